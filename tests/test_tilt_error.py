"""What a tilt of first order is off is told: against a ring turned as a whole, in equilibria and in runs."""

import functools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation

from bearing_twin.kinds.bearing.load_error import by_load
from bearing_twin.kinds.bearing.quasi_static.answer import answer_of
from bearing_twin.kinds.bearing.quasi_static.statics import EquilibriumSolver, Support, azimuths_of, setting_of
from bearing_twin.kinds.bearing.quasi_static.tilt_response import response_to_tilt
from bearing_twin.kinds.bearing.quasi_static.worth import LOADS_OF, errors_of, spots_of
from bearing_twin.kinds.bearing.tilt_error import Tilted
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

ANGULAR = (
    "geometry.balls=16", "geometry.ball_diameter=7e-3", "geometry.pitch_diameter=38.5e-3",
    "geometry.inner_conformity=0.515", "geometry.outer_conformity=0.525", "geometry.contact_angle=0.4363323",
)  # fmt: skip
ALL_FREE, UPRIGHT = (True,) * 5, (True, True, True, False, False)


def turned_opening(setting, ring, azimuth):
    """Where a circle of groove centres that is turned as a whole crosses a ball's plane, from the outer one's [m]."""
    turn = Rotation.from_rotvec([ring[3], ring[4], 0.0]).as_matrix()

    def point(angle):
        return np.array(ring[:3]) + setting.inner.locus_radius * turn @ (math.cos(angle), math.sin(angle), 0.0)

    cosine, sine = math.cos(azimuth), math.sin(azimuth)
    angle = brentq(lambda one: float(point(one)[:2] @ (-sine, cosine)), azimuth - 0.3, azimuth + 0.3, xtol=1e-15)
    x, y, z = point(angle)
    return x * cosine + y * sine - setting.outer.locus_radius, z


def true_balance(geometry, setting, azimuths, ring, stiffness):
    """Loads of balls at rest (N,) [N] between true circles, and what holds the ring (5,) [N, N m], by its forces."""
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    loads, holds = [], np.zeros(5)
    for azimuth in azimuths:
        radial, axial = turned_opening(setting, ring, azimuth)
        apart, outwards = math.hypot(radial, axial), setting.outer.locus_radius + radial
        load = stiffness * max(apart - free, 0.0) ** 1.5
        plane = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        force = load * (radial * plane + (0.0, 0.0, axial)) / apart
        arm = outwards * plane + (0.0, 0.0, axial) - ring[:3]
        holds += (*force, *np.cross(arm, force)[:2])
        loads.append(load)
    return np.array(loads), holds


CASES = [
    (ANGULAR, ALL_FREE, (0.0, -300.0, 500.0, 0.2, 0.0), (0.0, 0.0)),
    (ANGULAR, ALL_FREE, (0.0, -300.0, 500.0, 0.0, 0.0), (0.0, 0.0)),
    ((), UPRIGHT, (0.0, -200.0, 100.0, 0.0, 0.0), (2e-3, 0.0)),
    (ANGULAR, UPRIGHT, (0.0, -300.0, 500.0, 0.0, 0.0), (2.2e-3, 0.0)),
    ((), ALL_FREE, (0.0, -200.0, 100.0, 0.6, 0.2), (0.0, 0.0)),
]


