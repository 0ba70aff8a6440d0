"""Opposing points of implicit surfaces (paper 1, eqs. 1-6): closed forms, differential form, wrong roots refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bearing_twin.errors import SceneError
from bearing_twin.shapes.implicit import SURFACES, ellipsoid, level, plane, sphere, superquadric, torus
from bearing_twin.shapes.surfaces import ball_in_groove
from bearing_twin.shapes.tracking import (
    body,
    contact_of,
    equations,
    find_opposing,
    opposing_rates,
    projected,
    tangent_axes,
)

BALL, GROOVE = 3.373e-3, 0.52 * 6.746e-3
EXAMPLES = {
    "plane": plane(),
    "sphere": sphere(0.7),
    "ellipsoid": ellipsoid(1.0, 0.8, 0.5, hollow=True),
    "torus": torus(1.0, 0.4),
    "superquadric": superquadric(1.0, 0.8, 0.6, 2.5, 4.0),
}
POINT = np.array([0.53, -0.41, 0.37])


def found(a, b, near):
    return contact_of(a, b, find_opposing(a, b, near))


def turned(*vector):
    return Rotation.from_rotvec(vector).as_matrix()


@pytest.mark.parametrize("name", sorted(SURFACES))
def test_gradient_and_hesse_matrix_are_the_derivatives(name):
    surface, step = EXAMPLES[name], 1e-6
    gradient, hesse, other, none = np.empty(3), np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    value = level(surface, POINT, gradient, hesse)
    assert level.py_func(surface, POINT, other, none) == pytest.approx(value, rel=1e-14)
    assert none == pytest.approx(hesse, rel=1e-13)
    for axis, shift in enumerate(step * np.eye(3)):
        slopes = [np.empty(3), np.empty(3)]
        values = [level(surface, POINT + sign * shift, one, none) for sign, one in zip((1, -1), slopes, strict=True)]
        assert (values[0] - values[1]) / (2 * step) == pytest.approx(gradient[axis], abs=1e-8)
        assert (slopes[0] - slopes[1]) / (2 * step) == pytest.approx(hesse[axis], abs=1e-8)


@pytest.mark.parametrize(("locus", "axis_distance", "side"), [(14.1e-3, 14.25e-3, 1), (14.4e-3, 14.25e-3, -1)])
@pytest.mark.parametrize("height", [0.0, 2e-5, -4e-5])
@pytest.mark.parametrize("orbit", [0.0, 2.0])
def test_ball_in_torus_groove_agrees_with_the_closed_form(locus, axis_distance, side, height, orbit):
    """Paper 1, section 5: the raceway is a hollow torus. All to 1e-10, wherever the ball is."""
    frame = turned(0.3, -0.8, 0.4)  # the whole bearing turned in space
    centre = np.array([axis_distance * math.cos(orbit), axis_distance * math.sin(orbit), height])
    outward = np.array([math.cos(orbit), math.sin(orbit), 0.0])
    ball, ring = body(sphere(BALL), frame @ centre), body(torus(locus, GROOVE, hollow=True), rotation=frame)
    contact = found(ball, ring, frame @ (centre + side * BALL * outward))
    closed = ball_in_groove(axis_distance, height, BALL, locus, GROOVE)
    normal = closed.normal_radial * outward + [0.0, 0.0, closed.normal_axial]
    along = -closed.normal_axial * outward + [0.0, 0.0, closed.normal_radial]
    assert contact.approach == pytest.approx(closed.approach, rel=1e-10)
    assert contact.normal == pytest.approx(frame @ normal, abs=1e-10)
    assert contact.curvature_small == pytest.approx(closed.curvature_small, rel=1e-10)
    assert contact.curvature_large == pytest.approx(closed.curvature_large, rel=1e-10)
    assert abs(contact.major_axis @ frame @ along) == pytest.approx(1.0, rel=1e-10)


@settings(max_examples=30, deadline=None)
@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(-1e-3, 1e-3))
def test_ellipsoid_on_plane_in_closed_form(vector, gap):
    """Support point r = D^2 n/|D n|, height |D n|; curvatures of z = h(x, y) there by the dual quadric."""
    size, turn = np.diag([0.10, 0.07, 0.05]), turned(*vector)
    down = turn.T @ [0.0, 0.0, -1.0]
    support = math.sqrt(down @ size @ size @ down)
    one, floor = body(ellipsoid(0.10, 0.07, 0.05), (0.2, -0.3, support + gap), turn), body(plane())
    foot = (one.position + turn @ size @ size @ down / support) * [1.0, 1.0, 0.0]
    contact = found(one, floor, foot)
    assert contact.approach == pytest.approx(-gap, abs=1e-14)
    assert contact.point_a - one.position == pytest.approx(turn @ size @ size @ down / support, abs=1e-12)
    assert contact.normal == pytest.approx([0.0, 0.0, -1.0], abs=1e-10)
    # The inverse of the curvature tensor is the Hesse matrix of the support function in the tangent plane.
    axes = tangent_axes(np.array([0.0, 0.0, -1.0])) @ turn
    inverse = axes @ (size @ size / support - np.outer(size @ size @ down, size @ size @ down) / support**3) @ axes.T
    radii = np.linalg.eigvalsh(inverse)
    assert [contact.curvature_small, contact.curvature_large] == pytest.approx(0.5 / radii[::-1], rel=1e-10)


def test_superquadric_of_exponent_two_is_an_ellipsoid_and_above_follows_its_gap():
    turn = turned(0.4, 0.7, -0.2)
    floor = body(plane())
    near = [0.0, 0.0, 0.0]
    smooth = found(body(superquadric(0.3, 0.2, 0.1, 2.0, 2.0), (0, 0, 0.2), turn), floor, near)
    round_ = found(body(ellipsoid(0.3, 0.2, 0.1), (0, 0, 0.2), turn), floor, near)
    assert smooth.point_a == pytest.approx(round_.point_a, abs=1e-13)
    assert smooth.curvature_large == pytest.approx(round_.curvature_large, rel=1e-10)

    boxy = body(superquadric(0.3, 0.2, 0.1, 2.5, 4.0), (0, 0, 0.2), turn)
    contact = found(boxy, floor, near)
    gradient, none = np.empty(3), np.empty((3, 3))
    step = 1e-4
    for curvature, axis in (
        (contact.curvature_small, contact.major_axis),
        (contact.curvature_large, np.cross(contact.normal, contact.major_axis)),
    ):
        rises = []
        for sign in (1.0, -1.0):
            point = contact.point_a + sign * step * axis
            for _ in range(30):  # up or down to the surface
                value = level(boxy.surface, boxy.rotation.T @ (point - boxy.position), gradient, none)
                point = point - value / (boxy.rotation @ gradient)[2] * np.array([0.0, 0.0, 1.0])
            rises.append(point[2] - contact.point_a[2])
        assert 0.5 * sum(rises) / step**2 == pytest.approx(curvature, rel=1e-4)


@pytest.mark.parametrize(
    ("a", "b", "near", "reason"),
    [
        # Both far points of two spheres: normals oppose, yet the distance is greatest.
        (body(sphere(1.0)), body(sphere(1.0), (3, 0, 0)), None, "far side"),
        (body(sphere(1.0), (0, 0, 1.5)), body(plane()), (0, 0, 40.0), "far side"),
        # A ball in the middle of a hollow: the middle semi-axis is a saddle, the longest the greatest distance.
        (body(sphere(0.2)), body(ellipsoid(3, 2, 1, hollow=True)), (0.0, 2.0, 0.0), "saddle"),
        (body(sphere(0.2)), body(ellipsoid(3, 2, 1, hollow=True)), (3.0, 0.0, 0.0), "far side"),
        # A ball in a hollow of its own size or less.
        (body(sphere(0.6)), body(ellipsoid(3, 2, 0.5, hollow=True)), (3.0, 0.0, 0.0), "no contact in an ellipse"),
        # A superquadric on its flat top.
        (body(superquadric(1, 1, 1, 4, 4), (0, 0, 1.1)), body(plane()), (0, 0, 0), "start nearer"),
    ],
)  # fmt: skip
def test_wrong_roots_are_recognised_and_refused(a, b, near, reason):
    if near is None:
        unknowns = np.array([-1.0, 0, 0, 4.0, 0, 0, -1.0, -5.0])
        residual = np.empty(8)
        equations(a, b, unknowns, residual, np.empty((8, 8)))
        assert np.abs(residual).max() < 1e-15  # a root of (1) all the same
    else:
        unknowns = None
    with pytest.raises(SceneError, match=reason) as caught:
        contact_of(a, b, find_opposing(a, b, near) if unknowns is None else unknowns)
    assert "start nearer" in str(caught.value)


def test_the_right_root_beside_the_wrong_ones_is_taken():
    ball, hollow = body(sphere(0.2)), body(ellipsoid(3, 2, 1, hollow=True))
    assert found(ball, hollow, (0.1, 0.1, 1.0)).approach == pytest.approx(-0.8, abs=1e-12)
    assert found(ball, hollow, (0.1, 0.1, -1.0)).approach == pytest.approx(-0.8, abs=1e-12)


def moving(time):
    """An ellipsoid tumbling past a turning torus."""
    spin_a, spin_b = np.array([0.5, -0.3, 0.8]), np.array([0.1, 0.4, -0.2])
    velocity_a, velocity_b = np.array([0.1, 0.05, -0.2]), np.array([0.0, -0.05, 0.0])
    a = body(ellipsoid(0.5, 0.4, 0.3), np.array([1.1, 0.2, 1.2]) + time * velocity_a, turned(*(time * spin_a)),
             velocity_a, spin_a)  # fmt: skip
    return a, body(torus(1.0, 0.4), time * velocity_b, turned(*(time * spin_b)), velocity_b, spin_b)


def followed(steps, project, duration=1.0):
    """The unknowns carried by eqs. (2)-(3) with the classical Runge-Kutta method, with or without projection."""
    unknowns, step = find_opposing(*moving(0.0), (1.1, 0.2, 0.8)), duration / steps
    for k in range(steps):
        now, half, then = (moving(step * (k + share)) for share in (0.0, 0.5, 1.0))
        k1 = opposing_rates(*now, unknowns)
        k2 = opposing_rates(*half, unknowns + 0.5 * step * k1)
        k3 = opposing_rates(*half, unknowns + 0.5 * step * k2)
        k4 = opposing_rates(*then, unknowns + step * k3)
        unknowns = unknowns + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if project:
            unknowns = projected(*then, unknowns)
    return unknowns


def test_differential_form_converges_to_newton_and_projection_keeps_it_there():
    """Eqs. (2)-(3): fourth order of the Runge-Kutta method without projection; to rounding with it."""
    exact = find_opposing(*moving(1.0), followed(20, True)[:3])
    errors = [np.abs(followed(steps, False) - exact).max() for steps in (10, 20, 40)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.5)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.5)
    assert np.abs(followed(10, True) - exact).max() < 1e-3 * errors[0]
    assert np.abs(followed(40, True) - exact).max() < 1e-11


@pytest.mark.parametrize(
    "make",
    [
        lambda: sphere(0.0),
        lambda: ellipsoid(1.0, -1.0, 1.0),
        lambda: torus(0.1, 0.2),
        lambda: superquadric(1, 1, 1, 1.5, 2),
        lambda: find_opposing(body(sphere(1.0)), body(plane()), (0.0, 0.0, 0.0)),
    ],
)
def test_impossible_surfaces_and_starts_are_refused(make):
    with pytest.raises(SceneError):
        make()
