"""What a tolerance is worth: the error asked for against the error got, and what the run itself says its error is.

Shipped bearing scenes, shortened, and variants of them, run as `simulate` runs them, against the same scene at a
tolerance so tight that it counts as true; then others that nothing of the companion was fitted to, some chosen later
still, and some held out while what all these showed was mended. Errors are those of the chart of steppers: of load over
the greatest load, of friction over mu N of a contact or mu N R of a ball. `reason` tells what failed. Rows of runs
`at length` have no errors: they tell what the companion takes (`companion_cost`).
"""

import contextlib
import functools
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.bearing_variants import ALL_CASES, GROUPS
from bearing_twin.charts.chart import Chart
from bearing_twin.charts.companion_cost import (
    LENGTHS,
    SHIPPED,
    at_length,
    counted,
    long_runs,
    much,
    steps_of,
    taken,
)
from bearing_twin.charts.contest import judged, tried
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE, Row
from bearing_twin.charts.tolerance_picture import FAR, NEAR, draw
from bearing_twin.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.numerics.steppers import NOTHING
from bearing_twin.run.passes import Run, simulate
from bearing_twin.run.scene import load_scene

EXACT = 1e-8
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
KNOWABLE = 1e-8  # true errors below this are not compared with estimates: the reference is no better ...
ROUGHER, CLEAR = 3.0, 3.0  # ... nor those up to so many times what the reference differs from a run so much rougher
OUTPUTS = {"loads": "load", "friction": "friction"}  # what their columns begin with
ALONE = "solver.companion=off"
METHOD, LOADS_ALONE = "as chosen", "loads alone"
# What differs from the case, of runs beside the truth and of those at length.
WANTED = {METHOD: (), LOADS_ALONE: (f"wanted.outputs={LOADS}",)}
LONG = dict(zip(LENGTHS, WANTED.values(), strict=True))


@dataclass(frozen=True)
class ToleranceRow(Row):
    """One run: true and estimated errors of load and friction, what it says of itself (`told`), and its steps.

    `load_known` and `friction_known` are the least errors that can be told from those of the reference. Of a run that
    names its `horizon` [s], all these are up to it, and `to_the_end` is the greatest error of the whole run.
    `steps` are those of a run that nobody watches, `watched_steps` those with what was done again, `companion_steps`
    the companion's, and `took` is what the run says took it where that is much; `seconds` are CPU seconds of the whole
    run, `evaluations` steps of balls.
    """

    load_estimate: float = np.nan
    friction_estimate: float = np.nan
    told: str = ""
    steps: int = 0
    watched_steps: int = 0
    companion_steps: int = 0
    load_known: float = KNOWABLE
    friction_known: float = KNOWABLE
    horizon: float = np.nan
    to_the_end: float = np.nan
    took: str = ""

    @property
    def kept(self) -> bool:
        """Whether the error is what was asked for."""
        return self.error <= self.setting

    @property
    def bounded(self) -> bool:
        """Whether the run names a horizon: beyond it nothing is promised."""
        return bool(np.isfinite(self.horizon))

    @property
    def doubtful(self) -> bool:
        """Whether the run says that its error is more; before its horizon, if it names one."""
        if self.bounded:
            return max(self.load_estimate, self.friction_estimate) > self.setting
        return self.told.startswith("doubtful")

    @property
    def missed(self) -> bool:
        """Whether it is more, as far as the reference knows, which may itself be off by more than what is wanted."""
        errors = (self.load_error, self.load_known), (self.friction_error, self.friction_known)
        return any(error > self.setting + (known if known > self.setting else 0.0) for error, known in errors)

    @property
    def ratios(self) -> list[float]:
        """Estimates over true errors, of those that can be known."""
        return [found / true for found, true in self.pairs]

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """Estimates and true errors, of those that can be known."""
        found = (
            (self.load_estimate, self.load_error, self.load_known),
            (self.friction_estimate, self.friction_error, self.friction_known),
        )
        return [(estimate, true) for estimate, true, known in found if true > known]


def words_of(case: str) -> tuple[str, ...]:
    """The scene of a case, and the overrides in which it differs from it."""
    scene, differs = ALL_CASES[case]
    return scene, *differs


def _run(scene: str, *overrides: str) -> tuple[Run, Rows]:
    """A run of a scene to its end, and all its outputs but the first."""
    run = simulate(load_scene(scene, overrides))
    blocks = list(run.blocks())
    return run, Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])


