"""What everything costs in the user's hand, as one table: `python bench/table.py [--write] [part of a row's name ...]`.

CPU time, one core where nothing else is said. Goals are those of a machine on which a contact of ball and raceway takes
YARDSTICK (`measured`). The table says what is measured, what a contact took before and after, and, of times, what that
is there, by which a goal is met or missed. `--write` keeps the rows that ran in docs/speed.csv, from which
docs/accuracy.md is written (`python tests/doc_tables.py`).
"""

import contextlib
import importlib.util
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from functools import cache
from pathlib import Path

import numpy as np
import peers
from measured import SPEED, YARDSTICK, Measured, keep
from memory import most_held
from native import compared
from speed import STAGES, kernel_time, set_up, times_real_time
from static_solve import solved

from bearing_twin import load_scene, load_study, run_study, simulate
from bearing_twin.charts.bearing_cells import motion_of
from bearing_twin.charts.contest_picture import cheapest
from bearing_twin.charts.made import processor
from bearing_twin.charts.work_precision import CASES, FINER, WANTED, further, judge_motion
from bearing_twin.uq.study import parse_study

LOOSE, TOUCHING = "geometry.radial_clearance=1e-5", ("geometry.balls=13", "geometry.pitch_diameter=28.1888e-3")
STEPPERS = ("rodas4", "rodas3", "rodas4_landing")  # of which the cheapest within WANTED is told
REPEATS, TURNS, SPAN = 5, 300, 0.2  # of each timing, of short ones; s of simulated time
START = ("simulate", "bearing_6203", "--set", "run.duration=0.001")


@cache
def _settled():
    scene = load_scene("bearing_6203", ["run.duration=20"])
    return scene, simulate(scene).simulation._motion


def _stage(name: str) -> float:
    """Times real time of one way to take a run."""
    scene, yardstick = _settled()
    return times_real_time(STAGES[name], scene, yardstick)[1]


def _held(problem: str) -> float:
    """Times real time of the cheapest run whose errors in load and friction are small enough."""
    rows, waiting = [], [(problem, one, setting) for one in STEPPERS for setting in FINER[one]]
    while waiting:
        rows += [judge_motion(*one, 0.0) for one in waiting]
        waiting = further(rows)
    return max(1.0 / row.seconds for one in STEPPERS if (row := cheapest(rows, problem, one, WANTED)))


def _seconds(motion, times) -> float:
    """CPU seconds of a motion from its start, the median."""
    return float(np.median([_once(motion, times) for _ in range(REPEATS + 1)][1:]))


def _once(motion, times) -> float:
    """CPU seconds of a motion from its start, once."""
    motion.reset()
    began = time.process_time()
    motion.advance(times, float(times[-1]))
    return time.process_time() - began


def _spot_over_point(problem: str) -> float:
    """Seconds of friction over a spot over those of friction at a point, at the same tolerance."""
    case = CASES[problem]
    motions = [motion_of(case, "rodas4", "hertz", f"contact.friction={one}") for one in ("spot", "point")]
    spot, point = (_seconds(motion, case.times) for motion in motions)
    return spot / point


def _a_step(*overrides: str) -> float:
    """CPU seconds of a step of one ball."""
    case = CASES["sliding"]._replace(overrides=("initial.motion=rest", *overrides))
    motion = motion_of(case, "rodas4")
    spent = _seconds(motion, case.times)
    motion.reset()
    before = motion.costs()["ball_steps"]
    motion.advance(case.times, float(case.times[-1]))
    return spent / (motion.costs()["ball_steps"] - before)


def _many_balls() -> float:
    """Cost a ball of 512 over that of 8, each of the same motion."""
    spent = []
    for balls in (8, 512):
        wide = f"geometry.pitch_diameter={balls * 28.5e-3 / 8}"
        motion = motion_of(CASES["settled"]._replace(overrides=(f"geometry.balls={balls}", wide)), "rodas4")
        spent.append(_seconds(motion, CASES["settled"].times) / balls)
    return spent[1] / spent[0]


def _blocks(name: str, *overrides: str) -> float:
    """Times real time of iterating the blocks of a scene, with its companion and set-up."""
    spans, scene = [], load_scene(name, overrides)
    for _ in range(REPEATS):
        began = time.process_time()
        for _ in simulate(scene).blocks():
            pass
        spans.append(time.process_time() - began)
    return scene.parameters.run.duration / float(np.median(spans[1:]))


def _cage_over_none() -> float:
    """Seconds of a held ring with an even cage over those without a cage, a tenth of a second at 1500 rpm.

    Each takes a quarter of a millisecond: the least of many in turn.
    """
    cases = [
        CASES["settled"]._replace(overrides=("drive.speed=157.08", f"cage.kind={one}")) for one in ("even", "none")
    ]
    pairs = [(motion_of(case, "rodas4"), case.times) for case in cases]
    even, none = np.min([[_once(*pair) for pair in pairs] for _ in range(TURNS)], axis=0)
    return even / none


