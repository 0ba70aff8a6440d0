"""Dimensions and cages of a loaded bearing with clearance: error against cost, over speed and load.

The 6203 of the test rig with 10 um of clearance under a load down: equilibria, moving balls round a ring that is held
where equilibrium puts it, and round a ring with mass, each without a cage, with an even one and with one of pockets.
Truth is the fullest of them, a ring with mass and pockets, at a tolerance a hundred times tighter. Balls of different
models are at different places after a while, so that means over the last part of the run are compared: the greatest
load of a ball (mean of all balls), the orbit speed, and the ring: its displacement, or its force where it is held.
Truth is checked by another stepper. `setting` is the speed, seconds are those of a simulated second with 1000 outputs.
"""

import math
import time
from typing import NamedTuple

import numpy as np
from matplotlib.ticker import NullLocator

from bearing_twin.charts.contest import limited
from bearing_twin.charts.contest_picture import without_result
from bearing_twin.charts.dimension_row import DimensionRow, worst
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE
from bearing_twin.kinds.bearing.measured import method_of
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, PRESCRIBED, QUASI_STATIC
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene
from bearing_twin.units import two_digits

SCENE, LAW, STEPPER = "bearing_6203_rig_1000N", "hertz", "rodas4"
PROBLEMS = {"rig, 400 N": 400.0, "rig, 1000 N": 1000.0}  # down
SPEEDS = (94.2478, 157.0796, 628.3185)  # rad/s: 900, 1500 and 6000 rpm
NONE = "none"
MODELS = (
    (QUASI_STATIC, EVEN),
    *((dimension, cage) for dimension in (PRESCRIBED, FREE_RING) for cage in (NONE, EVEN, POCKETS)),
)
FULLEST = FREE_RING, POCKETS
TOLERANCE, FINEST = 1e-3, 1e-5
SPAN, LATE, RATE = 0.3, 0.2, 1000.0  # s of a run, of its last part, outputs a second
FEW = 100.0  # outputs a second of another timing
CHUNK = 20  # outputs at a time
ERRORS = {"load_error": "greatest ball load", "orbit_error": "orbit speed", "ring_error": "ring's place or force"}
MARKERS = {NONE: "o", EVEN: "s", POCKETS: "^"}
RPM = 30.0 / math.pi  # revolutions a minute of 1 rad/s
LEAST = 1e-7  # smaller errors are drawn here


AGAIN = "rodas3"  # the stepper that checks the truth


class Means(NamedTuple):
    """Of a run's last part: greatest ball load [N], orbit speed [rad/s], ring's y [m], its force [N]; CPU costs."""

    load: float
    orbit: float
    place: float
    force: float
    cost: float
    cost_at_100_hz: float


def _keys(model, load: float, speed: float, tolerance: float, place: float) -> tuple[str, ...]:
    """What differs from the rig in this dimension and cage; a ring that is held stands at y = `place` [m]."""
    dimension, cage = model
    base = load_scene(SCENE).parameters
    weight = base.rings.inner.mass * base.gravity[1]  # equilibria know loads alone
    down = {QUASI_STATIC: weight - load, PRESCRIBED: 0.0, FREE_RING: -load}[dimension]
    keys = (f"model.dimension={dimension}", f"rings.inner.load=[0,{down},0]", f"cage.kind={cage}")
    rest = f"drive.speed={speed}", f"wanted.tolerance={tolerance}", "solver.companion=off"
    held = (f"drive.offset=[0,{place},0]",) if dimension == PRESCRIBED else ()
    return *keys, *rest, *held


def run_means(
    model, load: float, speed: float, tolerance: float = TOLERANCE, place: float = 0.0, stepper: str = STEPPER
) -> Means:
    """The means of one run; `place` [m] as above."""
    given = load_scene(SCENE, _keys(model, load, speed, tolerance, place)).parameters
    choice = Choice(LAW, QUASI_STATIC if model[0] == QUASI_STATIC else stepper, 0.0, "", ())
    motion, times, spent = bearing_motion(given, choice), np.arange(1, CHUNK + 1) / RATE, 0.0
    motion.first_outputs()
    found: dict[str, list] = {"normal_load": [], "orbit_angle": [], "inner_ring_offset": [], "inner_ring_force": []}
    chunks = round(SPAN * RATE / CHUNK)
    for chunk in range(chunks):
        start = time.thread_time()
        out = motion.advance(times, CHUNK / RATE)
        spent += time.thread_time() - start if chunk else 0.0  # the first may wait for a compiler
        if (chunk + 1) * CHUNK / RATE > SPAN - LATE:
            for name, kept in found.items():
                kept.append(np.array(getattr(out, name)))
    start = time.thread_time()
    motion.advance(np.arange(1, round(SPAN * FEW)) / FEW, SPAN)
    few = (time.thread_time() - start) / SPAN
    late = {name: np.concatenate(kept) for name, kept in found.items()}
    seconds = (len(late["orbit_angle"]) - 1) / RATE
    return Means(
        float(late["normal_load"].max(axis=(0, 2)).mean()),
        float((late["orbit_angle"][-1] - late["orbit_angle"][0]).mean() / seconds),
        float(late["inner_ring_offset"][:, 1].mean()),
        float(late["inner_ring_force"][:, 1].mean()),
        spent / (chunks - 1) * RATE / CHUNK,
        few,
    )