@functools.lru_cache(maxsize=1)
def _exact(scene: str, *differs: str) -> tuple[Rows, Rows]:
    """The outputs that count as true, and rougher ones, which tell how far these may be off.

    A process is at one case at a time.
    """
    return tuple(_run(scene, *differs, f"wanted.tolerance={one * EXACT!r}", ALONE)[1] for one in (1.0, ROUGHER))


def judge(case: str, method: str, tolerance: float, limit: float) -> ToleranceRow:
    """One run beside the truth, with what one of WANTED wants."""
    row = ToleranceRow(case, method, tolerance, command=_command(case, method, tolerance))
    if method in LONG:
        return tried(row, lambda: counted(case, LONG[method], tolerance), limit)
    return beside_truth(row, words_of(case), WANTED[method], limit)


def beside_truth(row: ToleranceRow, case: tuple[str, ...], wanted: tuple[str, ...], limit: float) -> ToleranceRow:
    """The row with a run of a case (`words_of`), at its setting and with what is `wanted`, beside the truth."""
    asked, exact = (*wanted, f"wanted.tolerance={row.setting!r}"), functools.partial(_exact, *case)
    with contextlib.suppress(BearingTwinError):  # which the run itself tells in its row
        exact()  # before time counts
    return judged(row, lambda: _outcome(case, asked, *exact()), limit)


def up_to(rows: Rows, outputs: int) -> Rows:
    """The first so many of these outputs."""
    return Rows(rows.layout, rows.numbers[:outputs])


def compared(run: Run, found: Rows, exact: Rows, rougher: Rows) -> dict:
    """Errors of a run and what it says of them, up to its horizon if it names one, and what can be known of them.

    Of outputs that are not wanted there is neither.
    """
    wanted, horizon = run.report.errors["wanted_errors"], run.report.errors.get("horizon_s", np.nan)
    motion, greatest = BearingMotion(run.scene.parameters, run.choice), float(exact.normal_load.max())
    told, outputs = "error", len(found.numbers)
    if np.isfinite(horizon):
        told, outputs = "error_up_to_horizon", int((1.0 + NOTHING) * horizon * run.scene.parameters.run.output_rate)
    first = [up_to(one, outputs) for one in (found, exact, rougher)]
    # Where the horizon is before the first output, nothing is promised and nothing is off.
    own, other = (errors(motion, one, first[1], greatest) if outputs else (0.0, 0.0) for one in (first[0], first[2]))
    numbers = zip(OUTPUTS, own, other, errors(motion, found, exact), strict=True)
    rows = {name: rest for name, *rest in numbers if name in wanted}
    columns = {"horizon": horizon, "to_the_end": max(whole for *_, whole in rows.values())}
    for name, (error, rough, _) in rows.items():
        column, estimate = OUTPUTS[name], wanted[name][told]
        columns[f"{column}_error"], columns[f"{column}_known"] = error, max(KNOWABLE, CLEAR * rough)
        columns[f"{column}_estimate"] = np.nan if estimate is None else estimate
    return columns


def _outcome(case: tuple[str, ...], asked: tuple[str, ...], exact: Rows, rougher: Rows) -> dict:
    start = time.thread_time()
    run, found = _run(*case, *asked)
    seconds = time.thread_time() - start
    try:
        plain = _run(*case, *asked, ALONE)[0].report.costs.get("ball_steps", 0)  # equilibria have no steps
    except IntegrationError:  # too rough where nobody watches: there is nothing to compare with
        plain = 0
    return compared(run, found, exact, rougher) | steps_of(run) | {"seconds": seconds, "steps": plain}


def _command(case: str, method: str, tolerance: float) -> str:
    scene, differs = at_length(case) if method in LONG else ALL_CASES[case]
    return command_of(scene, (*differs, *(WANTED | LONG)[method], f"wanted.tolerance={tolerance:g}"))


def _entries(case: str) -> Iterator[tuple[str, float]]:
    """Which (contestant, tolerance)s there are of a case, or of a scene as it ships."""
    methods = WANTED | LONG if case in ALL_CASES else LONG
    yield from ((method, tolerance) for method in methods for tolerance in TOLERANCES)


def _share(number: int, total: int) -> str:
    return f"{number} of {total}"


