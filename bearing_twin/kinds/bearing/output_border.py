"""What a bearing gives out of its ring with mass and its cage, added to the rows that `output_lanes` has written."""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.border import CAGE_SPEED, applied_load
from bearing_twin.kinds.bearing.cage import bump
from bearing_twin.kinds.bearing.equations import ball_vector
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    CAGE,
    LOST,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_VELOCITY,
    SPIN,
    VELOCITY,
    WORK_DONE,
)


@inlined
def _pocket_forces(pockets, bearing, state, border, row, first):
    """Writes what each pocket does to its ball along the orbit; returns the energy in all pockets."""
    energy = 0.0
    if len(pockets) > 0:
        for k in range(bearing.balls):
            ahead = state[k, ORBIT_ANGLE] - border[CAGE] - 2.0 * math.pi * k / bearing.balls
            velocity, spin = ball_vector(state, k, VELOCITY), ball_vector(state, k, SPIN)
            found = bump(pockets, bearing, state[k, AXIS_DISTANCE], ahead, velocity, spin, border[CAGE_SPEED])
            row[first + k] = found.along
            energy += found.energy
    return energy


@kernel
def _hold_even(bearing, partners, state, border, row, first, force):
    """Writes what an even cage does to each ball; column `force` is where the forces of the raceways begin."""
    mass, speed = bearing.ball_mass, border[CAGE_SPEED]
    inertia, torque = partners.mass[CAGE], 0.0
    for turn in range(2):
        growth = torque / inertia
        for k in range(bearing.balls):
            cosine, sine = math.cos(state[k, ORBIT_ANGLE]), math.sin(state[k, ORBIT_ANGLE])
            x = row[force + 3 * k] + mass * bearing.gravity[0]
            y = row[force + 3 * k + 1] + mass * bearing.gravity[1]
            along, radius = cosine * y - sine * x, state[k, AXIS_DISTANCE]
            swing = 2.0 * mass * state[k, RADIAL_VELOCITY] * speed
            if turn == 0:
                torque += radius * (along - swing)
                inertia += mass * radius * radius
            else:
                row[first + k] = mass * radius * growth + swing - along


@inlined
def _load(partners, drive, time, i):
    """What acts on the ring from outside along coordinate i, if that is free."""
    if partners.free[i] == 0.0:
        return 0.0
    load, load_rate = partners.load[i], partners.load_rate[i]
    return applied_load(load, load_rate, partners.unbalance, partners.phase, drive, time, i)


@kernel
def write_border(bearing, partners, drive, rolling, times, states, borders, places, out, first):
    """Adds ring and cage to the rows of `out` from `first` on, at `times` [s] into a part with these loads.

    Their shares of the energies too. `rolling` is the speed of balls that roll, over the ring's.
    """
    shared = places.shared + 12  # the energies follow four vectors
    for sample in range(len(times)):
        row, border, time = out[first + sample], borders[sample], times[sample]
        for i in range(3):
            row[places.ring + 12 + i] = _load(partners, drive, time, i)
        for i in range(PLACES):
            speed, off = border[PLACES + i], border[i] - partners.rest[i]
            row[shared] += 0.5 * partners.free[i] * partners.mass[i] * speed * speed
            row[shared + 1] += 0.5 * partners.free[i] * partners.stiffness[i] * off * off
            row[shared + 2] -= partners.free[i] * partners.weight[i] * border[i]
        row[places.ring + 15] = border[WORK_DONE]
        row[shared + 3] += border[WORK_DONE]
        row[shared + 4] += border[LOST]
        row[shared + 5] += abs(border[WORK_DONE])
        if partners.free[CAGE] > 0.0:
            cage, pocket = places.ring + 16, places.ring + 19
            speed = rolling * (drive.speed + drive.acceleration * time)
            row[cage], row[cage + 1] = border[CAGE], border[CAGE_SPEED]
            row[cage + 2] = 1.0 - border[CAGE_SPEED] / speed if speed != 0.0 else 0.0
            if partners.even:
                _hold_even(bearing, partners, states[sample], border, row, pocket, places.force)
            else:
                row[shared + 1] += _pocket_forces(bearing.pockets, bearing, states[sample], border, row, pocket)
