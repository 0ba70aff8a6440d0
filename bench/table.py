"""Costs of public calls and commands, as one table: `python bench/table.py [--write] [part of a row's name ...]`.

CPU time of one core unless stated otherwise, by public calls and commands.
`--write` keeps the rows that ran in docs/speed.csv, from which `python tests/doc_tables.py` writes docs/accuracy.md.
"""

import contextlib
import csv
import importlib.util
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from functools import cache
from pathlib import Path
from typing import NamedTuple

import peers
from memory import most_held

from bearing_twin import load_scene, load_study, parse_study, run_study, simulate, write_log
from bearing_twin.charts.contest import processor
from bearing_twin.charts.scenes import WITHOUT_CHECK

TABLE = Path(__file__).resolve().parent.parent / "docs" / "speed.csv"
COLUMNS = "what", "found", "unit", "machine", "day"
REPEATS, SPEED = 5, "times real time"


class Measured(NamedTuple):
    """A row: a name, a unit, and what measures it; NaN where that is impossible here."""

    what: str
    unit: str
    measure: Callable[[], float]


def _spent() -> float:
    """CPU seconds of this process and of those that it has started and seen end."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def _median(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """CPU seconds of `work`, the median of repeats after one that warms up."""
    spans = []
    for _ in range(repeats + 1):
        began = time.process_time()
        work()
        spans.append(time.process_time() - began)
    return statistics.median(spans[1:])


def _speed(name: str, *overrides: str, take: Callable = lambda run: [None for _ in run.blocks()]) -> float:
    """Simulated seconds a CPU second, of blocks unless it is taken otherwise."""
    scene = load_scene(name, overrides)
    return scene.parameters.run.duration / _median(lambda: take(simulate(scene)))


def _log(run) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_log(run, Path(folder) / "run.mcap")


def _many_balls() -> float:
    """Cost a ball of 512 over that of 8, each of the same motion."""
    costs = []
    for balls in (8, 512):
        wide = f"geometry.balls={balls}", f"geometry.pitch_diameter={balls * 28.5e-3 / 8}", "run.duration=0.1"
        costs.append(1.0 / (_speed("bearing_6203", *wide, WITHOUT_CHECK) * balls))
    return costs[1] / costs[0]


def _study(name, *overrides: str, workers: int = 1) -> float:
    """CPU seconds of all realisations of a study with their statistics, after a small one that warms up."""
    load = (
        load_study if isinstance(name, str) else lambda mapping, overrides: parse_study(mapping, "spheres", overrides)
    )
    run_study(load(name, ["samples=4", f"workers={workers}"]))
    study, began = load(name, [f"workers={workers}", *overrides]), _spent()
    run_study(study)
    return _spent() - began


def _start(scene: str) -> float:
    """CPU seconds of a command that simulates a millisecond."""
    command = [sys.executable, "-m", "bearing_twin", "simulate", scene, "--set", "run.duration=0.001"]
    spans = []
    for _ in range(REPEATS):
        began = _spent()
        subprocess.run(command, check=True, capture_output=True)
        spans.append(_spent() - began)
    return statistics.median(spans)


@cache
def _nodes(outputs: int, messages: int):
    from node_cost import measured  # needs ROS

    with tempfile.TemporaryDirectory() as folder:
        return measured(outputs, messages, Path(folder))


def _peer(problem: str) -> float:
    """Exudyn's time over ours by the public call; its environment is made where there is none."""
    with contextlib.redirect_stdout(sys.stderr):
        return peers.compared(problem, peers.PROBLEMS[problem])[0]


