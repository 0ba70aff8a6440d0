"""Bodies that collide: spheres and discs on a line, an ellipsoid on a plane, any two bodies with implicit surfaces.

The rows of their kinds in the table of kinds, and the quantities of their studies.

* `parameters`: scenes (`BodiesScene`) with `Body` and `Sphere`; fewer steps than `FEW_STEPS` are warned of, fewer than
  `FEWEST_STEPS` refused.
* `derived`: the masses of bodies (`homogeneous_mass`, `mass_of`), and conditions of the rules (`is_measured`,
  `spheres_closed`, `has_closed_form`).
* `impact`: impacts of two bodies, their motion and their periods of contact.
* `motion`: the motion of two bodies that bounce, `PairMotion`.
* `figures`: figures of impacts, and the records of contacts that they follow from.
* `model_errors`: the second run of an impact (`ImpactComparison`), and a `relative` error.
"""

from bearing_twin.kinds.bodies.parameters import (
    HERE,
    EllipsoidOnPlaneScene,
    TwoBodiesScene,
    TwoDiscsScene,
    TwoSpheresScene,
)
from bearing_twin.kinds.contract import Kind, Quantity, figure_quantities, lazy_import, parts_in


def impact_quantities(**closed) -> dict[str, Quantity]:
    """Quantities of any impact; closed forms by the quantity's name."""
    rows = figure_quantities("contact_duration_s", "peak_force_n", "greatest_approach_m", "impulse_ns", "restitution")
    return {name: row._replace(closed=closed.get(name)) for name, row in rows.items()}


def pair_quantities(forms: str) -> dict[str, Quantity]:
    """Quantities of two spheres or discs, with closed forms of a module of `contact`.

    They are handed (law or coefficient, reduced mass, speed).
    """
    closed = {"contact_duration": "contact_time", "peak_force": "peak_force", "greatest_approach": "greatest_approach"}
    return impact_quantities(
        **{name: lazy_import(f"bearing_twin.contact.{forms}:{function}") for name, function in closed.items()},
        impulse=lambda _, reduced_mass, speed: 2.0 * reduced_mass * speed,
    )


SPHERE_QUANTITIES, DISC_QUANTITIES = pair_quantities("hertz_impact"), pair_quantities("line")
ELLIPSOID_QUANTITIES = figure_quantities(
    *("contact_duration_s", "peak_force_n", "greatest_approach_m", "restitution", "peak_pressure_pa"),
    *("dissipated_viscous_j", "dissipated_friction_j"),
) | {"contacts": Quantity(("contact_count",))}
PAIR_QUANTITIES = ELLIPSOID_QUANTITIES | figure_quantities("held_work_j")


LISTED = 200  # contacts named one by one in a report
MEANINGS = {
    "peak_force_n": "contact force, greatest over all contacts that have ended",
    "contact_duration_s": "time in contact, sum over all contacts that have ended",
    "contacts": "the contacts that have ended, one by one: begin, duration, greatest force, impulse of the force",
    "greatest_approach_m": "mutual approach, greatest over all contacts that have ended",
    "restitution": "relative speed away over that before, after the last contact that has ended",
    "energy_closure": "energy gained (+) or lost (-) by the numerical method over the initial energy, whole motion",
    "impulse_ns": "of the contact force, sum over all contacts that have ended",
    "impact_speed_m_s": "relative speed at the first touch",
}
MEANINGS_OF_ELLIPSOID = {
    "peak_force_n": "normal load, greatest over the run; of a contact that goes on, as seen at the outputs",
    "contact_count": "contacts that have begun",
    "contact_duration_s": "time in contact over the run",
    "contacts": f"the first {LISTED} contacts one by one; of one that goes on, no impulse and no restitution",
    "restitution": "speed away over the speed before, of the first contact; none while it goes on",
    "resting_since_s": "begin of the contact that goes on at the end; none where there is none",
    "greatest_approach_m": "greatest over the run; of a contact that goes on, as seen at the outputs",
    "peak_pressure_pa": "Hertz pressure, greatest over the run; of a contact that goes on, as seen at the outputs",
    "energy_closure": "energy gained (+) or lost (-) by the method over the run, as a share of the most ever stored",
    "greatest_energy_gain": "the most energy gained by the method at any output, as a share of the most ever stored",
    "energy_start_j": "kinetic, elastic and potential, at the start",
    "energy_end_j": "kinetic, elastic and potential, at the end",
    "dissipated_viscous_j": "lost to damping since the start, at the end",
    "dissipated_friction_j": "lost to friction since the start, at the end",
    "velocity_change_x_m_s": "of the centre along x since the start, at the end",
    "velocity_change_y_m_s": "of the centre along y since the start, at the end",
    "angular_momentum_change_vertical_nms": "about the centre, along z, since the start, at the end",
    "height_at_end_m": "of the centre above the plane, at the end",
    "quaternion_drift": "of the norm before normalisation, greatest in one step since the start, at the end",
}
_NOT_OF_PAIR = ("height_at_end_m", "angular_momentum_change_vertical_nms")
MEANINGS_OF_PAIR = {key: text for key, text in MEANINGS_OF_ELLIPSOID.items() if key not in _NOT_OF_PAIR} | {
    "energy_closure": "energy gained (+) or lost (-) by the method over the run, as a share of the most ever kinetic "
    "and elastic",
    "greatest_energy_gain": "the most energy gained by the method at any output, as the same share",
    **{
        f"velocity_change_{axis}_m_s": f"of the first body's centre along {axis} since the start, at the end"
        for axis in "xyz"
    },
    "held_work_j": "done on held bodies since the start, at the end",
    "tracking_error_m": "most by which opposing points missed their equations at a step's end, over the run",
}


