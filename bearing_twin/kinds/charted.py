"""What methods of kinds beside the bearing err and cost, as charted: rows for their choosers, and sentences on them.

`bearing_twin chart pairs`, `chart beams`, `chart two_bodies`, `chart discs` and `chart motions` make the tables. Costs
are CPU seconds of a run, or of a simulated second, on the machine of the tables: only ratios mean something.
Evaluations and steps are the same everywhere.
"""

import csv
import functools
import math
from typing import NamedTuple

from bearing_twin.paths import share_path
from bearing_twin.units import two_digits

EVEN_SHAFT, UNEVEN_SHAFT, KNOCKED_SHAFT = "shaft, loads alike", "shaft, loads differ", "shaft, load jumps"
HURRIED_SHAFT, TUMBLES = "shaft, speed changes", "ellipsoid bounces"
BODIES = EVEN_SHAFT, UNEVEN_SHAFT, KNOCKED_SHAFT, HURRIED_SHAFT, TUMBLES
"""Problems of `chart motions` that are no bearing alone."""
SPREAD = 1.0 / 3.0  # of costs, as between two tables of the same code (docs/models.md, Steppers)


class Charted(NamedTuple):
    """One row: problem, method, its setting, the relative error of the force, CPU seconds, evaluations or steps."""

    problem: str
    method: str
    setting: float
    error: float
    seconds: float
    evaluations: float


@functools.cache
def measured_rows(name: str) -> list[dict[str, str]]:
    """The rows of a table in `config/measured`, as text by column."""
    with share_path("config", "measured", name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@functools.cache
def charted(table: str, problem: str) -> tuple[Charted, ...]:
    """What was done of a problem in a table."""
    rows = [row for row in measured_rows(f"{table}.csv") if row["problem"] == problem and row["status"] == "done"]
    keys = ("setting", "load_error", "seconds", "evaluations")
    return tuple(Charted(problem, row["method"], *(float(row[key]) for key in keys)) for row in rows)


class Evaluations(NamedTuple):
    """Evaluations at the start, a second later, and for each turn of a shaft or touch of an ellipsoid then."""

    at_start: float
    a_second: float
    an_event: float


@functools.cache
def _evaluations() -> dict[tuple[str, str, float], Evaluations]:
    """By problem, method and setting, of those that are no bearing alone."""
    rows = [row for row in measured_rows("motions.csv") if row["problem"] in BODIES and row["status"] == "done"]
    found = {}
    for row in rows:
        span = float(row["simulated"])
        a_second, events = float(row["evaluations_a_second"]), float(row["events_a_second"])
        counts = Evaluations(max(float(row["evaluations"]) - span * a_second, 0.0), a_second, a_second / events)
        found[row["problem"], row["method"], float(row["setting"])] = counts
    return found


def evaluations_of(row: Charted) -> Evaluations:
    """What a run like this row of the motions evaluates."""
    return _evaluations()[row.problem, row.method, row.setting]


def row_of(table: str, problem: str, method: str, setting: float) -> Charted | None:
    """The row of a method whose setting is nearest, as a ratio; None where it was not measured."""
    mine = [row for row in charted(table, problem) if row.method == method]
    return min(mine, key=lambda row: abs(math.log(row.setting / setting)), default=None)


def runner_up(table: str, row: Charted, wanted: float, same: tuple[str, ...] = ()) -> Charted | None:
    """The cheapest row of another method, none of `same`, that errs by at most what is wanted, or the row does."""
    enough, own = max(wanted, row.error), (row.method, *same)
    others = [one for one in charted(table, row.problem) if one.method not in own and one.error <= enough]
    return min(others, key=lambda one: one.seconds, default=None)


def in_words(table: str, row: Charted | None, wanted: float, tuned_by: str = "at", same: tuple[str, ...] = ()) -> str:
    """What a choice says of the row that speaks for it, and of its runner-up; "" for none."""
    if row is None:
        return ""
    other = runner_up(table, row, wanted, same)
    said = f"its forces were off by {two_digits(row.error)} where measured ({row.problem}, {tuned_by} {row.setting:g})"
    if other is None:
        return f"{said}; no other method measured there kept {wanted:g}"
    times, also = other.seconds / row.seconds, f"{other.method} {tuned_by} {other.setting:g}"
    if times > 1.0 + SPREAD:
        return f"{said}; next came {also} at {times:.3g} times its cost"
    return f"{said}; {also} {'cost the same' if times * (1.0 + SPREAD) > 1.0 else f'takes {times:.2g} times its cost'}"


def predicted(
    row: Charted | None,
    counted: str = "",
    at_start: float = 0.0,
    a_second: float = 0.0,
    a_touch: float = 0.0,
    output: str = "force",
) -> dict | None:
    """What a choice foretells by a row: its error of an `output` and cost; what is `counted` of a run, if anything is.

    That is so much `at_start`, so much `a_second`, and so much `a_touch` of those that a run will have, by its name in
    the costs of a run. None without a row.
    """
    if row is None:
        return None
    told = {"motion": row.problem, "stepper": row.method, "setting": row.setting}
    told |= {f"{output}_error": row.error, "cost": row.seconds}
    each = {"a_touch": a_touch} if a_touch else {}
    return told | ({"counted": counted, "at_start": at_start, "a_second": a_second} | each if counted else {})
