"""The model of a running scene looked at again after commands: switched without a jump of loads, told, and recorded."""

import json
from types import SimpleNamespace

import made_up_costs
import numpy as np
import pytest
from made_up_run import a_choice, made_up_block

from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing import choices, rechoice
from bearing_twin.kinds.bearing.choices import CHOICE, GREATEST_JUMP, Switch, Switches, switches_of
from bearing_twin.kinds.bearing.models import choose
from bearing_twin.kinds.bearing.quasi_static.running import QuasiStaticMotion
from bearing_twin.kinds.bearing.rechoice import _going_on, scene_now
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, dimension_of
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.log import cdr
from bearing_twin.log.mcap_log import LogWriter, choice_record, raw_messages, read_log
from bearing_twin.log.stream import MessageStream
from bearing_twin.nodes.simulation_loop import SimulationLoop
from bearing_twin.report import Rechosen
from bearing_twin.run.failure import Failure
from bearing_twin.run.looks import APART_NS, Looks
from bearing_twin.run.report_of import report_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

pytestmark = pytest.mark.usefixtures("made_up_costs")  # by which another stepper is chosen at FAST

SOON = "drive.acceleration=50000.0"  # rad/s^2: commanded speeds are reached within some hundredths of a second
CAGED = ("cage.kind=even", "wanted.outputs=loads", "wanted.tolerance=3e-4", SOON)  # equilibria are enough, when slow
FAST = 1500.0  # rad/s


def jump(before, after):
    """Change of loads from one block's end to the next one's begin, over the greatest load."""
    last, first = before.values["normal_load"][-1], after.values["normal_load"][0]
    return np.abs(first - last).max() / last.max()


def test_a_command_has_the_model_chosen_anew_and_loads_do_not_jump():
    simulation = Simulation(load_scene("bearing_6203", (SOON, "run.output_rate=1e4")))
    begun, before = (simulation.choice.stepper, simulation.choice.setting), simulation.advance(101)
    simulation.set_speed(FAST)
    block = simulation.advance(100)
    [switch] = switches_of(block.records[CHOICE.name])
    assert begun == (switch.before, 0.03) == ("rodas4", 0.03)
    assert (switch.time, switch.speed, switch.goal) == (pytest.approx(1e-2), pytest.approx(183.26), FAST)
    assert (
        (simulation.choice.stepper, simulation.choice.setting) == (switch.stepper, switch.setting) == ("rodas3", 0.005)
    )
    assert "most like this one (fast)" in simulation.choice.reason
    assert "told to go from 183.26 to 1500 rad/s; loads jumped by 0 %" in simulation.switched
    assert switch.taken
    assert jump(before, block) < GREATEST_JUMP
    simulation.advance(400)
    simulation.set_speed(183.26)
    simulation.advance(1500)  # once it is slow again, what was chosen for that is taken again
    assert (simulation.choice.stepper, simulation.choice.setting) == begun
    report = simulation.report()
    assert report.stepper == "rodas4"
    assert report.choice_reason.endswith("(the last of 2 times)")
    assert not [flag for flag in report.flags if "would have" in flag]
    simulation.reset()
    assert np.array_equal(simulation.advance(101).values["normal_load"], before.values["normal_load"])
    assert simulation.switched == ""


def test_what_nobody_commanded_is_not_looked_at_again(monkeypatch):
    monkeypatch.setattr("bearing_twin.kinds.bearing.rechoice.rechosen", lambda *given: pytest.fail("looked"))
    simulation = Simulation(load_scene("bearing_6203"))
    simulation.advance(100)
    assert simulation.choice is simulation.chosen


def test_balls_go_on_from_equilibria_and_back_and_their_energy_adds_up():
    simulation = Simulation(load_scene("bearing_6203", (*CAGED, "run.output_rate=1000.0", "solver.stepper=rodas4")))
    assert simulation.choice.stepper == QUASI_STATIC
    simulation.advance(21)
    costs = [simulation.report().costs]
    simulation.set_speed(3000.0)
    up = simulation.advance(100)
    costs.append(simulation.report().costs)
    simulation.set_speed(183.26)
    down = simulation.advance(200)
    first, second = (switches_of(block.records[CHOICE.name])[-1] for block in (up, down))
    assert (first.before, first.stepper) == (QUASI_STATIC, "rodas4")
    assert (second.before, second.stepper) == ("rodas4", QUASI_STATIC)
    assert max(first.jump, second.jump) < 1e-3
    assert isinstance(simulation._motion, QuasiStaticMotion)
    report = simulation.report()
    assert abs(report.figures["energy_closure"]) < 1e-6
    assert report.costs["equilibria"] > costs[1]["equilibria"] > 0  # what was computed ahead and taken back apart
    assert report.costs["ball_steps"] >= costs[1]["ball_steps"] > 0 == costs[0].get("ball_steps", 0)
    assert report.costs["companion_ball_steps"] >= costs[1]["companion_ball_steps"] > 0
    assert report.figures["inner_ring_speed_at_end_rad_s"] == pytest.approx(183.26)
    assert "drive_torque_nm" not in report.figures  # equilibria lose nothing, so that no mean over both means anything
    for block in (up, down):
        assert np.abs(np.diff(block.values["orbit_angle"], axis=0)).max() < 2.0  # rad a millisecond: nothing leaps
        assert np.linalg.norm(block.values["orientation"], axis=-1) == pytest.approx(1.0)
    assert np.diff(np.concatenate([up.values["dissipated"], down.values["dissipated"]])).min() >= 0.0


