"""A second run gives the error of the run that is given out, and changes nothing of it."""

import threading

import numpy as np
import pytest

from bearing_twin.base.errors import Interrupted
from bearing_twin.base.stopping import Halt
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.error_estimates import SECOND_RUN
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.second_run import Differences
from bearing_twin.run.simulation import Simulation, simulate

SCENES = {
    "bearing_6203": ("run.duration=0.03",),
    "bearing_6203_loose": ("run.duration=0.03",),
    "bearing_6203_sudden": ("run.duration=0.02",),
    "bearing_6203_rig_400N": ("run.duration=0.02",),
}
"""Scenes that move, and how they are shortened."""


def finished(scene):
    run = simulate(scene)
    return list(run.blocks()), run.report


def numbers(blocks):
    return np.concatenate([block.matrix() for block in blocks])


@pytest.mark.parametrize("name", SCENES)
def test_the_estimate_is_the_true_error(name):
    """Of loads and friction, against a run at a thousandth of the tolerance, within a factor of 2."""
    scene = load_scene(name, SCENES[name])
    kind, choice = KINDS[scene.kind], choose(scene)
    blocks, report = finished(scene)
    refined = scene.parameters, choice
    for _ in range(3):
        refined = kind.comparison(*refined).refined()
    true, comparison = Simulation(load_scene(name, (*SCENES[name], "solver.check=none"))), None
    true._motion = kind.motion(*refined)
    comparison, differences = kind.comparison(scene.parameters, choice), Differences(1e-3)
    for block in blocks:
        differences.add(1e-9 * block.time_ns, comparison.differences(block, true.advance(len(block))))
    for output, reported in report.errors["wanted_errors"].items():
        assert 0.5 < reported["error"] / differences.worst[output].error < 2.0


def test_no_figure_depends_on_the_check():
    """The same bits with and without."""
    (checked, report), (plain, without) = (
        finished(load_scene("bearing_6203_loose", ("run.duration=0.05", f"solver.check={check}")))
        for check in (SECOND_RUN, "none")
    )
    assert numbers(checked).tobytes() == numbers(plain).tobytes()
    assert report.figures == without.figures
    known = [key for key, value in report.errors.items() if key.endswith("_error") and value is not None]
    assert "normal_load_inner_n_error" in known
    assert all(without.errors.get(key) is None for key in known)
    assert without.errors["wanted_errors"]["loads"]["error"] is None
    assert "none" in without.errors["errors_unknown"]["method"]


@pytest.mark.parametrize(("former", "today"), [("on", SECOND_RUN), ("off", "none")])
def test_the_former_key_is_read(former, today):
    assert load_scene("bearing_6203", (f"solver.companion={former}",)).parameters.solver.check == today
    mapping = {"kind": "bearing", "solver": {"companion": former}}
    assert load_scene(mapping).parameters.solver.check == today


def commanded():
    """Outputs and report of a run that gets a speed within a chunk."""
    threads = threading.active_count()
    run = Simulation(load_scene("bearing_6203_rig_400N", ("run.duration=0.1",)))
    parts = [run.advance(21)]
    run.set_speed(220.0)
    while run.sequence < 80:
        parts.append(run.advance(7))
        assert threading.active_count() <= threads
    return numbers(parts), run.report()


def test_commands_and_threads():
    """A command in mid-chunk holds for both runs, is repeated to the bit, and no thread outlives a chunk."""
    (once, report), (twice, again) = commanded(), commanded()
    assert once.tobytes() == twice.tobytes()
    errors = [report_of_run.errors["wanted_errors"]["loads"]["error"] for report_of_run in (report, again)]
    assert errors[0] == errors[1]
    assert 0.0 < errors[0] < 1e-2


def test_what_is_interrupted_is_computed_again_to_the_bit():
    scene = load_scene("bearing_6203_loose", ("run.duration=0.2",))
    one_piece, report = finished(scene)
    halt = Halt()
    run, parts, count = Simulation(scene, halt), [], 0
    timer = threading.Timer
    while run.sequence + 1 < scene.outputs:
        timer(0.002, halt.interrupt).start()
        try:
            parts.append(run.advance(scene.outputs - run.sequence - 1))
        except Interrupted:
            count += 1
    assert numbers(parts).tobytes() == numbers(one_piece).tobytes()
    ours, theirs = (result.errors for result in (run.report(last=True), report))
    assert ours["wanted_errors"] == theirs["wanted_errors"]


def test_a_second_run_that_breaks_off_ends_the_comparison_alone():
    """The run goes on to the bit; its errors are those up to there, which is said."""
    scene = load_scene("bearing_6203", ("run.duration=2",))
    one_piece, _ = finished(scene)
    run = Simulation(scene)
    parts = [run.advance(401)]
    run._motion._second.scales = run._motion._second.scales * 1e-30
    parts.append(run.advance(scene.outputs - 401))
    assert numbers(parts).tobytes() == numbers(one_piece).tobytes()
    report = run.report(last=True)
    assert report.errors["wanted_errors"]["loads"]["error"] > 0.0
    assert "broke off" in report.errors["errors_unknown"]["method"]
    assert report.failure is None


def test_at_the_least_tolerance_the_second_run_is_coarser():
    """Both runs would be one otherwise, and the error 0."""
    scene = load_scene("bearing_6203", ("run.duration=0.01", "wanted.tolerance=1e-10"))
    choice = choose(scene)._replace(setting=1e-10)
    parameters, refined = KINDS[scene.kind].comparison(scene.parameters, choice).refined()
    assert refined.setting > choice.setting
    assert parameters.wanted.tolerance > scene.parameters.wanted.tolerance


def test_fixed_steps_are_halved_after_a_jump_too():
    """Both runs took the same stable step after it, and the estimate was rounding."""
    overrides = "solver.stepper=rk4", "run.duration=0.002", "run.output_rate=20000", "drive.change.time=0.001"
    _, report = finished(load_scene("bearing_6203", (*overrides, "drive.change.offset=[0,-20e-6,0]")))
    assert report.costs["second_run_ball_steps"] >= 2 * report.costs["ball_steps"]
    assert report.errors["wanted_errors"]["friction"]["error"] > 1e-9


def test_the_horizon_is_where_most_outputs_differ_to_the_end():
    """A single impact is none, however large; nor is what agrees again."""
    times, sizes = np.linspace(0.0, 1.0, 1001), np.ones(1001)
    for differs, horizon in (
        (times > 0.4, 0.4),
        ((times > 0.4) & (times < 0.6), -1.0),
        (times == times[-1], -1.0),
        ((times > 0.7) & (np.arange(1001) % 3 > 0), 0.7),
        (times >= 0.0, 0.0),
    ):
        differences = Differences(1e-3)
        for part in np.array_split(np.arange(1001), 7):
            differences.add(times[part], {"loads": (np.where(differs, 1e-2, 1e-5)[part], sizes[part])})
        assert differences.horizon == pytest.approx(horizon, abs=2e-3)
        assert differences.worst["loads"].error == 1e-2
        if horizon > 0.0:
            assert differences.worst["loads"].until == 1e-5


def test_equilibria_have_no_second_run():
    _, report = finished(load_scene("bearing_218_thrust", ("run.duration=0.01",)))
    assert report.stepper == "quasi_static"
    assert report.errors["wanted_errors"]["loads"]["error"] is None
    assert report.errors["normal_load_inner_n_error"] is None