TO_THE_END = "stop.relative_tolerance=1e-6"
SPEEDS = "sweep={motion.first_velocity: [1, 2, 5, 10, 20, 50, 100, 200]}"
MANY = ("study", "spheres_alpha_4e-5", "--samples", "200000", *(f"--set={key}" for key in (SPEEDS, "histories=[]")))
SPHERES = {
    "scene": "two_spheres",
    "method": "ensemble",
    "inputs": {"contact.measured_alpha": {"distribution": "gamma", "mean": 1.138e-4, "std": 4e-5}},
    "quantities": ["contact_duration", "peak_force"],
    "samples": 1_000_000,
}
RIG, KILOHERTZ = "bearing_6203_rig_1000N", "run.output_rate=1000"
ONE, TEN, POCKETS = ("run.duration=1", KILOHERTZ), ("run.duration=10", KILOHERTZ), "cage.kind=pockets"
SETTLED, LONG = "6203 settled, outputs at 1 kHz: ", "run.duration=20"
ROWS = (
    Measured(f"{SETTLED}blocks without a check", SPEED, lambda: _speed("bearing_6203", LONG, WITHOUT_CHECK)),
    Measured(f"{SETTLED}blocks", SPEED, lambda: _speed("bearing_6203", LONG)),
    Measured(f"{SETTLED}samples", SPEED, lambda: _speed("bearing_6203", LONG, take=list)),
    Measured(f"{SETTLED}a log", SPEED, lambda: _speed("bearing_6203", LONG, take=_log)),
    Measured("6203 with clearance, outputs at 1 kHz", SPEED, lambda: _speed("bearing_6203_loose", *ONE)),
    Measured("6203, sudden speed and load", SPEED, lambda: _speed("bearing_6203_sudden", KILOHERTZ)),
    Measured("6203, friction over the patch", SPEED, lambda: _speed("bearing_6203", *ONE, "contact.friction=spot")),
    Measured("512 balls, a ball", "of 8 balls", _many_balls),
    Measured("rig 1000 N over 10 s, even cage", SPEED, lambda: _speed(RIG, *TEN, "cage.kind=even")),
    Measured("rig 1000 N over 10 s, pockets", SPEED, lambda: _speed(RIG, *TEN, POCKETS)),
    Measured("shaft on two 6203, unbalance", SPEED, lambda: _speed("shaft_two_6203", *ONE)),
    Measured("shaft on two 7204B, overhung", SPEED, lambda: _speed("shaft_angular_pair", *ONE)),
    Measured("1e6 spheres with statistics", "s", lambda: _study(SPHERES)),
    Measured(
        "1000 bearings with tolerances", "s", lambda: _study("bearing_6203_tolerances", "samples=1000", TO_THE_END)
    ),
    Measured("200 000 spheres at 8 speeds without histories", "MB", lambda: most_held(*MANY)),
    Measured("start of a command, 6203", "s", lambda: _start("bearing_6203")),
    Measured("start of a command, rig 1000 N", "s", lambda: _start(RIG)),
    Measured("sim_node, outputs at 100 Hz", "% of a core", lambda: _nodes(100, 100).alone),
    Measured("sim_node, outputs at 1 kHz", "% of a core", lambda: _nodes(1000, 1000).alone),
    Measured("recorder_node at 1 kHz", "% of a core", lambda: _nodes(1000, 1000).recorder),
    Measured("both nodes at 4 kHz", "lost", lambda: _nodes(4000, 1000).lost),
    Measured("Exudyn's time, settled", "of ours", lambda: _peer("settled")),
    Measured("Exudyn's time, from rest", "of ours", lambda: _peer("from rest")),
    Measured("Exudyn's time, lift-off", "of ours", lambda: _peer("lift-off")),
)


def stored_rows() -> dict[str, dict]:
    """The rows of the table in docs, by name."""
    if not TABLE.is_file():
        return {}
    with TABLE.open(newline="", encoding="utf-8") as stream:
        return {line["what"]: line for line in csv.DictReader(stream)}


def main(*arguments: str) -> None:
    """Prints one line a row; --write keeps them."""
    names, measured = [name for name in arguments if name != "--write"], {}
    machine, day = processor(), str(date.today())
    print(f"{machine}, {day}")
    rows = [row for row in ROWS if not names or any(name in row.what for name in names)]
    for number, row in enumerate(rows):
        print(f"{number + 1} of {len(rows)}: {row.what}", file=sys.stderr, flush=True)
        if "_node" in row.what and not importlib.util.find_spec("rclpy"):
            print(f"{row.what}: not measured, there is no ROS here (source env.bash)", file=sys.stderr)
            continue
        value = row.measure()
        if value == value:
            measured[row.what] = dict(zip(COLUMNS, (row.what, f"{value:.3g}", row.unit, machine, day), strict=True))
            print(f"{row.what:48}{value:8.3g} {row.unit}", flush=True)
    if "--write" in arguments:
        lines = stored_rows() | measured
        with TABLE.open("w", newline="", encoding="utf-8") as stream:
            table = csv.DictWriter(stream, COLUMNS, extrasaction="ignore", lineterminator="\n")
            table.writeheader()
            table.writerows(lines[row.what] for row in ROWS if row.what in lines)


if __name__ == "__main__":
    main(*sys.argv[1:])
