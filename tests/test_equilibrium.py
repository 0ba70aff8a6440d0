"""`bearing_twin.equilibrium`: balances, the command and the run of the same scene, refusals."""

import math

import numpy as np
import pytest

from bearing_twin import SceneError, equilibrium, load_scene, simulate
from bearing_twin.run.simulation import Simulation

BALLS, RIG = 8, "bearing_6203_rig_1000N"


def test_loads_are_balanced_and_the_stiffness_is_their_slope():
    loads = np.random.default_rng(1).normal(scale=[300.0, 300.0, 300.0, 1.0, 1.0], size=(40, 5))
    equilibria = equilibrium(RIG, loads, drive__speed=0.0)
    assert equilibria.converged.all()
    azimuth = equilibria.ball_azimuth
    across, along = (part(equilibria.contact_angle[..., 1]) * equilibria.ball_load[..., 1] for part in (np.cos, np.sin))
    # the outer ring is pushed as the inner one is, but for how far that stands beside a ball, over the pitch radius
    sums = [(across * np.cos(azimuth)).sum(1), (across * np.sin(azimuth)).sum(1), along.sum(1)]
    assert np.stack(sums, axis=1) == pytest.approx(loads[:, :3], abs=0.5)
    step = 1e-4 * np.array([300.0, 300.0, 300.0, 1.0, 1.0])
    first = equilibria.ball_azimuth[:, 0]
    ends = [equilibrium(RIG, loads + sign * step, ball_angle=first, drive__speed=0.0).displacement for sign in (1, -1)]
    slope = np.einsum("kij,kj->ki", equilibria.stiffness, ends[0] - ends[1])
    assert slope == pytest.approx(np.tile(2.0 * step, (40, 1)), rel=1e-3, abs=1e-7)


def test_it_is_what_the_command_and_the_run_of_the_scene_find(run_json):
    """Cases of one array are each as if alone."""
    clearance, speed = np.array([[5e-6], [2e-5]]), np.array([0.0, 1500.0])
    load = [100.0, -700.0, 200.0, 0.5, -1.0]
    equilibria = equilibrium(RIG, load, geometry__radial_clearance=clearance, drive__speed=speed)
    assert equilibria.displacement.shape == (2, 2, 5)
    assert equilibria.ball_load.shape == (2, 2, BALLS, 2)
    for i, j in np.ndindex(2, 2):
        options = "--load", "100,-700,200", "--moment", "0.5,-1", "--clearance", repr(clearance[i, 0].item())
        reported = run_json("bearing", RIG, *options, "--speed", speed[j])
        assert equilibria.displacement[i, j, :3] == pytest.approx(reported["ring_displacement_m"], rel=1e-9)
        assert equilibria.ball_load[i, j, :, 0] == pytest.approx(reported["normal_load_inner_n"], rel=1e-9)
        assert equilibria.stiffness[i, j] == pytest.approx(np.array(reported["stiffness"]), rel=1e-9, abs=1e-3)
    pit = ["defects=[{on: outer, spall: {place: -1.5708, length: 1e-3, depth: 5e-6}}]"]
    reported = run_json("bearing", RIG, "--load", "0,-700,0", "--set", *pit)
    equilibria = equilibrium(load_scene(RIG, pit), [0.0, -700.0, 0.0])
    assert equilibria.displacement[:3] == pytest.approx(reported["ring_displacement_m"], rel=1e-9)
    changed = ["gravity=[0,0,0]", "model.dimension=quasi_static", "rings.inner.load=[0,-700,200]", "run.duration=1e-3"]
    scene = load_scene(RIG, changed)
    sample = next(iter(simulate(scene).blocks())).values
    alone = equilibrium(scene, [0.0, -700.0, 200.0], ball_angle=0.0)
    assert alone.displacement[:3] == pytest.approx(sample["inner_ring_offset"][0], rel=1e-9)
    assert alone.ball_load == pytest.approx(sample["normal_load"][0], rel=1e-9, abs=1e-9)


def test_balls_that_lie_on_the_inner_raceway_alone_are_balanced_too():
    """Newton's method missed the place of one with a gyroscopic moment, and a load that is carried was refused."""
    running = Simulation(load_scene("bearing_6203_rig_400N"))
    running.set_speed(50.0)
    running.set_load([100.0, -200.0, 50.0], [0.0, 0.0])


def test_what_has_no_equilibrium_says_why_and_leaves_the_others():
    loads = [[0.0, -500.0, 0.0], [0.0, 0.0, 0.0], [0.0, -3e5, 0.0], [0.0, 0.0, 1e5]]
    equilibria = equilibrium(RIG, loads, geometry__radial_clearance=[[1e-5], [2.5e-4]])
    assert equilibria.converged.tolist() == [[True, False, False, False]] * 2
    assert [bool(reason) for reason in equilibria.reason.ravel()] == [False, True, True, True] * 2
    assert "no ball touches both rings" in equilibria.reason[0, 1]
    for values in (equilibria.displacement, equilibria.ball_load, equilibria.contact_angle, equilibria.stiffness):
        assert np.isnan(values[~equilibria.converged]).all()
        assert np.isfinite(values[equilibria.converged]).all()


@pytest.mark.parametrize(
    ("scene", "loads", "changes", "message"),
    [
        (RIG, [1.0, 2.0], {}, r"\(\.\.\., 3\)"),
        (RIG, [0.0, math.nan, 0.0], {}, "finite"),
        (RIG, "0,-2kN,0", {}, r"\(\.\.\., 3\)"),
        (RIG, [0.0, 1.0, 0.0], {"drive__sped": 1.0}, r"drive\.sped is not a key"),
        (RIG, [0.0, 1.0, 0.0], {"drive__speed": math.inf}, "drive.speed"),
        (RIG, np.ones((4, 3)), {"drive__speed": [1.0, 2.0]}, "broadcast"),
        (RIG, np.ones((2, 3)), {"geometry__balls": [7, 8]}, "geometry.balls"),
        (RIG, [0.0, 1.0, 0.0], {"ball_angle": math.nan}, "ball_angle must be finite"),
        (RIG, [0.0, 1.0, 0.0], {"ball_angle": "x"}, "ball_angle must be finite"),
        (RIG, [0.0, 1.0, 0.0], {"drive__speed": [None, 1.0]}, "drive.speed = .* must be numbers or words"),
        ("two_spheres", [0.0, 1.0, 0.0], {}, "no bearing"),
    ],
)
def test_what_is_not_possible_is_refused_in_a_sentence(scene, loads, changes, message):
    with pytest.raises(SceneError, match=message):
        equilibrium(scene, loads, **changes)


def test_no_load_gives_arrays_of_no_case():
    equilibria = equilibrium(RIG, np.zeros((0, 3)), drive__speed=np.zeros(0))
    balls = equilibrium(RIG, [0.0, -500.0, 0.0]).ball_azimuth.size
    assert equilibria.ball_load.shape == (0, balls, 2)
    assert equilibria.stiffness.shape == (0, 5, 5)
    assert "0 equilibria" in repr(equilibria)
