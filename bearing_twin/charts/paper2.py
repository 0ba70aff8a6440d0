"""Paper 2 (Opritescu, Tirdea, Toader 2011), figures 1 to 5: a sphere falls on a beam from 50 and 600 mm.

The paper computed with solid elements and prints no dimension but the heights; the drawings are those of the shipped
scenes. "Local deformation lengthens the contact" is held against a rigid contact on Timoshenko's beam, whose force at
the touch is v times the impedance 2 sqrt(K G A rho A) of its shear waves. "The stress dies down faster when the height
is smaller" is read off the stress after the last contact, period by period of the first mode.
"""

import functools
import math

import numpy as np

from bearing_twin.charts.panels import Axis, Line, Panel, Sheet
from bearing_twin.charts.paper import Figures, Paper
from bearing_twin.kinds.beam.derived import beam_of
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.reference.struck_beam import strike
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

HEIGHTS = {50: (2, 4), 600: (3, 5)}  # mm: the paper's figures of bodies and of curves
LOOKS = {"euler": "--", "timoshenko": "-"}
TIME, LENGTH, HEIGHT = (
    Axis("time", "s"),
    Axis("along the beam", "m", shown=(1e3, "mm")),
    Axis("height", "m", shown=(1e3, "mm")),
)
SHOWN, TOUCH = 1.5e-3, 1.2e-4  # s of the curves, of the forces at the first contact
CELLS, QUARTER = 800, 1  # of the beam under a rigid contact; the place of a quarter of the span among the channels
DAMPING, PERIODS = 0.005, 8  # of every mode; periods of the first mode after the last contact
FOOTER = "steel sphere, radius 10 mm, on a steel beam of 10 x 10 x 153.5 mm"


@functools.lru_cache(maxsize=16)
def fall(height: int, theory: str, damping: float = 0.0, duration: float = SHOWN):
    """(time [s], channels, figures, parameters) of the fall from `height` [mm]."""
    given = [f"beam.theory={theory}", f"beam.damping_ratio={damping!r}", f"run.duration={duration!r}"]
    made = simulate(
        load_scene(f"sphere_on_beam_drop_{height}mm", [*given, "run.output_rate=1e6", "run.publish_rate=1e6"])
    )
    blocks = list(made.blocks())
    names = ("normal_load", "approach", "sphere_position", "deflection", "bending_stress", "shape")
    values = {name: np.concatenate([block.values[name] for block in blocks]) for name in names}
    time = 1e-9 * np.concatenate([block.time_ns for block in blocks])
    return time, values, made.report.figures, made.scene.parameters


def drops(quick: bool) -> Sheet:
    """Figures 1, 2 and 3: the problem, the start, the touch and the greatest deflection."""
    rows = [[Panel("figure 1", "Figure 1: the problem", LENGTH, HEIGHT, _bodies(), "upper right", to_scale=True)], []]
    reading = []
    for height, (figure, _) in HEIGHTS.items():
        title = f"Figure {figure}a: {height} mm above"
        rows[0].append(Panel(f"figure {figure}a", title, LENGTH, HEIGHT, _bodies(1e-3 * height), None, to_scale=True))
        lines, seen = [], []
        for theory, dashes in LOOKS.items():
            time, values, _, parameters = fall(height, theory)
            shapes = values["shape"]
            at = np.linspace(0.0, parameters.beam.span, shapes.shape[1])
            last = int(shapes.max(axis=1).argmax())
            for place, (name, row) in enumerate({"touch": 0, "greatest deflection": last}.items()):
                words = f"{name}, {theory.capitalize()}, {1e6 * time[row]:.0f} µs"
                look = {"color": BALL_COLOURS[3 * place + 2], "linewidth": 2.4, "linestyle": dashes}
                lines.append(Line(words, at, -shapes[row], look))
            seen.append(f"{1e6 * shapes.max():.1f} µm at {1e6 * time[last]:.0f} µs by {theory.capitalize()}")
        deflected = Axis("height above rest", "m", limits=(-1.15 * shapes.max(), 0.6 * shapes.max()))
        title = f"Figure {figure}b and c: fall from {height} mm"
        rows[1].append(Panel(f"figure {figure}b, c", title, LENGTH, deflected, lines, "upper right"))
        reading.append(f"The beam is bent most, by the fall from {height} mm, by {' and '.join(seen)}.")
    return Sheet("Paper 2: a sphere falls on a beam", rows, FOOTER, reading)


