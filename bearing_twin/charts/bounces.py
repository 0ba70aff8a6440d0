"""Figures 3 and 4 of paper 1: a ball of radius 0.1 bounces by the Hertz and by the volumetric law, and one comes late.

The paper shows the delay in one impact and says that it is Hertz's. Which law comes late depends on the viscous term,
so three are shown. Without loss the softer, volumetric law comes late: its contacts last longer by c^(-2/5). With a
restitution held fixed it does so, too. With one function d(h) for both, as in the paper, the softer law loses more
speed, its flights become shorter, and Hertz comes late. Points are measured, lines are closed forms.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.contact.damping import steady_damping, steady_ratio
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.kinds.ellipsoid.derived import ellipsoid_mass, modulus_of
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading
from bearing_twin.pictures.worth import finish
from bearing_twin.reference import bounce
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

SCENE = "ellipsoid_on_plane"
DURATION, RESTITUTION = 3.2, 0.8  # s; of speed, at every speed, by Hertz
TOLERANCE = "wanted.tolerance=1e-11"  # two runs are subtracted
RATE = 5000.0  # Hz, of the altitude over the whole run
FINE = 2e5  # Hz, of the altitude about one impact
PAIR = ("hertz", "volumetric")
FROM_RIGHT = 2  # figure 4 shows the second impact from the right
LAST = 4  # impacts before the end of which the delay is told
CASES = {
    "no loss": (),
    "restitution 0.8 for both": (f"contact.restitution={RESTITUTION}",),
    "one d(h) for both (paper 1)": (),  # with the viscosity that gives Hertz the restitution
}


@dataclass(frozen=True)
class BouncePoint:
    """One impact: which from the start, its instant [s] by both laws, Hertz's delay [s] measured and in closed form."""

    case: str
    impact: int
    hertz_s: float
    volumetric_s: float
    hertz_delay_s: float
    closed_form_s: float


POINT = BouncePoint


def _scene(case, law, *more):
    overrides = [
        "contact.restitution=1.0",
        f"run.duration={DURATION}",
        TOLERANCE,
        f"contact.normal={law}",
        *CASES[case],
        *more,
    ]
    if "d(h)" in case:
        overrides.append(f"contact.viscosity={steady_damping(RESTITUTION, *_bodies('hertz'))!r}")
    return load_scene(SCENE, overrides)


def _bodies(law):
    """Load coefficient [N/m^1.5] and mass [kg] of the ball."""
    parameters = load_scene(SCENE).parameters
    curvature = 0.5 / parameters.body.semi_axes[0]
    coefficient = coefficient_of(law, curvature, curvature, modulus_of(parameters))
    return float(coefficient), ellipsoid_mass(parameters.body)


def _instants(case, law):
    run = simulate(_scene(case, law))
    for _ in run.blocks():
        pass
    return np.array([contact["start_s"] for contact in run.report.figures["contacts"]])


def _closed_form(case, count):
    """Hertz's delay [s] (count,) after the volumetric law."""
    parameters = load_scene(SCENE).parameters
    fall, gravity = parameters.start.height, -parameters.gravity[2]
    (hertz, mass), (soft, _) = _bodies("hertz"), _bodies("volumetric")
    ratio = steady_ratio(RESTITUTION) if "no loss" not in case else 0.0
    softer = ratio * np.sqrt(hertz / soft) if "d(h)" in case else ratio
    pairs = ((hertz, ratio), (soft, softer))
    first, second = (bounce.impact_instants(count, fall, gravity, c, mass, z) for c, z in pairs)
    return first - second


def measure() -> list[BouncePoint]:
    """All impacts of 3.2 s in the three cases."""
    points = []
    for case in CASES:
        hertz, volumetric = (_instants(case, law) for law in PAIR)
        count = min(len(hertz), len(volumetric))
        exact = _closed_form(case, count)
        points += [
            BouncePoint(
                case, n + 1, float(hertz[n]), float(volumetric[n]), float(hertz[n] - volumetric[n]), float(exact[n])
            )
            for n in range(count)
        ]
    return points


