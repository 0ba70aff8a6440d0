"""Contests of methods: the runner's promises, and what the smallest version of each chart says about order."""

import csv
import json
import math
import os
import shlex
import subprocess
import sys

import pytest

from bearing_twin.charts import (
    bearing_laws,
    bearing_outputs,
    body_limits,
    contest,
    limits,
    model_limits,
    model_maps,
    newcomers,
    scene_contests,
    stability,
    stability_picture,
    study_samples,
)
from bearing_twin.charts.contest import Asked, Job, Kept, answers_of, rows_of
from bearing_twin.charts.table import DONE, FAILED, REFUSED, STOPPED, Row, write_table
from bearing_twin.command import all_charts
from bearing_twin.command.chart_table import CHARTS
from bearing_twin.command.cli import main
from bearing_twin.errors import BearingTwinError, IntegrationError, SceneError

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

WANTED = Asked((), lambda share: None, 0, 0.0, Kept(None))


def here(*problems):
    """What is asked of a contest in this process."""
    return WANTED._replace(problems=problems, kept=Kept(None))


def test_a_contestant_that_hangs_is_stopped_and_the_others_go_on(monkeypatch, tmp_path, quick_workers):
    """In a process of its own, by the system; what is finished is not done again, and None is an answer, too."""
    (tmp_path / "made_up").mkdir()
    (tmp_path / "made_up" / "hanging.py").write_text(
        "import time\nfrom numba.core import event\nfrom bearing_twin.charts.contest import Row, limited\n\n"
        "def run(number, hangs):\n    began = time.thread_time()\n    with limited(0.1):\n"
        "        with event.trigger_event('numba:compiler_lock'):\n"  # as long as it takes
        "            while not number and time.thread_time() - began < 0.4:\n                pass\n"
        "        while hangs:\n            pass\n"
        "    return Row('p', 'm', number, load_error=0.5, status='done')\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.syspath_prepend(tmp_path)
    tasks = [Job("made_up.hanging:run", (number, number == 1.0)) for number in (0.0, 1.0, 2.0)]
    kept = Kept(tmp_path / "x.unfinished")
    answers = answers_of(tasks, kept, workers=1)
    rows = rows_of(tasks, answers, lambda task: Row("p", "m", task.arguments[0]), 0.1)
    assert [row.status for row in rows] == [DONE, STOPPED, DONE]
    assert "0.1 CPU seconds" in rows[1].reason
    again = Kept(tmp_path / "x.unfinished")
    assert str(answers_of(tasks, again, workers=0)) == str(answers)  # NaN equals nothing
    with (tmp_path / "x.unfinished").open("a") as stream:
        stream.write('["torn')
    assert len(Kept(tmp_path / "x.unfinished").answers) == 3
    (tmp_path / "x.unfinished").write_text('"another state of the sources"\n["key", 1]\n')
    assert Kept(tmp_path / "x.unfinished").answers == {}


def test_what_does_not_come_out_is_a_row_with_its_reason():
    row = Row("p", "m", 1.0)

    def raises(error):
        def work():
            raise error

        return work

    refused = contest.judged(row, raises(SceneError("too long")), 0.0)
    assert (refused.status, refused.reason) == (REFUSED, "too long")
    assert contest.judged(row, raises(IntegrationError("at 1 s")), 0.0).status == FAILED
    assert contest.judged(row, raises(ZeroDivisionError("division")), 0.0).status == FAILED
    assert contest.judged(row, lambda: {"load_error": math.nan}, 0.0).reason == "not finite"
    good = contest.judged(row, lambda: {"load_error": 0.1, "friction_error": 0.2}, 0.0)
    assert (good.status, good.error) == (DONE, 0.2)


@pytest.fixture
def from_near(monkeypatch):
    """Limits are looked for from where one would be too far from its prediction, not from a third of this."""
    monkeypatch.setattr(limits, "FROM", 1.6)


@pytest.mark.usefixtures("from_near")
@pytest.mark.parametrize("method", stability.FIXED)
@pytest.mark.parametrize("name", stability.AXES)
def test_predicted_limits_are_those_found_and_refusal_follows_them(method, name):
    """At both ends of two decades: within a fifth, and nothing is let pass that fails."""
    for across in stability.AXES[name].values[:: len(stability.AXES[name].values) - 1]:
        found = stability.limit(name, method, across)
        assert found.ratio == pytest.approx(1.0, abs=stability_picture.WITHIN)
        assert found.refused == pytest.approx(found.predicted, rel=0.05)


@pytest.mark.usefixtures("from_near")
@pytest.mark.parametrize("name", model_limits.LIMITED)
def test_limits_of_spheres_and_discs_are_those_predicted(name):
    """At both ends of two decades; refusal lets nothing pass that fails."""
    facts = model_limits.LIMITED[name]
    assert facts.across[-1] / facts.across[0] == pytest.approx(100.0)
    for method in facts.methods:
        for across in facts.across[:: len(facts.across) - 1]:
            found = model_limits.limit(name, method, across)
            assert found.ratio == pytest.approx(1.0, abs=stability_picture.WITHIN)
            assert found.refused < 1.1 * found.found


def test_modes_of_a_beam_hold_whatever_the_step(monkeypatch):
    """From 4 steps a contact to a half; by Volterra's equation errors grow with the step."""
    methods, errors = [], {}
    throw = body_limits.throw
    monkeypatch.setattr(body_limits, "throw", lambda *given: throw(*given[:-1], methods[-1]))
    for method in ("modes", "volterra"):
        methods.append(method)
        place = body_limits.struck()
        contact = body_limits.HATS * place.predicted(method)
        errors[method] = [
            place.error(method, contact / count) for count in (4.0, 1.0, 0.5)[: 3 if method == "modes" else 1]
        ]
    assert max(errors["modes"]) < 1e-2 < 0.1 < errors["volterra"][0]


def test_what_is_put_right_drifts_when_left_alone():
    """The norm by the closed form of rk4, the axis by rounding over the difference of the curvatures."""
    for turn, steps in ((0.5, 20), (1.0, 20000)):
        found = model_maps.model_cell("quaternion", "rk4", steps, turn, 0.0)
        growth = abs(1.0 + (z := 0.5j * turn) * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))
        assert found.load_error == pytest.approx(1.0 - growth**steps, rel=1e-6)
    rounder, longer = (model_maps.model_cell("axis", "gap", 0.5, across, 0.0) for across in (1e-15, 1e-4))
    assert rounder.load_error > 1e-3 > 1e-11 > longer.load_error
    assert "circular" in rounder.reason
    assert not longer.reason


