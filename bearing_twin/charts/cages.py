"""Dimensions and cages of a loaded bearing with clearance: error against cost, over speed and load.

The 6203 of the test rig with 10 um of clearance under a load down: equilibria, moving balls round a ring that is held
where equilibrium puts it, and round a ring with mass, each without a cage, with an even one and with one of pockets.
Truth is the fullest of them, a ring with mass and pockets, at a tolerance a hundred times tighter. Balls of different
models are at different places after a while, so that means over the last part of the run are compared: the greatest
load of a ball (mean of all balls), the orbit speed, and the ring: its displacement, or its force where it is held.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from bearing_twin.charts.table import write_points
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, PRESCRIBED, QUASI_STATIC
from bearing_twin.pictures.style import STYLE, ball_line, frame, heading, stamp
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene
from bearing_twin.units import two_digits

SCENE, LAW, STEPPER = "bearing_6203_rig_1000N", "hertz", "rodas4"
LOADS, SPEEDS = (400.0, 1000.0), (94.2478, 157.0796, 628.3185)  # N down; rad/s: 900, 1500 and 6000 rpm
NONE = "none"
MODELS = (
    (QUASI_STATIC, EVEN),
    *((dimension, cage) for dimension in (PRESCRIBED, FREE_RING) for cage in (NONE, EVEN, POCKETS)),
)
FULLEST = FREE_RING, POCKETS
TOLERANCE, FINEST = 1e-3, 1e-5
SPAN, LATE, RATE = 0.3, 0.2, 1000.0  # s of a run, of its last part, outputs a second
CHUNK = 20  # outputs at a time
ERRORS = {"load_error": "greatest ball load", "orbit_error": "orbit speed", "ring_error": "ring's place or force"}
MARKERS = {NONE: "o", EVEN: "s", POCKETS: "^"}
RPM = 30.0 / math.pi  # revolutions a minute of 1 rad/s
LEAST = 1e-7  # smaller errors are drawn here


@dataclass(frozen=True)
class CagePoint:
    """One dimension and cage at one load [N] and speed [rad/s]: relative errors, CPU seconds a simulated second."""

    dimension: str
    cage: str
    load: float
    speed: float
    load_error: float
    orbit_error: float
    ring_error: float
    cost: float


POINT = CagePoint


class Means(NamedTuple):
    """Of the last part of a run: greatest ball load [N], orbit speed [rad/s], ring's y [m], its force [N], CPU cost."""

    load: float
    orbit: float
    place: float
    force: float
    cost: float


def _parameters(model, load: float, speed: float, tolerance: float, place: float):
    """The rig in this dimension and cage; a ring that is held stands at y = `place` [m]."""
    dimension, cage = model
    base = load_scene(SCENE).parameters
    weight = base.rings.inner.mass * base.gravity[1]  # equilibria know loads alone
    down = {QUASI_STATIC: weight - load, PRESCRIBED: 0.0, FREE_RING: -load}[dimension]
    keys = (f"model.dimension={dimension}", f"rings.inner.load=[0,{down},0]", f"cage.kind={cage}")
    rest = f"drive.speed={speed}", f"wanted.tolerance={tolerance}", "solver.companion=off"
    held = (f"drive.offset=[0,{place},0]",) if dimension == PRESCRIBED else ()
    return load_scene(SCENE, (*keys, *rest, *held)).parameters


def run_means(model, load: float, speed: float, tolerance: float = TOLERANCE, place: float = 0.0) -> Means:
    """The means of one run; `place` [m] as above."""
    stepper = QUASI_STATIC if model[0] == QUASI_STATIC else STEPPER
    given = _parameters(model, load, speed, tolerance, place)
    motion, times, spent = bearing_motion(given, Choice(LAW, stepper, 0.0, "", ())), np.arange(1, CHUNK + 1) / RATE, 0.0
    motion.first_outputs()
    found: dict[str, list] = {"normal_load": [], "orbit_angle": [], "inner_ring_offset": [], "inner_ring_force": []}
    chunks = round(SPAN * RATE / CHUNK)
    for chunk in range(chunks):
        start = time.process_time()
        out = motion.advance(times, CHUNK / RATE)
        spent += time.process_time() - start if chunk else 0.0  # the first may wait for a compiler
        if (chunk + 1) * CHUNK / RATE > SPAN - LATE:
            for name, kept in found.items():
                kept.append(np.array(getattr(out, name)))
    late = {name: np.concatenate(kept) for name, kept in found.items()}
    seconds = (len(late["orbit_angle"]) - 1) / RATE
    return Means(
        float(late["normal_load"].max(axis=(0, 2)).mean()),
        float((late["orbit_angle"][-1] - late["orbit_angle"][0]).mean() / seconds),
        float(late["inner_ring_offset"][:, 1].mean()),
        float(late["inner_ring_force"][:, 1].mean()),
        spent / (chunks - 1) * RATE / CHUNK,
    )


