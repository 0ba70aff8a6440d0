"""Paper 2, figures 1 to 5: a sphere falls on a beam from 50 and 600 mm, by both beam theories; two of its conclusions.

The paper computed with solid elements and prints no dimension but the heights; the drawings are those of the shipped
scenes. "Local deformation lengthens the contact" is held against a rigid contact: the sphere sticks to the beam while
it presses on it. That has a finite force on Timoshenko's beam alone: v times the impedance 2 sqrt(K G A rho A) of its
shear waves at the touch, after which the waves relieve it. "The stress dies down faster when the height is smaller" is
read off the stress after the last contact, period by period of the first mode.
"""

import functools
import math

import numpy as np

from bearing_twin.charts.sheets import Axis, Line, Panel, Sheet, SheetRow, Sheets
from bearing_twin.kinds.beam.derived import resolve
from bearing_twin.kinds.beam.motion import throw_scene
from bearing_twin.kinds.beam.parameters import BEAM_THEORIES, TIMOSHENKO
from bearing_twin.kinds.beam.watched import WatchedPoints
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.reference.struck_beam import strike
from bearing_twin.run.scene import load_scene

HEIGHTS = {50: (2, 4), 600: (3, 5)}  # mm: the paper's figures of bodies and of curves
LOOKS = {"euler": "--", "timoshenko": "-"}
TIME, LENGTH = Axis("time", "s"), Axis("along the beam", "m", shown=(1e3, "mm"))
SHOWN = 1.5e-3  # s of the curves
TOUCH = 1.2e-4  # s of the forces: the first contact
CELLS = 800  # of the beam under a rigid contact
DAMPING = 0.005  # of every mode: without damping nothing dies down
PERIODS = 8  # of the first mode after the last contact
FOOTER = "steel sphere, radius 10 mm, on a steel beam of 10 x 10 x 153.5 mm"


@functools.lru_cache(maxsize=16)
def motion(height: int, theory: str, damping: float = 0.0, duration: float = 0.0):
    """(parameters, motion, watch) of the fall from `height` [mm]; `duration` [s] in place of the scene's."""
    given = [f"beam.theory={theory}", f"beam.damping_ratio={damping!r}", f"run.duration={duration!r}"]
    parameters = resolve(load_scene(f"sphere_on_beam_drop_{height}mm", given).parameters)
    found = throw_scene(parameters)
    return parameters, found, WatchedPoints(parameters, found)


def drops(update) -> Sheet:
    """Figures 1, 2 and 3: the problem, where the sphere starts, the touch and the greatest deflection."""
    problem = Panel("figure 1", "Figure 1: the problem", LENGTH, _up(), _bodies(), "upper right", to_scale=True)
    rows, reading = [[problem], []], []
    for place, (height, (figure, _)) in enumerate(HEIGHTS.items()):
        parts, seen = _bodies(1e-3 * height), []
        title = f"Figure {figure}a: {height} mm above"
        rows[0].append(Panel(f"figure {figure}a", title, LENGTH, _up(), parts, None, to_scale=True))
        lines = []
        for theory in BEAM_THEORIES:
            for colour, (name, when, shape, bottom) in enumerate(_instants(height, theory)):
                look = {"color": BALL_COLOURS[3 * colour + 2], "linewidth": 2.4, "linestyle": LOOKS[theory]}
                span = motion(height, theory)[1].beam.span
                at, words = np.linspace(0.0, span, len(shape)), f"{name}, {theory.capitalize()}"
                lines.append(Line(f"{words}, {1e6 * when:.0f} µs", at, -shape, look))
                dot = look | {"marker": "o", "markersize": 9, "linestyle": "", "alpha": 0.7}
                lines.append(Line(f"sphere's lowest point, {words}", [0.5 * span] * 2, [-bottom] * 2, dot, False))
            seen.append(f"{1e6 * shape.max():.1f} µm at {1e6 * when:.0f} µs by {theory.capitalize()}")
        title = f"Figure {figure}b and c: fall from {height} mm"
        deflected = Axis("height above rest", "m", limits=(-1.15 * shape.max(), 0.6 * shape.max()))
        rows[1].append(Panel(f"figure {figure}b, c", title, LENGTH, deflected, lines, "upper right"))
        reading.append(f"The beam is bent most, by the fall from {height} mm, by {' and '.join(seen)}.")
        update((place + 1) / len(HEIGHTS))
    return Sheet("Paper 2: a sphere falls on a beam", rows, f"{FOOTER}; dots: the sphere's lowest point", reading)


