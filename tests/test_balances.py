"""Balances of a bearing read off its channels alone: power of each mechanism, momentum, wrenches, ellipses, means."""

import math

import numpy as np
import pytest
from bearings import TURNED_REST, motion
from made_up_run import a_choice
from scipy.integrate import simpson

from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.materials import MATERIALS, effective_modulus
from bearing_twin.kinds.bearing.forces.layout import VELOCITY
from bearing_twin.log import cdr
from bearing_twin.log.stream import MessageStream
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.shapes.implicit import sphere, torus
from bearing_twin.shapes.tracking import body, contact_of, find_opposing

PERIOD, COUNT = 4e-7, 401
TIMES = PERIOD * np.arange(1, COUNT + 1)
STEEL = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
SPOT = "contact.friction=spot"
# Slip dies in microseconds, not in fractions of one, so that sums over the instants are integrals.
SMOOTH = ("drive.acceleration=1e5", "contact.friction_regularisation=0.3", "wanted.tolerance=1e-6")
# Thirteen balls that fill the circle, pressed outwards and inwards until each touches both neighbours.
FULL = (
    "geometry.balls=13", f"geometry.pitch_diameter={6.746e-3 / math.sin(math.pi / 13) * (1.0 + 1e-9)!r}",
    "geometry.radial_clearance=-40e-6", "initial.motion=rest",
)  # fmt: skip


def ringing(*overrides):
    """Dense outputs of a start under radial and axial offset, the ring speeding up, with the bearing's numbers."""
    moving = motion(*TURNED_REST, *SMOOTH, *overrides)
    moving.goal_speed = 300.0
    moving.state[:, VELOCITY] += 0.05 * np.cos(2.4 * np.arange(len(moving.state)))  # so that the contacts ring
    return moving.bearing, moving.advance(TIMES, float(TIMES[-1]))


@pytest.fixture(scope="module", params=["point", "spot"])
def started(request):
    """Eight balls: with friction at a point from rest, sliding; with spots rolling under thrust, drilling."""
    drilling = ("initial.motion=rolling", "drive.offset=[0.0, -1.0e-6, 4.0e-5]", SPOT)
    return ringing(*(drilling if request.param == "spot" else ()))


@pytest.fixture(scope="module")
def full():
    """Thirteen touching balls with friction over the spots, from rest."""
    return ringing(SPOT, *FULL)


def integral(power):
    """The integral over all instants of an array (instants, ...)."""
    return simpson(power, dx=PERIOD, axis=0)


def test_what_friction_and_damping_take_is_what_the_books_say(started):
    """Friction force on slip, drilling torque on spin, and the viscous part of the load on the rate of approach."""
    _, out = started
    sliding = -np.einsum("skrv,skrv->s", out.friction_force, out.slip)
    drilling = -np.einsum("skr,skr->s", out.drilling_torque, out.spin_rate)
    coefficient = np.vectorize(hertz_coefficient)(out.curvature_small, out.curvature_large, STEEL)
    elastic = coefficient * np.maximum(out.approach, 0.0) ** 1.5
    rate = np.gradient(out.approach, PERIOD, axis=0, edge_order=2)
    viscous = ((out.normal_load - elastic) * rate).sum(axis=(1, 2))
    assert np.all(sliding >= 0.0)
    parts = [integral(power) for power in (sliding, drilling, viscous)]
    booked = out.dissipated[-1] - out.dissipated[0]
    assert sum(parts) == pytest.approx(booked, rel=1e-3)
    spots = bool(np.any(out.drilling_torque))
    assert parts[0] > 0.02 * booked
    assert parts[1] > 0.02 * booked if spots else parts[1] == 0.0
    assert parts[2] > 5e-4 * booked


def test_the_drive_works_by_the_rings_torque_at_its_speed(started):
    _, out = started
    assert np.ptp(out.inner_ring_speed) > 10.0
    power = -out.inner_ring_torque[:, 2] * out.inner_ring_speed
    assert integral(power) == pytest.approx(out.drive_work[-1] - out.drive_work[0], rel=2e-5)


