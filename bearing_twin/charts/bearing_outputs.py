"""What a number of a bearing costs: a figure over the output rate, a quantile over samplers and samples.

Figures are those of 50 ms of a loose 6203, against outputs at 100 kHz. The quantile is that of the heaviest ball load
under the tolerances of the study `bearing_6203_tolerances`, its error over the load's deviation, a mean over SEEDS.
"""

import functools
import time

import numpy as np

from bearing_twin.charts.contest import judged
from bearing_twin.charts.contest_picture import Contest
from bearing_twin.charts.scene_rows import FORCE, command_of
from bearing_twin.charts.table import Row
from bearing_twin.charts.timing import timed
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene
from bearing_twin.uq.realisations import realise, task_of
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints
from bearing_twin.uq.study import load_study

SCENE, DURATION, FINEST = "bearing_6203_loose", 0.05, 1e5
RATES, FINER = (100.0, 300.0, 1e3, 3e3, 1e4, 3e4), 2e5  # FINER checks what is taken as true
FIGURES = ("heaviest load", "drive torque", "dissipated")
STUDY, PROBABILITY, SEEDS = "bearing_6203_tolerances", 0.9, 3
SAMPLES = (8, 16, 32, 64)
TRUE_SAMPLER, TRUE_SAMPLES, TRUE_SEED = "sobol", 512, 99


def _overrides(rate: float) -> tuple[str, ...]:
    return (f"run.output_rate={rate:g}", f"run.publish_rate={rate:g}", f"run.duration={DURATION}")


def _figures(rate: float) -> dict[str, float]:
    run = Run(load_scene(SCENE, _overrides(rate)))
    load = max(float(block.values[FORCE].max()) for block in run.blocks())
    figures = run.report.figures
    return dict(zip(FIGURES, (load, figures["drive_torque_nm"], figures["dissipated_j"]), strict=True))


@functools.cache
def _true_figures() -> dict[str, float]:
    return _figures(FINEST)


def judge_rate(name: str, figure: str, rate: float, limit: float) -> Row:
    """A figure at an output rate."""
    exact = _true_figures()[figure]

    def outcome():
        found, cost = timed(lambda: _figures(rate))
        return {
            "load_error": abs(found[figure] / exact - 1.0),
            "seconds": cost.seconds / DURATION,
            "spread": cost.spread,
        }

    return judged(Row(name, figure, rate, command=_rate_command(name, figure, rate)), outcome, limit)


def _rate_command(name, figure, rate):
    return command_of(SCENE, _overrides(rate))


def _again(rows: list[Row]) -> list[str]:
    """How near a finer rate comes to what is taken as true."""
    off = ", ".join(f"{row.method} {row.error:.1g}" for row in rows if row.setting == FINER)
    return [f"Figures at {FINEST:g} outputs a second are found again at {FINER:g} to: {off}."] if off else []


@functools.cache
def _study():
    study = load_study(STUDY)
    return study, task_of(study)


def _loads(sampler: str, samples: int, seed: int) -> np.ndarray:
    """The heaviest ball loads [N] of so many realisations."""
    study, task = _study()
    points = UnitPoints(sampler, study.joint.dimension, seed, samples)
    found = realise(task, study.joint.values(points.chunk(0, samples)))
    return found.quantities[:, task.quantities.index("greatest_ball_load")]


@functools.cache
def _truth() -> tuple[float, float]:
    """The quantile [N] and the deviation [N] of the load."""
    loads = _loads(TRUE_SAMPLER, TRUE_SAMPLES, TRUE_SEED)
    return float(np.quantile(loads, PROBABILITY)), float(np.std(loads))


def judge_quantile(name: str, sampler: str, samples: float, limit: float) -> Row:
    """The quantile by a sampler and so many samples."""
    exact, deviation = _truth()

    def outcome():
        start = time.thread_time()
        found = [float(np.quantile(_loads(sampler, int(samples), seed), PROBABILITY)) for seed in range(SEEDS)]
        seconds = (time.thread_time() - start) / SEEDS
        error = float(np.mean(np.abs(np.subtract(found, exact)))) / deviation
        return {"load_error": error, "seconds": seconds, "evaluations": int(samples)}

    command = _study_command(name, sampler, samples)
    return judged(Row(name, sampler, samples, command=command), outcome, limit)


def _study_command(name, sampler, samples):
    return f"bearing_twin study {STUDY} --samples {samples:.0f} --set sampler={sampler}"


CONTESTS = {
    "output_rate": Contest(
        judge=judge_rate,
        title="Figures of a loose 6203 over the output rate",
        error="error of the figure, against outputs at 100 kHz",
        cost="CPU s a simulated s",
        wanted=1e-3,
        problems={"lift-off": "100 Hz to 30 kHz"},
        entries=lambda name: ((figure, rate) for figure in FIGURES for rate in (*RATES, FINER)),
        command=_rate_command,
        more=_again,
        setting="outputs a second [1/s]",
    ),
    "quantiles": Contest(
        judge=judge_quantile,
        title="The 0.9 quantile of the heaviest ball load",
        error="error of the quantile, over the deviation",
        cost="CPU s a study",
        wanted=0.2,
        problems={"tolerances": "four uncertain inputs, 8 to 64 samples"},
        entries=lambda name: ((sampler, samples) for sampler in SAMPLERS for samples in SAMPLES),
        command=_study_command,
        own=(TRUE_SAMPLER,),
    ),
}
