"""Paper 1 (Kosenko, Aleksandrov): contact frame and opposing points, bounces by two laws, the ball bearing, its laws.

The paper prints no dimension, speed, damping or friction: those of the scenes stand for them. "Their coordinates
coincide with a very high accuracy" (section 5) becomes a number. Figure 4 shows one impact and says that Hertz comes
late; which law does depends on the viscous term, so three are drawn, with their closed forms as lines.
"""

import functools
import math

import numpy as np

from bearing_twin.charts import reference
from bearing_twin.charts.contest import Figures, Paper
from bearing_twin.charts.laws import LAW_LABELS
from bearing_twin.charts.scenes import run_scene
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.laws import steady_damping, steady_ratio
from bearing_twin.kinds.bodies.derived import mass_of
from bearing_twin.pictures import BALL_COLOURS, Axis, Line, Panel, Sheet, line_style
from bearing_twin.run.scene import load_scene

TIME = Axis("time", "s")
TWO = (
    *("first.shape=ellipsoid", "first.semi_axes=[0.03,0.02,0.012]", "first.turn=[0,0.5,0]", "first.velocity=[0,0,0]"),
    *("first.angular_velocity=[0,0,0]", "second.shape=ellipsoid", "second.semi_axes=[0.025,0.03,0.015]"),
    *("second.turn=[0,-0.3,0]", "gravity=[0,0,0]", "run.duration=1e-6", "run.output_rate=1e6", "run.publish_rate=1e6"),
)
POSITIONS = {1: "[0.006,0,0.034]", 2: "[0.006,0,0.0307]"}  # m: the first body's centre, by figure
ARROW = 0.012  # m
AROUND = np.linspace(0.0, 2.0 * math.pi, 181)


def _law_index(law: str) -> int:
    """The number of a law's colour, as in the chart of laws."""
    return [*LAW_LABELS].index(law)


def _outline(body, name: str, index: int) -> Line:
    """The section y = 0 of an ellipsoid that is turned about y."""
    x, z = body.semi_axes[0] * np.cos(AROUND), body.semi_axes[2] * np.sin(AROUND)
    c, s = math.cos(body.turn[1]), math.sin(body.turn[1])
    return Line(name, body.position[0] + c * x + s * z, body.position[2] - s * x + c * z, line_style(index))


def contact_frame(quick: bool) -> Sheet:
    """Figures 1 and 2: opposing points of two bodies, and the frame of their contact."""
    panels, reading = [], []
    for figure, position in POSITIONS.items():
        overrides = (*TWO, f"first.position={position}")
        run_data = run_scene("two_bodies_ellipsoid", overrides, ("contact_point", "normal", "approach"))
        point, normal = (run_data.values[name][0][[0, 2]] for name in ("contact_point", "normal"))
        approach, parameters, parts = float(run_data.values["approach"][0]), run_data.scene.parameters, []
        ends = [point + 0.5 * approach * sign * normal for sign in (1.0, -1.0)]
        for index, (letter, body) in enumerate({"A": parameters.first, "B": parameters.second}.items()):
            parts.append(_outline(body, f"body {letter}", 5 * index))
            dot = {"color": BALL_COLOURS[5 * index], "marker": "o", "markersize": 9, "linestyle": ""}
            parts.append(Line(f"opposing point P_{letter}", [ends[index][0]], [ends[index][1]], dot))
        tangent = np.array([normal[1], -normal[0]])
        for name, direction, index in (("γ (normal)", normal, 2), ("α (in the tangent plane)", tangent, 3)):
            tip = ends[0] + ARROW * direction
            style = {"color": BALL_COLOURS[index], "linewidth": 2.5}
            parts.append(Line(name, [ends[0][0], tip[0]], [ends[0][1], tip[1]], style))
        separated = approach < 0.0
        subject = "opposing points of separated bodies" if separated else "frame of a contact, depth enlarged"
        across, up = Axis("x", "m"), Axis("z", "m")
        panels.append(Panel(f"Figure {figure}: {subject}", across, up, parts, "lower left", equal_aspect=True))
        distance = f"a gap of {-1e3 * approach:.3g} mm" if separated else f"an approach of {1e3 * approach:.3g} mm"
        reading.append(f"Figure {figure}: the opposing points lie on one normal of both surfaces, with {distance}.")
    title = "Paper 1: opposing points of two ellipsoids, and the frame of their contact"
    return Sheet(title, [panels], "two_bodies_ellipsoid, section y = 0", reading)


