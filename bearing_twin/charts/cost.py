"""Where the time of a bearing's run goes, from the contacts to a log on disk.

Each part is what a further stage adds: the motion without outputs, with outputs, watched by its companion, blocks,
messages, a log; and samples, beside it, to blocks. CPU time of one core, medians of several runs in turn; the raceway
contacts' part is that of as many evaluations, timed apart.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.forces.equations import raceway_rates
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, LANE_ROWS
from bearing_twin.kinds.bearing.forces.rates import put_ring_speed
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.moving import moving_by
from bearing_twin.log.run_log import write_log
from bearing_twin.log.stream import MessageStream
from bearing_twin.numerics.lanes import LANES, into_blocks, new_blocks
from bearing_twin.pictures.style import BALL_COLOURS, frame, save_chart
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

RUNS = {  # what is said of a run: its scene, what differs there, and the seconds simulated
    "6203, settled": ("bearing_6203", (), 5.0),
    "6203, friction over the spots": ("bearing_6203", ("contact.friction=spot",), 5.0),
    "6203 at 20 000 rpm": ("bearing_6203_fast", (), 5.0),
    "6203 with clearance, lift-off": ("bearing_6203_loose", (), 5.0),
    "6203, sudden speed and load": ("bearing_6203_sudden", (), 1.0),
}
RATE = 1000  # Hz, of the outputs
REPEATS = 5
EVALUATIONS = 2000  # of the contacts of LANES balls, to time them
SAMPLES = "samples"
PARTS = {
    "kernel": "raceway contacts",
    "steps": "the rest of the steps",
    "outputs": "outputs",
    "companion": "its companion",
    "packaging": "packaging as blocks",
    "publishing": "messages as published",
    "log": "writing the log",
    SAMPLES: "samples one by one",
}


@dataclass(frozen=True)
class CostPart:
    """A part of a run: CPU seconds per simulated second, and its spread over the repeats (median deviation)."""

    run: str
    part: str
    cpu_per_simulated_second: float
    spread: float


POINT = CostPart


@kernel
def _evaluate(bearing, lanes, count):
    for _ in range(count):
        raceway_rates(bearing, lanes)


def _contact_seconds(motion) -> float:
    """CPU seconds of one evaluation of one ball's raceway contacts, side by side with others."""
    blocks = new_blocks(len(motion.state), LANE_ROWS)
    into_blocks(motion.state, blocks, AXIS_DISTANCE)
    put_ring_speed(motion.drive, 0.0, blocks[0])
    return _seconds(lambda: _evaluate(motion.bearing, blocks[0], EVALUATIONS)) / EVALUATIONS / LANES


def _seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def _move(motion, run: Run, outputs: bool) -> None:
    """The motion alone, in the chunks of the simulation."""
    motion.reset()
    chunk, left = run.simulation.chunk_outputs, run.outputs - 1
    while left > 0:
        times = np.arange(1, min(chunk, left) + 1) / RATE
        motion.advance(times if outputs else times[:0], times[-1])
        left -= len(times)


def _messages(run: Run) -> None:
    stream = MessageStream(run.scene, choice=run.choice)
    for block in run.blocks():
        for _ in stream.messages(block):
            pass
    for _ in stream.flush():
        pass


def _log(run: Run) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_log(run, Path(folder) / "run.mcap")


def _exhaust(items) -> None:
    for _ in items:
        pass


def _parts(motion, watched, run: Run) -> dict[str, float]:
    """CPU seconds of each of PARTS: what a stage takes beyond the stage before it."""
    steps = _seconds(lambda: _move(motion, run, False))
    contacts = motion.costs()["ball_rates"] * _contact_seconds(motion)
    outputs = _seconds(lambda: _move(motion, run, True))
    beside = _seconds(lambda: _move(watched, run, True))
    blocks = _seconds(lambda: _exhaust(run.blocks()))
    samples = _seconds(lambda: _exhaust(run))
    messages = _seconds(lambda: _messages(run))
    log = _seconds(lambda: _log(run))
    return {
        "kernel": contacts,
        "steps": steps - contacts,
        "outputs": outputs - steps,
        "companion": beside - outputs,
        "packaging": blocks - beside,
        "publishing": messages - blocks,
        "log": log - messages,
        "samples": samples - blocks,
    }


def measure(names=tuple(RUNS), say: Callable[[str], None] = lambda _: None) -> Iterator[CostPart]:
    """Every part of the named runs; compiles before it measures."""
    for name in names:
        scene, overrides, seconds = RUNS[name]
        say(name)
        run = Run(load_scene(scene, (*overrides, f"run.duration={seconds}", f"run.output_rate={RATE}")))
        motions = [make(run.scene.parameters, run.choice) for make in (BearingMotion, moving_by)]
        _parts(*motions, run)
        found = [_parts(*motions, run) for _ in range(REPEATS)]
        for part in PARTS:
            costs = np.array([one[part] for one in found]) / seconds
            middle = float(np.median(costs))
            yield CostPart(name, part, middle, float(np.median(np.abs(costs - middle))))


def _to_a_log(points: list[CostPart], name: str) -> dict[str, float]:
    """The parts of a run on their way into a log; noise does not make one negative."""
    return {p.part: max(p.cpu_per_simulated_second, 0.0) for p in points if p.run == name and p.part != SAMPLES}


def reading(points: list[CostPart]) -> list[str]:
    """What the chart says, a sentence a run."""
    sentences = []
    for name in dict.fromkeys(p.run for p in points):
        parts = _to_a_log(points, name)
        total = sum(parts.values())
        shares = ", ".join(f"{PARTS[part]} {100.0 * cost / total:.0f} %" for part, cost in parts.items())
        (samples,) = (p.cpu_per_simulated_second for p in points if (p.run, p.part) == (name, SAMPLES))
        sentences.append(
            f"{name}: a log takes {1e3 * total:.3g} ms CPU a simulated second, {1.0 / total:.3g} times real time: "
            f"{shares}; {PARTS[SAMPLES]} take {1e3 * max(samples, 0.0):.2g} ms beside it."
        )
    return sentences


def draw(points: list[CostPart], path: Path) -> None:
    """The chart: a bar a run, cut into its parts; on the right what the whole takes."""
    names = list(dict.fromkeys(p.run for p in points))
    figure = Figure(figsize=(14, 1.1 * len(names) + 2.6), layout="constrained")
    axis = figure.subplots()
    for row, name in enumerate(names):
        parts, left = _to_a_log(points, name), 0.0
        total = sum(parts.values())
        for number, (part, cost) in enumerate(parts.items()):
            share = 100.0 * cost / total
            axis.barh(
                row, share, left=left, height=0.62, color=BALL_COLOURS[number], label=PARTS[part] if not row else ""
            )
            if share >= 4.0:
                axis.text(
                    left + 0.5 * share, row, f"{share:.0f} %", ha="center", va="center", color="white", fontsize=12
                )
            left += share
        axis.text(101.5, row, f"{1e3 * total:.3g} ms = {1.0 / total:.3g} x real time", va="center", fontsize=12)
    axis.set_yticks(range(len(names)), names)
    axis.set(xlim=(0.0, 128.0), xlabel="share of the CPU time of one core, %", xticks=range(0, 101, 20))
    axis.invert_yaxis()
    frame(axis)
    axis.tick_params(axis="y", labelsize=12)
    axis.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=len(PARTS) - 1, fontsize=11, frameon=False)
    title = f"Where the time of a simulated second into a log goes ({RATE} outputs a second, 8 balls)"
    save_chart(figure, title, path)
