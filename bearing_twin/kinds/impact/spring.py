"""The load between two bodies that meet on a line, elastic and viscous, and the equation of motion with it."""

from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact import line
from bearing_twin.contact.damping import damped_load, steady_damped_load
from bearing_twin.contact.elastic import HERTZIAN, elastic
from bearing_twin.contact.elasticity import line_elastic


class Spring(NamedTuple):
    """The load between two bodies: `line_law.scale` > 0 selects line contact, else coefficient * approach^power.

    `damping` [s/m] multiplies the load by (1 + damping * approach rate); `steady` [N s/m^(5/4)] is the damping of
    `steady_damped_load`, which takes its place where it is above zero.
    """

    coefficient: float
    line_law: line.LineLaw
    damping: float
    steady: float = 0.0
    power: float = HERTZIAN


NO_LINE = line.LineLaw(0.0, 0.0, 0.0)


@kernel
def spring_elastic(spring, approach):
    """The elastic answer to an approach [m]."""
    if spring.line_law.scale > 0.0:
        return line_elastic(spring.line_law, approach)
    return elastic(spring.coefficient, spring.power, approach)


@kernel
def spring_load(spring, approach, approach_rate):
    """Load [N] with its viscous part."""
    answer = spring_elastic(spring, approach)
    if spring.steady > 0.0:
        return steady_damped_load(answer.load, approach, approach_rate, spring.steady, spring.power)
    return damped_load(answer.load, 0.0, approach_rate, spring.damping, 0.0)


@kernel
def spring_loads(spring, approaches, rates_of_approach):
    """Loads [N] at many approaches [m] and their rates [m/s]."""
    loads = np.empty(len(approaches))
    for i in range(len(approaches)):
        loads[i] = spring_load(spring, approaches[i], rates_of_approach[i])
    return loads


@kernel
def spring_energies(spring, approaches):
    """Energies [J] stored at many approaches [m]."""
    energies = np.empty(len(approaches))
    for i in range(len(approaches)):
        energies[i] = spring_elastic(spring, approaches[i]).energy
    return energies


@kernel
def rates(spring, reduced_mass, state, out):
    """Time derivative of (approach [m], approach rate [m/s], dissipated energy [J])."""
    load = spring_load(spring, state[0], state[1])
    out[0] = state[1]
    out[1] = -load / reduced_mass
    out[2] = (load - spring_elastic(spring, state[0]).load) * state[1]
