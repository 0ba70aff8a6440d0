"""Scenes that run without ROS and obey commands, and messages that tell them."""

from types import SimpleNamespace

import numpy as np
from made_up_run import a_choice

from bearing_twin.kinds import KINDS
from bearing_twin.log.stream import MessageStream
from bearing_twin.nodes.simulation_loop import Commands, SimulationLoop
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation


def vector(x=0.0, y=0.0, z=0.0):
    return SimpleNamespace(x=x, y=y, z=z)


def wrench(force=(), torque=(), frame="bearing_link"):
    """Attributes of a WrenchStamped."""
    both = SimpleNamespace(force=vector(*force), torque=vector(*torque))
    return SimpleNamespace(header=SimpleNamespace(frame_id=frame), wrench=both)


def twist(linear=(), angular=(), frame="bearing_link"):
    """Attributes of a TwistStamped."""
    both = SimpleNamespace(linear=vector(*linear), angular=vector(*angular))
    return SimpleNamespace(header=SimpleNamespace(frame_id=frame), twist=both)


def obeying(scene, overrides=(), load_timeout_ns=0, frame_prefix=""):
    """A paused loop over a scene: `run` goes on, `tell` commands, `channel` is what was computed so far."""
    scene = load_scene(scene, overrides)
    obeyed = {command.name: command for command in KINDS[scene.kind].commands()}
    simulation, blocks = Simulation(scene), []
    advance = simulation.advance
    simulation.advance = lambda outputs: blocks.append(advance(outputs)) or blocks[-1]
    commands = Commands(load_timeout_ns, frame_prefix)
    loop = SimulationLoop(
        simulation, lambda: MessageStream(scene, choice=a_choice()), lambda message: None, "fastest", commands=commands
    )
    loop.paced.paused = True
    return SimpleNamespace(
        loop=loop,
        run=lambda seconds: loop.step(0, seconds),
        tell=lambda name, message: loop.obey(0, obeyed[name], message),
        channel=lambda name: np.concatenate([block.values[name] for block in blocks]),
    )