@pytest.mark.parametrize("dimensions", [("prescribed", "quasi_static"), ("quasi_static", "prescribed")])
def test_a_change_of_the_drive_at_the_instant_of_a_switch_still_comes(dimensions, monkeypatch):
    changes = ("drive.change.time=0.02", "drive.change.speed=-50.0", "drive.speed=183.26", *CAGED)
    before, after = (load_scene("bearing_6203", (f"model.dimension={one}", *changes)) for one in dimensions)
    chosen = choose(before.parameters)
    motion = rechoice.moving_by(before.parameters, chosen)
    motion.advance(np.array([0.02]), 0.02)
    monkeypatch.setattr(rechoice, "choose", lambda parameters: choose(after.parameters))
    found = rechoice.rechosen(before.parameters, chosen, motion, (None, None))
    assert found.motion is not motion
    assert found.motion.advance(np.array([0.02]), 0.02).inner_ring_speed[-1] == pytest.approx(133.26)


def test_where_no_model_can_be_chosen_the_one_in_use_stays_and_its_reason_does_not_grow(monkeypatch):
    simulation = Simulation(load_scene("bearing_6203", (SOON,)))
    simulation.advance(11)

    def refused(parameters):
        raise SceneError("there is no balance")

    monkeypatch.setattr(rechoice, "choose", refused)
    begun = simulation.choice
    for speed in (FAST, 500.0):
        simulation.set_speed(speed)
        simulation.advance(1200)
        assert simulation.choice is begun
        assert simulation.switched.endswith(
            "rodas4 stayed, because no other model could be chosen: there is no balance"
        )


def test_windows_of_a_companion_are_not_lost_to_a_switch_that_is_refused(monkeypatch):
    for greatest in (-1.0, 1.0):
        monkeypatch.setattr(choices, "GREATEST_JUMP", greatest)
        scene = load_scene("bearing_6203", (SOON, "run.output_rate=1e4"))
        motion = rechoice.moving_by(scene.parameters, Simulation(scene).choice)
        motion.advance(np.array([1e-2]), 1e-2)
        kept = len(motion._rows)
        motion.goal_speed = FAST
        found = rechoice.rechosen(scene.parameters, Simulation(scene).choice, motion, (None, None))
        assert (found.motion is motion) == (greatest < 0.0)
        assert len(found.motion._rows) == kept > 0


def test_a_model_whose_loads_would_jump_is_not_taken_which_is_said(monkeypatch):
    monkeypatch.setattr(choices, "GREATEST_JUMP", -1.0)
    simulation = Simulation(load_scene("bearing_6203", (SOON,)))
    simulation.advance(11)
    simulation.set_speed(FAST)
    block = simulation.advance(10)
    assert (simulation.choice.stepper, simulation.choice.setting) == ("rodas4", 0.03)
    assert len(block.records[CHOICE.name]) == 1
    [flag] = (flag for flag in simulation.report().flags if "would have been taken" in flag)
    assert "so rodas4 stayed" in flag
    assert flag == simulation.switched


def test_what_is_pinned_is_judged_and_stays():
    simulation = Simulation(load_scene("bearing_6203", ("solver.stepper=rodas3", "wanted.tolerance=1e-4", SOON)))
    assert "rodas3, as the scene asks: it was off by" in simulation.choice.reason
    assert "(settled)" in simulation.choice.reason
    simulation.advance(11)
    simulation.set_speed(FAST)
    assert not simulation.advance(10).records.get(CHOICE.name, ())
    assert simulation.choice.stepper == "rodas3"
    assert "(fast)" in simulation.choice.reason


