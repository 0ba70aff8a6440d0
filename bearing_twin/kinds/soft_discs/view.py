"""The view of soft discs: their meshes as they deform, coloured by strain energy."""

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.soft_discs.derived import bodies_of
from bearing_twin.kinds.soft_discs.mesh import half_disc
from bearing_twin.kinds.soft_discs.strain_energy import density_at_nodes, edges_of, triangles_of
from bearing_twin.kinds.views import DARK, Look, MovingMesh, Solid, View, curves, picked

TAKEN = (
    *("normal_load", "position", "velocity", "penetration", "least_stretch", "kinetic_energy", "elastic_energy"),
    *("contact_energy", "shape", "other_velocity", "other_shape"),
)
ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "strain"), ("contact_energy", "in the penalty"))
HALVES = {  # signs of x and y of the halves drawn of a disc, by what it meets; the mesh is of one half
    "wall": ((1.0, 1.0), (-1.0, 1.0)),
    "disc": ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)),
    "other_disc": ((1.0, 1.0), (-1.0, 1.0)),
}
BELOW = ((1.0, -1.0), (-1.0, -1.0))


def view(facts, channels) -> View:
    """x across the line of flight, y away from the wall or the place of first touch."""
    parameters = facts.scene.parameters
    mesh = half_disc(parameters.mesh.divisions, parameters.mesh.order, parameters.mesh.integration)
    bodies = dict(zip(("shape", "other_shape"), bodies_of(parameters).values(), strict=False))
    taken = picked(channels, TAKEN)
    densities = tuple(
        Channel(f"{name}_energy", "J/m³", (_nodes(taken, name),), "strain energy at the nodes") for name in bodies
    )
    triangles, edges = triangles_of(mesh).tolist(), _pairs(mesh)

    def rows(sample):
        found = {one.name: sample[one.name] for one in taken}
        for name, body in bodies.items():
            found[f"{name}_energy"] = density_at_nodes(body, mesh, sample[name])
        return found

    signs = dict(zip(bodies, (HALVES[parameters.against], BELOW), strict=False))
    radius = parameters.disc.radius
    tall = {"wall": radius, "disc": 2.0 * radius, "other_disc": radius + parameters.other.radius}[parameters.against]
    shared = tuple(one.name for one in densities)
    middle = {"wall": radius, "disc": 0.0, "other_disc": radius - parameters.other.radius}[parameters.against]
    facing = "the wall" if parameters.against == "wall" else "the other disc"
    velocities = (("velocity", "disc"), ("other_velocity", "other disc"))[: len(bodies)]
    wall = Solid("wall", "wall", {"slab": {"width": 4.0 * radius, "height": 0.06 * radius}}, DARK)
    return View(
        series=(*taken, *densities),
        rows=rows,
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            curves(f"Velocity of the centre of mass, away from {facing}", "m/s", *velocities),
            curves("Energy", "J", *ENERGIES),
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


def _nodes(taken, name: str) -> int:
    return next(one.shape[0] for one in taken if one.name == name)


def _pairs(mesh) -> list[tuple[int, int]]:
    """Ends of the lines between neighbouring nodes on the sides of elements, each once."""
    lines = np.concatenate([np.stack([side[:, :-1], side[:, 1:]], axis=-1).reshape(-1, 2) for side in edges_of(mesh)])
    return np.unique(np.sort(lines, axis=1), axis=0).tolist()
