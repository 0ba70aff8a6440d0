"""The same bearing in another program, Exudyn: `python bench/peers.py [problem ...]`.

Exudyn is a multibody program in C++; it gets an environment of its own in build/peers. Eight balls in the grooves of
two rings start from the same state under the same laws: a load of c h^1.5 with the same c and Hunt and Crossley's
damping, friction of the same coefficient. Its friction grows in a straight line up to the regularising speed and ours
bends, so that the two agree where slip is small and each is judged against a far tighter run of its own. The ring has
no axial offset: contacts of a sphere and a torus are wrong there with one. Printed is CPU time per simulated second,
set-up left out for both; compared is the cheapest run of each whose errors of load and friction are small enough, by
the least of REPEATS runs, one of each in turn.
"""

import json
import platform
import subprocess
import sys
import time
import venv
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearing_twin import load_scene, simulate
from bearing_twin.charts.scenes import last_overrides

HERE = Path(__file__).resolve().parent
FOLDER, PEER = HERE.parent / "build" / "peers", "exudyn==1.13.6"
ERRORS = 1e-3, 1e-2, 1e-1  # errors in load and friction at which costs are compared: at the least that both reach
LEAST_LOAD = 0.01  # of the greatest load: a contact that carries less has no friction limit for a relative error
SAME = ("contact.normal=hertz", "contact.relaxation_time=0", "contact.damping=0.5", "drive.offset=[0, 0, 0]")
TRUTH = ("solver.stepper=rodas4", "wanted.tolerance=1e-8")
TOLERANCES = 1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5
REPEATS = 5


class Problem(NamedTuple):
    """A scene, what is set in it, output rate [Hz], duration [s], and the fixed step [s] of Exudyn's tightest run."""

    scene: str
    overrides: tuple[str, ...]
    rate: float
    duration: float
    truth: float


PROBLEMS = {
    "settled": Problem("bearing_6203", (), 1e3, 0.5, 1e-6),
    "from rest": Problem("bearing_6203", ("initial.motion=rest", "drive.offset=[0, -1e-6, 0]"), 2e4, 4e-3, 5e-8),
    "lift-off": Problem("bearing_6203_loose", ("drive.offset=[0, -9e-6, 0]",), 1e3, 0.05, 2.5e-7),
}


