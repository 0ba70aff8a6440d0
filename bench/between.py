"""Contacts explicit, friction and damping linearly implicit: `python bench/between.py [folder [problem ...]]`.

Methods between explicit and implicit ones (`between_steps.py`), adaptive, against the product's by problems of
`bearing_twin chart steppers` and its norm. Prints the order of each on balls that ring, and what it costs; with a
folder, writes between.csv and between.png there.
"""

import sys
from pathlib import Path

import numpy as np
from between_steps import METHODS, advance_between

from bearing_twin.charts.bearing_cells import Case, bearing_row, command_of, errors, motion_of, truth, worked
from bearing_twin.charts.contest_picture import Contest, cheapest
from bearing_twin.charts.table import Row, write_table
from bearing_twin.charts.timing import LONG_ENOUGH
from bearing_twin.charts.work_precision import CASES, WANTED
from bearing_twin.charts.work_precision import PROBLEMS as TITLES
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.forces.handing import handed
from bearing_twin.kinds.bearing.forces.layout import VELOCITY
from bearing_twin.kinds.bearing.motion import BearingMotion, drive_later
from bearing_twin.kinds.bearing.stepping.integrate import check
from bearing_twin.numerics.stretches import alike
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene
from bearing_twin.units import two_digits

BETWEEN, PRODUCT, EXPLICIT = tuple(METHODS), ("rodas4", "rodas3"), "dopri5"
JUMP = CASES["sudden"]._replace(overrides=("drive.change.time=2e-4", "drive.change.speed=0"))
PROBLEMS = {name: CASES[name] for name in ("sudden", "sliding", "lift-off", "settled")}
PROBLEMS |= {"ringing": JUMP, "rung": JUMP._replace(period=1e-3)}
TITLED = {name: TITLES.get(name) for name in PROBLEMS} | {
    "ringing": "sudden load: ringing, 1 ms",
    "rung": "the same, 20 ms",
}
LADDER = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
HELD = (1e-2, 1e-3, 1e-4)  # errors at which costs are compared


class BetweenMotion(BearingMotion):
    """A case's bearing, whose balls do not meet, by one of METHODS at a tolerance."""

    def __init__(self, case: Case, method: str, tolerance: float):
        scene = load_scene(case.scene, (*case.overrides, f"wanted.tolerance={tolerance!r}"))
        super().__init__(scene.parameters, Choice("hertz", "rodas4", 0.0, "", ()))
        self.method = METHODS[method]

    def _integrate(self, partners, drive, near, begin, times, duration, filled):
        if near.any():
            raise BearingTwinError("balls may meet; a method between steps each alone")
        drive = drive_later(drive, begin)
        failure, (states, orientations, borders) = np.zeros(2), filled
        pointer = self._pointer(len(times))
        room = states, orientations, self.counts, failure, self.stop, self.carried, borders, self.border, pointer
        own, balls = alike(len(self.state), duration, len(times)), np.arange(len(self.state))
        what = handed(self.bearing), tuple(drive), tuple(self.method), times, duration, self.scales, tuple(own)
        moving = balls, self.state, self.orientation, self.steps
        check(advance_between(*what, *moving, room), self.elapsed + begin, failure)
        return pointer


def judge(name: str, method: str, setting: float, limit: float = 0.0, enough: float = LONG_ENOUGH) -> Row:
    """One run of a problem by a method at a tolerance."""
    case = PROBLEMS[name]
    if method not in METHODS:
        row = Row(name, method, setting, command=command_of(case, method, setting))
        return bearing_row(row, case, limit, enough=enough)
    motion = BetweenMotion(case, method, setting)

    def work():
        motion.reset()
        return motion.advance(case.times, case.seconds), motion.costs()["ball_rates"]

    return worked(Row(name, method, setting), work, motion, case, truth(case), limit, enough)


