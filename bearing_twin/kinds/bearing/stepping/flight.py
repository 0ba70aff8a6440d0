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
def cut_steps(bearing, alone, blocks):
    """Cuts what each lane would step in its stretch; what it wants otherwise is WANTED.

    Balls that are not `alone` share their steps, the short ones of balls in contact.
    """
    for lanes in blocks:
        for k in range(LANES):
            wanted = get(lanes, STEP, k)
            if alone and wanted > LONGEST_FLIGHT and _flying(bearing, lanes, k):
                wanted = LONGEST_FLIGHT
            cut_to_end(wanted, lanes, k)
