"""Equilibria against balls that move by themselves: error against cost, over speed and load.

A preloaded 6203 without gravity, its inner ring held where equilibrium puts it under the load. Speeds are those at
which the centrifugal load of the ball with most of it is a given share of its load on the inner raceway. Truth is the
motion of the balls at a tolerance a thousand times tighter than by default, early, when the axes of the balls' spin
are those of rolling, and late: under thrust once they have settled, with a load across, in an even cage without which
balls drift, 2 s after the start. Equilibria are taken with the balls where that motion has them. `rk4` checks the
truth early at every load, at one speed. `setting` is the share, the errors of load and angle are the late ones,
seconds those of a simulated second with 1000 outputs.
"""

import math

import numpy as np

from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import ring, without_result
from bearing_twin.charts.dimension_row import DimensionRow, worst
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE
from bearing_twin.charts.timing import Timing, timed
from bearing_twin.kinds.bearing.controls import SHARED
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    EquilibriumSolver,
    Support,
    controlled,
    load_line,
    setting_of,
    solver_of,
)
from bearing_twin.kinds.bearing.rings import EVEN, PRESCRIBED, QUASI_STATIC
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene
from bearing_twin.units import two_digits

SCENE, LAW = "bearing_6203", "hertz"
LOADS = {  # N on the inner ring, thrust last
    "20 N thrust": (0.0, 0.0, 20.0),
    "100 N thrust": (0.0, 0.0, 100.0),
    "500 N thrust": (0.0, 0.0, 500.0),
    "100 N thrust, 60 N across": (0.0, -60.0, 100.0),
}
SHARES = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0, 1.4)  # centrifugal load over load on the inner raceway
STEPPERS = {QUASI_STATIC: QUASI_STATIC, PRESCRIBED: "rodas4"}
TOLERANCE, FINEST = 1e-3, 1e-6
EARLY, LATE = 0.02, 2.0  # s after a start with the balls rolling
SETTLES = 10.0  # of the times in which an axis of spin turns
PART = 1.0  # s that are computed in one go
RATES = (1000.0, 100.0)  # outputs a second
SPAN, ENOUGH = 0.2, 0.1  # s of each timed run, and of a timing
NOTHING = 1e-15  # m: an offset below it is rounding
FASTEST = 2e4  # rad/s: no speed beyond it is looked for
LEAST = 1e-7  # smaller errors are drawn here

AGAIN, AGAIN_AT, AGAIN_STEP = "rk4", 0.3, 2e-7  # the check, its share, its step [s]


def _keys(speed: float, offset=(0.0, 0.0, 0.0), tolerance: float = TOLERANCE, *more: str) -> tuple[str, ...]:
    place = ",".join(f"{one:.12g}" if abs(one) > NOTHING else "0" for one in offset)
    driven = f"drive.speed={speed!r}", f"drive.offset=[{place}]"
    return ("gravity=[0,0,0]", *driven, f"wanted.tolerance={tolerance!r}", *more)


def _parameters(speed: float, offset=(0.0, 0.0, 0.0), tolerance: float = TOLERANCE, *more: str):
    return load_scene(SCENE, (*_keys(speed, offset, tolerance, *more), "solver.companion=off")).parameters


def _balance(load, speed: float):
    """The equilibrium under this load [N] with the tilts held, ball 0 on the load line."""
    support = Support((True, True, True, False, False), (*load, 0.0, 0.0), (0.0,) * 5)
    return solver_of(_parameters(speed), LAW, load_line(support)).solve(support)


def _share(found) -> float:
    """The greatest centrifugal load over the load on the inner raceway; infinite where a ball has none."""
    load = found.contacts.load[:, 0]
    return float((found.contacts.centrifugal / load).max()) if load.min() > 0.0 else math.inf


def _speed_of(load, share: float) -> float:
    """The speed [rad/s] at which the centrifugal load is this share of the load on the inner raceway."""
    low, high = 0.0, FASTEST
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _share(_balance(load, middle)) < share else (low, middle)
    return low


def _across(name: str) -> bool:
    return any(LOADS[name][:2])


def late(parameters, name: str, share: float) -> float:
    """When after a start [s] a late look is taken.

    An axis of spin turns as exp(-t/tau), tau = 5 mu Q d_m/(2 F_c s) ; with a load across
    a look is taken at LATE.
    """
    contact = parameters.contact
    tau = 2.5 * contact.friction_coefficient * parameters.geometry.pitch_diameter
    tau /= contact.friction_regularisation * share
    return LATE if _across(name) else max(LATE, SETTLES * tau)


