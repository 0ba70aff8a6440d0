"""The ball in a groove against geometry done the long way: nearest points and curvatures by brute force."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.shapes.implicit import ellipsoid, plane
from bearing_twin.shapes.surfaces import ball_in_groove, ellipsoid_on_plane, ellipsoid_reach, ellipsoid_slopes
from bearing_twin.shapes.tracking import body, contact_of, find_opposing

BALL, GROOVE = 3.373e-3, 0.52 * 6.746e-3


def torus(locus, phi, tube):
    radial = locus + GROOVE * np.cos(tube)
    return np.array([radial * np.cos(phi), radial * np.sin(phi), GROOVE * np.sin(tube)])


@pytest.mark.parametrize(("locus", "distance", "tube_guess"), [(14.1e-3, 14.25e-3, 0.1), (14.4e-3, 14.25e-3, 3.0)])
@pytest.mark.parametrize("height", [0.0, 2e-5, -4e-5])
def test_groove_normal_and_gap_are_those_of_the_extreme_point(locus, distance, height, tube_guess):
    """The contact is where the torus is farthest from the ball's centre in the meridian plane of the groove."""
    centre = np.array([distance, 0.0, height])
    found = minimize(
        lambda t: 1e3 * np.linalg.norm(torus(locus, 0.0, t[0]) - centre),
        [tube_guess],
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-16},
    )
    point = torus(locus, 0.0, found.x[0])
    contact = ball_in_groove(distance, height, BALL, locus, GROOVE)
    reach = np.linalg.norm(point - centre)
    assert contact.approach == pytest.approx(BALL - reach, abs=1e-12)
    direction = (point - centre) / reach
    assert [contact.normal_radial, 0.0, contact.normal_axial] == pytest.approx(direction, abs=1e-4)


@pytest.mark.parametrize(("locus", "tube"), [(10.7e-3, 0.0), (10.7e-3, 0.2), (17.7e-3, np.pi), (17.7e-3, np.pi - 0.15)])
def test_curvatures_are_those_of_the_torus(locus, tube):
    """Principal curvatures by finite differences of the parametrised torus, half the relative ones of the pair."""
    step = 1e-4
    normal = np.array([np.cos(tube), 0.0, np.sin(tube)])  # outwards from the tube: from ball to raceway
    point = torus(locus, 0.0, tube)
    along = (
        (torus(locus, 0.0, tube + step) + torus(locus, 0.0, tube - step) - 2.0 * point) @ normal / (step * GROOVE) ** 2
    )
    radius = locus + GROOVE * np.cos(tube)
    around = (torus(locus, step, tube) + torus(locus, -step, tube) - 2.0 * point) @ normal / (step * radius) ** 2
    centre = point - (BALL - 1e-6) * normal
    contact = ball_in_groove(centre[0], centre[2], BALL, locus, GROOVE)
    assert contact.approach == pytest.approx(1e-6, abs=1e-12)
    assert contact.curvature_small == pytest.approx(0.5 * (1.0 / BALL + along), rel=1e-4)
    assert contact.curvature_large == pytest.approx(0.5 * (1.0 / BALL + around), rel=1e-4)
    assert 0.0 < contact.curvature_small < contact.curvature_large


def test_the_centre_circle_is_defined():
    contact = ball_in_groove(0.014, 0.0, BALL, 0.014, GROOVE)
    assert contact.approach < 0.0
    assert (contact.normal_radial, contact.normal_axial) == (0.0, 0.0)


AXES = (0.03, 0.02, 0.012)
TURNS = [(0.0, 0.0, 0.0), (0.4, -0.3, 0.2), (1.2, 0.7, -2.0), (0.0, 1.5, 0.1), (2.0, 0.1, 0.3)]


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("axes", [AXES, (0.02, 0.02, 0.02), (0.02, 0.02, 0.01), (0.01, 0.02, 0.02)])
def test_the_ellipsoids_lowest_point_is_what_the_opposing_points_of_two_surfaces_say(axes, turn):
    rotation = rotation_matrix(quaternion_from_vector(turn))
    low = ellipsoid_on_plane(axes, tuple(-rotation[2]))
    height = low.reach - 1e-5
    one, other = body(ellipsoid(*axes), (0.0, 0.0, height), rotation), body(plane())
    at = rotation @ low.point
    found = contact_of(one, other, find_opposing(one, other, (*at[:2], 0.0)))
    assert found.approach == pytest.approx(1e-5, rel=1e-9)
    assert found.point_a - [0.0, 0.0, height] == pytest.approx(at, abs=1e-14)
    assert low.curvature_small == pytest.approx(found.curvature_small, rel=1e-10)
    assert low.curvature_large == pytest.approx(found.curvature_large, rel=1e-10)
    mean = 0.5 * (low.curvature_small + low.curvature_large)
    assert low.shape == pytest.approx(mean / math.sqrt(low.curvature_small * low.curvature_large), rel=1e-13)
    assert low.shape_excess == pytest.approx(math.sqrt(max(low.shape**2 - 1.0, 0.0)), rel=1e-9, abs=1e-7)
    if not found.circular:
        assert abs(found.major_axis @ (rotation @ low.major_axis)) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("turn", TURNS)
def test_slopes_of_the_gap_are_its_differences(turn):
    down = -rotation_matrix(quaternion_from_vector(turn))[2]
    reach, point = ellipsoid_reach(AXES, tuple(down))
    size, shape = ellipsoid_slopes(AXES, tuple(down), reach, point)
    assert abs(np.dot(size, down)) + abs(np.dot(shape, down)) < 1e-14
    for axis in np.eye(3):
        aside = axis - (axis @ down) * down
        lows = []
        for sign in (1.0, -1.0):
            moved = down + sign * 1e-5 * aside
            lows.append(ellipsoid_on_plane(AXES, tuple(moved / np.linalg.norm(moved))))
        sizes = [-0.25 * math.log(low.curvature_small * low.curvature_large) for low in lows]
        assert (sizes[0] - sizes[1]) / 2e-5 == pytest.approx(np.dot(size, axis), abs=1e-7)
        assert (lows[0].shape - lows[1].shape) / 2e-5 == pytest.approx(np.dot(shape, axis), abs=1e-7)
