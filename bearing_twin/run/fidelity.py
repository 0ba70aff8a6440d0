"""The cheapest adequate model for a scene, and why: each kind weighs its own laws and methods in its `models`."""

from bearing_twin.kinds import KINDS
from bearing_twin.report import Choice
from bearing_twin.run.scene import Scene


def choose(scene: Scene) -> Choice:
    """Law and stepper for a scene; raises SceneError where a bearing has no start."""
    return KINDS[scene.kind].choose(scene.parameters)
