"""`contact.friction: auto`: the cheapest model that is exact enough, judged by runs with the finest; kept in logs."""

import re

import numpy as np
import pytest

from bearing_twin.kinds.bearing.doubt import BearingDoubt
from bearing_twin.kinds.bearing.figures import BearingFigures
from bearing_twin.kinds.bearing.friction_choice import as_chosen, chosen_friction
from bearing_twin.kinds.bearing.measured import friction_costs
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.run.failure import Failure
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.report_of import report_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

SHORT = ("run.duration=0.002", "run.output_rate=1000", "run.publish_rate=1000")


def rubbing(friction, name, *overrides):
    return load_scene(name, (f"contact.friction={friction}", *SHORT, *overrides))


@pytest.mark.parametrize(
    ("name", "tolerance", "model"),
    [
        ("bearing_6203", 0.05, "point"),
        ("bearing_6203", 1e-3, "spot"),
        ("bearing_6203_fast", 0.1, "point"),
        ("bearing_6203_fast", 0.04, "spot"),
        ("bearing_6203_fast", 0.01, "spot_medium"),
        ("bearing_6203_fast", 1e-3, "spot_fine"),
        ("bearing_6203_fast", 1e-4, "spot_fine"),
        ("bearing_6203_start", 1e-3, "spot"),
    ],
)
def test_the_cheapest_model_that_is_exact_enough_is_taken(name, tolerance, model):
    choice = choose(rubbing("auto", name, f"wanted.tolerance={tolerance}"))
    assert choice.friction == model
    assert f"friction {model}, " in choice.reason


def drilled(scene):
    """Drilling torques of the last output over mu N R, (N, 2)."""
    *_, last = simulate(scene)
    radius = 0.5 * scene.parameters.geometry.ball_diameter
    return last["drilling_torque"] / (scene.parameters.contact.friction_coefficient * last["normal_load"] * radius)


def told_in(scene):
    """What the reason of a choice says that its friction errs by."""
    return float(re.search(r"; friction .*?off by (?:at most )?(\S+) of mu N", choose(scene).reason)[1])


@pytest.mark.parametrize(("name", "tolerance"), [("bearing_6203", 0.05), ("bearing_6203_fast", 0.1)])
def test_what_is_told_of_friction_at_a_point_is_what_a_run_with_the_finest_finds(name, tolerance):
    """Up to twice as much is told, where both raceways share the spin."""
    two = ("geometry.balls=2", f"wanted.tolerance={tolerance}")
    fine, taken = drilled(rubbing("spot_fine", name, *two)), drilled(rubbing("auto", name, *two))
    assert 0.45 * told_in(rubbing("auto", name, *two)) < float(np.abs(taken - fine).max())
    assert float(np.abs(taken - fine).max()) <= 1.1 * told_in(rubbing("auto", name, *two))


@pytest.mark.parametrize("friction", ["spot", "spot_medium"])
def test_no_rule_errs_more_than_is_told_where_balls_slide_and_spin_and_hardly_less(friction):
    """From rest at 20 000 rpm, against the finest: over mu N of each contact."""
    from_rest = ("initial.motion=rest", "geometry.balls=2", "run.duration=0.01", "run.output_rate=1e5")
    exact = ("wanted.tolerance=1e-6", "solver.stepper=rodas4", "solver.companion=off")
    forces = []
    for name in (friction, "spot_fine"):
        blocks = list(simulate(rubbing(name, "bearing_6203_fast", *from_rest, *exact)).blocks())
        loads, force = (
            np.concatenate([one.values[key] for one in blocks]) for key in ("normal_load", "friction_force")
        )
        forces.append(force / (0.08 * np.maximum(loads, 0.01 * loads.max()))[..., None])
    found = float(np.linalg.norm(forces[0] - forces[1], axis=-1).max())
    assert 0.4 * told_in(rubbing(friction, "bearing_6203_fast", *from_rest)) < found
    assert found <= told_in(rubbing(friction, "bearing_6203_fast", *from_rest))


def test_a_rule_that_the_scene_asks_for_is_kept_and_named_where_it_misses_what_is_wanted():
    choice = choose(rubbing("spot", "bearing_6203_fast"))
    (told,) = (one for one in choice.warnings if "contact.friction" in one)
    assert choice.friction == ""
    assert re.search(
        r"contact.friction = spot is off by at most \S+ of mu N.*; auto takes spot_fine, off by at most", told
    )
    for kept in (rubbing("spot", "bearing_6203_fast", "wanted.tolerance=0.05"), rubbing("spot", "bearing_6203")):
        assert not [one for one in choose(kept).warnings if "contact.friction" in one]


@pytest.mark.parametrize("overrides", [("contact.friction_coefficient=0",), ("wanted.outputs=loads",)])
def test_nothing_is_told_of_a_rule_where_spots_do_not_matter(overrides):
    choice = choose(rubbing("spot", "bearing_6203_fast", *overrides))
    assert "off by at most" not in choice.reason
    assert not [one for one in choice.warnings if "contact.friction = " in one]


def test_a_tolerance_that_no_rule_keeps_gets_the_finest_and_says_so():
    reason = choose(rubbing("auto", "bearing_6203_fast", "wanted.tolerance=1e-5")).reason
    assert "friction spot_fine, because none is within the wanted 1e-05: off by at most" in reason