def reading(points: list[ToleranceRow]) -> Iterator[str]:
    """What the chart says of all, of groups of scenes, of all with loads alone wanted, and of long runs."""
    points, alone, long = ([p for p in points if p.method in one] for one in ({METHOD}, {LOADS_ALONE}, LONG))
    if good := [p for p in points if p.status == DONE]:
        yield f"All: {said(good)}"
        yield f"All: {nearness(good)}"
        yield f"All without a horizon: {nearness([p for p in good if not p.bounded])}"
    for who, cases in GROUPS.items():
        mine = [p for p in points if p.problem in cases]
        if mine:
            yield from (f"{who}: {sentence}" for sentence in _read_group(mine))
    if alone:
        good = [p for p in alone if p.status == DONE]
        yield from (f"Loads alone wanted: {sentence}" for sentence in (said(good), *unsaid(good), nearness(good)))
    yield from long_runs(long)


def said(good: list[ToleranceRow]) -> str:
    """What a run is worth that calls itself done."""
    done = [p for p in good if p.told == DONE]
    over = [p.error / p.setting for p in done if p.missed]
    furthest = f"; the furthest of the others is off by {max(over):.2g} times it" if over else ""
    kept = sum(p.kept for p in done)
    return f"of runs that call themselves done {_share(kept, len(done))} are within their tolerance{furthest}."


def unsaid(good: list[ToleranceRow]) -> Iterator[str]:
    """Which runs miss their tolerance and do not say so."""
    if found := [p for p in good if p.missed and not p.doubtful]:
        yield "unsaid are " + "; ".join(f"{p.problem} at {p.setting:g}, {p.error:.2g}" for p in found) + "."


def unknown(good: list[ToleranceRow]) -> Iterator[str]:
    """Which runs may miss their tolerance or not, and whether they say so."""
    if lost := [p for p in good if not p.kept and not p.missed]:
        told = ", ".join(dict.fromkeys(p.problem for p in lost)), _share(sum(p.doubtful for p in lost), len(lost))
        yield "in {} runs nobody knows, as the reference is off by more ({}); doubtful are {}.".format(len(lost), *told)


def nearness(good: list[ToleranceRow]) -> str:
    """How near estimates are to true errors."""
    ratios = np.array([ratio for p in good for ratio in p.ratios])
    if not len(ratios):
        return "no true error is known."
    near, low, high = (ratios > 1.0 / NEAR) & (ratios < NEAR), ratios < 1.0 / FAR, ratios > FAR
    return (
        f"estimates are within a factor {NEAR:g} of the true error in {_share(int(near.sum()), len(ratios))} "
        f"({100.0 * near.mean():.3g} %), less than a tenth of it in {int(low.sum())}, more than {FAR:g} times it in "
        f"{int(high.sum())}; their median is {np.median(ratios):.2g} times it."
    )


def _read_group(points: list[ToleranceRow]) -> Iterator[str]:
    good = [p for p in points if p.status == DONE]
    missed, kept = [p for p in good if p.missed], [p for p in good if p.kept]
    yield f"the error is within the tolerance in {_share(len(kept), len(points))} runs."
    if bounded := [p for p in good if p.bounded]:
        names, cells = ", ".join(dict.fromkeys(p.problem for p in bounded)), _share(len(bounded), len(good))
        held = _share(sum(p.to_the_end <= p.setting for p in bounded), len(bounded))
        yield f"{cells} name a horizon and are compared up to it ({names}); within the tolerance to the end are {held}."
    yield from unknown(good)
    if missed:
        doubtful = sum(p.doubtful for p in missed)
        worst = max(p.error / p.setting for p in missed)
        yield (
            f"where it is more, the run calls itself doubtful in {_share(doubtful, len(missed))}; the "
            f"greatest error is {worst:.2g} times the tolerance."
        )
    yield from unsaid(good)
    yield from (f"{p.problem} at {p.setting:g}: {p.reason}" for p in points if p.status != DONE)
    if not good:
        return
    yield nearness(good)
    costs = [(p.companion_steps + p.watched_steps) / p.steps for p in good if p.steps]
    yield (
        f"the companion takes {taken(good)}; with what is done again a run takes {np.median(costs):.2g} times the "
        f"steps of one that nobody watches, {max(costs):.2g} at most."
    )
    yield f"it takes {much(good)}."


CONTESTS = {
    "tolerance": Chart(
        judge=judge,
        problems={name: name for name in (*ALL_CASES, *SHIPPED)},
        entries=_entries,
        kind=ToleranceRow,
        command=_command,
        drawn=draw,
        told=reading,
    )
}
