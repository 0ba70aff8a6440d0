"""A reader that leaves before the end, as `head` does, is no error: of any program of the package."""

import subprocess
import sys

import pytest

WORDS = {
    "help of a command": ("bearing_twin", "simulate", "--help"),
    "a long table": ("bearing_twin", "scenes", "--keys"),
    "help of a node": ("bearing_twin.nodes.entry", "sim_node", "--help"),
    "a node by its word": ("bearing_twin", "node", "start", "sim_node", "--help"),
    "an error": ("bearing_twin", "nothing"),
}


@pytest.mark.parametrize(("what", "both"), [("help of a command", False), *((what, True) for what in WORDS)])
def test_a_reader_that_leaves_is_no_error(what, both, tmp_path):
    said = tmp_path / "said"
    with said.open("wb") as rest:
        process = subprocess.Popen(
            [sys.executable, "-m", *WORDS[what]], stdout=subprocess.PIPE, stderr=subprocess.STDOUT if both else rest
        )
        process.stdout.close()
        assert process.wait(600) == 0
    assert said.read_bytes() == b""


def test_another_pipe_that_breaks_is_an_error():
    code = (
        "from bearing_twin.pipes import while_read\n"
        "def broken():\n    raise BrokenPipeError('a socket')\n"
        "while_read(broken)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False)
    assert (done.returncode, "a socket" in done.stderr) == (1, True)
