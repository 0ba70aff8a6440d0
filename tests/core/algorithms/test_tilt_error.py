"""What a tilt of first order is off is reported: against a ring turned as a whole, in equilibria and in runs."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation

from bearing_twin.kinds.bearing.equilibrium import EquilibriumSolver, Support, azimuths_of, setting_of
from bearing_twin.kinds.bearing.equilibrium_report import answer_of
from bearing_twin.kinds.bearing.model_error import response_to_tilt
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
    angle = brentq(
        lambda angle_of_point: float(point(angle_of_point)[:2] @ (-sine, cosine)),
        azimuth - 0.3,
        azimuth + 0.3,
        xtol=1e-15,
    )
    x, y, z = point(angle)
    return x * cosine + y * sine - setting.outer.locus_radius, z


def true_balance(geometry, setting, azimuths, ring, stiffness):
    """Loads of balls at rest (N,) [N] between true circles, and what holds the ring (5,) [N, N m], by its forces."""
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    loads, ring_loads = [], np.zeros(5)
    for azimuth in azimuths:
        radial, axial = turned_opening(setting, ring, azimuth)
        distance, outwards = math.hypot(radial, axial), setting.outer.locus_radius + radial
        load = stiffness * max(distance - free, 0.0) ** 1.5
        plane = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        force = load * (radial * plane + (0.0, 0.0, axial)) / distance
        arm = outwards * plane + (0.0, 0.0, axial) - ring[:3]
        ring_loads += (*force, *np.cross(arm, force)[:2])
        loads.append(load)
    return np.array(loads), ring_loads


CASES = [
    (ANGULAR, ALL_FREE, (0.0, -300.0, 500.0, 0.2, 0.0), (0.0, 0.0)),
    (ANGULAR, ALL_FREE, (0.0, -300.0, 500.0, 0.0, 0.0), (0.0, 0.0)),
    ((), UPRIGHT, (0.0, -200.0, 100.0, 0.0, 0.0), (2e-3, 0.0)),
    (ANGULAR, UPRIGHT, (0.0, -300.0, 500.0, 0.0, 0.0), (2.2e-3, 0.0)),
    ((), ALL_FREE, (0.0, -200.0, 100.0, 0.6, 0.2), (0.0, 0.0)),
]


@pytest.mark.parametrize(("keys", "free", "loads", "tilt"), CASES)
def test_equilibria_know_what_a_ring_turned_as_a_whole_changes(keys, free, loads, tilt):
    """Newton's method on true circles, contacts as stiff: changes with their signs, and errors that hold them."""
    parameters = load_scene("bearing_6203", ("gravity=[0,0,0]", "drive.speed=0", *keys)).parameters
    setting, azimuths = setting_of(parameters, "hertz", 0.0), azimuths_of(parameters.geometry.balls, 0.1)
    solver, support = EquilibriumSolver(setting, azimuths), Support(free, loads, (0.0, 0.0, 0.0, *tilt))
    equilibrium = solver.solve(support)
    contacts, begin, moves = equilibrium.contacts, equilibrium.coordinates, np.array(free)
    stiffness = float((contacts.load.mean(axis=1) / contacts.approach.sum(axis=1) ** 1.5).mean())
    sizes, scales = np.array([1e-6] * 3 + [1e-4] * 2), np.array([100.0] * 3 + [1.0] * 2)

    def ring_at(free_places):
        ring = begin.copy()
        ring[moves] += free_places * sizes[moves]
        return ring

    def residual(free_places):
        holds = true_balance(parameters.geometry, setting, azimuths, ring_at(free_places), stiffness)[1]
        return ((holds - loads) / scales)[moves]

    assert (
        np.abs(residual(np.zeros(moves.sum()))).max() > 1e-3
    )  # as first order has it, the true ring is not in balance
    true = ring_at(least_squares(residual, np.zeros(moves.sum()), xtol=1e-15, ftol=1e-15, gtol=1e-15).x)
    carried, ring_loads = true_balance(parameters.geometry, setting, azimuths, true, stiffness)
    reported = response_to_tilt(solver, support, equilibrium)
    load_changes, shift = carried - contacts.load[:, 1], true - begin
    assert reported.loads[:, 1] == pytest.approx(load_changes, abs=0.06 * np.abs(load_changes).max())
    assert reported.coordinates[:3] == pytest.approx(shift[:3], abs=0.06 * np.abs(shift[:3]).max())
    assert reported.coordinates[3:] == pytest.approx(shift[3:], rel=0.03, abs=1e-9)
    forces = np.where(moves, 0.0, ring_loads - equilibrium.loads)
    assert reported.ring_loads == pytest.approx(forces, rel=0.03, abs=1e-5)
    answer = answer_of(parameters, "hertz", solver, support, equilibrium)["model_errors"]["first_order_tilt"]
    assert answer["misalignment_rad"] == pytest.approx(np.abs(reported.coordinates[3:]).tolist(), abs=1e-12)
    assert answer["normal_load_n"] == pytest.approx(np.abs(reported.loads).max(), rel=1e-12)


def test_a_ring_that_is_not_tilted_has_no_such_error():
    """Held upright, or free under a thrust that tilts it by rounding alone."""
    for scene, free, load in (("bearing_6203", UPRIGHT, -200.0), ("bearing_218_thrust", ALL_FREE, 0.0)):
        parameters = load_scene(scene).parameters
        setting = setting_of(parameters, "hertz", parameters.drive.speed)
        solver = EquilibriumSolver(setting, azimuths_of(parameters.geometry.balls, 0.0))
        support = Support(free, (0.0, load, 17800.0, 0.0, 0.0), (0.0,) * 5)
        assert response_to_tilt(solver, support, solver.solve(support)) is None, scene
