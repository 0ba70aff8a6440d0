"""Charts of one contact: elastic laws over the shape of the ellipse, friction over a patch that slides and spins.

Laws: the load as the contact calculator gives it, which is what every product of a law goes by, against exact Hertz;
SciPy's integrals check that. Friction: Coulomb's law without smoothing, the hardest case, against
`reference.patch_friction_exact`; each error is the worst of several directions of slip, of
the force over mu N, of the torque over pure spin's.
"""

import functools
import math

import numpy as np
from scipy.optimize import brentq, brute
from scipy.special import elliprd, elliprf

from bearing_twin.charts.contest import (
    DONE,
    LEAST_ERROR,
    Contest,
    Problem,
    by_method,
    cost_comparison,
    error_against_cost,
    panels_over,
    rows_of,
    time_text,
    timed,
)
from bearing_twin.charts.reference import patch_friction_exact
from bearing_twin.charts.scenes import SceneProblem, bearing_problem, log_spaced, tolerances
from bearing_twin.contact.calculator import COMPARED, Gap, laws_at
from bearing_twin.contact.elasticity import carried_course, coefficient_of, curvature_ratio, hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, patch_by
from bearing_twin.contact.laws import LAWS
from bearing_twin.pictures import Axis

BEARING = (0.08, 0.18)  # b/a of steel balls in raceways
FROZEN_AT = 0.1  # b/a at which `constant` is exact
SCIPY = "SciPy"
LAW_LABELS = {
    "hertz": "Hertz by a rational function",
    "hertz_exact": "Hertz solved exactly",
    "volumetric": "volumetric law",
    "constant": "constant coefficient",
    "hertz_differential": "Hertz, states projected",
    "hertz_unprojected": "Hertz, states not projected",
    "linear": "linear spring",
    SCIPY: "Hertz by SciPy",
}
FRICTION_LABELS = {
    "point": "friction at the contact point",
    "spot": "friction over the patch",
    "spot_medium": "the same, 4 times the points",
    "spot_fine": "the same, 24 times the points",
    "pade1": "closed form of first degree",
    "pade2": "closed form of second degree",
}
TURNS, STEPS = 200, 16  # of the swing of the shape over which laws with states are carried to be timed
EVALUATIONS = 20_000  # evaluations of a timing


@functools.cache
def law_cost(name: str) -> dict[str, float]:
    """CPU seconds of one evaluation of a law on balls in raceways."""
    large = curvature_ratio(np.geomspace(*BEARING, EVALUATIONS))
    if name == SCIPY:
        return timed(lambda: [by_scipy(1.0, curvature, 1.0) for curvature in large[::200]], EVALUATIONS / 200)[1]
    if not LAWS[name].carries:
        return timed(lambda: coefficient_of(name, 1.0, large, 1.0, 1.0), EVALUATIONS)[1]
    phase = 2.0 * math.pi / STEPS * np.arange(TURNS * STEPS + 1)
    course = np.exp(math.log(1.0 / curvature_ratio(0.1)) + 0.5 * np.sin(phase))
    return timed(lambda: carried_course(name, course), TURNS * STEPS)[1]


def by_scipy(small: float, large: float, modulus: float) -> float:
    """Exact Hertz's coefficient [N/m^1.5] of a gap P x^2 + Q y^2 [1/m] and a modulus [Pa], by SciPy alone."""

    def mismatch(logarithm):
        square = math.exp(2.0 * logarithm)
        return math.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0) * small / large)

    square = math.exp(2.0 * brentq(mismatch, -16.0, 1e-9, xtol=1e-15, rtol=1e-14))
    first_integral, second_integral = elliprf(0.0, square, 1.0), elliprd(0.0, square, 1.0) / 3.0
    return 2.0 * math.pi / 3.0 * modulus * math.sqrt(second_integral / (small * first_integral)) / first_integral


