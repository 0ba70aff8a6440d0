"""Where bodies touch: closed forms, implicit surfaces and their opposing points, overlap of bodies."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from surfaces import SURFACES, level, opposing_error, opposing_rates, overlap_of, projected, tangent_axes

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.shapes import (
    ball_in_groove,
    body,
    contact_of,
    ellipsoid,
    ellipsoid_on_plane,
    find_opposing,
    plane,
    quaternion_from_vector,
    rotation_matrix,
    sphere,
    superquadric,
    support,
    torus,
)

BALL, GROOVE = 3.373e-3, 0.52 * 6.746e-3


AXES = (0.03, 0.02, 0.012)
TURNS = [(0.0, 0.0, 0.0), (0.4, -0.3, 0.2), (1.2, 0.7, -2.0), (0.0, 1.5, 0.1), (2.0, 0.1, 0.3)]


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("axes", [AXES, (0.02, 0.02, 0.02), (0.02, 0.02, 0.01), (0.01, 0.02, 0.02)])
def test_the_ellipsoids_lowest_point_is_what_the_opposing_points_of_two_surfaces_say(axes, turn):
    rotation = rotation_matrix(quaternion_from_vector(turn))
    low = ellipsoid_on_plane(axes, -rotation[2])
    height = low.reach - 1e-5
    ellipsoid_body, floor_body = body(ellipsoid(*axes), (0.0, 0.0, height), rotation), body(plane())
    opposed = rotation @ low.point
    opposed_contact = contact_of(
        ellipsoid_body, floor_body, find_opposing(ellipsoid_body, floor_body, (*opposed[:2], 0.0))
    )
    assert opposed_contact.approach == pytest.approx(1e-5, rel=1e-9)
    assert opposed_contact.point_a - [0.0, 0.0, height] == pytest.approx(opposed, abs=1e-14)
    assert low.curvature_small == pytest.approx(opposed_contact.curvature_small, rel=1e-10)
    assert low.curvature_large == pytest.approx(opposed_contact.curvature_large, rel=1e-10)
    mean = 0.5 * (low.curvature_small + low.curvature_large)
    shape = mean / math.sqrt(low.curvature_small * low.curvature_large)
    assert low.excess == pytest.approx(math.sqrt(max(shape**2 - 1.0, 0.0)), rel=1e-9, abs=1e-7)
    if not opposed_contact.circular:
        assert abs(opposed_contact.major_axis @ (rotation @ low.major_axis)) == pytest.approx(1.0, rel=1e-12)


EXAMPLES = {
    "plane": plane(),
    "sphere": sphere(0.7),
    "ellipsoid": ellipsoid(1.0, 0.8, 0.5, hollow=True),
    "torus": torus(1.0, 0.4),
    "superquadric": superquadric(1.0, 0.8, 0.6, 2.5, 4.0),
}
POINT = np.array([0.53, -0.41, 0.37])


def opposed_contact(a, b, near):
    return contact_of(a, b, find_opposing(a, b, near))


def turned(*vector):
    return Rotation.from_rotvec(vector).as_matrix()


@pytest.mark.parametrize("name", sorted(SURFACES))
def test_gradient_and_hesse_matrix_are_the_derivatives(name):
    surface, step = EXAMPLES[name], 1e-6
    centre = level(surface, POINT)
    for axis, shift in enumerate(step * np.eye(3)):
        ahead, behind = level(surface, POINT + shift), level(surface, POINT - shift)
        assert (ahead.value - behind.value) / (2 * step) == pytest.approx(centre.gradient[axis], abs=1e-8)
        assert (ahead.gradient - behind.gradient) / (2 * step) == pytest.approx(centre.hesse[axis], abs=1e-8)


@pytest.mark.parametrize(("locus", "axis_distance", "side"), [(14.1e-3, 14.25e-3, 1), (14.4e-3, 14.25e-3, -1)])
@pytest.mark.parametrize("height", [0.0, 2e-5, -4e-5])
@pytest.mark.parametrize("orbit", [0.0, 2.0])
def test_ball_in_torus_groove_agrees_with_the_closed_form(locus, axis_distance, side, height, orbit):
    """Paper 1, section 5: the raceway is a hollow torus. All to 1e-10, wherever the ball is."""
    frame = turned(0.3, -0.8, 0.4)  # the whole bearing turned in space
    centre = np.array([axis_distance * math.cos(orbit), axis_distance * math.sin(orbit), height])
    outward = np.array([math.cos(orbit), math.sin(orbit), 0.0])
    ball, ring = body(sphere(BALL), frame @ centre), body(torus(locus, GROOVE, hollow=True), rotation=frame)
    contact = opposed_contact(ball, ring, frame @ (centre + side * BALL * outward))
    closed = ball_in_groove(axis_distance, height, BALL, locus, GROOVE)
    normal = closed.normal_radial * outward + [0.0, 0.0, closed.normal_axial]
    along = -closed.normal_axial * outward + [0.0, 0.0, closed.normal_radial]
    assert contact.approach == pytest.approx(closed.approach, rel=1e-10)
    assert contact.normal == pytest.approx(frame @ normal, abs=1e-10)
    assert contact.curvature_small == pytest.approx(closed.curvature_small, rel=1e-10)
    assert contact.curvature_large == pytest.approx(closed.curvature_large, rel=1e-10)
    assert abs(contact.major_axis @ frame @ along) == pytest.approx(1.0, rel=1e-10)


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
        assert opposing_error(a, b, unknowns) < 1e-15  # a root of (1) all the same
    else:
        unknowns = None
    with pytest.raises(SceneError, match=reason) as caught:
        contact_of(a, b, find_opposing(a, b, near) if unknowns is None else unknowns)
    assert "start nearer" in str(caught.value)


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
        lambda: sphere(np.nan),
        lambda: ellipsoid(1.0, -1.0, 1.0),
        lambda: torus(0.1, 0.2),
        lambda: superquadric(1.0, 1.0, 1.0, 1.5, 2.0),
        lambda: find_opposing(body(sphere(1.0)), body(plane()), (0.0, 0.0, 0.0)),
    ],
)
def test_impossible_surfaces_and_starts_are_refused(make):
    with pytest.raises(SceneError):
        make()


MODULUS = 1.14e11
LOCUS, TUBE, BALL_IN_GROOVE = 14.1e-3, 3.508e-3, 3.373e-3
PAIRS = {
    "sphere on plane": lambda h: (body(sphere(0.01), (0, 0, 0.01 - h)), body(plane()), (0, 0, 0)),
    "narrow ellipsoid": lambda h: (body(ellipsoid(0.03, 0.003, 0.01), (0, 0, 0.01 - h)), body(plane()), (0, 0, 0)),
    "ball in groove": lambda h: (
        body(sphere(BALL_IN_GROOVE), (LOCUS + TUBE - BALL_IN_GROOVE + h, 0, 0)), body(torus(LOCUS, TUBE, hollow=True)),
        (LOCUS + TUBE, 0, 0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PAIRS)
def test_rays_over_an_ellipse_give_equation_9_as_the_approach_goes_to_zero(name):
    """What is left is of the bodies' size: it falls with h, down to 1e-7."""
    errors = []
    for approach in (1e-7, 1e-8, 1e-9):
        a, b, near = PAIRS[name](approach)
        opposed = contact_of(a, b, find_opposing(a, b, near))
        axes = np.array([opposed.major_axis, np.cross(opposed.normal, opposed.major_axis)])
        opposed_contact = overlap_of(
            a,
            b,
            0.5 * (opposed.point_a + opposed.point_b),
            axes,
            opposed.normal,
            opposed.approach,
            BALL_IN_GROOVE,
            MODULUS,
        )
        law = (
            coefficient_of("volumetric", opposed.curvature_small, opposed.curvature_large, MODULUS)
            * opposed.approach**1.5
        )
        errors.append(abs(opposed_contact.load / law - 1.0))
        assert math.hypot(opposed_contact.centre_x, opposed_contact.centre_y) < 1e-6 * opposed_contact.half_width_x
    assert errors[0] < 1e-4
    assert errors[2] < 5e-7
    assert errors[1] < 0.2 * errors[0] + 1e-7


