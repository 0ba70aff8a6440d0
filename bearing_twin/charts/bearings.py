"""Charts of a bearing's run: integration methods, and how much of the bearing has to move by itself."""

import numpy as np

from bearing_twin.charts.contest import best_of, of_methods, of_problem, over_across
from bearing_twin.charts.panels import Axis
from bearing_twin.charts.rows import DONE
from bearing_twin.charts.scenes import Problem, Scenes, load_and_friction, spread, steps, tolerances
from bearing_twin.numerics.methods import STEPPER_FACTS
from bearing_twin.numerics.steppers import ROSENBROCK

FROM_REST = ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]")
LADDER, FINER, SCIPYS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6), (1e-1, 1e-3, 1e-5), (1e-3,)
STEPS = (4e-6, 2e-6, 1e-6, 5e-7, 2.5e-7)


def methods() -> dict:
    """Every stepper with its ladder of tolerances or steps."""
    found = {}
    for name, facts in STEPPER_FACTS.items():
        keys = (f"solver.stepper={name}",)
        ladder = LADDER if name in ROSENBROCK else SCIPYS if "SciPy" in facts.source else FINER
        found[name] = tolerances(*ladder, keys=keys) if facts.adaptive else steps(*STEPS, keys=keys)
    return found


def moving(title: str, scene: str, period: float, count: int, *keys: str) -> Problem:
    """A bearing over `count` outputs `period` [s] apart, by every stepper."""
    rates = (f"run.duration={period * count:g}", f"run.output_rate={1.0 / period:g}", "run.publish_rate=100")
    return Problem(
        title=title,
        scene=scene,
        keys=(*keys, *rates),
        reference=("solver.stepper=rodas4", "wanted.tolerance=1e-8"),
        methods=methods(),
        norm=load_and_friction,
        channels=("normal_load", "friction_force"),
        a_second=True,
    )


MOVING = {
    "settled": moving("settled, outputs every 1 ms", "bearing_6203", 1e-3, 100),
    "sliding": moving("from rest: sliding, ringing", "bearing_6203", 5e-5, 40, *FROM_REST),
    "lift-off": moving("clearance, lift-off", "bearing_6203_loose", 1e-3, 20, "cage.kind=none"),
    "sticking": moving(
        "friction regularised at 0.1 mm/s", "bearing_6203", 1e-3, 10, "contact.friction_regularisation=1e-4"
    ),
    "fast": moving("20 000 rpm, outputs every 1 ms", "bearing_6203_fast", 1e-3, 20),
    "sudden": moving(
        "sudden speed and load", "bearing_6203_sudden", 5e-5, 40, "drive.change.time=2e-4", "drive.acceleration=1e6"
    ),
}

SPEEDS = spread(50.0, 2000.0, 7)  # rad/s of the inner ring
LATE = 0.5  # s: friction has turned the axes of the balls' spin by then


def loads_and_angles(found, exact) -> dict[str, float]:
    """Norm: greatest differences of loads and of contact angles at the end, each over the greatest, ball by ball."""
    errors = {}
    for name in ("normal_load", "contact_angle"):
        one, other = (np.sort(np.abs(run.values[name][-1]), axis=0) for run in (found, exact))
        errors[f"{name}_error"] = float(np.abs(one - other).max() / other.max())
    return {"error": max(errors.values()), **errors}


def held(title: str, *keys: str) -> Problem:
    """A preloaded 6203 in an even cage, its inner ring held, over speed."""
    return Problem(
        title=title,
        scene="bearing_6203",
        keys=("gravity=[0,0,0]", "cage.kind=even", f"run.duration={LATE}", "run.output_rate=1000", *keys),
        reference=("model.dimension=prescribed", "solver.stepper=rodas4", "wanted.tolerance=1e-6"),
        methods={
            "equilibrium": tolerances(1e-3, keys=("model.dimension=quasi_static",)),
            "moving balls, rodas4": tolerances(1e-3, keys=("model.dimension=prescribed", "solver.stepper=rodas4")),
            "moving balls, rodas3": tolerances(1e-3, keys=("model.dimension=prescribed", "solver.stepper=rodas3")),
        },
        norm=loads_and_angles,
        channels=("normal_load", "contact_angle"),
        across=lambda speed: (f"drive.speed={speed:.9g}",),
        values=SPEEDS,
        a_second=True,
    )


HELD = {
    "light thrust": held("light thrust, 5 µm axial", "drive.offset=[0,0,5e-6]"),
    "thrust": held("thrust, 20 µm axial", "drive.offset=[0,0,2e-5]"),
    "combined": held("thrust and radial load, 20 and 3 µm", "drive.offset=[0,-3e-6,2e-5]"),
}


def _dimension_panels(contest, rows):
    names = {"normal_load_error": "error of ball loads", "contact_angle_error": "error of contact angles"}
    return over_across(contest, rows, Axis("speed of the inner ring", "rad/s", log=True), names)


def _dimension_reading(contest, rows):
    for name, title in contest.problems.items():
        if mine := of_methods(of_problem(rows, name, DONE)).get("equilibrium"):
            slow, fast = (min(mine, key=lambda row: row.across), max(mine, key=lambda row: row.across))
            parts = (
                f"loads {row.more['normal_load_error']:.1g} and angles {row.more['contact_angle_error']:.1g} "
                f"at {row.across:g} rad/s"
                for row in (slow, fast)
            )
            yield f"{title}: equilibria differ from balls that move by {'; '.join(parts)}."
    yield from best_of(contest, rows)


CHARTS = {
    "steppers": Scenes(table=MOVING).contest(
        title="Integration methods on a 6203: error against cost, one core",
        error="greatest error of load or friction",
        cost="CPU time of a simulated second",
        own=tuple(ROSENBROCK),
    ),
    "dimensions": Scenes(table=HELD).contest(
        title="A preloaded 6203 over speed: equilibria against balls that move",
        cost="CPU time of a simulated second",
        wanted=1e-2,
        panels=_dimension_panels,
        read=_dimension_reading,
    ),
}
