"""What a tolerance is worth: the error asked for against the error got, and what the run itself says its error is.

Shipped bearing scenes, shortened, and variants of them, run as `simulate` runs them, against the same scene at a
tolerance so tight that it counts as true. Errors are those of the chart of steppers: of load over the greatest load, of
friction over mu N of a contact or mu N R of a ball, at every output.
"""

import functools
from collections.abc import Iterator
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bearing_twin.charts.contest import DONE, FAILED, STOPPED, Made, Row, Task, Wanted, answers_of, limited
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import read_points, write_points
from bearing_twin.charts.work_precision import errors
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, stamp
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Run, simulate

EXACT = 1e-8
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
KNOWABLE = 1e-8  # true errors below this are not compared with estimates: the reference is no better
NEAR, FAR = 3.0, 10.0  # factors between estimate and true error
OUTPUTS = ("loads", "friction")
ALONE = "solver.companion=off"
CASES = {  # name: scene, what differs; those after the seventh are variants
    "settled": ("bearing_6203", ("run.duration=0.2",)),
    "6205": ("bearing_6205", ("run.duration=0.2",)),
    "fast": ("bearing_6203_fast", ("run.duration=0.1",)),
    "sticking": ("bearing_6203_sticking", ("run.duration=0.05",)),
    "lift-off": ("bearing_6203_loose", ("run.duration=0.2",)),
    "from rest": ("bearing_6203_start", ()),
    "sudden": ("bearing_6203_sudden", ("run.duration=0.05",)),
    "slippery": (
        "bearing_6203",
        ("run.duration=0.1", "contact.friction_coefficient=0.02", "drive.offset=[0,-2e-6,2e-5]"),
    ),
    "sped up": ("bearing_6203", ("run.duration=0.1", "drive.change.time=0.03", "drive.change.speed=50")),
    "lift-off, faster": ("bearing_6203_loose", ("run.duration=0.1", "drive.speed=400")),
    "lift-off, wider": (
        "bearing_6203_loose",
        ("run.duration=0.1", "geometry.radial_clearance=20e-6", "drive.offset=[2e-6,-14e-6,0]"),
    ),
    "6205, lift-off": (
        "bearing_6205",
        ("run.duration=0.1", "geometry.radial_clearance=10e-6", "drive.offset=[0,-8e-6,0]"),
    ),
    "from rest, off centre": (
        "bearing_6203_start",
        ("run.duration=0.02", "drive.speed=90", "drive.offset=[3e-6,-2e-6,8e-6]"),
    ),
    "sudden, harder": ("bearing_6203_sudden", ("run.duration=0.04", "drive.change.offset=[2e-6,-5e-6,1e-6]")),
}


problems = {name: name for name in CASES}
"""What may be asked for alone, as in every contest."""


@dataclass(frozen=True)
class TolerancePoint:
    """One run: the tolerance asked for, true and estimated errors of load and friction, its status, and its steps.

    `steps` are those of a run that nobody watches, `watched_steps` those with what was done again, `companion_steps`
    the companion's. `problem` is empty unless the run failed.
    """

    case: str
    tolerance: float
    load_error: float = np.nan
    friction_error: float = np.nan
    load_estimate: float = np.nan
    friction_estimate: float = np.nan
    status: str = ""
    steps: int = 0
    watched_steps: int = 0
    companion_steps: int = 0
    problem: str = ""

    @property
    def error(self) -> float:
        """The greater of both true errors."""
        return max(self.load_error, self.friction_error)

    @property
    def kept(self) -> bool:
        """Whether the error is what was asked for."""
        return self.error <= self.tolerance

    @property
    def ratios(self) -> list[float]:
        """Estimates over true errors, of those that can be known."""
        pairs = ((self.load_estimate, self.load_error), (self.friction_estimate, self.friction_error))
        return [found / true for found, true in pairs if true > KNOWABLE]


