"""What loads and friction are off at outputs inside long steps, read off the balance of forces and moments there.

Where a step is longer than a ball takes to swing between its raceways, the ball is in balance with them, and its
acceleration is known from how its velocity changes from output to output. An interpolant between the ends of such a
step misses that balance: what is left over of the forces on the ball is what its loads are off, to 1 % or so. So it is
with friction, where a step is longer than slip takes to die out: what is left over of the torque on the ball, and of
the force across both normals, is what friction is off. Nothing is integrated for it. No window shows it so: its own
start lies on an interpolant.

What is left over of the forces where a part begins is no error: it makes a ball swing between its raceways. A step that
is longer than such a swing ends it at once, for the run and for any companion, where contacts that damp little would
let it go on (`rung_out`).
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.companion.accelerations import bends, better, changes, even
from bearing_twin.kinds.bearing.companion.deviations import LEAST_LOAD, Part
from bearing_twin.kinds.bearing.companion.windows import BETWEEN, PLACE, WINDOW
from bearing_twin.kinds.bearing.forces.cage import Pockets
from bearing_twin.kinds.bearing.forces.equations import Bearing
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    ORBIT_ANGLE,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
)
from bearing_twin.kinds.bearing.outputs import empty_outputs, write_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.rings import FREE_RING, dimension_of
from bearing_twin.kinds.bearing.stepping.border import CAGE_SPEED
from bearing_twin.kinds.bearing.stepping.pointing import STEPS_IN
from bearing_twin.numerics.rotation import about_z, add, cross, dot, minus, scaled

SWING = 2.0 * np.pi  # rad: steps shorter than such a period are made for the swing itself, where nothing is in balance
SURE = 0.8  # of the tolerance: what is known so exactly is done again only above it
UNKNOWN = 0.1  # of what is left over: where accelerations are known no better, nothing is said of friction
ERRORS = 3  # of a ball: of load, friction, torque
NO_FRICTION = 1e-300  # share of the load: next to nothing, so that no quotient is infinite
MOST = 100  # outputs of a part that are looked at: those in the longest steps, whose interpolants err most


def in_longest_steps(part: Part) -> np.ndarray:
    """Which outputs (MOST at most) are looked at."""
    if len(part.times) <= MOST or not len(part.pointer):
        return np.arange(len(part.times))
    return np.sort(np.argsort(part.pointer[..., STEPS_IN].min(axis=0), kind="stable")[:MOST])


@inlined
def _rubs(given, coupled, load, angle, torque, force):
    """What friction is off (share of mu N, N m), by the `torque` and the `force` that are left over on a ball.

    Both contacts lie on one line through the ball, nearly: its torque tells what their friction differs, its force
    across that line what they make in sum. Along the orbit a cage may push as well (`coupled`): that sum is left out.
    """
    radius, limit, least = given.radius, given.friction, given.least
    n = math.cos(angle), 0.0, math.sin(angle)
    drills = dot(torque, n)
    across = minus(torque, scaled(drills, n))
    differ, pushes = scaled(1.0 / radius, cross(across, n)), (force[0], 0.0 if coupled else force[1], force[2])
    pushes = minus(pushes, scaled(dot(pushes, n), n))
    inner, outer = minus(pushes, differ), add(pushes, differ)
    share = max(
        0.5 * math.sqrt(dot(inner, inner)) / max(load[0], least),
        0.5 * math.sqrt(dot(outer, outer)) / max(load[1], least),
    )  # that of the torque over both loads lies between them
    return share / limit, math.sqrt(dot(across, across))


class _Given(NamedTuple):
    """Numbers of a bearing: mass, moment of inertia and radius of a ball, powers of its laws, gravity, friction.

    `relaxing` [1/(N s)] is how fast slip dies out for each newton of load; `least` [N] counts as load at least;
    `creeps` [m/s] is the slip that smooths friction, also where a pocket pushes, on a circle of radius `pocket` [m].
    """

    mass: float
    inertia: float
    radius: float
    inner: float
    outer: float
    gravity: tuple[float, float, float]
    friction: float
    relaxing: float
    least: float
    creeps: float = 1.0
    pocket: float = 1.0
    pocket_friction: float = 0.0


@inlined
def _pocket_rubs(given, push, speed, state):
    """Friction [N] along radius and axis of the pocket that pushes a ball along its orbit; the lever [m] it acts at."""
    lever = -math.copysign(given.radius, push)
    slip = state[VELOCITY] - lever * (state[SPIN + 2] - speed), state[VELOCITY + 2] + lever * state[SPIN]
    load = abs(push) * state[AXIS_DISTANCE] / given.pocket
    resists = given.pocket_friction * load / math.sqrt(slip[0] * slip[0] + slip[1] * slip[1] + given.creeps**2)
    return -resists * slip[0], -resists * slip[1], lever


@kernel
def _left_over(given, coupled, times, here, bears, channels, pushes, speeds, states, begun, counts, off):
    """Fills `off` (n, balls, ERRORS) where `bears` and steps are long; `counts` (balls, T) are steps up to outputs.

    The `channels` load, approach, angle, force and torque, and `pushes` (n, balls) of pockets [N] along the orbit, have
    the outputs `here` (n,) alone; `states`, the cage's `speeds` (T,) [rad/s] and `counts` all.
    """
    load, approach, angle, force, torque = channels
    last = len(times) - 1
    if last == 0:  # here and not before, so that a run of one output compiles what longer ones need
        return
    for row, now in enumerate(here):
        ahead = min(now + 1, last)
        past, following = times[now] - (times[now - 1] if now > 0 else 0.0), times[ahead] - times[now]
        behind = following if now < last else past  # what follows the last output is not known
        for ball in range(load.shape[1]):
            if not bears[row, ball]:
                continue
            deep, held = approach[row, ball], load[row, ball]
            one = given.inner * held[0] / deep[0] if deep[0] > 0.0 else 0.0
            two = given.outer * held[1] / deep[1] if deep[1] > 0.0 else 0.0
            swing, dies = math.sqrt((one + two) / given.mass), given.relaxing * (held[0] + held[1])  # rad/s, 1/s
            some, more = SWING * counts[ball, now], SWING * counts[ball, ahead]
            long, slow = swing * past >= some and swing * behind >= more, dies * past >= some
            slow = slow and dies * behind >= more and even(times, now, last)
            if not (long or slow):
                continue
            state = states[now, ball]
            before, later = states[now - 1, ball] if now > 0 else begun[ball], states[ahead, ball]
            moved = changes(before, state, later, VELOCITY, past, following)
            spun = changes(before, state, later, SPIN, past, following)
            back = math.cos(state[ORBIT_ANGLE]), -math.sin(state[ORBIT_ANGLE])  # into the ball's frame
            speed, orbit = state[TANGENTIAL_VELOCITY], state[TANGENTIAL_VELOCITY] / state[AXIS_DISTANCE]
            faster = add(moved, (-speed * orbit, state[VELOCITY] * orbit, 0.0))
            pulled, pushed = about_z(*back, given.gravity), about_z(*back, force[row, ball])
            along_radius, along_axis, lever = _pocket_rubs(given, pushes[row, ball], speeds[now], state)
            pushed = add(pushed, (along_radius, 0.0, along_axis))
            left = add(pushed, scaled(given.mass, minus(pulled, faster)))
            if long:
                leant = math.cos(angle[row, ball, 0]), math.cos(angle[row, ball, 1])
                one, two = one * leant[0], two * leant[1]
                off[row, ball, 0] = abs(left[0]) * max(one, two) / (one * leant[0] + two * leant[1])
            if slow:
                quicker = add(spun, (-orbit * state[SPIN + 1], orbit * state[SPIN], 0.0))
                turning = minus(about_z(*back, torque[row, ball]), scaled(given.inertia, quicker))
                turning = add(turning, (lever * along_axis, 0.0, -lever * along_radius))
                # Two orders of accelerations, and how smooth all is, tell how well they are known.
                more = scaled(given.mass, better(states, now, ball, VELOCITY, moved, past))
                turns = scaled(given.inertia, better(states, now, ball, SPIN, spun, past))
                mean = 0.5 * (angle[row, ball, 0] + angle[row, ball, 1])
                found = _rubs(given, coupled, held, mean, turning, left)
                bent = scaled(given.mass, bends(states, now, ball, VELOCITY, past))
                twisted = scaled(given.inertia, bends(states, now, ball, SPIN, past))
                unknown = _rubs(given, coupled, held, mean, turns, more)[0]
                unknown += _rubs(given, coupled, held, mean, twisted, bent)[0]
                if unknown < UNKNOWN * found[0]:
                    off[row, ball, 1], off[row, ball, 2] = found


@kernel
def _bear(load, touched, here, bears):
    """Fills `bears` (n, balls): whether both raceways carry a ball at outputs `here`, and at those before and behind.

    And it touches neither neighbour: `touched` (outputs, balls, or none) are those that touch the next one ahead.
    """
    last, balls = len(load) - 1, load.shape[1]
    for row, now in enumerate(here):
        for ball in range(balls):
            for at in (max(now - 1, 0), now, min(now + 1, last)):
                free = not (load[at, ball, 0] > 0.0 and load[at, ball, 1] > 0.0)
                if free or (len(touched) > 0 and (touched[at, ball] or touched[at, ball - 1])):
                    bears[row, ball] = False


def off_balance(part: Part, moves: bool, here: np.ndarray, greatest: float) -> np.ndarray:
    """How far outputs number `here` (n,) are off at balls (n, balls, ERRORS): load [N], friction (share), torque [N m].

    The greater one of the contacts of a ball, friction over what it could be, with the `greatest` load [N] of the run.
    0 where this says nothing, as where a ring moves with its balls: they swing with it for longer than a step.
    """
    balls = part.load.shape[1]
    off = np.zeros((len(here), balls, ERRORS))
    if moves or not len(part.pointer):
        return off
    bears = np.ones((len(here), balls), bool)
    if not part.all_bear or part.near.any():
        touched = part.out["neighbour_load"] != 0.0 if part.near.any() else np.zeros((0, balls), bool)
        _bear(part.load, touched, here, bears)
        if not bears.any():
            return off
    # Copies of these rows are alike to a kernel, rows of one output and of many are not.
    names = "approach", "contact_angle", "raceway_force", "raceway_torque"
    every = len(here) == len(part.times)
    channels = part.load, *(part.out[name] for name in names)
    channels = tuple(np.ascontiguousarray(one) if every else one[here] for one in channels)
    coupled = bool(part.partners.active)
    pushes = part.out["pocket_force"][here] if coupled else np.zeros((len(here), balls))
    speeds = part.filled[2][:, CAGE_SPEED] if coupled else np.zeros(len(part.times))
    moving = pushes, np.ascontiguousarray(speeds), part.filled[0], part.begun[0], part.pointer[..., STEPS_IN]
    _left_over(_given(part.bearing, LEAST_LOAD * greatest), coupled, part.times, here, bears, channels, *moving, off)
    return off


@kernel
def _rung_out(given, relaxation_time, times, steps, bears, state, load, approach, force):
    """What `rung_out` tells, of balls (N, ...) where a part begins; `steps` (N, T, POINTED), `bears` (T, N, 2)."""
    most = 0.0
    for ball in range(len(load)):
        held, deep = load[ball], approach[ball]
        if not (held[0] > 0.0 and held[1] > 0.0):
            continue
        one, two = given.inner * held[0] / deep[0], given.outer * held[1] / deep[1]
        both, angle, speed = one + two, state[ball, ORBIT_ANGLE], state[ball, TANGENTIAL_VELOCITY]
        left = (force[ball, 0] + given.mass * given.gravity[0]) * math.cos(angle)
        left += (force[ball, 1] + given.mass * given.gravity[1]) * math.sin(angle)
        left += given.mass * speed * speed / state[ball, AXIS_DISTANCE]
        swing, lost, before = math.sqrt(both / given.mass) / SWING, False, 0.0
        for now in range(len(times)):
            lost = lost or (times[now] - before) * swing >= steps[ball, now, STEPS_IN]
            before = times[now]
            if lost and bears[now, ball, 0] > 0.0 and bears[now, ball, 1] > 0.0:
                # It falls: no later output shows more.
                falls = math.exp(-0.5 * both * relaxation_time / given.mass * before)
                most = max(most, falls * abs(left) * max(one, two) / both)
                break
    return most


def rung_out(parameters: BearingScene, part: Part) -> float:
    """What loads [N] are off as steps end the swing of balls that are out of balance where a part begins.

    A mass on the contacts with both raceways, each with a viscous term as their stiffness: its swing falls as
    exp(-k tau t / 2 m). It is lost from the first output on up to which steps are longer than it takes.
    """
    state, orientation, _, _, border = (one[None] for one in part.begun)
    out, bearing = empty_outputs(parameters, 1), part.bearing
    begun = np.zeros(1), state, orientation, border
    write_outputs(parameters, bearing, part.partners, part.drive, *begun, out.numbers, 0)
    channels = (np.ascontiguousarray(out[name][0]) for name in ("normal_load", "approach", "raceway_force"))
    instants = part.times, part.pointer, part.load
    return _rung_out(_given(bearing, 0.0), float(bearing.relaxation_time), *instants, part.begun[0], *channels)


def _given(bearing: Bearing, least: float) -> _Given:
    friction = float(bearing.friction_coefficient)
    ball = bearing.ball_mass, bearing.ball_inertia, bearing.ball_radius
    powers = bearing.inner.law.power, bearing.outer.law.power
    # Slip dies out by what friction does to place and spin of a ball; where there is no friction it never does.
    relaxing = friction / (bearing.friction_regularisation * bearing.ball_mass)
    gravity = tuple(map(float, bearing.gravity))
    creeps, held = float(bearing.friction_regularisation), bearing.pockets
    pocket = (float(held.radius), float(held.friction)) if isinstance(held, Pockets) else (1.0, 0.0)
    known = *map(float, (*ball, *powers)), gravity, max(friction, NO_FRICTION), relaxing, float(least)
    return _Given(*known, creeps, *pocket)


def between_steps(parameters: BearingScene, part: Part, tolerance: float, greatest: float) -> np.ndarray:
    """A row of WINDOW with what loads and friction are off between steps; none where nothing is.

    `greatest` [N] is the greatest load of the run.
    """
    moves = dimension_of(parameters) == FREE_RING
    off = off_balance(part, moves, in_longest_steps(part), greatest).reshape(-1, ERRORS).max(axis=0, initial=0.0)
    if len(part.pointer) and not moves:
        off[0] = max(float(off[0]), rung_out(parameters, part))
    rows = np.zeros((int(off.any()), len(WINDOW.columns)))
    rows[:, : PLACE["contact_angle"]] = part.elapsed + part.duration, part.elapsed, BETWEEN, 0.0, tolerance, *off
    return rows
