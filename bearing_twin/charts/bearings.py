"""Charts of a bearing's run: integration methods, what one tries first, how much has to move, where methods fail.

What one tries first are SciPy with its defaults, a fixed step of 0.1 ms and explicit Euler on the product's equations,
whose right-hand side is compiled: what differs is the method and its setting. `rodas4` and `rk4` beside them are runs
of the product, which refuses steps that are too long.

Maps of where methods fail show the error of what a user runs over two numbers: steps of fixed-step methods against
stiffness, friction and damping; tolerances of adaptive ones against friction; modes and steps of a beam, meshes of a
soft disc. Every cell is a run.
"""

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Choice
from bearing_twin.charts.bodies import OUTSIDE, beam_impact, disc
from bearing_twin.charts.contest import DONE, REFUSED, Contest, by_method, cost_comparison, panels_over, rows_of
from bearing_twin.charts.scenes import Method, RunData, SceneProblem, bearing_problem, log_spaced, steps, tolerances
from bearing_twin.coefficients import ROSENBROCK
from bearing_twin.kinds.bearing.integrate import rates
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.methods import STEPPER_FACTS
from bearing_twin.pictures import Axis, Line, Map, Panel, in_rows

LOADS = ("normal_load", "friction_force")
FROM_REST = ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]")
TOLERANCES, FEW_TOLERANCES, SCIPY_TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6), (1e-1, 1e-3, 1e-5), (1e-3,)
STEPS = (4e-6, 2e-6, 1e-6, 5e-7, 2.5e-7)


def methods() -> dict:
    """Every stepper with its ladder of tolerances or steps."""
    by_name = {}
    for name, facts in STEPPER_FACTS.items():
        settings = TOLERANCES if name in ROSENBROCK else FEW_TOLERANCES
        if "SciPy" in facts.source:
            settings = SCIPY_TOLERANCES
        ladder = functools.partial(tolerances, *settings) if facts.adaptive else functools.partial(steps, *STEPS)
        by_name[name] = ladder(overrides=(f"solver.stepper={name}",))
    return by_name


