"""Central impact of two equal elastic discs in line contact, paper 3, section 5.1.

    (m / 2) x'' = -F(x),   F from eq. (14) or from Johnson's law, both inverted by Lambert's function,

x being the mutual approach of the centres. The closed form is the quadrature of `disc_closed_form` for contact
time and peak force; histories come from the same quadrature run up to each instant, or from the differential
equation. Thick discs answer nearly in plane strain, as Johnson's law assumes.

Breaks: where the kinetic energy exceeds what the law can store it has no solution (soft discs: use finite
elasticity), and where the half-width of the contact is no longer small against the radius.
"""

import math
from functools import partial

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bearing_twin.base.report import Choice
from bearing_twin.contact.line import approach_of, load_of_energy
from bearing_twin.contact.line import energy as energy_of
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import gathered, pressure_doubt, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.contract import ClosedForm
from bearing_twin.kinds.impact import disc_closed_form
from bearing_twin.kinds.impact.collision import ContactPeriod, Spring
from bearing_twin.kinds.impact.derived import disc_law, disc_mass, meeting_speed, strip_of
from bearing_twin.kinds.impact.figures import PairFigures
from bearing_twin.kinds.impact.impact import Impact, ImpactMotion, pair_impact
from bearing_twin.kinds.impact.parameters import TwoDiscsScene

PIECES = 400  # of the history by quadrature


def solve(parameters: TwoDiscsScene, law: str = "johnson", stepper: str = "closed_form") -> Impact:
    """The impact with the law `line` or `johnson`, by a stepper as in `two_spheres`; raises IntegrationError."""
    mass, speed = disc_mass(parameters.disc), parameters.motion.speed
    line = disc_law(parameters.disc, law)
    duration = float(disc_closed_form.contact_time(line, 0.5 * mass, speed))
    closed = _closed(line, 0.5 * mass, speed, duration) if stepper == "closed_form" else None
    return pair_impact(parameters, Spring(0.0, line, 0.0), (mass, mass), stepper, duration, closed)


def motion(parameters: TwoDiscsScene, choice: Choice) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solve, parameters, choice)


def closed_form(parameters: TwoDiscsScene) -> ClosedForm | None:
    """Discs by quadrature, many at once."""
    if parameters.solver.stepper not in ("auto", "closed_form"):
        return None
    return ClosedForm(
        bodies=_bodies,
        histories={},
        no_solution="the law of line contact cannot store the energy of this impact",
    )


def _bodies(parameters) -> tuple:
    name = "johnson" if parameters.contact.normal == "auto" else parameters.contact.normal
    return disc_law(parameters.disc, name), 0.5 * disc_mass(parameters.disc), meeting_speed(parameters)


def _closed(line, reduced, speed, duration):
    peak = float(disc_closed_form.peak_force(line, reduced, speed))
    initial_energy = 0.5 * reduced * speed**2
    times, approach, rates = _half_history(line, reduced, speed)
    times *= 0.5 * duration / times[-1]
    curve = CubicHermiteSpline(times, approach, rates)

    def history(since):
        since = np.asarray(since, float)
        first = np.minimum(since, duration - since)
        return curve(first), np.where(since < 0.5 * duration, 1.0, -1.0) * np.maximum(curve(first, 1), 0.0)

    contact = ContactPeriod(0.0, duration, peak, 2.0 * reduced * speed)
    closure = float(energy_of(line, peak)) / initial_energy - 1.0
    return contact, float(approach_of(line, peak)), 1.0, closure, history


def _half_history(line, reduced, speed):
    """Times [s], approaches [m] and rates [m/s] from touch to standstill: dt = mu v sin(angle) / F d(angle)."""
    points, weights = np.polynomial.legendre.leggauss(6)
    edges = 0.5 * math.pi * np.linspace(0.0, 1.0, PIECES + 1) ** 1.5
    angles = edges[:-1, None] + 0.5 * (points + 1.0) * np.diff(edges)[:, None]
    initial_energy = 0.5 * reduced * speed**2
    slopes = reduced * speed * np.sin(angles) / load_of_energy(line, initial_energy * np.sin(angles) ** 2)
    spans = 0.5 * np.diff(edges) * np.sum(weights * slopes, axis=1)
    approach = approach_of(line, load_of_energy(line, initial_energy * np.sin(edges) ** 2))
    return np.concatenate([[0.0], np.cumsum(spans)]), approach, speed * np.cos(edges)


def _flags(parameters, peak_force, duration):
    disc = parameters.disc
    half_width, pressure = strip_of(disc, peak_force)
    flags = gathered(
        pressure_doubt(pressure, yield_pressure(disc.material)),
        width_doubt(half_width, disc.radius),
        wave_doubt(duration, wave_transit(2.0 * disc.radius, disc.material.young_modulus, disc.material.density)),
    )
    if disc.thickness < disc.radius and parameters.contact.normal == "auto":  # else its range says so
        flags.append(
            f"a thickness of {disc.thickness:g} m is below the radius of {disc.radius:g} m: both assume plane strain"
        )
    return flags


figures = partial(PairFigures, _flags)
