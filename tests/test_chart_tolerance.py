"""The chart of tolerances: what it measures is what runs say, and what it reads off follows from its points."""

import math

import pytest

from bearing_twin.charts import tolerance
from bearing_twin.charts.bearing_variants import CASES
from bearing_twin.charts.companion_cost import ALONE_AT_LENGTH, AT_LENGTH, SHIPPED, at_length
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.table import DONE, FAILED, read_table
from bearing_twin.charts.tolerance import CONTESTS, LOADS_ALONE, METHOD, ToleranceRow, reading
from bearing_twin.run.doubt import SHORT_RUN
from bearing_twin.run.scene import load_scene

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")


def here(*names):
    """All in this process, without a limit."""
    return Asked(names, lambda share: None, 0, 0.0, Kept(None))


def test_every_case_is_a_scene():
    for name, overrides in CASES.values():
        assert load_scene(name, overrides).kind == "bearing"
    assert len({name for name, _ in list(CASES.values())[:7]}) == 7


def test_a_settled_bearing_is_better_than_asked_and_knows_its_errors(tmp_path, monkeypatch):
    monkeypatch.setattr(tolerance, "TOLERANCES", (1e-2,))
    made = CONTESTS["tolerance"].make(tmp_path, "tolerance", here("settled"))
    point, alone, long, long_alone = made.rows
    assert point.kept
    assert (point.status, point.told) == (DONE, "done")
    assert point.seconds > 0.0
    assert 0 < point.companion_steps < point.watched_steps
    assert all(1.0 / 3.0 < ratio < 3.0 for ratio in point.ratios)
    assert alone.kept
    assert (alone.method, alone.told) == (LOADS_ALONE, "done")
    assert alone.error == alone.load_error < point.error
    assert len(alone.ratios) == 1
    assert 1.0 / 3.0 < alone.ratios[0] < 3.0
    assert "wanted.outputs=loads" in alone.command
    assert (long.method, long.status, long.told) == (AT_LENGTH, DONE, "done")
    assert math.isnan(long.load_error)
    assert (long_alone.method, long_alone.told) == (ALONE_AT_LENGTH, "done")
    assert "wanted.outputs=loads" in long_alone.command
    assert long_alone.watched_steps <= long.watched_steps
    assert long.command.endswith("--set run.duration=2 --set wanted.tolerance=0.01")
    # What begins is the same, and what is settled needs few windows more.
    assert (
        point.companion_steps <= long.companion_steps < point.companion_steps / point.watched_steps * long.watched_steps
    )
    assert made.reading[-1].startswith("Others 10 times as long: the companion takes ")
    row, *_ = read_table(tmp_path / "tolerance.csv", ToleranceRow)
    assert row.load_error == pytest.approx(point.load_error, rel=1e-5)
    assert CONTESTS["tolerance"].read(tmp_path, "tolerance") == made.reading


def test_scenes_as_they_ship_are_counted_and_told_apart():
    assert at_length("bearing_6203_fast") == ("bearing_6203_fast", ())
    assert {load_scene(name).kind for name in SHIPPED} == {"bearing"}
    entries = list(CONTESTS["tolerance"].entries("bearing_6203_fast"))
    assert {method for method, _ in entries} == {AT_LENGTH, ALONE_AT_LENGTH}
    row = tolerance.judge("bearing_6203_fast", *entries[0], 0.0)
    assert (row.status, row.told) == (DONE, "done")
    dear = row.but(problem="sudden", companion_steps=row.watched_steps, took=f"it took 100 %: {SHORT_RUN}")
    share = 100.0 * row.companion_steps / row.watched_steps
    assert list(reading([row, dear, dear.but(took=""), row.but(watched_steps=0, companion_steps=0)])) == [
        f"Shipped scenes at their own length: the companion takes {share:.3g} % of a run's steps as a median and "
        f"{share:.3g} % at most, over 35 % in 0 of 1 runs.",
        "Others 10 times as long: the companion takes 100 % of a run's steps as a median and 100 % at most, over 35 % "
        "in 2 of 2 runs; 1 of these say what took it, 1 are short.",
    ]


LOADS = ("settled", 1e-4), ("sudden", 7e-3)


def _made(case, load, friction, *further):
    names = ("load_estimate", "friction_estimate", "told", "steps", "watched_steps", "companion_steps")
    known = dict(zip(names, further, strict=True))
    return ToleranceRow(case, METHOD, 1e-3, load, friction, 1.0, 100, DONE, **known)


def test_loads_alone_are_told_apart():
    nothing = math.nan, "done", 0, 0, 0  # equilibria have no steps
    loads = [_made(case, error, math.nan, 2e-4, *nothing).but(method=LOADS_ALONE) for case, error in LOADS]
    text = " ".join(reading(loads))
    assert text.startswith(
        "Loads alone wanted: of runs that call themselves done 1 of 2 are within their tolerance; the furthest of the "
        "others is off by 7 times it. Loads alone wanted: unsaid are sudden at 0.001, 0.007. Loads alone wanted: "
        "estimates are within a factor 3 of the true error in 1 of 2 (50 %)"
    )
    assert "All" not in text
    assert len(text.split("Loads alone wanted:")) == 4


def test_what_is_missed_is_said_with_what_the_run_says_of_it():
    good = _made("settled", 1e-4, 1e-4, 2e-4, 1e-5, "done", 100, 120, 30)
    said = _made("sudden", 4e-3, 1e-4, 4e-3, 1e-4, "doubtful: loads", 100, 400, 50)
    unsaid = _made("from rest", 1e-4, 2e-3, 1e-4, 1e-4, "done", 100, 100, 10)
    broken = ToleranceRow("fast", METHOD, 1e-3, status=FAILED, reason="it broke")
    text = " ".join(reading([good, said, unsaid, broken]))
    assert "within the tolerance in 1 of 4 runs" in text
    assert "doubtful in 1 of 2; the greatest error is 4 times" in text
    assert "from rest at 0.001, 0.002" in text
    assert "fast at 0.001: it broke" in text
    # Of six estimates four are near, two are a tenth of the error or less: 0.1 and 0.05.
    assert text.startswith("All: of runs that call themselves done 1 of 2 are within their tolerance; the furthest of ")
    assert (
        "the others is off by 2 times it. All: estimates are within a factor 3 of the true error in 4 of 6 (66.7 %)"
        in text
    )
    assert text.count("true error in 4 of 6") == 3  # of all, of those without a horizon, of the scenes known
    assert "All without a horizon: estimates" in text
    assert "at most" in text
    assert "it takes over 35 % in 0 of 3 runs." in text
    dear = good.but(companion_steps=100)
    told = " ".join(reading([dear, dear.but(took=f"it took 83 %: {SHORT_RUN}, 9 steps")]))
    assert "it takes over 35 % in 2 of 2 runs; 1 of these say what took it, 1 are short." in told
    assert not broken.kept
    assert "nobody knows" not in text
    lost = _made("fast", 4e-3, 1e-4, 4e-3, 1e-4, "doubtful: loads", 100, 400, 50).but(load_known=5e-3)
    assert not lost.kept
    assert not lost.missed
    text = " ".join(reading([good, lost]))
    assert "within the tolerance in 1 of 2 runs" in text
    assert "in 1 runs nobody knows, as the reference is off by more (fast)" in text
    assert "doubtful are 1 of 1." in text
    assert lost.but(load_known=1e-3).missed
    assert lost.but(load_known=2.8e-3).missed  # off by more than what is wanted and what the reference may be off
    assert not lost.but(load_known=3.2e-3).missed
    assert said.ratios == pytest.approx([1.0, 1.0])
