"""Paper 2 (Opritescu, Tirdea, Toader 2011), figures 1 to 5: a sphere falls on a beam from 50 and 600 mm.

The paper computed with solid elements and prints no dimension but the heights; the drawings are those of the shipped
scenes. "Local deformation lengthens the contact" is held against a rigid contact on Timoshenko's beam, whose force at
the touch is v times the impedance 2 sqrt(K G A rho A) of its shear waves. "The stress dies down faster when the height
is smaller" is read off the stress after the last contact, period by period of the first mode.
"""

import functools
import math

import numpy as np

from bearing_twin.charts.contest import Figures, Paper
from bearing_twin.charts.reference import strike
from bearing_twin.charts.scenes import RunData, run_scene
from bearing_twin.kinds.beam.motion import beam_of
from bearing_twin.pictures import BALL_COLOURS, Axis, Line, Panel, Sheet
from bearing_twin.run.scene import load_scene

HEIGHTS = {50: (2, 4), 600: (3, 5)}  # mm: the paper's figures of bodies and of curves
LINE_STYLES = {"euler": "--", "timoshenko": "-"}
TIME = Axis("time", "s")
LENGTH = Axis("along the beam", "m")
CURVE_DURATION, TOUCH_DURATION = 1.5e-3, 1.2e-4  # s of the curves, of the forces at the first contact
CELLS, QUARTER = 800, 1  # of the beam under a rigid contact; the place of a quarter of the span among the channels
DAMPING, PERIODS = 0.005, 8  # of every mode; periods of the first mode after the last contact
FOOTER = "steel sphere, radius 10 mm, on a steel beam of 10 x 10 x 153.5 mm"
CHANNELS = ("normal_load", "deflection", "bending_stress", "shape")


@functools.lru_cache(maxsize=16)
def fall(height: int, theory: str, damping: float = 0.0, duration: float = CURVE_DURATION) -> RunData:
    """The fall from `height` [mm]."""
    overrides = f"beam.theory={theory}", f"beam.damping_ratio={damping!r}", f"run.duration={duration!r}"
    return run_scene(
        f"sphere_on_beam_drop_{height}mm", (*overrides, "run.output_rate=1e6", "run.publish_rate=1e6"), CHANNELS
    )


def drops(quick: bool) -> Sheet:
    """Figures 1, 2 and 3: the beam at the touch and at its greatest deflection."""
    panels, reading = [], []
    for height, (figure, _) in HEIGHTS.items():
        lines, greatest = [], []
        for theory, dashes in LINE_STYLES.items():
            data = fall(height, theory)
            time, shapes, span = data.time, data.values["shape"], data.scene.parameters.beam.span
            last = int(shapes.max(axis=1).argmax())
            for name, row, colour_index in (("touch", 0, 2), ("greatest deflection", last, 5)):
                label = f"{name}, {theory.capitalize()}, {1e6 * time[row]:.0f} µs"
                style = {"color": BALL_COLOURS[colour_index], "linewidth": 2.4, "linestyle": dashes}
                lines.append(Line(label, np.linspace(0.0, span, shapes.shape[1]), -shapes[row], style))
            greatest.append(f"{1e6 * shapes.max():.1f} µm at {1e6 * time[last]:.0f} µs by {theory.capitalize()}")
        up = Axis("height above rest", "m", limits=(-1.15 * shapes.max(), 0.6 * shapes.max()))
        panels.append(Panel(f"Figure {figure}: fall from {height} mm", LENGTH, up, lines, "upper right"))
        reading.append(f"The beam is bent most, by the fall from {height} mm, by {' and '.join(greatest)}.")
    return Sheet("Paper 2: a sphere falls on a beam", [panels], FOOTER, reading)


def histories(quick: bool) -> Sheet:
    """Figures 4 and 5: deflection and stress at the point of impact and at a quarter of the span."""
    rows: list = [[], []]
    reading = []
    for height, (_, figure) in HEIGHTS.items():
        for row, letter, name, unit in ((0, "a", "deflection", "m"), (1, "b", "bending_stress", "Pa")):
            parts, title = [], name.replace("_", " ")
            for theory, dashes in LINE_STYLES.items():
                data = fall(height, theory)
                for column, colour_index, location in ((0, 0, "point of impact"), (QUARTER, 5, "1/4 of the span")):
                    style = {"color": BALL_COLOURS[colour_index], "linestyle": dashes, "linewidth": 1.7}
                    label = f"{location}, {theory.capitalize()}"
                    parts.append(Line(label, data.time, data.values[name][:, column], style))
            heading = f"Figure {figure}{letter}: {title}, fall from {height} mm"
            rows[row].append(Panel(heading, TIME, Axis(title, unit), parts))
        falls = []
        for theory in LINE_STYLES:
            figures = fall(height, theory, 0.0, 3e-3).figures
            peaks = ", ".join(f"{contact['peak_force_n']:.1f}" for contact in figures["contacts"])
            falls.append(f"by {theory.capitalize()} {peaks} N and a restitution of {figures['restitution']:.4f}")
        reading.append(f"The contacts of the fall from {height} mm reach {'; '.join(falls)}.")
    return Sheet("Paper 2: deflection and stress of the beam", rows, f"{FOOTER}; undamped", reading, shared_legend=True)


