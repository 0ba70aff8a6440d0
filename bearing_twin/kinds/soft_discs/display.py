"""The topics of soft discs: wrenches, the contact, frames and markers, as fields of messages.

The frame of the scene has its origin on the wall where the disc touches first, x along the wall, y away from it and z
along the axis of the disc. Of two discs the other is below the plane y = 0, of equal ones its mirror image.
"""

import numpy as np

from bearing_twin.base.sample import Channel, Sample
from bearing_twin.kinds.contract import PUBLISH, Output, Topic
from bearing_twin.kinds.soft_discs import SOFT_DISCS
from bearing_twin.kinds.soft_discs.derived import bodies_of
from bearing_twin.kinds.soft_discs.mesh import density_at_nodes, edges_of, half_disc, triangles_of
from bearing_twin.kinds.soft_discs.motion import bodies_in_units
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene
from bearing_twin.kinds.topics import (
    BLUE,
    CYLINDER,
    GLASS,
    LINE_STRIP,
    MARKER_ARRAY,
    ORANGE,
    STEEL,
    ContactPair,
    load_marker,
    marker,
    pair_topics,
    times,
)
from bearing_twin.kinds.views import DARK, Look, MovingMesh, Solid, View, curves, energies, view_of

FRAME = SOFT_DISCS.frame
AXIS, UP = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def bodies(parameters: SoftDiscsScene) -> tuple[str, str]:
    """The disc, and what it meets."""
    return ("disc", "wall") if parameters.against == "wall" else ("disc", "other_disc")


def topics(parameters: SoftDiscsScene) -> tuple[Topic, ...]:
    """The topics of a soft disc."""
    disc, other = bodies(parameters)
    about = "the point of first touch" if other == "wall" else "its centre of mass"
    texts = {disc: f"on the disc, by the {other}, about its centre of mass", other: f"on the {other}, about {about}"}
    return (
        *pair_topics(FRAME, pair_of, texts, solids),
        Topic("markers", MARKER_ARRAY, PUBLISH, marker_fields, "outlines of the deformed bodies", FRAME),
    )


def solids(parameters: SoftDiscsScene) -> dict[str, list[dict]]:
    """The bodies as markers in their frames: the discs, undeformed."""
    size = 2.0 * parameters.disc.radius, 2.0 * parameters.disc.radius, parameters.disc.thickness
    return {body: [marker(body, 0, CYLINDER, size, GLASS)] for body in bodies(parameters) if body != "wall"}


def pair_of(parameters: SoftDiscsScene, sample: Sample) -> ContactPair:
    """The contact: half the length and half the width of the strip, and the pressure where it is greatest.

    The pressure is that of the penalty per undeformed length; the width that of the rim's nodes below the wall.
    """
    disc, height, depth = parameters.disc, sample["position"], sample["penetration"]
    opposite = {"wall": 0.0 * height, "disc": -height}.get(parameters.against)
    rim = _rim(parameters, sample, "shape")
    inside, stiffness = rim[..., 1] < 0.0, parameters.contact.stiffness_ratio
    if opposite is None:
        opposite, stiffness = -sample["other_position"], bodies_in_units(parameters.resolve())[0].stiffness
        inside = _above(rim, _rim(parameters, sample, "other_shape")) > rim[..., 1]
    pressure = stiffness * disc.material.young_modulus * (depth / disc.radius) ** parameters.contact.exponent
    width = np.where(inside, rim[..., 0], 0.0).max(axis=-1)
    positions, load = (times(height, UP), times(opposite, UP), np.zeros(3)), sample["normal_load"]
    return ContactPair(*positions, -UP, depth, load, 0.5 * disc.thickness, width, pressure, major_axis=AXIS)


