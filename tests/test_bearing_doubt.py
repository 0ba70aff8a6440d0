"""What a bearing run says of its own errors, against the same run at a tolerance so tight that it counts as true."""

import dataclasses
import json
import math

import numpy as np
import pytest
from made_up_run import a_choice, made_up_block, made_up_scene

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.bearing_variants import CASES
from bearing_twin.charts.tolerance import METHOD, judge
from bearing_twin.contact.friction import friction_number, friction_of
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing import measured
from bearing_twin.kinds.bearing.companion import looking, redoing
from bearing_twin.kinds.bearing.companion.growth import MOST, Growth
from bearing_twin.kinds.bearing.companion.pointers import one_for_all
from bearing_twin.kinds.bearing.companion.windows import (
    ALL,
    LEAST_STEPS,
    PLACE,
    WINDOW,
    Window,
    overlap,
    steps_before,
    window_at,
    within,
)
from bearing_twin.kinds.bearing.doubt import BearingDoubt
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.summing import turning
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.run.doubt import exceeds, promise_in_words
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.sample import cut
from bearing_twin.units import two_digits

EXACT = 1e-8  # tolerance of what counts as true
CELLS = {
    "settled": ("bearing_6203", ("run.duration=0.1",), 1e-4),
    "lift-off": ("bearing_6203_loose", ("run.duration=0.04",), 1e-3),
    "wider": ("bearing_6205", ("geometry.radial_clearance=1e-5", "drive.offset=[0,-8e-6,0]", "run.duration=0.1"), 1e-3),
}


def outputs(motion, scene):
    """All outputs of a motion but the first, in chunks of at most 100."""
    run, parts = scene.parameters.run, []
    total = round(run.duration * run.output_rate)
    for first in range(0, total, 100):
        times = np.arange(1, min(100, total - first) + 1) / run.output_rate
        parts.append(motion.advance(times, times[-1]))
    return Rows(parts[0].layout, np.concatenate([part.numbers for part in parts]))


def watched(name, *overrides):
    scene = load_scene(name, overrides)
    return WatchedMotion(scene.parameters, a_choice()), scene


def reported(name, *overrides):
    run = simulate(load_scene(name, overrides))
    for _ in run.blocks():
        pass
    return run


@pytest.mark.parametrize("cell", CELLS)
def test_the_estimates_are_within_a_factor_of_three_of_the_true_errors(cell, monkeypatch):
    name, overrides, tolerance = CELLS[cell]
    moving, scene = watched(name, *overrides, f"wanted.tolerance={tolerance}")
    monkeypatch.setattr(moving, "_worst", lambda since: 0.0)  # as rough as it is
    found = outputs(moving, scene)
    exact_scene = load_scene(name, (*overrides, f"wanted.tolerance={EXACT}"))
    true = errors(moving, found, outputs(BearingMotion(exact_scene.parameters, a_choice()), exact_scene))
    rows = moving.take_records()["companion"]
    estimates = rows[:, PLACE["load"]].max() / found.normal_load.max(), rows[:, PLACE["friction"]].max()
    for estimate, error in zip(estimates, true, strict=True):
        assert error / 3.0 < estimate < 3.0 * error


@pytest.mark.parametrize("rough_by", [10.0, 30.0, 100.0])  # times the wanted tolerance
def test_what_is_too_rough_is_done_again_and_that_is_remembered_and_told(rough_by):
    name, overrides, tolerance = CELLS["lift-off"]
    scene = load_scene(name, (*overrides, f"wanted.tolerance={tolerance}"))
    rough = a_choice()._replace(setting=rough_by * tolerance)
    moving = WatchedMotion(scene.parameters, rough)
    found = outputs(moving, scene)
    exact_scene = load_scene(name, (*overrides, f"wanted.tolerance={EXACT}"))
    exact = outputs(BearingMotion(exact_scene.parameters, a_choice()), exact_scene)
    plain = BearingMotion(scene.parameters, rough)
    assert max(errors(plain, outputs(plain, scene), exact)) > 2.0 * tolerance
    assert max(errors(moving, found, exact)) < (1.0 if rough_by != 30.0 else 2.0) * tolerance  # 1.5, unseen
    rows = moving.take_records()["companion"]
    assert moving.setting < 1.0
    assert rows[-1, PLACE["tolerance"]] == moving.setting * moving.given
    assert (np.diff(rows[:, PLACE["tolerance"]]) <= 0.0).all()