BALL, DURATION, RESTITUTION = "ellipsoid_on_plane", 3.2, 0.8
PAIR, LAST_IMPACTS = ("hertz", "volumetric"), 4
CASES = {"no loss": 0, "restitution 0.8 for both": 1, "one d(h) for both (paper 1)": 2}


@functools.cache
def _ball(law: str) -> tuple[float, float]:
    """Load coefficient [N/m^1.5] and mass [kg] of the ball."""
    parameters = load_scene(BALL).parameters
    curvature = 0.5 / parameters.body.semi_axes[0]
    return float(coefficient_of(law, curvature, curvature, parameters.modulus)), float(mass_of(parameters.body))


def _bounce_keys(case: int, law: str, *further: str) -> tuple[str, ...]:
    loss = (
        (),
        (f"contact.restitution={RESTITUTION}",),
        (f"contact.viscosity={steady_damping(RESTITUTION, *_ball('hertz'))!r}",),
    )
    overrides = ("contact.restitution=1.0", f"run.duration={DURATION}", "wanted.tolerance=1e-11")
    return (*overrides, f"contact.normal={law}", *loss[case], *further)


def delays(case: int) -> tuple[np.ndarray, np.ndarray]:
    """Delay [s] of Hertz's impacts after those of the volumetric law, found and in closed form."""
    contacts = [run_scene(BALL, _bounce_keys(case, law)).figures["contacts"] for law in PAIR]
    count = min(map(len, contacts))
    parameters = load_scene(BALL).parameters
    (hertz, mass), (soft, _) = map(_ball, PAIR)
    ratio = steady_ratio(RESTITUTION) if case else 0.0
    ratios = ratio, ratio * math.sqrt(hertz / soft) if case == 2 else ratio
    exact = [
        reference.impact_instants(count, parameters.start.height, -parameters.gravity[2], c, mass, z)
        for c, z in zip((hertz, soft), ratios, strict=True)
    ]
    instants = [np.array([contact["start_s"] for contact in contacts_of_law[:count]]) for contacts_of_law in contacts]
    return instants[0] - instants[1], exact[0] - exact[1]


