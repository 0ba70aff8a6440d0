"""What a tolerance is worth in every kind but a single bearing: error got against error asked, and what runs say of it.

Shipped scenes of shafts, impacts, beams, bodies that bounce and soft discs, and variants that nothing was fitted to,
run as `simulate` runs them. Truth is the same scene far more exact, by Timoshenko's beam where a scene asks for
Euler's, and on a much finer mesh; another run so much rougher says how far truth may be off. Each wanted output is
judged in its own norm, from what a user has: samples and figures. `load_error` is the greatest of them. Of a run that
names a horizon, contacts up to it count. Two discs by a law of line contact are left out: a truth of the same law has
its error, too.
"""

import contextlib
import functools
import math
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.contest import judged
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE, REFUSED
from bearing_twin.charts.tolerance import (
    ALONE,
    CLEAR,
    KNOWABLE,
    METHOD,
    TOLERANCES,
    ToleranceRow,
    nearness,
    said,
    unknown,
    unsaid,
)
from bearing_twin.charts.tolerance_picture import draw_all
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.ellipsoid.doubt import paired
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

PEAKS = "peaks alone"
WANTED = {METHOD: (), PEAKS: ("wanted.outputs=peaks",)}  # what differs from the case


class Truth(NamedTuple):
    """What makes a scene of a kind count as true, and what makes it rougher than that."""

    exact: tuple[str, ...]
    rougher: tuple[str, ...]
    peaks: bool = False  # whether they may be wanted alone


def _by_tolerance(exact: float, rougher: float, *more: str, peaks: bool = False) -> Truth:
    return Truth(*((f"wanted.tolerance={one:g}", *more) for one in (exact, rougher)), peaks)


SHEAR = "beam.theory=timoshenko"
TRUTHS = {
    "shaft": _by_tolerance(1e-8, 1e-7),
    "ellipsoid_on_plane": _by_tolerance(1e-11, 1e-10),
    "two_bodies": _by_tolerance(1e-10, 1e-9),
    "sphere_on_beam": _by_tolerance(1e-9, 1e-8, SHEAR, peaks=True),
    "two_spheres": _by_tolerance(1e-11, 1e-10, peaks=True),
    "soft_discs": Truth(("mesh.divisions=96",), ("mesh.divisions=72",), peaks=True),
}
"""By kind."""
SCENES = (
    *("shaft_two_6203", "shaft_angular_pair", "shaft_step_load", "two_spheres", "sphere_on_beam"),
    *("sphere_on_beam_drop_50mm", "sphere_on_beam_drop_600mm", "sphere_on_beam_long"),
    *("sphere_on_beam_drop_50mm_shear", "sphere_on_beam_drop_600mm_shear"),
    *("ellipsoid_on_plane", "ellipsoid_rocking", "ellipsoid_tumbling"),
    *("two_bodies_ellipsoid", "two_bodies_groove", "two_bodies_superellipsoid"),
    *("soft_discs_mean", "soft_discs_unequal", "soft_discs_fast"),
)
VARIANTS = {
    "spheres that lose speed": ("two_spheres", "contact.restitution=0.7"),
    "spheres, slow and soft": ("two_spheres", "contact.restitution=0.4", "motion.first_velocity=0.05"),
    "beam struck aside": ("sphere_on_beam_drop_50mm_shear", "blow.point=0.31"),
    "beam, thin": ("sphere_on_beam_drop_50mm_shear", "beam.height=5e-3"),
    "beam, hard blow": ("sphere_on_beam_drop_600mm_shear", "beam.height=2e-2"),
    "beam, auto": ("sphere_on_beam", "beam.theory=auto"),
    "ellipsoid, rough": ("ellipsoid_rocking", "contact.friction_coefficient=0.4"),
    "ellipsoid, lively": ("ellipsoid_on_plane", "contact.restitution=0.9", "run.duration=0.2"),
    "bodies, without friction": ("two_bodies_ellipsoid", "contact.friction_coefficient=0", "run.duration=0.1"),
    "shaft, slow": ("shaft_two_6203", "drive.speed=40"),
    "shaft, hurried": ("shaft_angular_pair", "drive.change={time: 5e-3, speed: 300}"),
    "discs, slow": ("soft_discs_mean", "motion.first_velocity=0.4"),
    "discs, half as fast": ("soft_discs_fast", "motion.first_velocity=50"),
}
CASES = {name: (name,) for name in SCENES} | VARIANTS


class Judged(NamedTuple):
    """A run's report, and what errors are of, by output that is wanted."""

    report: Any
    values: dict[str, np.ndarray]


def _loads(blocks: list, names: tuple[str, ...]) -> np.ndarray:
    """Channels of every output, side by side (outputs, numbers)."""
    columns = (np.concatenate([block.values[name].reshape(len(block), -1) for block in blocks]) for name in names)
    return np.concatenate(list(columns), axis=1)


def _contacts(figures: dict) -> np.ndarray:
    """Peak loads and impulses of contacts in their order, and when each began (n, 3)."""
    rows = [(one["peak_force_n"], one["impulse_ns"] or 0.0, one["start_s"]) for one in figures["contacts"]]
    return np.array(rows).reshape(-1, 3)


VALUES = {
    "ball_loads": lambda blocks, figures: _loads(blocks, tuple(f"{side}_normal_load" for side in SIDES)),
    "forces": lambda blocks, figures: _loads(blocks, ("normal_load",)),
    "peaks": lambda blocks, figures: np.array([figures["peak_force_n"], figures["contact_duration_s"]]),
    "contacts": lambda blocks, figures: _contacts(figures),
}
"""By output that is wanted: what is compared."""


