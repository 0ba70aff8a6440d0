"""Paper 1 (Kosenko, Aleksandrov): contact frame and opposing points, bounces by two laws, the ball bearing, its laws.

The paper prints no dimension, speed, damping or friction: those of the scenes stand for them. "Their coordinates
coincide with a very high accuracy" (section 5) becomes a number. Figure 4 shows one impact and says that Hertz comes
late; which law does depends on the viscous term, so three are drawn, with their closed forms as lines.
"""

import functools
import math

import numpy as np

from bearing_twin.charts.contest import seconds
from bearing_twin.charts.laws import law_cost
from bearing_twin.charts.panels import Axis, Drawing, Line, Panel, Sheet, Words, bars_of, colour
from bearing_twin.charts.paper import Figures, Paper
from bearing_twin.charts.scenes import WITHOUT_CHECK
from bearing_twin.contact.damping import steady_damping, steady_ratio
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.kinds.ellipsoid.derived import ellipsoid_mass, modulus_of
from bearing_twin.pictures.style import BALL_COLOURS, STYLE
from bearing_twin.reference import bounce
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

TIME = Axis("time", "s")


def run(scene: str, keys=(), names=("normal_load",)):
    """(time [s], channels, figures, scene) of a run."""
    made = simulate(load_scene(scene, [*keys, WITHOUT_CHECK]))
    blocks = list(made.blocks())
    values = {name: np.concatenate([block.values[name] for block in blocks]) for name in names}
    return 1e-9 * np.concatenate([block.time_ns for block in blocks]), values, made.report.figures, made.scene


TWO = (
    *("first.shape=ellipsoid", "first.semi_axes=[0.03,0.02,0.012]", "first.turn=[0,0.5,0]", "first.velocity=[0,0,0]"),
    *("first.angular_velocity=[0,0,0]", "second.shape=ellipsoid", "second.semi_axes=[0.025,0.03,0.015]"),
    *("second.turn=[0,-0.3,0]", "gravity=[0,0,0]", "run.duration=1e-6", "run.output_rate=1e6", "run.publish_rate=1e6"),
)
APART = {"figure 1": (0.006, 0.0, 0.034), "figure 2": (0.006, 0.0, 0.0307)}  # m: the first body's centre


def _outline(centre, axes, turn: float, name: str, place: int) -> Line:
    """The section y = 0 of an ellipsoid that is turned about y."""
    angle = np.linspace(0.0, 2.0 * math.pi, 181)
    x, z = axes[0] * np.cos(angle), axes[2] * np.sin(angle)
    c, s = math.cos(turn), math.sin(turn)
    return Line(name, centre[0] + c * x + s * z, centre[2] - s * x + c * z, colour(place))


def contact_frame(quick: bool) -> Sheet:
    """Figures 1 and 2: opposing points of two bodies, and the frame of their contact."""
    panels, reading = [], []
    for figure, position in APART.items():
        place = f"first.position=[{position[0]},{position[1]},{position[2]}]"
        names = ("contact_point", "normal", "approach", "major_axis")
        _, values, _, scene = run("two_bodies_ellipsoid", (*TWO, place), names)
        point, normal, major = (values[name][0][[0, 2]] for name in ("contact_point", "normal", "major_axis"))
        approach = float(values["approach"][0])
        ends = [point + 0.5 * approach * sign * normal for sign in (1.0, -1.0)]
        parts = []
        for number, (letter, body) in enumerate({"A": scene.parameters.first, "B": scene.parameters.second}.items()):
            parts.append(_outline(body.position, body.semi_axes, body.turn[1], f"body {letter}", 5 * number))
            dot = {"color": BALL_COLOURS[5 * number], "marker": "o", "markersize": 9, "linestyle": ""}
            parts.append(Line(f"opposing point P_{letter}", [ends[number][0]], [ends[number][1]], dot))
        arrow = 0.012
        axes = {"γ (normal)": normal, "α (in the tangent plane)": np.array([normal[1], -normal[0]])}
        for number, (name, one) in enumerate(axes.items()):
            tip = ends[0] + arrow * one
            look = {"color": BALL_COLOURS[(2, 3)[number]], "linewidth": 2.5}
            parts.append(Line(name, [ends[0][0], tip[0]], [ends[0][1], tip[1]], look))
            parts.append(Words(name[0], tip[0], tip[1]))
        what = "opposing points of bodies apart" if approach < 0.0 else "frame of a contact, depth enlarged"
        title = f"Figure {figure[-1]}: {what}"
        panels.append(Panel(figure, title, Axis("x", "m"), Axis("z", "m"), parts, "lower left", to_scale=True))
        words = f"a gap of {-1e3 * approach:.3g} mm" if approach < 0.0 else f"an approach of {1e3 * approach:.3g} mm"
        reading.append(
            f"{title.partition(':')[0]}: the opposing points lie on one normal of both surfaces, with {words}."
        )
        del major
    return Sheet(
        "Paper 1: opposing points of two ellipsoids, and the frame of their contact",
        [panels],
        "two_bodies_ellipsoid, section y = 0",
        reading,
    )