def moving(title: str, scene: str, period: float, count: int, *keys: str) -> SceneProblem:
    """A bearing over `count` outputs `period` [s] apart, by every stepper."""
    rates = (f"run.duration={period * count:g}", f"run.output_rate={1.0 / period:g}", "run.publish_rate=100")
    return bearing_problem(
        title=title,
        scene=scene,
        overrides=(*keys, *rates),
        reference=("solver.stepper=rodas4", "wanted.tolerance=1e-8"),
        methods=methods(),
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

SPEEDS = log_spaced(50.0, 2000.0, 7)  # rad/s of the inner ring
SPIN_SETTLED = 0.5  # s: friction has turned the axes of the balls' spin by then
EQUILIBRIUM = "equilibrium"
MOVING_BALLS = {name: f"moving balls, {name}" for name in ("rodas4", "rodas3")}


def loads_and_angles(result, exact) -> dict[str, float]:
    """Norm: greatest differences of loads and of contact angles at the end, each over the greatest, ball by ball."""
    errors = {}
    for name in ("normal_load", "contact_angle"):
        values, true_values = (np.sort(np.abs(run.values[name][-1]), axis=0) for run in (result, exact))
        errors[f"{name}_error"] = float(np.abs(values - true_values).max() / true_values.max())
    return {"error": max(errors.values()), **errors}


def held(title: str, *keys: str) -> SceneProblem:
    """A preloaded 6203 in an even cage, its inner ring held, over speed."""
    return bearing_problem(
        title=title,
        overrides=("gravity=[0,0,0]", "cage.kind=even", f"run.duration={SPIN_SETTLED}", "run.output_rate=1000", *keys),
        reference=("model.dimension=prescribed", "solver.stepper=rodas4", "wanted.tolerance=1e-6"),
        methods={
            EQUILIBRIUM: tolerances(1e-3, overrides=("model.dimension=quasi_static",)),
            **{
                name: tolerances(1e-3, overrides=("model.dimension=prescribed", f"solver.stepper={stepper}"))
                for stepper, name in MOVING_BALLS.items()
            },
        },
        norm=loads_and_angles,
        channels=("normal_load", "contact_angle"),
        across=lambda speed: (f"drive.speed={speed:.9g}",),
        values=SPEEDS,
    )


HELD_RINGS = {
    "light thrust": held("light thrust, 5 µm axial", "drive.offset=[0,0,5e-6]"),
    "thrust": held("thrust, 20 µm axial", "drive.offset=[0,0,2e-5]"),
    "combined": held("thrust and radial load, 20 and 3 µm", "drive.offset=[0,-3e-6,2e-5]"),
}


COST_OF_SECOND = "CPU time of a simulated second"
SPEED_PANELS = functools.partial(
    panels_over,
    across=Axis("speed of the inner ring", "rad/s", log=True),
    columns={
        "normal_load_error": Axis("error of ball loads", log=True),
        "contact_angle_error": Axis("error of contact angles", log=True),
        "seconds": Axis(COST_OF_SECOND, "s", log=True),
    },
)


def _dimension_reading(contest, rows):
    """Differences between equilibria and moving balls at the ends of the speeds, and costs."""
    for title, runs in contest.by_title(rows, DONE):
        differences = (
            f"{row.more['normal_load_error']:.1g} in loads and {row.more['contact_angle_error']:.1g} in angles at "
            f"{row.across:g} rad/s"
            for row in runs
            if row.method == EQUILIBRIUM and row.across in (SPEEDS[0], SPEEDS[-1])
        )
        if differences := ", by ".join(differences):
            yield f"{title}: equilibria differ from balls that move by {differences}."
    yield from cost_comparison(contest, rows)


COARSE, DEFAULT = 1e-4, 1e-3  # s, the step that is often tried first; SciPy's default tolerance


def naive(motion: BearingMotion, times: np.ndarray, method: str, setting: float) -> tuple[np.ndarray, int]:
    """A run as a user writes it: a right-hand side of time and a flat state; Euler's steps or `solve_ivp`.

    States at `times` [s], and evaluations of a ball.
    """
    shape, near = motion.state.shape, np.zeros(motion.bearing.balls, np.bool_)
    count = 0

    def right_hand_side(time, flat):
        nonlocal count
        count += motion.bearing.balls
        speed = motion.drive.speed + motion.drive.acceleration * time
        return rates(motion.bearing, speed, near, flat.reshape(shape)).ravel()

    state = motion.state.ravel().copy()
    if method == "Euler":
        states = [state]
        for begin, end in itertools.pairwise(times):
            for time in np.linspace(begin, end, max(1, round((end - begin) / setting)), endpoint=False):
                state = state + min(setting, end - begin) * right_hand_side(time, state)
                if not np.isfinite(state).all():
                    raise IntegrationError("not finite", "not finite", float(time), "")
            states.append(state)
        return np.array(states), count
    solution = solve_ivp(right_hand_side, (0.0, times[-1]), state, method, times, rtol=setting, atol=1e-3 * setting)
    if not solution.success:
        raise IntegrationError(solution.message, "failed", float(solution.t[-1]), "")
    return solution.y.T, count


def solve_naively(method: str, exact: RunData, setting: float) -> tuple[Callable, Callable]:
    """A run by `naive` as work, and what turns its states into outputs."""
    motion = BearingMotion(exact.scene.parameters, Choice("hertz", "rodas4", 0.0, "", ()))
    first = motion.state.copy()

    def work():
        motion.state[:] = first
        return naive(motion, exact.time, method, setting)

    def run_data(states_and_count) -> RunData:
        rows = []
        for state in states_and_count[0]:
            motion.state[:] = state.reshape(first.shape)
            rows.append(motion.first_outputs())
        values = {channel: np.concatenate([row[channel] for row in rows]) for channel in LOADS}
        return RunData(exact.time, values, {}, float(states_and_count[1]), exact.scene)

    return work, run_data


FIRST_ATTEMPTS = {
    "rodas4": tolerances(DEFAULT, 1e-1, 1e-2, 1e-4, 1e-5, 1e-6, overrides=("solver.stepper=rodas4",)),
    "rk4": steps(COARSE, 1e-6, 1e-5, 3e-7, overrides=("solver.stepper=rk4",)),
    "explicit Euler": Method(settings=(COARSE, 1e-6, 1e-5, 1e-7), solve=functools.partial(solve_naively, "Euler")),
    "solve_ivp RK45": Method(settings=(DEFAULT, 1e-6, 1e-9), solve=functools.partial(solve_naively, "RK45")),
    "solve_ivp LSODA": Method(settings=(DEFAULT, 1e-6, 1e-9), solve=functools.partial(solve_naively, "LSODA")),
}  # each setting that is tried first at the head
NEWCOMERS = {
    name: dataclasses.replace(MOVING[name], methods=FIRST_ATTEMPTS) for name in ("settled", "sliding", "lift-off")
}


def _newcomer_reading(contest, rows):
    """Error of each method as it is first tried, and the cost of the requested error."""
    titles = (title for title, _ in contest.by_title(rows))
    attempts = []
    for method, attempt in FIRST_ATTEMPTS.items():
        first = attempt.settings[0]
        runs = (row for row in rows if (row.method, row.setting) == (method, first))
        errors = dict.fromkeys(f"{row.error:.1g}" if row.status == DONE else row.status for row in runs)
        attempts.append(f"{method} at {first:g}: {', '.join(errors)}")
    yield f"Errors of first attempts ({'; '.join(titles)}): {'; '.join(attempts)}."
    yield from cost_comparison(contest, rows)


FAILS, COLUMNS = 0.1, 3  # error of a run that fails; maps side by side
ONE_BALL = ("geometry.balls=1", "run.duration=2e-3", "run.output_rate=10000", "run.publish_rate=1000")
BODIES = ("ball", "inner_ring", "outer_ring")
FIXED = {name: steps(*log_spaced(1e-7, 2e-5, 12), overrides=(f"solver.stepper={name}",)) for name in ("rk4", "imex")}
ADAPTIVE = {
    name: tolerances(*log_spaced(1e-1, 1e-6, 6), overrides=(f"solver.stepper={name}",))
    for name in ("rodas4", "rodas3", "dopri5")
}


def _ball(title: str, across, values, *keys: str, methods=None) -> SceneProblem:
    """One ball of a 6203."""
    return bearing_problem(
        title=title,
        overrides=(*ONE_BALL, *keys),
        reference=("solver.stepper=rodas4", "wanted.tolerance=1e-8"),
        methods=FIXED if methods is None else methods,
        across=across,
        values=values,
    )


def _moduli(value: float) -> tuple[str, ...]:
    return tuple(f"materials.{body}.young_modulus={value:g}" for body in BODIES)


def _slip(value: float) -> tuple[str, ...]:
    return (f"contact.friction_regularisation={value:g}",)


LOCKING = {
    f"{name} integration": Method(
        ("mesh.order=1", f"mesh.integration={name}", OUTSIDE), "mesh.divisions", (8.0, 12, 16, 24)
    )
    for name in ("full", "selective")
}
MODES = Method(("solver.stepper=modes", "wanted.tolerance=1e-3"), "solver.steps", (8.0, 12, 16, 24, 48, 96, 192))
MAPS = {
    "stiffness": _ball("one ball that rolls: Young's modulus [Pa]", _moduli, log_spaced(2e10, 2e12, 9)),
    "friction": _ball("one ball that rolls: friction regularisation [m/s]", _slip, log_spaced(1e-3, 1e-1, 9)),
    "sliding": _ball("one ball from rest: friction regularisation [m/s]", _slip, log_spaced(1e-3, 1e-1, 9), *FROM_REST),
    "damping": _ball(
        "one ball that rolls: relaxation time [s]",
        lambda value: (f"contact.relaxation_time={value:g}",),
        log_spaced(1e-7, 1e-5, 9),
        "contact.friction_coefficient=0.01",
    ),
    "tolerance": _ball(
        "one ball from rest: friction regularisation [m/s]",
        _slip,
        log_spaced(1e-4, 1e-1, 7),
        *FROM_REST,
        methods=ADAPTIVE,
    ),
    "modes": dataclasses.replace(
        beam_impact("sphere on a beam: modes", "sphere_on_beam_drop_600mm", "run.duration=3e-4"),
        methods={"modes": MODES},
        across=lambda value: (f"solver.modes={value:g}",),
        values=(5.0, 9, 17, 33, 65, 129, 257),
    ),
    "disc": dataclasses.replace(
        disc("soft disc: 1 - 2 × Poisson's ratio", LOCKING, finer="mesh.divisions=32"),
        across=lambda value: (f"disc.material.poisson_ratio={0.5 - 0.5 * value:g}",),
        values=(0.002, 0.01, 0.04, 0.1, 0.4),
    ),
}
SETTING_AXES = {
    "wanted.tolerance": Axis("tolerance", log=True),
    "solver.step": Axis("step", "s", log=True),
    "solver.steps": Axis("steps a contact", log=True),
    "mesh.divisions": Axis("divisions", log=True),
}


MARK = {"linestyle": "", "markersize": 8, "markeredgewidth": 2}


def _has_failed(row) -> bool:
    return row.status not in (DONE, REFUSED) or FAILS < row.error < math.inf


def _map_panels(contest, rows, styles) -> list[list[Panel]]:
    """A map a problem and method; crosses where a run fails, dots where the software refuses."""
    panels = []
    for name, problem in contest.problems.items():
        for method, runs in by_method(rows_of(rows, name)).items():
            across, settings = sorted({row.across for row in runs}), sorted({row.setting for row in runs})
            z = np.full((len(settings), len(across)), math.nan)
            for row in runs:
                if row.status == DONE:
                    z[settings.index(row.setting), across.index(row.across)] = row.error
            title, _, unit = problem.title.partition(" [")
            body, _, number = title.partition(": ")
            failed = [row for row in runs if _has_failed(row)]
            parts: list = [Map("error", "1", across, settings, z, "viridis_r", (1e-8, 1.0), 0.0)]
            for label, style, marked in (
                (f"error above {FAILS:g}, or no result", {"marker": "x", "color": "#D55E00"}, failed),
                ("refused by the software", {"marker": "s", "color": "#5f6f7a"}, rows_of(runs, name, REFUSED)),
            ):
                points = [(row.across, row.setting) for row in marked]
                parts.append(Line(label, *np.reshape(points, (-1, 2)).T, {**MARK, **style}))
            x, up = Axis(number, unit.rstrip("]") or "1", log=True), SETTING_AXES[problem.methods[method].tuned_key]
            panels.append(Panel(f"{body}, {method}", x, up, parts, None))
    return in_rows(panels, COLUMNS)


def _map_reading(contest, rows):
    """Numbers of cells that are refused and that fail, and the greatest error of the others, by method."""
    for method, runs in by_method(rows).items():
        refused = sum(row.status == REFUSED for row in runs)
        failed = sum(map(_has_failed, runs))
        errors = [row.error for row in runs if row.status == DONE and not _has_failed(row)]
        worst = f"; errors of the others up to {max(errors):.1g}" if errors else ""
        yield f"{method}: of {len(runs)} cells {refused} refused, {failed} failed{worst}."


CHARTS = {
    "steppers": Contest(
        problems=MOVING,
        title="Integration methods on a 6203: error against cost, one core",
        error="greatest error of load or friction",
        cost=COST_OF_SECOND,
        reference_methods=tuple(ROSENBROCK),
    ),
    "dimensions": Contest(
        problems=HELD_RINGS,
        title="A preloaded 6203 over speed: equilibria against balls that move",
        cost=COST_OF_SECOND,
        requested_error=1e-2,
        panels=SPEED_PANELS,
        read=_dimension_reading,
        labels={MOVING_BALLS.get(name, name): MOVING_BALLS.get(name, name) for name in STEPPER_FACTS},
    ),
    "newcomers": Contest(
        problems=NEWCOMERS,
        title="What one tries first, against the product's rodas4",
        read=_newcomer_reading,
        error="greatest error of load or friction",
        cost=COST_OF_SECOND,
        reference_methods=("rodas4",),
    ),
    "stability": Contest(
        problems={name: dataclasses.replace(problem, is_timed=False) for name, problem in MAPS.items()},
        title="Where methods fail, and where the software refuses",
        panels=_map_panels,
        read=_map_reading,
    ),
}
