"""Films of lubricants against the published formulas, torque of equilibria and of moving balls, bad input."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from runs import reported, run_all
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from bearing_twin import load_scene
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.kinds.bearing.equilibrium import controlled_equilibrium, load_line, solver_of, support_of
from bearing_twin.kinds.bearing.friction_torque import contact_torque, skf_torque
from bearing_twin.kinds.bearing.lubricant import film_lubricant, film_numbers, films, viscosity_of
from bearing_twin.kinds.bearing.ratings import ratings_of
from bearing_twin.run.scene import choose

GREASE, OIL = 1, 2
E, VISCOSITY, PRESSURE_COEFFICIENT, BALL, CONFORMITY = 227.5e9, 0.02784, 1.8e-8, 3.373e-3, 0.52  # E is E' [Pa]
STEEL = "{young_modulus: 207.5e9, poisson_ratio: 0.3}"
TABLE_SCENE = (
    "geometry.radial_clearance=0",
    f"materials={{ball: {STEEL}, inner_ring: {STEEL}, outer_ring: {STEEL}}}",
    "lubricant={viscosity_40: 32mm²/s, pressure_coefficient: 1.8e-8}",
)


def published(load, speed, radius_along, radius_across):
    """Thickness, grease and flooded resistance as they are printed, with SciPy's elliptic integrals and root."""

    def curvature_ratio(k):  # b/a
        m = 1.0 - k * k
        return (ellipe(m) / (k * k) - ellipk(m)) / (ellipk(m) - ellipe(m))

    k = brentq(lambda k: curvature_ratio(k) - radius_across / radius_along, 1e-3, 1.0 - 1e-9, xtol=1e-15)
    m = 1.0 - k * k
    beta = 4.0 / math.pi * ellipe(m) / (1.0 + radius_along / radius_across)
    a = (6.0 * ellipe(m) * load / (math.pi * k * k * E * (1.0 / radius_along + 1.0 / radius_across))) ** (1.0 / 3.0)
    u, g, w = VISCOSITY * speed / (E * radius_along), PRESSURE_COEFFICIENT * E, load / (E * radius_along**2)
    v = 2.0 * u
    thickness = 2.69 * radius_along * u**0.67 * g**0.53 * w**-0.067 * (1.0 - 0.61 * math.exp(-0.73 / k))
    starved = 1.544 * E * radius_along**2 * beta ** (1 / 3) * k**-0.577 * v**0.656 * w**0.466 * g**0.022
    share = 1.0 + beta**0.25 * k * w * v**-0.75 / 6.6
    elastic = 1.8 * beta**-0.25
    rigid = 0.77 * beta ** (-1 / 3) * k**0.12 * v ** (-1 / 12)
    return thickness, starved, 2.0 * a * E * radius_along * ((rigid - elastic) / share + elastic) * v**0.75


def test_films_and_rolling_resistance_are_those_of_print():
    across = 2.0 * CONFORMITY * BALL / (2.0 * CONFORMITY - 1.0)
    for side in (-1.0, 1.0):
        along = BALL * (1.0 + side * 6.746 / 28.5)
        for load, speed in ((217.4, 1.234), (10.0, 0.141), (600.0, 10.0)):
            expected = published(load, speed, along, across)
            for kind, column in ((GREASE, 1), (OIL, 2)):
                lubricant = np.array([kind, VISCOSITY, PRESSURE_COEFFICIENT, math.log(1e-7), 0.12, 0.05, 0.0, 0.0])
                numbers = film_numbers(lubricant, [0.5 / across], [0.5 / along], 0.5 * E, BALL)
                results = films(lubricant, numbers, [load], [speed])[0]
                assert results[0] == pytest.approx(expected[0], rel=1e-6)
                assert results[2] == pytest.approx(expected[column], rel=1e-6)
                share = 1.0 - math.exp(-1.8 * results[1] ** 1.2)
                assert results[5] == pytest.approx(0.05 * share + 0.12 * (1.0 - share), rel=1e-9)
                rolled = 7.48e-7 * BALL**0.33 * load**1.33 * (1.0 - 3.519e-3 * (across / along - 1.0) ** 0.8063)
                assert results[3] == pytest.approx(rolled, rel=1e-9)


