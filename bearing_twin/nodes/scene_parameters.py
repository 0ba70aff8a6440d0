"""What sim_node is told when it starts: its parameters and the scene they name, whose kind decides the namespace."""

from typing import Any

from rclpy.node import Node

from bearing_twin.errors import SceneError
from bearing_twin.kinds import KINDS
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, LOG_SAFETY, NOT_ALLOWED, NodeParameter
from bearing_twin.nodes.pacing import FASTEST, SLOWEST
from bearing_twin.nodes.running import given_parameters, values_of
from bearing_twin.run.fidelity import refuse_outside
from bearing_twin.run.scene import Scene, load_scene

NAME = "sim_node"
PARAMETERS = (
    NodeParameter(
        "scene",
        "bearing_6203",
        "scene to run: a name, a designation such as 6308, or the path of a YAML file",
        digits=True,
    ),
    NodeParameter("overrides", [], "changes to the scene, such as contact.normal=volumetric"),
    NodeParameter(
        "duration",
        0.0,
        "simulated time of a run; 0 = the scene's own where its motion ends by itself, as an impact, else endless",
        "s",
        0.0,
        86400.0,
    ),
    NodeParameter(
        "repeat",
        0.0,
        "wall time from one begin of a run to the next; 0 = run once and end, -1 = begin again on ~/reset alone",
        "s",
        -1.0,
        86400.0,
    ),
    NodeParameter(
        "real_time_factor",
        1.0,
        f"wanted pace, for an impact 1e-5 or less; {FASTEST} = as fast as possible, which only the log gets without "
        "loss",
        "1",
        SLOWEST,
        1000.0,
        read_only=False,
        words=(FASTEST,),
    ),
    NodeParameter(
        ALLOW_INVALID,
        False,
        "run a model that is asked for outside its range too, every output marked; false refuses scenes that allow it",
    ),
    NodeParameter("start_paused", False, "wait at time 0 until ~/pause is called with false"),
    NodeParameter("discovery", 0.0, "wait at most this long until every topic has a subscriber", "s", 0.0, 600.0),
    NodeParameter("publish_clock", False, "publish simulation time on /clock"),
    NodeParameter(
        "load_timeout",
        0.0,
        "simulated time after which a load on command/load that no other followed is stale: the scene's own load acts "
        "again, and /diagnostics warns; 0 = it holds until replaced",
        "s",
        0.0,
        86400.0,
    ),
    NodeParameter("frame_prefix", "", "stands before the name of every frame, such as left/"),
    NodeParameter("log", "", "MCAP log written by this node, without loss; empty = none"),
    *LOG_SAFETY,
)


def looked_up(options: dict[str, Any]) -> tuple[dict[str, Any], Scene]:
    """The parameters with which a sim_node of these options will start, and their scene; raises BearingTwinError.

    Parameters are handed to a node by its full name, so nodes that live only here ask in the namespace of each kind
    until one is told its scene. A namespace of the user's is the same for all of them.
    """
    found = None
    for namespace in dict.fromkeys(kind.namespace for kind in KINDS.values()):
        asking = Node(
            NAME, namespace=namespace, **(options | {"start_parameter_services": False, "enable_rosout": False})
        )
        try:
            given = given_parameters(asking)
            values, own = values_of(asking, PARAMETERS), asking.get_namespace()
        finally:
            asking.destroy_node()
        if found is None or "scene" in given:
            found = values
        if "scene" in given or own != namespace:
            break
    allowed = [f"solver.{ALLOW_INVALID}=on"] if found[ALLOW_INVALID] else []
    scene = load_scene(found["scene"], [*filter(None, found["overrides"]), *allowed])
    if scene.allows_invalid and not allowed:
        raise SceneError(f"scene {scene.name} has solver.{ALLOW_INVALID}: on, {NOT_ALLOWED}")
    refuse_outside(scene)
    return found, scene