def test_beyond_its_limit_rk4_gives_loads_right_and_friction_wrong():
    good, bad = (stability.cell("regularisation", "rk4", step, 1e-2) for step in (1e-6, 4e-6))
    assert good.error < 1e-6
    assert bad.status == DONE
    assert bad.load_error < 1e-3 < 0.1 < bad.friction_error


def test_a_ninth_method_is_drawn_where_there_are_eight_colours(tmp_path, monkeypatch):
    nine = tuple(f"method {number}" for number in range(1, 10))
    facts = model_limits.LIMITED["impact_stiffness"]._replace(methods=nine)
    monkeypatch.setitem(model_limits.LIMITED, "impact_stiffness", facts)
    drawn = []
    monkeypatch.setattr(stability_picture, "save_chart", lambda figure, *_: drawn.append(figure))
    found = [limits.Limit(one, "impact_stiffness", across, 1e-6, 2e-6, 1e-6) for one in nine for across in (1e10, 1e11)]
    stability_picture.of_limits(found, tmp_path / "l.png")
    lines = {line.get_label(): (line.get_color(), line.get_linestyle()) for line in drawn[0].axes[0].lines}
    assert len({lines[one] for one in nine}) == 9
    assert len({(look["color"], look["linestyle"]) for look in map(study_samples.colour, range(9))}) == 9