def test_stored_energies_are_those_of_speeds_heights_and_approaches(started):
    bearing, out = started
    kinetic = 0.5 * bearing.ball_mass * (out.velocity**2).sum(axis=(1, 2))
    kinetic += 0.2 * bearing.ball_mass * bearing.ball_radius**2 * (out.angular_velocity**2).sum(axis=(1, 2))
    assert out.kinetic_energy == pytest.approx(kinetic, rel=1e-12)
    potential = -bearing.ball_mass * np.einsum("skv,v->s", out.position, bearing.gravity)
    assert out.potential_energy == pytest.approx(potential, rel=1e-9, abs=1e-15)
    coefficient = np.vectorize(hertz_coefficient)(out.curvature_small, out.curvature_large, STEEL)
    elastic = (0.4 * coefficient * np.maximum(out.approach, 0.0) ** 2.5).sum(axis=(1, 2))
    assert out.elastic_energy == pytest.approx(elastic, rel=1e-8)


def test_a_ball_moves_and_turns_as_its_wrench_says(started):
    """Newton and Euler for every ball, integrated: the published wrench is all that acts besides the weight."""
    bearing, out = started
    force = out.raceway_force + bearing.ball_mass * np.array(bearing.gravity)
    change = bearing.ball_mass * (out.velocity[-1] - out.velocity[0])
    assert integral(force) == pytest.approx(change, abs=1e-4 * np.abs(change).max())
    turning = bearing.ball_inertia * (out.angular_velocity[-1] - out.angular_velocity[0])
    assert integral(out.raceway_torque) == pytest.approx(turning, abs=1e-4 * np.abs(turning).max())


def test_a_wrench_is_the_sum_of_its_contacts(started):
    _, out = started
    force = out.normal_load[..., None] * out.normal + out.friction_force
    assert force.sum(axis=2) == pytest.approx(out.raceway_force, abs=1e-12 * np.abs(out.raceway_force).max())
    arm = out.point - out.position[:, :, None]
    torque = np.cross(arm, force) - out.drilling_torque[..., None] * out.normal
    assert torque.sum(axis=2) == pytest.approx(out.raceway_torque, abs=1e-9 * np.abs(out.raceway_torque).max())


def about_the_centre(out):
    """Forces and torques about the bearing's centre by the raceways on all balls, and by all balls on the rings."""
    torque = out.raceway_torque + np.cross(out.position, out.raceway_force)
    ring = np.cross(out.inner_ring_offset, out.inner_ring_force) + out.inner_ring_torque + out.outer_ring_torque
    return out.raceway_force.sum(axis=1), torque.sum(axis=1), out.inner_ring_force + out.outer_ring_force, ring


def test_rings_answer_thirteen_touching_balls_with_spots(full):
    _, out = full
    drilling = -out.drilling_torque[..., None] * out.normal
    assert np.abs(drilling).max() > 1e-6
    force, torque, ring_force, ring_torque = about_the_centre(out)
    assert force + ring_force == pytest.approx(0.0, abs=1e-11 * np.abs(out.raceway_force).max())
    assert torque + ring_torque == pytest.approx(0.0, abs=1e-9 * np.abs(drilling).max())


def test_what_touching_balls_do_to_each_other_cancels(full):
    """The raceways' wrenches and the weights alone change the sums of momentum and of moment of momentum."""
    bearing, out = full
    gaps = np.linalg.norm(out.position - np.roll(out.position, 1, axis=1), axis=-1) - 2.0 * bearing.ball_radius
    assert gaps.min() < -1e-8
    weight = bearing.ball_mass * np.array(bearing.gravity)
    force, torque, _, _ = about_the_centre(out)
    momentum = bearing.ball_mass * out.velocity.sum(axis=1)
    moment = (bearing.ball_mass * np.cross(out.position, out.velocity)).sum(axis=1)
    moment += bearing.ball_inertia * out.angular_velocity.sum(axis=1)
    size = bearing.ball_mass * np.abs(out.velocity).sum(axis=1).max()
    assert integral(force + 13.0 * weight) == pytest.approx(momentum[-1] - momentum[0], abs=1e-4 * size)
    torque = torque + np.cross(out.position, weight).sum(axis=1)
    size = np.abs(moment).max()
    assert integral(torque) == pytest.approx(moment[-1] - moment[0], abs=1e-4 * size)


