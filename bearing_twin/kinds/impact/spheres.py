"""Central impact of two elastic spheres, paper 3, sections 2 and 3.

    mu x'' = -c x^1.5,   tau = alpha v^(-1/5),   c = (5/4) mu (C_H / alpha)^(5/2)        (eqs. 1, 2, 12, 13)

with x the mutual approach and mu the reduced mass. The Hertz coefficient c = (4/3) E* sqrt(R), or that of another law;
a linear spring has the power 1. Contact time, peak force and, by the inverse incomplete beta function, the whole
history are closed forms. A coefficient of restitution below 1 adds a Hunt-Crossley term; then contact time and history
are quadratures. Or a term that loses the same share at every speed (`damping_law: steady`); then they come from the
equation of motion.

Breaks: at speeds where the peak pressure exceeds yield or waves cannot cross the spheres several times in a contact.
"""

import math
from functools import partial

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.base.report import Choice
from bearing_twin.contact import hertz_impact as closed_forms
from bearing_twin.contact.damping import restitution_of, steady_damping
from bearing_twin.contact.elasticity import energies_at
from bearing_twin.contact.laws import HERTZIAN, LAWS
from bearing_twin.contact.materials import effective_modulus, yield_pressure
from bearing_twin.contact.validity import gathered, pressure_doubt, spot_radius, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.contract import ClosedForm
from bearing_twin.kinds.impact.collision import NO_LINE, ContactPeriod, Spring
from bearing_twin.kinds.impact.derived import (
    hunt_crossley_damping,
    is_elastic,
    meeting_speed,
    pair_contact_time,
    sphere_law,
    sphere_mass,
    sphere_pair,
)
from bearing_twin.kinds.impact.figures import PairFigures
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion, pair_impact
from bearing_twin.kinds.impact.parameters import TwoSpheresScene


def solve(parameters: TwoSpheresScene, law: str = "hertz", stepper: str = "closed_form") -> Impact:
    """The impact by `closed_form`, `dop853`, `rk4` or `symplectic_euler`; raises IntegrationError where one fails."""
    coefficient, first, second = sphere_pair(parameters)
    power = LAWS[law].power
    reduced, speed = first * second / (first + second), parameters.motion.speed
    contact, steady = parameters.contact, parameters.contact.viscosity
    damping, restitution = hunt_crossley_damping(contact, speed), contact.restitution
    if restitution < 1.0 and contact.damping_law == "steady":
        steady = steady_damping(restitution, coefficient, reduced, power)
    elif damping > 0.0:
        restitution = restitution_of(damping * speed)
    spring = Spring(coefficient, NO_LINE, damping, steady, power)
    closed = None
    if stepper == "closed_form":
        closed = _closed((coefficient, reduced, speed), power, damping, restitution)
    return pair_impact(parameters, spring, (first, second), stepper, pair_contact_time(parameters), closed)


def motion(parameters: TwoSpheresScene, choice: Choice) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solve, parameters, choice)


def closed_form(parameters: TwoSpheresScene) -> ClosedForm | None:
    """Spheres without loss, many at once."""
    hertzian = LAWS[sphere_law(parameters)].power == HERTZIAN
    if not (hertzian and is_elastic(parameters.contact) and parameters.solver.stepper in ("auto", "closed_form")):
        return None
    return ClosedForm(
        bodies=_bodies,
        histories={"normal_load": closed_forms.force_history, "approach": closed_forms.approach_history},
        no_solution="the closed form is not finite at these values",
        without=("contact.restitution", "contact.damping", "contact.viscosity"),
    )


def _bodies(parameters) -> tuple:
    coefficient, first, second = sphere_pair(parameters)
    return coefficient, first * second / (first + second), meeting_speed(parameters)


def _closed(bodies, power, damping, wanted):
    coefficient, reduced, speed = bodies
    duration, peak, deepest, restitution = closed_forms.damped_impact(*bodies, damping, power)
    contact = ContactPeriod(0.0, float(duration), float(peak), reduced * speed * (1.0 + restitution))
    initial_energy = 0.5 * reduced * speed**2

    if damping == 0.0:

        def history(times):
            approach = closed_forms.approach_history(times, *bodies, power)
            slowed = np.sqrt(np.maximum(1.0 - (approach / deepest) ** (power + 1.0), 0.0))
            return approach, np.where(np.asarray(times) < 0.5 * duration, speed, -speed) * slowed
    else:
        curve = CubicHermiteSpline(*closed_forms.damped_history(*bodies, damping, power))

        def history(times):
            return curve(times), curve(times, 1)

    if damping == 0.0:
        closure = energies_at(coefficient, power, float(deepest)) / initial_energy - 1.0
    else:
        closure = restitution**2 - wanted**2
    return contact, float(deepest), restitution, closure, history


def _flags(parameters, peak_force, duration):
    first, second = parameters.first, parameters.second
    radius = first.radius * second.radius / (first.radius + second.radius)
    modulus = effective_modulus(first.material, second.material)
    smaller = min(first.radius, second.radius)
    half_width = spot_radius(peak_force, radius, modulus)
    pressure = 1.5 * peak_force / (math.pi * half_width**2)
    transits = []
    for sphere in (first, second):
        density = sphere_mass(sphere) / (4.0 / 3.0 * math.pi * sphere.radius**3)
        transits.append(wave_transit(2.0 * sphere.radius, sphere.material.young_modulus, density))
    return gathered(
        pressure_doubt(pressure, yield_pressure(first.material, second.material)),
        width_doubt(half_width, smaller, body="smaller radius"),
        wave_doubt(duration, max(transits)),
    )


figures = partial(PairFigures, _flags)