BALL, DURATION, RESTITUTION = "ellipsoid_on_plane", 3.2, 0.8
PAIR, LAST = ("hertz", "volumetric"), 4
CASES = {"no loss": 0, "restitution 0.8 for both": 1, "one d(h) for both (paper 1)": 2}


@functools.cache
def _ball(law: str) -> tuple[float, float]:
    """Load coefficient [N/m^1.5] and mass [kg] of the ball."""
    parameters = load_scene(BALL).parameters
    curvature = 0.5 / parameters.body.semi_axes[0]
    return float(coefficient_of(law, curvature, curvature, modulus_of(parameters))), ellipsoid_mass(parameters.body)


def _bounce_keys(case: int, law: str, *more: str) -> tuple[str, ...]:
    loss = (
        (),
        (f"contact.restitution={RESTITUTION}",),
        (f"contact.viscosity={steady_damping(RESTITUTION, *_ball('hertz'))!r}",),
    )
    keys = ("contact.restitution=1.0", f"run.duration={DURATION}", "wanted.tolerance=1e-11")
    return (*keys, f"contact.normal={law}", *loss[case], *more)


def delays(case: int) -> tuple[np.ndarray, np.ndarray]:
    """Delay [s] of Hertz's impacts after those of the volumetric law, found and in closed form."""
    instants = [
        np.array([one["start_s"] for one in run(BALL, _bounce_keys(case, law), ())[2]["contacts"]]) for law in PAIR
    ]
    count = min(map(len, instants))
    parameters = load_scene(BALL).parameters
    (hertz, mass), (soft, _) = map(_ball, PAIR)
    ratio = steady_ratio(RESTITUTION) if case else 0.0
    ratios = ratio, ratio * math.sqrt(hertz / soft) if case == 2 else ratio
    exact = [
        bounce.impact_instants(count, parameters.start.height, -parameters.gravity[2], c, mass, z)
        for c, z in zip((hertz, soft), ratios, strict=True)
    ]
    return instants[0][:count] - instants[1][:count], exact[0] - exact[1]