def judge_law(law: str, setting: float, ratio: float) -> dict:
    """A law at one shape b/a."""
    large = float(curvature_ratio(ratio))
    if law == SCIPY:
        error = abs(by_scipy(1.0, large, 1.0) / hertz_coefficient(1.0, large, 1.0) - 1.0)
    else:
        error = abs(laws_at(Gap(1.0, large, 0.5 / large), 1.0, 1e-6, FROZEN_AT)[law].error)
    return {"error": error, **law_cost(law), "evaluations": 1.0}


def _shapes(title: str, shapes: tuple[float, ...]) -> Problem:
    """All laws over these shapes b/a."""

    def entries(quick: bool):
        return ((law, math.nan, ratio) for law in (*COMPARED, SCIPY) for ratio in shapes[:: 8 if quick else 1])

    return Problem(title, entries, judge_law)


def _in_a_run(title: str, key: str, names: tuple[str, ...], true: str, *keys: str) -> SceneProblem:
    """A choice of the contact inside the run of a 6203."""
    return bearing_problem(
        title=title,
        overrides=("run.duration=0.1", "run.output_rate=2000", *keys),
        reference=(f"{key}={true}", "wanted.tolerance=1e-8"),
        methods={name: tolerances(1e-3, 1e-6, overrides=(f"{key}={name}",)) for name in names},
    )


def _law_panels(contest, rows, styles):
    """Error over the shape; error against cost on a ball in a raceway, and in a run."""
    axes = Axis("b/a of the ellipse", log=True), {"error": Axis("error of the load against exact Hertz", log=True)}
    with_cost = [row for row in rows if row.problem != "ellipse"]
    return [
        *panels_over(contest, rows_of(rows, "ellipse"), styles, *axes),
        *error_against_cost(contest, with_cost, styles),
    ]


def _reading(contest, rows):
    """Cost of an evaluation and greatest errors of each row of the table of laws or of frictions; then the runs."""
    alone = (row for row in rows if row.status == DONE and not row.command)
    for method, runs in by_method(alone).items():
        worst = {row.problem: max(row.error, LEAST_ERROR) for row in sorted(runs, key=lambda row: row.error)}
        errors_text = ", ".join(
            f"{worst[name]:.1g} for {problem.title}" for name, problem in contest.problems.items() if name in worst
        )
        title_of_method = f"{method} ({contest.labels[method]})" if method in contest.labels else method
        yield f"{title_of_method}: {time_text(runs[0].seconds)} an evaluation; greatest error {errors_text}."
    yield from cost_comparison(contest, [row for row in rows if row.command])


SPINS = log_spaced(0.01, 100.0, 25)  # spin times major semi-axis over slip
DIRECTIONS = np.linspace(0.0, 0.5 * math.pi, 5)
POLES = (0.03, 1.1), (0.0, 0.5 * math.pi)
"""Distance and angle of the poles of motions among which the greatest error is searched; the patch is a circle."""
RAYS, NARROW = 250, 25.0  # of the exact solution, good to 1e-12; for b/a < 0.1 NARROW over b/a
MODELS = tuple(row.name for row in FRICTIONS.values() if row.over_patch)


@functools.cache
def _friction_cost(name: str) -> dict[str, float]:
    spins, patch = np.geomspace(0.1, 10.0, 2000), patch_by(name, 1.0)
    return timed(lambda: patch.friction(1.0, 1.0, 0.1, 0.6, 0.8, spins, 1e-9), len(spins))[1]


@functools.lru_cache(maxsize=4096)
def _exact(shape: float, along: float, across: float, spin: float):
    return patch_friction_exact(1.0, 1.0, shape, along, across, spin, 1.0, rays=max(RAYS, round(NARROW / shape)))


def errors(model: str, shape: float, motions) -> np.ndarray:
    """Errors (n, 2) of force, over mu N, and torque, over pure spin's, at motions (slip along both axes, spin)."""
    pure = abs(_exact(shape, 0.0, 0.0, 1.0).torque)
    exact = [_exact(shape, *motion) for motion in motions]
    result = patch_by(model, 1.0).friction(1.0, 1.0, shape, *np.array(motions).T, 1e-12)
    difference = np.stack(result, axis=1) - exact
    return np.stack([np.hypot(difference[:, 0], difference[:, 1]), np.abs(difference[:, 2]) / pure], axis=1)


