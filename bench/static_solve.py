"""Times the static solve: `python bench/static_solve.py`, microseconds of processor a call, 8 balls of a 6203.

Each line is the mean over calls inside one compiled loop, so that no time of Python counts.
"""

import math
import time

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.quasi_static.equilibrium import first_ring, ring_in_balance, ring_loads, solver_of
from bearing_twin.run.scene import load_scene

CALLS = 20_000
TURN = 0.06  # rad: how far balls go between two warm solves, as at 1500 rpm and 1 kHz


@kernel
def held(calls, setting, directions, q, place, weight, load, stiffness):
    """Loads and stiffness of a ring that is held, the balls where they were."""
    for _ in range(calls):
        ring_loads(setting, directions, q, place, weight, load, stiffness)


@kernel
def cold(calls, setting, directions, free, wanted, scales, longest, q, place, weight, load, stiffness):
    """A loaded ring from nothing."""
    for _ in range(calls):
        q[:] = 0.0
        place[:] = np.nan
        first_ring(setting, directions, free, wanted, scales, longest, q)
        ring_in_balance(setting, directions, q, free, wanted, place, weight, longest, load, stiffness)


@kernel
def warm(calls, turn, setting, directions, q, free, wanted, place, weight, longest, load, stiffness):
    """A loaded ring from the answer before, the balls a little further round."""
    c, s = math.cos(turn), math.sin(turn)
    for _ in range(calls):
        for k in range(len(directions)):
            x, y = directions[k, 0], directions[k, 1]
            directions[k, 0], directions[k, 1] = c * x - s * y, s * x + c * y
        ring_in_balance(setting, directions, q, free, wanted, place, weight, longest, load, stiffness)


def timed(function, *arguments) -> float:
    """Microseconds a call."""
    function(2, *arguments)
    begin = time.process_time()
    function(CALLS, *arguments)
    return 1e6 * (time.process_time() - begin) / CALLS


def solved(speed: float) -> dict[str, float]:
    """Microseconds a solve at that speed [rad/s], by how it starts."""
    overrides = ["geometry.radial_clearance=1e-5", f"drive.speed={speed}"]
    solver = solver_of(load_scene("bearing_6203", overrides).parameters, "hertz", 0.1)
    free, wanted = np.array([1, 1, 1, 0, 0], np.bool_), np.array([0.0, -1000.0, 0.0, 0.0, 0.0])
    start = solver.setting, solver.directions
    end = solver.place, solver.weights, solver.longest, solver.load, solver.stiffness
    arrays = end[:2] + end[3:]
    return {
        "cold": timed(cold, *start, free, wanted, solver.scales, solver.longest, solver.q, *arrays),
        "warm": timed(warm, TURN, *start, solver.q, free, wanted, *end),
        "held": timed(held, *start, solver.q, *arrays),
    }


def main() -> None:
    """Prints one line a case."""
    for speed in (0.0, 157.08):
        print(f"static solve of 8 balls under 1000 N, {speed:.0f} rad/s, CPU time in µs")
        for how, microseconds in solved(speed).items():
            print(f"  {how}{microseconds:8.1f}")


if __name__ == "__main__":
    main()