def compared(rows: list[Row], name: str) -> list[str]:
    """What a problem takes by the cheapest method between over what it takes by the product's cheapest.

    A cell for each of HELD: CPU time, evaluations of rates, and who they are of; "-" where either has none so good.
    """
    cells = []
    for error in HELD:
        found = [[cheapest(rows, name, one, error) for one in which] for which in (BETWEEN, PRODUCT)]
        if not all(map(any, found)):
            cells.append("-")
            continue
        best, other = (min(filter(None, one), key=lambda row: row.seconds) for one in found)
        time, count = (two_digits(getattr(best, key) / getattr(other, key)) for key in ("seconds", "evaluations"))
        cells.append(f"{time}, evaluations {count} ({best.method}, {other.method})")
    return cells


def told(rows: list[Row]) -> list[str]:
    """A sentence a problem on `compared`."""
    held = ", ".join(f"{error:g}" for error in HELD)
    names = dict.fromkeys(row.problem for row in rows)
    return [
        f"{CHART.problems[name]}: within {held} the cheapest method between takes so many times what the product does: "
        f"{'; '.join(compared(rows, name))}."
        for name in names
    ]


CHART = Contest(
    judge=judge,
    problems=TITLED,
    entries=lambda name: ((method, setting) for setting in LADDER for method in (*BETWEEN, *PRODUCT, EXPLICIT)),
    title="Contacts explicit, friction implicit (ARK, ROS34PW2), one core",
    error="greater error of load and of friction",
    cost="CPU s per simulated s",
    wanted=WANTED,
    own=PRODUCT,
    more=told,
)
RINGS = Case("bearing_6203", ("contact.friction_regularisation=0.3", "drive.acceleration=1e6"), 4.8e-5, 1)


def observed_order(method: str, step: float = 2.5e-7) -> tuple[float, float]:
    """By what load and friction of balls that ring, while the ring speeds up, err more in steps of 2 `step` [s].

    As powers of 2; the truth is by rk4 in steps of 20 ns.
    """
    start = motion_of(RINGS, "rodas4")
    start.advance(np.array([]), 5e-3)
    balls = np.arange(len(start.state))
    for column, angle in ((VELOCITY, 2.4), (VELOCITY + 2, 1.1)):
        start.state[:, column] += 0.03 * np.cos(angle * balls)
    exact = motion_of(RINGS, "rk4", key="solver.step=2e-8")
    found = [BetweenMotion(RINGS, method, WANTED) for _ in range(2)]
    for motion in (exact, *found):
        motion.state[:], motion.goal_speed = start.state, 1e4
        motion.advance(np.array([]), 1e-9)  # where the acceleration begins, steps are short
    true, wrong = exact.advance(RINGS.times, RINGS.seconds), []
    for motion, span in zip(found, (2.0 * step, step), strict=True):
        motion.scales = np.full_like(motion.scales, np.inf)
        for _ in range(round(RINGS.seconds / span)):
            motion.steps[:] = 1.0  # cut to the end, so that it is one step
            out = motion.advance(np.array([span]), span)
        wrong.append(errors(motion, out, true))
    return tuple(np.log2(np.divide(*wrong)).tolist())


def main(folder: str = "", *names: str) -> None:
    """Runs the problems named, or all, and prints what was found."""
    if (folder and not Path(folder).is_dir()) or not set(names) <= set(PROBLEMS):
        print(f"give a folder that exists, then some of {', '.join(PROBLEMS)}, or none for all", file=sys.stderr)
        raise SystemExit(2)
    for method in METHODS:
        print(f"{method}: order {' and '.join(f'{one:.2f}' for one in observed_order(method))} in load and in friction")
    rows = []
    for name in names or PROBLEMS:
        for method, setting in CHART.entries(name):
            rows.append(judge(name, method, setting))
            print(name, method, setting, file=sys.stderr, flush=True)
    rows.sort(key=lambda row: (list(PROBLEMS).index(row.problem), (*BETWEEN, *PRODUCT, EXPLICIT).index(row.method)))
    print(*CHART.reading(rows), sep="\n")
    if folder:
        write_table(rows, Path(folder) / "between.csv")
        CHART.draw(rows, Path(folder) / "between.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