def histories(quick: bool) -> Sheet:
    """Figures 4 and 5: deflection and stress at the point of impact and at a quarter of the span."""
    rows: list = [[], []]
    reading = []
    for height, (_, figure) in HEIGHTS.items():
        words = []
        for row, (name, title, unit) in zip(
            rows, (("deflection", "deflection", "m"), ("bending_stress", "bending stress", "Pa")), strict=True
        ):
            parts = []
            for theory, dashes in LOOKS.items():
                time, values, _, _ = fall(height, theory)
                for column, colour, where in ((0, 0, "point of impact"), (QUARTER, 5, "1/4 of the span")):
                    look = {"color": BALL_COLOURS[colour], "linestyle": dashes, "linewidth": 1.7}
                    parts.append(Line(f"{where}, {theory.capitalize()}", time, values[name][:, column], look))
            letter = "a" if unit == "m" else "b"
            heading = f"Figure {figure}{letter}: {title}, fall from {height} mm"
            row.append(Panel(f"figure {figure}{letter}", heading, TIME, Axis(title, unit), parts))
        for theory in LOOKS:
            figures = fall(height, theory, 0.0, 3e-3)[2]
            peaks = ", ".join(f"{one['peak_force_n']:.1f}" for one in figures["contacts"])
            words.append(f"by {theory.capitalize()} {peaks} N and a restitution of {figures['restitution']:.4f}")
        reading.append(f"The contacts of the fall from {height} mm reach {'; '.join(words)}.")
    return Sheet("Paper 2: deflection and stress of the beam", rows, f"{FOOTER}; undamped", reading)


def rigid(height: int):
    """The first contact of a rigid sphere on Timoshenko's beam, and its peak force [N] at the touch."""
    _, _, figures, parameters = fall(height, "timoshenko")
    beam, speed = beam_of(parameters, "timoshenko"), figures["impact_speed_m_s"]
    radius, density = parameters.sphere.radius, parameters.sphere.material.density
    mass = parameters.sphere.mass or 4.0 / 3.0 * math.pi * radius**3 * density
    found = strike(beam, mass, math.inf, speed, parameters.blow.point, TOUCH, CELLS)
    return found, 2.0 * speed * math.sqrt(beam.shear_rigidity * beam.mass / beam.span)


@functools.lru_cache(maxsize=16)
def stress_after(height: int, theory: str, damping: float):
    """R.m.s. stress at the impact by periods after the last contact, the first being 1; the first over the greatest."""
    beam = load_scene(f"sphere_on_beam_drop_{height}mm").parameters.beam
    stiffness = math.sqrt(beam.material.young_modulus / (12.0 * beam.material.density)) * beam.height
    period = 2.0 * math.pi / ((math.pi / beam.span) ** 2 * stiffness)
    time, values, figures, _ = fall(height, theory, damping, 1e-3 + PERIODS * period)
    last = max(one["start_s"] + one["duration_s"] for one in figures["contacts"])
    stress = values["bending_stress"][:, 0]
    sizes = []
    for part in range(PERIODS):
        inside = (time >= last + part * period) & (time < last + (part + 1) * period)
        sizes.append(math.sqrt(np.mean(stress[inside] ** 2)) if inside.any() else math.nan)
    return np.array(sizes) / sizes[0], sizes[0] / np.abs(stress).max()