def bounces(quick: bool) -> Sheet:
    """Figures 3 and 4: altitude over time, one impact enlarged, and Hertz's delay impact by impact."""
    looks = dict(
        zip(
            PAIR,
            (
                {"color": BALL_COLOURS[5], "linewidth": 3.4},
                {"color": BALL_COLOURS[0], "linewidth": 1.8, "linestyle": "--"},
            ),
            strict=True,
        )
    )
    whole, near, parts, reading = [], [], [], []
    rate, instants = 1000 if quick else 5000, {}
    for law, look in looks.items():
        time, values, figures, _ = run(BALL, _bounce_keys(2, law, f"run.output_rate={rate}"), ("position",))
        whole.append(Line(law, time, values["position"][:, 2], look))
        instants[law] = figures["contacts"][-2]["start_s"]
    middle, reach = 0.5 * sum(instants.values()), abs(instants["hertz"] - instants["volumetric"]) + 1e-3
    for line in whole:
        law = line.name
        fine = (f"run.output_rate={2e4 if quick else 1e5:g}", f"run.duration={middle + reach:.9g}")
        time, values, _, _ = run(BALL, _bounce_keys(2, law, *fine), ("position",))
        inside = time >= middle - reach
        near.append(Line(law, time[inside] - middle, values["position"][inside, 2], looks[law]))
    for name, case in CASES.items():
        found, exact = delays(case)
        impacts = np.arange(2, len(found) + 1)
        late = "Hertz" if found[-1] > 0.0 else "the volumetric law"
        parts.append(
            Line(
                f"{name}: {late} late",
                impacts,
                np.abs(found[1:]),
                {**colour(case), "linestyle": "", "marker": "o", "markersize": 8},
            )
        )
        parts.append(Line("closed form", impacts, np.abs(exact[1:]), colour(case), False))
        words = ", ".join(f"{1e6 * abs(one):.4g}" for one in found[1:][-LAST:])
        off = np.abs(found[1:] / exact[1:] - 1.0)[-LAST:].max()
        reading.append(
            f"{name}: {late} comes late, by {words} µs in the last impacts; the closed form is within "
            f"{100.0 * off:.1g} % of it."
        )
    up = Axis("altitude of the centre", "m")
    rows = [
        [Panel("figure 3", "Figure 3: altitude of the centre, one d(h) for both laws", TIME, up, whole, "upper right")],
        [
            Panel(
                "figure 4",
                "Figure 4: the second impact from the right",
                Axis(f"time after {middle:.6g} s", "s"),
                up,
                near,
            ),
            Panel(
                "delay",
                "Delay of the impacts; lines: closed forms",
                Axis("impact, counted from the first"),
                Axis("delay", "s", log=True),
                parts,
            ),
        ],
    ]
    return Sheet(
        "Paper 1: a ball of radius 0.1 m bounces by two laws", rows, f"{BALL}, restitution {RESTITUTION:g}", reading
    )


SCENE, EXACT, LAWS = "bearing_6203", "hertz_exact", ("hertz", "hertz_differential", "volumetric", "constant")
FOLLOWED, OUTER, SPAN = 0, 1, 0.1  # ball, raceway, s of the curves
LONG = ("run.duration=1", "run.output_rate=100")  # of the run that is timed


