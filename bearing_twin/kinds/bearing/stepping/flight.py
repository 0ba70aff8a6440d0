"""How long the next step of a ball in a lane may be: to the end of the chunk at most, and short in flight.

A step that begins and ends in flight may have passed over a bounce: where none of its stages lies in contact, its error
estimate sees nothing, at any tolerance. Rosenbrock methods do so, whose stages are few and far apart; the seven stages
of dopri5 were not found to.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import inner_approach, outer_approach
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, ORBIT_ANGLE
from bearing_twin.numerics.lanes import LANES, START, STEP, get
from bearing_twin.numerics.rosenbrock import cut_to_end

LONGEST_FLIGHT = 5e-5  # s, of a step that begins in flight: a bounce takes about as long


@inlined
def _flying(bearing, lanes, k):
    """Whether the ball in lane `k` touches neither raceway at the start of its step."""
    radius, height = get(lanes, START + AXIS_DISTANCE, k), get(lanes, START + HEIGHT, k)
    if outer_approach(bearing, radius, height) >= 0.0:
        return False  # as nearly always, so that this is all it costs
    return inner_approach(bearing, radius, get(lanes, START + ORBIT_ANGLE, k), height) < 0.0


@inlined
def by_themselves(coupling):
    """Whether no ring and no cage couples the balls: nothing does, or they may touch each other."""
    if len(coupling) > 0:
        return not coupling.border.active
    return True


@inlined
def cut_steps(bearing, coupling, blocks):
    """Cuts what each lane would step in its stretch; what it wants otherwise is WANTED.

    Balls that share steps with a ring or a cage have the short ones of those in contact. Of those that share them with
    each other all may fly: where one does, all steps are short.
    """
    short = by_themselves(coupling)
    if len(coupling) > 0 and short:
        short = get(blocks[0], STEP, 0) > LONGEST_FLIGHT and _any_flies(bearing, blocks)
    for lanes in blocks:
        for k in range(LANES):
            wanted = get(lanes, STEP, k)
            if short and wanted > LONGEST_FLIGHT and (len(coupling) > 0 or _flying(bearing, lanes, k)):
                wanted = LONGEST_FLIGHT
            cut_to_end(wanted, lanes, k)


@inlined
def _any_flies(bearing, blocks):
    flies = False
    for lanes in blocks:
        for k in range(LANES):
            flies = flies or _flying(bearing, lanes, k)
    return flies
