"""Balls that leave a raceway and enter a loaded zone again: equilibria are those of balls that move, or say why not."""

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.quasi_static.axes import left_by_rolling
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion
from bearing_twin.kinds.bearing.quasi_static.statics import EquilibriumSolver, Support, setting_of
from bearing_twin.report import Choice
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

LAW = "hertz"
EVEN = "gravity=[0,0,0]", "cage.kind=even"
QUASI_STATIC = "model.dimension=quasi_static"
LIGHT = "rings.inner.mass=0.05", "rings.inner.inertia=[1e-5,1e-5]", "rings.inner.support.damping=[5,5,5]"


def parameters_of(*words, control):
    return load_scene("bearing_6203", (*EVEN, f"model.control={control}", *words)).parameters


@pytest.mark.parametrize("speed", [157.08, 300.0, 628.3])
def test_what_axes_of_rolling_leave_out_of_balls_that_enter_a_loaded_zone_is_told(speed):
    """Their angles lag, by a tenth, and that takes load off them; within a factor of 3."""
    parameters, support = balls_that_enter(speed, "shared")
    seen, off, told = of_moving_balls(parameters, speed), 0.0, 0.0
    for azimuths, loads, _ in seen:
        solver = EquilibriumSolver(setting_of(parameters, LAW, speed), azimuths)
        found = in_motion(parameters, solver, support)
        off = max(off, np.abs(found.found.contacts.load - loads).max() / loads.max())
        told = max(told, left_by_rolling(parameters, solver, support, found.found).loads.max() / loads.max())
    assert off > 1e-3
    assert off / 3.0 < told < 3.0 * off


@pytest.mark.parametrize("speed", [157.08, 300.0, 628.3])
def test_equilibria_of_balls_that_enter_a_loaded_zone_are_those_of_balls_that_move(speed):
    parameters, support = balls_that_enter(speed, "auto")
    near, off, turned = None, 0.0, 0.0
    for azimuths, loads, angles in of_moving_balls(parameters, speed):
        solver = EquilibriumSolver(setting_of(parameters, LAW, speed), azimuths)
        found, _, near = in_motion(parameters, solver, support, near)
        assert not near.why
        bears = loads[:, 0] > 1e-2 * loads.max()
        off = max(off, np.abs(found.contacts.load - loads).max() / loads.max())
        turned = max(turned, np.abs(found.contacts.angle - angles)[bears].max() / np.abs(angles[bears]).max())
    assert off < 3e-4
    assert turned < 3e-4


def test_balls_that_enter_a_loaded_zone_begin_as_they_go_on_where_axes_are_asked_to_have_settled():
    parameters, _ = balls_that_enter(300.0, "settled")
    turn = 2.0 * np.pi / (0.38 * 300.0)
    angles = []
    for control in ("settled", "shared"):
        moving = bearing_motion(balls_that_enter(300.0, control)[0], Choice(LAW, "rodas4", 0.0, "", ()))
        out = moving.advance(np.linspace(0.0, 0.5 * turn, 200)[1:], 0.5 * turn)
        angles.append((np.mod(out.orbit_angle, 2.0 * np.pi).ravel(), out.contact_angle.reshape(-1, 2)))
    off = []
    for azimuths, loads, there in of_moving_balls(parameters, 300.0)[::4]:
        bears = loads[:, 0] > 2e-2 * loads.max()
        for where, seen in angles:
            order = where.argsort()
            begun = np.interp(azimuths, where[order], seen[order, 0], period=2.0 * np.pi)
            off.append(np.abs(begun - there[:, 0])[bears].max() / np.abs(there).max())
    settled, rolling = np.max(np.reshape(off, (-1, 2)), axis=0)
    assert settled < 2e-3 < 1e-2 < rolling