def _run(case: str, *overrides: str) -> tuple[Run, Rows]:
    """A run of a case to its end, and all its outputs but the first."""
    name, differs = CASES[case]
    run = simulate(load_scene(name, (*differs, *overrides)))
    blocks = list(run.blocks())
    return run, Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])


@functools.lru_cache(maxsize=1)
def _exact(case: str) -> Rows:
    """The outputs that count as true; a process is at one case at a time."""
    return _run(case, f"wanted.tolerance={EXACT!r}", ALONE)[1]


def judge(case: str, tolerance: float, limit: float) -> tuple:
    """One run beside the truth, as the numbers of a TolerancePoint; the process ends beyond `limit` CPU seconds."""
    with limited(limit):
        return astuple(_point(case, tolerance, _exact(case)))


def _point(case: str, tolerance: float, exact: Rows) -> TolerancePoint:
    asked = f"wanted.tolerance={tolerance!r}"
    try:
        run, found = _run(case, asked)
        plain, _ = _run(case, asked, ALONE)
    except BearingTwinError as error:
        return TolerancePoint(case, tolerance, problem=str(error))
    wanted, costs = run.report.errors["wanted_errors"], run.report.costs
    estimates = (wanted[name]["error"] for name in OUTPUTS)
    return TolerancePoint(
        case,
        tolerance,
        *errors(BearingMotion(run.scene.parameters, run.choice), found, exact),
        *(np.nan if one is None else one for one in estimates),
        run.report.status,
        plain.report.costs["ball_steps"],
        costs["ball_steps"],
        costs["companion_ball_steps"],
    )


def measure(wanted: Wanted, tolerances=TOLERANCES) -> list[TolerancePoint]:
    """Every case that is wanted at every tolerance."""
    tasks = [Task("tolerance:judge", (case, one, wanted.limit)) for case in wanted.problems for one in tolerances]
    answers = answers_of(tasks, wanted.kept, wanted.update, wanted.workers)
    stopped = f"{STOPPED} after {wanted.limit:g} CPU seconds"
    return [
        TolerancePoint(*task.arguments[:2], problem=stopped) if answer is None else TolerancePoint(*answer)
        for task, answer in zip(tasks, answers, strict=True)
    ]


def make(folder: Path, name: str, wanted: Wanted) -> Made:
    """Runs the contest, and writes picture and table."""
    points = measure(wanted)
    picture, table = folder / f"{name}.png", folder / f"{name}.csv"
    draw(points, picture)
    write_table(points, table)
    return Made(list(reading(points)), [str(picture)], [str(table)], list(map(_row, points)))


def read(folder: Path, name: str) -> list[str]:
    """What the chart says, from the table that was written there before."""
    return list(reading(read_points(folder / f"{name}.csv", TolerancePoint)))


def _row(point: TolerancePoint) -> Row:
    scene, differs = CASES[point.case]
    return Row(
        point.case,
        "as chosen",
        point.tolerance,
        load_error=point.load_error,
        friction_error=point.friction_error,
        evaluations=point.watched_steps + point.companion_steps,
        status=FAILED if point.problem else DONE,
        reason=point.problem or point.status,
        command=command_of(scene, (*differs, f"wanted.tolerance={point.tolerance:g}")),
    )


write_table = write_points


