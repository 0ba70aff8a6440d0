"""Kinds beside the bearing choose by charted rows: error, cost and runner-up are those of the tables."""

import math

import pytest

from bearing_twin.kinds import charted
from bearing_twin.kinds.charted import (
    BODIES,
    EVEN_SHAFT,
    HURRIED_SHAFT,
    KNOCKED_SHAFT,
    UNEVEN_SHAFT,
    Charted,
    evaluations_of,
    in_words,
    predicted,
    row_of,
    runner_up,
)
from bearing_twin.run.fidelity import choose
from bearing_twin.run.foretold import KEY, WORDS
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

ROWS = (
    Charted("p", "a", 1e-2, 1e-3, 1.0, 10.0),
    Charted("p", "a", 1e-6, 1e-7, 2.0, 40.0),
    Charted("p", "b", 1e-3, 1e-5, 3.0, 70.0),
    Charted("p", "b", 1e-6, 1e-8, 9.0, 90.0),
    Charted("p", "c", 1e-6, 1e-2, 0.1, 1.0),
)


@pytest.fixture
def rows(monkeypatch):
    monkeypatch.setattr(charted, "charted", lambda table, problem: ROWS)
    return ROWS


@pytest.mark.parametrize(("setting", "place"), [(1.0, 0), (1e-3, 0), (1e-5, 1), (1e-12, 1)])
def test_the_row_is_that_of_the_nearest_setting(rows, setting, place):
    assert row_of("t", "p", "a", setting) == rows[place]
    assert row_of("t", "p", "d", setting) is None


@pytest.mark.parametrize(
    ("own", "wanted", "same", "place"),
    [
        (0, 1e-4, (), 2),  # the row itself errs by 1e-3: so may others
        (1, 1e-6, (), 3),
        (1, 1e-4, (), 2),
        (1, 1e-1, (), 4),
        (1, 1e-1, ("c",), 2),
        (1, 1e-12, (), 3),
    ],
)
def test_the_runner_up_is_the_cheapest_of_another_method_that_is_good_enough(rows, own, wanted, same, place):
    assert runner_up("t", rows[own], wanted, same) == rows[place]


def test_the_sentence_names_the_row_and_its_runner_up_and_their_ratio(rows):
    assert in_words("t", rows[1], 1e-6) == (
        "its forces were off by 1e-07 where measured (p, at 1e-06); next came b at 1e-06 at 4.5 times its cost"
    )
    assert in_words("t", rows[1], 1e-1).endswith("c at 1e-06 takes 0.05 times its cost")
    assert in_words("t", rows[2], 1e-1, same=("c",)).endswith("a at 0.01 takes 0.33 times its cost")
    assert in_words("t", rows[1]._replace(seconds=8.0), 1e-6).endswith("b at 1e-06 cost the same")
    assert in_words("t", rows[3], 1e-9, same=("a", "c")).endswith("no other method measured there kept 1e-09")
    assert in_words("t", None, 1e-6) == ""
    assert predicted(None) is None


RUNS = [
    ("two_spheres", (), "pairs"),
    ("two_spheres", ("contact.restitution=0.7", "wanted.tolerance=1e-6", "wanted.outputs=history"), "pairs"),
    ("two_discs", ("wanted.tolerance=1e-5",), "pairs"),
    ("two_spheres", ("solver.stepper=dop853", "wanted.tolerance=1e-4"), "pairs"),
    ("two_discs", ("solver.stepper=dop853",), "pairs"),
    ("sphere_on_beam", (), "beams"),
    ("sphere_on_beam_drop_50mm", ("wanted.tolerance=1e-3",), "beams"),
    ("sphere_on_beam_drop_600mm_shear", (), "beams"),
    ("shaft_two_6203", ("drive.speed=150",), "motions"),
    ("shaft_two_6203", ("shaft.start=equilibrium", "run.duration=0.1"), "motions"),
    ("shaft_angular_pair", ("wanted.tolerance=1e-4", "drive.speed=800"), "motions"),
    ("shaft_step_load", ("shaft.mass=3",), "motions"),
    ("shaft_two_6203", ("drive.change={time: 0.05, speed: 80}", "wanted.tolerance=1e-4"), "motions"),
    ("ellipsoid_tumbling", ("wanted.tolerance=1e-4",), "motions"),
    ("ellipsoid_tumbling", ("body.semi_axes=[0.01,0.02,0.05]",), "motions"),
    ("ellipsoid_on_plane", (), "motions"),
    ("soft_discs_mean", ("wanted.tolerance=0.01",), "discs"),
    ("soft_discs_fast", ("wanted.tolerance=0.02",), "discs"),
]


