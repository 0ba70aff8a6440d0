"""A cage whose centre moves: guided by the land of a ring or by balls; rest, drag, momentum, energy, refusals."""

import numpy as np
import pytest
from bearings import motion, stored_energy
from ring_systems import CASES, disturbed

from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    CAGE,
    CAGE_X,
    CAGE_Y,
    LAND_WORK,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_VELOCITY,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.rings import land_radius
from bearing_twin.log import cdr
from bearing_twin.log.stream import MessageStream
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

RIG = "bearing_6203_rig_1000N"
GUIDED = [name for name in CASES if "guided" in name]
MASS, WEIGHT = 5e-3, 5e-3 * 9.80665  # of the cage
BY_LAND = ("cage.kind=pockets", "gravity=[0,-9.80665,0]")
# Balls that thrust holds, in the middle of pockets that they do not reach.
APART = ("cage.pocket_clearance=3e-3", "rings.inner.load=[0,0,800]")


def advanced(moving, period, count):
    times = period * np.arange(1, count + 1)
    return moving.advance(times, times[-1])


def rig(*overrides):
    return motion(*BY_LAND, *overrides, scene=RIG)


def test_a_cage_falls_onto_its_land_and_sags_by_its_weight_over_the_stiffness():
    moving = rig("cage.guidance=outer", *APART, "drive.speed=0", "cage.friction=0", "cage.stiffness=1e5")
    moving.border[CAGE_Y] = 0.0  # it starts at rest in its land
    out = advanced(moving, 1e-3, 300)
    fallen = out.cage_offset[3, 1]
    assert fallen == pytest.approx(-0.5 * 9.80665 * 4e-3**2, rel=1e-6)
    assert out.cage_offset[-1] == pytest.approx([0.0, -(1e-4 + WEIGHT / 1e5)], abs=1e-9)
    assert out.land_force[-1] == pytest.approx([0.0, WEIGHT], abs=1e-4 * WEIGHT)


def test_a_run_starts_with_the_cage_at_rest_in_its_land():
    """On the inner ring's land, which the load has displaced."""
    moving = rig("cage.guidance=inner", *APART, "drive.speed=0")
    first = moving.first_outputs()
    sag = first.inner_ring_offset[0, :2] - [0.0, 1e-4 + WEIGHT / 1e6]
    assert first.cage_offset[0] == pytest.approx(sag, abs=1e-15)
    assert first.land_force[0] == pytest.approx([0.0, WEIGHT], rel=1e-9)


@pytest.mark.parametrize(("guidance", "side"), [("inner", 1.0), ("outer", -1.0)])
def test_sliding_on_its_land_turns_or_brakes_a_cage_by_coulomb_friction(guidance, side):
    """Torque mu m g times lever on the cage, mu m g R back on the ring; times its turn the work of the drive."""
    still = ("initial.motion=rest", "contact.friction_coefficient=0", f"drive.speed={157.0796 if side > 0 else 0}")
    heavy = "cage.mass=0.5", "cage.inertia=1e-4"  # so that little else shakes it in its land
    moving = rig(f"cage.guidance={guidance}", *APART, *still, *heavy)
    moving.border[PLACES + CAGE] = 0.0 if side > 0 else 50.0
    first, out = moving.first_outputs(), advanced(moving, 1e-4, 10)
    radius, friction = land_radius(moving.parameters), 0.05
    assert radius == pytest.approx(0.5 * 28.55e-3 - side * 0.3 * 6.75e-3)
    torque = friction * 100.0 * WEIGHT * radius
    lever = radius + side * (1e-4 + 100.0 * WEIGHT / 1e6)  # to where they touch, from the cage's centre
    gained = moving.border[PLACES + CAGE] - (0.0 if side > 0 else 50.0)
    assert gained == pytest.approx(side * torque * lever / radius / 1e-4 * 1e-3, rel=2e-3)
    ring = first.inner_ring_torque[0, 2] if side > 0 else first.outer_ring_torque[0, 2]
    assert ring == pytest.approx(-side * torque, rel=1e-4)
    if side > 0:
        assert moving.border[LAND_WORK] == pytest.approx(torque * 157.0796 * 1e-3, rel=2e-3)
        turning = out.drive_work[-1] - out.inner_ring_load_work[-1]
        assert turning == pytest.approx(moving.border[LAND_WORK], rel=1e-9)
    else:
        assert moving.border[LAND_WORK] == 0.0


@pytest.mark.parametrize("name", GUIDED)
def test_what_balls_lose_of_momentum_the_cage_gains(name):
    """Linear in the plane, angular about the axis: rates with the walls less those without."""
    system = disturbed(name)
    bearing, state, border = system.bearing, system.state, system.border
    balls, own = system.rates(state, border)
    walls = bearing.pockets.walls._replace(stiffness=0.0)
    system.bearing = bearing._replace(pockets=bearing.pockets._replace(walls=walls))
    without, alone = system.rates(state, border)
    rates, changes = balls - without, (own - alone)[PLACES : 2 * PLACES] * system.partners.mass
    cosine, sine = np.cos(state[:, ORBIT_ANGLE]), np.sin(state[:, ORBIT_ANGLE])
    radial, along = bearing.ball_mass * rates[:, RADIAL_VELOCITY], bearing.ball_mass * rates[:, TANGENTIAL_VELOCITY]
    force = np.array([cosine * radial - sine * along, sine * radial + cosine * along])
    assert np.abs(along).max() > 0.1  # N: walls push
    assert changes[CAGE_X:CAGE] == pytest.approx(-force.sum(axis=1), abs=1e-10 * np.abs(force).sum())
    spun = bearing.ball_inertia * rates[:, AXIAL_SPIN] + state[:, AXIS_DISTANCE] * along
    about = changes[CAGE] + border[CAGE_X] * changes[CAGE_Y] - border[CAGE_Y] * changes[CAGE_X]
    assert about == pytest.approx(-spun.sum(), abs=1e-10 * np.abs(spun).sum())
    assert changes[:CAGE_X] == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("name", [name for name in GUIDED if "land" in name])