def _look(number: int) -> dict:
    return {"color": BALL_COLOURS[number % len(BALL_COLOURS)], "marker": "os^Dv"[number // len(BALL_COLOURS)]}


def draw(points: list[TolerancePoint], path: Path) -> None:
    """Error got over tolerance asked, and estimates over true errors; open marks are doubtful runs."""
    figure = Figure(figsize=(15, 8.4), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    good = [p for p in points if not p.problem]
    names = list(dict.fromkeys(p.case for p in points))
    for number, case in enumerate(names):
        look = _look(number)
        for p in (p for p in good if p.case == case):
            fill = "none" if p.status.startswith("doubtful") else look["color"]
            shift = 1.0 + 0.03 * (number - 0.5 * len(names))  # side by side
            left.plot(p.tolerance * shift, p.error, look["marker"], mfc=fill, mec=look["color"], ms=9, mew=1.6)
            true = [error for error in (p.load_error, p.friction_error) if error > KNOWABLE]
            right.plot(true, p.ratios, look["marker"], mfc=fill, mec=look["color"], ms=8, mew=1.4, linestyle="none")
        left.plot([], [], look["marker"], mfc=look["color"], mec=look["color"], ms=9, linestyle="none", label=case)
    ends = np.array([min(p.tolerance for p in points), max(p.tolerance for p in points)])
    left.plot(ends, ends, color=STYLE["ink"], linewidth=1.5)
    middle = float(np.sqrt(ends.prod()))
    left.text(0.8 * middle, 1.5 * middle, "as asked", ha="right", fontsize=13, color=STYLE["ink"])
    for factor in (1.0 / FAR, 1.0 / NEAR, 1.0, NEAR, FAR):
        right.axhline(
            factor, color=STYLE["ink"], linewidth=1.5 if factor == 1.0 else 1.0, linestyle="-" if factor == 1.0 else ":"
        )
    left.set(
        xscale="log", yscale="log", xlabel="tolerance asked for", ylabel="true error of load or friction, the greater"
    )
    right.set(xscale="log", yscale="log", xlabel="true error", ylabel="what the run says of it / true error")
    heading(left, "error got (open marks: the run calls itself doubtful)")
    heading(right, f"estimates (dotted: factors {NEAR:g} and {FAR:g})")
    for axis in (left, right):
        frame(axis)
    figure.legend(loc="outside right upper", fontsize=12, frameon=False)
    figure.suptitle("A tolerance and what it is worth", fontsize=16, color=STYLE["ink"])
    stamp(figure)
    figure.savefig(path, dpi=100)


def _share(number: int, total: int) -> str:
    return f"{number} of {total}"


def reading(points: list[TolerancePoint]) -> Iterator[str]:
    """What the chart says."""
    good = [p for p in points if not p.problem]
    missed = [p for p in good if not p.kept]
    ratios = np.array([ratio for p in good for ratio in p.ratios])
    yield f"The error is within the tolerance in {_share(len(good) - len(missed), len(points))} runs."
    unsaid = [p for p in missed if not p.status.startswith("doubtful")]
    worst = max((p.error / p.tolerance for p in missed), default=0.0)
    if missed:
        yield (
            f"Where it is not, the run calls itself doubtful in {_share(len(missed) - len(unsaid), len(missed))}; the "
            f"greatest error is {worst:.2g} times the tolerance."
        )
    if unsaid:
        yield "Unsaid: " + "; ".join(f"{p.case} at {p.tolerance:g}, {p.error:.2g}" for p in unsaid) + "."
    near = int(((ratios > 1.0 / NEAR) & (ratios < NEAR)).sum())
    yield (
        f"Estimates are within a factor {NEAR:g} of the true error in {_share(near, len(ratios))}, less than a tenth "
        f"of it in {int((ratios < 1.0 / FAR).sum())}, more than {FAR:g} times it in {int((ratios > FAR).sum())}."
    )
    shares = [p.companion_steps / p.watched_steps for p in good if p.watched_steps]
    costs = [(p.companion_steps + p.watched_steps) / p.steps for p in good if p.steps]
    yield (
        f"The companion takes {100.0 * np.median(shares):.2g} % of a run's steps as a median and "
        f"{100.0 * max(shares):.2g} % at most; with what is done again a run takes {np.median(costs):.2g} times the "
        f"steps of one that nobody watches, {max(costs):.2g} at most."
    )
    yield from (f"{p.case} at {p.tolerance:g}: {p.problem}" for p in points if p.problem)
