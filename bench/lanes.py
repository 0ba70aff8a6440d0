"""What lanes of other widths take: `python bench/lanes.py [processor ...]`, minutes, as each width compiles all steps.

Kernels are compiled for this machine's processor and for one whose instructions are 256 bits wide, or for those named,
as LLVM names them. Each width runs in a process of its own, with kernels of its own, one width after the other, several
times; told is the least CPU time over that of the width in use. rodas4, tolerance 1e-3.

Then, on this machine's processor, how many attempts find 1, 2, ... lanes with a ball, what an attempt of one ball takes
at each width, and by both the time that steps would take if each attempt had the cheapest of several widths, over that
at the width in use.
"""

import itertools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import numpy as np

WIDTHS, ROUNDS = (8, 4), 3
NARROWER = (4, 1)  # at these a run's last balls could step
NARROW = "znver3"  # 256 bits, otherwise much like processors of its maker with 512
HERE = "this machine's"
# Before any other module takes what is set: rows, spans and kernels follow from it.
CHILD = """
from bearing_twin.numerics import lanes
used, lanes.LANES = lanes.LANES, {width}
lanes.STATE_SPAN = lanes.COLUMNS * lanes.LANES
from lanes import {what}
{what}(used)
"""


def print_times(used: int) -> None:
    """Prints the width in use, then each problem and the CPU seconds of its run, at the width that is set."""
    from instructions import RIG
    from steps import least_seconds

    from bearing_twin.charts.bearing_cells import Case, ready
    from bearing_twin.charts.work_precision import CASES, WANTED

    touching = ("geometry.balls=13", "geometry.pitch_diameter=28.1888e-3", "initial.motion=rest")
    problems = CASES | {
        "13 balls that touch": Case("bearing_6203", touching, 1e-4, 20),
        "rig, even cage": Case(RIG, (), 1e-3, 10),
        "rig, pockets": Case(RIG, ("cage.kind=pockets",), 1e-3, 10),
    }
    print(used)
    for name, case in problems.items():
        print(f"{name}\t{least_seconds(ready(case, 'rodas4', WANTED), case, case.times)}")


def stretches_of(case) -> Iterator[tuple[list[int], float]]:
    """Of each stretch of a case: the attempts of each ball, and the CPU seconds of all where each steps by itself."""
    from steps import REPEATS

    from bearing_twin.charts.bearing_cells import ready
    from bearing_twin.charts.work_precision import WANTED
    from bearing_twin.kinds.bearing.stepping import integrate
    from bearing_twin.numerics.statuses import REJECTIONS, STEPS

    whole, found = integrate.rosenbrock_chunk, []

    def one_by_one(task, coupled, balls, state, orientation, steps, results):
        attempts, seconds = [], 0.0
        for ball in balls:
            spans = []
            for _ in range(REPEATS):
                moving = state.copy(), orientation.copy(), steps.copy()
                filled = type(results)(*(one.copy() for one in results))
                began = time.process_time()
                whole(task, coupled, np.array([ball]), *moving, filled)
                spans.append(time.process_time() - began)
            made = filled.counts - results.counts
            attempts.append(int(made[STEPS] + made[REJECTIONS]))
            seconds += min(spans)
        found.append((attempts, seconds))
        return whole(task, coupled, balls, state, orientation, steps, results)

    motion = ready(case, "rodas4", WANTED)
    integrate.rosenbrock_chunk = one_by_one
    try:
        motion.reset()
        motion.advance(case.times, case.seconds)
    finally:
        integrate.rosenbrock_chunk = whole
    yield from found


def held_lanes(attempts: list[int]) -> list[int]:
    """How many attempts find 1, 2, ... lanes with a ball, where each ball has one from the start and makes so many."""
    fewest_first = sorted(attempts)
    made = [after - before for before, after in itertools.pairwise([0, *fewest_first])]
    return made[::-1]