def run_of(words: tuple[str, ...]) -> Judged:
    """A run of a scene, the first word, with overrides, to its end."""
    run = Run(load_scene(words[0], words[1:]))
    blocks = list(run.blocks())
    report = run.report
    return Judged(report, {name: VALUES[name](blocks, report.figures) for name in report.errors["wanted_errors"]})


def _over_greatest(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def _root_mean_square(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def _of_peaks(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found / exact - 1.0).max())


def _of_contacts(found: np.ndarray, exact: np.ndarray) -> float:
    """Of peaks and impulses; a contact that one of both has not, which are its least, is off by all."""
    found, exact = found[:, :2], exact[:, :2]
    if not len(exact):
        return math.inf if len(found) else 0.0
    both, none = paired(list(found), list(exact), lambda one: one[0]), np.zeros(2)
    off = [np.abs((none if one is None else one) - (none if true is None else true)) for one, true in both]
    return float((np.array(off) / np.maximum(exact.max(axis=0), 1e-300)).max())


NORMS = {"ball_loads": _over_greatest, "forces": _over_greatest, "peaks": _of_peaks, "contacts": _of_contacts}


def _begun_before(name: str, values: np.ndarray, until: float) -> np.ndarray:
    """Contacts that began within so many seconds; other outputs whole."""
    return values[values[:, 2] < until] if name == "contacts" else values


def apart(kind: str, found: Judged, exact: Judged, until: float = math.inf) -> float:
    """The greatest error of what `found` has, each in its norm; of contacts, those that began within `until` [s]."""
    norms = NORMS | ({"forces": _root_mean_square} if kind == "soft_discs" else {})
    both = {name: (values, exact.values[name]) for name, values in found.values.items()}
    return max(norms[name](*(_begun_before(name, one, until) for one in pair)) for name, pair in both.items())


def kind_of_case(case: str) -> str:
    """The kind of a case's scene."""
    return load_scene(CASES[case][0]).kind


@functools.lru_cache(maxsize=2)
def _exact(case: str, wanted: tuple[str, ...]) -> tuple[Judged, Judged]:
    truth = TRUTHS[kind_of_case(case)]
    return tuple(run_of((*CASES[case], *wanted, *words, ALONE)) for words in (truth.exact, truth.rougher))


def judge(case: str, method: str, tolerance: float, limit: float) -> ToleranceRow:
    """One run beside the truth, with what one of WANTED wants."""
    row = ToleranceRow(case, method, tolerance, command=_command(case, method, tolerance))
    with contextlib.suppress(BearingTwinError):  # which the run itself tells in its row
        _exact(case, WANTED[method])  # before time counts
    return judged(row, lambda: _outcome(case, method, tolerance), limit)


def _outcome(case: str, method: str, tolerance: float) -> dict:
    kind, wanted = kind_of_case(case), WANTED[method]
    exact, rougher = _exact(case, wanted)
    start = time.thread_time()
    found = run_of((*CASES[case], *wanted, f"wanted.tolerance={tolerance!r}"))
    seconds = time.thread_time() - start
    errors = found.report.errors
    horizon, told = errors.get("horizon_s", math.nan), errors["wanted_errors"].values()
    until = horizon if math.isfinite(horizon) else math.inf
    estimates = [one["error"] for one in told]
    return {
        "load_error": apart(kind, found, exact, until),
        "load_known": max(KNOWABLE, CLEAR * apart(kind, rougher, exact, until)),
        "load_estimate": math.nan if None in estimates or until < math.inf else max(estimates),
        "to_the_end": apart(kind, found, exact),
        "horizon": horizon,
        "told": found.report.status.partition(":")[0],
        "seconds": seconds,
    }


def _command(case: str, method: str, tolerance: float) -> str:
    return command_of(CASES[case][0], (*CASES[case][1:], *WANTED[method], f"wanted.tolerance={tolerance:g}"))


def _entries(case: str) -> Iterator[tuple[str, float]]:
    methods = (METHOD, PEAKS) if TRUTHS[kind_of_case(case)].peaks else (METHOD,)
    yield from ((method, tolerance) for method in methods for tolerance in TOLERANCES)


def reading(points: list[ToleranceRow]) -> Iterator[str]:
    """What the chart says, of all and by group."""
    if refused := [p for p in points if p.status == REFUSED]:
        yield f"Of {len(points)} runs {len(refused)} are refused: no model keeps what is wanted."
    for who, cases in (("As shipped", SCENES), ("Variants", VARIANTS)):
        good = [p for p in points if p.problem in cases and p.status == DONE]
        if not good:
            continue
        kept = f"the error is within the tolerance in {sum(p.kept for p in good)} of {len(good)} runs; {said(good)}"
        near = nearness([p for p in good if not p.bounded])
        yield from (f"{who}: {sentence}" for sentence in (kept, *unsaid(good), *unknown(good), near))
        if lost := [p for p in good if p.missed]:
            names, doubtful = ", ".join(dict.fromkeys(p.problem for p in lost)), sum(p.doubtful for p in lost)
            yield f"{who}: {len(lost)} err by more than is wanted ({names}); {doubtful} of these say so."


CONTESTS = {
    "bodies": Chart(
        judge=judge,
        problems={name: name for name in CASES},
        entries=_entries,
        kind=ToleranceRow,
        command=_command,
        drawn=functools.partial(draw_all, title="Shafts, impacts, beams, soft discs: a tolerance and what it is worth"),
        told=reading,
    )
}
