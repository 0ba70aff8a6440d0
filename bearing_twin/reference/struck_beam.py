"""A mass that strikes a simply supported Timoshenko beam, by staggered differences in space and time.

Written from the equations alone and not from modes:

    rho A w'' = dQ/dx + f delta(x - x_c),   Q = K G A (dw/dx - psi),   rho I psi'' = dM/dx + Q,   M = E I dpsi/dx,

w and M at nodes, psi and Q between them; errors fall as the square of the cells. The mass has a Hertz spring, or none:
then it sticks to its node while it presses on it, takes over the node's speed at a touch and leaves where it would
have to pull.
"""

import math
from typing import NamedTuple

import numpy as np

COURANT = 0.9  # of the longest stable step


class BeamResponse(NamedTuple):
    """The point of impact over `time` [s]: `force` [N], `deflection` [m] and bending `stress` [Pa] of the fibre away.

    `contacts` as rows of (start [s], end [s], peak [N]); `leaving` [m/s], the mass's speed at the end.
    """

    time: np.ndarray
    force: np.ndarray
    deflection: np.ndarray
    stress: np.ndarray
    contacts: np.ndarray
    leaving: float


def strike(beam, mass: float, coefficient: float, speed: float, point: float, until: float, cells: int) -> BeamResponse:
    """The motion of `beam` (`kinds.beam.modes.Beam` with shear) and a mass [kg] that touches it at time 0.

    `coefficient` [N/m^1.5] of the Hertz spring, infinite for a rigid contact; `point`, a share of the span, on a node.
    """
    length = beam.span / cells
    fastest = 4.0 * beam.rigidity / beam.rotary_inertia / length**2
    fastest += beam.shear_rigidity * (1.0 / beam.rotary_inertia + 4.0 * beam.span / beam.mass / length**2)
    step = COURANT * 2.0 / math.sqrt(fastest)
    rows = np.zeros((int(until / step) + 1, 4))
    numbers = beam.rigidity, beam.rotary_inertia, beam.shear_rigidity, beam.mass / beam.span, length
    node = round(point * cells)
    leaving = _march(numbers, node, cells, mass, coefficient, speed, step, rows)
    time, (gap, force, deflection, moment) = step * np.arange(len(rows)), rows.T
    return BeamResponse(
        time, force, deflection, -moment * beam.half_height / beam.area_moment, _contacts(time, gap, force), leaving
    )


def _march(numbers, node, cells, mass, coefficient, speed, step, rows):
    """Fills rows of (approach, force, deflection, moment at the node); returns the mass's speed at the end."""
    rigidity, rotary, shear, inertia, length = numbers
    w, wt = np.zeros(cells + 1), np.zeros(cells + 1)
    psi, psit = np.zeros(cells), np.zeros(cells)
    moment, force_across = np.zeros(cells + 1), np.zeros(cells)
    bend, slide = rigidity / length, shear / length
    push, turn = step / (length * inertia), step / rotary
    travel, velocity = 0.0, speed
    rigid, touching = not math.isfinite(coefficient), False
    for row in range(len(rows)):
        force_across[:] = slide * (w[1:] - w[:-1]) - shear * psi
        moment[1:-1] = bend * (psi[1:] - psi[:-1])
        approach, force = travel - w[node], 0.0
        across = force_across[node] - force_across[node - 1]
        if rigid:
            if not touching and approach >= 0.0 and velocity > wt[node]:
                touching = True
                wt[node] = velocity = (mass * velocity + inertia * length * wt[node]) / (mass + inertia * length)
            if touching:
                force = -mass * across / (mass + inertia * length)
                touching = force >= 0.0
                force = max(force, 0.0)
        elif approach > 0.0:
            force = coefficient * approach**1.5
        rows[row] = approach, force, w[node], moment[node]
        velocity -= step * force / mass
        travel += step * velocity
        wt[1:-1] += push * (force_across[1:] - force_across[:-1])
        wt[node] += push * force
        psit += turn * ((moment[1:] - moment[:-1]) / length + force_across)
        w += step * wt
        psi += step * psit
    return velocity


def _contacts(time, gap, force):
    """Rows of (start, end, peak) of the stretches under load, ends where the line through the gap's values is zero."""
    pressed = np.concatenate([[False], force > 0.0, [False]])
    starts, ends = np.flatnonzero(pressed[1:] & ~pressed[:-1]), np.flatnonzero(pressed[:-1] & ~pressed[1:])
    rows = []
    for first, last in zip(starts, ends, strict=True):
        edges = [
            time[one] if not 0 < one < len(time) or gap[one] == gap[one - 1]
            else time[one] - (time[one] - time[one - 1]) * gap[one] / (gap[one] - gap[one - 1])
            for one in (first, min(last, len(time) - 1))
        ]  # fmt: skip
        top = min(max(first + int(np.argmax(force[first:last])), 1), len(force) - 2)
        before, here, after = force[top - 1 : top + 2]
        bend = before - 2.0 * here + after
        rows.append((*edges, here if bend >= 0.0 else here - 0.125 * (after - before) ** 2 / bend))
    return np.array(rows).reshape(-1, 3)
