"""Which of the motions that were measured a bearing scene is like: the rows of the tables that the chooser reads.

`bearing_twin chart steppers` measured those of balls that move each for itself, `chart motions` these and COUPLED.
"""

import math

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.adequacy import cage_needed, hurried
from bearing_twin.kinds.bearing.drive import TORQUE
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, dimension_of

STICKY = 1e-3  # m/s: a regularisation of friction below this is like the sticking one of the table
FAST = 3e5  # mm/min of speed times pitch diameter, the n d_m of catalogues
LEAST_DAMPING = 2e-7  # s of relaxation time, a fifth of the one measured with: less lets contacts ring for long
ROOM = 1.1  # ball diameters from centre to centre: less, and neighbours soon meet


def _jump(parameters) -> bool:
    change = parameters.drive.change
    return bool(change.time) and (any(change.offset) or hurried(parameters))


def _fast(parameters) -> bool:
    turns = 60.0 * abs(parameters.drive.speed) / (2.0 * math.pi)
    return turns * 1e3 * parameters.geometry.pitch_diameter >= FAST


def _free(parameters) -> bool:
    return dimension_of(parameters) == FREE_RING


def _knocked(parameters) -> bool:
    """Whether what acts on a free ring changes."""
    ring = parameters.rings.inner
    return _free(parameters) and bool(ring.change.time or len(ring.table))


SHARED = {
    "pockets": ("balls bump into the pockets of a cage", lambda one: one.cage.kind == POCKETS),
    "torque": ("a torque turns the shaft", lambda one: one.drive.kind == TORQUE),
    "ring knocked": ("the load of a free ring changes", _knocked),
    "unbalance": ("a free ring carries an unbalance", lambda one: _free(one) and one.rings.inner.unbalance > 0.0),
    "free ring": ("the ring moves with its mass", _free),
    "even cage": ("an even cage holds the balls", lambda one: one.cage.kind == EVEN and not _free(one)),
}
"""Motions of balls that share a step with each other, a cage or a ring: when a scene is like one."""
COUPLED = SHARED | {
    "drilling": ("friction is summed over the spots", lambda one: FRICTIONS[one.contact.friction].over_spot),
    "hardly damped": ("contacts are hardly damped", lambda one: 0.0 < one.contact.relaxation_time < LEAST_DAMPING),
}
"""Motions that `chart motions` alone measured."""
ALONE = {
    "sudden": ("the ring jumps", _jump),
    "sliding": ("balls start from rest", lambda one: one.initial.motion == "rest"),
    "sticking": (
        "friction is regularised below 1 mm/s",
        lambda one: one.contact.friction_regularisation <= STICKY,
    ),
    "lift-off": (
        "the load of a ball changes on its way round",
        lambda one: any(one.drive.offset[:2]) or bool(cage_needed(one)),
    ),
    "fast": ("speed times pitch diameter is above 3e5 mm/min", _fast),
    "settled": ("balls roll", lambda one: True),
}
"""Motions that `chart steppers` measured, hardest first."""
MOTIONS = COUPLED | ALONE
"""All of them: what each is, and when a scene is like it."""


def motions_of(parameters) -> tuple[str, ...]:
    """All motions of MOTIONS that a scene is like."""
    return tuple(name for name, (_, like) in MOTIONS.items() if like(parameters))


def unmeasured(parameters) -> str:
    """What a scene has that no table of steppers holds, "" for nothing."""
    geometry = parameters.geometry
    room = geometry.pitch_diameter * math.sin(math.pi / geometry.balls) / geometry.ball_diameter
    return "balls that can touch" if geometry.balls > 1 and room < ROOM and parameters.cage.kind == "none" else ""