@pytest.mark.parametrize(
    ("overrides", "why"),
    [
        (["wanted.outputs=loads", "drive.offset=[0, 0, 1e-5]", "gravity=[0, 0, 0]"], "loads alone are wanted"),
        (["contact.friction_coefficient=0"], "contact.friction_coefficient is 0"),
        (["drive.tilt=[1e-4, 0]", "model.dimension=prescribed"], "no other is built for a ring that tilts or moves"),
        (["geometry.inner_conformity=0.5004"], "errors over spots narrower than b/a = 0.03 are not known"),
    ],
)
def test_where_no_spot_is_looked_at_the_reason_says_why(overrides, why):
    choice = choose(rubbing("auto", "bearing_6203", *overrides))
    assert choice.friction == "point"
    assert choice.reason.endswith(f"friction at a point, because {why}")


def test_equilibria_hold_no_friction_whatever_is_asked():
    choice = choose(rubbing("auto", "bearing_218_thrust"))
    assert (choice.stepper, choice.friction) == ("quasi_static", "")


def test_a_change_of_the_drive_is_looked_at_before():
    """At 20 rad/s, spots spin below what friction is smoothed over; not at the speed that comes."""
    slow = ("drive.speed=20", "wanted.tolerance=1e-3", "gravity=[0, 0, 0]", "drive.acceleration=1e5")
    assert choose(rubbing("auto", "bearing_6203", *slow)).friction == "point"
    change = ("drive.change.time=0.001", "drive.change.speed=2000")
    assert choose(rubbing("auto", "bearing_6203", *slow, *change)).friction == "spot_medium"


def test_costs_are_those_measured_at_the_nearest_tolerance():
    costs = friction_costs(load_scene("bearing_6203", ("wanted.tolerance=1e-3",)).parameters)
    assert costs["point"] == 1.0
    assert 1.0 < costs["spot"] < 5.0 < costs["spot_fine"]


@pytest.mark.parametrize(
    ("spot", "model", "closer"),
    [(0.9, "spot", "spot_medium"), (1.3, "spot", "spot_fine"), (1.4, "spot_medium", "spot_fine")],
)
def test_of_models_whose_costs_no_measurement_tells_apart_the_first_of_their_table_is_taken(
    spot, model, closer, monkeypatch
):
    """Within 0.04 are `spot` and `spot_medium`, which costs 1; `point` would cost less."""
    costs = {"point": 0.5, "spot": spot, "spot_medium": 1.0, "spot_fine": 9.0, "pade1": 0.5, "pade2": 1.0}
    monkeypatch.setattr("bearing_twin.kinds.bearing.friction_choice.friction_costs", lambda parameters: costs)
    chosen = chosen_friction.__wrapped__(rubbing("auto", "bearing_6203_fast", "wanted.tolerance=0.04").parameters)
    assert chosen.name == model
    assert "; point would be off by" in chosen.reason
    assert chosen.reason.endswith(f"; {closer} would cost {costs[closer] / costs[model]:.2g} times as much")


def test_a_log_keeps_what_was_chosen_and_its_report_is_that_of_the_run(tmp_path):
    scene, log = rubbing("auto", "bearing_6203"), tmp_path / "auto.mcap"
    run = simulate(scene)
    write_log(run, log)
    kept = read_log(log)
    assert kept.choice.friction == run.choice.friction == "spot"
    assert kept.scene.parameters.contact.friction == "auto"
    told, _ = report_of(kept)
    assert (told.figures, told.errors) == (run.report.figures, run.report.errors)
    same = simulate(rubbing("spot", "bearing_6203"))
    list(same.blocks())
    assert same.report.figures == run.report.figures


def test_a_log_that_names_no_model_there_is_gets_the_one_chosen_now():
    scene = rubbing("auto", "bearing_6203")
    choice = choose(scene)
    for name in ("", "hay"):
        assert as_chosen(scene.parameters, choice._replace(friction=name)).contact.friction == "spot"
    assert as_chosen(scene.parameters, choice._replace(friction="pade1")).contact.friction == "pade1"


@pytest.mark.usefixtures("made_up_costs")
def test_what_a_run_began_with_stays_where_its_model_is_chosen_anew():
    """Balls that go on rub as they did, though a scene that began at the new speed would have another model."""
    asked = ("wanted.tolerance=0.02", "run.output_rate=1e4", "drive.acceleration=1e5")
    assert choose(rubbing("auto", "bearing_6203", *asked, "drive.speed=1500")).friction == "spot"
    simulation = Simulation(rubbing("auto", "bearing_6203", *asked))
    begun = simulation.choice
    simulation.advance(11)
    simulation.set_speed(1500.0)
    simulation.advance(5)
    assert simulation.choice.stepper != begun.stepper
    assert simulation.choice.friction == begun.friction == "point"


def test_all_who_ask_get_the_same_scene():
    """Interim reports copy the writers of a run, but not the scene that they share."""
    scene = rubbing("auto", "bearing_6203")
    choice = choose(scene)
    one, other = (writer(scene.parameters, choice).parameters for writer in (BearingFigures, BearingDoubt))
    assert one is other
    assert one.contact.friction == choice.friction


def test_a_failed_run_goes_on_with_the_friction_that_it_had():
    """At a tenth of 0.05 `auto` would take `spot`."""
    failed = Failure(rubbing("auto", "bearing_6203", "wanted.tolerance=0.05"), "", "", 0.0, "", "", 0.0, {}, -1, None)
    assert failed.tightened().parameters.contact.friction == "point"
    assert failed.tightened().parameters.wanted.tolerance == pytest.approx(0.005)
    pinned = failed._replace(scene=rubbing("spot", "bearing_6203"))
    assert pinned.tightened().parameters.contact.friction == "spot"
