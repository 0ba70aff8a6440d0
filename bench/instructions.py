"""Counts the processor's instructions of an attempted step of eight balls: `python bench/instructions.py`.

A child of this process moves a bearing on and is stopped after each instruction (`ptrace` of Linux), so that the count
is the same on a busy machine. Each line is what a longer stretch takes beyond a shorter one, over the attempts that it
makes more: what is done once a call does not count. No companion, no output inside, and takes minutes.
"""

import ctypes
import os
import signal
from datetime import date

import numpy as np

from bearing_twin.charts.bearing_cells import Case, motion_of
from bearing_twin.charts.made import processor
from bearing_twin.numerics.statuses import REJECTIONS, STEPS

TRACE_ME, ONE_INSTRUCTION = 0, 9  # of its requests
RIG = "bearing_6203_rig_1000N"
BEGIN = 1e-3  # s, of the stretches
# Scene, words, and how long both stretches are [s]. Balls alone are all alike, so that no lane waits for another.
CASES = {
    "balls alone": ("bearing_6203", ("gravity=[0,0,0]", "initial.motion=rest"), 1e-3, 3e-2),
    "balls alone, friction over spots": (
        "bearing_6203",
        ("gravity=[0,0,0]", "initial.motion=rest", "contact.friction=spot"),
        1e-3,
        3e-2,
    ),
    "ring with mass, even cage": (RIG, (), 1e-4, 4e-4),
    "ring with mass, pockets": (RIG, ("cage.kind=pockets",), 1e-4, 4e-4),
}

_ptrace = ctypes.CDLL(None, use_errno=True).ptrace
_ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]


def attempts(motion, seconds: float) -> int:
    """Attempts of a motion over a stretch [s], after which it is where it was."""
    before = motion.counts.copy()
    motion.advance(np.array([seconds]), seconds)
    made = motion.counts - before
    motion.take_back()
    return int(made[STEPS] + made[REJECTIONS]) // motion.bearing.balls


def instructions(motion, seconds: float) -> int:
    """Instructions of a motion over a stretch [s], in a child that ends with it.

    Raises OSError where the system lets no process watch its child.
    """
    child = os.fork()
    if child == 0:
        _ptrace(TRACE_ME, 0, None, None)
        os.kill(os.getpid(), signal.SIGSTOP)
        motion.advance(np.array([seconds]), seconds)
        os.kill(os.getpid(), signal.SIGSTOP)
        os._exit(0)
    os.waitpid(child, 0)
    count = 0
    while _ptrace(ONE_INSTRUCTION, child, None, None) == 0:
        _, status = os.waitpid(child, 0)
        if not os.WIFSTOPPED(status) or os.WSTOPSIG(status) == signal.SIGSTOP:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return count
        count += 1
    raise OSError(ctypes.get_errno(), "this system lets no process watch its child")


def main() -> None:
    """Prints one line a case."""
    print(f"instructions of an attempted step of 8 balls, {processor()}, {date.today()}")
    for name, (scene, words, short, long) in CASES.items():
        motion = motion_of(Case(scene, words, BEGIN, 1), "rodas4")
        motion.advance(np.array([BEGIN]), BEGIN)
        count = attempts(motion, long) - attempts(motion, short)
        more = instructions(motion, long) - instructions(motion, short)
        print(f"{name:34}{more / count:8.0f}, mean of {count} attempts", flush=True)


if __name__ == "__main__":
    main()