def always_off(since):
    """What finds each part off by all of mu N, in a window that begins with the part or before all."""

    def look(part, windows, scales, tolerance):
        row = np.zeros((1, len(PLACE)))
        row[0, PLACE["friction"]], row[0, PLACE["begin"]] = 1.0, part.elapsed if since == "the part" else -1.0
        return row

    return look


def test_a_tighter_setting_gets_rougher_again_once_parts_are_calm_but_never_as_rough_as_what_failed(monkeypatch):
    moving, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    look, found = always_off("the part"), []

    def look_once(part, windows, scales, tolerance):
        row = look(part, windows, scales, tolerance)
        row[0, PLACE["friction"]] = 1e-3 * (1.0 if not found else 1e-6)  # of the tolerance: all of it, then nothing
        found.append(moving.setting)
        return row

    monkeypatch.setattr(moving.companion, "look", look_once)
    settings = []
    for _ in range(30):
        moving.advance(0.02 * np.arange(1, 2), 0.02)
        settings.append(moving.setting)
        kept = moving.snapshot()
    assert found[:2] == [1.0, settings[0]]
    assert settings[0] == settings[1] == 0.25
    assert (np.diff(settings) >= 0.0).all()
    assert settings[-1] == 0.5
    other, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    other.resume(kept)
    assert (other.setting, other.snapshot()) == (0.5, kept)


def test_what_windows_of_all_balls_miss_keeps_steps_as_short_as_they_are():
    """Of balls that nothing couples: a twentieth of the tolerance in a window of all may be more than all of it."""
    moving, _ = watched("bearing_6203", "wanted.tolerance=1e-3")
    moving.companion.greatest_load = 100.0
    for ball, settings in ((ALL, {0.25}), (3, {0.25, 0.5})):
        moving._set(0.25)
        row = np.zeros((1, len(WINDOW.columns)))
        row[0, PLACE["ball"]], row[0, PLACE["load"]] = ball, 0.05 * 1e-3 * 100.0
        found = set()
        for _ in range(6):
            moving._relax(row)
            found.add(moving.setting)
        assert found == settings


def test_a_part_without_outputs_is_integrated_more_tightly_for_no_window_sees_it(monkeypatch):
    """As a jump that ends between two outputs; behind it the setting is as it was."""
    moving, _ = watched("bearing_6203", "drive.change={time: 2e-3, speed: -50}", "drive.acceleration=1e5")
    settings, part = [], BearingMotion._part

    def noted(self, times, duration, out, first):
        settings.append((len(times), self.setting))
        part(self, times, duration, out, first)

    monkeypatch.setattr(BearingMotion, "_part", noted)
    moving.advance(np.array([0.002, 0.01]), 0.01)
    assert (0, redoing.UNSEEN) in settings
    assert {setting for outputs, setting in settings if outputs} == {1.0}
    assert moving.setting == 1.0


@pytest.mark.parametrize("speed", [157.0796, 94.2478])
def test_a_part_is_done_again_where_what_a_moving_ring_carries_on_makes_it_too_rough(speed):
    """Windows off by 0.34 and 0.46 of the tolerance, of which the run counts three times as much."""
    run = reported("bearing_6203_rig_1000N", "run.duration=1", f"drive.speed={speed}")
    assert run.report.status == "done"


@pytest.mark.parametrize(("since", "redone"), [("the part", 4), ("before", 2)])
def test_where_a_tighter_setting_finds_the_same_the_setting_goes_back(since, redone, monkeypatch):
    """As where balls hit each other: tightened on and on, steps came down to rounding, and the run stalled.

    What began before a part is a matter of the whole chunk, which is done again once in a run.
    """
    moving, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    settings, advance = [], BearingMotion._part
    monkeypatch.setattr(BearingMotion, "_part", lambda it, *rest: (settings.append(it.setting), advance(it, *rest))[1])

    monkeypatch.setattr(moving.companion, "look", always_off(since))
    for _ in range(4):  # chunks, the first of two parts
        moving.advance(0.02 * np.arange(1, 2), 0.02)
    assert moving.setting == 0.1
    assert min(settings) >= 0.1 * 0.01
    assert len(settings) == 4 + redone