def _study(name, *overrides: str, workers: int = 1) -> float:
    """CPU seconds of all realisations of a study with their statistics, after a small one compiled."""
    load = load_study if isinstance(name, str) else lambda mapping, words: parse_study(mapping, "spheres", words)
    run_study(load(name, ["samples=4", f"workers={workers}"]))
    study, began = load(name, [f"workers={workers}", *overrides]), _spent()
    run_study(study)
    return _spent() - began


def _two_workers() -> float:
    """CPU time of a study by two workers over that by one."""
    one, two = (_study("bearing_6203_tolerances", "samples=1000", TO_THE_END, workers=count) for count in (1, 2))
    return two / one


def _peer(problem: str) -> float:
    """Exudyn's time over ours by the public call; its environment is made where there is none."""
    with contextlib.redirect_stdout(sys.stderr):
        return peers.compared(problem, peers.PROBLEMS[problem])[0]


def _spent() -> float:
    """CPU seconds of this process and of those that it has started and seen end."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def _start(cold: bool) -> float:
    """CPU seconds of a command that simulates a millisecond, with an empty cache or a full one."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | ({"XDG_CACHE_HOME": folder} if cold else {})
        spans = []
        for _ in range(1 if cold else REPEATS):
            began = _spent()
            command = [sys.executable, "-m", "bearing_twin", *START]
            subprocess.run(command, env=environment, check=True, capture_output=True)
            spans.append(_spent() - began)
    return float(np.median(spans))


@cache
def _nodes(outputs: int, messages: int):
    from node_cost import measured  # needs ROS

    with tempfile.TemporaryDirectory() as folder:
        return measured(outputs, messages, Path(folder))


def _native(method: str) -> float:
    found = compared(method, 0.05)
    return found[1] / found[0] if found else np.nan