@pytest.mark.parametrize(("scene", "overrides", "table"), RUNS)
def test_what_is_foretold_is_in_the_table_and_taken_within_a_factor_of_three(scene, overrides, table):
    run = Run(load_scene(scene, overrides))
    for _ in run.blocks():
        pass
    told, row = run.report.errors[KEY], run.choice.predicted
    [output] = [key for key in row if key.endswith("_error")]
    assert any(one.error == row[output] or table == "discs" for one in charted.charted(table, row["motion"]))
    assert row["cost"] in [one.seconds for one in charted.charted(table, row["motion"])]
    assert told["taken"] == run.report.costs[told["counted"]]
    assert told["counted"] in WORDS
    assert 1.0 / 3.0 <= told["ratio"] <= 3.0
    assert "where measured" in run.report.choice_reason
    promised = run.report.errors["wanted_errors"].get(f"{output.removesuffix('_error')}s")
    assert promised is None or promised["predicted"] == row[output]


@pytest.mark.parametrize(
    ("scene", "key"),
    [
        ("two_spheres", "solver.stepper=rk4"),
        ("two_discs", "solver.stepper=symplectic_euler"),
        ("sphere_on_beam", "solver.stepper=modes"),
        ("sphere_on_beam", "solver.modes=15"),
    ],
)
def test_of_fixed_steps_and_of_a_beam_whose_method_is_asked_for_nothing_is_foretold(scene, key):
    assert choose(load_scene(scene, [key])).predicted is None
    assert choose(load_scene(scene)).predicted is not None


def test_of_a_body_that_stays_in_contact_it_is_said_that_no_row_is():
    run = Run(load_scene("ellipsoid_rocking", ("run.duration=0.3",)))
    for _ in run.blocks():
        pass
    told = run.report.errors[KEY]
    assert told["predicted"] == pytest.approx(run.choice.predicted["a_touch"] * run.report.costs["touches"])
    assert told["ratio"] > 3.0
    assert "it stays in contact, of which no table has a row" in told["reason"]


@pytest.mark.parametrize(
    ("words", "motion"),
    [
        (("shaft_two_6203",), EVEN_SHAFT),
        (("shaft_angular_pair",), UNEVEN_SHAFT),
        (("shaft_two_6203", "shaft.start=equilibrium"), KNOCKED_SHAFT),
        (("shaft_two_6203", "drive.change={time: 0.02, speed: 50}"), HURRIED_SHAFT),
    ],
)
def test_a_shaft_is_like_the_motions_that_it_has(words, motion):
    assert choose(load_scene(words[0], words[1:])).predicted["motion"] == motion


def test_of_a_body_that_bounces_by_fixed_steps_it_is_said_that_no_row_is():
    choice = choose(load_scene("ellipsoid_tumbling", ["solver.stepper=rk4"]))
    assert choice.predicted is None
    assert "nothing is foretold of it, as no table has a row of a body that bounces by it" in choice.reason


@pytest.mark.parametrize("scene", ["two_bodies_groove", "two_bodies_superellipsoid"])
def test_bodies_that_meet_again_and_again_name_a_row_and_foretell_no_cost(scene):
    choice = choose(load_scene(scene))
    assert choice.predicted is None
    assert "its forces were off by" in choice.reason
    assert "next came" in choice.reason or "cost the same" in choice.reason


def test_rows_are_finite():
    for table, problems in {
        "pairs": ("elastic spheres", "spheres, restitution 0.8", "discs, line contact", "ellipsoid on a plane"),
        "beams": ("1 cm/s, one contact", "drop of 600 mm"),
        "two_bodies": ("ball in a groove",),
        "discs": ("mesh",),
        "motions": BODIES,
    }.items():
        for problem in problems:
            rows = charted.charted(table, problem)
            assert len(rows) >= 5
            assert table != "motions" or all(number >= 0.0 for row in rows for number in evaluations_of(row))
            assert all(math.isfinite(number) for row in rows for number in row[2:])
