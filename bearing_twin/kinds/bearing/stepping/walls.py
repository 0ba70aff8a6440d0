"""Steps that end where a ball meets the wall of its pocket, or leaves it, and where a cage does so with its land.

The force of a wall has a bend there. A step across it misses its tolerance by a factor of thousands, and so do several
shorter ones, as the estimate does not tell where the bend lies. But it can be told from the motion at the start: free
balls and cage move apart evenly, and a spring pushes them apart. Steps end a little behind the bend, so that the
Jacobian of the next one knows on which side it is.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.cage import ONSET, bump
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    CAGE,
    CAGE_X,
    CAGE_Y,
    CLOSING,
    ORBIT_ANGLE,
    PLACES,
    POCKET,
    RADIAL_VELOCITY,
    RING_X,
    RING_Y,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.moving_cage import seen, wall
from bearing_twin.kinds.bearing.stepping.border import CAGE_SPEED
from bearing_twin.numerics.lanes import END, LANE_RATES, LANES, START, STEP, get, get_vector, put
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import cosine_sine

NEVER, NOWHERE = 1e30, 1e-30  # s, m
BEHIND = 0.5  # of the approach that makes a ball err by all its scale where the wall's stiffness is not known of
FIRST = 0.2  # of ONSET: what a ball may go into a wall in the first step there


@inlined
def _gap(pockets, bearing, numbers, lanes, k):
    """Approach of lane k's ball to the nearer wall of its pocket at the start of a step [m], its rate, and the side."""
    radius, angle = get(lanes, START + AXIS_DISTANCE, k), get(lanes, START + ORBIT_ANGLE, k)
    velocity, spin = get_vector(lanes, START + VELOCITY, k), get_vector(lanes, START + SPIN, k)
    ahead, speed = angle - numbers[at.BEGIN + CAGE] - get(lanes, POCKET, k), numbers[at.BEGIN + CAGE_SPEED]
    if len(pockets) > 1:
        found = bump(pockets, bearing, radius, ahead, velocity, spin, speed)
        return found.approach, found.rate, found.side
    cosine, sine = cosine_sine(angle)
    place, moving = at.BEGIN + CAGE_X, at.BEGIN + PLACES + CAGE_X
    centre = seen(numbers[place], numbers[place + 1], cosine, sine)
    drift = seen(numbers[moving], numbers[moving + 1], cosine, sine)
    met = wall(pockets.walls, bearing, radius, ahead, centre, drift, velocity, spin, speed)
    return met.approach, met.rate, met.side


@inlined
def _walls(pockets):
    if len(pockets) == 1:
        return pockets.walls
    return pockets


@inlined
def _together(pockets, bearing, numbers):
    """The mass [kg] by which a ball and the cage are pushed apart."""
    arm = _walls(pockets).radius
    inverse = 1.0 / bearing.ball_mass + arm * arm * numbers[at.FREE + CAGE] / numbers[at.MASS + CAGE]
    if len(pockets) == 1:
        inverse += numbers[at.FREE + CAGE_X] / numbers[at.MASS + CAGE_X]
    return 1.0 / inverse


@inlined
def _until_met(far, rate, growth):
    """Seconds until a ball has gone `far` [m] > 0 towards a wall, its rate growing by `growth` [m/s^2]."""
    square = rate * rate + 2.0 * growth * far
    speed = rate + math.sqrt(max(square, 0.0))
    return 2.0 * far / speed if square >= 0.0 and speed > 0.0 else NEVER


@inlined
def _until_left(walls, mass, margin, approach, rate):
    """Seconds until a wall that a ball presses on has let go of it; its push falls off about evenly."""
    share = walls.relaxation_time * rate * approach / (approach + ONSET)
    if rate >= 0.0 or approach + share <= 0.0:
        return NEVER
    # The viscous part draws back as much as the spring pushes where the approach is T |rate| - ONSET.
    far = approach - max(-walls.relaxation_time * rate - ONSET, 0.0) + margin
    push = walls.stiffness * (approach + share) / (3.0 * mass)
    return 2.0 * far / (math.sqrt(rate * rate + 4.0 * push * far) - rate)


@inlined
def _next_bend(law, mass, blur, approach, rate, growth):
    """Seconds until a wall of this law is met or left behind; where the approach is below 0, `growth` is the rate's."""
    margin = BEHIND * math.sqrt(blur * abs(rate))
    if approach < 0.0:
        return _until_met(margin - approach, rate, growth)
    return _until_left(law, mass, margin, approach, rate)


