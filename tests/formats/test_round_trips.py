import builtins

import numpy as np
import pytest

from twin.errors import TwinError
from twin.formats import WRITTEN, read_recording, write_recording
from twin.recording import Recording

ALL_CHANNELS = (
    "force_ground",
    "force_floor1",
    "force_floor12",
    "acc_ground",
    "acc_floor2",
    "disp_floor1",
    "angle_pendulum",
    "torque_pendulum",
)


def recording(rate=32.0, start=0.0, samples=257):
    rng = np.random.default_rng(3)
    scale = 10.0 ** rng.integers(-12, 12, len(ALL_CHANNELS))
    columns = {
        name: x * rng.standard_normal(samples) for name, x in zip(ALL_CHANNELS, scale, strict=True)
    }
    return Recording.build(rate, columns, "virtual", start)


@pytest.mark.parametrize("suffix", WRITTEN)
@pytest.mark.parametrize("rate", [32.0, 1e7 / 2**14, 123.456789012345, 1 / 7])
def test_what_is_written_is_read_back_bit_for_bit(tmp_path, suffix, rate):
    original = recording(rate)
    back = read_recording(write_recording(original, tmp_path / f"r{suffix}"))
    assert back.names == original.names
    assert np.array_equal(back.data, original.data)
    assert back.sampling_hz == pytest.approx(rate, rel=1e-15)
    assert back.start_s == 0.0
    assert back.notes == ()


ODD = {
    "acc_floor1_y [m/s^2]": "acc",
    "acc_floor1.y [m/s^2]": "acc",
    "tip_force [N]": "force",
    "A3 [m/s^2]": "acc",
    "A 3 [m/s^2]": "acc",
    "reference position [m]": "disp",
    "wheel_speed [rad/s]": "rate",
    "gauge, left [m/m]": "strain",
    "column3/top [V]": "voltage",
    "a = b [N m]": "torque",
    "units [1]": "number",
    "file [kg/s]": "other",
    "3 'quoted' [it] x [Pa]": "pressure",
}


@pytest.mark.parametrize("suffix", WRITTEN)
def test_any_name_and_unit_is_read_back(tmp_path, suffix):
    samples = np.random.default_rng(1).standard_normal((20, len(ODD)))
    original = Recording.build(50.0, dict(zip(ODD, samples.T, strict=True)), "virtual")
    back = read_recording(write_recording(original, tmp_path / f"r{suffix}"))
    assert [c.title for c in back.channels] == list(ODD)
    assert [c.kind for c in back.channels] == list(ODD.values())
    assert np.array_equal(back.data, original.data)
    assert back.inputs == ("tip_force", "a = b")


@pytest.mark.parametrize("suffix", sorted(set(WRITTEN) - {".uff", ".unv"}))
def test_names_beyond_ascii_are_read_back(tmp_path, suffix):
    original = Recording.build(50.0, {"Stockwerk ü [m]": [1.0, 2.0], "λ [N]": [0.0, 1.0]})
    back = read_recording(write_recording(original, tmp_path / f"r{suffix}"))
    assert back.names == original.names


@pytest.mark.parametrize("suffix", WRITTEN)
@pytest.mark.parametrize("start", [-3.25, 1234.56789])
def test_the_start_is_kept(tmp_path, suffix, start):
    back = read_recording(write_recording(recording(400.0, start), tmp_path / f"r{suffix}"))
    assert back.start_s == start
    assert back.sampling_hz == 400.0


@pytest.mark.parametrize("suffix", WRITTEN)
def test_two_samples_of_one_channel_are_a_recording(tmp_path, suffix):
    short = Recording.build(5.0, {"acc_floor1": np.array([1.0, -1e-300])})
    back = read_recording(write_recording(short, tmp_path / f"r{suffix.upper()}"))
    assert np.array_equal(back.data, short.data)
    assert back.sampling_hz == 5.0


@pytest.mark.parametrize("suffix", [".tdms", ".npy", ".xlsx", ""])
def test_other_suffixes_cannot_be_written_and_nothing_is(tmp_path, suffix):
    with pytest.raises(TwinError, match=r"cannot be written; \.csv, \.uff"):
        write_recording(recording(), tmp_path / f"r{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_the_csv_has_the_contracts_header(tmp_path):
    path = write_recording(recording().select(["force_floor1", "acc_floor2"]), tmp_path / "r.csv")
    header = "time [s],force_floor1 [N],acc_floor2 [m/s^2]\n0.0,"
    assert path.read_text().startswith(header)


def test_the_hdf5_file_carries_its_units(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(write_recording(recording(), tmp_path / "r.h5")) as file:
        assert file["acc_floor2"].attrs["unit"] == "m/s^2"
        assert file["torque_pendulum"].attrs["unit"] == "N m"


def test_matlab_sees_column_vectors_and_their_units(tmp_path):
    from scipy.io import loadmat

    content = loadmat(write_recording(recording(), tmp_path / "r.mat"))
    assert content["acc_floor2"].shape == (257, 1)
    assert content["units"][0].strip() == "time [s]"


def test_the_universal_file_says_what_each_function_is(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = write_recording(recording(), tmp_path / "r.uff")
    first = pyuff.UFF(str(path)).read_sets(ALL_CHANNELS.index("acc_floor2"))
    assert (first["func_type"], first["binary"], first["rsp_node"], first["rsp_dir"]) == (
        1,
        1,
        2,
        1,
    )
    assert first["abscissa_spec_data_type"] == 17
    assert first["ordinate_spec_data_type"] == 12
    assert first["ordinate_axis_units_lab"] == "m/s^2"
    assert first["abscissa_inc"] == 1 / 32


@pytest.mark.parametrize(
    ("suffix", "module"), [(".h5", "h5py"), (".tdms", "nptdms"), (".uff", "pyuff")]
)
def test_a_missing_library_is_one_line_that_says_how_to_install_it(
    tmp_path, monkeypatch, suffix, module
):
    path = tmp_path / f"r{suffix}"
    path.write_text("x")

    def refuse(name, *args, **kwargs):
        if name.split(".")[0] == module:
            raise ImportError(name)
        return real(name, *args, **kwargs)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", refuse)
    monkeypatch.setattr("twin.formats.table.import_module", refuse)
    message = rf"{suffix} files need {module}; pip install 'frame-twin\[formats\]'$"
    with pytest.raises(TwinError, match=message):
        read_recording(path)
    if suffix != ".tdms":
        with pytest.raises(TwinError, match=message):
            write_recording(recording(), path)
    assert path.read_text() == "x"