def _off(value: float, exact: float) -> float:
    return abs(value / exact - 1.0)


def judge(name: str, speed: float, limit: float) -> list[DimensionRow]:
    """All models at one load and speed, and the check of the truth; the limit is of each."""
    load, rows = PROBLEMS[name], []
    with limited(2.0 * limit):
        truth = run_means(FULLEST, load, speed, FINEST)
    place = run_means((QUASI_STATIC, EVEN), load, speed).place
    for model in MODELS:
        with limited(limit):
            found = run_means(model, load, speed, place=place)
        command = command_of(SCENE, (*_keys(model, load, speed, TOLERANCE, place), f"run.duration={SPAN}"))
        rows.append(_row(name, method_of(*model), speed, found, truth, model[0] == PRESCRIBED).but(command=command))
    with limited(2.0 * limit):
        again = run_means(FULLEST, load, speed, FINEST, stepper=AGAIN)
    return [*rows, _row(name, AGAIN, speed, again, truth, False)]


def _row(name, method, speed, found, truth, held) -> DimensionRow:
    ring = _off(found.force, truth.force) if held else _off(found.place, truth.place)
    return DimensionRow(
        name,
        method,
        speed,
        load_error=_off(found.load, truth.load),
        seconds=found.cost,
        cost_at_100_hz=found.cost_at_100_hz,
        status=DONE,
        speed=speed,
        orbit_error=_off(found.orbit, truth.orbit),
        ring_error=ring,
    )


def reading(rows: list[DimensionRow]) -> list[str]:
    """What each model errs by and costs, one sentence each, and how near another stepper comes to the truth."""
    said = []
    for method in (method_of(*model) for model in MODELS):
        costs = [1e3 * row.seconds for row in rows if row.method == method]
        if not costs:
            continue
        errors = ", ".join(f"{words} {100.0 * worst(rows, method, key):.2g} %" for key, words in ERRORS.items())
        cost = f"{two_digits(min(costs))} to {two_digits(max(costs))} ms a second"
        said.append(f"Rig, {method}: off by at most: {errors}; {cost}.")
    if any(row.method == AGAIN and row.status == DONE for row in rows):
        errors = ", ".join(f"{words} {worst(rows, AGAIN, key):.1g}" for key, words in ERRORS.items())
        said.append(f"The truth of the rig is found again by {AGAIN} at the same tolerance to: {errors}.")
    return said


def draw(rows: list[DimensionRow], axes) -> None:
    """Errors of ball load and orbit speed over speed, and the worst error against cost, on three axes."""
    load, orbit, cost = axes
    dimensions = list(dict.fromkeys(dimension for dimension, _ in MODELS))
    for model in MODELS:
        mine = [row for row in rows if row.method == method_of(*model) and row.status == DONE]
        if not mine:
            continue
        look = {"color": ball_line(dimensions.index(model[0]))["color"], "marker": MARKERS[model[1]], "markersize": 7}
        for name, dashes in zip(PROBLEMS, ("-", ":"), strict=True):
            some = [row for row in mine if row.problem == name]
            for axis, key in ((load, "load_error"), (orbit, "orbit_error")):
                rpm = [row.setting * RPM for row in some]
                axis.plot(rpm, [max(getattr(row, key), LEAST) for row in some], **look, linestyle=dashes)
        most = [max(*(getattr(row, key) for key in ERRORS), LEAST) for row in mine]
        cost.plot([row.seconds for row in mine], most, **look, linestyle="none", label=method_of(*model))
    without_result(cost, rows)
    for axis in (load, orbit):
        axis.set(xscale="log", yscale="log", xlabel="speed of the inner ring [rpm]")
        rpm = sorted({row.setting * RPM for row in rows})
        axis.set_xticks(rpm, [f"{one:.0f}" for one in rpm])
        axis.xaxis.set_minor_locator(NullLocator())
    heading(load, f"rig with clearance: {ERRORS['load_error']}", up="error, over that of ring with mass and pockets")
    heading(orbit, ERRORS["orbit_error"])
    cost.set(xscale="log", yscale="log", xlabel="CPU seconds a simulated second, 1000 outputs")
    heading(cost, "worst of both and of the ring, against cost")
    for name, dashes in zip(PROBLEMS, ("-", ":"), strict=True):
        load.plot([], [], color=STYLE["soft"], linestyle=dashes, label=name)
    load.legend(loc="best", frameon=False, fontsize=11)
    for axis in axes:
        frame(axis)
    cost.figure.legend(
        *cost.get_legend_handles_labels(), loc="outside lower center", ncols=7, frameon=False, fontsize=11
    )
