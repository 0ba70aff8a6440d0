"""What lanes of other widths take: `python bench/lanes.py [processor ...]`, minutes, as each width compiles all steps.

Kernels are compiled for this machine's processor and for one whose instructions are 256 bits wide, or for those named,
as LLVM names them. Each width runs in a process of its own, with kernels of its own, one width after the other, several
times; told is the least CPU time over that of the width in use. rodas4, tolerance 1e-3.
"""

import os
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

WIDTHS, ROUNDS = (8, 4), 3
NARROW = "znver3"  # 256 bits, otherwise much like processors of its maker with 512
HERE = "this machine's"
# Before any other module takes what is set: rows, spans and kernels follow from it.
CHILD = """
from bearing_twin.numerics import lanes
used, lanes.LANES = lanes.LANES, {width}
lanes.STATE_SPAN = lanes.COLUMNS * lanes.LANES
from lanes import print_times
print_times(used)
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


def run_of(width: int, cache: str, cpu: str) -> tuple[int, dict[str, float]]:
    """The width in use on such a processor, and CPU seconds of the problems at `width`."""
    other = {} if cpu == HERE else {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": ""}
    there = os.environ | {"XDG_CACHE_HOME": cache} | other
    program = [sys.executable, "-c", CHILD.format(width=width)]
    said = subprocess.run(program, env=there, cwd=Path(__file__).parent, stdout=subprocess.PIPE, text=True, check=True)
    used, *lines = said.stdout.splitlines()
    return int(used), {name: float(seconds) for name, seconds in (line.split("\t") for line in lines)}


def main(*cpus: str) -> None:
    """Prints a table a processor: widths, then what each problem takes."""
    from bearing_twin.charts.made import processor

    print(f"{processor()}, {date.today()}; CPU time over that of the width in use")
    for cpu in cpus or (HERE, NARROW):
        least: dict[int, dict[str, float]] = {}
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(ROUNDS):
                for width in WIDTHS:
                    used, seconds = run_of(width, f"{folder}/{width}", cpu)
                    before = least.get(width, seconds)
                    least[width] = {name: min(one, before[name]) for name, one in seconds.items()}
        words = f"processor: {cpu}; in use: {used}"
        print(f"{words:44}" + "".join(f"{width:>8}" for width in WIDTHS))
        for name, whole in least[used].items():
            print(f"{name:44}" + "".join(f"{least[width][name] / whole:8.2f}" for width in WIDTHS), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