def _moved(motion, instant: float) -> tuple:
    """Azimuths, loads and angles of a motion at an instant [s] after its start."""
    motion.reset()
    parts = max(1, math.ceil(instant / PART))
    for _ in range(parts):
        out = motion.advance(np.array([instant / parts]), instant / parts)
    return out.orbit_angle[-1], out.normal_load[-1], np.abs(out.contact_angle[-1])


def _motion(stepper: str, parameters):
    return bearing_motion(parameters, Choice(LAW, stepper, 0.0, "", ()))


def _static(parameters, azimuths):
    """Loads and angles in balance with the balls at these azimuths, the ring held."""
    held = Support((False,) * 5, (0.0,) * 5, (*parameters.drive.offset, 0.0, 0.0))
    solver = EquilibriumSolver(setting_of(parameters, LAW, parameters.drive.speed), azimuths)
    found = controlled(parameters, solver, held)
    return found.contacts.load, np.abs(found.contacts.angle)


def _errors(found, exact) -> list[float]:
    """Greatest differences of loads and of angles, each over the greatest."""
    return [float(np.abs(a - b).max() / np.abs(b).max()) for a, b in zip(found, exact, strict=False)]


def _cost(motion, rate: float) -> Timing:
    """CPU seconds a simulated second of a motion that is under way."""
    times = np.arange(1, round(SPAN * rate) + 1) / rate
    cost = timed(lambda: motion.advance(times, SPAN), ENOUGH)[1]
    return cost._replace(seconds=cost.seconds / SPAN)


def judge(name: str, share: float, limit: float) -> list[DimensionRow]:
    """Both dimensions at one load and one share of centrifugal load, and at one share the check of the truth."""
    with limited(limit):
        load = LOADS[name]
        speed = _speed_of(load, share)
        offset = tuple(_balance(load, speed).coordinates[:3].tolist())
        truth, found, cage = [], {QUASI_STATIC: [], PRESCRIBED: []}, (f"cage.kind={EVEN}",) if _across(name) else ()
        settles = late(_parameters(speed), name, share)
        for instant, spaced in ((EARLY, ()), (settles, cage)):
            then = f"model.control={SHARED}"
            exact = _motion(STEPPERS[PRESCRIBED], _parameters(speed, offset, FINEST, *spaced))
            truth.append(_moved(exact, instant))
            given = _parameters(speed, offset, TOLERANCE, then, *spaced)
            found[QUASI_STATIC].append(_static(given, truth[-1][0]))
            moving = _motion(STEPPERS[PRESCRIBED], _parameters(speed, offset, TOLERANCE, *spaced))
            found[PRESCRIBED].append(_moved(moving, instant)[1:])
        if cage:  # costs are of balls without one
            moving = _motion(STEPPERS[PRESCRIBED], _parameters(speed, offset))
            _moved(moving, settles)
        motions = {QUASI_STATIC: _motion(QUASI_STATIC, given), PRESCRIBED: moving}
        motions[QUASI_STATIC].first_outputs()
        rows = [_row(name, dimension, share, speed, pairs, truth, motions) for dimension, pairs in found.items()]
        rows[-1] = rows[-1].but(command=command_of(SCENE, _keys(speed, offset, TOLERANCE, *cage)))
        if share == AGAIN_AT:
            again = f"model.control={SHARED}", f"solver.step={AGAIN_STEP!r}"
            _, *early = _moved(_motion(AGAIN, _parameters(speed, offset, TOLERANCE, *again)), EARLY)
            rows.append(_row(name, AGAIN, share, speed, [early], truth, {}))
        return rows


def _row(name, dimension, share, speed, pairs, truth, motions) -> DimensionRow:
    """Errors of pairs (loads, angles), early and late or early alone, and the costs of a motion under way."""
    errors = [_errors(pair, exact) for pair, (_, *exact) in zip(pairs, truth, strict=False)]
    row = DimensionRow(name, dimension, share, status=DONE, speed=speed)
    row = row.but(early_load_error=errors[0][0], early_angle_error=errors[0][1])
    if dimension not in motions:
        return row
    high, low = (_cost(motions[dimension], rate) for rate in RATES)
    return row.but(load_error=errors[1][0], angle_error=errors[1][1], cost_at_100_hz=low.seconds, **high._asdict())