def balls_that_enter(speed, control):
    """A ring held so that balls leave it on their way, along and across, and how it is held."""
    offset = (0.0, -12e-6, 60e-6)
    words = "geometry.radial_clearance=1e-5", f"drive.speed={speed}", "model.dimension=prescribed"
    more = f"drive.offset={list(offset)}", "solver.companion=off", "wanted.tolerance=1e-5"
    return parameters_of(*words, *more, control=control), Support((False,) * 5, (0.0,) * 5, (*offset, 0.0, 0.0))


def of_moving_balls(parameters, speed):
    """Azimuths, loads and contact angles of balls over a spacing, once they have moved for 25 turns of the cage."""
    moving = bearing_motion(parameters, Choice(LAW, "rodas4", 0.0, "", ()))
    turn = 2.0 * np.pi / (0.38 * speed)
    moving.advance(np.array([25.0 * turn]), 25.0 * turn)
    spacing = turn / parameters.geometry.balls
    out = moving.advance(np.linspace(0.0, spacing, 33)[1:], spacing)
    return list(zip(out.orbit_angle, out.normal_load, out.contact_angle, strict=True))


def run_of(*words):
    """A run, and of its last 150 outputs azimuths, loads, angles and friction of all balls, in order of azimuths."""
    run = simulate(load_scene("bearing_6203", (*EVEN, "run.output_rate=1000", "run.publish_rate=1000", *words)))
    blocks = list(run.blocks())
    azimuth, load, angle, friction = (
        np.concatenate([block.values[name] for block in blocks])[-150:]
        for name in ("orbit_angle", "normal_load", "contact_angle", "friction_force")
    )
    azimuth = np.mod(azimuth, 2.0 * np.pi).ravel()
    along = np.stack([np.cos(azimuth), np.sin(azimuth)])
    x, y, z = np.moveaxis(friction.reshape(-1, 2, 3), 2, 0)
    turned = along[0][:, None] * x + along[1][:, None] * y, along[0][:, None] * y - along[1][:, None] * x, z
    order = azimuth.argsort()
    rubbed = np.concatenate(turned, axis=1)  # radial, along, axial, each of both raceways
    return run, *(one[order] for one in (azimuth, load.reshape(-1, 2), angle.reshape(-1, 2), rubbed))


def rarely_more(run, other):
    """By how much loads and angles of loaded balls differ, over the greatest, and friction over mu N, at most.

    Loads and angles 49 of 50 times.
    """
    (_, where, *mine), (scene, azimuth, *theirs) = run, other
    seen = [
        np.stack([np.interp(where, azimuth, one, period=2.0 * np.pi) for one in values.T], axis=1) for values in theirs
    ]
    bears = seen[0].min(axis=1) > 0.02 * seen[0].max()
    off = [np.abs(one - there)[bears] for one, there in zip(mine, seen, strict=True)]
    (load, angle), limit = (np.quantile(one.max(axis=1), 0.98) for one in off[:2]), seen[0][bears].min(axis=1)
    rubbed = np.linalg.norm(off[2].reshape(-1, 3, 2), axis=1).max(axis=1)
    coefficient = scene.scene.parameters.contact.friction_coefficient
    return load / seen[0].max(), angle / np.abs(seen[1]).max(), float((rubbed / (coefficient * limit)).max())


@pytest.mark.parametrize(
    ("load", "speed"), [("0,-300,100", 183.26), ("0,-1000,200", 157.08), ("0,-300,150", 300.0), ("0,-300,200", 628.3)]
)
def test_a_ring_under_load_with_clearance_is_in_balance_as_one_with_little_mass(load, speed):
    """Balls leave it on their way, and it moves as they pass."""
    words = f"rings.inner.load=[{load}]", f"drive.speed={speed}", "geometry.radial_clearance=1e-5"
    still = run_of(QUASI_STATIC, *words, "run.duration=0.2")
    dense = "run.duration=1.5", "run.output_rate=5000", "solver.companion=off", "model.control=settled"
    moving = run_of("model.dimension=free", *LIGHT, *words, *dense)
    loads, angles, friction = rarely_more(still, moving)
    rolling = rarely_more(run_of(QUASI_STATIC, *words, "model.control=shared", "run.duration=0.2"), moving)
    assert loads < 6e-4
    assert angles < 2e-3
    assert rolling[0] > 2.0 * loads
    told = still[0].report.errors["wanted_errors"]["friction"]["error"]
    assert friction < 1.5 * told
    assert told < 1e-3 or told < 6.0 * friction
    assert still[0].report.status == ("done" if told < 1e-3 else "doubtful: friction")
    assert "their axes of spin have settled" in still[0].report.choice_reason


