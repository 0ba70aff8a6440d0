"""The loads of a bearing as others take them: the wrench on each body, every contact as one row, where frames are."""

import numpy as np

from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.sample import Sample, Wrench

RINGS = ("inner_ring", "outer_ring")


def bodies(parameters: BearingScene) -> list[str]:
    """Names of the bodies: the balls, then the rings."""
    return [*(f"ball_{k}" for k in range(parameters.geometry.balls)), *RINGS]


def origins(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """Where the frames of the bodies have their origins [m]: centres of balls and rings, in `bearing_link`."""
    centres = [*sample["position"], sample["inner_ring_offset"], np.zeros(3)]
    return dict(zip(bodies(parameters), centres, strict=True))


def wrenches(parameters: BearingScene, sample: Sample) -> list[Wrench]:
    """The wrench of all contacts on each ball about its centre, then those on the rings about theirs."""
    position, point = sample["position"], sample["neighbour_point"]
    push = sample["neighbour_load"][:, None] * sample["neighbour_normal"] + sample["neighbour_friction"]
    ahead = np.cross(point - position, push)
    behind = np.cross(point - np.roll(position, -1, axis=0), -push)  # on the next ball
    force = sample["raceway_force"] + push - np.roll(push, 1, axis=0)
    torque = sample["raceway_torque"] + ahead + np.roll(behind, 1, axis=0)
    rows = [
        Wrench(f"ball_{k}", "raceways and balls", "ball centre", f"ball_{k}", force[k], torque[k])
        for k in range(parameters.geometry.balls)
    ]
    for ring in RINGS:
        rows.append(Wrench(ring, "balls", "ring centre", ring, sample[f"{ring}_force"], sample[f"{ring}_torque"]))
    return rows


def contacts(parameters: BearingScene, sample: Sample) -> dict:
    """The fields of Contacts: ball k with raceway r is row 2 k + r, then ball k with the next ball ahead."""
    balls = parameters.geometry.balls
    ball = np.arange(balls)
    raceway = {
        **{name: sample[name] for name in ("approach", "normal_load", "contact_angle")},
        **{name: sample[name] for name in ("point", "normal", "friction_force", "slip")},
        **contact_details(parameters, sample),
        # The channels count both about the line from the ball to the raceway, against `normal`.
        "spin_rate": -sample["spin_rate"],
        "drilling_torque": -sample["drilling_torque"],
    }
    pairs = [np.repeat(ball, 2), np.tile((balls, balls + 1), balls)]
    if balls == 1:
        rows = raceway
    else:
        rows = {
            name: np.concatenate([raceway[name].reshape(2 * balls, *values.shape[1:]), values])
            for name, values in _neighbours(parameters, sample).items()
        }
        pairs = [np.concatenate(pair) for pair in zip(pairs, (ball, (ball + 1) % balls), strict=True)]
    return {"balls": balls, "bodies": bodies(parameters), "body": pairs[0], "by": pairs[1], **rows}


def _neighbours(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """One row for each ball and the next ahead, of spheres that roll on each other."""
    load, normal, point = (sample[f"neighbour_{name}"] for name in ("load", "normal", "point"))
    touching = (sample["neighbour_approach"] > 0.0)[:, None]
    arm = point - sample["position"]
    surface = sample["velocity"] + np.cross(sample["angular_velocity"], arm)
    spin, place, velocity = (np.roll(sample[n], -1, axis=0) for n in ("angular_velocity", "position", "velocity"))
    relative = np.where(touching, surface - velocity - np.cross(spin, point - place), 0.0)
    slip = relative - np.sum(relative * normal, axis=1, keepdims=True) * normal
    curvature = 2.0 / parameters.geometry.ball_diameter  # of the gap between two balls, the same all round
    modulus = effective_modulus(parameters.materials.ball, parameters.materials.ball)
    spots = np.array([ellipse(curvature, curvature, modulus, one) if one > 0.0 else (0.0,) * 3 for one in load])
    across = np.array([0.0, 0.0, 1.0]) - normal[:, 2:] * normal
    across = np.where(touching, across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300), 0.0)
    return {
        "in_contact": touching[:, 0],
        "approach": sample["neighbour_approach"],
        "normal_load": load,
        "semi_major": spots[:, 0],
        "semi_minor": spots[:, 1],
        "peak_pressure": spots[:, 2],
        "contact_angle": np.arctan2(-normal[:, 2], np.hypot(normal[:, 0], normal[:, 1])),
        "spin_rate": np.sum((sample["angular_velocity"] - spin) * normal, axis=1),
        "drilling_torque": np.zeros(len(load)),
        "point": point,
        "normal": normal,
        "major_axis": across,
        "friction_force": sample["neighbour_friction"],
        "slip": slip,
    }
