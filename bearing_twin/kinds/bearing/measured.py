"""What steppers, dimensions and friction cost and err in bearings, as measured: the tables that the chooser reads.

`bearing_twin chart steppers`, `chart motions`, `chart dimensions` and `chart bearing_friction` make them; they hold for
eight balls and contacts by `hertz`. Costs are CPU seconds a simulated second on the machine of the tables: only ratios
mean something. Evaluations are the same on every machine.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.motions import COUPLED, MOTIONS, SHARED, motions_of
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import EVEN, POCKETS, PRESCRIBED, QUASI_STATIC
from bearing_twin.kinds.bearing.stepping.integrate import REFERENCE_SHARE, SCIPY
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP
from bearing_twin.kinds.charted import measured_rows
from bearing_twin.numerics.steppers import ROSENBROCK

LOOSEST = 30.0  # times the wanted tolerance
LIKE_MEASURED = 30.0, 2.4  # what a scene of the same motion may err more: settings looser than wanted, and others
EVENTS = "sudden", "sliding"  # motions in which an error hangs on single events: where a ball that hops lands
BETWEEN = 1, 1.5, 2, 3, 5, 7  # settings in a decade, of which RUNGS are measured
RUNGS = "1.000", "3.000"
FINEST = 1e-9  # no setting is finer
LIKE_LANDING = "rodas4"  # the method whose steps end elsewhere where it lands
SPREAD = 1.0 / 3.0  # of costs: two tables of the same code lie that far apart (docs/models.md, Steppers)
RATES = {"seconds": 1000.0, "cost_at_100_hz": 100.0}  # outputs a second, by the columns of costs of dimensions
DIMENSIONS = QUASI_STATIC, PRESCRIBED
FIRST = 0.02  # s, which the table of motions counts by themselves
COUNTED = "ball_rates"  # what it counts, as the costs of a run name it
BALLS = 8  # of the bearings that the table of steppers counts
RIG = "rig"  # the problems of a bearing with clearance begin so


class Rung(NamedTuple):
    """A stepper at one setting of its tolerance: relative errors of load and friction, and cost."""

    setting: float
    load_error: float
    friction_error: float
    cost: float


class Prediction(NamedTuple):
    """A stepper for a scene: the tolerance it is given, what errors and cost it had in that motion when measured.

    Of what is `counted`, by its name in the costs of a run, it takes so many `at_start` and so many `a_second`.
    """

    motion: str
    stepper: str
    setting: float
    load_error: float
    friction_error: float
    cost: float
    counted: str = COUNTED
    at_start: float = 0.0
    a_second: float = 0.0


def error_of(measured: Rung | Prediction, outputs: str) -> float:
    """The error that counts for the outputs that are wanted."""
    return measured.load_error if outputs == LOADS else max(measured.load_error, measured.friction_error)


@functools.cache
def ladders() -> dict[tuple[str, str], tuple[Rung, ...]]:
    """(motion, stepper): its rungs from loose to tight; settings of fixed steps are in s.

    A scene has SciPy's methods tighter than the table, where they are contestants: settings are those of a scene. One
    that lands is the same method with other ends of steps: what it errs less at a setting is luck, and not read
    (docs/models.md). Nor is a setting that was looked for between RUNGS, where a method just keeps 1e-3.
    """
    found: dict[tuple[str, str], list[Rung]] = {}
    for row in (
        *measured_rows("steppers.csv"),
        *(row for row in measured_rows("motions.csv") if row["problem"] in COUPLED),
    ):
        if row["status"] == "done" and (row["method"] not in ROSENBROCK or _is_rung(row)):
            rung = (float(row[key]) for key in ("load_error", "friction_error", "seconds"))
            found.setdefault((row["problem"], row["method"]), []).append(Rung(_setting(row), *rung))
    for (motion, stepper), rungs in found.items():
        if stepper in ROSENBROCK and ROSENBROCK[stepper].lands:
            plain = {one.setting: one for one in found[motion, LIKE_LANDING]}
            found[motion, stepper] = [_no_better(one, plain.get(one.setting, one)) for one in rungs]
    return {key: tuple(sorted(rungs, reverse=True)) for key, rungs in found.items()}


def _is_rung(row: dict[str, str]) -> bool:
    return f"{float(row['setting']):.3e}".startswith(RUNGS)


def _setting(row: dict[str, str]) -> float:
    """That of a scene which runs as a row did."""
    return float(row["setting"]) / (REFERENCE_SHARE if row["method"] in SCIPY else 1.0)


@functools.cache
def counts() -> dict[tuple[str, str], np.ndarray]:
    """(motion, stepper): logarithms of setting, evaluations of a ball at the start and a second, settings rising.

    Of steppers that `chart motions` has not, those of `chart steppers`: stability holds their steps from the start on.
    """
    found: dict[tuple[str, str], list[tuple[float, float, float]]] = {}
    for row in measured_rows("motions.csv"):
        if row["status"] == "done" and row["problem"] in MOTIONS:
            first, later = (float(row[key]) / float(row["balls"]) for key in ("evaluations", "evaluations_a_second"))
            one = float(row["setting"]), max(first - FIRST * later, 1.0), max(later, 1.0)
            found.setdefault((row["problem"], row["method"]), []).append(one)
    for row in measured_rows("steppers.csv"):
        if row["status"] == "done" and row["method"] not in ROSENBROCK:
            one = _setting(row), 1.0, float(row["evaluations"]) / (BALLS * float(row["simulated"]))
            found.setdefault((row["problem"], row["method"]), []).append(one)
    return {key: np.log(sorted(rows)) for key, rows in found.items()}


def counted(balls: int, motions: tuple[str, ...], stepper: str, setting: float) -> tuple[float, float]:
    """How often the rates of so many balls will be evaluated at the start, and a second: most of these motions.

    Between settings, and beyond them, by powers of the setting; of fixed steps by their length.
    """
    most, wanted = np.zeros(2), math.log(setting)
    for motion in motions:
        logs = counts()[motion, stepper]
        if stepper in FIXED_STEP:
            found = logs[0, 1:] + (0.0, logs[0, 0] - wanted)
        elif len(logs) == 1:
            found = logs[0, 1:]
        else:
            at = min(max(int(logs[:, 0].searchsorted(wanted)), 1), len(logs) - 1)
            share = (wanted - logs[at - 1, 0]) / (logs[at, 0] - logs[at - 1, 0])
            found = logs[at - 1, 1:] + min(share, 1.0) * (logs[at, 1:] - logs[at - 1, 1:])
        most = np.maximum(most, np.exp(found))
    at_start, a_second = (most * balls).tolist()
    return at_start, a_second


def _no_better(rung: Rung, other: Rung) -> Rung:
    """A rung with the errors of another where those are greater."""
    errors = zip(rung[1:3], other[1:3], strict=True)
    return Rung(rung.setting, *(max(pair) for pair in errors), rung.cost)


@functools.cache
def _with_between(rungs: tuple[Rung, ...]) -> tuple[Rung, ...]:
    """Rungs with others between them, by the order measured there, and beyond, where errors fall as settings."""
    if not rungs:
        return ()
    logs, last, found = np.log(rungs[::-1]).T, rungs[-1], {rung.setting: rung for rung in rungs}
    for setting in (float(f"{one}e{power}") for power in range(-9, 0) for one in BETWEEN):
        if setting < last.setting:
            found[setting] = _scaled(last, setting / last.setting)
        elif setting < rungs[0].setting and setting not in found:
            at = (math.exp(np.interp(math.log(setting), logs[0], column)) for column in logs[1:])
            found[setting] = Rung(setting, *at)
    return tuple(sorted(found.values(), reverse=True))


def _scaled(rung: Rung, share: float) -> Rung:
    """A rung with this share of its setting, and of its errors."""
    return Rung(*(share * one for one in rung[:3]), rung.cost)


def _enough(rungs: tuple[Rung, ...], wanted: float, outputs: str, even: bool = True) -> Rung | None:
    """The loosest rung that keeps a tolerance LIKE_MEASURED times over; beyond the tightest errors fall as settings.

    Settings looser than wanted may lie between those measured in an `even` motion, none of EVENTS, where errors follow
    the order; others may not, as there is less room for luck.
    """
    looser, kept = (wanted / one for one in LIKE_MEASURED)
    for rung in _with_between(rungs) if even else rungs:
        if wanted < rung.setting <= LOOSEST * wanted and error_of(rung, outputs) <= looser:
            return rung
    for rung in rungs:
        if rung.setting <= wanted and error_of(rung, outputs) <= kept:
            return rung
    if not rungs:
        return None
    share = min(1.0, kept / error_of(rungs[-1], outputs))
    return _scaled(rungs[-1], share)._replace(setting=min(wanted, share * rungs[-1].setting))


def _no_tighter(rung: Rung, rungs: tuple[Rung, ...], wanted) -> Rung:
    """The rung, or that of the wanted tolerance where it is a tighter one.

    Balls that bump carry errors on: no setting keeps a tolerance for long, and the companion says up to when one does.
    """
    if rung.setting >= wanted.tolerance:
        return rung
    loose = [one for one in rungs if one.setting >= wanted.tolerance * (1.0 - 1e-9)]
    return (loose[-1] if loose else rungs[-1])._replace(setting=wanted.tolerance)


def as_cheap(rows: Sequence) -> list:
    """Those of the rows, which have a `cost`, that cost no more than SPREAD above the least, in the order given.

    Of these equals the first is to be taken: by a fixed order, lest the noise of a measurement decides.
    """
    least = min((one.cost for one in rows), default=0.0)
    return [one for one in rows if one.cost <= (1.0 + SPREAD) * least]


def steppers_of(motions: tuple[str, ...]) -> tuple[str, ...]:
    """Those that a scene like these motions may take: none that lands where balls share a step with each other."""
    shared = set(SHARED).intersection(motions)
    return tuple(name for name, one in ROSENBROCK.items() if not (shared and one.lands))


def predictions(parameters) -> list[Prediction]:
    """Each stepper at the loosest setting that keeps what is wanted in all motions the scene is like; best first.

    Those that are `as_cheap` lead, in the order of the table of steppers, which begins with `rodas4`; the others follow
    by their cost. The scene alone decides, not what runs: a node that is slow again comes back to what it began with.
    """
    found, motions, wanted = [], motions_of(parameters), parameters.wanted
    wanted_of, even = (wanted.tolerance, wanted.outputs), not {*EVENTS, *COUPLED}.intersection(motions)
    for stepper in steppers_of(motions):
        rungs = {one: _enough(ladders().get((one, stepper), ()), *wanted_of, even) for one in motions}
        if None in rungs.values():
            continue
        if POCKETS in motions:
            rungs = {one: _no_tighter(rung, ladders()[one, stepper], wanted) for one, rung in rungs.items()}
        # The motion that costs most decides; what it errs by at a setting tighter than its own is less than measured.
        motion, worst = max(rungs.items(), key=lambda one: one[1].cost)
        setting = max(FINEST, min(rung.setting for rung in rungs.values()))
        told = Prediction(motion, stepper, *worst._replace(setting=setting))
        at_start, a_second = counted(parameters.geometry.balls, motions, stepper, setting)
        found.append(told._replace(at_start=at_start, a_second=a_second))
    equals = as_cheap(found)
    return equals + sorted((one for one in found if one not in equals), key=lambda one: one.cost)


def friction_costs(parameters) -> dict[str, float]:
    """Cost of each friction model over that of `point`, at the tolerance measured nearest, under thrust or without."""
    problem, costs = "thrust" if parameters.drive.offset[2] else "settled", {}
    for row in measured_rows("bearing_friction.csv"):
        if row["problem"] == problem and row["status"] == "done":
            away = abs(math.log(float(row["setting"]) / parameters.wanted.tolerance))
            costs.setdefault(row["method"], []).append((away, float(row["seconds"])))
    nearest = {name: min(found)[1] for name, found in costs.items()}
    return {name: cost / nearest["point"] for name, cost in nearest.items()}


def method_of(dimension: str, cage: str) -> str:
    """How the chart of dimensions names a model of a bearing with clearance."""
    words = {"none": "no cage", EVEN: "even cage", POCKETS: "pockets"}[cage]
    return dimension if dimension == QUASI_STATIC else f"{dimension}, {words}"


def dimension_costs(parameters, share: float) -> dict[str, float]:
    """Cost of each measured dimension at the scene's output rate, of the nearest rows.

    With a cage those of the bearing with clearance, by speed; else those of the preloaded one, by whether there is a
    load across and by the centrifugal `share`. Between and beyond the two rates measured it is taken as a cost a second
    and one an output.
    """
    cage, across = parameters.cage.kind, any(parameters.drive.offset[:2])
    caged = cage != "none"
    methods = {method_of(one, cage) if caged else one: one for one in DIMENSIONS}
    wanted, nearest, found = max(abs(parameters.drive.speed), 1.0) if caged else max(share, 1e-3), math.inf, {}
    for row in measured_rows("dimensions.csv"):
        alike = row["problem"].startswith(RIG) == caged and (caged or ("across" in row["problem"]) == across)
        away = abs(math.log(float(row["setting"]) / wanted))
        if row["method"] not in methods or row["status"] != "done" or not alike or away > nearest + 1e-6:
            continue
        nearest = away
        high, low = (float(row[key]) for key in RATES)
        slope = (high - low) / (RATES["seconds"] - RATES["cost_at_100_hz"])
        base = max(0.0, low - slope * RATES["cost_at_100_hz"])
        found[methods[row["method"]]] = base + slope * parameters.run.output_rate
    return found
