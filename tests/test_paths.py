"""Files are written whole or not at all."""

import os

import pytest
from forks import forked

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.paths import file_name, write_whole


def test_a_file_that_cannot_be_written_whole_leaves_what_was_there(tmp_path):
    path = tmp_path / "picture.png"
    write_whole(path, b"old")
    done = forked(lambda: write_whole(path, b"new" * 100) and None, largest_file=10)
    assert done.returncode == 1
    assert "cannot be written (File too large); give another path" in done.stderr
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["picture.png"]


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("../../a study/of: mine", "_.._a_study_of_mine"),
        ("..", "_"),
        ("", "_"),
        ("a/\x1b[2J", "a_2J"),
        ("Lager 6203-2", "Lager_6203-2"),
        ("größe", "größe"),
        ("x" * 300, "x" * 60),
    ],
)
def test_a_name_from_elsewhere_becomes_a_file_in_its_folder(name, file, tmp_path):
    assert file_name(name) == file
    (tmp_path / f"{file_name(name)}.csv").touch()
    assert [one.parent for one in tmp_path.rglob("*")] == [tmp_path]


def test_links_stay_links_and_pipes_take_the_bytes(tmp_path):
    (tmp_path / "far").mkdir()
    link, pipe = tmp_path / "link.png", tmp_path / "pipe"
    link.symlink_to(tmp_path / "far" / "picture.png")
    assert write_whole(link, b"bytes") == link
    assert link.is_symlink()
    assert (tmp_path / "far" / "picture.png").read_bytes() == b"bytes"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"bytes")
    assert os.read(reader, 10) == b"bytes"
    os.close(reader)
    assert pipe.is_fifo()


def test_who_may_read_a_file_stays(tmp_path):
    path = tmp_path / "picture.png"
    write_whole(path, b"old")
    path.chmod(0o640)
    write_whole(path, b"new")
    assert (path.stat().st_mode & 0o777, path.read_bytes()) == (0o640, b"new")


@pytest.mark.parametrize("place", ["nowhere/picture.png", "."])
def test_a_place_that_is_none_is_refused(tmp_path, place):
    with pytest.raises(BearingTwinError, match="cannot be written"):
        write_whole(tmp_path / place, b"bytes")
    assert os.listdir(tmp_path) == []
