"""Rings that leave their equilibrium, as friction along the grooves makes them whirl: before a run, and in one."""

import json

import numpy as np
import pytest

from bearing_twin.command import cli
from bearing_twin.kinds.bearing.quasi_static.in_motion import scene_in_motion
from bearing_twin.kinds.bearing.quasi_static.whirl import whirl_of
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

EVEN = "gravity=[0,0,0]", "cage.kind=even"
MASS = "rings.inner.mass=0.5", "rings.inner.inertia=[1e-4,1e-4]"
STILL, FREE = "model.dimension=quasi_static", "model.dimension=free"
THRUST = "rings.inner.load=[0,0,800]", "drive.speed=2000"
TILTS = "rings.inner.load=[0,0,500]", "rings.inner.moment=[1,0]", "rings.inner.free=all", "drive.speed=1000"


def found(scene, *words):
    return whirl_of(load_scene(scene, (*EVEN, STILL, *words)).parameters, "hertz")[0]


def run(scene, *words):
    made = simulate(load_scene(scene, ("cage.kind=even", "run.publish_rate=1000", *words)))
    return made, list(made.blocks())


def test_a_ring_that_whirls_is_foretold_and_does_so():
    """Under 800 N of thrust and the balls' weight, from rolling: loads spread by half, those of equilibria do not."""
    words = *MASS, *THRUST, "run.output_rate=1000"
    still, _ = run("7204B", STILL, "run.duration=0.01", *words)
    assert still.report.status.startswith("doubtful: loads")
    (said,) = (one for one in still.choice.warnings if "whirl" in one)
    assert "1.57e+03 Hz" in said
    _, moving = run("7204B", FREE, "run.duration=0.1", "solver.companion=off", *words)
    loads = moving[-1].values["normal_load"][-30:, :, 1]
    assert np.ptp(loads) > 0.3 * loads.mean()


def test_a_ring_that_stays_is_not_suspected():
    """Next to no friction takes it nowhere: what is left is what contacts damp."""
    slippery = "contact.friction_coefficient=1e-6"
    for scene, words in (("7204B", THRUST), ("bearing_6203", TILTS)):
        whirl = found(scene, *MASS, *words, slippery)
        assert not whirl.grows
        assert whirl.rate < 1.0
    still, _ = run("7204B", STILL, "run.duration=0.01", *MASS, *THRUST, slippery)
    assert still.report.status == "done"
    _, moving = run("7204B", FREE, "run.duration=0.1", "solver.companion=off", *MASS, *THRUST, slippery)
    loads = moving[-1].values["normal_load"][-30:, :, 1]
    assert np.ptp(loads) < 0.05 * loads.mean()


def loads_at(place, capsys):
    """What holds a ring (5,) at this place, balls settled, by the command."""
    at = [",".join(f"{one:.14g}" for one in part) for part in (place[:3], place[3:])]
    words = "--displacement", at[0], "--misalignment", at[1], "--control", "settled", "--set", "drive.speed=1000"
    assert cli.main(["bearing", "bearing_6203", *words, "--ball-angle", "0", "--set", EVEN[0], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    return -np.array([*told["ring_force_n"], *told["ring_moment_nm"]])


def test_a_whirl_follows_from_what_the_command_tells(capsys):
    """Undamped, by differences of `bearing --control settled`, mass and gyroscopic moment: 98/s at 558 Hz."""
    undamped = "contact.relaxation_time=0"
    begin = load_scene("bearing_6203", (*EVEN, STILL, *MASS, *TILTS, "model.control=settled", undamped)).parameters
    place, steps = scene_in_motion(begin, "hertz").found.coordinates, np.diag([2e-8] * 3 + [2e-6] * 2)
    sides = [(loads_at(place + one, capsys) - loads_at(place - one, capsys)) / (2.0 * one.max()) for one in steps]
    masses = np.array([0.5] * 3 + [1e-4] * 2)
    spun = np.zeros((5, 5))
    spun[3, 4], spun[4, 3] = 0.1, -0.1
    turned = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.array(sides).T / masses[:, None], -spun / masses[:, None]]])
    fastest = max(np.linalg.eigvals(turned), key=lambda one: one.real)
    whirl = found("bearing_6203", *MASS, *TILTS, undamped)
    assert whirl.rate == pytest.approx(fastest.real, rel=0.02)
    assert whirl.frequency == pytest.approx(abs(fastest.imag) / (2.0 * np.pi), rel=1e-3)
    assert whirl.rate == pytest.approx(98.0, rel=0.02)
    damped = found("bearing_6203", *MASS, *TILTS)
    assert damped.rate == pytest.approx(whirl.rate - 0.5e-6 * (2.0 * np.pi * whirl.frequency) ** 2, rel=0.03)


def test_where_nothing_is_known_of_a_whirl():
    """Without mass, where nothing is free, where balls leave a raceway: no statement; without mass that is said."""
    assert found("bearing_6203", "rings.inner.load=[0,0,100]") is None
    assert found("bearing_6203", *MASS, "drive.offset=[0,0,3e-5]", "drive.tilt=[1e-3,0]") is None
    assert found("bearing_6203_rig_1000N") is None
    light, _ = run("bearing_6203", STILL, "rings.inner.load=[0,0,100]", "run.duration=0.01")
    assert "rings.inner.mass" in light.report.errors["errors_unknown"]["whirl"]
