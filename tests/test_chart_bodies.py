"""The chart of all other kinds: every wanted output judged in its own norm, from samples and figures."""

import math

import numpy as np
import pytest

from bearing_twin.charts import bodies
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.table import DONE
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import load_scene, scene_names

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")


def outcome(**values):
    return bodies.Judged(None, {name: np.array(one) for name, one in values.items()})


def test_every_shipped_scene_takes_part_in_this_chart_or_in_that_of_bearings():
    """But two discs, whose law of line contact a truth would share."""
    others = {name for name in scene_names() if load_scene(name).kind != "bearing"}
    assert {*bodies.SCENES, "two_discs"} == others
    shipped = {name for name, kind in KINDS.items() if kind.home.startswith("bearing_twin.")}  # not those of tests
    kinds = {bodies.kind_of_case(case) for case in bodies.CASES}
    assert kinds == {*bodies.TRUTHS} == shipped - {"bearing", "two_discs"}


def test_variants_are_legal_and_unlike_the_scenes_that_ship():
    for scene, *differs in bodies.VARIANTS.values():
        assert load_scene(scene, differs).parameters != load_scene(scene).parameters


def test_errors_are_in_the_norm_of_each_output():
    found, exact = outcome(peaks=[1.1, 2.0], forces=[[0.0], [3.0]]), outcome(peaks=[1.0, 2.0], forces=[[0.0], [4.0]])
    assert bodies.apart("sphere_on_beam", found, exact) == pytest.approx(0.25)
    found, exact = outcome(forces=[[3.0], [3.0], [0.0]]), outcome(forces=[[4.0], [3.0], [0.0]])
    assert bodies.apart("soft_discs", found, exact) == pytest.approx(0.2)
    assert bodies.apart("sphere_on_beam", found, exact) == pytest.approx(0.25)


def test_contacts_count_up_to_a_horizon_and_one_that_is_missing_is_off_by_all():
    exact = outcome(contacts=[[10.0, 1.0, 0.1], [4.0, 0.5, 0.2]])
    late = outcome(contacts=[[10.5, 1.0, 0.1], [9.0, 0.5, 0.2]])
    assert bodies.apart("two_bodies", late, exact) == pytest.approx(0.5)
    assert bodies.apart("two_bodies", late, exact, until=0.15) == pytest.approx(0.05)
    assert bodies.apart("two_bodies", outcome(contacts=[[10.0, 1.0, 0.1]]), exact) == pytest.approx(0.5)
    assert math.isinf(bodies.apart("two_bodies", exact, outcome(contacts=np.zeros((0, 3)))))
    grazed = outcome(contacts=[[10.0, 1.0, 0.1], [1e-7, 1e-9, 0.15], [4.0, 0.5, 0.2]])  # which shifts no other
    assert bodies.apart("two_bodies", grazed, exact) == pytest.approx(1e-8)
    assert bodies.apart("two_bodies", exact, exact, until=0.0) == 0.0


def test_runs_are_judged_beside_the_truth_and_read(tmp_path):
    asked = Asked(["spheres that lose speed", "shaft, slow"], lambda share: None, 0, 0.0, Kept(None))
    made = bodies.CONTESTS["bodies"].make(tmp_path, "bodies", asked)
    assert len(made.rows) == 18
    assert all(row.status == row.told == DONE and row.kept for row in made.rows)
    assert any(row.ratios for row in made.rows)
    assert "wanted.outputs=peaks" in made.rows[6].command
    assert made.reading[0].startswith("Variants: the error is within the tolerance in 18 of 18 runs; of runs that call")
    assert made.reading == bodies.CONTESTS["bodies"].read(tmp_path, "bodies")
    lost = [row.but(load_error=0.5, told="doubtful") if row.setting == 1e-2 else row for row in made.rows]
    said = list(bodies.reading(lost))
    assert "within the tolerance in 15 of 18" in said[0]
    assert said[-1].startswith("Variants: 3 err by more than is wanted (spheres that lose speed, shaft, slow); 3 of")
