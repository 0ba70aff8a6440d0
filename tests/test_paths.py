"""Files are written whole or not at all."""

import io
import os

import pytest
from forks import forked
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from bearing_twin.errors import BearingTwinError
from bearing_twin.paths import file_name, write_whole, written_whole
from bearing_twin.pictures.moving import write_moving
from bearing_twin.view.film import WRITERS


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


def moving(path):
    figure = Figure(figsize=(2, 2))
    FigureCanvasAgg(figure)
    write_moving(figure, path, range(2), lambda row: figure.text(0.1, 0.3 * row, "text"))


def film(path):
    images = []
    for _ in range(3):
        held = io.BytesIO()
        Image.frombytes("RGB", (64, 64), os.urandom(3 * 64 * 64)).save(held, "png")
        images.append(held.getvalue())
    with written_whole(path) as draft:
        WRITERS[path.suffix](images, draft)


@pytest.mark.parametrize(("write", "name"), [(moving, "moving.gif"), (film, "film.gif"), (film, "film.mp4")])
def test_films_that_find_no_room_leave_what_was_there(tmp_path, write, name):
    if name.endswith("mp4"):
        pytest.importorskip("imageio_ffmpeg", reason="films as MP4 need imageio-ffmpeg")
    path = tmp_path / name
    path.write_bytes(b"old")
    done = forked(lambda: write(path), largest_file=1000)
    assert f"{path} cannot be written (" in done.stderr.splitlines()[-1]
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == [name]
    write(path)
    assert path.read_bytes()[:4] in (b"GIF8", b"\0\0\0 ")
    assert os.listdir(tmp_path) == [name]


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