@pytest.mark.parametrize(("words", "free", "loads", "tilt"), CASES)
def test_equilibria_know_what_a_ring_turned_as_a_whole_changes(words, free, loads, tilt):
    """Newton's method on true circles, contacts as stiff: changes with their signs, and errors that hold them."""
    parameters = load_scene("bearing_6203", ("gravity=[0,0,0]", "drive.speed=0", *words)).parameters
    setting, azimuths = setting_of(parameters, "hertz", 0.0), azimuths_of(parameters.geometry.balls, 0.1)
    solver, support = EquilibriumSolver(setting, azimuths), Support(free, loads, (0.0, 0.0, 0.0, *tilt))
    found = solver.solve(support)
    contacts, begin, moves = found.contacts, found.coordinates, np.array(free)
    stiffness = float((contacts.load.mean(axis=1) / contacts.approach.sum(axis=1) ** 1.5).mean())
    sizes, scales = np.array([1e-6] * 3 + [1e-4] * 2), np.array([100.0] * 3 + [1.0] * 2)

    def placed(free_places):
        ring = begin.copy()
        ring[moves] += free_places * sizes[moves]
        return ring

    def left(free_places):
        holds = true_balance(parameters.geometry, setting, azimuths, placed(free_places), stiffness)[1]
        return ((holds - loads) / scales)[moves]

    assert np.abs(left(np.zeros(moves.sum()))).max() > 1e-3  # as first order has it, the true ring is not in balance
    true = placed(least_squares(left, np.zeros(moves.sum()), xtol=1e-15, ftol=1e-15, gtol=1e-15).x)
    carried, held = true_balance(parameters.geometry, setting, azimuths, true, stiffness)
    told = response_to_tilt(solver, support, found)
    more, moved = carried - contacts.load[:, 1], true - begin
    assert told.loads[:, 1] == pytest.approx(more, abs=0.06 * np.abs(more).max())
    assert told.coordinates[:3] == pytest.approx(moved[:3], abs=0.06 * np.abs(moved[:3]).max())
    assert told.coordinates[3:] == pytest.approx(moved[3:], rel=0.03, abs=1e-9)
    forces = np.where(moves, 0.0, held - found.loads)
    assert told.ring_loads == pytest.approx(forces, rel=0.03, abs=1e-5)
    off = errors_of(parameters, "hertz", solver, support, found, spots_of(parameters, contacts))
    assert (off.columns["normal_load"].max() > np.abs(more)).all()
    assert (off.coordinates[3:] + 1e-12 >= np.abs(moved[3:])).all()
    assert (off.ring_loads[3:] + 1e-6 >= np.abs(forces[3:])).all()
    answer = answer_of(parameters, "hertz", solver, support, found)
    assert answer["misalignment_rad_error"] == off.coordinates[3:].tolist()


def test_a_ring_that_is_not_tilted_has_no_such_error():
    parameters = load_scene("bearing_6203", ("drive.speed=0",)).parameters
    solver = EquilibriumSolver(setting_of(parameters, "hertz", 0.0), azimuths_of(8, 0.0))
    support = Support(UPRIGHT, (0.0, -200.0, 100.0, 0.0, 0.0), (0.0,) * 5)
    assert response_to_tilt(solver, support, solver.solve(support)) is None


def left_out_of(words, scene="bearing_6203_tilted"):
    run = simulate(load_scene(scene, ("gravity=[0,0,0]", *words)))
    blocks = list(run.blocks())
    by_source = run.report.errors["errors_by_source"]
    return run.report.figures, {key: np.array(one.get("left_out", 0.0)) for key, one in by_source.items()}, blocks


def test_a_run_with_a_tilted_ring_tells_what_its_loads_are_off():
    """Of balls as good as at rest between true circles; the greatest, and no more than what a whole tilt makes."""
    words = "drive.speed=1", "run.duration=1e-3", "contact.normal=hertz"
    tilt = 2e-3
    figures, told, blocks = left_out_of((*words, f"drive.tilt=[{tilt},0]"))
    without = left_out_of((*words, "drive.tilt=[0,0]"))[1]
    scene = load_scene("bearing_6203_tilted", ("gravity=[0,0,0]", *words, f"drive.tilt=[{tilt},0]")).parameters
    setting, first = setting_of(scene, "hertz", 0.0), blocks[0].values
    azimuths, load = first["orbit_angle"][0], first["normal_load"][0]
    pressed = first["approach"][0].sum(axis=1)
    stiffness = float((load.mean(axis=1) / pressed**1.5).mean())
    ring = np.array([*scene.drive.offset, *scene.drive.tilt])
    off = np.abs(true_balance(scene.geometry, setting, azimuths, ring, stiffness)[0] - load[:, 0])
    wide = np.array(figures["semi_major_inner_m"]) / (0.5 * scene.geometry.ball_diameter)
    tilted = told["greatest_normal_load_inner_n"] - wide**2 * figures["greatest_normal_load_inner_n"]
    assert off.max() > 0.005 * load.max()
    assert (tilted > 0.99 * off).all()
    assert tilted.max() < 1.1 * off.max()
    assert (without["greatest_normal_load_inner_n"] < told["greatest_normal_load_inner_n"]).all()