def test_what_a_chunk_that_is_done_again_was_looked_at_counts(monkeypatch):
    """Forgotten, a run whose chunks are done again would be looked at more than its share of steps allows."""
    moving, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    look, off, looked, steps = moving.companion.look, always_off("before"), [], []

    def also_off(part, *rest):
        before, spent = moving.companion.looked, moving.companion.steps
        rows = look(part, *rest)
        looked.append(moving.companion.looked - before)
        steps.append(moving.companion.steps - spent)
        return np.concatenate([rows, off(part, *rest)])

    monkeypatch.setattr(moving.companion, "look", also_off)
    moving.advance(0.04 * np.arange(1, 2), 0.04)
    assert len(looked) > 2
    assert moving.companion.looked == sum(looked) > looked[-1]
    assert moving.companion.steps == sum(steps)


@pytest.mark.parametrize("since", ["the part", "before"])
def test_a_setting_that_nothing_can_be_integrated_with_is_given_up(since, monkeypatch):
    """The run goes on as before it was tightened, and its error is told."""
    moving, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    plain, _ = watched("bearing_6203", "run.duration=0.1", "wanted.tolerance=1e-3")
    advance = BearingMotion._part

    def part(it, *rest):
        advance(it, *rest)
        if it.setting < 1.0:
            it.state += 1.0  # as a part that was left in its middle
            raise IntegrationError("needs ever shorter steps", "stalled", 0.0, "ball 0")

    monkeypatch.setattr(moving.companion, "look", always_off(since))
    for _ in range(2):
        plain.advance(0.02 * np.arange(1, 2), 0.02)
    monkeypatch.setattr(BearingMotion, "_part", part)
    for _ in range(2):
        moving.advance(0.02 * np.arange(1, 2), 0.02)
    assert moving.setting == 1.0
    assert moving.elapsed == pytest.approx(0.04)
    assert np.array_equal(moving.state, plain.state)
    assert len(moving.take_records()["companion"]) >= 2


def test_a_run_gives_the_same_bits_however_it_is_asked_for_and_after_a_reset():
    scene = load_scene("bearing_6203_loose", ("run.duration=0.12",))
    simulation = Simulation(scene)
    whole = simulation.advance(121)
    simulation.reset()
    parts = [simulation.advance(count) for count in (1, 30, 69, 20, 1)]
    assert np.array_equal(np.concatenate([part.matrix() for part in parts]), whole.matrix())
    rows = np.concatenate([part.records["companion"] for part in parts if "companion" in part.records])
    assert len(rows) > 3
    assert np.array_equal(rows, whole.records["companion"])


def test_a_motion_goes_on_from_a_snapshot_with_what_its_companion_knew():
    moving, _ = watched("bearing_6203_loose")
    times = 1e-3 * np.arange(1, 21)
    moving.advance(times, times[-1])
    moving.take_records()
    kept = json.loads(json.dumps(moving.snapshot()))
    first = moving.advance(times, times[-1])
    rows = moving.take_records()["companion"]
    other, _ = watched("bearing_6203_loose")
    other.resume(kept)
    again = other.advance(times, times[-1])
    assert np.array_equal(first.numbers, again.numbers)
    assert np.array_equal(rows, other.take_records()["companion"])


def test_a_run_of_an_hour_is_no_other_for_its_companion():
    moving, scene = watched("bearing_6203", "run.duration=0.02")
    moving.companion.parts = 10_000
    assert len(outputs(moving, scene).normal_load) == round(0.02 * scene.parameters.run.output_rate)


def test_what_the_tables_predicted_stands_beside_what_came_out():
    run = reported("bearing_6203", "run.duration=0.05")
    told, foretold = run.report.errors["wanted_errors"], run.choice.predicted
    assert told["loads"]["predicted"] == foretold["load_error"] != foretold["friction_error"]
    assert told["friction"]["predicted"] == foretold["friction_error"]
    assert f"wanted 0.001, predicted {two_digits(foretold['friction_error'])}" in promise_in_words(told["friction"])
    unlike = reported("bearing_6203", "run.duration=0.01", "geometry.balls=13").report.errors["wanted_errors"]
    assert "predicted" not in unlike["loads"]
    assert "predicted" not in promise_in_words(unlike["loads"])


def test_a_companion_that_is_off_is_said():
    on, off = (reported("bearing_6203", "run.duration=0.05", f"solver.companion={word}") for word in ("on", "off"))
    key = "greatest_normal_load_inner_n"
    assert on.report.figures[key] == pytest.approx(off.report.figures[key], rel=1e-5)
    assert "companion_ball_steps" not in off.report.costs
    assert on.report.errors["wanted_errors"]["loads"]["error"] < 1e-3
    assert off.report.errors["wanted_errors"]["loads"]["error"] is None
    assert "solver.companion: off" in off.report.errors["errors_unknown"]["method"]
    assert "method" not in off.report.errors["errors_by_source"]["normal_load_inner_n"]