def histories(update) -> Sheet:
    """Figures 4 and 5: deflection and stress at the point of impact and at quarters of the span, by both theories."""
    rows, reading = [[], []], []
    times, footer = np.linspace(0.0, SHOWN, 801), f"{FOOTER}; undamped; lines as in the first panel"
    for place, (height, (_, figure)) in enumerate(HEIGHTS.items()):
        panels, told = ([], []), []
        for theory in BEAM_THEORIES:
            _, found, watch = motion(height, theory)
            values = dict(zip(("deflection", "stress"), watch.at_points(times), strict=True))
            for parts, kind in zip(panels, ("deflection", "stress"), strict=True):
                for column, (colour, name) in {0: (0, "impact"), 1: (5, "1/4 and 3/4 of the span")}.items():
                    look = {"color": BALL_COLOURS[colour], "linestyle": LOOKS[theory], "linewidth": 1.7}
                    parts.append(Line(f"{name}, {theory.capitalize()}", times, values[kind][:, column], look))
            peaks = ", ".join(f"{contact.peak_force:.1f}" for contact in found.contacts)
            left = -found.motions[-1, 1] / found.motions[0, 1]
            told.append(f"by {theory.capitalize()} {peaks} N and a restitution of {left:.4f}")
        names = ("a", "deflection", "downward"), ("b", "bending stress", "lower fibre")
        for row, parts, (letter, what, which) in zip(rows, panels, names, strict=True):
            up = Axis(f"{what}, {which}", "m" if letter == "a" else "Pa")
            title = f"Figure {figure}{letter}: {what}, fall from {height} mm"
            row.append(
                Panel(f"figure {figure}{letter}", title, TIME, up, parts, None if place or letter == "b" else "best")
            )
        reading.append(f"The contacts of the fall from {height} mm reach {'; '.join(told)}.")
        update((place + 1) / len(HEIGHTS))
    return Sheet("Paper 2: deflection and stress of the beam", rows, footer, reading)


def claims(update) -> Sheet:
    """Two conclusions: local deformation lengthens the contact; the stress dies down faster for the smaller height."""
    panels, reading = [], []
    for height in HEIGHTS:
        panel, sentence = _force(height)
        panels.append(panel)
        reading.append(sentence)
        update(0.2 * len(panels))
    after = {
        (height, theory, damping): stress_after(height, theory, damping)
        for height in HEIGHTS
        for theory in BEAM_THEORIES
        for damping in (0.0, DAMPING)
    }
    rows = [panels, [_decay(after, damping) for damping in (0.0, DAMPING)]]
    footer = f"{FOOTER}; the rigid contact, by {CELLS} cells, overshoots at its first step"
    return Sheet("Paper 2: two of its conclusions", rows, footer, reading + _decay_read(after))


def _force(height):
    """The first contact with and without local deformation, and a sentence on it."""
    soft, rigid = first_contacts(height)
    times = np.linspace(0.0, TOUCH, 601)
    force = motion(height, TIMOSHENKO)[1].at(times)[1]
    lines = [
        Line("rigid contact", rigid.time, rigid.force, {"color": BALL_COLOURS[5], "linewidth": 1.4}),
        Line("with Hertz's local deformation", times, force, {"color": BALL_COLOURS[0], "linewidth": 2.2}),
    ]
    ends, peak = rigid.contacts[[0, -1], 1], rigid_force(height)
    holds = soft.duration > ends[-1] and soft.peak_force < peak
    sentence = (
        f"From {height} mm local deformation lengthens the contact from {1e6 * ends[0]:.1f} µs, or "
        f"{1e6 * ends[-1]:.1f} µs with a short second touch, to {1e6 * soft.duration:.1f} µs, and takes its peak from "
        f"{1e-3 * peak:.3g} to {1e-3 * soft.peak_force:.3g} kN: the paper's claim {'holds' if holds else 'fails'}."
    )
    title = f"Contact force on Timoshenko's beam, fall from {height} mm"
    return Panel(f"force {height}", title, TIME, Axis("force", "N"), lines), sentence


def _decay(after, damping):
    """The stress after the last contact, period by period."""
    parts = []
    for colour, height in enumerate(HEIGHTS):
        for theory in BEAM_THEORIES:
            look = {"color": BALL_COLOURS[5 * colour], "linestyle": LOOKS[theory], "marker": "o"}
            shares = after[height, theory, damping][0]
            parts.append(Line(f"{height} mm, {theory.capitalize()}", np.arange(PERIODS), shares, look))
    across = Axis("periods of the first mode after the last contact", "1")
    up = Axis("r.m.s. stress, first period = 1", "1", limits=(0.0, 1.2))
    how = f"{100.0 * damping:g} % of critical damping" if damping else "undamped"
    return Panel(f"decay {damping:g}", f"Stress at the point of impact, {how}", across, up, parts, "lower left")