def _off(value: float, exact: float) -> float:
    return abs(value / exact - 1.0)


def _points(load: float, speed: float, models) -> list[CagePoint]:
    """All models at one load and speed."""
    truth, points = run_means(FULLEST, load, speed, FINEST), []
    place = run_means((QUASI_STATIC, EVEN), load, speed).place
    for model in models:
        found = run_means(model, load, speed, place=place)
        held = model[0] == PRESCRIBED
        ring = _off(found.force, truth.force) if held else _off(found.place, truth.place)
        errors = _off(found.load, truth.load), _off(found.orbit, truth.orbit), ring
        points.append(CagePoint(*model, load, speed, *errors, found.cost))
    return points


def measure(
    update: Callable[[float], None] = lambda share: None, loads=LOADS, speeds=SPEEDS, models=MODELS
) -> list[CagePoint]:
    """Every model at every load and speed."""
    points, cells = [], [(load, speed) for load in loads for speed in speeds]
    for number, cell in enumerate(cells):
        points += _points(*cell, models)
        update((number + 1) / len(cells))
    return points


write_table = write_points


def worst(points: list[CagePoint], model, error: str) -> float:
    """The greatest error of a model; NaN where it was not measured."""
    return max((getattr(p, error) for p in points if (p.dimension, p.cage) == model), default=math.nan)


def reading(points: list[CagePoint]) -> list[str]:
    """What each model errs by and costs, one sentence each."""
    said = []
    for model in dict.fromkeys((p.dimension, p.cage) for p in points):
        costs = [1e3 * p.cost for p in points if (p.dimension, p.cage) == model]
        errors = ", ".join(f"{words} {100.0 * worst(points, model, key):.2g} %" for key, words in ERRORS.items())
        cost = f"{two_digits(min(costs))} to {two_digits(max(costs))} ms a second"
        said.append(f"{named(model)}: off by at most: {errors}; {cost}.")
    return said


def named(model) -> str:
    """A model in words."""
    dimension, cage = model
    if dimension == QUASI_STATIC:
        return "quasi_static"
    return f"{dimension}, " + {NONE: "no cage", EVEN: "even cage", POCKETS: "pockets"}[cage]


def draw(points: list[CagePoint], path: Path) -> None:
    """The chart: errors of ball load and orbit speed over speed, and the worst error against cost."""
    figure = Figure(figsize=(14, 7), layout="constrained")
    FigureCanvasAgg(figure)
    load, orbit, cost = figure.subplots(1, 3, sharey=True)
    dimensions = list(dict.fromkeys(p.dimension for p in points))
    for model in dict.fromkeys((p.dimension, p.cage) for p in points):
        mine = [p for p in points if (p.dimension, p.cage) == model]
        look = {"color": ball_line(dimensions.index(model[0]))["color"], "marker": MARKERS[model[1]], "markersize": 7}
        for size, dashes in zip(dict.fromkeys(p.load for p in mine), ("-", ":"), strict=False):
            row = [p for p in mine if p.load == size]
            for axis, key in ((load, "load_error"), (orbit, "orbit_error")):
                rpm = [p.speed * RPM for p in row]
                axis.plot(rpm, [max(getattr(p, key), LEAST) for p in row], **look, linestyle=dashes)
        most = [max(p.load_error, p.orbit_error, p.ring_error, LEAST) for p in mine]
        cost.plot([p.cost for p in mine], most, **look, linestyle="none", label=named(model))
    for axis, key in ((load, "load_error"), (orbit, "orbit_error")):
        axis.set(xscale="log", yscale="log", xlabel="speed of the inner ring [rpm]")
        heading(axis, f"error of the {ERRORS[key]}")
        rpm = sorted({p.speed * RPM for p in points})
        axis.set_xticks(rpm, [f"{one:.0f}" for one in rpm])
        axis.xaxis.set_minor_locator(NullLocator())
    load.set_ylabel("error, over the value of ring with mass and pockets")
    cost.set(xscale="log", yscale="log", xlabel="CPU seconds a simulated second, 1000 outputs")
    heading(cost, "worst of both and of the ring, against cost")
    for size, dashes in zip(dict.fromkeys(p.load for p in points), ("-", ":"), strict=False):
        load.plot([], [], color=STYLE["soft"], linestyle=dashes, label=f"{size:g} N")
    load.legend(loc="best", frameon=False, fontsize=11)
    for axis in (load, orbit, cost):
        frame(axis)
    handles, place = cost.get_legend_handles_labels(), {"loc": "lower center", "bbox_to_anchor": (0.5, 0.025)}
    figure.legend(*handles, **place, ncols=7, frameon=False, fontsize=11)
    title = "A loaded bearing with clearance: dimensions with and without a cage"
    figure.suptitle(title, fontsize=15, color=STYLE["ink"])
    figure.get_layout_engine().set(rect=(0.0, 0.08, 1.0, 0.92))  # below is room for both
    stamp(figure)
    figure.savefig(path, dpi=100)
