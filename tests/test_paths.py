"""Files are written whole or not at all."""

import os
import subprocess
import sys

import pytest

from bearing_twin.errors import BearingTwinError
from bearing_twin.paths import write_whole

SCRIPT = """
import resource, sys
from bearing_twin.paths import write_whole
resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10))
write_whole(sys.argv[1], b"new" * 100)
"""


def test_a_file_that_cannot_be_written_whole_leaves_what_was_there(tmp_path):
    path = tmp_path / "picture.png"
    write_whole(path, b"old")
    done = subprocess.run([sys.executable, "-c", SCRIPT, path], capture_output=True, text=True)
    assert done.returncode == 1
    assert "cannot be written (File too large); give another path" in done.stderr
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["picture.png"]


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


@pytest.mark.parametrize("place", ["nowhere/picture.png", "."])
def test_a_place_that_is_none_is_refused(tmp_path, place):
    with pytest.raises(BearingTwinError, match="cannot be written"):
        write_whole(tmp_path / place, b"bytes")
    assert os.listdir(tmp_path) == []
