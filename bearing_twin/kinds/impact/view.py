"""The view of two colliding bodies: both, drawn with their displacements enlarged, and the force on each."""

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.impact.parameters import TwoDiscsScene
from bearing_twin.kinds.impact.topics import radii
from bearing_twin.kinds.views import BLUE, ORANGE, Arrows, Enlarged, Look, Solid, View, curves, picked

REACH, ARROW, ABOVE = 0.3, 0.9, 1.25  # radii of the smaller body: displacement, longest arrow, height of the arrows
TAKEN = ("approach", "normal_load", "displacement", "velocity", "kinetic_energy", "elastic_energy")
ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "in the contact"))


def view(facts, channels) -> View:
    """Of two spheres or two discs; x along the line of impact, the first contact in the origin."""
    parameters = facts.scene.parameters
    first, second = radii(parameters)
    least = min(first, second)
    force = Channel("forces", "N", (2, 3), "on each body by the other")
    middles, ways = (
        Channel("middles", "m", (2, 3), "centres at the first contact"),
        Channel("ways", "m", (2, 3), "from there"),
    )
    tails = Channel("tails", "m", (2, 3), "where the arrows begin")
    gap = parameters.motion.gap

    def rows(sample):
        count = len(sample["normal_load"])
        places, moved, forces, points = (np.zeros((count, 2, 3)) for _ in range(4))
        places[:, 0, 0], places[:, 1, 0] = -first, second
        moved[..., 0] = sample["displacement"]
        moved[:, 0, 0] -= gap
        forces[:, 0, 0], forces[:, 1, 0] = -sample["normal_load"], sample["normal_load"]
        points[..., 1] = ABOVE * max(first, second)
        points[:, 0, 0], points[:, 1, 0] = -0.04 * least, 0.04 * least
        return {name: sample[name] for name in TAKEN} | {
            "middles": places,
            "ways": moved,
            "forces": forces,
            "tails": points,
        }

    return View(
        series=(*picked(channels, TAKEN), middles, ways, force, tails),
        rows=rows,
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            curves("Approach, negative while there is a gap", "m", ("approach", "approach")),
            curves("Velocities", "m/s", ("velocity", "first", 0), ("velocity", "second", 1)),
            curves("Energy", "J", *ENERGIES),
        ),
        solids=tuple(_bodies(parameters, first, second)),
        marks=(
            Arrows(
                "forces", "force on each body", "N", "forces", ARROW * least, (BLUE, ORANGE), point="tails",
                from_point=True,
            ),
        ),
        look=Look(
            first + second,
            (0.25, 0.28, 0.93),
            middle=(second - first, 0.1 * least, 0.0),
            at_start=((second, 0.0, 0.0), first + second),  # the origin is the first body's centre
        ),
        enlarged=Enlarged("displacements", ("ways",), REACH * least),
        words="Where the bodies overlap they are pressed flat: the overlap is the approach, as much enlarged.",
    )  # fmt: skip


def _bodies(parameters, first: float, second: float):
    # faces in one plane would flicker: the second disc is drawn a little thinner
    for place, (name, radius) in enumerate((("first", first), ("second", second))):
        if isinstance(parameters, TwoDiscsScene):
            shape = {"cylinder": {"radius": radius, "length": parameters.disc.thickness * (1.0 - 0.002 * place)}}
        else:
            shape = {"ellipsoid": (radius,) * 3}
        yield Solid(
            name, f"{name} body", shape, (BLUE, ORANGE)[place],
            place=place, position="middles", deviation="ways", opacity=0.62,
        )  # fmt: skip