def test_a_ball_between_others_moves_and_turns_as_all_its_contacts_say(full):
    """Newton and Euler for each of thirteen balls: raceways, the ball ahead, and the reaction to the one behind."""
    bearing, out = full
    ahead = out.neighbour_load[..., None] * out.neighbour_normal + out.neighbour_friction
    assert np.abs(integral(ahead)).max() > 1e-3 * bearing.ball_mass * np.abs(out.velocity).max()
    after = np.roll(out.position, -1, axis=1)
    turning = np.cross(out.neighbour_point - out.position, ahead)
    behind = np.cross(out.neighbour_point - after, -ahead)
    weight = bearing.ball_mass * np.array(bearing.gravity)
    force = out.raceway_force + weight + ahead - np.roll(ahead, 1, axis=1)
    change = bearing.ball_mass * (out.velocity[-1] - out.velocity[0])
    assert integral(force) == pytest.approx(change, abs=1e-3 * np.abs(change).max())
    torque = out.raceway_torque + turning + np.roll(behind, 1, axis=1)
    change = bearing.ball_inertia * (out.angular_velocity[-1] - out.angular_velocity[0])
    assert integral(torque) == pytest.approx(change, abs=1e-3 * np.abs(change).max())


@pytest.fixture(scope="module")
def thrust():
    """A scene whose contacts are inclined, and one block of its run."""
    scene = load_scene("bearing_6203", ["drive.offset=[3.0e-6, -2.0e-6, 4.0e-5]"])
    return scene, Simulation(scene).advance(3)


def long_axes(scene, sample):
    """What two implicit surfaces, a ball and a ring's groove, say of their contact: unit vectors (balls, 2, 3)."""
    geometry, axes = scene.parameters.geometry, np.zeros((scene.parameters.geometry.balls, 2, 3))
    radius = 0.5 * geometry.ball_diameter
    rings = (
        (-1.0, geometry.inner_conformity, sample["inner_ring_offset"]), (1.0, geometry.outer_conformity, np.zeros(3))
    )  # fmt: skip
    for side, conformity, centre in rings:
        groove = conformity * geometry.ball_diameter
        bottom = 0.5 * geometry.pitch_diameter + side * (radius + 0.25 * geometry.radial_clearance)
        ring = body(torus(bottom - side * groove, groove, hollow=True), centre)
        which = 0 if side < 0.0 else 1
        for k, position in enumerate(sample["position"]):
            ball = body(sphere(radius), position)
            found = contact_of(ball, ring, find_opposing(ball, ring, sample["point"][k, which]))
            assert found.approach == pytest.approx(sample["approach"][k, which], abs=1e-12)
            assert found.curvature_small < 0.3 * found.curvature_large
            axes[k, which] = found.major_axis
    return axes


def first_message(scene, block, ros_type):
    """The first message of one type in a block."""
    pairs = MessageStream(scene, choice=a_choice()).messages(block)
    return next(cdr.deserialise(topic.ros_type, data) for topic, _, data in pairs if topic.ros_type == ros_type)


def test_the_long_axis_of_an_ellipse_lies_across_the_groove_in_message_and_marker(thrust):
    scene, block = thrust
    sample, first = block[0], long_axes(scene, block[0])
    assert np.all(np.abs(sample["contact_angle"]) > 0.03)
    assert np.abs(first[..., 2]).min() > 0.9  # nearly along the bearing's axis
    contacts = first_message(scene, block, cdr.CONTACTS)
    rows = first[..., 0].size  # ball after ball, inner before outer; behind them balls with their neighbours
    told = contacts.major_axis.reshape(-1, 3)[:rows].reshape(first.shape)
    assert np.abs(np.einsum("krv,krv->kr", told, first)) == pytest.approx(1.0, abs=1e-6)
    semi_major, semi_minor = (axis[:rows].reshape(-1, 2) for axis in (contacts.semi_major, contacts.semi_minor))
    assert np.all(semi_major > 5.0 * semi_minor)
    [outline] = [m for m in first_message(scene, block, cdr.MARKERS).markers if m.ns == "contact_ellipses"]
    corners = np.array([[p.x, p.y, p.z] for p in outline.points]).reshape(len(first), 2, -1, 3)
    from_centre = corners - sample["point"][:, :, None]
    length = np.linalg.norm(from_centre, axis=-1)
    far = np.take_along_axis(from_centre, length.argmax(axis=2)[..., None, None], axis=2)[:, :, 0]
    longest = length.max(axis=2)
    assert np.abs(np.einsum("krv,krv->kr", far, first)) == pytest.approx(longest, rel=1e-6)
    assert longest == pytest.approx(10.0 * semi_major, rel=1e-9)
    assert length.min(axis=2) == pytest.approx(10.0 * semi_minor, rel=1e-9)
    assert np.abs(np.einsum("krnv,krv->krn", from_centre, sample["normal"])).max() < 1e-9 * longest.max()
