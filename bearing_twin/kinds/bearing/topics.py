"""The topics of a bearing: wrenches, contacts, state, joints and markers, as fields of messages.

They take many outputs at once, with one row an output in front of every array.
"""

import numpy as np

from bearing_twin.base.sample import Sample
from bearing_twin.kinds.bearing.accelerometer import Listener, tables
from bearing_twin.kinds.bearing.markers import markers, solids
from bearing_twin.kinds.bearing.outputs import RINGS, contact_details, contacts, origins, ring_attitude, wrenches
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.rings import moving_centre
from bearing_twin.kinds.bearing.row import BEARING
from bearing_twin.kinds.contract import MARKERS, PUBLISH, SECOND, Command, Output, Topic
from bearing_twin.kinds.topics import (
    DIAGNOSTICS,
    FLOAT,
    MARKER_ARRAY,
    POSE,
    body_topics,
    contacts_topic,
    load_command,
    turning_commands,
)

FRAME = BEARING.frame
STATE_ARRAYS = ("orbit_angle", "position", "velocity", "orientation", "angular_velocity", "roll_rate")
STATE_NUMBERS = (
    "inner_ring_angle", "inner_ring_speed", "drive_torque", "kinetic_energy", "elastic_energy", "potential_energy",
    "drive_work", "dissipated",
)  # fmt: skip


def topics(parameters: BearingScene) -> tuple[Topic, ...]:
    """The topics of a bearing with these balls."""
    balls = parameters.geometry.balls
    texts = {f"ball_{k}": f"on ball {k}, by raceways and neighbours, about its centre" for k in range(balls)}
    texts |= dict.fromkeys(RINGS, "on the ring, by the balls and a cage on its land, about its centre")
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids, together=True),
        contacts_topic(
            FRAME, contacts, "all contacts, of balls with raceways and with each other, as arrays", together=True
        ),
        Topic(
            "state", "bearing_twin_msgs/msg/BearingState", PUBLISH, state, "motion of balls and rings, energies", FRAME,
            together=True,
        ),
        Topic(
            "inner_ring/pose", POSE, PUBLISH, ring_pose, "centre and attitude of the inner ring, tilted and turned",
            FRAME, together=True,
        ),
        Topic(
            "joint_states", "sensor_msgs/msg/JointState", PUBLISH, joints, "angles of inner ring and orbits", FRAME,
            together=True,
        ),
        *_cage_topics(parameters),
        *(
            Topic(
                "health", DIAGNOSTICS, SECOND, Listener,
                "of a scene with a sensor: damage that the spectrum of its last 10 s names, and levels of lines [dB]",
            )
            for _ in tables(parameters)
        ),
        Topic(
            "markers", MARKER_ARRAY, MARKERS, marker_fields, "balls, rings, ellipses, loads to look at", FRAME,
            together=True,
        ),
    )  # fmt: skip


def _cage_topics(parameters: BearingScene) -> tuple[Topic, ...]:
    if parameters.cage.kind == "none":
        return ()
    text = (
        "of a cage, where there is one: angle [rad], speed [rad/s]; effort: torque of the balls on it [N m]; and x, y "
        "of a centre that moves [m, m/s]; effort: force of the land on it [N]"
    )
    return (Topic("cage/state", "sensor_msgs/msg/JointState", PUBLISH, cage, text, FRAME, together=True),)


def commands() -> tuple[Command, ...]:
    """The topics that a running bearing obeys."""
    speed, stamped = turning_commands("the inner ring", FRAME)
    torque = Command(
        "command/torque", FLOAT, lambda message: ("set_torque", message.data),
        "torque on the inner ring about +z [N m], of a scene whose drive.kind is torque; held until the next",
    )  # fmt: skip
    return speed, torque, stamped, load_command("on the inner ring about its centre", FRAME)


def state(output: Output) -> dict:
    """bearing_twin_msgs/BearingState."""
    sample = output.sample
    return {
        "sequence": sample.sequence,
        "balls": output.parameters.geometry.balls,
        "cage_speed": orbit_rates(sample).mean(axis=-1),
        "inner_ring_offset": sample["inner_ring_offset"],
        "inner_ring_tilt": sample["inner_ring_tilt"],
        **{name: sample[name] for name in STATE_ARRAYS + STATE_NUMBERS},
    }


def ring_pose(output: Output) -> dict:
    """geometry_msgs/PoseStamped of the inner ring."""
    sample = output.sample
    attitude = ring_attitude(sample["inner_ring_tilt"], sample["inner_ring_angle"])
    return {"pose": {"position": sample["inner_ring_offset"], "orientation": attitude}}


def joints(output: Output) -> dict:
    """sensor_msgs/JointState: angle [rad] and speed [rad/s] of the inner ring and of each ball's orbit."""
    sample = output.sample
    balls = output.parameters.geometry.balls
    return {
        "name": ["inner_ring_joint", *(f"ball_{k}_orbit_joint" for k in range(balls))],
        "position": np.concatenate([sample["inner_ring_angle"][..., None], sample["orbit_angle"]], axis=-1),
        "velocity": np.concatenate([sample["inner_ring_speed"][..., None], orbit_rates(sample)], axis=-1),
    }


def cage(output: Output) -> dict:
    """sensor_msgs/JointState of the cage: angle [rad], speed [rad/s], and torque of the balls on it about +z [N m].

    The angle is 0 where ball 0 is in the middle of its pocket. The torque is that of the forces along the orbits; what
    friction of the pockets adds, at most cage.friction times ball diameter over pitch diameter of it, is left out.
    Equilibria know none: it is 0 there. Of a centre that moves: x and y [m], velocity [m/s], force of the land [N].
    """
    sample, moving = output.sample, moving_centre(output.parameters)
    x, y, _ = np.moveaxis(sample["position"], -1, 0)
    torque = -(sample["pocket_force"] * np.hypot(x, y)).sum(axis=-1)
    return {
        "name": ["cage_joint", *(("cage_x_joint", "cage_y_joint") if moving else ())],
        "position": _with_centre(sample["cage_angle"], sample["cage_offset"], moving),
        "velocity": _with_centre(sample["cage_speed"], sample["cage_velocity"], moving),
        "effort": _with_centre(torque, sample["land_force"], moving),
    }


def _with_centre(turning, centre, moving: bool) -> np.ndarray:
    return np.concatenate([turning[..., None], centre], axis=-1) if moving else turning[..., None]


def marker_fields(output: Output) -> list[tuple[np.ndarray, dict]]:
    """visualization_msgs/MarkerArray, for each number of ellipses and arrows that occurs."""
    found = markers(output.parameters, output.sample, output.once(contact_details))
    return [(rows, {"markers": fields}) for rows, fields in found]


def orbit_rates(sample: Sample) -> np.ndarray:
    """Angular velocity [rad/s] of each ball's centre about the bearing's axis."""
    x, y, _ = np.moveaxis(sample["position"], -1, 0)
    along_x, along_y, _ = np.moveaxis(sample["velocity"], -1, 0)
    return (x * along_y - y * along_x) / (x**2 + y**2)