def test_differential_slip_is_that_of_a_curved_patch():
    """Heathcote: slip y^2/(2 R_d) less what has no net force, under Hertz's load per width, summed over the width."""
    across, along = 2.0 * CONFORMITY * BALL / (2.0 * CONFORMITY - 1.0), BALL * (1.0 - 6.746 / 28.5)
    smooth = math.log(1e-12)  # all load is on the film
    lubricant = np.array([GREASE, VISCOSITY, PRESSURE_COEFFICIENT, smooth, 0.12, 0.05, 0.0, 0.0])
    numbers = film_numbers(lubricant, [0.5 / across], [0.5 / along], 0.5 * E, BALL)
    load, a = 217.4, ellipse(0.5 / across, 0.5 / along, 0.5 * E, 217.4).semi_major
    curved = 4.0 * CONFORMITY * BALL / (2.0 * CONFORMITY + 1.0)
    y = (np.arange(200_000) + 0.5) / 200_000 * a
    pressed = 0.75 * load / a * (1.0 - (y / a) ** 2) * (a / len(y))
    body_state = brentq(lambda t: t - t**3 / 3.0 - 1.0 / 3.0, 0.1, 0.9)
    moment = 2.0 * (0.05 * pressed * y**2 / (2.0 * curved) * np.where(y > body_state * a, 1.0, -1.0)).sum()
    assert films(lubricant, numbers, [load], [1.234])[0, 4] == pytest.approx(moment, rel=1e-4)


def answered(run_json, load, rpm, *changes):
    arguments = ["bearing", "6203", "--load", f"0,{-load},0", "--speed", f"{rpm}rpm"]
    return run_json(*arguments, *(argument for change in changes for argument in ("--set", change)))


def test_the_table_of_a_6203(run_json):
    """Parts in N mm, by a program of other authorship: films before the factors of the inlet, slip on a whole film."""
    rows = (
        (400, 1750, (3.861, 4.144), (0.9829, 0.9515), 1.113, 1.019, 0.143, 6.195, (4.85, 8.24)),
        (100, 1750, (2.024, 2.820), (0.9829, 0.9515), 0.176, 0.101, 0.157, 2.353, (3.56, 6.95)),
        (1000, 1500, (5.348, 4.916), (0.9859, 0.9583), 3.766, 4.692, 0.122, 14.451, (9.11, 12.16)),
        (400, 200, (0.931, 0.797), (0.9989, 0.9943), 1.113, 1.019, 0.0335, 4.567, (2.26, 3.06)),
    )
    for load, rpm, film, (heated, starved), hysteresis, slip, thickness, skf, palmgren in rows:
        for column, kind in enumerate(("grease", "oil")):
            set_kind = f"lubricant.kind={kind}"
            answer = answered(run_json, load, rpm, *TABLE_SCENE, set_kind, "lubricant.boundary_friction=0.05")
            parts = {name: 1e3 * value for name, value in answer["friction_torque_nm"].items()}
            expected = {
                "film": film[column] * heated * (starved if kind == "grease" else 1.0),
                "hysteresis": hysteresis,
                "slip": slip,
            }
            assert parts["palmgren"] == pytest.approx(palmgren[column], rel=5e-3)
            assert {name: parts[name] for name in expected} == pytest.approx(expected, rel=1e-2)
            assert parts["total"] == pytest.approx(parts["film"] + parts["hysteresis"] + parts["slip"], rel=1e-12)
            assert answer["friction_loss_w"] == pytest.approx(1e-3 * parts["total"] * answer["speed_rad_s"], rel=1e-12)
            assert 1e6 * answer["film_m"] == pytest.approx(thickness, rel=1e-2)
            assert answer["lambda"] == pytest.approx(1e7 * answer["film_m"], rel=1e-9)
        mixed = answered(run_json, load, rpm, *TABLE_SCENE, "lubricant.kind=grease")["friction_torque_nm"]
        assert 1e3 * mixed["skf"] == pytest.approx(skf, rel=1e-3)
    assert 1e3 * mixed["slip"] == pytest.approx(1.831, rel=1e-2)  # at 200 1/min films carry a part of the load