@pytest.mark.parametrize(("share", "warned"), [(0.99, False), (1.01, True)])
def test_a_stepper_that_is_asked_for_and_missed_when_measured_is_warned_of(share, warned, monkeypatch):
    monkeypatch.setitem(made_up_costs.ERRS, "rodas3", share)
    ladders = made_up_costs.made_up_ladders(rodas3={})
    monkeypatch.setattr("bearing_twin.kinds.bearing.measured.ladders", lambda: ladders)
    choice = choose(load_scene("bearing_6203_loose", ("solver.stepper=rodas3", "wanted.tolerance=1e-1")).parameters)
    told = f"off by {0.1 * share:.2g} at a tolerance of 0.1 where the motion was like this one"
    assert told in choice.reason
    assert bool([one for one in choice.warnings if f"solver.stepper = rodas3 was {told}" in one]) is warned


def test_the_scene_of_now_has_the_commanded_load_and_the_speeds_still_to_come():
    parameters = load_scene("bearing_6203_rig_400N").parameters
    now = scene_now(parameters, -20.0, True, 100.0, ((0.0, -7.0, 0.0), (0.0, 0.0, 0.0)))
    assert (now.drive.speed, now.drive.change.speed, bool(now.drive.change.time)) == (100.0, -120.0, True)
    assert now.rings.inner.load == (0.0, -7.0, 0.0)
    back = scene_now(parameters, -200.0, True, 100.0, (None, None)).drive
    assert (back.speed, back.change.speed, bool(back.change.time)) == (-200.0, 300.0, True)
    none = scene_now(parameters, -20.0, True, -20.0, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert dimension_of(none) == dimension_of(parameters)  # a ring stays free where nothing loads it any more
    assert not none.drive.change.time
    sudden = load_scene("bearing_6203_sudden").parameters
    coming, gone = (scene_now(sudden, 20.0, changed, 20.0, (None, None)) for changed in (False, True))
    assert any(coming.drive.change.offset)
    assert not any(gone.drive.change.offset)
    assert gone.drive.offset == pytest.approx(np.add(sudden.drive.offset, sudden.drive.change.offset))


def test_what_the_companion_tightened_holds_on_for_the_same_stepper_alone():
    parameters = load_scene("bearing_6203", ("solver.stepper=rodas4",)).parameters
    moving = WatchedMotion(parameters, choose(parameters))
    moving._set(0.25)
    for stepper, setting, expected in (("rodas4", 2e-3, 0.5 * 0.25), ("rodas4", 1e-5, 1.0), ("rodas3", 2e-3, 1.0)):
        wanted = choose(parameters)._replace(stepper=stepper, setting=setting)
        other = _going_on(parameters, wanted, moving, moving.first_outputs())
        assert other.setting == pytest.approx(expected), stepper


def test_looks_are_apart_and_what_was_not_given_out_is_told_again():
    looked = []

    def rechosen(parameters, choice, motion, load):
        looked.append(load)
        return Rechosen(choice, motion, told="switched", records={"choice": np.ones((1, 2))})

    looks = Looks(SimpleNamespace(rechosen=rechosen), None, a_choice(), "moving")
    for time_ns in range(0, 3 * APART_NS, APART_NS // 10):
        looks.commanded(given=True)
        looks.again(time_ns, (None, None), a_choice(), "moving")
    assert len(looked) == 3
    assert list(looks.notes()) == ["choice"]
    looks.commanded(given=False)  # the block was computed again
    assert list(looks.notes()) == ["choice"]
    looks.commanded(given=True)
    assert looks.notes() == {}
    assert looks.told == "switched"


def test_switches_are_counted_in_memory_that_does_not_grow_and_rows_of_others_are_left_out():
    switch = Switch(0.5, 100.0, 200.0, "rodas4", "rodas3", 1e-3, 0.0)
    assert switches_of(switch.row()) == [switch]
    assert switches_of(np.full((1, len(CHOICE.columns)), np.nan)) == []
    assert switches_of(np.zeros((1, 3))) == []
    tighter = switch._replace(stepper="rodas4")
    assert "on rodas4 at a tolerance of 0.001 in place of the former one, told to" in tighter.sentence()
    assert tighter._replace(jump=1.0).sentence().endswith("so the former one stayed")
    switches = Switches()
    for _ in range(50):
        switches.add(np.concatenate([switch.row(), switch._replace(jump=np.nan).row()]))
    after = switches.after(a_choice())
    assert (after.stepper, after.setting) == ("rodas3", 1e-3)
    assert after.reason.count("rodas3") == 1
    assert "the last of 50 times" in after.reason
    assert "the last of 50 times" in switches.doubt


def test_a_model_that_is_taken_before_the_first_output_is_told_with_the_scene():
    scene, told = load_scene("bearing_6203", (SOON,)), a_choice(stepper="rodas3")
    stream = MessageStream(scene, choice=a_choice())
    assert stream.adopt(told, 0) == []
    begun = stream.messages(made_up_block(scene, 3))
    assert [one[0].name for one in begun].count("scene") == 1
    assert '"rodas3"' in cdr.deserialise(cdr.STRING, begun[0][2]).data
    assert [one[0].name for one in stream.adopt(a_choice(), 10**9)] == ["scene"]


def test_a_log_tells_of_the_switch_what_its_run_told(tmp_path):
    scene, path = load_scene("bearing_6203", (SOON,)), tmp_path / "run.mcap"
    simulation = Simulation(scene)
    loop = SimulationLoop(
        simulation,
        lambda: MessageStream(scene, choice=simulation.choice),
        lambda message: None,
        "fastest",
        open_log=lambda run: LogWriter(path, scene, choice_record(simulation.choice)),
    )
    loop.paced.paused = True
    loop.step(0, 0.02)
    assert loop.look()[2]["choice_switch"] == "-"
    loop.set_speed(0, FAST)
    loop.step(0, 0.1)
    numbers = loop.look()[2]
    assert numbers["stepper"] == "rodas3"
    assert "in place of rodas4" in numbers["choice_switch"]
    loop.close()
    said, read = simulation.report(), report_of(read_log(path))[0]
    assert (read.stepper, read.choice_reason, read.status) == (said.stepper, said.choice_reason, said.status)
    assert "from 0.02 s on rodas3" in read.choice_reason
    assert (read.flags, read.errors) == (said.flags, said.errors)
    scenes = [one.data for one in raw_messages(path) if one.topic.name == "/bearing/scene"]
    told = [json.loads(cdr.deserialise(cdr.STRING, data).data)["stepper"] for data in scenes]
    assert told == ["rodas4", "rodas3"]
    assert [one.log_time for one in raw_messages(path) if one.topic.name == "/bearing/scene"] == [0, 20_000_000]


def test_a_switch_within_a_batch_is_told_at_its_instant_and_in_the_order_of_time(monkeypatch):
    monkeypatch.setattr("bearing_twin.run.looks.APART_NS", 0)
    scene = load_scene("bearing_6203", (SOON,))
    simulation = Simulation(scene)
    loop = SimulationLoop(simulation, lambda: MessageStream(scene, choice=simulation.choice), lambda message: None)
    loop._advance(11)
    simulation.set_speed(FAST)
    loop._advance(5)  # told here
    before = simulation.choice
    simulation.set_speed(183.26)
    batch = loop._advance(100)  # of several chunks: what was chosen first held until the speed was reached
    [scene_at] = [place for place, one in enumerate(batch) if one.topic == "scene"]
    assert simulation.choice != before
    assert 15_000_000 <= batch[scene_at].time_ns == simulation.looks.since_ns
    stamps = [one.time_ns for one in batch]
    assert max(stamps[:scene_at], default=0) <= simulation.looks.since_ns < min(stamps[scene_at + 1 :])


@pytest.mark.parametrize("begun", ["equilibria", "balls"])
def test_a_run_that_failed_after_a_switch_goes_on_or_says_why_not(begun):
    words = (*CAGED, "run.output_rate=1000.0") if begun == "equilibria" else (SOON, "run.output_rate=1e4")
    scene = load_scene("bearing_6203", words)
    failing = Simulation(scene)
    failing.advance(21)
    failing.set_speed(FAST if begun == "balls" else 3000.0)
    failing.advance(400)
    assert failing.choice.stepper != failing.chosen.stepper
    state = json.loads(json.dumps(failing._motion.snapshot()))
    last = failing._pending.first_sequence + len(failing._pending) - 1
    failure = Failure(scene, "made up", "", 0.0, "", "", 0.0, {}, last, state)
    other = Simulation(scene)
    if begun == "equilibria":
        with pytest.raises(SceneError, match="does not fit its scene and first model; simulate"):
            other.resume(failure)
        return
    other.resume(failure)
    failing.advance(max(1, len(failing._pending)))
    expected, found = failing.advance(20), other.advance(20)
    assert found.first_sequence == expected.first_sequence
    assert found.values["inner_ring_speed"] == pytest.approx(expected.values["inner_ring_speed"], rel=1e-9)
    loads = expected.values["normal_load"]
    assert np.abs(found.values["normal_load"] - loads).max() < scene.parameters.wanted.tolerance * loads.max()