def reading(points: list[DimensionRow]) -> list[str]:
    """What these rows say: how far equilibria hold, what settles late, and what each dimension costs."""
    shares = [one for one in (0.1, 0.3, 1.4) if any(p.setting <= one for p in points)]
    across = [p for p in points if _across(p.problem)]
    thrust = [p for p in points if p not in across]
    both = [(some, words) for some, words in ((thrust, "under thrust"), (across, "with a load across")) if some]

    def upto(some, key):
        return ", ".join(f"{worst(some, QUASI_STATIC, key, one):.1g} up to {one:g}" for one in shares)

    def angles(key):
        return "; ".join(f"{words} by {upto(some, key)}" for some, words in both)

    costs = (
        f"{dimension} {_cost_of(points, dimension, 'seconds')} ms ({_cost_of(points, dimension, 'cost_at_100_hz')} ms)"
        for dimension in STEPPERS
    )
    off = (f"{worst(some, PRESCRIBED, 'load_error'):.1g} {words}" for some, words in both)
    return [
        "Preloaded 6203, quasi_static against the settled motion of the balls, by centrifugal load over load on the "
        f"inner raceway: loads off by {upto(points, 'load_error')}.",
        f"Contact angles: {angles('angle_error')}.",
        f"{1e3 * EARLY:g} ms after a start in rolling, with such axes: loads "
        f"{upto(points, 'early_load_error')}; angles {angles('early_angle_error')}.",
        f"prescribed at its default tolerance: loads off by at most {' and '.join(off)}, in an even cage.",
        f"CPU time of a simulated second with 1000 outputs (with 100): {', '.join(costs)}.",
        *_again(points),
    ]


def _cost_of(points, dimension, key) -> str:
    found = [1e3 * getattr(p, key) for p in points if p.method == dimension and p.status == DONE]
    return " to ".join(map(two_digits, (min(found), max(found)))) if found else "nan"


def _again(points):
    """How near another method comes to the truth."""
    off = [max(p.early_load_error, p.early_angle_error) for p in points if p.method == AGAIN]
    if off:
        yield (
            f"The truth is found again by {AGAIN} at steps of {1e6 * AGAIN_STEP:g} µs, {1e3 * EARLY:g} ms after the "
            f"start, to {max(off):.1g} in loads and angles, at {len(off)} loads."
        )


def _over_speed(axis, points, keys) -> None:
    """Errors of equilibria over the share of centrifugal load: settled in full lines, early in dashes."""
    for number, load in enumerate(dict.fromkeys(p.problem for p in points)):
        mine = [p for p in points if p.problem == load and p.method == QUASI_STATIC]
        shares = [p.setting for p in mine]
        for key, dashes in zip(keys, ("-", ":"), strict=True):
            errors = [max(getattr(p, key), LEAST) for p in mine]
            look = ball_line(number) | {"linestyle": dashes}
            axis.plot(shares, errors, "o", **look, markersize=4, label=load if dashes == "-" else None)
    axis.set(xscale="log", yscale="log", xlabel="centrifugal load / load on the inner raceway")


def draw(points: list[DimensionRow], axes) -> None:
    """Errors of load and of angle over speed, and error against cost of both dimensions, on three axes."""
    load, angle, cost = axes
    _over_speed(load, points, ("load_error", "early_load_error"))
    _over_speed(angle, points, ("angle_error", "early_angle_error"))
    heading(load, "preloaded, ring held: ball loads of equilibria", up="greatest error, over the greatest")
    heading(angle, "contact angles of equilibria")
    load.plot([], [], color=STYLE["soft"], linestyle="-", label="late, settled")
    load.plot([], [], color=STYLE["soft"], linestyle=":", label="after 20 ms")
    load.legend(loc="upper left", frameon=False, fontsize=11)
    angle.legend(
        *([one[-1:] for one in angle.get_legend_handles_labels()]), loc="upper left", frameon=False, fontsize=11
    )
    for number, dimension in enumerate(STEPPERS):
        for key, marker, rate in (("seconds", "o", RATES[0]), ("cost_at_100_hz", "^", RATES[1])):
            mine = [p for p in points if p.method == dimension and p.status == DONE]
            cost.plot(
                [getattr(p, key) for p in mine],
                [max(p.load_error, p.angle_error, LEAST) for p in mine],
                marker,
                color=ball_line(number)["color"],
                markersize=6,
                label=f"{dimension}, {rate:g} outputs a second",
            )
            timed_here = mine if key == "seconds" else []
            ring(cost, timed_here, lambda p: (p.seconds, max(p.load_error, p.angle_error, LEAST)), STYLE["ink"])
    without_result(cost, points)
    cost.set(xscale="log", yscale="log", xlabel="CPU seconds a simulated second")
    heading(cost, "late, loads and angles, against cost")
    keys = cost.get_legend_handles_labels()
    cost.figure.legend(*keys, loc="outside lower right", ncols=len(keys[0]), frameon=False, fontsize=11)
    for axis in axes:
        frame(axis)