def test_greased_bearings_come_near_to_the_formula_of_skf():
    """0.8 to 1.4 of it over bearings, loads, speeds and viscosities, and 1 in the median."""
    ratios = []
    for name in ("6203", "6206", "6308"):
        greased = ("geometry.radial_clearance=0", "lubricant={kind: grease, viscosity_40: 32mm²/s}")
        scene = load_scene(name, greased).parameters
        static = ratings_of(scene).static
        for share, rpm in itertools.product((0.005, 0.03, 0.1), (100, 1000, 5000)):
            load, speed = share * static, rpm * math.pi / 30.0
            if 1e3 * scene.geometry.pitch_diameter * rpm > 500_000:
                continue
            keys = f"rings.inner.load=[0, {-load}, 0]", f"drive.speed={speed!r}"
            parameters = load_scene(name, (*greased, *keys)).parameters
            support = support_of(parameters)
            solver = solver_of(parameters, "hertz", load_line(support))
            contacts = controlled_equilibrium(parameters, solver, support).contacts
            for viscosity in (15e-6, 32e-6, 100e-6):
                oil = dataclasses.replace(parameters.lubricant, viscosity_40=viscosity)
                oiled = dataclasses.replace(parameters, lubricant=oil)
                torque = contact_torque(oiled, contacts)
                ratios.append(
                    (torque.film + torque.hysteresis + torque.slip) / skf_torque(oiled, static, (0.0, load, 0.0))
                )
    assert len(ratios) > 60
    assert 0.8 < min(ratios) < 0.95 < np.median(ratios) < 1.1 < max(ratios) < 1.4


def test_spin_of_an_angular_contact_and_of_its_mirror_image_adds_to_slip(run_json):
    scene = ("bearing", "7205B", "--speed", "1750rpm", "--set", "lubricant.kind=grease", "--load")
    thrust, mirrored, radial = (
        run_json(*scene, load)["friction_torque_nm"] for load in ("0,0,500", "0,0,-500", "0,-500,0")
    )
    assert thrust == pytest.approx(mirrored, rel=1e-6)
    assert 0.5 < thrust["total"] / thrust["skf"] < 2.0
    assert thrust["slip"] / thrust["hysteresis"] > 1.5 * radial["slip"] / radial["hysteresis"]


def test_viscosities_of_grades_and_between_two_temperatures():
    for grade, constants in (("VG32", (9.9402, 3.9102)), ("VG68", (9.6301, 3.7521)), ("VG100", (9.4912, 3.6816))):
        oil = load_scene("6203", (f"lubricant={{kind: oil, name: {grade}}}",)).parameters.lubricant
        assert viscosity_of(oil, 313.15) == pytest.approx(1e-6 * float(grade[2:]), rel=2e-2)
        cold, warm = (viscosity_of(oil, kelvin) for kelvin in (313.15, 373.15))
        by_two = dataclasses.replace(oil, viscosity_40=cold, viscosity_100=warm)
        for kelvin in (300.0, 340.0, 373.15):
            walther = 10.0 ** (10.0 ** (constants[0] - constants[1] * math.log10(kelvin))) - 0.7
            assert 1e6 * viscosity_of(by_two, kelvin) == pytest.approx(walther, rel=3e-2)


@pytest.mark.parametrize(
    ("changes", "phrase"),
    [
        (["lubricant.kind=grease", "temperature=150°C"], "outside the oil's"),
        (["lubricant.name=VG32"], "lubricant.kind"),
        (["lubricant.kind=oil", "lubricant.viscosity_40=32mm²/s", "temperature=60°C"], "viscosity_100"),
        (["lubricant={kind: oil, viscosity_40: 32mm²/s, viscosity_100: 40mm²/s}"], "thin"),
        (["lubricant={kind: oil, viscosity_40: 32mm²/s, name: VG32}"], "keep one"),
        (["lubricant.kind=grease", "drive.speed=0.5"], "dry"),
        (["lubricant.kind=grease", "surface.roughness=0"], "roughness"),
        (["lubricant.kind=honey"], "grease"),
    ],
)
def test_bad_lubricants_get_a_sentence(changes, phrase, refused):
    arguments = [argument for change in changes for argument in ("--set", change)]
    assert phrase in refused("bearing", "6203", "--load", "0,-400,0", *arguments)


def figures_of(scene, *changes):
    return reported(scene, *changes, "solver.check=none").figures


