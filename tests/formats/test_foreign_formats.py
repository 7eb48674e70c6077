from warnings import catch_warnings, simplefilter

import numpy as np
import pytest
from scipy.io import savemat

from twin.errors import RecordingError
from twin.formats import read_recording

FORCE = np.array([0.0, 1.0, 2.0, 3.0])
ACC = np.array([4.0, 5.0, 6.0, 7.5])
MAP = {"F": "force_floor1 [N]", "a": "acc_floor1 [g]"}


class Harm:
    """An object whose unpickling would be noticed."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was loaded",))


def refusal(path, *arguments):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, *arguments)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.isprintable()
    return message


def assert_read(path, *arguments):
    recording = read_recording(path, *arguments)
    assert recording.sampling_hz == 8.0
    assert np.array_equal(recording.column("force_floor1"), FORCE)
    assert np.array_equal(recording.column("acc_floor1"), ACC * 9.80665)
    return recording


# MATLAB


def test_matlab_variables_are_read_by_name_as_rows_or_columns(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE[:, None], "a": ACC[None, :], "note": "text", "s": {"x": 1}})
    recording = assert_read(path, MAP, 8)
    assert recording.notes == ("left out, as the channel map does not name them: 'note', 's'",)


def test_columns_of_a_matlab_matrix_are_named_as_matlab_does(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"y": np.column_stack([FORCE, ACC])})
    assert_read(path, {"y(:,1)": "force_floor1 [N]", "y(:,2)": "acc_floor1 [g]"}, 8)
    savemat(path, {"y": np.vstack([FORCE, ACC])})
    assert_read(path, {"y(1,:)": "force_floor1 [N]", "y(2,:)": "acc_floor1 [g]"}, 8)
    assert "the file has 'y(1,:)', 'y(2,:)'" in refusal(path, MAP, 8)


def test_a_mat_file_of_integers_and_single_precision_is_read(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE.astype(np.int16), "a": ACC.astype(np.float32)})
    assert_read(path, MAP, 8)


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (np.array(["F", 2.0], dtype=object), "cell"),
        ({"x": 1.0}, "struct"),
        ("text", "char"),
    ],
)
def test_objects_in_a_mat_file_are_refused(tmp_path, value, kind):
    path = tmp_path / "r.mat"
    savemat(path, {"F": value, "a": ACC})
    assert f"column 'F' is a MATLAB {kind}, not an array of numbers" in refusal(path, MAP, 8)


def test_complex_samples_are_refused(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE + 1j, "a": ACC})
    assert "column 'F' does not hold real numbers" in refusal(path, MAP, 8)


def test_matlab_7_3_is_told_to_be_hdf5(tmp_path):
    path = tmp_path / "r.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + bytes(500))
    assert "a MATLAB 7.3 file is HDF5; rename it to r.h5, or save it with -v7" in refusal(path)


def test_a_mat_file_without_units_or_rate_says_so(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"force_floor1": FORCE, "acc_floor1": ACC})
    assert "'force_floor1' has no unit" in refusal(path, None, 8)
    assert "no column 'time [s]'" in refusal(path, {"force_floor1": "force_floor1 [N]"})


def test_variables_of_different_lengths_are_refused(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE, "a": ACC[:3]})
    assert "column 'a' has 3 samples and column 'F' has 4" in refusal(path, MAP, 8)


@pytest.mark.parametrize("rate", [0.0, np.nan, "fast", [1.0, 2.0]])
def test_a_declared_rate_that_is_no_rate_is_refused(tmp_path, rate):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE, "a": ACC, "sampling_hz": rate})
    refusal(path, MAP)


def test_a_declared_rate_is_used(tmp_path):
    path = tmp_path / "r.mat"
    savemat(path, {"F": FORCE, "a": ACC, "sampling_hz": 8})
    assert_read(path, MAP)


# NumPy


def test_numpy_files_are_read_through_a_map(tmp_path):
    np.savez(tmp_path / "r.npz", F=FORCE, a=ACC)
    assert_read(tmp_path / "r.npz", MAP, 8)
    np.save(tmp_path / "r.npy", np.column_stack([FORCE, ACC]))
    columns = {"data(:,1)": "force_floor1 [N]", "data(:,2)": "acc_floor1 [g]"}
    assert_read(tmp_path / "r.npy", columns, 8)
    fields = np.array(list(zip(FORCE, ACC, strict=True)), dtype=[("F", float), ("a", float)])
    np.save(tmp_path / "s.npy", fields)
    assert_read(tmp_path / "s.npy", MAP, 8)


def test_pickled_objects_are_refused_without_being_loaded(tmp_path):
    objects = np.array([Harm()], dtype=object)
    np.save(tmp_path / "r.npy", objects, allow_pickle=True)
    assert "pickled Python objects are refused" in refusal(tmp_path / "r.npy")
    np.savez(tmp_path / "r.npz", F=objects, a=ACC)
    assert "pickled Python objects are refused" in refusal(tmp_path / "r.npz", MAP, 8)


def test_a_bare_pickle_is_refused_without_being_loaded(tmp_path):
    import pickle

    for name in ("r.npy", "r.npz", "r.mat", "r.h5", "r.tdms", "r.uff", "r.csv"):
        (tmp_path / name).write_bytes(pickle.dumps(Harm()))
        refusal(tmp_path / name)


# HDF5


def test_hdf5_datasets_in_groups_are_read_by_their_path(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "r.hdf5"
    with h5py.File(path, "w") as file:
        file["run 1/F"] = FORCE
        file["run 1/F"].attrs["units"] = "N"
        file["run 1/a"] = ACC[None, :]
        file["run 1/a"].attrs["unit"] = np.bytes_("g")
        file["text"] = "words"
        file["lost"] = h5py.SoftLink("/nowhere")
        file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/x")
        file.attrs["sampling_hz"] = 8.0
    recording = assert_read(path, {"run 1/F": "force_floor1", "run 1/a": "acc_floor1"})
    assert recording.notes == ("left out, as the channel map does not name them: 'text'",)
    assert "'text' does not hold real numbers" in refusal(path, {"text": "force_floor1 [N]"})
    assert "the file has 'run 1/F [N]', 'run 1/a [g]', 'text'" in refusal(path, MAP)


def test_a_hdf5_file_without_datasets_is_refused(tmp_path):
    h5py = pytest.importorskip("h5py")
    h5py.File(tmp_path / "r.h5", "w").close()
    assert "holds no arrays" in refusal(tmp_path / "r.h5")


# TDMS


def write_tdms(path, rates=(8.0, 8.0), groups=("g", "g"), names=("F", "a"), starts=(0.0, 0.0)):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        for rate, group, name, start, x, unit in zip(
            rates, groups, names, starts, (FORCE, ACC), ("N", "g"), strict=True
        ):
            properties = {"unit_string": unit}
            if rate:
                properties |= {"wf_increment": 1 / rate, "wf_start_offset": start}
            writer.write_segment([nptdms.ChannelObject(group, name, x, properties)])


def test_tdms_channels_bring_rate_start_and_unit(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, starts=(2.5, 2.5))
    recording = assert_read(path, {"F": "force_floor1", "a": "acc_floor1"})
    assert recording.start_s == 2.5


def test_tdms_channels_of_one_name_are_told_apart_by_their_group(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, groups=("hammer", "frame"), names=("c", "c"))
    assert_read(path, {"hammer/c": "force_floor1", "frame/c": "acc_floor1"})


def test_tdms_channels_with_our_names_need_no_map(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, names=("force_floor1", "acc_floor1"))
    assert_read(path)


def test_tdms_channels_of_different_rates_or_starts_are_refused(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, rates=(8.0, 16.0))
    assert "not sampled together: 8 Hz from 0 s and 16 Hz" in refusal(path, MAP)
    write_tdms(path, starts=(0.0, 0.01))
    assert "8 Hz from 0 s and 8 Hz from 0.01 s" in refusal(path, MAP)
    write_tdms(path, rates=(8.0, None))
    assert "8 Hz from 0 s and no rate" in refusal(path, MAP)


def test_a_tdms_file_without_waveform_needs_a_rate(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, rates=(None, None))
    assert_read(path, MAP, 8)
    assert "give the sampling rate" in refusal(path, MAP)


# UFF


def function(data, name="NONE", unit="NONE", kind=1, node=1, direction=1, step=0.125, **more):
    return {
        **dict.fromkeys(("ref_node", "ref_dir", "z_axis_value"), 0),
        **dict.fromkeys(("orddenom_spec_data_type", "z_axis_spec_data_type"), 0),
        **{"type": 58, "binary": 0, "id1": name, "func_type": kind},
        **{"rsp_node": node, "rsp_dir": direction, "abscissa_spacing": 1},
        **{"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 12},
        **{"ordinate_axis_units_lab": unit, "x": step * np.arange(len(data)), "data": data},
        **more,
    }


def write_uff(path, *functions):
    pyuff = pytest.importorskip("pyuff")
    path.write_bytes(b"")
    with catch_warnings():
        simplefilter("ignore", ResourceWarning)
        pyuff.UFF(str(path)).write_sets(list(functions), mode="add")


@pytest.mark.parametrize("binary", [0, 1])
def test_uff_functions_are_named_by_their_id_line(tmp_path, binary):
    path = tmp_path / "r.unv"
    write_uff(
        path,
        function(FORCE, "F", "N", binary=binary),
        function(ACC, "a", "g", binary=binary),
        function(np.ones(4) + 1j, "H", kind=4, binary=binary),
    )
    assert_read(path, {"F": "force_floor1", "a": "acc_floor1"})
    assert "the file has 'F [N]', 'a [g]'" in refusal(path, {"H": "acc_floor1 [g]"})


def test_uff_functions_without_a_name_are_named_by_node_and_direction(tmp_path):
    path = tmp_path / "r.uff"
    write_uff(path, function(FORCE, node=12, direction=-3), function(ACC, node=2, direction=1))
    assert_read(path, {"12-Z": "force_floor1 [N]", "2X": "acc_floor1 [g]"})


def test_an_uneven_abscissa_is_checked_for_uniformity(tmp_path):
    path = tmp_path / "r.uff"
    columns = {"F": "force_floor1 [N]", "a": "acc_floor1 [g]"}
    uneven = {"abscissa_spacing": 0, "binary": 1}
    write_uff(path, function(FORCE, "F", **uneven), function(ACC, "a", **uneven))
    assert_read(path, columns)
    write_uff(path, function(FORCE, "F", **uneven, x=np.array([0, 1, 2, 3.5])), function(ACC, "a"))
    assert "'F' is not uniform: sample 3: time is not uniform" in refusal(path, columns)


def test_the_rate_of_a_universal_file_is_not_blurred_by_its_six_digits(tmp_path):
    path = tmp_path / "r.uff"
    write_uff(path, function(FORCE, "F", step=1 / 3))
    assert read_recording(path, {"F": "force_floor1 [N]"}).sampling_hz == 3.0


def test_a_universal_file_without_time_histories_is_refused(tmp_path):
    path = tmp_path / "r.uff"
    write_uff(path, function(np.ones(4) + 1j, kind=4))
    assert "no time histories" in refusal(path)
    path.write_text("nothing of the kind\n")
    assert "no time histories" in refusal(path)


def test_a_universal_file_that_is_cut_short_is_refused(tmp_path):
    path = tmp_path / "r.uff"
    write_uff(path, function(np.arange(100.0), "F"))
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:20] + lines[-1:]))
    assert "of 100 samples; the file is cut short or damaged" in refusal(path)