def reading(points: list[BouncePoint]) -> list[str]:
    """What the chart says, a sentence a case."""
    sentences = []
    for case in CASES:
        mine = [point for point in points if point.case == case]
        last = [point for point in mine if point.impact > 1][-LAST:]
        late = "Hertz" if last[-1].hertz_delay_s > 0.0 else "the volumetric law"
        told = ", ".join(f"{1e6 * abs(point.hertz_delay_s):.4g}" for point in last)
        off = max(abs(point.hertz_delay_s / point.closed_form_s - 1.0) for point in last)
        sentences.append(
            f"{case}: {late} comes late, by {told} µs in the last {len(last)} of {len(mine)} impacts; the closed form "
            f"is within {100.0 * off:.2g} % of it."
        )
    return sentences


def _altitude(law, rate, begin=0.0, end=DURATION):
    """Time [s] and height [m] of the centre in the paper's case."""
    run = simulate(_scene(list(CASES)[-1], law, f"run.output_rate={rate}", f"run.duration={end}"))
    blocks = [block for block in run.blocks() if 1e-9 * block.time_ns[-1] >= begin]
    time = 1e-9 * np.concatenate([block.time_ns for block in blocks])
    return time, np.concatenate([block.values["position"][:, 2] for block in blocks])


def draw(points: list[BouncePoint], path: Path) -> None:
    """Altitude over time (figure 3), one impact enlarged (figure 4), and Hertz's delay impact by impact."""
    figure = Figure(figsize=(16.0, 10.0), dpi=100, facecolor="white")
    grid = figure.add_gridspec(2, 2, left=0.06, right=0.98, top=0.89, bottom=0.1, hspace=0.32, wspace=0.2)
    looks = (("#D55E00", "-", 3.4), ("#0072B2", "--", 1.8))
    whole = figure.add_subplot(grid[0, :])
    for law, (colour, line, width) in zip(PAIR, looks, strict=True):
        time, height = _altitude(law, RATE)
        whole.plot(time, height, color=colour, linestyle=line, linewidth=width, label=law)
    paper = [point for point in points if point.case == list(CASES)[-1]]
    shown = paper[-FROM_RIGHT]
    whole.axvline(shown.hertz_s, color=STYLE["soft"], linewidth=1.0, linestyle=":")
    heading(whole, "Figure 3: altitude of the centre, one d(h) for both laws (dotted: the impact of figure 4)")
    whole.set_xlabel("time [s]")
    whole.set_ylabel("altitude [m]")
    whole.legend(frameon=False, fontsize=12, loc="upper right")
    near = figure.add_subplot(grid[1, 0])
    middle, reach = 0.5 * (shown.hertz_s + shown.volumetric_s), abs(shown.hertz_delay_s) + 1e-3
    for law, (colour, line, width) in zip(PAIR, looks, strict=True):
        time, height = _altitude(law, FINE, middle - reach, middle + reach)
        inside = time >= middle - reach
        near.plot(1e3 * (time[inside] - middle), height[inside], color=colour, linestyle=line, linewidth=width)
    near.set_xlabel(f"time after {middle:.6g} s [ms]")
    near.set_ylabel("altitude [m]")
    near.ticklabel_format(useOffset=False)
    heading(near, f"Figure 4: the second impact from the right, Hertz {1e3 * shown.hertz_delay_s:.3g} ms late")
    delays = figure.add_subplot(grid[1, 1])
    for number, case in enumerate(CASES):
        mine = [point for point in points if point.case == case and point.impact > 1]
        impacts = [point.impact for point in mine]
        colour = BALL_COLOURS[(2, 1, 0)[number]]
        delays.plot(impacts, [1e6 * abs(point.closed_form_s) for point in mine], color=colour, linewidth=1.6)
        late = "Hertz late" if mine[-1].hertz_delay_s > 0.0 else "volumetric late"
        measured = [1e6 * abs(point.hertz_delay_s) for point in mine]
        delays.plot(impacts, measured, "o", color=colour, markersize=8, label=f"{case}: {late}")
    delays.set_yscale("log")
    delays.set_ylim(0.3, 5e4)
    delays.legend(frameon=False, fontsize=11, loc="upper left")
    heading(delays, "Delay of the impacts; lines: closed forms", "impact, counted from the first", "|delay| [µs]")
    for axis in (whole, near, delays):
        frame(axis)
        axis.margins(x=0.04 if axis is delays else 0.01)
    title = "A ball of radius 0.1 m bounces by two laws: figures 3 and 4 of Kosenko and Aleksandrov"
    fall = load_scene(SCENE).parameters.start.height
    footer = f"{SCENE}, {DURATION:g} s, fall {fall:g} m, restitution {RESTITUTION:g}"
    finish(figure, title, footer, path, size=17)
