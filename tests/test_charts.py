"""Charts: each is made in its quick form, written, read again, and says in the right order who is more accurate."""

import contextlib
from pathlib import Path

import pytest
from doc_tables import read_table
from PIL import Image

from bearing_twin.charts import CHARTS, RENAMED, chart_of
from bearing_twin.charts import contest as engine
from bearing_twin.charts.contest import DONE, FAILED, REFUSED, STOPPED, Options

PART = {  # the problem or sheet that is tried of each, else the first
    "laws": "ellipse",
    "friction": "b/a = 0.3",
    "steppers": "sliding",
    "newcomers": "sliding",
    "dimensions": "thrust",
    "tolerance": "two_spheres",
    "choice": "two_spheres at 5 %",
    "beams": "slow",
    "discs": "locking",
    "bodies": "discs",
    "stability": "modes",
    "samplers": "four",
    "coverage": "gamma",
    "cost": "settled",
    "paper1": "contact_frame",
    "paper2": "4",
    "paper3": "1",
}
PAPERS = ("paper1", "paper2", "paper3")
WHOLE = "laws"  # is drawn as it is shown


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Every chart once, in this process: what `make` gives, by name."""
    folder, charts = tmp_path_factory.mktemp("charts"), {}

    def make(name):
        with pytest.MonkeyPatch.context() as patch:
            # Costs are not asserted: once is enough. With a limit the clock ticks more coarsely than runs take.
            patch.setattr(engine, "LONG", 0.0)
            return once(name)

    def once(name):
        if name not in charts:
            charts[name] = chart_of(name).make(
                folder, name, Options((PART.get(name) or next(iter(chart_of(name).problems)),), limit=0.0, quick=True)
            )
        return charts[name]

    return make


@pytest.mark.parametrize("name", CHARTS)
def test_a_chart_has_a_picture_a_table_and_a_reading(name, made, request, caplog):
    if name != WHOLE:
        request.getfixturevalue("quick_pictures")
    chart = made(name)
    assert not caplog.records  # Matplotlib's words would stand between the sentences
    assert chart.reading
    assert all(sentence.strip() for sentence in chart.reading)
    for picture in chart.pictures:
        with Image.open(picture) as image:
            assert image.width == (1600 if name == WHOLE else 640)
    if name in PAPERS:
        texts = (Path(table).with_suffix(".txt").read_text("utf-8") for table in chart.tables)
        assert "".join(texts).splitlines() == chart.reading
    else:
        rows = read_table(Path(chart.tables[0]))
        assert chart_of(name).reading(rows) == chart.reading
        assert {row.status for row in rows} <= {DONE, REFUSED, FAILED, STOPPED}
        assert any(row.status == DONE for row in rows)
        assert all(row.reason for row in rows if row.status != DONE)
        for row in rows:
            shares = (value for key, value in row.more.items() if "quantile" in key or key in ("mean", "deviation"))
            assert all(0.0 <= value <= 1.0 for value in shares)


@pytest.mark.usefixtures("quick_pictures")
@pytest.mark.parametrize("name", [name for name in CHARTS if name not in PAPERS])
def test_a_chart_without_a_result_is_drawn_and_says_so(name, tmp_path, monkeypatch):
    """Readings said that an error is inf, or up to nan, or medians of nothing."""

    @contextlib.contextmanager
    def stopped(seconds):
        raise engine.Stopped
        yield

    monkeypatch.setattr(engine, "limited", stopped)
    chart = chart_of(name).make(tmp_path, name, Options((PART[name],), quick=True))
    assert {row.status for row in chart.rows} == {STOPPED}
    text = " ".join(chart.reading)
    assert "Failed or stopped" in text
    assert not [words for words in ("nan", "inf", ": .") if words in text]


def errors(rows, method, **values):
    """Errors of a method, of the rows with these values."""
    rows_of_method = (row for row in rows if row.method == method)
    return [row.error for row in rows_of_method if all(getattr(row, key) == value for key, value in values.items())]


def test_laws_are_ordered_and_hertz_is_right_at_every_shape(made):
    rows = made("laws").rows
    assert max(errors(rows, "hertz")) < 1e-9  # the product solves narrow ellipses exactly
    assert max(errors(rows, "SciPy")) < 1e-13
    assert max(errors(rows, "hertz_differential")) < 1e-9 < max(errors(rows, "hertz_unprojected"))
    round_spot = {law: errors(rows, law, across=1.0)[0] for law in ("hertz", "volumetric", "constant")}
    assert round_spot["hertz"] < round_spot["volumetric"] == pytest.approx(0.00475, rel=0.01)
    assert round_spot["volumetric"] < round_spot["constant"]


def test_tighter_settings_are_more_accurate(made):
    for name, method in (
        ("steppers", "rodas4"),
        ("beams", "41 modes"),
        ("bodies", "dop853"),
        ("discs", "selective integration"),
    ):
        rows = [row for row in made(name).rows if row.method == method]
        errors_in_order = [row.error for row in rows if row.status == DONE]
        assert errors_in_order == sorted(errors_in_order, reverse=True), name
    assert all(row.error <= row.setting for row in made("tolerance").rows)


def test_defaults_of_others_are_worse_and_too_long_steps_are_refused(made):
    rows = made("newcomers").rows
    product, scipy = (min(errors(rows, name, setting=1e-3)) for name in ("rodas4", "solve_ivp RK45"))
    assert product < 1e-3 < scipy
    assert {row.status for row in rows if row.method == "rk4"} >= {REFUSED}


def test_papers_say_what_was_computed_independently(made):
    """Peaks and contacts of paper 2 and deviations of paper 3 as in independent programs."""
    falls = " ".join(made("paper2").reading)
    assert "1062.6, 752.2 N" in falls
    assert "1043.9 N" in falls
    densities = " ".join(made("paper3").reading)
    assert "1.099e-05" in densities
    assert "truncated normal, with 0.059 nat more than gamma" in densities


def test_old_names_name_the_chart_of_today(tmp_path, run_json, refused):
    for old, new in RENAMED.items():
        assert new in refused("chart", old, "--out", tmp_path)
    assert {row["chart"] for row in run_json("chart", "--list")["charts"]} == set(CHARTS)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["laws", "--problem", "elipse"], "ellipse"),
        (["paper3", "--only", "99"], "99"),
        (["laws", "--limit", "0"], "above 0"),
        (["all", "--problem", "ellipse"], "one chart"),
        (["laws", "--out", "nowhere"], "not a folder"),
    ],
)
def test_words_that_do_not_fit_are_refused(arguments, says, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    assert says in refused("chart", *arguments)


def test_a_chart_that_exists_is_replaced_with_force_alone(tmp_path, run_json, refused):
    (tmp_path / "laws.csv").touch()
    arguments = ["chart", "laws", "--quick", "--problem", "ellipse", "--out", tmp_path]
    assert "--force" in refused(*arguments)
    rows = run_json(*arguments, "--force")["rows"]
    assert len(rows) == len(read_table(tmp_path / "laws.csv")) > 0
    assert rows[0].keys() == {*engine.COLUMNS, "more"}, "keys that readers of --json rely on"
    assert {"problem", "method", "setting", "across", "error", "seconds", "status", "reason"} < rows[0].keys()
    (tmp_path / "paper1_bounces.txt").touch()
    assert "paper1_bounces.txt" in refused("chart", "paper1", "--only", "3", "--out", tmp_path)
