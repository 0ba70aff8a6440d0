"""What a bearing gives out of its ring with mass and its cage, added to the rows that `output_rows` has written."""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.cage import bump
from bearing_twin.kinds.bearing.forces.equations import RingDrive, ball_vector
from bearing_twin.kinds.bearing.forces.land import carried_by_ring, touch_at
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    CAGE,
    CAGE_X,
    CAGE_Y,
    LAND_WORK,
    LOST,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_VELOCITY,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    SHAFT_WORK,
    SPIN,
    VELOCITY,
    WORK_DONE,
)
from bearing_twin.kinds.bearing.forces.moving_cage import seen, wall
from bearing_twin.kinds.bearing.output_rows import DRIVE_TORQUE
from bearing_twin.kinds.bearing.stepping.border import CAGE_SPEED, outside_load


@inlined
def _pocket_forces(pockets, bearing, state, border, row, first):
    """Writes what each pocket does to its ball along the orbit; returns the energy in all pockets."""
    energy = 0.0
    if len(pockets) > 1:
        for k in range(bearing.balls):
            ahead = state[k, ORBIT_ANGLE] - border[CAGE] - 2.0 * math.pi * k / bearing.balls
            velocity, spin = ball_vector(state, k, VELOCITY), ball_vector(state, k, SPIN)
            found = bump(pockets, bearing, state[k, AXIS_DISTANCE], ahead, velocity, spin, border[CAGE_SPEED])
            row[first + k] = found.along
            energy += found.energy
    return energy


@kernel
def _write_moving(pockets, bearing, land, speed, state, border, row, first, shared):
    """Writes what walls and land do to a cage whose centre moves, to balls and rings; returns the energy in them.

    From column `first` on stand pockets, place and velocity of the centre, and what the land does to the cage.
    """
    energy = 0.0
    if len(pockets) == 1:
        after, centre, moving = first + bearing.balls, PLACES + CAGE_X, (border[CAGE_X], border[CAGE_Y])
        for k in range(bearing.balls):
            cosine, sine = math.cos(state[k, ORBIT_ANGLE]), math.sin(state[k, ORBIT_ANGLE])
            found = wall(
                pockets.walls, bearing, state[k, AXIS_DISTANCE],
                state[k, ORBIT_ANGLE] - border[CAGE] - 2.0 * math.pi * k / bearing.balls,
                seen(border[CAGE_X], border[CAGE_Y], cosine, sine),
                seen(border[centre], border[centre + 1], cosine, sine),
                ball_vector(state, k, VELOCITY), ball_vector(state, k, SPIN), border[CAGE_SPEED],
            )  # fmt: skip
            row[first + k] = found.force[1]
            energy += found.energy
        held = touch_at(land, border, 0, speed)
        inner = carried_by_ring(land)
        for i in range(2):
            row[after + i], row[after + 2 + i], row[after + 4 + i] = moving[i], border[centre + i], held.force[i]
            row[shared + i] -= inner * held.force[i]
            row[shared + 6 + i] -= (1.0 - inner) * held.force[i]
        row[shared + 5] += inner * held.ring_torque
        row[shared + 11] += (1.0 - inner) * held.ring_torque
        energy += held.energy
    return energy


@kernel
def _hold_even(mass, gravity, inertia, state, speed, row, first, position, force):
    """Writes what an even cage of this inertia does to each ball, from the raceways' forces and balls' places in `row`.

    It asks for numbers alone: a bearing and its partners as arguments took longer than all that is reckoned here.
    """
    torque, pulled_x, pulled_y = 0.0, mass * gravity[0], mass * gravity[1]
    for k in range(len(state)):
        at, on, radius = position + 3 * k, force + 3 * k, state[k, AXIS_DISTANCE]
        x, y = row[on] + pulled_x, row[on + 1] + pulled_y
        moment = row[at] * y - row[at + 1] * x - 2.0 * mass * state[k, RADIAL_VELOCITY] * speed * radius
        row[first + k] = moment / radius
        torque += moment
        inertia += mass * radius * radius
    growth = mass * torque / inertia
    for k in range(len(state)):
        row[first + k] = state[k, AXIS_DISTANCE] * growth - row[first + k]


@inlined
def _write_shaft(shaft, partners, border, time, row, torque, shared):
    """Writes the torque on a shaft into column `torque`; its spin and that torque's work join the energies.

    What balls and land take of the work stays in the bearing.
    """
    if len(shaft) > 0:
        row[torque] = partners.load[CAGE] + time * partners.load_rate[CAGE]
        row[shared] += 0.5 * shaft.inertia * border[SHAFT_SPEED] * border[SHAFT_SPEED]
        row[shared + 3] = border[WORK_DONE] + border[SHAFT_WORK]
        row[shared + 5] += abs(border[SHAFT_WORK])


@kernel
def write_border(bearing, partners, drive, rolling, times, states, borders, places, out, first):
    """Adds ring and cage to the rows of `out` from `first` on, at `times` [s] into a part with these loads.

    Their shares of the energies too. `rolling` is the speed of balls that roll, over the ring's.
    """
    shared = places.shared + 12  # the energies follow four vectors
    for sample in range(len(times)):
        row, border, time = out[first + sample], borders[sample], times[sample]
        now = drive
        if len(partners.shaft) > 0:
            now = RingDrive(border[SHAFT_ANGLE] - time * border[SHAFT_SPEED], border[SHAFT_SPEED], 0.0)
        for i in range(3):
            row[places.ring + 12 + i] = outside_load(partners, now, time, i)
        for i in range(PLACES):
            speed, off = border[PLACES + i], border[i] - partners.rest[i]
            row[shared] += 0.5 * partners.free[i] * partners.mass[i] * speed * speed
            row[shared + 1] += 0.5 * partners.free[i] * partners.stiffness[i] * off * off
            row[shared + 2] -= partners.free[i] * partners.weight[i] * border[i]
        row[places.ring + 15] = border[WORK_DONE]
        row[shared + 3] += border[WORK_DONE] + border[LAND_WORK]
        row[shared + 4] += border[LOST]
        row[shared + 5] += abs(border[WORK_DONE]) + abs(border[LAND_WORK])
        if partners.free[CAGE] > 0.0:
            cage, pocket = places.ring + DRIVE_TORQUE + 1, places.ring + DRIVE_TORQUE + 4
            turning = row[places.ring + 1]
            speed = rolling * turning
            row[cage], row[cage + 1] = border[CAGE], border[CAGE_SPEED]
            row[cage + 2] = 1.0 - border[CAGE_SPEED] / speed if speed != 0.0 else 0.0
            if partners.even:
                given = bearing.ball_mass, bearing.gravity, partners.mass[CAGE], states[sample], border[CAGE_SPEED]
                _hold_even(*given, row, pocket, places.position, places.force)
            else:
                state, pockets = states[sample], bearing.pockets
                row[shared + 1] += _pocket_forces(pockets, bearing, state, border, row, pocket)
                row[shared + 1] += _write_moving(
                    pockets, bearing, partners.land, turning, state, border, row, pocket, places.shared
                )
                row[places.ring + DRIVE_TORQUE] = -row[places.shared + 5]
        _write_shaft(partners.shaft, partners, border, time, row, places.ring + DRIVE_TORQUE, shared)
