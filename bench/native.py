"""The same equations in plain C++ as a yardstick: `python bench/native.py [seconds]`; skipped without a compiler.

The classical Runge-Kutta method and the implicit-explicit step at 0.5 us, eight balls of a 6203 from rest, by the
product and by `native.cpp` in turn. The product also turns the balls and looks whether its state can be right; the
states must agree.
"""

import platform
import shutil
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path

import numpy as np

from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene
from bearing_twin.vectors import BITS

METHODS = ("rk4", "imex")
STEP, REPEATS = 5e-7, 5
OPTIONS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")
if platform.machine() == "x86_64":
    OPTIONS += (f"-mprefer-vector-width={BITS}",)  # as the product's kernels
GROUPS = (slice(0, 1), slice(1, 2), slice(2, 3), slice(3, 6), slice(6, 9))  # columns that share a unit and a size
AGREE = 1e-6  # of the greatest number of a group: what rounding may grow to


def built(folder):
    """The program, or None without a compiler."""
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        return None
    program = Path(folder) / "native"
    subprocess.run([compiler, *OPTIONS, "-o", program, Path(__file__).with_name("native.cpp")], check=True)
    return program


def numbers(motion, steps):
    """What the program reads, in its order."""
    bearing = motion.bearing
    yield from (motion.drive.speed, STEP, steps, bearing.ball_radius, bearing.ball_mass, bearing.ball_inertia)
    yield from (*bearing.offset, *bearing.gravity, bearing.damping, bearing.relaxation_time)
    yield from (bearing.raceway_friction, bearing.friction_regularisation)
    for ring in (bearing.inner, bearing.outer):
        yield from (ring.locus_radius, ring.groove_radius, *ring.terms)
    yield from motion.state.T.ravel()


def compared(method, span):
    """Processor seconds per simulated second over `span` [s], ours and C++, and how far apart; None: no compiler."""
    scene = load_scene("bearing_6203", ("initial.motion=rest", f"solver.stepper={method}", f"solver.step={STEP}"))
    motion = BearingMotion(scene.parameters, choose(scene))
    with tempfile.TemporaryDirectory() as folder:
        program = built(folder)
        if program is None:
            return None
        given = "\n".join(f"{number:.17g}" for number in numbers(motion, round(span / STEP)))
        motion.advance(np.array([span]), span)
        ours, theirs = [], []
        for _ in range(REPEATS):
            motion.reset()
            start = time.process_time()
            motion.advance(np.array([span]), span)
            ours.append((time.process_time() - start) / span)
            answer = subprocess.run([program, method], input=given, capture_output=True, text=True, check=True).stdout
            *state, spent = map(float, answer.split())
            theirs.append(spent / span)
    state = np.array(state).reshape(motion.state.shape[::-1]).T
    groups = [(np.abs(state - motion.state)[:, part].max(), np.abs(motion.state)[:, part].max()) for part in GROUPS]
    apart = float(max(error / greatest for error, greatest in groups))
    if not apart < AGREE:
        raise SystemExit(f"the two disagree by {apart:.2g}: the comparison means nothing")
    return float(np.median(ours)), float(np.median(theirs)), apart


def main(seconds="0.05"):
    """Prints two lines a method: what was compared; seconds of both, and their ratio."""
    span = float(seconds)
    for method in METHODS:
        found = compared(method, span)
        if found is None:
            print("native: no C++ compiler is found, so there is nothing to compare with", file=sys.stderr)
            return
        one, two, apart = found
        what = f"{method} at {1e6 * STEP:g} us, {span:g} s, 8 balls, {platform.machine()}, {date.today()}"
        print(f"{what}; agree to {apart:.1g}")
        print(
            f"{one:.3g} s a simulated second, C++ {two:.3g}: the product runs at {two / one:.2f} times its speed",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
