"""Paced streams and loops of simulations without ROS, on a clock of their own; and messages that command them."""

from collections import defaultdict
from types import SimpleNamespace

import numpy as np
from runs import a_choice, cut, made_up_block, made_up_scene

from bearing_twin.kinds import KINDS
from bearing_twin.log.run_log import LogWriter
from bearing_twin.log.stream import sample_range
from bearing_twin.nodes.pacing import PacedStream, Timed
from bearing_twin.nodes.simulation_loop import Commands, SimulationLoop, log_path
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

MS = 1_000_000
START = 77_000_000_000  # wall time, anything but 0
SCENE = made_up_scene(balls=2)
BLOCK = made_up_block(SCENE, 400)


class Stream(PacedStream):
    """Batches of times in ms; `seen` are (wall, "tick" or topic, time) in ms since the start."""

    def __init__(self, batches, factor=1.0):
        self.clock, self.seen = START, []
        super().__init__(lambda message: self.note(message.topic, message.time_ns), factor)
        self.tick = lambda time_ns: self.note("tick", time_ns)
        self._source = iter([[Timed(ms * MS, "topic", b"") for ms in batch] for batch in batches])

    def next_batch(self):
        return next(self._source, None)

    def note(self, kind, time_ns):
        self.seen.append(((self.clock - START) // MS, kind, time_ns // MS))

    def drive(self, until_ms=None):
        """Calls `turn` at exactly the times it asks for, until it asks for none or `until_ms`."""
        while (wake_at := self.turn(self.clock)) is not None:
            if until_ms is not None and wake_at > START + until_ms * MS:
                return
            self.clock = max(self.clock, wake_at)

    def delivered(self, kind="topic"):
        return [(time, wall) for wall, noted, time in self.seen if noted == kind]


def made_up_simulation(scene=SCENE):
    """The outputs of BLOCK, one after the other, behind the interface of a Simulation; `speeds` are the commands."""
    it = SimpleNamespace(output_period_ns=MS, chunk_outputs=400, scene=scene, speeds=[], choice=a_choice())

    def reset():
        it.sequence, it.time_ns = -1, -MS

    def advance(outputs):
        first = it.sequence + 1
        it.sequence += outputs
        it.time_ns += outputs * MS
        return cut(BLOCK, first, first + outputs)[1]

    reset()
    it.reset, it.advance = reset, advance
    it.set_speed = lambda speed: it.speeds.append((it.time_ns, speed)) or ""
    record = {"status": "made up"}
    it.report = lambda: SimpleNamespace(**record, errors={}, as_dict=lambda: record, record=lambda: record)
    return it


class Loop(SimulationLoop):
    """A loop over a made-up simulation, what it delivers by topic, and a clock for `drive`."""

    def __init__(self, simulation=None, log=None, **options):
        self.delivered, self.walls, self.clock = defaultdict(list), [], START
        if log:
            options["open_log"] = lambda run, simulation: LogWriter(log_path(log, run), simulation.scene)
        super().__init__(simulation or made_up_simulation(), self.note, **options)

    def note(self, message):
        self.delivered[message.topic].append((message.time_ns, message.cdr))
        self.walls.append((self.clock - START, message.topic))

    def drive(self, until_ms):
        """Turns the loop for so much wall time, or until it has nothing more to do."""
        end = self.clock + round(until_ms * MS)
        while (wake_at := self.turn(self.clock)) is not None and wake_at <= end:
            self.clock = max(self.clock, wake_at)
        self.clock = end

    def outputs(self):
        """Numbers of the outputs in the SampleBlocks delivered."""
        ranges = (sample_range(cdr) for _, cdr in self.delivered["samples"])
        return [number for first, count in ranges for number in range(first, first + count)]


def vector(x=0.0, y=0.0, z=0.0):
    return SimpleNamespace(x=x, y=y, z=z)


def wrench(force=(), torque=(), frame="bearing_link"):
    """Attributes of a WrenchStamped."""
    vectors = SimpleNamespace(force=vector(*force), torque=vector(*torque))
    return SimpleNamespace(header=SimpleNamespace(frame_id=frame), wrench=vectors)


def twist(linear=(), angular=(), frame="bearing_link"):
    """Attributes of a TwistStamped."""
    vectors = SimpleNamespace(linear=vector(*linear), angular=vector(*angular))
    return SimpleNamespace(header=SimpleNamespace(frame_id=frame), twist=vectors)


def obeying(scene, overrides=(), load_timeout_ns=0, frame_prefix=""):
    """A paused loop over a scene: `run` goes on, `tell` commands, `channel` is what was computed so far."""
    scene = load_scene(scene, overrides)
    obeyed = {command.name: command for command in KINDS[scene.kind].commands()}
    simulation, blocks = Simulation(scene), []
    advance = simulation.advance
    simulation.advance = lambda outputs: blocks.append(advance(outputs)) or blocks[-1]
    commands = Commands(load_timeout_ns, frame_prefix)
    loop = SimulationLoop(simulation, lambda message: None, "fastest", commands=commands)
    loop.paused = True
    return SimpleNamespace(
        loop=loop,
        run=lambda seconds: loop.step(0, seconds),
        tell=lambda name, message: loop.execute(obeyed[name], message),
        channel=lambda name: np.concatenate([block.values[name] for block in blocks]),
    )