@pytest.mark.parametrize("stepper", ["dopri5", "imex"])
def test_a_method_that_is_wrong_after_a_jump_is_refused_right_or_doubtful(stepper):
    jump = ("drive.change.time=2e-3", "drive.change.offset=[0,-4e-5,0]", "run.duration=4e-3", "run.output_rate=2e4")
    run = reported("bearing_6203", *jump, f"solver.stepper={stepper}")
    _moving, scene = watched("bearing_6203", *jump, f"wanted.tolerance={EXACT}")
    exact = outputs(BearingMotion(scene.parameters, a_choice()), scene)
    found = Simulation(run.scene).advance(run.outputs).values
    error = np.abs(found["normal_load"][1:] - exact.normal_load).max() / exact.normal_load.max()
    assert error <= run.scene.parameters.wanted.tolerance or run.report.status.startswith("doubtful: ")


def test_a_law_that_is_further_off_than_wanted_is_doubtful_and_told_what_mends_it():
    run = reported("bearing_6203", "run.duration=0.02", "contact.normal=volumetric", "wanted.tolerance=1e-4")
    assert run.report.status == "doubtful: loads"
    assert any("contact.normal: hertz" in flag for flag in run.report.flags)
    by_source = run.report.errors["errors_by_source"]["normal_load_inner_n"]
    assert by_source["law"][0] > 100.0 * by_source["method"][0]
    sums = [sum(parts) for parts in zip(*by_source.values(), strict=True)]
    assert run.report.errors["normal_load_inner_n_error"] == pytest.approx(sums, rel=1e-12)


def test_a_torque_of_friction_at_a_point_says_what_drilling_it_does_not_hold():
    run = reported("bearing_6203", "run.duration=0.05")
    figures, errors_of = run.report.figures, run.report.errors
    assert abs(figures["drive_torque_nm"]) < 1e-7
    # The power of both spots of every ball under pure spin, by quadrature over the spot, over the ring's speed.
    last = Simulation(run.scene).advance(run.outputs)[-1]
    power = 0.0
    for side, name in enumerate(("inner", "outer")):
        for ball in range(8):
            spot = friction_of(
                friction_number("spot_fine"), last["normal_load"][ball, side], figures[f"semi_major_{name}_m"][ball],
                figures[f"semi_minor_{name}_m"][ball], 0.0, 0.0, last["spin_rate"][ball, side], 0.08, 1e-9,
            )  # fmt: skip
            power += abs(spot.torque * last["spin_rate"][ball, side])
    told = errors_of["errors_by_source"]["drive_torque_nm"]["friction_model"]
    assert told == pytest.approx(power / 183.26, rel=0.01)
    (flag,) = (flag for flag in run.report.flags if "drive torque" in flag)
    assert "set contact.friction: spot, which computes the drilling that a point does not hold" in flag


def drilling_errors(*words):
    found = reported(*words, "run.duration=0.02").report.errors["errors_by_source"]
    return found["friction_torque_nm"]["friction_model"]


def test_spots_that_do_not_spin_hold_no_drilling_and_slow_ones_little():
    assert drilling_errors("bearing_6203_rig_1000N") == [0.0] * 8
    sharp, smooth = (drilling_errors("bearing_6203", f"contact.friction_regularisation={v}") for v in (0.01, 0.1))
    assert 0.0 < smooth[0] < 0.7 * sharp[0]


def test_the_error_of_friction_over_spots_holds_what_its_quadrature_is_off():
    run = simulate(load_scene("bearing_6203", ("run.duration=0.02", "contact.friction=spot")))
    last, torques = [block[-1] for block in run.blocks()][-1], {}
    figures = run.report.figures
    for model in ("spot", "spot_fine"):
        torques[model] = [
            friction_of(
                friction_number(model), last["normal_load"][0, side], figures[f"semi_major_{name}_m"][0],
                figures[f"semi_minor_{name}_m"][0], 0.0, 0.0, last["spin_rate"][0, side], 0.08, 0.01,
            ).torque
            for side, name in enumerate(("inner", "outer"))
        ]  # fmt: skip
    told = run.report.errors["errors_by_source"]["friction_torque_nm"]["friction_model"][0]
    off, drills = np.abs(np.subtract(*torques.values())).sum(), np.abs(torques["spot_fine"]).sum()
    assert 0.0 < off < told < drills


