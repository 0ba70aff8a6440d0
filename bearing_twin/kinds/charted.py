"""What methods of kinds beside the bearing err and cost, as charted: rows for their choosers, and sentences on them.

`bearing_twin chart pairs`, `chart beams`, `chart two_bodies` and `chart discs` make the tables. Costs are CPU seconds
of a run on the machine of the tables: only ratios mean something. Evaluations and steps are the same everywhere.
"""

import csv
import functools
import math
from typing import NamedTuple

from bearing_twin.paths import share_path
from bearing_twin.units import two_digits

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
def charted(table: str, problem: str) -> tuple[Charted, ...]:
    """What was done of a problem in a table."""
    with share_path("config", "measured", f"{table}.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["problem"] == problem and row["status"] == "done"]
    keys = ("setting", "load_error", "seconds", "evaluations")
    return tuple(Charted(problem, row["method"], *(float(row[key]) for key in keys)) for row in rows)


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


def predicted(row: Charted | None, counted: str = "", at_start: float = 0.0, a_second: float = 0.0) -> dict | None:
    """What a choice foretells by a row: its error of the force and cost; what is `counted` of a run, where anything is.

    That is so much `at_start` and so much `a_second`, by its name in the costs of a run. None without a row.
    """
    if row is None:
        return None
    told = {"motion": row.problem, "stepper": row.method, "setting": row.setting}
    told |= {"force_error": row.error, "cost": row.seconds}
    return told | ({"counted": counted, "at_start": at_start, "a_second": a_second} if counted else {})
