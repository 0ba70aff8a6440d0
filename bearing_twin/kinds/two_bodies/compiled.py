"""Two bodies as the compiled core takes them (`core/bodies/two_bodies.cpp`): numbers in, motion and outputs back."""

from typing import NamedTuple

import numpy as np

from bearing_twin.contact.patch_friction import patch_by
from bearing_twin.core import INTEGERS_OUT, REALS, REALS_OUT, Function
from bearing_twin.kinds.bouncing import CoreBodies, advancing, giving_outputs
from bearing_twin.shapes.implicit import Surface

COLUMNS = 46
BODY = 13
POSITION, QUATERNION, VELOCITY, MOMENTUM, UNKNOWNS = 0, 3, 7, 10, 34
"""Of the state, PairState of the core: a body's part, in which it is the first; the second's begins at BODY. A held
body's momentum is its angular velocity."""

CLOCK = 6
IN_CONTACT, DRIFT, OFF = 2, 3, 5
"""Of PairClock, beside those of `bouncing`: whether in contact; greatest drift of a quaternion's norm, and
distance [m] of the opposing points from meeting their equations, at the end of a step."""

RECORD = 20
ENDED, BEGAN, RUB_X, DEEPEST_APPROACH = 0, 1, 13, 16
"""Of ContactRecord: times [s], impulse of friction (3,) [N s], greatest approach [m]."""

_start = Function("core_two_bodies_start", None, (REALS, REALS, REALS, *(REALS_OUT,) * 3, INTEGERS_OUT))
advance = advancing("core_two_bodies_advance")
write_outputs = giving_outputs("core_two_bodies_outputs")


class Rigid(NamedTuple):
    """One body: surface, mass [kg] (0 where it is held), principal moments of inertia, reach of its surface [m]."""

    surface: Surface
    mass: float
    inertia: tuple[float, float, float]
    reach: float

    @property
    def inverse_mass(self) -> float:
        """1/mass, 0 of a held body."""
        return 1.0 / self.mass if self.mass else 0.0

    def numbers(self) -> list[float]:
        """The same as the core reads it."""
        return [self.mass, *self.inertia, *self.surface.numbers(), self.reach]


def pair_numbers(a: Rigid, b: Rigid, gravity, size, tracking, by_overlap, law, contact, friction: str) -> CoreBodies:
    """The pair of two bodies with an elastic law and what `bouncing.contact_numbers` gives of the contact.

    `size` [m] is about the least radius; `by_overlap`: the load is that of the true overlap.
    """
    patch, points = patch_by(friction, contact["friction"])
    numbers = [
        *(*a.numbers(), *b.numbers(), *gravity, contact["sink"], size, tracking, by_overlap, *law),
        *(*contact["damping"], contact["regularisation"], *patch),
    ]
    return CoreBodies(np.array(numbers, float), points)


def open_record(pair: CoreBodies, plan, state, clock, record, counts) -> None:
    """Opens the record of a contact in which the bodies are at the start."""
    _start(*pair, plan, state, clock, record, counts)