def environment():
    """The interpreter of Exudyn's own environment, made where there is none."""
    python = FOLDER / "bin" / "python"
    if not (FOLDER / "made").exists():
        print(f"{PEER}: making {FOLDER}", file=sys.stderr)
        venv.create(FOLDER, with_pip=True, clear=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", PEER], check=True)
        (FOLDER / "made").touch()
    return python


def scene_of(problem, *overrides):
    """The scene as both run it."""
    outputs = f"run.output_rate={problem.rate:g}", f"run.duration={problem.duration:g}"
    return load_scene(problem.scene, last_overrides((*SAME, *problem.overrides, *outputs, *overrides)))


def ours(problem, *overrides):
    """Loads (T, N, 2), friction (T, N, 2, 3), and CPU seconds per simulated second of iterating all blocks."""
    run = simulate(scene_of(problem, *overrides))
    start = time.process_time()
    blocks = list(run.blocks())
    spent = (time.process_time() - start) / problem.duration
    loads, frictions = (
        np.concatenate([block.values[name] for block in blocks])[1:] for name in ("normal_load", "friction_force")
    )
    return loads, frictions, spent


def input_of(problem):
    """Input of Exudyn: the start and the constants, by name."""
    scene = scene_of(problem).parameters
    run = simulate(scene_of(problem))
    first = next(iter(run.blocks()))
    bearing = run.simulation._motion.bearing
    position, velocity, spin = (first.values[name][0].tolist() for name in ("position", "velocity", "angular_velocity"))
    rings = [
        {"locus": ring.locus_radius, "groove": ring.groove_radius, "coefficient": ring.law.given}
        for ring in (bearing.inner, bearing.outer)
    ]
    return {
        "position": position,
        "velocity": velocity,
        "spin": spin,
        "rings": rings,
        "radius": bearing.ball_radius,
        "mass": bearing.ball_mass,
        "inertia": bearing.ball_inertia,
        "offset": bearing.offset,
        "gravity": bearing.gravity,
        "speed": scene.drive.speed,
        "friction": bearing.friction_coefficient,
        "regularisation": bearing.friction_regularisation,
        "damping": bearing.damping,
        "period": 1.0 / problem.rate,
        "end": problem.duration,
        "truth": problem.truth,
    }


def theirs(problem, only=None):
    """One dictionary a run of Exudyn, the tightest first: name, loads, friction, CPU seconds per simulated second."""
    request = json.dumps(input_of(problem) | {"only": only})
    command = [environment(), HERE / "peers_exudyn.py"]
    answer = subprocess.run(command, input=request, stdout=subprocess.PIPE, text=True, check=True)
    for line in filter(lambda line: line.startswith("{"), answer.stdout.splitlines()):
        yield json.loads(line)


def errors(result, true, coefficient):
    """Greatest errors of load, over the greatest load, and of friction, over mu times the load there and then."""
    (load, friction), (true_load, true_friction) = result, true
    greatest = true_load.max()
    difference = np.linalg.norm(friction - true_friction, axis=-1) / np.maximum(true_load, LEAST_LOAD * greatest)
    return np.abs(load - true_load).max() / greatest, difference.max() / coefficient


def print_row(name, errors, seconds):
    """Print a line of the table."""
    print(f"  {name:44}{errors[0]:>10.1e}{errors[1]:>12.1e}{seconds:>14.3g}", flush=True)


def cheapest(rows, tolerance):
    """The cheapest (name, errors, seconds) whose errors are within the tolerance, or None."""
    return min((row for row in rows if max(row[1]) <= tolerance), key=lambda row: row[2], default=None)


def measured(problem, true, coefficient, setting):
    """Settings, errors and the least time of REPEATS of our runs, after one that warms up."""
    (*result, _), *again = (ours(problem, *setting) for _ in range(1 + REPEATS))
    return ", ".join(setting), errors(result, true, coefficient), min(seconds for *_, seconds in again)


def ratio(problem, their_setting, our_setting):
    """Their time over ours, each the least of REPEATS runs in turn, of two settings by their names."""
    keys = our_setting.split(", ")
    spent = [(next(theirs(problem, their_setting))["seconds"], ours(problem, *keys)[2]) for _ in range(REPEATS)]
    return np.divide(*np.min(spent, axis=0))


def compared(name, problem):
    """Prints the table of one problem; returns Exudyn's time over ours of the cheapest good settings.

    With our second run and without; NaN where Exudyn is not available.
    """
    try:
        environment()
    except subprocess.CalledProcessError as error:
        print(f"{PEER} is not available: {error}", file=sys.stderr)
        return np.nan, np.nan
    mu = scene_of(problem).parameters.contact.friction_coefficient
    *true, _ = ours(problem, *TRUTH)
    runs = list(theirs(problem))
    arrays = [tuple(map(np.array, (run["load"], run["friction"]))) for run in runs]
    between = errors(arrays[0], true, mu)
    print(f"{name}: the tightest runs differ by {between[0]:.1e} in load and {between[1]:.1e} in friction")
    print(f"  {'':44}{'load':>10}{'friction':>12}{'CPU s per s':>14}")
    rows = [
        (run["name"], errors(result, arrays[0], mu), run["seconds"])
        for run, result in zip(runs[1:], arrays[1:], strict=True)
        if result[0].shape == true[0].shape and np.isfinite(result[0]).all()
    ]
    checked, unchecked = (
        [
            measured(problem, true, mu, (f"wanted.tolerance={tolerance:g}", f"solver.check={check}"))
            for tolerance in TOLERANCES
        ]
        for check in ("second_run", "none")
    )
    for row in rows + checked + unchecked:
        print_row(*row)
    ratios = [np.nan, np.nan]
    for index, our_rows in enumerate((checked, unchecked)):
        for tolerance in ERRORS:
            mine, best = cheapest(our_rows, tolerance), cheapest(rows, tolerance)
            if mine and best:
                ratios[index] = times = ratio(problem, best[0], mine[0])
                print(f"  below {tolerance:g}: {best[0]} takes {times:.0f} times the time of {mine[0]}", flush=True)
                break
    return tuple(ratios)


def main(*names):
    """Every problem, or those named."""
    for name in names:
        if name not in PROBLEMS:
            raise SystemExit(f"there is no problem {name!r}: name some of {', '.join(PROBLEMS)}")
    print(f"{PEER}, one core, {platform.machine()}, {date.today()}")
    for name in names or PROBLEMS:
        compared(name, PROBLEMS[name])


if __name__ == "__main__":
    main(*sys.argv[1:])