def rigid(height: int):
    """The first contact of a rigid sphere on Timoshenko's beam, and its peak force [N] at the touch."""
    data = fall(height, "timoshenko")
    parameters, speed = data.scene.parameters, data.figures["impact_speed_m_s"]
    beam, sphere = beam_of(parameters, "timoshenko"), parameters.sphere
    mass = sphere.mass or 4.0 / 3.0 * math.pi * sphere.radius**3 * sphere.material.density
    contact = strike(beam, mass, math.inf, speed, parameters.blow.point, TOUCH_DURATION, CELLS)
    return contact, 2.0 * speed * math.sqrt(beam.shear_rigidity * beam.mass / beam.span)


@functools.lru_cache(maxsize=16)
def stress_after(height: int, theory: str, damping: float):
    """R.m.s. stress at the impact by periods after the last contact, the first being 1; the first over the greatest."""
    beam = load_scene(f"sphere_on_beam_drop_{height}mm").parameters.beam
    stiffness = math.sqrt(beam.material.young_modulus / (12.0 * beam.material.density)) * beam.height
    period = 2.0 * math.pi / ((math.pi / beam.span) ** 2 * stiffness)
    data = fall(height, theory, damping, 1e-3 + PERIODS * period)
    last = max(contact["start_s"] + contact["duration_s"] for contact in data.figures["contacts"])
    stress, period_index = data.values["bending_stress"][:, 0], np.floor((data.time - last) / period)
    sizes = np.array([math.sqrt(np.mean(stress[period_index == part] ** 2)) for part in range(PERIODS)])
    return sizes / sizes[0], sizes[0] / np.abs(stress).max()


def claims(quick: bool) -> Sheet:
    """Two conclusions: local deformation lengthens the contact; the stress dies down faster for the smaller height."""
    rows: list = [[], []]
    reading, faster = [], True
    for height in HEIGHTS:
        data, (hard, peak) = fall(height, "timoshenko"), rigid(height)
        soft, touching = data.figures["contacts"][0], data.time <= TOUCH_DURATION
        load = data.values["normal_load"][touching]
        lines = [
            Line("rigid contact", hard.time, hard.force, {"color": BALL_COLOURS[5], "linewidth": 1.4}),
            Line("with Hertz's local deformation", data.time[touching], load, {"color": BALL_COLOURS[0]}),
        ]
        title = f"Contact force on Timoshenko's beam, fall from {height} mm"
        rows[0].append(Panel(title, TIME, Axis("force", "N"), lines))
        ends = hard.contacts[[0, -1], 1]
        holds = soft["duration_s"] > ends[-1] and soft["peak_force_n"] < peak
        reading.append(
            f"From {height} mm local deformation lengthens the contact from {1e6 * ends[0]:.1f} µs, or "
            f"{1e6 * ends[-1]:.1f} µs with a short second touch, to {1e6 * soft['duration_s']:.1f} µs, and takes its "
            f"peak from {1e-3 * peak:.3g} to {1e-3 * soft['peak_force_n']:.3g} kN: the paper's claim "
            f"{'holds' if holds else 'fails'}."
        )
    across = Axis("periods of the first mode after the last contact")
    up = Axis("r.m.s. stress, first period = 1", limits=(0.0, 1.2))
    for damping in (0.0, DAMPING):
        parts, shares_text = [], []
        for theory, dashes in LINE_STYLES.items():
            percentages = []
            for index, height in enumerate(HEIGHTS):
                shares, first = stress_after(height, theory, damping)
                style = {"color": BALL_COLOURS[5 * index], "linestyle": dashes, "marker": "o"}
                parts.append(Line(f"{height} mm, {theory.capitalize()}", np.arange(PERIODS), shares, style))
                percentages.append(100.0 * (shares[-1] if damping else first))
            faster = faster and (not damping or percentages[0] < percentages[1])
            shares_text.append(f"{percentages[0]:.0f} and {percentages[1]:.0f} % by {theory.capitalize()}")
        how = f"{100.0 * damping:g} % of critical damping" if damping else "undamped"
        rows[1].append(Panel(f"Stress at the point of impact, {how}", across, up, parts, "lower left"))
        reading.append(
            f"With {how} the stress is, {PERIODS - 1} periods on, for 50 and 600 mm at {' and '.join(shares_text)} of "
            f"what it was: the paper's 'faster when the height is smaller' {'holds' if faster else 'does not hold'}."
            if damping
            else "Without damping the stress does not die down after the last contact; that leaves of the greatest "
            f"stress (r.m.s.), for 50 and 600 mm, {' and '.join(shares_text)}."
        )
    footer = f"{FOOTER}; the rigid contact, by {CELLS} cells, overshoots at its first step"
    return Sheet("Paper 2: two of its conclusions", rows, footer, reading)


CHARTS = {
    "paper2": Paper(
        {"drops": Figures((1, 2, 3), drops), "histories": Figures((4, 5), histories), "claims": Figures((), claims)}
    )
}