def test_balls_that_are_elsewhere_turn_by_turn_are_told_by_what_loads_are_off():
    words = "rings.inner.load=[0,-500,100]", "drive.speed=157.08", "geometry.radial_clearance=1e-5"
    still = run_of(QUASI_STATIC, *words, "run.duration=0.2")
    dense = "run.duration=1.5", "run.output_rate=5000", "solver.companion=off"
    loads, *_ = rarely_more(still, run_of("model.dimension=free", *LIGHT, *words, *dense))
    told = still[0].report.errors["wanted_errors"]["loads"]["error"]
    assert 1e-3 < loads < told < 5.0 * loads
    assert still[0].report.status == "doubtful: loads"


RATE = 20000  # outputs a second, by which ringing of a ring is seen
SLOW = butter(4, 1000.0, fs=RATE, output="sos")  # what changes more slowly than 1 kHz


def by_time(count, *words):
    """Of the last outputs (count, Z): azimuths, loads and angles of the inner contacts."""
    blocks = list(simulate(load_scene("bearing_6203", (*EVEN, "run.publish_rate=1000", *words))).blocks())
    channels = "orbit_angle", "normal_load", "contact_angle"
    azimuth, load, angle = (np.concatenate([one.values[name] for one in blocks])[-count:] for name in channels)
    return np.mod(azimuth, 2.0 * np.pi), load[..., 0], angle[..., 0]


@pytest.mark.parametrize(
    ("load", "speed", "slow"), [("0,-1000,200", 157.08, 2e-4), ("0,-300,100", 183.26, 5e-4), ("0,-400,60", 300.0, 1e-3)]
)
def test_what_a_ring_with_mass_adds_to_its_equilibrium_is_its_ringing(load, speed, slow):
    """It rings each time a ball enters: less with less mass, and hardly below 1 kHz."""
    words = f"rings.inner.load=[{load}]", f"drive.speed={speed}", "geometry.radial_clearance=1e-5"
    where, loads, angles = by_time(1000, QUASI_STATIC, *words, "run.output_rate=5000", "run.duration=0.3")
    order, where = where.ravel().argsort(), np.sort(where.ravel())
    most = []
    for mass, damping in ((0.05, 5.0), (0.0125, 100.0)):
        ring = f"rings.inner.mass={mass}", f"rings.inner.inertia=[{2e-4 * mass},{2e-4 * mass}]"
        support = f"rings.inner.support.damping=[{damping},{damping},{damping}]", "solver.companion=off"
        dense = "model.control=settled", f"run.output_rate={RATE}", "run.duration=1.5", "wanted.tolerance=1e-5"
        azimuth, moved, turned = by_time(4000, "model.dimension=free", *ring, *support, *dense, *words)
        still, leant = (np.interp(azimuth, where, one.ravel()[order], period=2 * np.pi) for one in (loads, angles))
        bears = moved > 0.02 * moved.max()
        off = (moved - still) / moved.max(), np.where(bears, turned - leant, 0.0) / turned[bears].max()
        inside = slice(200, -200)  # filters know nothing of what is beyond the ends
        below = [np.abs(sosfiltfilt(SLOW, one, axis=0)[inside]).max() for one in off]
        assert below[0] < slow
        assert below[1] < 2e-3
        most.append(np.abs(off[0][inside]).max())
    assert most[1] < 0.6 * most[0]
    assert most[0] > 1.9 * below[0]