def _above(rim: np.ndarray, opposite: np.ndarray) -> np.ndarray:
    """Height [m] of the other disc's rim, which is upside down, at the places of this one's."""
    pairs = zip(rim.reshape(-1, *rim.shape[-2:]), opposite.reshape(-1, *opposite.shape[-2:]), strict=True)
    heights = [np.interp(points[:, 0], far[:, 0], far[:, 1], right=np.inf) for points, far in pairs]
    return -np.array(heights).reshape(rim.shape[:-1])


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the rim of the deformed disc, the wall or the other disc, and the force."""
    parameters, sample = output.parameters, output.sample
    radius, against = parameters.disc.radius, parameters.against
    line = _closed(_rim(parameters, sample, "shape"))
    if against == "wall":
        opposite = [(-1.5 * radius, 0.0, 0.0), (1.5 * radius, 0.0, 0.0)]
    else:
        opposite = _closed(_rim(parameters, sample, "other_shape")) if against == "other_disc" else line
        opposite = opposite * (1.0, -1.0, 1.0)
    width = (0.02 * radius, 0.0, 0.0)
    return {
        "markers": [
            marker("disc", 0, LINE_STRIP, width, ORANGE, points=line),
            marker("other", 0, LINE_STRIP, width, STEEL if against == "wall" else BLUE, points=opposite),
            load_marker(sample["normal_load"], 0.7 * radius, (1.2 * radius, 0.3 * radius, 0.0)),
        ]
    }


def _closed(rim: np.ndarray) -> np.ndarray:
    """Half a rim (..., n, 2) and its mirror image, one line (..., 2 n, 3)."""
    line = np.concatenate([rim, rim[..., ::-1, :] * (-1.0, 1.0)], axis=-2)
    return np.concatenate([line, np.zeros_like(line[..., :1])], axis=-1)


def _rim(parameters: SoftDiscsScene, sample: Sample, shape: str) -> np.ndarray:
    """Places (..., n, 2) of the nodes on the rim of a disc, from the bottom to the top."""
    return sample[shape][..., half_disc(parameters.resolve().mesh).outline, :]


ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "strain"), ("contact_energy", "in the penalty"))
HALVES = {  # signs of x and y of the halves drawn of a disc, by what it meets; the mesh is of one half
    "wall": ((1.0, 1.0), (-1.0, 1.0)),
    "disc": ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)),
    "other_disc": ((1.0, 1.0), (-1.0, 1.0)),
}
BELOW = ((1.0, -1.0), (-1.0, -1.0))


def view(parameters, channels) -> View:
    """x across the line of flight, y away from the wall or the place of first touch."""
    mesh = half_disc(parameters.mesh)
    bodies = dict(zip(("shape", "other_shape"), bodies_of(parameters).values(), strict=False))
    nodes = (len(mesh.mass) - 1,)
    densities = tuple(Channel(f"{name}_energy", "J/m³", nodes, "strain energy at the nodes") for name in bodies)
    triangles, edges = triangles_of(mesh).tolist(), _pairs(mesh)

    def rows(sample):
        return {f"{name}_energy": density_at_nodes(body, mesh, sample[name]) for name, body in bodies.items()}

    signs = dict(zip(bodies, (HALVES[parameters.against], BELOW), strict=False))
    radius = parameters.disc.radius
    tall = {"wall": radius, "disc": 2.0 * radius, "other_disc": radius + parameters.other.radius}[parameters.against]
    shared = tuple(channel.name for channel in densities)
    middle = {"wall": radius, "disc": 0.0, "other_disc": radius - parameters.other.radius}[parameters.against]
    facing = "the wall" if parameters.against == "wall" else "the other disc"
    velocities = (("velocity", "disc"), ("other_velocity", "other disc"))[: len(bodies)]
    wall = Solid("wall", "wall", {"slab": {"width": 4.0 * radius, "height": 0.06 * radius}}, DARK)
    return view_of(
        channels,
        densities,
        rows,
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            curves(f"Velocity of the centre of mass, away from {facing}", "m/s", *velocities),
            energies(*ENERGIES),
            curves("Least principal stretch", "1", ("least_stretch", "least stretch")),
            curves(f"Depth of the rim in {facing}", "m", ("penetration", "depth")),
        ),
        solids=(wall,) if parameters.against == "wall" else (),
        marks=tuple(
            MovingMesh(name, "strain energy", name, triangles, edges, f"{name}_energy", shared, signs[name])
            for name in bodies
        ),
        look=Look(1.1 * tall, middle=(0.0, middle, 0.0)),
        words="The mesh is that of the computation, true to scale; the other half of a disc is its mirror.",
    )


def _pairs(mesh) -> list[tuple[int, int]]:
    """Ends of the lines between neighbouring nodes on the sides of elements, each once."""
    lines = np.concatenate([np.stack([side[:, :-1], side[:, 1:]], axis=-1).reshape(-1, 2) for side in edges_of(mesh)])
    return np.unique(np.sort(lines, axis=1), axis=0).tolist()