def print_alone(used: int) -> None:
    """Prints the width in use, then each problem, the CPU seconds of an attempt of one ball, and `held_lanes`."""
    from bearing_twin.charts.work_precision import CASES

    print(used)
    for name, case in CASES.items():
        stretches = list(stretches_of(case))
        each = sum(seconds for _, seconds in stretches) / sum(sum(attempts) for attempts, _ in stretches)
        held = np.sum([held_lanes(attempts) for attempts, _ in stretches], axis=0)
        print("\t".join(str(one) for one in (name, each, *held)))


def run_of(width: int, cache: str, cpu: str, what: str) -> tuple[int, dict[str, list[float]]]:
    """The width in use on such a processor, and what the function of that name prints of the problems at `width`."""
    other = {} if cpu == HERE else {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": ""}
    there = os.environ | {"XDG_CACHE_HOME": cache} | other
    program = [sys.executable, "-c", CHILD.format(width=width, what=what)]
    said = subprocess.run(program, env=there, cwd=Path(__file__).parent, stdout=subprocess.PIPE, text=True, check=True)
    used, *lines = said.stdout.splitlines()
    return int(used), {name: [float(one) for one in told] for name, *told in (line.split("\t") for line in lines)}


def by_cheapest(held: list[float], seconds: dict[int, float]) -> float:
    """CPU seconds of attempts whose lanes are `held` so, each at the cheapest width; `seconds` of one at each width."""
    return sum(
        attempts * min(-(-balls // width) * each for width, each in seconds.items())
        for balls, attempts in enumerate(held, 1)
    )


def print_narrower(folder: str) -> None:
    """Prints a table: what an attempt takes at each width, and what narrower lanes for the last balls would bring."""
    from bearing_twin.vectors import BITS

    widths = tuple(dict.fromkeys((BITS // 64, *NARROWER)))
    told: dict[int, dict[str, list[float]]] = {}
    for _, width in itertools.product(range(ROUNDS), widths):
        _, found = run_of(width, f"{folder}/{width}", HERE, "print_alone")
        before = told.get(width, found)
        told[width] = {name: min(one, before[name]) for name, one in found.items()}  # of lists: by what comes first
    sets = [(widths[0], 1), *([widths] if len(widths) > 2 else [])]
    print(f"{'attempts with 1, 2, ... balls':44}{'us of one at ' + ', '.join(map(str, widths)):>28}", end="")
    print("".join(f"{' '.join(map(str, one)):>8}" for one in sets))
    for name, (_, *held) in told[widths[0]].items():
        seconds = {width: told[width][name][0] for width in widths}
        now = by_cheapest(held, {widths[0]: seconds[widths[0]]})
        words = f"{name}: {' '.join(f'{one:.0f}' for one in held)}"
        costs = ", ".join(f"{1e6 * one:.2f}" for one in seconds.values())
        shares = "".join(f"{by_cheapest(held, {one: seconds[one] for one in some}) / now:8.2f}" for some in sets)
        print(f"{words:44}{costs:>28}{shares}", flush=True)


def main(*cpus: str) -> None:
    """Prints a table a processor: widths, then what each problem takes."""
    from bearing_twin.charts.made import processor

    print(f"{processor()}, {date.today()}; CPU time over that of the width in use")
    with tempfile.TemporaryDirectory() as folder:
        print_narrower(folder)
    for cpu in cpus or (HERE, NARROW):
        least: dict[int, dict[str, float]] = {}
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(ROUNDS):
                for width in WIDTHS:
                    used, told = run_of(width, f"{folder}/{width}", cpu, "print_times")
                    seconds = {name: one for name, (one,) in told.items()}
                    before = least.get(width, seconds)
                    least[width] = {name: min(one, before[name]) for name, one in seconds.items()}
        words = f"processor: {cpu}; in use: {used}"
        print(f"{words:44}" + "".join(f"{width:>8}" for width in WIDTHS))
        for name, whole in least[used].items():
            print(f"{name:44}" + "".join(f"{least[width][name] / whole:8.2f}" for width in WIDTHS), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
