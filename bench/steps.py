"""What balls step in short runs, and what of it are contacts: `python bench/steps.py [part of a problem ...]`.

The problems of `bearing_twin chart steppers` at the cheapest setting that is good enough there; then friction over the
spots beside friction at a point, and a held ring with an even cage beside none, at one tolerance. Balls alone step side
by side in lanes, each as often as it must: lanes are full where all step as often. CPU time is the least of several.
"""

import sys
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import numpy as np
from speed import kernel_time

from bearing_twin.charts.bearing_cells import Case, ready
from bearing_twin.charts.contest_picture import cheapest
from bearing_twin.charts.made import processor
from bearing_twin.charts.table import read_table
from bearing_twin.charts.work_precision import CASES, FINER, WANTED, StepperRow
from bearing_twin.kinds.bearing.stepping import rosenbrock
from bearing_twin.numerics.stretches import Stretches, alike

TABLE = Path(__file__).resolve().parent.parent / "docs" / "steppers.csv"
REPEATS = 20
SPOTS = ("settled", "sliding", "lift-off")
HELD = "drive.speed=157.08"


def problems() -> Iterator[tuple[str, Case, str, float]]:
    """What ran, the case, the stepper and its setting."""
    rows = read_table(TABLE, StepperRow)
    for name, case in CASES.items():
        best = min(filter(None, (cheapest(rows, name, one, WANTED) for one in FINER)), key=lambda row: row.seconds)
        yield name, case, best.method, best.setting
    for name in SPOTS:
        for friction in ("point", "spot"):
            more = (*CASES[name].overrides, f"contact.friction={friction}")
            yield f"{name}, {friction}", CASES[name]._replace(overrides=more), "rodas4", WANTED
    for cage in ("none", "even"):
        yield (
            f"held ring, cage {cage}",
            CASES["settled"]._replace(overrides=(HELD, f"cage.kind={cage}")),
            "rodas4",
            WANTED,
        )


def counted(motion, case: Case) -> tuple[dict[str, int], int]:
    """What a run of a motion counts, and the steps of the ball with most."""
    kept: list[Stretches] = []

    def keeping(*given) -> Stretches:
        kept.append(alike(*given))
        return kept[-1]

    rosenbrock.alike = keeping
    try:
        motion.reset()
        before = motion.costs()
        motion.advance(case.times, case.seconds)
    finally:
        rosenbrock.alike = alike
    return {name: count - before[name] for name, count in motion.costs().items()}, sum(one.taken for one in kept).max()


def least_seconds(motion, case: Case, times: np.ndarray) -> float:
    """CPU seconds of a run that gives out `times` [s]."""
    spans = []
    for _ in range(REPEATS):
        motion.reset()
        began = time.process_time()
        motion.advance(times, case.seconds)
        spans.append(time.process_time() - began)
    return min(spans)


def main(*words: str) -> None:
    """Prints a line a problem."""
    print(f"{processor()}, {date.today()}; of a ball, a mean but for the most steps; CPU time of all balls")
    print(
        f"{'':26}{'':26}"
        + "".join(f"{one:>10}" for one in ("attempts", "steps", "most", "rates", "CPU us", "contacts", "outputs"))
    )
    for name, case, stepper, setting in problems():
        if words and not any(word in name for word in words):
            continue
        motion = ready(case, stepper, setting)
        (counts, most), balls = counted(motion, case), len(motion.state)
        steps, whole = (least_seconds(motion, case, times) for times in (case.times[:0], case.times))
        contacts = 2e-9 * kernel_time(motion) * counts["ball_rates"]
        attempts = (counts["ball_steps"] + counts["ball_rejections"]) / balls
        each = attempts, counts["ball_steps"] / balls, most, counts["ball_rates"] / balls
        told = "".join(f"{one:10.0f}" for one in (*each, 1e6 * steps))
        shares = f"{100 * contacts / steps:8.0f} %{100 * (whole - steps) / whole:8.0f} %"
        what = f"{stepper}, {setting:g}, {1e3 * case.seconds:g} ms"
        print(f"{name:26}{what:26}{told}{shares}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
