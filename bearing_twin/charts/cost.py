"""CPU time of a run by stage: the motion with its outputs, the check beside it, samples one by one, a log."""

import tempfile
from pathlib import Path

from bearing_twin.base.units import two_digits
from bearing_twin.charts.contest import Contest, of_problem, seconds, timed
from bearing_twin.charts.panels import Axis, Panel, bars_of
from bearing_twin.charts.scenes import WITHOUT_CHECK
from bearing_twin.log.run_log import write_log
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

SPAN, RATE = 1.0, 1000  # s of a run, outputs a second
RUNS = {  # title, scene, share of SPAN
    "settled": ("6203, settled", "bearing_6203", 1.0),
    "loose": ("6203 with clearance, lift-off", "bearing_6203_loose", 0.3),
    "shaft": ("rotor between two 6203", "shaft_two_6203", 0.1),
}


def _blocks(run) -> None:
    for _ in run.blocks():
        pass


def _samples(run) -> None:
    for _ in run:
        pass


def _log(run) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_log(run, Path(folder) / "run.mcap")


STAGES = {
    "outputs as blocks": (_blocks, (WITHOUT_CHECK,)),
    "the same with a check": (_blocks, ()),
    "outputs one by one": (_samples, (WITHOUT_CHECK,)),
    "into a log": (_log, (WITHOUT_CHECK,)),
}


def judge(problem: str, stage: str, *_) -> dict:
    """One way to take a run, its CPU seconds a simulated second."""
    _, scene, share = RUNS[problem]
    work, keys = STAGES[stage]
    run = simulate(load_scene(scene, (*_keys(share), *keys)))
    return {"error": 0.0, **timed(lambda: work(run), share * SPAN)[1]}


def _keys(share: float) -> tuple[str, ...]:
    return (f"run.duration={share * SPAN:g}", f"run.output_rate={RATE}")


def panels(contest, rows) -> list[list[Panel]]:
    """A panel a run: a bar a stage."""
    axis = Axis("CPU time of a simulated second", "s")
    found = {title: {row.method: row.seconds for row in of_problem(rows, name)} for name, (title, _, _) in RUNS.items()}
    return [[bars_of(title, axis, stages) for title, stages in found.items() if stages]]


def read(contest, rows):
    """CPU time of every stage, and its speed against real time."""
    for name, (title, _, _) in RUNS.items():
        words = ", ".join(
            f"{row.method} {seconds(row.seconds)} ({two_digits(1.0 / row.seconds)} times real time)"
            for row in of_problem(rows, name)
            if row.seconds > 0.0
        )
        if words:
            yield f"{title}, CPU time of a simulated second with {RATE} outputs: {words}."


CHARTS = {
    "cost": Contest(
        title=f"Where the CPU time of a run goes ({RATE} outputs a simulated second, one core)",
        problems={name: row[0] for name, row in RUNS.items()},
        entries=lambda name, quick: ((stage, float("nan"), float("nan")) for stage in STAGES),
        judge=judge,
        panels=panels,
        read=read,
    )
}