@pytest.mark.parametrize(
    "words", [("bearing_6203_rig_1000N", "rings.inner.load=[0.0, -1000.0, 200.0]"), ("bearing_6203_tilted",)]
)
def test_friction_over_spots_is_no_advice_where_it_is_refused(words):
    with pytest.raises(SceneError, match="is not built for a ring that tilts or moves"):
        simulate(load_scene(words[0], [*words[1:], "contact.friction=spot"]))
    run = reported(*words, "run.duration=0.02")
    assert any("mostly friction model" in flag for flag in run.report.flags)
    assert not any("contact.friction: spot" in flag for flag in run.report.flags)
    assert "spot is not built for a ring" in run.report.errors["errors_unknown"]["friction_model"]


def test_a_held_ring_that_touches_nothing_is_told_once_and_its_figures_make_no_noise():
    scene = load_scene("6203", ["geometry.radial_clearance=40e-6", "run.duration=0.05"])
    run, blocks = simulate(scene), []
    blocks += run.blocks()
    report = run.report
    assert report.figures["greatest_normal_load_inner_n"] == [0.0] * 8
    assert report.figures["drive_work_j"] == 0.0
    told = report.as_dict()
    assert told["ring_force_n_error"] == [0.0] * 3
    assert told["normal_load_outer_n_error"][0] > 0.0
    assert sum("touches no ball" in one for one in report.warnings) == 1
    assert list(report.flags) == []
    # balls that ring may strike it between outputs: the drive's work knows, loads at outputs do not
    figures = KINDS["bearing"].figures_of(scene.parameters, run.choice)
    for block in blocks:
        figures.add(block)
    figures.last["drive_work"] = 1e-6
    assert ["between outputs alone" in one for one in figures.flags()] == [True]


def test_balls_that_are_thrown_off_the_inner_ring_are_told():
    report = reported("bearing_6203", "drive.speed=20000", "run.duration=0.01").report
    assert report.figures["greatest_normal_load_inner_n"] == [0.0] * 8
    assert sum("thrown off the inner ring" in one and "rad/s" in one for one in report.flags) == 1


def test_a_bearing_names_in_its_flags_the_torque_that_lacks_and_not_what_follows_from_it():
    """Its moment is off by far less than loads that cancel in it may be; its work is torque over angle."""
    report = reported("bearing_6203", "run.duration=0.1").report
    told = report.as_dict()
    for key in ("drive_work_j", "dissipated_j", "ring_moment_nm"):
        assert exceeds(told[key], told[f"{key}_error"])
    (flag,) = report.flags
    assert flag.count("±") == 2
    for words in ("drive torque 0 ±", "friction torque 0 ±", "set contact.friction: spot"):
        assert words in flag


def test_a_motion_in_a_plane_has_no_moment_across_it_and_no_doubt_about_one():
    run = simulate(load_scene("bearing_6203_unbalance", ["run.duration=0.02"]))
    for _ in run.blocks():
        pass
    told = run.report.as_dict()
    assert told["ring_moment_nm"] == told["ring_moment_nm_error"] == [0.0, 0.0]
    assert told["ring_force_n_error"][0] > 0.0
    assert not any("ring moment" in flag for flag in run.report.flags)


def test_a_free_ring_tilts_as_exactly_as_the_displacement_that_this_makes_at_the_balls():
    run = reported("bearing_6203_step_load", "run.duration=0.02", "rings.inner.change.moment=[0.2,0.1]")
    parts, pitch = run.report.errors["errors_by_source"], run.scene.parameters.geometry.pitch_diameter
    moved, tilted = (parts[key]["method"] for key in ("ring_displacement_m", "misalignment_rad"))
    assert tilted == pytest.approx([one / (0.5 * pitch) for one in moved[:2]], abs=0.0)
    assert tilted[0] > 0.0


def test_loads_of_balls_that_stand_do_not_change_because_they_go_round():
    """A step of load at standstill: balls turned by rounding, 1e-38 rad, and loads were said to be off by 2e10."""
    report = reported("bearing_6203_step_load", "run.duration=0.02").report
    assert report.status == "done"
    assert 0.0 < report.errors["wanted_errors"]["loads"]["error"] < 1e-5