def bearing(quick: bool) -> Sheet:
    """Figure 5, contact point and normal of a ball, how far other laws are from exact Hertz, and their cost."""
    from bearing_twin.charts.contest import timed

    span = 0.02 if quick else SPAN
    keys = (f"run.duration={span}", "run.output_rate=4000")
    names = ("point", "normal", "normal_load", "position", "orientation")
    found, costs = {}, {}
    for law in (EXACT, *LAWS):
        chosen = f"contact.normal={law}"
        found[law] = run(SCENE, (*keys, chosen), names)
        costs[law] = timed(lambda chosen=chosen: run(SCENE, (*LONG, chosen)))[1]["seconds"]
    time, exact, _, scene = found[EXACT]
    point, normal = (exact[name][:, FOLLOWED, OUTER] for name in ("point", "normal"))
    off, reading = [], []
    for place, law in enumerate(LAWS):
        values = found[law][1]
        away = np.linalg.norm(values["point"][:, FOLLOWED, OUTER] - point, axis=1)
        turned = np.linalg.norm(values["normal"][:, FOLLOWED, OUTER] - normal, axis=1).max()
        load = np.abs(values["normal_load"][:, FOLLOWED, OUTER] / exact["normal_load"][:, FOLLOWED, OUTER] - 1.0).max()
        off.append(Line(law, time, np.maximum(away, 1e-18), colour(place)))
        reading.append(
            f"{law} against exact Hertz over {span:g} s: r_P within {away.max():.2g} m, n_A within {turned:.2g} rad, "
            f"load within {load:.2g}."
        )
    evaluations = {law: law_cost(law)["seconds"] for law in costs}
    for words, times in (("of an evaluation of the law", evaluations), ("of a simulated second of the bearing", costs)):
        parts = ", ".join(f"{law} {times[law] / times[EXACT]:.2f}" for law in LAWS)
        reading.append(f"CPU time {words} over that of exact Hertz ({seconds(times[EXACT])}): {parts}.")
    reading.append("The paper: the volumetric law is cheaper than Hertz, the constant coefficient at least twice so.")

    def curves(values, letter):
        return [
            Line(rf"${letter}_{axis}$", time, values[:, column], colour(column)) for column, axis in enumerate("xyz")
        ]

    rows = [
        [
            Panel(
                "figure 5",
                f"Figure 5: the bearing after {span:g} s, cut open",
                parts=[Drawing(lambda axis: _in_space(axis, scene.parameters, exact))],
            ),
            Panel(
                "point", "Contact point of a ball with the outer raceway", TIME, Axis("r_P", "m"), curves(point, "r")
            ),
            Panel("normal", "Normal of the raceway there", TIME, Axis("n_A"), curves(normal, "n")),
        ],
        [
            Panel(
                "distance",
                "r_P by other laws, from that by exact Hertz",
                TIME,
                Axis("distance", "m", log=True, shown=(1.0, "m")),
                off,
            ),
            bars_of("evaluation", "An evaluation of the law", Axis("CPU time", "s"), evaluations),
            bars_of("run", "A simulated second of the bearing", Axis("CPU time", "s"), costs),
        ],
    ]
    return Sheet(
        "Paper 1: the ball bearing of section 5",
        rows,
        f"{SCENE}, {scene.parameters.drive.speed:g} rad/s; arrows: normals on the outer raceway, z in mm",
        reading,
    )


def _in_space(axis, parameters, values) -> None:
    """Grooves cut open, balls, and the normals on the outer raceway, in mm."""
    geometry = parameters.geometry
    ball, pitch = 0.5e3 * geometry.ball_diameter, 0.5e3 * geometry.pitch_diameter
    for conformity, middle, tone in (
        (geometry.outer_conformity, 0.0, STYLE["edge"]),
        (geometry.inner_conformity, math.pi, BALL_COLOURS[4]),
    ):
        groove = 2.0 * conformity * ball
        meridian, turn = np.meshgrid(
            np.linspace(-0.95, 0.95, 9) + middle, np.linspace(math.radians(-200.0), math.radians(70.0), 90)
        )
        centre = pitch - (groove - ball) * math.cos(middle)
        reach = centre + groove * np.cos(meridian)
        axis.plot_surface(
            reach * np.cos(turn), reach * np.sin(turn), groove * np.sin(meridian), color=tone, alpha=0.45, linewidth=0
        )
    polar, around = np.meshgrid(np.linspace(0.0, math.pi, 17), np.linspace(0.0, 2.0 * math.pi, 33))
    sphere = ball * np.array([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)])
    for number, centre in enumerate(1e3 * values["position"][-1]):
        x, y, z = sphere + centre[:, None, None]
        axis.plot_surface(x, y, z, color=BALL_COLOURS[1 if number == FOLLOWED else 0], linewidth=0)
        foot = 1e3 * values["point"][-1, number, OUTER]
        axis.quiver(*foot, *(-4.0 * values["normal"][-1, number, OUTER]), color=BALL_COLOURS[5], linewidth=1.6)
    axis.set_box_aspect((1.0, 1.0, 0.35), zoom=1.15)
    axis.set(xlim=(-20.0, 20.0), ylim=(-20.0, 20.0), zlim=(-7.0, 7.0), xlabel="x [mm]", ylabel="y [mm]")
    axis.set_zticks([-5.0, 0.0, 5.0])
    axis.view_init(elev=38.0, azim=-60.0)


CHARTS = {
    "paper1": Paper(
        {
            "contact_frame": Figures((1, 2), contact_frame),
            "bounces": Figures((3, 4), bounces),
            "bearing": Figures((5,), bearing),
        }
    )
}
