"""The laws of contact inside a bearing, and how its balls start."""

import math

import numpy as np
import pytest
from bearings import TURNED_REST, asking, motion, run, stored_energy

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.names import law_names
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.forces.equations import single_contact, static_force
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE, SPIN, TANGENTIAL_VELOCITY
from bearing_twin.kinds.bearing.parameters import GIVES
from bearing_twin.kinds.bearing.start import bearing_of, start_state
from bearing_twin.numerics.rotation import about_z
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

CLOSE = (  # b/a below 0.01
    "geometry.inner_conformity=0.5003",
    "geometry.outer_conformity=0.5003",
    "geometry.radial_clearance=-1e-7",
    "drive.offset=[0.0, 0.0, 0.0]",
)


def test_linear_springs_carry_what_statics_says():
    """Slow turning, no gravity: each ball is two springs in series, k/2 times the local interference."""
    offset = 2e-6
    overrides = ("gravity=[0.0, 0.0, 0.0]", "drive.speed=1.0", f"drive.offset=[{offset}, 0.0, 0.0]", "geometry.balls=7")
    _, out = run(*overrides, *asking("linear"), law="linear", count=4, period=5e-3)
    for ball, angle in enumerate(out.orbit_angle[-1]):
        expected = 1e7 * (3e-6 + offset * math.cos(angle))  # minus a quarter of the clearance at either race
        assert out.normal_load[-1, ball, 0] == pytest.approx(expected, rel=2e-3)
    assert out.normal_load[-1, 0, 0] == pytest.approx(2e7 * out.approach[-1, 0, 0], rel=1e-4)


@pytest.mark.parametrize("law", law_names("point", GIVES))
def test_energy_closes_by_every_law(law):
    moving = motion("initial.motion=rest", "drive.offset=[0.0, -9.0e-6, 1.0e-5]", *asking(law), law=law)
    before = stored_energy(moving.first_outputs())[0]
    out = moving.advance(np.arange(1, 31) * 2e-4, 6e-3)
    residual = out.drive_work[-1] - (stored_energy(out)[-1] - before) - out.dissipated[-1]
    # What the curvatures do to the coefficient is left out of the energy: 1e-4 of it.
    assert out.drive_work[-1] > 1e-4
    assert abs(residual) < 2e-4 * out.drive_work[-1]


@pytest.mark.parametrize("stepper", ["rk4", "imex", "dopri5", "rodas3"])
def test_every_kind_of_stepper_takes_a_linear_spring(stepper):
    overrides = (*TURNED_REST, *asking("linear"))
    found, expected = (run(*overrides, law="linear", stepper=name, count=3)[1] for name in (stepper, "rodas4"))
    for name in ("normal_load", "raceway_torque"):
        exact = getattr(expected, name)
        assert np.abs(getattr(found, name) - exact).max() < 1e-3 * np.abs(exact).max()


def test_the_law_reported_is_the_law_used():
    """Also where an ellipse is too narrow for the rational form of `hertz`, which is solved exactly there."""
    for asked in ("auto", "hertz", "hertz_exact"):
        scene = load_scene("bearing_6203", [*CLOSE, "run.duration=1e-3", f"contact.normal={asked}"])
        simulation = Simulation(scene)
        simulation.advance(2)
        assert choose(scene).law == simulation.report().law == asked.replace("auto", "hertz")
        assert choose(scene).warnings == ()
    rational, exact = (run(*CLOSE, law=law, count=3)[1].normal_load for law in ("hertz", "hertz_exact"))
    assert rational == pytest.approx(exact, rel=1e-7)


def test_a_number_for_no_law_and_a_law_without_its_number_are_refused():
    for overrides, sentence in (
        (["contact.normal=linear"], "needs contact.stiffness in N/m"),
        (["contact.stiffness=1e7"], "needs contact.normal: linear"),
        (["contact.stiffness=1e7", "contact.normal=hertz"], "needs contact.normal: linear"),
    ):
        with pytest.raises(SceneError, match=sentence):
            load_scene("bearing_6203", overrides)
    for law, row in LAWS.items():
        if row.fits == "line" or "alpha" in row.needs:
            with pytest.raises(SceneError):
                load_scene("bearing_6203", [f"contact.normal={law}"])


def test_a_rough_friction_model_is_warned_of():
    rough = {name for name in FRICTIONS if choose(load_scene("bearing_6203", [f"contact.friction={name}"])).warnings}
    assert rough == {name for name, row in FRICTIONS.items() if row.error > FRICTIONS["spot"].error}
    assert rough >= {"pade1", "pade2"}


def start_of(name, *overrides):
    scene = load_scene(name, overrides)
    bearing = bearing_of(scene.parameters, choose(scene).law)
    return bearing, scene.parameters.drive.speed, start_state(bearing, scene.parameters.drive.speed, "rolling")


@pytest.mark.parametrize("name", ["bearing_6203", "bearing_6203_loose", "bearing_6203_fast"])
@pytest.mark.parametrize("offset", ["[0,0,0]", "[0,0,6e-5]", "[1e-6,-2e-6,-5e-6]", "[0,-1e-5,4e-5]"])
def test_nothing_pushes_a_ball_at_the_start_and_it_rolls(name, offset):
    """Also on one raceway alone, and held by its orbit alone; slip against what the ring's surface runs at."""
    bearing, speed, state = start_of(name, f"drive.offset={offset}")
    for ball in state:
        distance, angle, height = ball[AXIS_DISTANCE], ball[ORBIT_ANGLE], ball[HEIGHT]
        rate = ball[TANGENTIAL_VELOCITY] / distance
        centrifugal = bearing.ball_mass * distance * rate**2
        force = np.hypot(*static_force(bearing, rate, distance, angle, height))
        # Iterating orbit and rest three times leaves this much of the change of the orbit.
        assert force < 1e-3 * centrifugal
        centre, position = about_z(np.cos(angle), -np.sin(angle), bearing.offset), (distance, 0.0, height)
        velocity, spin = (0.0, ball[TANGENTIAL_VELOCITY], 0.0), tuple(ball[SPIN : SPIN + 3])
        inner = single_contact(bearing, bearing.inner, centre, speed, position, velocity, spin)
        outer = single_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        assert max(np.abs(inner.slip).max(), np.abs(outer.slip).max()) < 1e-3 * speed * distance


def test_a_ball_that_nothing_presses_is_in_the_middle():
    bearing, _, state = start_of("bearing_6203_loose", "drive.speed=0", "drive.offset=[0,0,0]")
    middle = 0.5 * (bearing.inner.locus_radius + bearing.outer.locus_radius)
    assert state[:, AXIS_DISTANCE] == pytest.approx(middle, abs=1e-12)
    assert np.all(static_force(bearing, 0.0, state[3, AXIS_DISTANCE], 0.0, 0.0) == np.zeros(2))


def test_balls_that_their_orbit_throws_through_the_raceway_are_refused():
    bearing, _, _ = start_of("bearing_6203")
    with pytest.raises(SceneError, match="find no rest"):
        start_state(bearing, 1e6, "rolling")
