"""A reader that leaves before the end, as `head` does, is no error: of any program of the package."""

import os
import subprocess
import sys

import pytest

from bearing_twin.log.run_log import read_log

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
def test_a_reader_that_leaves_is_no_error(what, both, tmp_path, quick_starts):
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
        "from bearing_twin.base.process import while_read\n"
        "def broken():\n    raise BrokenPipeError('a socket')\n"
        "while_read(broken)"
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
