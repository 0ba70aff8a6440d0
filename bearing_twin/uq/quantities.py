"""What a study may ask about a scene: one table a kind, each quantity with its unit and where it comes from.

`closed` is the vectorised closed form: it takes a scene's dataclass whose numbers may be arrays and returns an array,
NaN where there is no impact. It is used where the scene is one that the closed form describes (`CLOSED_FORMS`).
Otherwise every realisation is simulated and `figure` reads the quantity off the figures of its report.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.errors import StudyError
from bearing_twin.kinds.impact import disc_closed_form as disc_impact
from bearing_twin.kinds.impact.parameters import disc_law, disc_mass, sphere_pair
from bearing_twin.parameters import echo, unknown


class Quantity(NamedTuple):
    """One quantity of a kind of scene: `unit`, `meaning`, `figure` of a report's figures, `closed` form or None."""

    unit: str
    meaning: str
    figure: Callable[[Mapping], float]
    closed: Callable[[Any], np.ndarray] | None = None


class ClosedForm(NamedTuple):
    """When a kind of scene has closed forms, and what they share: `bodies(parameters)` is handed to each of them."""

    describes: Callable[[Any], bool]
    bodies: Callable[[Any], tuple]
    histories: dict[str, Callable]  # channel: (times, *bodies) -> array, all broadcast
    no_solution: str  # why a closed form gives NaN although the bodies meet
    without: tuple[str, ...] = ()  # keys that may not be uncertain


def _figure(key: str) -> Callable[[Mapping], float]:
    """That figure, NaN where a run has none."""
    return lambda figures: math.nan if figures[key] is None else float(figures[key])


def _greatest(*keys: str) -> Callable[[Mapping], float]:
    return lambda figures: max(float(value) for key in keys for value in figures[key])


def _spheres(parameters) -> tuple:
    coefficient, first, second = sphere_pair(parameters)
    return coefficient, first * second / (first + second), _meeting(parameters)


def _discs(parameters) -> tuple:
    name = "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal
    return disc_law(parameters.disc, name), 0.5 * disc_mass(parameters.disc), _meeting(parameters)


def _meeting(parameters):
    """Relative speed [m/s], NaN where the bodies never meet."""
    speed = np.asarray(parameters.motion.speed, float)
    return np.where(speed > 0.0, speed, np.nan)


def _elastic_spheres(parameters) -> bool:
    return parameters.contact.restitution == 1.0 and parameters.solver.stepper in ("auto", "closed_form")


def _discs_by_quadrature(parameters) -> bool:
    return parameters.solver.stepper in ("auto", "closed_form")


def _impulse(bodies, reduced, speed):
    return 2.0 * reduced * speed


CLOSED_FORMS = {
    "two_spheres": ClosedForm(
        _elastic_spheres,
        _spheres,
        {"normal_load": impact.force_history, "approach": impact.approach_history},
        "the closed form is not finite at these values",
        ("contact.restitution",),
    ),
    "two_discs": ClosedForm(
        _discs_by_quadrature, _discs, {}, "the law of line contact cannot store the energy of this impact"
    ),
}

KNOWN_WHEN_SOLVED = ("two_spheres", "two_discs", "sphere_on_beam")
"""Kinds whose figures do not depend on the outputs asked for."""


def _total_impulse(figures) -> float:
    return sum(float(contact["impulse_ns"]) for contact in figures["contacts"])


_IMPACT = {
    "contact_duration": Quantity("s", "total time in contact", _figure("contact_duration_s")),
    "peak_force": Quantity("N", "greatest contact force", _figure("peak_force_n")),
    "greatest_approach": Quantity("m", "greatest mutual approach", _figure("greatest_approach_m")),
    "impulse": Quantity("N s", "of the contact force, over all contacts", _total_impulse),
    "restitution": Quantity("1", "relative speed away over relative speed before", _figure("restitution")),
}


def _with_closed(**closed) -> dict[str, Quantity]:
    return {name: row._replace(closed=closed.get(name)) for name, row in _IMPACT.items()}


QUANTITIES: dict[str, dict[str, Quantity]] = {
    "two_spheres": _with_closed(
        contact_duration=impact.contact_time,
        peak_force=impact.peak_force,
        greatest_approach=impact.greatest_approach,
        impulse=_impulse,
    ),
    "two_discs": _with_closed(
        contact_duration=disc_impact.contact_time,
        peak_force=disc_impact.peak_force,
        greatest_approach=disc_impact.greatest_approach,
        impulse=_impulse,
    ),
    "sphere_on_beam": {
        **_IMPACT,
        "contacts": Quantity("1", "number of contacts", _figure("contact_count")),
        "peak_deflection": Quantity("m", "greatest deflection of the beam", _figure("peak_deflection_m")),
        "peak_stress": Quantity("Pa", "greatest bending stress", _figure("peak_stress_pa")),
        "velocity_after": Quantity(
            "m/s", "of the sphere at the end, positive along the blow", _figure("sphere_velocity_after_m_s")
        ),
    },
    "ellipsoid_on_plane": {
        **{name: row for name, row in _IMPACT.items() if name != "impulse"},
        "contacts": Quantity("1", "number of contacts", _figure("contact_count")),
        "peak_pressure": Quantity("Pa", "greatest Hertz pressure", _figure("peak_pressure_pa")),
        "dissipated_viscous": Quantity("J", "lost to damping", _figure("dissipated_viscous_j")),
        "dissipated_friction": Quantity("J", "lost to friction", _figure("dissipated_friction_j")),
    },
    "bearing": {
        "greatest_ball_load": Quantity(
            "N",
            "greatest load of any contact during the run",
            _greatest("greatest_normal_load_inner_n", "greatest_normal_load_outer_n"),
        ),
        "greatest_pressure": Quantity(
            "Pa",
            "greatest Hertz pressure of any contact",
            _greatest("peak_pressure_inner_pa", "peak_pressure_outer_pa"),
        ),
        "cage_speed": Quantity(
            "rad/s", "mean speed of the balls about the axis, second half of the run", _figure("cage_speed_rad_s")
        ),
        "roll_rate": Quantity("rad/s", "mean, second half of the run", _figure("roll_rate_rad_s")),
        "drive_torque": Quantity(
            "N m", "that turns the inner ring, mean of the second half of the run", _figure("drive_torque_nm")
        ),
        "dissipated_energy": Quantity("J", "lost in the contacts during the run", _figure("dissipated_j")),
        "greatest_contact_angle": Quantity(
            "rad",
            "of any contact at its greatest load",
            _greatest("contact_angle_inner_rad", "contact_angle_outer_rad"),
        ),
    },
}


def quantity_of(kind: str, name) -> Quantity:
    """The row of a quantity; raises StudyError with the nearest legal name."""
    known = QUANTITIES.get(kind, {})
    if name not in known:
        raise StudyError(f"{echo(name)} is no quantity of a scene of kind {kind}; {unknown(name, known)}")
    return known[name]


def has_closed_form(kind: str, parameters, names, histories=(), varied=()) -> bool:
    """Whether closed forms give all these quantities and histories of a scene, the `varied` keys being uncertain."""
    form = CLOSED_FORMS.get(kind)
    return (
        form is not None
        and form.describes(parameters)
        and not set(form.without) & set(varied)
        and all(QUANTITIES[kind][name].closed for name in names)
        and all(channel in form.histories for channel in histories)
    )