def test_a_command_that_makes_another_motion_of_it_keeps_the_tolerance_and_loads_do_not_jump():
    """Another stepper is chosen for it, which goes on where the first one was."""

    def commanded(*overrides):
        simulation = Simulation(load_scene("bearing_6203", ("run.duration=0.15", *overrides)))
        before = simulation.advance(51)
        simulation.set_speed(1500.0)
        return simulation, before, Rows(before.values.layout, simulation.advance(100).matrix())

    _, _, exact = commanded(f"wanted.tolerance={EXACT}", "solver.companion=off")
    simulation, before, found = commanded("wanted.tolerance=1e-3")
    assert max(errors(BearingMotion(simulation.scene.parameters, a_choice()), found, exact)) < 1e-3
    load = np.concatenate([before.values["normal_load"][-1:], found.normal_load[:1]])
    assert np.abs(np.diff(load, axis=0)).max() < 0.01 * load.max()


def test_outputs_without_windows_say_that_the_method_is_not_known():
    scene = made_up_scene()
    doubt, block = BearingDoubt(scene.parameters, a_choice()), made_up_block(scene, 20)
    doubt.add(block)
    assert not doubt.worst.windows
    assert "no window" in doubt._notes()["method"]


def test_windows_hold_the_cell_they_are_made_for_and_enough_steps():
    random = np.random.default_rng(5)
    for _ in range(200):
        steps = random.integers(0, 6, 40).astype(float)
        cell = int(random.integers(40))
        window = window_at(3, cell, steps_before(steps))
        inside = slice(window.begin + 1, window.begin + 1 + window.length)
        assert window.begin < cell < window.begin + 1 + window.length
        assert window.begin >= -1
        assert window.begin + window.length < 40
        assert steps[inside].sum() >= min(LEAST_STEPS, steps.sum())
    assert overlap(Window(0, 3, 4), Window(1, 6, 2))
    assert not overlap(Window(0, 3, 4), Window(1, 7, 2))
    assert within(Window(0, 4, 2), Window(0, 3, 4))
    assert not within(Window(1, 4, 2), Window(0, 3, 4))


def test_one_ball_is_looked_at_for_all_where_it_is_like_them_and_that_is_cheaper():
    steps, grid = np.ones((3, 12)), np.ones((3, 12))
    windows = [Window(0, -1, 6), Window(1, 3, 8)]
    assert one_for_all(windows, (grid,), steps) == [Window(0, -1, 12)]
    assert one_for_all(windows[:1], (grid,), steps) == windows[:1]  # nothing to share
    short = [Window(0, -1, 6), Window(1, 3, 6)]
    assert one_for_all(short, (grid,), steps) == short  # as many steps as one ball takes in all
    assert one_for_all(windows, (grid,), steps * [[1.0], [1.0], [0.25]]) == windows  # one moves otherwise
    unlike = np.diag([1.0, 1.0, 3.0]) @ grid
    assert one_for_all(windows, (grid, unlike), steps) == [Window(2, -1, 12)]
    assert one_for_all(windows, (unlike, np.diag([3.0, 1.0, 1.0]) @ grid), steps) == windows  # none shows both
    assert one_for_all([Window(ALL, -1, 12), *windows], (grid,), steps)[0].ball == ALL
    assert one_for_all(windows, (np.zeros((3, 12)),), steps) == [Window(0, -1, 12)]


@pytest.mark.parametrize(("outputs_wanted", "off"), [("loads", 1e-6), ("history", 1e-2)])
def test_friction_has_nothing_done_again_where_loads_alone_are_wanted(outputs_wanted, off):
    motion, _ = watched("bearing_6203", f"wanted.outputs={outputs_wanted}", "wanted.tolerance=1e-3")
    motion.companion.greatest_load = 50.0
    row = np.zeros((1, len(WINDOW.columns)))
    row[0, PLACE["load"]], row[0, PLACE["friction"]] = 50.0 * 1e-6, 1e-2
    assert motion.companion.off(row) == pytest.approx(off / 1e-3)


def followed(*rows):
    """The growth of errors of friction in rows (end [s], begin [s], ball, error) at a tolerance of 1e-4."""
    growth = Growth(1e-4)
    for end, begin, ball, error in rows:
        row = np.zeros(len(WINDOW.columns))
        row[0], row[PLACE["begin"]], row[PLACE["ball"]], row[PLACE["friction"]] = end, begin, ball, error
        growth.add(row, 50.0)
    return growth


