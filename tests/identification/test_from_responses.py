"""Frequency responses of another program, as universal files."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from wide_support import FREQ, ZETA, poles

from twin.cli import main
from twin.errors import RecordingError
from twin.formats.responses import holds_responses, read_responses
from twin.identification.from_responses import identify_responses
from twin.modal import mac

pyuff = pytest.importorskip("pyuff")
SCHEMA = Path(__file__).parents[3] / "shared" / "contracts" / "identification.schema.json"
LINES = np.arange(1, 2801) * 0.25


def accelerance(outputs=5, inputs=2, noise=0.005):
    rng = np.random.default_rng(0)
    shapes = rng.standard_normal((max(outputs, inputs), len(FREQ)))
    s = 2j * np.pi * LINES
    H = np.zeros((len(LINES), outputs, inputs), complex)
    for k, pole in enumerate(poles()):
        w = np.outer(shapes[:outputs, k], shapes[:inputs, k]) / (2j * pole.imag)
        H += w * (s**2 / (s - pole))[:, None, None]
        H += w.conj() * (s**2 / (s - pole.conj()))[:, None, None]
    level = noise * np.sqrt(np.mean(np.abs(H) ** 2) / 2)
    return H + level * (rng.standard_normal(H.shape) + 1j * rng.standard_normal(H.shape))


def write(path, H, left_out=(), binary=0):
    sets = []
    for o in range(H.shape[1]):
        for i in range(H.shape[2]):
            if (o, i) in left_out:
                continue
            sets.append(
                pyuff.prepare_58(
                    binary=binary, func_type=4, rsp_node=o + 1, rsp_dir=3, ref_node=i + 1,
                    ref_dir=3, data=H[:, o, i], x=LINES, id1=f"frf {o} {i}", rsp_ent_name="",
                    ref_ent_name="", abscissa_spacing=1, abscissa_spec_data_type=18,
                    ordinate_spec_data_type=12, orddenom_spec_data_type=13,
                )
            )  # fmt: skip
    pyuff.UFF(str(path)).write_sets(sets, "add")
    return path


def test_the_modes_come_back_from_a_universal_file(tmp_path):
    responses = read_responses(write(tmp_path / "frf.uff", accelerance()))
    assert responses.H.shape == (len(LINES), 5, 2)
    assert responses.outputs[0] == "1.z"
    found = identify_responses(responses, (40, 690))
    np.testing.assert_allclose(found.modal.natural_freq, FREQ, rtol=1e-4)
    np.testing.assert_allclose(found.modal.damping_ratio, ZETA, rtol=0.03)
    error = np.abs(found.modal.natural_freq - FREQ)
    assert np.all(error < 4 * found.modal.natural_freq_std)
    assert found.error < 0.01


def test_a_roving_hammer_gives_the_modes_of_a_roving_accelerometer(tmp_path):
    H = accelerance(4, 1)
    fixed = read_responses(write(tmp_path / "a.uff", H))
    roving = read_responses(write(tmp_path / "b.uff", H.transpose(0, 2, 1)))
    np.testing.assert_array_equal(fixed.H, roving.H)
    assert "reciprocity" in roving.notes[0]


# pyuff 2.5.8 leaves a binary file that it writes to the garbage collector; its mode "overwrite"
# gives one that it cannot read itself.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("binary", [0, 1], ids=["text", "binary"])
def test_a_roving_hammer_of_another_program_gives_all_modes_and_their_shapes(tmp_path, binary):
    H = accelerance(1, 6)
    found = identify_responses(
        read_responses(write(tmp_path / "frf.uff", H, (), binary)), (40, 690)
    )
    np.testing.assert_allclose(found.modal.natural_freq, FREQ, rtol=1e-4)
    np.testing.assert_allclose(found.modal.damping_ratio, ZETA, rtol=0.03)
    shapes = np.random.default_rng(0).standard_normal((6, len(FREQ)))
    assert np.all(np.diag(mac(found.modal.mode_shape, shapes)) > 0.999)


def test_a_missing_pair_is_named(tmp_path):
    path = write(tmp_path / "frf.uff", accelerance(3, 2), left_out=[(2, 1)])
    with pytest.raises(RecordingError, match=r"no response between 3\.z and 2\.z"):
        read_responses(path)


def test_the_command_line_reads_them(tmp_path, capsys):
    path = write(tmp_path / "frf.uff", accelerance(3, 1))
    assert holds_responses(path)
    with pytest.raises(SystemExit) as stop:
        main(
            [
                "identify",
                str(path),
                "--out",
                str(tmp_path / "o"),
                "--band",
                "40",
                "690",
                "--json",
                "-",
            ]
        )
    assert stop.value.code == 0
    found = json.loads(capsys.readouterr().out)
    if SCHEMA.exists():
        jsonschema.validate(found, json.loads(SCHEMA.read_text()))
    assert len(found["modes"]) == len(FREQ)