def test_one_contact_drags_ball_and_ring_as_published():
    """Friction switched off, the ball is dragged by -F at either contact and pushed by 2 F R_x/r at its centre."""
    gamma, u = 6.746 / 28.5, 0.25 * 183.26 * 28.5e-3 * (1.0 - (6.746 / 28.5) ** 2)
    across = 2.0 * CONFORMITY * BALL / (2.0 * CONFORMITY - 1.0)
    for kind, column in (("grease", 1), ("oil", 2)):
        oil = f"lubricant.kind={kind}", "lubricant.boundary_friction=1e-9", "lubricant.film_friction=0"
        rest = "geometry.radial_clearance=-6e-6", "drive.offset=[0, 0, 0]", "gravity=[0, 0, 0]", "solver.check=none"
        values = run_all("bearing_6203", *TABLE_SCENE[1:], *oil, *rest, "run={duration: 1e-3, output_rate: 1000}")[1][0]
        drag, load = np.linalg.norm(values["friction_force"], axis=-1), values["normal_load"]
        radial = values["position"] * [1.0, 1.0, 0.0]
        along = np.cross([0.0, 0.0, 1.0], radial / np.linalg.norm(radial, axis=-1)[:, None])
        inlet = 0.9829 * (0.9515 if kind == "grease" else 1.0)
        for side, sign in ((0, -1.0), (1, 1.0)):
            resistance = inlet * published(load[0, side], u, BALL * (1.0 + sign * gamma), across)[column]
            curved = across / (BALL * (1.0 + sign * gamma)) - 1.0
            steel = 7.48e-7 * BALL**0.33 * load[0, side] ** 1.33 * (1.0 - 3.519e-3 * curved**0.8063)
            assert drag[:, side] == pytest.approx(resistance + 0.5 * steel / BALL, rel=8e-3)
            assert np.sum(values["friction_force"][:, side] * along, axis=-1) == pytest.approx(sign * drag[:, side])
        driven = np.sum(values["raceway_force"] * along, axis=-1)
        expected = drag[:, 0] * (1.0 - 2.0 * gamma) - drag[:, 1] * (1.0 + 2.0 * gamma)
        assert driven == pytest.approx(expected, rel=5e-3)
        # the ring is dragged by F alone: what pushes it goes through its centre
        on_ring = -drag[:, 0] * np.linalg.norm((values["point"] * [1.0, 1.0, 0.0])[:, 0], axis=-1)
        assert values["inner_ring_torque"][2] == pytest.approx(on_ring.sum(), rel=1e-6)


MOVING = {
    "held": ("bearing_6203", ("run.duration=0.2",)),
    "patches": ("bearing_6203", ("run.duration=0.1", "contact.friction=spot")),
    "tilted": ("bearing_6203_tilted", ("run.duration=0.05",)),
    "level": ("bearing_6203_rig_400N", ("run.duration=0.05",)),
    "tilting": ("bearing_6203_rig_400N", ("run.duration=0.03", "rings.inner.free=all")),
    "guided": ("bearing_6203_guided_cage", ("run.duration=0.02",)),
    "torque": ("bearing_6203_run_up", ("run.duration=0.05",)),
    "explicit": ("bearing_6203", ("run.duration=2e-3", "solver.stepper=dopri5")),
}


@pytest.mark.parametrize("kind", ["grease", "oil"])
def test_power_closes_with_every_part(kind):
    for name, (scene, changes) in MOVING.items():
        figures = figures_of(scene, *changes, f"lubricant.kind={kind}")
        assert abs(figures["energy_closure"]) < 1e-5, name


def test_moving_balls_take_the_torque_of_equilibria(run_json):
    """Within 3 %; of a bearing that a load pushes to one side of equilibria with balls anywhere."""
    for scene, angles in (("bearing_6203", (0.0,)), ("bearing_6203_rig_400N", np.arange(0.0, 45.0, 5.0) - 90.0)):
        command = "bearing", scene, "--set", "lubricant.kind=grease", "--ball-angle"
        equilibria = [run_json(*command, f"{angle}")["friction_torque_nm"]["total"] for angle in angles]
        scene_keys = scene, "lubricant.kind=grease", "run.duration=0.2"
        moving = [
            figures_of(*scene_keys, f"wanted.tolerance={tolerance}")["drive_torque_nm"]
            for tolerance in ("1e-3", "1e-5")
        ]
        assert moving[0] == pytest.approx(np.mean(equilibria), rel=0.03)
        assert moving[0] == pytest.approx(moving[1], rel=1e-3)


def test_where_contacts_spin_a_lubricated_bearing_has_friction_over_the_patch(run_json):
    """Equilibria add up slip by rolling and by spin, which is an upper bound; friction at a point has no spin."""
    combined = ("rings.inner.load=[0, -400, 300]", "run.duration=0.05", "solver.check=none")
    torque = [figures_of("bearing_6203_greased", *combined, *changes) for changes in ((), ("contact.friction=point",))]
    combined_torque, rolling = (figures["drive_torque_nm"] for figures in torque)
    upper_bound = run_json("bearing", "bearing_6203_greased", "--set", combined[0])["friction_torque_nm"]["total"]
    assert 1.1 * rolling < combined_torque < upper_bound
    for load, friction in (("[0, -400, 0]", "point"), ("[0, -400, 1]", "spot")):
        scene = load_scene("bearing_6203_greased", [f"rings.inner.load={load}"])
        assert choose(scene).friction == friction
        assert load_scene(scene.resolved()).parameters.contact == scene.parameters.contact
    assert load_scene("bearing_6203_rig_400N").parameters.contact.friction == "point"