def test_an_error_that_grows_by_itself_beyond_what_is_wanted_is_a_horizon():
    grown = followed((0.01, 0.0, 2, 1e-6), (0.02, 0.0, 2, 5e-5), (0.03, 0.0, 2, 2e-3), (0.04, 0.0, 2, 2e-2))
    assert (grown.grown, grown.kept) == (pytest.approx(2000.0), 0.02)
    assert "beyond 0.02 s" in grown.notes["horizon"]
    assert "only statistics" in grown.notes["horizon"]
    # Of several balls the first that cannot be foretold counts, in whatever order they are heard of.
    balls = ((0.02, 0.0, 2, 1e-6), (0.03, 0.0, 2, 2e-2)), ((0.01, 0.0, 3, 1e-6), (0.04, 0.0, 3, 2e-2))
    assert [followed(*one, *other).kept for one, other in (balls, balls[::-1])] == [0.01, 0.01]
    # Great from the start, within what is wanted, or of another ball or begin: none of them is growth.
    assert not followed((0.01, 0.0, 2, 1e-2), (0.02, 0.0, 2, 1.0)).notes
    assert not followed((0.01, 0.0, 2, 1e-9), (0.02, 0.0, 2, 9e-5)).notes
    assert not followed((0.01, 0.0, 2, 1e-6), (0.02, 0.0, 3, 1e-2), (0.03, 0.02, 2, 1e-2)).notes
    assert len(followed(*((0.1, 0.001 * one, 0, 1e-6) for one in range(2 * MOST))).first) == MOST


@pytest.mark.parametrize("retaken", [0, 2])
def test_a_chunk_in_which_balls_meet_is_done_again_from_its_beginning(retaken, monkeypatch):
    """A ring jumps at 20 ms, and two balls that were thrown meet at 31 ms: 5e-9 m become an error of friction."""
    monkeypatch.setattr(redoing, "RETAKEN", retaken)
    case, tolerance = "sudden, harder", 4e-3
    name, differs = CASES[case]
    point = judge(case, METHOD, tolerance, 0.0)
    assert (point.error < 0.1 * tolerance) == (retaken > 0)
    assert point.told == ("done" if retaken else "doubtful: friction")
    scene = load_scene(name, (*differs, f"wanted.tolerance={tolerance}"))
    moving = WatchedMotion(scene.parameters, choose(scene))
    times = np.arange(1, 401) / scene.parameters.run.output_rate
    moving._rows = [np.full((1, len(WINDOW.columns)), -1.0)]  # of a call before, not yet taken
    moving.advance(times, times[-1])
    earlier, *rows = moving.take_records()["companion"]
    assert set(earlier) == {-1.0}
    rows = np.array(rows)
    before = rows[rows[:, PLACE["begin"]] < 0.019]
    assert len(set(before[:, PLACE["tolerance"]])) == 1  # of one pass, however often it was done
    assert moving.costs()["ball_steps"] > (2.0 if retaken else 1.0) * point.steps


@pytest.mark.parametrize(("case", "tolerance"), [("jump, six balls", 1e-2), ("loose, jump deeper", 0.06)])
def test_what_balls_that_fly_are_off_is_found_and_mended(case, tolerance, monkeypatch):
    """All that a jump throws are followed; one that hops where it should roll, and comes late, is seen taking off."""
    monkeypatch.setattr(measured, "LIKE_MEASURED", (30.0, 1.0))  # runs begin rough
    point = judge(case, METHOD, tolerance, 0.0)
    assert point.kept
    assert point.watched_steps > point.steps
    assert point.friction_estimate > 0.1 * point.friction_error


def test_a_ball_that_slides_at_first_is_looked_at_whatever_points_more_later(monkeypatch):
    """Its friction is off by 3.6e-4 before it rolls, and later windows show a tenth of that."""
    case = "rest, rough, off centre", METHOD, 1e-3, 0.0
    point = judge(*case)
    assert point.told == "done"
    assert point.kept
    assert all(1.0 / 3.0 < ratio < 5.0 for ratio in point.ratios)
    monkeypatch.setattr(looking, "AT_FIRST", 0.0)
    assert judge(*case).ratios[1] < 0.1
    # Where none slides at first nothing more is looked at.
    rolls = reported("bearing_6203", "run.duration=0.04").report.costs
    monkeypatch.undo()
    assert reported("bearing_6203", "run.duration=0.04").report.costs == rolls