def test_the_moment_on_a_ring_that_tilts_freely_keeps_to_its_load():
    """A 7205 under a radial load, thrust and a moment: angular momentum of the ring, and the moment of the balls."""
    words = (
        *ANGULAR, "model.dimension=free", "cage.kind=even", "rings.inner.free=all", "rings.inner.mass=0.6",
        "rings.inner.load=[0,-300,500]", "rings.inner.moment=[0.2,0]", "rings.inner.inertia=[2e-4,2e-4]",
        "drive.speed=628.3185", "drive.tilt=[0,0]", "drive.offset=[0,0,0]", "run.duration=0.02", "run.output_rate=2e4",
    )  # fmt: skip
    figures, told, blocks = left_out_of(words)
    half = [block.values for block in blocks if len(block)]
    values = {name: np.concatenate([one[name] for one in half]) for name in ("inner_ring_tilt", "inner_ring_tilt_rate")}
    late = slice(len(values["inner_ring_tilt"]) // 2, None)
    tilt, rate = values["inner_ring_tilt"][late], values["inner_ring_tilt_rate"][late]
    spin = 2e-4 * np.array([rate[-1, 0] - rate[0, 0], rate[-1, 1] - rate[0, 1]])
    gyro = 2e-4 * 628.3185 * np.array([tilt[-1, 1] - tilt[0, 1], tilt[0, 0] - tilt[-1, 0]])
    wanted = (spin + gyro) / 0.01 - (0.2, 0.0)
    off = np.abs(np.array(figures["ring_moment_nm"]) - wanted)
    assert (off < 1e-3).all()  # of 0.2 N m
    size = np.hypot(*figures["misalignment_rad"])
    assert 0.005 * size < told["misalignment_rad"].max() < 0.05 * size


def tilted_at(angle, load, tilt, moment=0.0):
    """(what was seen, figures) of two balls under this load [N] at this contact angle [rad], and so much a moment."""
    seen, key = Tilted(2), ("inner_m", "outer_m")
    values = {"inner_ring_tilt": np.array([[tilt, 0.0]]), "approach": np.full((1, 2, 2), 3e-6)}
    seen.add(SimpleNamespace(values=values), np.ones((2, 2), bool), (np.zeros(4, int), *np.nonzero(np.ones((2, 2)))))
    figures = {
        "contact_angle_inner_rad": [angle] * 2,
        "normal_load_inner_n": [load] * 2,
        "misalignment_rad": [tilt, 0.0],
    }
    figures |= {f"{name}_{side}": [1.0, 1.0] for name in ("semi_major", "semi_minor") for side in key}
    figures |= {f"peak_pressure_{side}_pa": [1.0, 1.0] for side in ("inner", "outer")}
    return seen, figures | {"ring_moment_nm": [moment, 0.0]}


@pytest.mark.parametrize("given", [False, True])
def test_what_is_off_of_a_ring_follows_from_what_is_given(given):
    """Its place or its loads; contact angles as those of a circle that is turned as a whole."""
    parameters, angle, load, tilt = load_scene("bearing_6203").parameters, 0.3, 100.0, 2e-3
    setting, geometry = setting_of(parameters, "hertz", 0.0), parameters.geometry
    seen, figures = tilted_at(angle, load, tilt, moment=5.0)
    found = seen.errors(geometry, figures, np.full((2, 2), load), given)
    lower, radius = 0.5 * setting.inner.locus_radius * tilt**2, setting.inner.locus_radius
    off = 1.5 * load / 6e-6 * math.cos(angle) * lower
    moment = tilt * radius * 2.0 * load * math.cos(angle)
    near = functools.partial(pytest.approx, rel=3e-4)  # the circle of a bearing with interference is 1e-4 larger
    assert found["normal_load_outer_n"] == near([off] * 2)
    assert found["ring_moment_nm"] == near([0.0 if given else moment] * 2)
    assert found["ring_force_n"] == near([0.0 if given else off] * 3)
    assert found["ring_displacement_m"] == near([lower if given else 0.0] * 3)
    assert found["misalignment_rad"] == near([moment / 5.0 * tilt if given else 0.0] * 2)
    # The circle's point that a tilt about x lifts, seen by the ball there, with the ring pushed along z to this angle.
    apart = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    shift = setting.outer.locus_radius + apart * math.cos(angle) - radius
    ring = (0.0, shift, apart * math.sin(angle) - radius * tilt, tilt, 0.0)
    radial, axial = turned_opening(setting, ring, 0.5 * math.pi)
    told = found["contact_angle_inner_rad"][0]
    assert told == pytest.approx(math.atan2(axial, radial) - angle, rel=0.05)


def test_a_run_of_equilibria_tells_what_its_tilt_is_off_as_equilibria_do():
    words = *ANGULAR, "rings.inner.load=[0,-300,500]", "rings.inner.moment=[0.2,0]", "rings.inner.free=all"
    words = *words, "model.dimension=quasi_static", "drive.tilt=[0,0]", "drive.offset=[0,0,0]", "drive.speed=10"
    figures, told, _ = left_out_of((*words, "run.duration=2e-3"))
    size = math.hypot(*figures["misalignment_rad"])
    assert 0.005 * size < told["misalignment_rad"].max() < 0.05 * size  # 0.0087 by circles turned as a whole
    assert told["ring_moment_nm"].max() == 0.0  # it is given, and taken as it is


def test_errors_of_loads_go_through_the_balance_of_what_is_given():
    """N = C d^1.5 at a given load: contacts stiffer by s are pressed 2 s/3 less; at a given place they bear s more."""
    geometry, load = load_scene("bearing_6203").parameters.geometry, np.array([[100.0, 110.0], [50.0, 60.0]])
    share = np.array([[0.03, 0.03], [0.01, 0.02]])
    _, figures = tilted_at(0.2, 80.0, 0.0)
    figures |= {
        "ring_force_n": [0.0, -200.0, 10.0],
        "ring_moment_nm": [0.0, 0.5],
        "ring_displacement_m": [3e-6, 4e-6, 0.0],
    }
    figures |= {f"{key}_{side}_n": [80.0, 40.0] for key in LOADS_OF for side in ("inner", "outer")}
    held, free = (by_load(geometry, figures, load, share, None, given) for given in (False, True))
    for found in (held, free):
        assert found["normal_load_inner_n"] == pytest.approx([2.4, 0.4])
    uneven = 0.02 * 120.0  # what contacts do not share, of all they carry
    assert held["ring_force_n"] == pytest.approx([0.03 * 200.0 + uneven] * 3)
    assert held["ring_moment_nm"] == pytest.approx([0.03 * 0.5 + 0.5 * geometry.pitch_diameter * uneven] * 2)
    assert free["ring_displacement_m"] == pytest.approx([2.0 / 3.0 * 0.03 * 5e-6] * 3)
    assert not any((*free["ring_force_n"], *free["ring_moment_nm"], *held["ring_displacement_m"]))
    response = SimpleNamespace(coordinates=np.array([0.0, -1e-7, 0.0, 1e-5, 0.0]), ring_loads=np.zeros(5))
    stands = by_load(geometry, figures, load, share, SimpleNamespace(kept=0.1, response=response), True)
    assert stands["greatest_normal_load_outer_n"] == pytest.approx([0.24, 0.08])
    assert (stands["ring_displacement_m"], stands["misalignment_rad"]) == ([0.0, 1e-7, 0.0], [1e-5, 0.0])


def test_loads_that_were_greatest_before_a_ring_tilted_are_off_as_well():
    still, tilted = (
        SimpleNamespace(values={"inner_ring_tilt": np.array([[tilt, 0.0]]), "approach": np.full((1, 2, 2), 3e-6)})
        for tilt in (0.0, 2e-3)
    )
    seen, load = Tilted(2), np.full((2, 2), 100.0)
    seen.add(still, np.ones((2, 2), bool), (np.zeros(4, int), *np.nonzero(np.ones((2, 2)))))
    seen.add(tilted, np.zeros((2, 2), bool), (np.zeros(0, int),) * 3)
    _, figures = tilted_at(0.0, 100.0, 0.0)
    geometry = load_scene("bearing_6203").parameters.geometry
    radius = 0.5 * geometry.pitch_diameter + 0.02 * geometry.ball_diameter
    off = seen.errors(geometry, figures, load, given=False)["greatest_normal_load_inner_n"]
    assert off == pytest.approx([1.5 * 100.0 / 6e-6 * 0.5 * radius * 4e-6] * 2)