def _of_pole(shape: float, distance: float, angle: float) -> tuple[float, float, float]:
    slip = shape * distance * math.sin(angle), -distance * math.cos(angle)
    size = math.hypot(*slip)
    return slip[0] / size, slip[1] / size, 1.0 / size


def hardest(model: str, shape: float, grid: int = 24) -> list[tuple[tuple[float, float, float], float]]:
    """The motions with the greatest errors of force and of torque, and these errors: from a grid of poles downhill."""
    motions = []
    for part in (0, 1):

        def miss(pole, part=part):
            return -errors(model, shape, [_of_pole(shape, *pole)])[0, part]

        pole, error, *_ = brute(miss, POLES, Ns=grid, full_output=True)
        motions.append((_of_pole(shape, *pole), -float(error)))
    return motions


def judge_friction(shape: float, name: str, _: float, spin: float) -> dict:
    """A model at one shape and ratio of spin to slip; without one (NaN) at the motions of its greatest errors."""
    if math.isnan(spin):
        errors_of_motions, cost = np.array([[error for _, error in hardest(name, shape)]]), _friction_cost(name)
    else:
        motions = [(math.cos(angle), math.sin(angle), spin) for angle in DIRECTIONS]
        errors_of_motions, cost = errors(name, shape, motions), _friction_cost(name)
    force, torque = map(float, errors_of_motions.max(axis=0))
    return {"error": max(force, torque), **cost, "force_error": force, "torque_error": torque}


def _friction_entries(quick: bool):
    return [(name, math.nan, spin) for name in MODELS for spin in (SPINS[::6] if quick else (*SPINS, math.nan))]


def _friction_panels(contest, rows, styles):
    """Errors of force and torque over spin, and a run."""
    columns = {
        "force_error": Axis("error of the force, over that of sliding", log=True, limits=(1e-6, 2.0)),
        "torque_error": Axis("error of the torque, over that of pure spin", log=True, limits=(1e-6, 2.0)),
    }
    over_spin = [row for row in rows if not math.isnan(row.across)]
    runs = [row for row in rows if row.command]
    across = Axis("spin × major semi-axis / slip", log=True)
    return [*panels_over(contest, over_spin, styles, across, columns), *error_against_cost(contest, runs, styles)]


CHARTS = {
    "laws": Contest(
        title="Elastic laws: error over the shape of the contact, and cost",
        problems={
            "ellipse": _shapes("b/a from 0.001 to 1", log_spaced(1e-3, 1.0, 25)),
            "raceway": _shapes("balls in raceways (b/a from 0.08 to 0.18)", log_spaced(*BEARING, 5)),
            "law in a run": _in_a_run(
                "a second of a 6203, by law",
                "contact.normal",
                ("hertz", "hertz_exact", "volumetric", "constant", "hertz_differential"),
                "hertz_exact",
            ),
        },
        panels=_law_panels,
        read=_reading,
        labels=LAW_LABELS,
        error="greatest error of load or friction",
        cost="CPU time",
    ),
    "friction": Contest(
        title="Friction over a contact patch that slides and spins: error of each model",
        problems={
            **{
                f"b/a = {shape:g}": Problem(
                    f"b/a = {shape:g}", _friction_entries, functools.partial(judge_friction, shape)
                )
                for shape in (1.0, 0.3, 0.1)
            },
            "friction in a run": _in_a_run(
                "a second of a 6203, by friction", "contact.friction", tuple(FRICTIONS), "spot_fine", "drive.speed=300"
            ),
        },
        panels=_friction_panels,
        read=_reading,
        labels=FRICTION_LABELS,
        error="greatest error of load or friction",
        cost="CPU time",
    ),
}