def test_balls_that_roll_on_after_a_jump_are_looked_at_whatever_pointed_to_the_jump():
    """In an even cage, at a tolerance of 0.1: the jump's own window shows a twelfth of what friction is off later."""
    point = judge("even cage, jump", METHOD, 0.1, 0.0)
    assert all(1.0 / 3.0 < ratio < 3.0 for ratio in point.ratios)
    assert point.kept


def test_a_ball_that_bounces_after_a_jump_names_its_horizon(monkeypatch):
    monkeypatch.setattr(redoing, "RETAKEN", 0)  # done again, the run may be exact enough to have none
    jump = "drive.change.offset=[2e-6,-6e-6,1e-6]"
    report = reported("bearing_6203_sudden", "run.duration=0.04", jump, "wanted.tolerance=0.1").report
    assert report.status.startswith("doubtful")
    assert "only statistics of many runs hold" in report.errors["errors_unknown"]["horizon"]
    assert any("moves that instant on" in flag for flag in report.flags)
    assert "horizon" not in reported("bearing_6203", "run.duration=0.04").report.errors["errors_unknown"]


def test_what_errors_follow_from_does_not_depend_on_how_outputs_are_cut():
    """To the bit, for one block of many outputs and for stretches of 50, also from the middle of one on."""
    scene = made_up_scene()
    for first in (0, 130):
        block, found = made_up_block(scene, 330, first), []
        block.values["normal_load"][:] *= np.linspace(0.1, 1.0, 330)[:, None, None]
        windows = np.ones((30, len(WINDOW.columns)))
        windows[:, 0] = np.linspace(1e-9 * block.time_ns[0], 1e-9 * block.time_ns[-1], 30)
        block = dataclasses.replace(block, records={WINDOW.name: windows})
        for length in (50, 10**9):
            doubt = BearingDoubt(scene.parameters, a_choice())
            doubt.growth.add = lambda row, greatest, seen=(seen := []): seen.append((row[0], greatest))
            for piece in cut(block, length):
                doubt.add(piece)
            assert len(seen) == doubt.worst.windows == 30
            sums = (*doubt.load.flat, *doubt.curvatures.flat, *doubt.rubbed.flat)
            found.append((doubt.outputs, doubt.least, *sums, *seen))
        assert found[0] == found[1]
        assert found[0][1] == block.values["normal_load"].min()


def test_balls_that_stand_have_no_speed_and_raise_no_doubt():
    report = reported("bearing_6203_step_load", "run.duration=0.02").report
    for key in ("cage_speed_rad_s", "roll_rate_rad_s"):
        assert report.figures[key] == report.errors[f"{key}_error"] == 0.0
    assert not report.flags
    parameters = load_scene("bearing_6203").parameters
    assert (turning(parameters, 1e-9), turning(parameters, -1e-12)) == (1e-9, 0.0)
    assert math.isnan(turning(parameters, math.nan))


@pytest.mark.parametrize("speed", [1e-320, -1e-300, 0.0])
def test_a_ring_that_as_good_as_stands_has_no_torque_over_its_angle(speed, recwarn):
    """A commanded speed may be any number: its quotients went beyond all numbers, with a warning of the program's."""
    errors = reported("bearing_6203", f"drive.speed={speed}", "run.duration=2e-3").report.errors
    assert "friction_model" not in errors["errors_by_source"].get("drive_torque_nm", {})
    assert [str(one.message) for one in recwarn if one.category is RuntimeWarning] == []


def test_what_a_friction_model_does_to_the_motion_is_said_to_be_unknown():
    """Balls of an angular contact bearing turn about axes that drilling sets: pade1 rolls them some per cent slower."""
    thrust = ["drive.offset=[0.0,0.0,3.4e-4]", "drive.speed=100.0", "gravity=[0.0,0.0,0.0]", "run.duration=0.1"]
    fine, rough = (
        reported("7210B", *thrust, f"contact.friction={friction}", "contact.friction_regularisation=1e-4").report
        for friction in ("spot_fine", "pade1")
    )
    off = abs(rough.figures["roll_rate_rad_s"] - fine.figures["roll_rate_rad_s"])
    assert off > 0.01 * fine.figures["roll_rate_rad_s"] > rough.errors["roll_rate_rad_s_error"]
    for report, name in ((fine, "spot_fine"), (rough, "pade1")):
        told = report.errors["errors_unknown"]["friction_model"]
        assert told.startswith(f"errors hold torque and loss that contact.friction: {name} errs by")
        assert "as in roll rates" in told
