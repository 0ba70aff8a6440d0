"""The picture of a run or of a log: the same numbers, the same picture."""

from pathlib import Path

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Facts, Picture, plain_picture


def picture_of(stream) -> Picture:
    """An empty picture of a run or a log, by its kind; of a log without a scene, one drawn from its channels."""
    scene, choice = stream.scene, stream.choice
    facts = Facts(scene, choice.law, choice.stepper)
    return plain_picture(facts) if scene is None else KINDS[scene.kind].picture(facts)


def plot(stream, path) -> Path:
    """Draws a run (which is then simulated) or a log to a PNG; returns its path. Raises BearingTwinError."""
    picture = picture_of(stream)
    for block in stream.blocks():
        picture.add(block)
    return picture.write(path)
