import hashlib
import io
import json
import threading
import zipfile
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from scipy import io as matlab

from twin import fetching
from twin.errors import RecordingError
from twin.fetching import download, fetch, sets
from twin.formats import read_recording

SHARED = Path(__file__).parents[2] / "shared" / "data"
needs_shared = pytest.mark.skipif(
    not (SHARED / "silverbox").is_dir(), reason="no folder of recordings beside this checkout"
)


def zipped(members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return stream.getvalue()


def bouc_wen_archive():
    rng = np.random.default_rng(0)
    members = {}
    for kind in ("multisine", "sinesweep"):
        for letter in "uy":
            stream = io.BytesIO()
            name = f"{letter}val_{kind}"
            matlab.savemat(stream, {name: rng.standard_normal((1, 400))})
            members[f"BoucWenFiles/Test signals/Validation signals/{name}.mat"] = stream.getvalue()
            members[f"__MACOSX/{name}.mat"] = b"not that one"
    return zipped(members)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(download.CACHE_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def server(tmp_path):
    """Serve a folder on this machine: (folder, address)."""
    folder = tmp_path / "served"
    folder.mkdir()

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *arguments):
            pass

    http = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    thread = threading.Thread(target=http.serve_forever, daemon=True)
    thread.start()
    yield folder, f"http://127.0.0.1:{http.server_port}"
    http.shutdown()
    http.server_close()
    thread.join()


def test_a_download_is_remembered_by_its_checksum_and_not_repeated(server, cache, tmp_path):
    folder, address = server
    archive = bouc_wen_archive()
    (folder / "BoucWenFiles.zip").write_bytes(archive)
    found = fetch("bouc_wen", tmp_path / "out", address)
    assert [p.name for p in found.files] == ["bouc_wen_test_multisine.csv",
                                             "bouc_wen_test_sweep.csv"]  # fmt: skip
    sha = hashlib.sha256(archive).hexdigest()
    assert sha in found.notes[0]
    assert json.loads((cache / download.LEARNT).read_text()) == {"bouc_wen-BoucWenFiles.zip": sha}
    recording = read_recording(found.files[0])
    assert (recording.sampling_hz, recording.samples) == (750.0, 400)
    assert recording.names == ("force_floor1", "disp_floor1")
    (folder / "BoucWenFiles.zip").unlink()
    again = fetch("bouc_wen", tmp_path / "again", address)
    assert again.notes == ("the checksum is that of the first download; none is published",)


def test_a_later_download_that_differs_from_the_first_is_refused(server, cache, tmp_path):
    folder, address = server
    (folder / "BoucWenFiles.zip").write_bytes(bouc_wen_archive())
    fetch("bouc_wen", tmp_path / "out", address)
    (cache / "bouc_wen-BoucWenFiles.zip").unlink()
    (folder / "BoucWenFiles.zip").write_bytes(zipped({"something.txt": "else"}))
    with pytest.raises(RecordingError, match="has a wrong SHA-256 and was thrown away"):
        fetch("bouc_wen", tmp_path / "other", address)
    assert not (tmp_path / "other").exists()
    assert [p.name for p in cache.iterdir()] == [download.LEARNT]


def test_a_published_checksum_is_insisted_on(server, cache, tmp_path):
    folder, address = server
    (folder / "SilverboxFiles.zip").write_bytes(zipped({"SNLS80mV.csv": "V1,V2\n0,0\n"}))
    with pytest.raises(RecordingError, match=r"silverbox: what http.* has a wrong SHA-256"):
        fetch("silverbox", tmp_path / "out", address)
    assert not (tmp_path / "out").exists()
    assert list(cache.iterdir()) == []


def test_a_server_without_the_archive_gives_one_line(server, cache, tmp_path):
    _, address = server
    with pytest.raises(RecordingError, match=r"cannot download http.*HTTPError.*--from FOLDER"):
        fetch("f16", tmp_path / "out", address)


def test_no_network_gives_one_line(cache, tmp_path):
    with pytest.raises(RecordingError, match=r"cannot download http://127\.0\.0\.1:1/.*Connection"):
        fetch("bouc_wen", tmp_path / "out", "http://127.0.0.1:1")


def test_an_archive_within_an_archive_and_a_file_address_are_read(tmp_path):
    (tmp_path / "BoucWenFiles.zip").write_bytes(zipped({"a/BoucWenFiles.zip": bouc_wen_archive()}))
    found = fetch("bouc_wen", tmp_path / "out", tmp_path.as_uri())
    assert len(found.files) == 2


def test_a_folder_without_any_of_the_files_says_which_are_wanted(tmp_path):
    with pytest.raises(RecordingError, match=r"neither BoucWenFiles\.zip nor any of uval_multi"):
        fetch("bouc_wen", tmp_path / "out", str(tmp_path))
    with pytest.raises(RecordingError, match="does not exist"):
        fetch("bouc_wen", tmp_path / "out", str(tmp_path / "nowhere"))


def test_damaged_archives_and_files_are_refused_and_nothing_is_written(tmp_path):
    (tmp_path / "BoucWenFiles.zip").write_bytes(b"PK no")
    with pytest.raises(RecordingError, match="not a ZIP archive that can be read"):
        fetch("bouc_wen", tmp_path / "out", str(tmp_path))
    (tmp_path / "BoucWenFiles.zip").write_bytes(zipped({"uval_multisine.mat": b"junk"}))
    with pytest.raises(RecordingError, match=r"uval_multisine\.mat: not a MAT file"):
        fetch("bouc_wen", tmp_path / "out", str(tmp_path))
    assert not (tmp_path / "out").exists()


def test_a_write_that_fails_leaves_nothing_behind(tmp_path):
    (tmp_path / "BoucWenFiles.zip").write_bytes(bouc_wen_archive())
    (tmp_path / "out" / "bouc_wen_test_sweep.csv").mkdir(parents=True)
    with pytest.raises(Exception, match="this is a folder"):
        fetch("bouc_wen", tmp_path / "out", str(tmp_path))
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["bouc_wen_test_sweep.csv"]


def test_the_frame_with_a_bumper_becomes_a_recording_a_test(tmp_path):
    states = np.repeat([1, 14], 3)
    data = np.random.default_rng(1).standard_normal((256, 5, 6))
    matlab.savemat(tmp_path / "data3SS.mat", {"dataset": data, "states": states[None]})
    found = fetch("lanl_bumper", tmp_path / "out", str(tmp_path))
    assert [p.stem for p in found.files] == [f"lanl_state{s:02d}_{n}" for s in (1, 14)
                                             for n in (1, 2, 3)]  # fmt: skip
    recording = read_recording(found.files[4])
    assert recording.sampling_hz == pytest.approx(320)
    np.testing.assert_allclose(recording.column("force_ground"), data[:, 0, 4])
    np.testing.assert_allclose(recording.column("acc_floor3"), 9.80665 * data[:, 4, 4])
    assert any("320 Hz" in note for note in found.notes)
    matlab.savemat(tmp_path / "data3SS.mat", {"dataset": data, "states": states[None, :2]})
    with pytest.raises(RecordingError, match=r"shape \(256, 5, 6\) for 2 states"):
        fetch("lanl_bumper", tmp_path / "more", str(tmp_path))


def test_a_set_without_an_address_says_where_to_go(tmp_path):
    with pytest.raises(RecordingError, match=r"no address for programs; download data3SS\.mat"):
        fetch("lanl_bumper", tmp_path)


def test_every_set_can_be_converted_and_has_what_a_reader_needs():
    assert set(fetching._CONVERTERS) == {one.name for one in sets.SETS}
    for one in sets.SETS:
        sums = [one.sha256, *one.members.values()]
        assert all(s is None or (len(s) == 64 and int(s, 16)) for s in sums)
        assert one.page.startswith("https://")
        assert one.cite
        assert "{out}" in one.diagnosis


@needs_shared
def test_a_local_copy_of_the_silverbox_is_the_benchmark(tmp_path):
    found = fetch("silverbox", tmp_path, str(SHARED / "silverbox"))
    names = [p.stem for p in found.files]
    assert names == ["silverbox_arrow",
                     *(f"silverbox_multisine_{i:02d}" for i in range(1, 11)),
                     "silverbox_schroeder"]  # fmt: skip
    first = read_recording(found.files[1])
    assert first.sampling_hz == pytest.approx(1e7 / 2**14)
    assert 8000 < first.samples < 9000


@needs_shared
def test_a_local_copy_of_one_level_of_the_f16_is_the_benchmark(tmp_path):
    found = fetch("f16", tmp_path, str(SHARED / "f16_gvt"))
    (path,) = found.files
    recording = read_recording(path)
    assert (path.name, recording.sampling_hz, recording.samples) == ("f16_level1.csv", 400, 73728)
    assert recording.names == ("force_floor1", "acc_floor1", "acc_floor2", "acc_floor3")
    assert "Level3" in found.notes[0]


@needs_shared
def test_a_changed_copy_is_refused(tmp_path, monkeypatch):
    silverbox = sets.benchmark_set("silverbox")
    other = replace(silverbox, members=dict.fromkeys(silverbox.members, "0" * 64))
    monkeypatch.setattr(fetching, "benchmark_set", lambda name: other)
    with pytest.raises(RecordingError, match="its SHA-256 is not that of the benchmark's file"):
        fetch("silverbox", tmp_path / "out", str(SHARED / "silverbox"))
    assert not (tmp_path / "out").exists()