def test_films_of_moving_contacts_are_those_of_their_loads_at_the_speed_of_rolling():
    elastic = "contact.relaxation_time=0", "solver.check=none"  # films follow the elastic load
    scene = load_scene("bearing_6203_rig_400N", ("lubricant.kind=grease", "run.duration=0.02", *elastic))
    values, parameters = run_all(scene)[1][-1], scene.parameters
    ball, geometry, lubricant = parameters.materials.ball, parameters.geometry, film_lubricant(parameters)
    ratio = geometry.ball_diameter / geometry.pitch_diameter
    rolling = 0.25 * float(values["inner_ring_speed"]) * geometry.pitch_diameter * (1.0 - ratio**2)
    assert not values["film_thickness"][values["normal_load"] == 0.0].any()
    loaded = values["normal_load"] > 1.0  # N; a load sets in over 1e-6 N
    small, large, load = (values[name][loaded] for name in ("curvature_small", "curvature_large", "normal_load"))
    modulus = 0.5 * ball.young_modulus / (1.0 - ball.poisson_ratio**2)
    numbers = film_numbers(lubricant, small, large, modulus, 0.5 * geometry.ball_diameter)
    expected = films(lubricant, numbers, load, np.full(len(load), rolling))
    assert values["film_thickness"][loaded] == pytest.approx(expected[:, 0], rel=1e-2)
    assert values["film_ratio"][loaded] == pytest.approx(expected[:, 1], rel=1e-2)


def test_a_run_of_equilibria_has_the_films_and_the_torque_of_the_bearing_command(run_json):
    """At one place of the balls those of `bearing`, over many those of moving balls within 3 %; all work is lost."""
    greased = ("lubricant.kind=grease", "contact.normal=hertz", "solver.check=none")
    keys = "gravity=[0, 0, 0]", "model.dimension=quasi_static", "run.duration=0.2"
    report, block = run_all("bearing_6203_rig_400N", *greased, *keys)
    first, last, figures = block[0], block[-1], report.figures
    angle = f"{math.degrees(first['orbit_angle'][0])}"
    command = "bearing", "bearing_6203_rig_400N", "--ball-angle", angle
    answer = run_json(*command, "--set", greased[0], "--set", greased[1])
    assert first["drive_torque"] == pytest.approx(answer["friction_torque_nm"]["total"], rel=1e-6)
    films_of_loads = first["film_thickness"][first["film_thickness"] > 0.0]
    assert films_of_loads.min() == pytest.approx(answer["film_m"], rel=1e-6)
    assert first["film_ratio"][first["film_ratio"] > 0.0].min() == pytest.approx(answer["lambda"], rel=1e-6)
    moving = figures_of("bearing_6203_rig_400N", *greased, "run.duration=0.1")["drive_torque_nm"]
    assert figures["drive_torque_nm"] == pytest.approx(moving, rel=0.03)
    turned = float(last["inner_ring_angle"] - first["inner_ring_angle"])
    assert figures["dissipated_j"] == pytest.approx(figures["drive_torque_nm"] * turned, rel=1e-2)
    assert abs(figures["energy_closure"]) < 1e-5


def test_lubricated_equilibria_that_turn_backwards_or_rest():
    scene = ("bearing_6203_rig_400N", "lubricant.kind=grease", "model.dimension=quasi_static", "run.duration=0.01")
    torques = [figures_of(*scene, f"drive.speed={speed}")["drive_torque_nm"] for speed in (183.26, -183.26, 0.0)]
    assert torques == [pytest.approx(-torques[1], rel=1e-3), pytest.approx(-torques[0], rel=1e-3), 0.0]
    assert torques[0] > 1e-3


def test_friction_in_oil_is_smoothed_over_half_a_per_cent_of_rolling():
    def smoothing(*keys, scene="bearing_6203_greased"):
        return load_scene(scene, keys).parameters.contact.friction_regularisation

    geometry = load_scene("bearing_6203_greased").parameters.geometry
    ratio = geometry.ball_diameter / geometry.pitch_diameter
    rolling = 0.25 * 50.0 * geometry.pitch_diameter * (1.0 - ratio**2)
    assert smoothing("drive.speed=-50") == pytest.approx(5e-3 * rolling)
    assert smoothing("drive.speed=5000") == smoothing(scene="bearing_6203") == 0.01
    assert smoothing("contact.friction_regularisation=0.02") == 0.02
