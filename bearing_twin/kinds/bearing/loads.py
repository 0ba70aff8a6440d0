"""The loads of a bearing as others take them: the wrench on each body, every contact as one row, where frames are."""

import numpy as np

from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.topics import NUMBERS
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
    force, torque = sample["raceway_force"], sample["raceway_torque"]
    if sample["neighbour_load"].any():
        position, point = sample["position"], sample["neighbour_point"]
        push = sample["neighbour_load"][:, None] * sample["neighbour_normal"] + sample["neighbour_friction"]
        ahead = np.cross(point - position, push)
        behind = np.cross(point - np.roll(position, -1, axis=0), -push)  # on the next ball
        force = force + push - np.roll(push, 1, axis=0)
        torque = torque + ahead + np.roll(behind, 1, axis=0)
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
    touching = sample["neighbour_approach"] > 0.0
    rows = {
        "in_contact": touching,
        "approach": sample["neighbour_approach"],
        "normal_load": load,
        "point": point,
        "normal": normal,
        "friction_force": sample["neighbour_friction"],
        **{name: np.zeros(len(load)) for name in NUMBERS if name not in ("approach", "normal_load")},
        **{name: np.zeros((len(load), 3)) for name in ("major_axis", "slip")},
    }
    curvature = 2.0 / parameters.geometry.ball_diameter  # of the gap between two balls, the same all round
    modulus = effective_modulus(parameters.materials.ball, parameters.materials.ball)
    position, velocity, spin = (sample[name] for name in ("position", "velocity", "angular_velocity"))
    for k in np.flatnonzero(touching):
        other = (k + 1) % len(load)
        own = velocity[k] + np.cross(spin[k], point[k] - position[k])
        relative = own - velocity[other] - np.cross(spin[other], point[k] - position[other])
        across = np.array([0.0, 0.0, 1.0]) - normal[k, 2] * normal[k]
        rows["slip"][k] = relative - relative @ normal[k] * normal[k]
        rows["spin_rate"][k] = (spin[k] - spin[other]) @ normal[k]
        rows["major_axis"][k] = across / np.linalg.norm(across)
        rows["contact_angle"][k] = np.arctan2(-normal[k, 2], np.hypot(*normal[k, :2]))
        spot = ellipse(curvature, curvature, modulus, load[k])
        rows["semi_major"][k], rows["semi_minor"][k], rows["peak_pressure"][k] = spot
    return rows
