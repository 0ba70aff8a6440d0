"""A soft disc on a rigid wall, or on another disc, as a run: channels at any instant, and what the impact was.

Two equal discs are each other's mirror image: the plane between them is a wall without friction, to which each comes at
half the relative speed; positions, velocities and energies are those of one disc. Of two unequal ones both are meshed,
energies are those of both; heights are above the place of first touch in the frame of the common centre of mass.
"""

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion
from bearing_twin.kinds.soft_discs.derived import nodes_of, resolve, wall_speed
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene
from bearing_twin.kinds.soft_discs.solve import GREATEST_FRAMES, Solved, solve

NODES = ("node", "in_plane")  # axes of a shape


def channels(parameters: SoftDiscsScene) -> tuple[Channel, ...]:
    """What one sample of this scene holds."""
    nodes = nodes_of(resolve(parameters).mesh.divisions)
    return (
        Channel("normal_load", "N", (), "contact force on the whole disc, away from the wall"),
        Channel("position", "m", (), "height of the centre of mass above the wall or the place of first touch"),
        Channel("velocity", "m/s", (), "of the centre of mass, away from the wall"),
        Channel("penetration", "m", (), "greatest depth of the rim below the wall"),
        Channel("least_stretch", "1", (), "least principal stretch in the plane of the discs"),
        Channel(
            "kinetic_energy",
            "J",
            (),
            "of the whole disc or both, product of the velocities half a step before and after",
        ),
        Channel("elastic_energy", "J", (), "strain energy of the whole disc or both"),
        Channel("contact_energy", "J", (), "stored in the penalty of the contact"),
        Channel(
            "shape", "m", (nodes, 2), "nodes of the half disc x >= 0: x from the line of flight, y off the wall", NODES
        ),
        *(
            (
                Channel(
                    "other_position", "m", (), "depth of the other's centre of mass below the place of first touch"
                ),
                Channel("other_velocity", "m/s", (), "of the other's centre of mass, away from the disc"),
                Channel("other_shape", "m", (nodes, 2), "nodes of the other's half, y away from the disc", NODES),
            )
            if parameters.against == "other_disc"
            else ()
        ),
    )


OF_HISTORY = {
    "normal_load": "force", "position": "position", "velocity": "velocity", "penetration": "depth",
    "least_stretch": "least_stretch", "kinetic_energy": "kinetic", "elastic_energy": "elastic",
    "contact_energy": "contact",
}  # fmt: skip
"""Columns of the history by channel."""
OF_OTHER = {"other_position": "other_position", "other_velocity": "other_velocity"}


def solved_impact(parameters: SoftDiscsScene, law: str = "", stepper: str = "") -> Impact:
    """The impact; raises IntegrationError where the disc collapses."""
    parameters = resolve(parameters)
    outputs = round(parameters.run.duration * parameters.run.output_rate) + 1
    found = solve(parameters, min(outputs, GREATEST_FRAMES))
    speed, total = wall_speed(parameters), found.column("kinetic") + found.column("elastic") + found.column("contact")
    figures, brought = figures_of(found, speed), total[0]
    duration, peak_force = figures["contact_duration_s"], figures["peak_force_n"]
    gained = float(total[int(np.argmax(np.abs(total - brought)))] - brought)
    known = [
        duration, peak_force, figures["peak_time_s"], duration, figures["impulse_ns"], figures["restitution"],
        figures["greatest_penetration_m"], gained, figures["least_stretch"],
        float(np.abs(found.column("balance")).max()), float(figures["touches"]), float(found.ended),
    ]  # fmt: skip
    records = {"impact": np.array([known])}
    radius, other = parameters.disc.radius, parameters.other.radius
    both = parameters.against == "other_disc"

    def at(times):
        one = (*(found.at(name, times) for name in OF_HISTORY.values()), found.shape_at(radius, times))
        if not both:
            return one
        return (*one, *(found.at(name, times) for name in OF_OTHER.values()), found.shape_at(other, times, 1))

    costs = {
        "steps": len(found.history),
        "nodes": (1 + both) * (len(found.mesh.x) - 1),
        "elements": (1 + both) * len(found.mesh.elements),
    }
    return Impact(at, parameters.run, records, costs)


def duration_and_touches(found: Solved) -> tuple[float, int]:
    """From first touch to last contact [s], gaps included, and how often the disc touched the wall.

    The force of the last steps is drawn on by a straight line to where it is zero, at most one step.
    """
    force = found.column("force")
    inside = force > 0.0
    touching = np.flatnonzero(inside)
    if not len(touching):
        return 0.0, 0
    last = touching[-1]
    fall = force[last - 1] - force[last] if last else 0.0
    beyond = min(1.0, force[last] / fall) if fall > 0.0 else 1.0
    touches = int(np.sum(inside[1:] & ~inside[:-1]) + inside[0])
    return float((last + beyond) * found.step), touches


def figures_of(found: Solved, speed: float) -> dict[str, float]:
    """The figures of a motion whose disc came at this speed [m/s]."""
    force, (duration, touches) = found.column("force"), duration_and_touches(found)
    peak = int(np.argmax(force))
    return {
        "peak_force_n": float(force[peak]),
        "peak_time_s": peak * found.step,
        "contact_duration_s": duration,
        "impulse_ns": float(force.sum()) * found.step,
        "restitution": float(found.column("velocity")[-1]) / speed,
        "greatest_penetration_m": float(found.column("depth").max()),
        "least_stretch": float(found.column("least_stretch").min()),
        "touches": touches,
    }


def motion(parameters: SoftDiscsScene, choice: Choice) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solved_impact, parameters, choice)
