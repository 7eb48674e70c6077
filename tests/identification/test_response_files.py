"""Frequency responses as text and MATLAB files, and coherence as their weight."""

import json

import numpy as np
import pytest
from scipy import io
from wide_support import FREQ, poles

from twin.cli import main
from twin.errors import RecordingError
from twin.formats.responses import holds_responses, read_responses
from twin.identification.from_responses import identify_responses
from twin.signals.responses import ResponseSet

LINES = np.arange(160, 2761) * 0.25


def accelerance(outputs=3, inputs=1):
    shapes = np.random.default_rng(0).standard_normal((max(outputs, inputs), len(FREQ)))
    s = 2j * np.pi * LINES
    H = np.zeros((len(LINES), outputs, inputs), complex)
    for k, pole in enumerate(poles()):
        w = np.outer(shapes[:outputs, k], shapes[:inputs, k]) / (2j * pole.imag)
        H += w * (s**2 / (s - pole))[:, None, None]
        H += w.conj() * (s**2 / (s - pole.conj()))[:, None, None]
    return H


def uneven(H, seed=0, averages=8):
    """Averaged responses whose noise is thirty times larger below 300 Hz, and their coherence."""
    rng = np.random.default_rng(seed)
    level = np.where(LINES < 300, 0.3, 0.01) * np.sqrt(np.mean(np.abs(H) ** 2))
    noise = rng.standard_normal((averages, *H.shape)) + 1j * rng.standard_normal(
        (averages, *H.shape)
    )
    each = H + level[None, :, None, None] * noise
    coherence = np.abs(each.mean(0)) ** 2 / np.mean(np.abs(each) ** 2, axis=0)
    return each.mean(0), coherence


def text(path, H, polar=False, coherence=None):
    header, columns = ["frequency [Hz]"], [LINES]
    for o in range(H.shape[1]):
        for i in range(H.shape[2]):
            h, name = H[:, o, i], f"acc_{o + 1}/force_{i + 1}"
            header += [f"{name} magnitude", f"{name} phase [deg]"] if polar else []
            header += [] if polar else [f"{name} real", f"{name} imag"]
            columns += [np.abs(h), np.degrees(np.angle(h))] if polar else [h.real, h.imag]
            if coherence is not None:
                header.append(f"{name} coherence")
                columns.append(coherence[:, o, i])
    rows = "\n".join(",".join(f"{x:.10g}" for x in row) for row in np.column_stack(columns))
    path.write_text(",".join(header) + "\n" + rows + "\n")
    return path


@pytest.mark.parametrize("polar", [False, True], ids=["cartesian", "polar"])
def test_text_holds_parts_of_every_response(tmp_path, polar):
    H = accelerance(3, 2)
    file = text(tmp_path / "frf.csv", H, polar, np.full(H.shape, 0.9))
    assert holds_responses(file)
    read = read_responses(file)
    np.testing.assert_allclose(read.H, H, rtol=1e-8, atol=1e-8 * np.abs(H).max())
    assert read.outputs == ("acc_1", "acc_2", "acc_3")
    assert read.inputs == ("force_1", "force_2")
    assert read.coherence.shape == H.shape


def test_a_roving_accelerometer_writes_a_file_for_every_point(tmp_path):
    H = accelerance(3, 1)
    files = []
    for o in range(3):
        values = {"H": H[:, o, :], "f": LINES, "outputs": np.array([f"p{o}"])}
        io.savemat(tmp_path / f"{o}.mat", values)
        files.append(tmp_path / f"{o}.mat")
    assert all(holds_responses(file) for file in files)
    together = read_responses(files)
    np.testing.assert_allclose(together.H, H)
    assert together.outputs == ("p0", "p1", "p2")


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0)], ids=["lines first", "lines last"])
def test_matlab_holds_a_matrix_of_responses(tmp_path, axes):
    H = accelerance(3, 2)
    coherence = np.full(H.shape[:2], 0.8)
    values = {"frf": H.transpose(axes), "f": LINES, "coh": coherence}
    io.savemat(tmp_path / "frf.mat", values)
    read = read_responses(tmp_path / "frf.mat")
    np.testing.assert_allclose(read.H, H)
    assert np.all(read.coherence == 0.8)


def test_the_coherence_is_the_weight():
    """Modes that noisy and quiet lines share a segment with are told better with it."""
    H = accelerance()
    inside = (LINES > 250) & (LINES < 400)
    error = {True: [], False: []}
    for seed in range(6):
        noisy, coherence = uneven(H, seed)
        for weighted in (True, False):
            known = coherence[inside] if weighted else None
            responses = ResponseSet(
                LINES[inside], noisy[inside], ("1", "2", "3"), ("1",), coherence=known
            )
            found = identify_responses(responses).modal
            at = int(np.argmin(np.abs(found.natural_freq - 350)))
            error[weighted].append(found.natural_freq[at] - 350)
    rms = {k: np.sqrt(np.mean(np.square(e))) for k, e in error.items()}
    assert rms[True] < 0.5 * rms[False]


def test_noise_follows_coherence():
    noisy, coherence = uneven(accelerance(1), averages=64)
    responses = ResponseSet(LINES, noisy, ("1",), ("1",), coherence=coherence)
    ratio = np.median(responses.noise()[LINES < 290]) / np.median(responses.noise()[LINES > 310])
    assert ratio == pytest.approx(30, rel=0.15)
    assert ResponseSet(LINES, noisy, ("1",), ("1",), coherence=np.ones(noisy.shape)).noise() is None


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda t: t.replace("acc_1/force_1 imag", "acc_1/force_1 torque"), "no part of a resp"),
        (lambda t: t.replace("acc_2/force_1", "acc_1/force_1"), "stands twice"),
        (lambda t: t.replace("acc_2/force_1 imag", "acc_2/force_2 imag"), "real only"),
        (lambda t: t.replace("\n40.25,", "\n39.25,"), "do not rise"),
    ],
)
def test_a_damaged_file_is_one_line(tmp_path, damage, said, capsys):
    file = text(tmp_path / "frf.csv", accelerance(2))
    file.write_text(damage(file.read_text()))
    with pytest.raises(RecordingError, match=said):
        read_responses(file)
    with pytest.raises(SystemExit) as stop:
        main(["identify", str(file), "--out", str(tmp_path / "o")])
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_the_command_reads_text(tmp_path, capsys):
    noisy, coherence = uneven(accelerance())
    file = text(tmp_path / "frf.csv", noisy, coherence=coherence)
    with pytest.raises(SystemExit) as stop:
        main(
            [
                "identify",
                str(file),
                "--out",
                str(tmp_path / "o"),
                "--band",
                "310",
                "690",
                "--json",
                "-",
            ]
        )
    assert stop.value.code == 0
    found = [m["frequency_hz"] for m in json.loads(capsys.readouterr().out)["modes"]]
    np.testing.assert_allclose(found, FREQ[FREQ > 310], rtol=1e-3)