def test_what_the_land_takes_from_the_cage_its_ring_gets(name):
    """Forces on cage and ring cancel, so do torques about the axis; the outer ring is at rest."""
    system = disturbed(name)
    _, own = system.rates(system.state, system.border)
    land = system.partners.land
    system.partners = system.partners._replace(land=land._replace(stiffness=0.0))
    _, without = system.rates(system.state, system.border)
    changes = (own - without)[PLACES : 2 * PLACES] * system.partners.mass
    assert np.abs(changes[CAGE_X:CAGE]).max() > 0.1
    expected = -changes[CAGE_X:CAGE] if land.side < 0.0 else np.zeros(2)
    assert changes[:2] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("guidance", ["inner", "outer", "balls"])
def test_energy_closes_and_forces_balance(guidance):
    """With all works and losses, after an unbalanced start: the cage falls, is hit by balls and whirls."""
    moving = rig(f"cage.guidance={guidance}", "wanted.tolerance=1e-6")
    moving.border[[PLACES + CAGE_X, PLACES + CAGE_Y]] = 0.02, 0.03
    out = advanced(moving, 2e-4, 250)
    stored = stored_energy(out)
    made = (stored + out.dissipated - out.drive_work)[[0, -1]]
    assert abs(made[1] - made[0]) <= 1e-5 * (out.gross_work[-1] - out.gross_work[0])
    rest = out.raceway_force.sum(axis=1) + out.inner_ring_force + out.outer_ring_force
    rest[:, :2] += out.land_force
    assert np.abs(rest).max() < 1e-9
    if guidance == "balls":
        assert not out.land_force.any()
        return
    assert np.abs(out.land_force).max() > WEIGHT
    middle = out.cage_offset - (out.inner_ring_offset[:, :2] if guidance == "inner" else 0.0)
    assert np.hypot(*middle.T).max() < 1e-4 + 2e-6


def test_balls_alone_carry_a_cage():
    """Under thrust, which holds all balls, the cage hangs by half the clearance of the pockets beside it."""
    moving = rig("cage.guidance=balls", "cage.pocket_clearance=1e-4", "rings.inner.load=[0,0,800]")
    out = advanced(moving, 1e-3, 100)
    assert out.cage_offset[20:, 1].mean() == pytest.approx(-0.5e-4, rel=0.2)


@pytest.mark.parametrize("guidance", ["inner", "outer", "balls"])
def test_wrenches_on_balls_and_rings_add_up_to_what_the_cage_does_to_its_land(guidance):
    """As the messages tell it; contacts alone cancel, and those on the other ring are its wrench."""
    overrides = ("cage.kind=pockets", f"cage.guidance={guidance}", "run.publish_rate=1e3", "run.output_rate=1e3")
    scene = load_scene("bearing_6203_guided_cage", overrides)
    block = Simulation(scene).advance(20)
    told = {}
    for topic, _, data in MessageStream(scene).messages(block):
        if topic.ros_type in (cdr.WRENCH, cdr.CONTACTS, cdr.JOINT_STATE):
            told.setdefault(topic.name, []).append(cdr.deserialise(topic.ros_type, data))
    forces = {
        name: np.array([[one.wrench.force.x, one.wrench.force.y, one.wrench.force.z] for one in found])
        for name, found in told.items()
        if name.endswith("/wrench")
    }
    land = np.array([[*one.effort[1:], 0.0] for one in told["cage/state"]])
    assert sum(forces.values()) == pytest.approx(-land, abs=1e-10)
    assert (np.abs(land).max() > 0.0) == (guidance != "balls")
    outer = np.array([
        (np.array(one.normal_load)[1:16:2, None] * np.reshape(one.normal, (-1, 3))[1:16:2]
         + np.reshape(one.friction_force, (-1, 3))[1:16:2]).sum(axis=0)
        for one in told["contacts"]
    ])  # fmt: skip
    missing = -land if guidance == "outer" else 0.0 * land
    assert forces["outer_ring/wrench"] + outer == pytest.approx(missing, abs=1e-10)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("cage.kind=even", "cage.guidance=outer"), "set cage.kind: pockets"),
        (("cage.guidance=outer", "rings.inner.free=all"), "not built for a ring that tilts"),
        (("cage.guidance=outer", "cage.mass=0", "cage.inertia=1e-6"), "give cage.mass above 0 kg"),
        (("cage.guidance=inner", "cage.land_radius=15e-3"), "inside the pitch circle"),
        (("cage.guidance=outer", "cage.land_radius=14e-3"), "outside the pitch circle"),
        (("cage.guidance=outer", "cage.land_clearance=0"), "cage.land_clearance"),
        (("cage.guidance=lands",), "cage.guidance"),
    ],
)
def test_guidance_that_cannot_be_is_refused(overrides, words):
    with pytest.raises(SceneError, match=words):
        load_scene(RIG, ("cage.kind=pockets", *overrides))


def test_guidance_asks_for_a_ring_with_mass():
    with pytest.raises(SceneError, match="ring with mass"):
        load_scene("bearing_6203", ("cage.kind=pockets", "cage.guidance=outer"))
