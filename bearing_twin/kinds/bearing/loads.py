"""The loads of a bearing as others take them: the wrench on each body, every contact as one row, where frames are.

A sample may hold many outputs: one row each in front of all its arrays, and of those given.
"""

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.topics import NUMBERS

RINGS = ("inner_ring", "outer_ring")


def bodies(parameters: BearingScene) -> list[str]:
    """Names of the bodies: the balls, then the rings."""
    return [*(f"ball_{k}" for k in range(parameters.geometry.balls)), *RINGS]


def origins(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """Where the frames of the bodies have their origins [m]: centres of balls and rings, in `bearing_link`."""
    offset = sample["inner_ring_offset"]
    centres = [*np.moveaxis(sample["position"], -2, 0), offset, np.zeros(offset.shape)]
    return dict(zip(bodies(parameters), centres, strict=True))


def ring_attitude(tilt: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4) x, y, z, w of a ring turned by `angle` (...) [rad] about z, then tilted.

    `tilt` (..., 2) [rad] is a rotation vector about x and y.
    """
    half = 0.5 * np.asarray(tilt)
    size = np.sqrt(half[..., 0] ** 2 + half[..., 1] ** 2)
    x, y = np.moveaxis(half, -1, 0) * np.sinc(size / np.pi)
    w, cosine, sine = np.cos(size), np.cos(0.5 * np.asarray(angle)), np.sin(0.5 * np.asarray(angle))
    return np.stack([x * cosine + y * sine, y * cosine - x * sine, w * sine, w * cosine], axis=-1)


def wrenches(parameters: BearingScene, sample: Sample) -> list[Wrench]:
    """The wrench of all contacts on each ball about its centre, then those on the rings about theirs."""
    force, torque = sample["raceway_force"], sample["raceway_torque"]
    touching = sample["neighbour_load"].any(axis=-1)[..., None, None]
    if touching.any():
        position, point = sample["position"], sample["neighbour_point"]
        push = sample["neighbour_load"][..., None] * sample["neighbour_normal"] + sample["neighbour_friction"]
        ahead = np.cross(point - position, push)
        behind = np.cross(point - np.roll(position, -1, axis=-2), -push)  # on the next ball
        force = np.where(touching, force + push - np.roll(push, 1, axis=-2), force)
        torque = np.where(touching, torque + ahead + np.roll(behind, 1, axis=-2), torque)
    rows = [
        Wrench(f"ball_{k}", "raceways and balls", "ball centre", f"ball_{k}", force[..., k, :], torque[..., k, :])
        for k in range(parameters.geometry.balls)
    ]
    for ring in RINGS:
        rows.append(Wrench(ring, "balls", "ring centre", ring, sample[f"{ring}_force"], sample[f"{ring}_torque"]))
    return rows


def contacts(parameters: BearingScene, sample: Sample) -> dict:
    """The fields of Contacts: ball k with raceway r is row 2 k + r, then ball k with the next ball ahead."""
    balls = parameters.geometry.balls
    raceway = {
        **{name: sample[name] for name in ("approach", "normal_load", "contact_angle")},
        **{name: sample[name] for name in ("point", "normal", "friction_force", "slip")},
        **contact_details(parameters, sample),
        # The channels count both about the line from the ball to the raceway, against `normal`.
        "spin_rate": -sample["spin_rate"],
        "drilling_torque": -sample["drilling_torque"],
    }
    body, by = [k // 2 for k in range(2 * balls)], [balls, balls + 1] * balls
    outer = sample["approach"].shape[:-2]
    rows = {name: array.reshape(*outer, 2 * balls, *array.shape[len(outer) + 2 :]) for name, array in raceway.items()}
    if balls > 1:
        for name, values in _neighbours(parameters, sample).items():
            rows[name] = np.concatenate([rows[name], values], axis=len(outer))
        body, by = [*body, *range(balls)], [*by, *((k + 1) % balls for k in range(balls))]
    return {"balls": balls, "bodies": bodies(parameters), "body": body, "by": by, **rows}


def _neighbours(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """One row for each ball and the next ahead, of spheres that roll on each other."""
    load, normal, point = (sample[f"neighbour_{name}"] for name in ("load", "normal", "point"))
    touching = sample["neighbour_approach"] > 0.0
    rows = {
        "in_contact": touching,
        "approach": sample["neighbour_approach"],
        "normal_load": load,
        "point": point,
        "normal": normal,
        "friction_force": sample["neighbour_friction"],
        **{name: np.zeros(load.shape) for name in NUMBERS if name not in ("approach", "normal_load")},
        **{name: np.zeros(point.shape) for name in ("major_axis", "slip")},
    }
    curvature = 2.0 / parameters.geometry.ball_diameter  # of the gap between two balls, the same all round
    modulus = effective_modulus(parameters.materials.ball, parameters.materials.ball)
    position, velocity, spin = (sample[name] for name in ("position", "velocity", "angular_velocity"))
    for one in zip(*np.nonzero(touching), strict=True):
        other = (*one[:-1], (one[-1] + 1) % load.shape[-1])
        across = normal[one]
        own = velocity[one] + np.cross(spin[one], point[one] - position[one])
        relative = own - velocity[other] - np.cross(spin[other], point[one] - position[other])
        axis = np.array([0.0, 0.0, 1.0]) - across[2] * across
        rows["slip"][one] = relative - relative @ across * across
        rows["spin_rate"][one] = (spin[one] - spin[other]) @ across
        rows["major_axis"][one] = axis / np.linalg.norm(axis)
        rows["contact_angle"][one] = np.arctan2(-across[2], np.hypot(*across[:2]))
        spot = ellipse(curvature, curvature, modulus, load[one])
        rows["semi_major"][one], rows["semi_minor"][one], rows["peak_pressure"][one] = spot
    return rows
