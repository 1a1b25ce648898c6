import os

import pytest

from scara_drake.common.files import whole_file, write_whole


def test_a_text_is_written_as_it_is(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("before")
    write_whole(path, "θ2\r\nθ3\n")
    assert path.read_bytes() == "θ2\r\nθ3\n".encode()
    assert list(tmp_path.iterdir()) == [path]


def test_until_the_end_the_file_is_what_it_was(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("before")
    with whole_file(path) as partial:
        partial.write_text("after")
        assert partial.parent == tmp_path
        assert path.read_text() == "before"
    assert path.read_text() == "after"


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_a_failure_leaves_nothing_behind(tmp_path, error):
    path = tmp_path / "a.nc"

    def write():
        with whole_file(path) as partial:
            partial.write_text("half")
            raise error

    with pytest.raises(error):
        write()
    assert list(tmp_path.iterdir()) == []


def test_a_failed_rename_leaves_the_file_before_it(tmp_path, monkeypatch):
    def fail(*arguments):
        raise OSError("disk full")

    path = tmp_path / "a.yaml"
    path.write_text("before")
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_whole(path, "after")
    monkeypatch.undo()
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.yaml", "before")]


def test_a_missing_folder_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        write_whole(tmp_path / "none" / "a.txt", "")
