"""The cheapest adequate model for a scene, and why: each kind weighs its own laws and methods in its `models`."""

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import Scene


def choose(scene: Scene) -> Choice:
    """Law and stepper for a scene; raises SceneError where a bearing has no start, or a model leaves its range."""
    refuse_outside(scene)
    return KINDS[scene.kind].choose(scene.parameters)._replace(outside=scene.outside)


def refuse_outside(scene: Scene) -> None:
    """Raises SceneError where a model that is asked for leaves its range, and the scene does not allow that."""
    if scene.outside and not scene.allows_invalid:
        told = "; ".join(scene.outside)
        raise SceneError(
            f"scene {scene.name}: {told}, or let it run all the same by --allow-invalid (solver.allow_invalid: on), "
            "which marks every output"
        )