def rounded_box(approach, turn=(0.0, 0.0, 0.0)):
    """A superellipsoid pressed into the plane z = 0, its contact as `overlap_of` takes it."""
    surface, rotation = superquadric(0.02, 0.01, 0.01, 4.0, 4.0), Rotation.from_rotvec(turn).as_matrix()
    low = rotation @ support(surface, rotation.T @ np.array([0.0, 0.0, -1.0]))
    a, b = body(surface, (-low[0], -low[1], -low[2] - approach), rotation), body(plane())
    normal = np.array([0.0, 0.0, -1.0])
    return a, b, np.array([0.0, 0.0, -0.5 * approach]), tangent_axes(normal), normal, approach


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.1, 0.2, 0.05), (0.5, -0.4, 0.3)])
def test_the_load_over_rays_is_the_derivative_of_their_energy(turn):
    approach, step = 1e-5, 1e-3
    before, centre, after = (
        overlap_of(*rounded_box(approach * (1.0 + share), turn), 0.01, MODULUS) for share in (-step, 0.0, step)
    )
    assert centre.load == pytest.approx((after.energy - before.energy) / (2.0 * step * approach), rel=1e-5)


@pytest.mark.parametrize("turn", [(0.1, 0.2, 0.05), (0.5, -0.4, 0.3)])
def test_the_load_of_an_overlap_acts_where_its_moment_is_the_derivative_of_the_energy_by_a_tilt(turn):
    a, *rest = rounded_box(1e-5, turn)
    (axes, normal), step = rest[2:4], 1e-6
    contact = overlap_of(a, *rest, 0.01, MODULUS)
    point = contact.centre_x * axes[0] + contact.centre_y * axes[1]
    for axis in axes:
        tilts = (Rotation.from_rotvec(angle * axis).as_matrix() for angle in (-step, step))
        tilted = (body(a.surface, tilt @ a.position, tilt @ a.rotation) for tilt in tilts)
        before, after = (overlap_of(each, *rest, 0.01, MODULUS).energy for each in tilted)
        moment = contact.load * np.cross(axis, point) @ normal
        assert (after - before) / (2.0 * step) == pytest.approx(moment, rel=1e-4)
