"""Files are written whole or not at all, and read within limits; streams that close, fill up or are read no more."""

import contextlib
import os
import subprocess
import sys
import time

import pytest
from processes import forked
from torture_rows import in_a_process

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.paths import write_atomic
from bearing_twin.log.run_log import read_log
from bearing_twin.run.scene import parse_scene


def test_a_file_that_cannot_be_written_whole_leaves_what_was_there(tmp_path):
    path = tmp_path / "picture.png"
    write_atomic(path, b"old")
    done = forked(lambda: write_atomic(path, b"new" * 100) and None, largest_file=10)
    assert done.returncode == 1
    assert "cannot be written (File too large); give another path" in done.stderr
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["picture.png"]


def test_links_stay_links_and_pipes_take_the_bytes(tmp_path):
    (tmp_path / "far").mkdir()
    link, pipe = tmp_path / "link.png", tmp_path / "pipe"
    link.symlink_to(tmp_path / "far" / "picture.png")
    assert write_atomic(link, b"bytes") == link
    assert link.is_symlink()
    assert (tmp_path / "far" / "picture.png").read_bytes() == b"bytes"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_atomic(pipe, b"bytes")
    assert os.read(reader, 10) == b"bytes"
    os.close(reader)
    assert pipe.is_fifo()


def test_who_may_read_a_file_stays(tmp_path):
    path = tmp_path / "picture.png"
    write_atomic(path, b"old")
    path.chmod(0o640)
    write_atomic(path, b"new")
    assert (path.stat().st_mode & 0o777, path.read_bytes()) == (0o640, b"new")


@pytest.mark.parametrize("place", ["nowhere/picture.png", "."])
def test_a_place_that_is_none_is_refused(tmp_path, place):
    with pytest.raises(BearingTwinError, match="cannot be written"):
        write_atomic(tmp_path / place, b"bytes")
    assert os.listdir(tmp_path) == []


WORDS = {
    "help of a command": ("bearing_twin", "simulate", "--help"),
    "a long table": ("bearing_twin", "scenes", "--keys"),
    "help of a node": ("bearing_twin.nodes.entry", "sim_node", "--help"),
    "a node by its word": ("bearing_twin", "node", "start", "sim_node", "--help"),
    "an error": ("bearing_twin", "nothing"),
}


BY_ITS_WORD = "a node by its word"  # imports the command line first and then the node, two seconds
BOTH = [pytest.param(one, True, marks=[pytest.mark.environment] if one == BY_ITS_WORD else []) for one in WORDS]


@pytest.mark.parametrize(("what", "both"), [("help of a command", False), *BOTH])
def test_a_reader_that_leaves_is_no_error(what, both, tmp_path):
    said, (reader, printed) = tmp_path / "said", os.pipe()
    os.close(reader)  # before anything is printed
    with said.open("wb") as rest:
        process = subprocess.Popen(
            [sys.executable, "-m", *WORDS[what]], stdout=printed, stderr=printed if both else rest
        )
        os.close(printed)
        assert process.wait(600) == 0
    assert said.read_bytes() == b""


def test_another_pipe_that_breaks_is_an_error():
    code = (
        "from bearing_twin.base.process import run_while_read\n"
        "def broken():\n    raise BrokenPipeError('a socket')\n"
        "run_while_read(broken)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False)
    assert (done.returncode, "a socket" in done.stderr) == (1, True)


CLOSED = {"stdin": "<&-", "stdout": ">&-", "stderr": "2>&-", "all": "<&- >&- 2>&-", "full stderr": "2> /dev/full"}


@pytest.mark.environment
@pytest.mark.parametrize("what", CLOSED)
def test_streams_that_are_closed_or_full_end_nothing(what, tmp_path):
    """There were tracebacks, and a log that got the number of standard output would have got what is printed."""
    log = tmp_path / "run.mcap"
    command = f"{sys.executable} -m bearing_twin simulate two_spheres --out {log} {CLOSED[what]}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=600, check=False)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)
    assert len(list(read_log(log))) == 401


def test_an_error_that_cannot_be_said_is_still_the_users():
    command = f"{sys.executable} -m bearing_twin simulate nothing 2> /dev/full"
    assert subprocess.run(["bash", "-c", command], timeout=600, check=False).returncode == 2


@pytest.mark.parametrize("words", ["scenes --keys", "bearing 6203 --load 0,-100,0 --json"])
def test_a_result_that_finds_no_room_says_that_it_was_to_go_to_standard_output(words):
    command = f"{sys.executable} -m bearing_twin {words} > /dev/full"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == "bearing_twin: standard output cannot be used (No space left on device)"


TABLE = '{"kind": "bearing", "rings": {"inner": {"table": [%s]}}}'
BILLION = "a: &a [x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 8)}]\n" for k in range(12)
)
YAML_BOMBS = {  # texts that would take a reader of YAML long, or much memory
    "aliases": BILLION,
    "merge keys": "a: &a {b: 1}\nc: {" + ", ".join(["<<: *a"] * 1000) + "}",
    "deep lists": "a: " + "[" * 60_000,
    "deep lists, closed": "a: " + "[" * 5000 + "]" * 5000,
    "deep mappings": "a: " + "{a: " * 20_000,
    "deep blocks": "".join(f"{' ' * k}a:\n" for k in range(450)),
    "a long list": "a: [" + "1, " * 40_000 + "]",
    "a long table": TABLE % ", ".join(f"[{k}, 1,0,0,0,0]" for k in range(5800)),
    "a table without end": TABLE % ", ".join(f"[{k}, 1,0,0,0,0]" for k in range(100_000)),
    "a long number": "kind: bearing\nrun: {duration: 1" + "0" * 100_000 + "}",
    "a long text": "kind: bearing\nname: " + "x" * 120_000,
    "many keys": "".join(f"k{k}: 1\n" for k in range(14_000)),
    "the same key": "kind: bearing\n" * 9000,
    "a tag that runs code": "!!python/object/apply:os.system [sleep 100]",
    "many documents": "---\na: 1\n" * 14_000,
    "escapes": 'a: "' + "\\U0001F600" * 12_000 + '"',
    "comments": "#\n" * 60_000,
    "sexagesimals": "a: [" + "190:20:30, " * 11_000 + "]",
}


def test_yaml_that_would_take_long_is_read_or_refused_soon():
    def read():
        for what, text in YAML_BOMBS.items():
            begin = time.process_time()
            with contextlib.suppress(BearingTwinError):
                parse_scene(text, "a bomb")
            assert time.process_time() - begin < 1.5, what

    cost = in_a_process(read)
    assert cost.well
    assert cost.memory < 190e6
