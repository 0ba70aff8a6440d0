"""What an elastic contact answers to its approach h: load c h^p, stiffness and energy, written once.

p = 1.5 is Hertz's power, p = 1 a linear spring. Laws differ in where c comes from (`contact.laws`).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, plain

HERTZIAN = 1.5
"""Power of a point contact between smooth curved bodies."""

RESOLUTION = 1.0 / 6.0  # tuned: of 1/sqrt(k/m), in a bounce; its contact lasts 4 of them
LASTING, RESTING = 20.0, 2.0  # tuned: of 1/sqrt(k/m): beyond the first a contact is no bounce, left to error control


class Elastic(NamedTuple):
    """A contact's coefficient [N/m^p], load [N], stiffness d(load)/dh [N/m] and stored energy [J]."""

    coefficient: float
    load: float
    stiffness: float
    energy: float


def power_law(coefficient, power, depth, root):
    """The answer of c h^p at a depth h >= 0 [m] whose `root` is h^(p - 1); numbers or arrays that broadcast."""
    return Elastic(
        coefficient,
        coefficient * depth * root,
        power * coefficient * root,
        1.0 / (power + 1.0) * coefficient * depth * depth * root,
    )


compiled_power_law = inlined(power_law)


@plain
@inlined
def elastic(coefficient, power, approach):
    """The answer of c h^p to an approach [m]; load, stiffness and energy are zero for a gap.

    The energy is the integral of the load at constant coefficient (paper 1, section 4).
    """
    depth = max(approach, 0.0)
    if power == HERTZIAN:
        root = math.sqrt(depth)
    elif power == 1.0:
        root = 1.0 if approach > 0.0 else 0.0
    else:
        root = depth ** (power - 1.0)
    return compiled_power_law(coefficient, power, depth, root)


def loads_at(coefficient, power, depth):
    """Loads [N] at depths [m] >= 0; arrays broadcast."""
    return power_law(coefficient, power, depth, depth ** (power - 1.0)).load


def energies_at(coefficient, power, depth):
    """Energies [J] stored at depths [m] >= 0; arrays broadcast."""
    return power_law(coefficient, power, depth, depth ** (power - 1.0)).energy


def approaches_of_loads(coefficient, power, load):
    """Approaches [m] at loads [N] >= 0, the inverse of `loads_at`; arrays broadcast."""
    return (load / coefficient) ** (1.0 / power)


def greatest_approaches(coefficient, power, mass, speed):
    """Approaches [m] at which the energy of masses [kg] that meet at speeds [m/s] is stored; arrays broadcast."""
    return (0.5 * (power + 1.0) * mass * speed**2 / coefficient) ** (1.0 / (power + 1.0))


approach_of_load = inlined(approaches_of_loads)
greatest_approach = inlined(greatest_approaches)


@inlined
def longest_contact_step(lasted, rate):
    """The longest step [s] in a contact that has `lasted` [s]; `rate` [1/s] is sqrt(k/m) at the stiffness ahead."""
    return (RESOLUTION if lasted * rate < LASTING else RESTING) / rate
