"""Impact of two equal discs by a law of line contact: contact time by quadrature, vectorised over the discs."""

import math

import numpy as np

from bearing_twin.contact.line import LineLaw, approach_of, load_of_energy

NODES = 48  # of the quadrature; the relative error is below 1e-13


def peak_force(law: LineLaw, reduced_mass, speed):
    """Greatest load [N], at which all kinetic energy is stored; NaN where the law has no such load."""
    return load_of_energy(law, 0.5 * reduced_mass * np.square(speed))


def contact_time(law: LineLaw, reduced_mass, speed, nodes: int = NODES):
    """Duration [s] of the contact, NaN where the law has no solution; law's fields, mass and speed broadcast.

    With the stored energy U = (mu v^2 / 2) sin^2(angle) and dx = dU / F,
    tau = 2 mu v * integral of sin(angle) / F over 0 .. pi/2. The integrand goes as sqrt(ln) near 0, which a double
    exponential change of variable makes harmless.
    """
    scale, compliance, half, reduced_mass, speed = np.broadcast_arrays(*map(np.asarray, (*law, reduced_mass, speed)))
    column = LineLaw(scale[..., None], compliance[..., None], half[..., None])
    angle, weight = _nodes(nodes)
    energy = 0.5 * (reduced_mass * speed**2)[..., None] * np.sin(angle) ** 2
    with np.errstate(divide="ignore"):  # a speed so small that its energy underflows: no load, an endless contact
        integral = np.sum(weight * np.sin(angle) / load_of_energy(column, energy), axis=-1)
    return (2.0 * reduced_mass * speed * integral)[()]


def greatest_approach(law: LineLaw, reduced_mass, speed):
    """Greatest approach [m] of the two centres."""
    return approach_of(law, peak_force(law, reduced_mass, speed))


def _nodes(count):
    """Angles in (0, pi/2) and weights of the tanh-sinh rule."""
    reach = 3.2
    u = np.linspace(-reach, reach, count)
    inner = 0.5 * math.pi * np.sinh(u)
    share = 1.0 / (1.0 + np.exp(-2.0 * inner))
    weight = 0.25 * math.pi * np.cosh(u) / np.cosh(inner) ** 2 * (u[1] - u[0])
    return 0.5 * math.pi * share, 0.5 * math.pi * weight