@inlined
def _off_land(land, numbers, first):
    """Where the cage's centre is from the land's, in places, speeds or accelerations that begin at `first` (2,)."""
    inner = 1.0 if land.side < 0.0 else 0.0
    x = numbers[first + CAGE_X] - inner * numbers[first + RING_X]
    return x, numbers[first + CAGE_Y] - inner * numbers[first + RING_Y]


@inlined
def _land_rate(land, numbers):
    """Approach of the cage to its land at the start of a step [m], its rate, and how fast that grows [m/s^2]."""
    x, y = _off_land(land, numbers, at.BEGIN)
    along, across = _off_land(land, numbers, at.BEGIN + PLACES)
    distance = math.sqrt(x * x + y * y) + NOWHERE
    rate, turn = (x * along + y * across) / distance, (x * across - y * along) / distance
    return distance - land.clearance, rate, turn * turn / distance


@lean_kernel
def _note_land(land, numbers):
    """Keeps how fast the cage's centre comes to move towards its land [m/s^2], its way round it left out."""
    if len(land) > 0:
        x, y = _off_land(land, numbers, at.BEGIN)
        along, across = _off_land(land, numbers, at.RATES + PLACES)
        numbers[at.LAND_CLOSING] = (x * along + y * across) / (math.sqrt(x * x + y * y) + NOWHERE)


@lean_kernel
def _meet_land(land, numbers, step):
    """Seconds until the cage meets its land or leaves it, `step` where there is none, and a step to go on with [s]."""
    if len(land) > 0:
        approach, rate, growth = _land_rate(land, numbers)
        inner = 1.0 if land.side < 0.0 else 0.0
        inverse = numbers[at.FREE + CAGE_X] / numbers[at.MASS + CAGE_X]
        mass = 1.0 / (inverse + inner * numbers[at.FREE + RING_X] / numbers[at.MASS + RING_X])
        blur = mass / (land.stiffness * numbers[at.INVERSE_SCALES + PLACES + CAGE_X])
        until = _next_bend(land, mass, blur, approach, rate, growth + numbers[at.LAND_CLOSING])
        return (until, FIRST * ONSET / rate) if approach < 0.0 else (until, NEVER)
    return step, NEVER


@inlined
def note_closing(pockets, coupling, blocks):
    """Keeps how fast the rate grows at which each ball comes forward in its pocket [m/s^2], after an accepted step."""
    if len(pockets) > 0:
        numbers, speeds = coupling.border.numbers, at.RATES + PLACES
        for block in range(len(blocks)):
            lanes, arm = blocks[block], _walls(pockets).radius
            for k in range(LANES):
                radius, speed = get(lanes, END + AXIS_DISTANCE, k), get(lanes, END + TANGENTIAL_VELOCITY, k)
                turning = speed * get(lanes, END + RADIAL_VELOCITY, k) / radius
                grown = (get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - turning) / radius - numbers[speeds + CAGE]
                drift = 0.0
                if len(pockets) == 1:
                    cosine, sine = cosine_sine(get(lanes, END + ORBIT_ANGLE, k))
                    drift = seen(numbers[speeds + CAGE_X], numbers[speeds + CAGE_Y], cosine, sine)[1]
                put(lanes, CLOSING, k, arm * grown - drift)
        _note_land(coupling.border.land, numbers)


@inlined
def meet_walls(pockets, bearing, coupling, scales, blocks):
    """Cuts the coming step where a ball meets a wall or leaves it; returns the step to go on with [s], 0 if uncut.

    `scales` (MOTION,) are the errors a step may make. Where there are no pockets, it does nothing.
    """
    if len(pockets) > 0:
        numbers, walls = coupling.border.numbers, _walls(pockets)
        mass = _together(pockets, bearing, numbers)
        wanted = step = get(blocks[0], STEP, 0)
        resume, blur = 0.0, scales[TANGENTIAL_VELOCITY] * bearing.ball_mass / walls.stiffness
        for place in range(coupling.border.count):
            lanes, k = blocks[place // LANES], place % LANES
            approach, rate, side = _gap(pockets, bearing, numbers, lanes, k)
            until = _next_bend(walls, mass, blur, approach, rate, side * get(lanes, CLOSING, k))
            if until < step:
                step, resume = until, min(wanted, FIRST * ONSET / rate) if approach < 0.0 else wanted
        until, first = _meet_land(coupling.border.land, numbers, step)
        if until < step:
            step, resume = until, min(wanted, first)
        if step < wanted:
            for block in range(len(blocks)):
                for k in range(LANES):
                    put(blocks[block], STEP, k, step)
        return resume
    return 0.0
