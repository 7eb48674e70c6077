import pytest

from twin.errors import TwinError
from twin.files import write_whole


def test_an_older_file_survives_a_writer_that_fails(tmp_path):
    target = tmp_path / "out.csv"
    target.write_text("old")

    def fail(part):
        part.write_text("half")
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        write_whole(target, fail)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_full_disk_is_one_line_that_names_the_file(tmp_path):
    def fail(part):
        raise OSError(28, "No space left on device")

    with pytest.raises(TwinError, match=r"out\.csv: cannot write \(No space left on device\)"):
        write_whole(tmp_path / "out.csv", fail)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_the_file_is_one_line(tmp_path):
    (tmp_path / "out.csv").mkdir()
    with pytest.raises(TwinError, match=r"out\.csv: cannot write: this is a folder"):
        write_whole(tmp_path / "out.csv", lambda part: part.write_text("x"))


def test_a_file_in_the_place_of_the_folder_is_one_line(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(TwinError, match="cannot make this folder"):
        write_whole(tmp_path / "file" / "out.csv", lambda part: part.write_text("x"))


def test_missing_folders_are_made(tmp_path):
    path = write_whole(tmp_path / "a" / "b" / "out.txt", lambda part: part.write_text("x"))
    assert path.read_text() == "x"