def claims(quick: bool) -> Sheet:
    """Two conclusions: local deformation lengthens the contact; the stress dies down faster for the smaller height."""
    rows: list = [[], []]
    reading = []
    for height in HEIGHTS:
        time, values, figures, _ = fall(height, "timoshenko")
        hard, peak = rigid(height)
        soft, near = figures["contacts"][0], time <= TOUCH
        lines = [
            Line("rigid contact", hard.time, hard.force, {"color": BALL_COLOURS[5], "linewidth": 1.4}),
            Line(
                "with Hertz's local deformation",
                time[near],
                values["normal_load"][near],
                {"color": BALL_COLOURS[0], "linewidth": 2.2},
            ),
        ]
        title = f"Contact force on Timoshenko's beam, fall from {height} mm"
        rows[0].append(Panel(f"force {height}", title, TIME, Axis("force", "N"), lines))
        ends = hard.contacts[[0, -1], 1]
        holds = soft["duration_s"] > ends[-1] and soft["peak_force_n"] < peak
        reading.append(
            f"From {height} mm local deformation lengthens the contact from {1e6 * ends[0]:.1f} µs, or "
            f"{1e6 * ends[-1]:.1f} µs with a short second touch, to {1e6 * soft['duration_s']:.1f} µs, and takes its "
            f"peak from {1e-3 * peak:.3g} to {1e-3 * soft['peak_force_n']:.3g} kN: the paper's claim "
            f"{'holds' if holds else 'fails'}."
        )
    faster = True
    for damping in (0.0, DAMPING):
        parts, words = [], []
        for theory, dashes in LOOKS.items():
            both = []
            for place, height in enumerate(HEIGHTS):
                shares, first = stress_after(height, theory, damping)
                look = {"color": BALL_COLOURS[5 * place], "linestyle": dashes, "marker": "o"}
                parts.append(Line(f"{height} mm, {theory.capitalize()}", np.arange(PERIODS), shares, look))
                both.append(100.0 * (shares[-1] if damping else first))
            faster = faster and (not damping or both[0] < both[1])
            words.append(f"{both[0]:.0f} and {both[1]:.0f} % by {theory.capitalize()}")
        across, up = (
            Axis("periods of the first mode after the last contact"),
            Axis("r.m.s. stress, first period = 1", limits=(0.0, 1.2)),
        )
        how = f"{100.0 * damping:g} % of critical damping" if damping else "undamped"
        rows[1].append(
            Panel(f"decay {damping:g}", f"Stress at the point of impact, {how}", across, up, parts, "lower left")
        )
        if damping:
            reading.append(
                f"With {how} the stress is, {PERIODS - 1} periods on, for 50 and 600 mm at "
                f"{' and '.join(words)} of what it was: the paper's 'faster when the height is "
                f"smaller' {'holds' if faster else 'does not hold'}."
            )
        else:
            reading.append(
                "Without damping the stress does not die down after the last contact; that leaves of the greatest "
                f"stress (r.m.s.), for 50 and 600 mm, {' and '.join(words)}."
            )
    footer = f"{FOOTER}; the rigid contact, by {CELLS} cells, overshoots at its first step"
    return Sheet("Paper 2: two of its conclusions", rows, footer, reading)


def _bodies(above: float = 0.0) -> list[Line]:
    """Beam, supports and sphere as outlines; the fall as an arrow."""
    parameters = load_scene("sphere_on_beam_drop_50mm").parameters
    span, thick, radius = parameters.beam.span, parameters.beam.height, parameters.sphere.radius
    ink, grey = {"color": STYLE["ink"], "linewidth": 2.0}, {"color": STYLE["edge"], "linewidth": 2.0}
    turn, middle, foot = np.linspace(0.0, 2.0 * math.pi, 121), 0.5 * span, thick * np.array([0.0, -0.7, 0.7, 0.0])
    words = f"h = {1e3 * above:g} mm" if above else "falls from h = 50 and 600 mm"
    across = middle + (1.6 * radius if above else 0.0)
    return [
        Line(
            f"beam, {1e3 * thick:g} x {1e3 * thick:g} x {1e3 * span:g} mm",
            [0.0, span, span, 0.0, 0.0],
            [0.0, 0.0, -thick, -thick, 0.0],
            ink,
        ),
        Line(
            f"sphere, radius {1e3 * radius:g} mm",
            middle + radius * np.cos(turn),
            above + radius * (1.0 + np.sin(turn)),
            {"color": BALL_COLOURS[0], "linewidth": 2.0},
        ),
        *(
            Line("supports", at + foot, [-thick, -2.2 * thick, -2.2 * thick, -thick], grey, not at)
            for at in (0.0, span)
        ),
        Line(
            words,
            [across, across],
            [above or 0.05, 0.0 if above else 2.2 * radius],
            {"color": BALL_COLOURS[5], "linewidth": 2.0, "marker": "v"},
        ),
    ]


CHARTS = {
    "paper2": Paper(
        {"drops": Figures((1, 2, 3), drops), "histories": Figures((4, 5), histories), "claims": Figures((), claims)}
    )
}
