"""The chart of draws: scenes drawn by chance are legal, the same everywhere, and judged as those of other charts."""

import pytest

from bearing_twin.charts import drawn
from bearing_twin.charts.bearing_variants import ALL_CASES, DRAWN, FIRST_DRAWN, SPAN
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.drawn import CONTESTS, FIRST, NAMES
from bearing_twin.charts.draws import HELD, LOADED, TOLERANCES, draw_of
from bearing_twin.charts.table import DONE
from bearing_twin.charts.tolerance import ToleranceRow
from bearing_twin.run.scene import load_scene

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")


def test_draws_are_legal_scenes_and_unlike_each_other():
    draws = [draw_of(FIRST + number) for number in range(60)]
    for scene, differs, wanted, tolerance in draws:
        read = load_scene(scene, (*differs, *wanted, f"wanted.tolerance={tolerance}")).parameters
        assert read.contact.friction_coefficient > 0.0
        assert read.run.duration <= 0.04
    assert len({differs for _, differs, *_ in draws}) == 60
    assert {scene for scene, *_ in draws} == {*HELD, *LOADED}
    assert {tolerance for *_, tolerance in draws} == set(TOLERANCES)
    assert 5 < sum(bool(wanted) for _, _, wanted, _ in draws) < 35


def test_a_draw_is_the_same_everywhere():
    """By Python's generator of random numbers, whose sequence is kept from version to version."""
    scene, differs, wanted, tolerance = draw_of(1)
    assert (scene, wanted, tolerance) == ("bearing_6203_guided_cage", (), 0.001)
    assert differs == (
        "geometry.radial_clearance=1.626e-05",
        "drive.speed=29.99",
        "contact.friction_coefficient=0.1531",
        "contact.friction_regularisation=0.03946",
        "rings.inner.load=[267.2, 32.43, 0]",
        "model.dimension=free",
        "run.duration=0.01",
        "run.output_rate=1000",
        "run.publish_rate=1000",
    )


def test_the_chart_of_tolerances_has_draws_that_no_other_chart_has():
    """As long as its other variants; at all its tolerances, whatever the draw wants."""
    assert len(DRAWN) >= 20
    assert not set(range(FIRST, FIRST + len(NAMES))) & set(range(FIRST_DRAWN, FIRST_DRAWN + len(DRAWN)))
    for name, (scene, differs) in DRAWN.items():
        assert ALL_CASES[name] == (scene, differs)
        assert load_scene(scene, differs).parameters.run.duration == SPAN


def test_draws_are_run_beside_the_truth(tmp_path):
    asked = Asked(NAMES[:3], lambda share: None, 0, 0.0, Kept(None))
    made = CONTESTS["drawn"].make(tmp_path, "drawn", asked)
    assert [row.problem for row in made.rows] == list(NAMES[:3])
    assert all(row.status == DONE for row in made.rows)
    assert all(row.setting in TOLERANCES for row in made.rows)
    assert "wanted.tolerance=" in made.rows[0].command
    assert (tmp_path / "drawn.png").is_file()
    assert made.reading == CONTESTS["drawn"].read(tmp_path, "drawn")


def test_what_is_said_of_draws_counts_them():
    def row(number, error, told, estimate):
        columns = {
            "load_error": error,
            "friction_error": error,
            "load_estimate": estimate,
            "friction_estimate": estimate,
        }
        steps = {"watched_steps": 100, "companion_steps": 20}
        return ToleranceRow(NAMES[number], "as chosen", 1e-2, status=DONE, told=told, **columns, **steps)

    rows = [row(0, 1e-3, "done", 2e-3), row(1, 2e-2, "done", 1e-3), row(2, 3e-2, "doubtful: loads", 2e-2)]
    said = list(drawn.reading([*rows, ToleranceRow(NAMES[3], "as chosen", 1e-2, status="refused", reason="no")]))
    assert said[0] == "Of 4 draws 1 did not run: no."
    assert "within the tolerance in 1 of 3 draws" in said[1]
    assert "done 1 of 2" in said[1]
    assert said[2] == "unsaid are draw 2 at 0.01, 0.02."
    assert "in 4 of 6" in said[3]
    assert "takes 20 % of a run's steps as a median" in said[4]


def test_a_draw_is_judged_with_all_that_it_draws(monkeypatch):
    """The scene, what differs in it and what is wanted, at the tolerance asked for."""
    seen = []
    monkeypatch.setattr(drawn, "beside_truth", lambda row, scene, wanted, limit: seen.append((row, scene, wanted)))
    for number in range(1, 12):
        drawn.judge(f"draw {number}", "method", 0.25, 0.0)
        scene, differs, wanted, _ = draw_of(FIRST + number - 1)
        row, words, also = seen[-1]
        assert (words, also) == ((scene, *differs), wanted)
        assert row.setting == 0.25
        assert all(word in row.command for word in (scene, *wanted, "wanted.tolerance=0.25"))
    assert any(wanted for *_, wanted in seen)