def _row(name: str, help: str, parameters: type, quantities, meanings, **parts: str) -> Kind:
    row = {"name": name, "help": help, "parameters": parameters, "quantities": quantities}
    row["meanings"] = lambda: meanings
    return Kind(brief=True, **row, **parts_in(HERE, **parts))


OF_IMPACT = {
    "channels": "impact:CHANNELS", "records": "figures:OF_IMPACT", "figures": "figures:PairFigures",
    "comparison": "model_errors:ImpactComparison", "picture": "picture:PairPicture", "view": "display:impact_view",
}  # fmt: skip
OF_BOUNCING = {
    "choose": "derived:choose_bouncing", "figures": "figures:BouncingFigures",
    "comparison": "model_errors:ContactComparison", "model_errors": "model_errors:BouncingErrors",
    "picture": "picture:BouncingPicture", "view": "display:bouncing_view",
}  # fmt: skip

TWO_SPHERES = _row(
    "two_spheres",
    "central impact of two elastic spheres, without gravity",
    TwoSpheresScene,
    choose="derived:choose_spheres",
    motion="impact:spheres",
    model_errors="model_errors:SphereErrors",
    quantities=lambda: SPHERE_QUANTITIES,
    meanings=MEANINGS,
    topics="display:sphere_topics",
    **OF_IMPACT,
)
TWO_DISCS = _row(
    "two_discs",
    "central impact of two equal discs in line contact, without gravity",
    TwoDiscsScene,
    choose="derived:choose_discs",
    motion="impact:discs",
    model_errors="model_errors:DiscErrors",
    quantities=lambda: DISC_QUANTITIES,
    meanings=MEANINGS,
    topics="display:disc_topics",
    **OF_IMPACT,
)
ELLIPSOID_ON_PLANE = _row(
    "ellipsoid_on_plane",
    "an ellipsoid falls on a plane, bounces, slides and rocks under gravity",
    EllipsoidOnPlaneScene,
    motion="motion:EllipsoidMotion",
    channels="motion:ELLIPSOID_CHANNELS",
    records="figures:OF_ELLIPSOID",
    meanings=MEANINGS_OF_ELLIPSOID,
    quantities=lambda: ELLIPSOID_QUANTITIES,
    topics="display:ellipsoid_topics",
    **OF_BOUNCING,
)
TWO_BODIES = _row(
    "two_bodies",
    "two bodies of any smooth shape bounce, roll and spin on each other",
    TwoBodiesScene,
    motion="motion:PairMotion",
    channels="motion:PAIR_CHANNELS",
    records="figures:OF_PAIR",
    meanings=MEANINGS_OF_PAIR,
    quantities=lambda: PAIR_QUANTITIES,
    topics="display:body_topics",
    **OF_BOUNCING,
)
