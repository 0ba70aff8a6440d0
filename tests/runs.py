"""Whole runs for tests: their reports; single messages into recordings."""

from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate


def reported(scene, *overrides):
    """The report of a whole run."""
    run = simulate(load_scene(scene, overrides))
    for _ in run.blocks():
        pass
    return run.report


def receive(recording, topic, received_ns, sent_ns, data, number=None):
    """Hands one message to a recording; how many solver outputs were lost just before it."""
    return recording.receive_all(topic, [received_ns], [sent_ns], [data], [number])
