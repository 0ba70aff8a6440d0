"""The chart of costs: its parts are what each stage adds, in the picture, the table and the sentences."""

import csv

import pytest

from bearing_twin.charts import cost
from bearing_twin.charts.cost import PARTS, SAMPLES, CostPart, draw, measure, reading
from bearing_twin.charts.table import write_table

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")


def made(name, **ms):
    return [CostPart(name, part, 1e-3 * ms.get(part, 0.0), 0.0) for part in PARTS]


def test_parts_are_what_a_stage_takes_beyond_the_stage_before(monkeypatch):
    """Stages run in order, once to compile and then counted; a clock that ticks by what was run tells them apart."""
    ticks = iter(range(10**6))
    spent = {"motion": 3.0, "moved": 5.0, "watched": 8.0, "blocks": 9.0, "samples": 9.5, "messages": 20.0, "log": 50.0}
    stages = [*spent.values()]
    monkeypatch.setattr(cost, "_seconds", lambda work: (work(), stages[next(ticks) % len(stages)])[1])
    monkeypatch.setattr(cost, "_contact_seconds", lambda motion: 1.0 / motion.costs()["ball_rates"])
    monkeypatch.setitem(cost.RUNS, "short", ("bearing_6203", (), 0.05))
    found = {p.part: p.cpu_per_simulated_second * 0.05 for p in measure(["short"])}
    assert found == pytest.approx(
        {
            "kernel": 1.0,
            "steps": 2.0,
            "outputs": 2.0,
            "companion": 3.0,
            "packaging": 1.0,
            "publishing": 11.0,
            "log": 30.0,
            SAMPLES: 0.5,
        }
    )


def test_the_motion_runs_as_far_as_the_run_does():
    """Each part belongs to the same simulated seconds, with outputs and without."""
    run = cost.Run(cost.load_scene("bearing_6203", ("run.duration=0.06", f"run.output_rate={cost.RATE}")))
    motion = cost.BearingMotion(run.scene.parameters, run.choice)
    for outputs in (False, True):
        cost._move(motion, run, outputs)
        assert motion.elapsed == pytest.approx(0.06, rel=1e-9)


def test_sentences_table_and_picture_say_what_was_measured(tmp_path):
    points = [*made("first", kernel=1.0, steps=3.0, log=6.0, samples=0.5), *made("second", outputs=2.0, packaging=-0.1)]
    first, second = reading(points)
    assert first.startswith("first: a log takes 10 ms CPU a simulated second, 100 times real time: ")
    assert "raceway contacts 10 %, the rest of the steps 30 %" in first
    assert "writing the log 60 %; samples one by one take 0.5 ms beside it." in first
    assert "outputs 100 %, its companion 0 %, packaging as blocks 0 %" in second
    write_table(points, tmp_path / "cost.csv")
    rows = list(csv.DictReader((tmp_path / "cost.csv").open(encoding="utf-8")))
    assert [row["part"] for row in rows] == [*PARTS, *PARTS]
    draw(points, tmp_path / "cost.png")
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG")