def bounces(quick: bool) -> Sheet:
    """Figures 3 and 4: altitude over time, one impact enlarged, and Hertz's delay impact by impact."""
    styles = {
        "hertz": {**line_style(_law_index("hertz")), "linewidth": 3.4},
        "volumetric": {**line_style(_law_index("volumetric")), "linewidth": 1.8, "linestyle": "--"},
    }

    def altitude(law: str, *keys: str):
        run_data = run_scene(BALL, _bounce_keys(2, law, *keys), ("position",))
        return run_data.time, run_data.values["position"][:, 2], run_data.figures["contacts"]

    altitudes, enlarged, parts, reading, instants = [], [], [], [], []
    for law, style in styles.items():
        time, height, contacts = altitude(law, f"run.output_rate={1000 if quick else 5000}")
        altitudes.append(Line(LAW_LABELS[law], time, height, style))
        instants.append(contacts[-2]["start_s"])
    middle, reach = 0.5 * sum(instants), abs(instants[0] - instants[1]) + 1e-3
    for law, style in styles.items():
        fine = (f"run.output_rate={2e4 if quick else 1e5:g}", f"run.duration={middle + reach:.9g}")
        time, height, _ = altitude(law, *fine)
        inside = time >= middle - reach
        enlarged.append(Line(LAW_LABELS[law], time[inside] - middle, height[inside], style))
    for name, case in CASES.items():
        measured, exact = (values[1:] for values in delays(case))
        impacts = np.arange(2, len(measured) + 2)
        later_law = "Hertz" if measured[-1] > 0.0 else "the volumetric law"
        style = {**line_style(case), "linestyle": "", "marker": "o", "markersize": 8}
        parts.append(Line(f"{name}: {later_law} late", impacts, np.abs(measured), style))
        parts.append(Line("closed form", impacts, np.abs(exact), line_style(case), False))
        last_delays = ", ".join(f"{1e6 * abs(delay):.4g}" for delay in measured[-LAST_IMPACTS:])
        error = 100.0 * np.abs(measured / exact - 1.0)[-LAST_IMPACTS:].max()
        reading.append(
            f"{name}: {later_law} comes late, by {last_delays} µs in the last impacts; the closed form is within "
            f"{error:.1g} % of it."
        )
    up, after = Axis("altitude of the centre", "m"), Axis(f"time after {middle:.6g} s", "s")
    impact, delay = Axis("impact, counted from the first"), Axis("delay", "s", log=True)
    rows = [
        [Panel("Figure 3: altitude of the centre, one d(h) for both laws", TIME, up, altitudes, "upper right")],
        [
            Panel("Figure 4: the second impact from the right", after, up, enlarged),
            Panel("Delay of the impacts; lines: closed forms", impact, delay, parts),
        ],
    ]
    footer = f"{BALL}, restitution {RESTITUTION:g}"
    return Sheet("Paper 1: a ball of radius 0.1 m bounces by two laws", rows, footer, reading)


SCENE, EXACT, LAWS = "bearing_6203", "hertz_exact", ("hertz", "hertz_differential", "volumetric", "constant")
FOLLOWED, OUTER, SPAN = 0, 1, 0.1  # ball, raceway, s of the curves


def bearing(quick: bool) -> Sheet:
    """Figure 5: contact point and normal of a ball, and how far those by other laws are from exact Hertz."""
    span = 0.02 if quick else SPAN
    overrides, channels = (f"run.duration={span}", "run.output_rate=4000"), ("point", "normal", "normal_load")
    runs = {law: run_scene(SCENE, (*overrides, f"contact.normal={law}"), channels) for law in (EXACT, *LAWS)}
    time, exact, scene = runs[EXACT].time, runs[EXACT].values, runs[EXACT].scene
    point, normal, load = (exact[name][:, FOLLOWED, OUTER] for name in ("point", "normal", "normal_load"))
    distances, reading = [], []
    for law in LAWS:
        p, n, f = (runs[law].values[name][:, FOLLOWED, OUTER] for name in ("point", "normal", "normal_load"))
        away, turned = np.linalg.norm(p - point, axis=1), np.linalg.norm(n - normal, axis=1).max()
        distances.append(Line(LAW_LABELS[law], time, np.maximum(away, 1e-18), line_style(_law_index(law))))
        reading.append(
            f"{law} against exact Hertz over {span:g} s: r_P within {away.max():.2g} m, n_A within {turned:.2g} rad, "
            f"load within {np.abs(f / load - 1.0).max():.2g}."
        )

    def curves(values, letter):
        return [Line(rf"${letter}_{axis}$", time, values[:, k], line_style(k)) for k, axis in enumerate("xyz")]

    rows = [
        [
            Panel(
                "Contact point of a ball with the outer raceway",
                TIME,
                Axis("its coordinates r_P", "m"),
                curves(point, "r"),
            ),
            Panel("Normal of the raceway there", TIME, Axis("its components n_A"), curves(normal, "n")),
            Panel("Contact point by other laws, from exact Hertz", TIME, Axis("distance", "m", log=True), distances),
        ]
    ]
    footer = f"{SCENE}, {scene.parameters.drive.speed:g} rad/s"
    return Sheet("Paper 1: the ball bearing of section 5", rows, footer, reading)


CHARTS = {
    "paper1": Paper(
        {
            "contact_frame": Figures((1, 2), contact_frame),
            "bounces": Figures((3, 4), bounces),
            "bearing": Figures((5,), bearing),
        }
    )
}
