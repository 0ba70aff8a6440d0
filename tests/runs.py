"""Runs for tests: whole, or made up without a solver; single messages into recordings, disks that fill up."""

import errno
import hashlib
import os
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from mcap.records import Metadata

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, join_blocks
from bearing_twin.log.bag import log_files, reader_of
from bearing_twin.log.raw_log import OUTPUTS_KEY, RUN_RECORD
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.run.simulation import simulate


def a_choice(law: str = "hertz", stepper: str = "rodas4") -> Choice:
    """A model without the weighing that leads to one."""
    return Choice(law, stepper, 0.0, "made up", ())


def made_up_scene(balls: int = 3, output_rate: float = 1000.0, publish_rate: float = 100.0) -> Scene:
    """A scene with few balls; its law and stepper are fixed."""
    return load_scene(
        "bearing_6203",
        (
            f"geometry.balls={balls}",
            f"run.output_rate={output_rate!r}",
            f"run.publish_rate={publish_rate!r}",
            "contact.normal=hertz",
            "solver.stepper=rodas4",
        ),
    )


def made_up_block(scene: Scene, outputs: int, first: int = 0, seed: int = 1) -> Block:
    """`outputs` random outputs; every third contact is open."""
    random = np.random.default_rng(seed)
    values = {channel.name: random.normal(size=(outputs, *channel.shape)) for channel in scene.channels}
    values["curvature_small"] = random.uniform(1.0, 10.0, size=values["curvature_small"].shape)
    values["curvature_large"] = random.uniform(100.0, 500.0, size=values["curvature_large"].shape)
    values["normal"] /= np.linalg.norm(values["normal"], axis=-1, keepdims=True)
    values["orientation"] /= np.linalg.norm(values["orientation"], axis=-1, keepdims=True)
    is_open = random.uniform(size=values["approach"].shape) < 1 / 3
    values["approach"] = np.where(is_open, -1e-6, 1e-6)
    values["normal_load"] = np.where(is_open, 0.0, random.uniform(1.0, 100.0, size=is_open.shape))
    values["slip"][0].flat[0] = -0.0
    period = round(1e9 / scene.parameters.run.output_rate)
    time_ns = (first + np.arange(outputs, dtype=np.int64)) * period
    return Block(scene.channels, first, time_ns, values)


def cut(block: Block, *rows: int) -> list[Block]:
    """The block in pieces that begin at `rows`."""
    edges = (0, *rows, len(block))
    return [
        Block(
            block.channels,
            block.first_sequence + low,
            block.time_ns[low:high],
            {name: array[low:high] for name, array in block.values.items()},
        )
        for low, high in pairwise(edges)
    ]


def made_up_run(scene: Scene, blocks: list[Block]) -> SimpleNamespace:
    """The part of a run that `write_log` needs."""
    report = SimpleNamespace(record=lambda: {"status": "made up", "samples": sum(map(len, blocks))})
    return SimpleNamespace(scene=scene, choice=a_choice(), blocks=lambda: iter(blocks), report=report)


def bits(samples) -> list:
    """Samples as comparable values: number, time, and the bytes of every array with its shape."""
    return [
        (sample.sequence, sample.time_ns, {name: (v.shape, v.tobytes()) for name, v in sample.values.items()})
        for sample in samples
    ]


def content_digest(path) -> str:
    """SHA-256 of everything in a log except date, host and costs: equal for two runs of one scene on one machine.

    How messages are put together in chunks makes no difference: it depends on when a node flushed them. Nor does it
    that a node may end its log at any time, where a whole run says how long it is.
    """
    digest, topics_told = hashlib.sha256(), {}
    for file in log_files(path):
        with reader_of(file) as reader:
            for item in reader.content():
                if isinstance(item, Metadata):
                    if item.name != RUN_RECORD:
                        said = [one for one in sorted(item.metadata.items()) if one[0] != OUTPUTS_KEY]
                        digest.update(repr((item.name, said)).encode())
                    continue
                if item.topic.name not in topics_told:
                    topics_told[item.topic.name] = len(topics_told)
                    digest.update(repr(item.topic.identity).encode())
                head = topics_told[item.topic.name], item.log_time, item.publish_time, len(item.data)
                digest.update(repr(head).encode())
                digest.update(item.data)
    return digest.hexdigest()


def run_all(scene, *overrides):
    """The report of a whole run, and all outputs as one block."""
    run = simulate(scene if isinstance(scene, Scene) else load_scene(scene, overrides))
    block = join_blocks(list(run.blocks()))
    return run.report, block


def reported(scene, *overrides):
    """The report of a whole run."""
    return run_all(scene, *overrides)[0]


def no_room(*_):
    """A function of the system in the place of which the disk is full."""
    raise OSError(errno.ENOSPC, "No space left on device")


def full_after(writes: int, monkeypatch) -> None:
    """The disk has room for so many writes of logs, and for none after them."""
    write, calls = os.pwritev, []

    def full(*arguments):
        calls.append(arguments)
        return (no_room if len(calls) > writes else write)(*arguments)

    monkeypatch.setattr(os, "pwritev", full)