def test_maps_are_drawn_told_and_read_again(tmp_path, monkeypatch):
    monkeypatch.setattr(stability, "TOLERANCES", (1e-1, 1e-5))
    wanted = here("regularisation", "tolerance", "impact_damping")
    measured = stability.measure(wanted, every=8, steps=(1e-6, 1e-5, 5e-5))
    rows, found = measured
    assert {row.status for row in rows} == {DONE, FAILED}
    mine = {row.setting: row.error for row in rows if (row.problem, row.method) == ("tolerance", "rodas3")}
    looser, tighter = mine[1e-1], mine[1e-5]
    assert tighter < looser
    stability_picture.of_steps(rows, found, tmp_path / "s.png")
    stability_picture.of_tolerances(rows, tmp_path / "t.png")
    stability_picture.of_limits(found, tmp_path / "l.png")
    stability_picture.write_limits(found, tmp_path / "s.csv")
    write_table(rows, tmp_path / "s_cells.csv")
    again = stability_picture.read(tmp_path, "s")
    assert again == stability_picture.reading(rows, found)
    assert "within 20 % at 2 of 2 places" in again[0]


def test_a_cell_is_repeated_by_its_command(capsys):
    assert main(["chart", "stability", "--cell", "stiffness imex 1e-06 2e+11", "--json"]) == 0
    assert '"status": "done"' in capsys.readouterr().out
    for words in ("impact_damping rk4 4e-05 0.1", "law volumetric 1 0.01"):
        assert main(["chart", "stability", "--cell", words, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["load_error"] > 0.05
        assert shlex.split(found["command"])[3:] == ["--cell", words]
    for words, told in (
        ("stiffness imex 1e-6", "four words"),
        ("stifness imex 1e-6 1", "stiffness"),
        ("stiffness rodas4 1e-6 1", "rk4"),
        ("stiffness imex nan 1", "above zero"),
        ("impact_damping imex 1e-5 1", "rk4"),
    ):
        assert main(["chart", "stability", "--cell", words]) == 2
        assert told in capsys.readouterr().err


def test_newcomers_pay_more_or_get_nothing():
    """Order only: a step of 0.1 ms gives nothing; RK45 takes far more evaluations than rodas4 at the same tolerance."""
    assert newcomers.judge("settled", "rk4", 1e-4, 0.0).status == FAILED
    assert newcomers.judge("settled", "explicit Euler", 1e-4, 0.0).status == FAILED
    product, other = (newcomers.judge("settled", method, 1e-3, 0.0) for method in ("rodas4", "solve_ivp LSODA"))
    assert other.evaluations > 3.0 * product.evaluations
    assert max(product.error, other.error) < 1e-3


def test_the_volumetric_law_stays_off_and_others_do_not():
    off, near = (bearing_laws.judge("settled", law, 1e-5, 0.0).error for law in ("volumetric", "hertz"))
    assert near < 1e-5 < 1e-3 < off < 1e-2


def test_friction_over_the_spot_is_nearer_than_its_closed_form(monkeypatch):
    """Over two outputs, by the same stepper and tolerance."""
    monkeypatch.setattr(bearing_laws, "FEW", 2)
    spot, rough = (bearing_laws.judge_friction("thrust", model, 1e-3, 0.0).error for model in ("spot", "pade1"))
    assert spot < 0.1 * rough


def test_shorter_steps_and_tighter_tolerances_are_nearer(tmp_path):
    """A chart of each kind beside the bearing; its table gives the same sentences again."""
    for name, method, loose, tight in (
        ("elastic spheres", "rk4", *scene_contests.PAIRS["elastic spheres"].fields["rk4"].ladder[2:5:2]),
        ("elastic spheres", "dop853", 1e-4, 1e-8),
        ("1 cm/s, one contact", "volterra", 60, 250),
        ("discs, line contact", "rk4", *scene_contests.PAIRS["discs, line contact"].fields["rk4"].ladder[2:5:2]),
        ("ellipsoid on a plane", "rk4", *scene_contests.PAIRS["ellipsoid on a plane"].fields["rk4"].ladder[2:5:2]),
        ("ball in a groove", "closed", 1e-2, 1e-8),
    ):
        errors = [scene_contests.judge(name, method, one, 0.0).error for one in (loose, tight)]
        assert errors[1] < 0.5 * errors[0] < 0.1
    refused = scene_contests.judge("elastic spheres", "rk4", scene_contests.CONTACT / 4, 0.0)
    assert refused.status == REFUSED
    assert "8 steps" in refused.reason


def test_a_contest_writes_picture_and_table(tmp_path, monkeypatch, capsys):
    one = scene_contests.CONTESTS["pairs"]
    few = tuple(entry for entry in one.entries("elastic spheres") if entry[0] in ("closed_form", "rk4"))[:4]
    monkeypatch.setitem(vars(one), "entries", lambda name: few)
    made = one.make(tmp_path, "pairs", here("elastic spheres"))
    assert (tmp_path / "pairs.png").stat().st_size > 10_000
    assert main(["chart", "pairs", "--read", "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["reading"] == made.reading
    assert main(["chart", "beams", "--read", "--out", str(tmp_path)]) == 2
    assert "closed_form" in made.reading[0]
    nearest = min(row.error for row in made.rows)
    assert made.reading[1] == f"References that other methods find: elastic spheres to {nearest:.1g} (closed_form)."
    assert [row["status"] for row in csv.DictReader((tmp_path / "pairs.csv").open())].count(REFUSED) == 2


def test_peaks_need_outputs_and_quantiles_need_samples(monkeypatch):
    monkeypatch.setattr(bearing_outputs, "FINEST", 1e4)
    few, many = (bearing_outputs.judge_rate("lift-off", "heaviest load", rate, 0.0).error for rate in (100.0, 3e3))
    assert many < few
    for name, value in (("SEEDS", 1), ("TRUE_SAMPLES", 4)):
        monkeypatch.setattr(bearing_outputs, name, value)
    row = bearing_outputs.judge_quantile("tolerances", "sobol", 4.0, 0.0)
    assert (row.status, row.evaluations) == (DONE, 4)
    assert row.error < 3.0


def test_what_charts_there_are_and_words_that_fit_none(capsys):
    assert main(["chart", "--list", "--json"]) == 0
    assert '"stability"' in capsys.readouterr().out
    assert main(["chart", "beams", "--problem", "bems"]) == 2
    assert "drop of 600 mm" in capsys.readouterr().err
    assert main(["chart"]) == 2
    assert main(["chart", "beams", "--limit", "-1"]) == 2
    assert main(["chart", "bounces", "--limit", "3"]) == 2
    with pytest.raises(SystemExit) as ended:
        main(["chart", "--help"])
    assert ended.value.code == 0


def test_all_charts_go_on_where_one_failed(tmp_path, monkeypatch):
    """Charts stand for processes that end at once; the second fails the first time round."""
    started = []

    def start(code):
        def begin(name, folder, limit):
            started.append(name)
            text = f"import sys; print('no room', file=sys.stderr); sys.exit({code if name == 'beams' else 0})"
            return subprocess.Popen([sys.executable, "-c", text], stderr=subprocess.PIPE, text=True)

        return begin

    monkeypatch.setattr(all_charts, "CHARTS", {name: CHARTS[name] for name in ("stability", "beams")})
    monkeypatch.setattr(contest, "WORKERS", 1)
    monkeypatch.setattr(all_charts, "_started", start(2))
    with pytest.raises(BearingTwinError, match="chart beams failed: no room"):
        all_charts.make_all(tmp_path, None)
    monkeypatch.setattr(all_charts, "_started", start(0))
    made = all_charts.make_all(tmp_path, None)
    assert started == ["stability", "beams", "beams"]
    assert set(made.result["seconds"]) == {"stability", "beams"}
    assert list(tmp_path.iterdir()) == []