TO_THE_END = "stop.relative_tolerance=1e-6"
SPEEDS = "sweep={motion.first_velocity: [1, 2, 5, 10, 20, 50, 100, 200]}"
MANY = ("study", "spheres_alpha_4e-5", "--samples", "200000", *(f"--set={one}" for one in (SPEEDS, "histories=[]")))
SETTLED = "6203 settled, outputs at 1 kHz: "
SPHERES = {
    "scene": "two_spheres",
    "method": "ensemble",
    "inputs": {"contact.measured_alpha": {"distribution": "gamma", "mean": 1.138e-4, "std": 4e-5}},
    "quantities": ["contact_duration", "peak_force"],
    "samples": 1_000_000,
}
RIG, KILOHERTZ = "bearing_6203_rig_1000N", "run.output_rate=1000"
ONE, TEN, POCKETS = ("run.duration=1", KILOHERTZ), ("run.duration=10", KILOHERTZ), "cage.kind=pockets"
ROWS: dict[Measured, Callable[[], float]] = {
    Measured(f"{SETTLED}motion", "speed.py", 350, "more", SPEED): lambda: _stage("motion and outputs"),
    Measured(f"{SETTLED}blocks", "speed.py", 200, "more", SPEED): lambda: _stage("iterate blocks"),
    Measured(f"{SETTLED}samples", "speed.py", 120, "more", SPEED): lambda: _stage("iterate samples"),
    Measured(f"{SETTLED}log", "speed.py", 60, "more", SPEED): lambda: _stage("log on disk"),
    Measured("from rest, errors 1e-3", "`chart steppers`", 5, "more", SPEED): lambda: _held("sliding"),
    Measured("lift-off, errors 1e-3", "`chart steppers`", 70, "more", SPEED): lambda: _held("lift-off"),
    Measured("sudden, its worst millisecond", "`chart steppers`", 1.3, "more", SPEED): lambda: _held("sudden"),
    Measured("sudden, the scene at 1 kHz", "blocks", 12, "more", SPEED): lambda: _blocks(
        "bearing_6203_sudden", "run.output_rate=1000"
    ),
    Measured("friction at 0.1 mm/s", "`chart steppers`", 60, "more", SPEED): lambda: _held("sticking"),
    Measured("spot, settled", "motion", 1.4, "less", "of point"): lambda: _spot_over_point("settled"),
    Measured("spot, from rest", "motion", 2.5, "less", "of point"): lambda: _spot_over_point("sliding"),
    Measured("spot, lift-off", "motion", 2.5, "less", "of point"): lambda: _spot_over_point("lift-off"),
    Measured("13 balls that touch, a step", "motion", 3, "less", "of one alone"): lambda: (
        _a_step(*TOUCHING) / _a_step()
    ),
    Measured("rk4 at 0.5 us", "native.py", 0.8, "more", "of C++"): lambda: _native("rk4"),
    Measured("imex at 0.5 us", "native.py", 0.8, "more", "of C++"): lambda: _native("imex"),
    Measured("512 balls, a ball", "motion", 1.3, "less", "of 8 balls"): _many_balls,
    Measured("set-up of 8 balls", "speed.py", 1, "less", "ms"): lambda: set_up(*_settled())[0],
    Measured("1e6 spheres with statistics", "`run_study`", 0.5, "less", "s"): lambda: _study(SPHERES),
    Measured("1e4 bearings with tolerances", "`run_study`", 70, "less", "s"): lambda: _study(
        "bearing_6203_tolerances", "samples=10000", TO_THE_END
    ),
    Measured("1000 bearings by two workers", "`run_study`", 1, "less", "of one"): _two_workers,
    Measured("200 000 spheres at 8 speeds without histories", "command", 300, "less", "MB"): lambda: most_held(*MANY),
    Measured("static solve, cold", "static_solve.py", 20, "less", "us"): lambda: solved(157.08)["cold"],
    Measured("static solve, warm", "static_solve.py", 8, "less", "us"): lambda: solved(157.08)["warm"],
    Measured("loads of a held ring", "static_solve.py", 1.5, "less", "us"): lambda: solved(157.08)["held"],
    Measured("rig 1000 N over 10 s, even cage", "blocks", 20, "more", SPEED): lambda: _blocks(RIG, *TEN),
    Measured("rig 1000 N over 10 s, pockets", "blocks", 8, "more", SPEED): lambda: _blocks(RIG, *TEN, POCKETS),
    Measured("shaft on two 6203, unbalance", "blocks", 10, "more", SPEED): lambda: _blocks("shaft_two_6203", *ONE),
    Measured("shaft on two 7204B, overhung", "blocks", 10, "more", SPEED): lambda: _blocks("shaft_angular_pair", *ONE),
    Measured("even cage, ring held", "motion", 1.1, "less", "of no cage"): _cage_over_none,
    Measured("start, kernels kept", "command", 1.3, "less", "s"): lambda: _start(False),
    Measured("start, kernels compiled", "command", 18, "less", "s"): lambda: _start(True),
    Measured("sim_node, outputs at 100 Hz", "node_cost.py", 5, "less", "% of a core"): lambda: _nodes(100, 100).alone,
    Measured("sim_node, outputs at 1 kHz", "node_cost.py", 10, "less", "% of a core"): lambda: _nodes(1000, 1000).alone,
    Measured("recorder_node at 1 kHz", "node_cost.py", 20, "less", "% of a core"): lambda: _nodes(1000, 1000).recorder,
    Measured("both nodes at 4 kHz", "node_cost.py", 1, "less", "lost"): lambda: _nodes(4000, 1000).lost,
    Measured("Exudyn's time, settled", "peers.py", 200, "more", "of ours"): lambda: _peer("settled"),
    Measured("Exudyn's time, from rest", "peers.py", 200, "more", "of ours"): lambda: _peer("from rest"),
    Measured("Exudyn's time, lift-off", "peers.py", 250, "more", "of ours"): lambda: _peer("lift-off"),
}


def main(*words: str) -> None:
    """Prints one line a row; --write keeps them."""
    parts = [word for word in words if word != "--write"]
    machine, moving, rows = processor(), _settled()[1], []
    print(f"{machine}, {date.today()}")
    wanted = [row for row in ROWS if not parts or any(part in row.what for part in parts)]
    for number, row in enumerate(wanted):
        print(f"{number + 1} of {len(wanted)}: {row.what}", file=sys.stderr, flush=True)
        if "_node" in row.what and not importlib.util.find_spec("rclpy"):
            print(f"{row.what}: left out, there is no ROS here (source env.bash)", file=sys.stderr)
            continue
        before, found = kernel_time(moving), ROWS[row]()
        contact = float(f"{0.5 * (before + kernel_time(moving)):.2g}")  # a machine is not as fast all the time
        if np.isnan(found):
            print(f"{row.what}: left out, what it is compared with is not to be had here", file=sys.stderr)
            continue
        here = {"found": float(f"{found:.3g}"), "machine": machine, "contact": contact, "day": str(date.today())}
        rows.append(replace(row, **here))
        as_there = f"{rows[-1].scaled:g} at {YARDSTICK} ns, of {contact:g}" if row.timed else ""
        print(
            f"{row.what:48}{rows[-1].found:8g} {row.unit:16}{as_there:26}{row.better} than {row.goal:<6g}"
            f"{'' if rows[-1].met else 'missed'}",
            flush=True,
        )
    if "--write" in words:
        keep(rows, ROWS)


if __name__ == "__main__":
    main(*sys.argv[1:])