def _decay_read(after) -> list[str]:
    """What the stress does after the last contact."""

    def shares(damping, pick):
        """Of both heights by each theory, per cent."""
        rows = {one: [100.0 * pick(after[height, one, damping]) for height in HEIGHTS] for one in BEAM_THEORIES}
        words = (f"{small:.0f} and {large:.0f} % by {one.capitalize()}" for one, (small, large) in rows.items())
        return " and ".join(words), all(small < large for small, large in rows.values())

    left, _ = shares(0.0, lambda found: found[1])
    later, faster = shares(DAMPING, lambda found: found[0][-1])
    return [
        "Without damping the stress does not die down at all after the last contact, from either height.",
        f"What the last contact leaves of the greatest stress (r.m.s.) is, for 50 and 600 mm, {left}: the later "
        "contacts decide that, and they follow the beam theory more than the height.",
        f"With {100.0 * DAMPING:g} % of critical damping it is, {PERIODS - 1} periods on, for 50 and 600 mm at {later} "
        f"of what it was: the paper's 'faster when the height is smaller' {'holds' if faster else 'does not hold'}.",
    ]


def first_contacts(height: int):
    """The first contact on Timoshenko's beam with Hertz's spring, and the whole blow of a rigid contact."""
    parameters, found, _ = motion(height, TIMOSHENKO)
    speed = float(found.motions[0, 1])
    rigid = strike(found.beam, found.sphere.mass, math.inf, speed, parameters.blow.point, TOUCH, CELLS)
    return found.contacts[0], rigid


def rigid_force(height: int) -> float:
    """Peak force [N] of a rigid contact on Timoshenko's beam, at the touch: v times the impedance of shear waves."""
    beam, speed = motion(height, TIMOSHENKO)[1].beam, float(motion(height, TIMOSHENKO)[1].motions[0, 1])
    return 2.0 * speed * math.sqrt(beam.shear_rigidity * beam.mass / beam.span)


@functools.lru_cache(maxsize=16)
def stress_after(height: int, theory: str, damping: float):
    """R.m.s. stress at the impact by periods after the last contact, the first being 1; the first over the greatest."""
    period = 2.0 * math.pi / float(motion(height, theory)[1].modes.omega.min())
    _, found, watch = motion(height, theory, damping, 1e-3 + PERIODS * period)
    last = max(contact.start + contact.duration for contact in found.contacts)
    times = last + period * np.linspace(0.0, PERIODS, 1000 * PERIODS, endpoint=False)
    square = watch.at_points(times)[1][:, 0].reshape(PERIODS, -1) ** 2
    sizes = np.sqrt(square.mean(axis=1))
    return sizes / sizes[0], float(sizes[0] / watch.greatest()[1].value)


def _up() -> Axis:
    return Axis("height", "m", shown=(1e3, "mm"))


def _bodies(above: float = 0.0) -> list[Line]:
    """Beam, supports and sphere as outlines; lengths and the fall in words, where the sphere touches."""
    parameters = load_scene("sphere_on_beam_drop_50mm").parameters
    span, thick, radius = parameters.beam.span, parameters.beam.height, parameters.sphere.radius
    ink = {"color": STYLE["ink"], "linewidth": 2.0}
    turn, middle = np.linspace(0.0, 2.0 * math.pi, 121), 0.5 * span
    box = Line(f"beam, {1e3 * thick:g} x {1e3 * thick:g} x {1e3 * span:g} mm", [0.0, span, span, 0.0, 0.0],
               [0.0, 0.0, -thick, -thick, 0.0], ink)  # fmt: skip
    sphere = Line(f"sphere, radius {1e3 * radius:g} mm", middle + radius * np.cos(turn),
                  above + radius * (1.0 + np.sin(turn)), {"color": BALL_COLOURS[0], "linewidth": 2.0})  # fmt: skip
    foot = thick * np.array([0.0, -0.7, 0.7, 0.0])
    grey = {"color": STYLE["edge"], "linewidth": 2.0}
    feet = [
        Line("supports", at + foot, [-thick, -2.2 * thick, -2.2 * thick, -thick], grey, not at) for at in (0.0, span)
    ]
    fall = {"color": BALL_COLOURS[5], "linewidth": 2.0, "marker": "v"}
    start = above or 0.05
    words = "falls from h = 50 and 600 mm" if not above else f"h = {1e3 * above:g} mm"
    across = middle + (1.6 * radius if above else 0.0)
    path = Line(words, [across, across], [start, 2.2 * radius if not above else 0.0], fall)
    return [box, sphere, *feet, path]


def _instants(height, theory):
    """(name, time [s], shape [m] and sphere's lowest point [m], downward) at the touch and at the greatest bend."""
    _, found, watch = motion(height, theory)
    times = np.linspace(0.0, min(found.end, SHOWN), 2001)
    approach, _, position, *_, shape, _, _, _ = watch(times)
    rows = {"touch": 0, "greatest deflection": int(shape.max(axis=1).argmax())}
    return [
        (name, float(times[row]), shape[row], float(position[row] - max(approach[row], 0.0)))
        for name, row in rows.items()
    ]


SHEETS = Sheets(
    "paper2",
    {"drops": SheetRow((1, 2, 3), drops), "histories": SheetRow((4, 5), histories), "claims": SheetRow((), claims)},
)
