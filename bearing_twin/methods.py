"""Integration methods: their names and what is known of them; how a stretch of an integration ended.

One table of statuses, so that a number means the same in every kind. OK: all of it is done; NOT_FINITE: a state is not
a number any more; TOO_DEEP: bodies have run through each other; STALLED: an iteration or the step control makes no
progress; FULL: the arrays handed over are full; SEPARATED: the bodies have come apart; TIME_UP: the time limit is
reached and they have not; STOPPED: an interruption was requested; UNTRACKED: the opposing points found are no contact
of two bodies.
"""

from typing import NamedTuple

NOTHING = 1e-12  # share of a stretch that is too short for a step


class StepperFacts(NamedTuple):
    """A stepper: its order, whether its step adapts, its treatment of stiffness, and its source.

    `coupled`: it moves a ring with mass and a cage together with the balls, and takes samples between its steps.
    """

    order: int
    adaptive: bool
    treats: str
    source: str
    coupled: bool = False


STEPPER_FACTS = {
    "rodas4": StepperFacts(
        4,
        True,
        "contact and friction implicitly",
        "Hairer and Wanner, Solving ODE II, 2nd ed. 1996, section IV.7: RODAS, order 4(3), L-stable",
        coupled=True,
    ),
    "rodas4_landing": StepperFacts(
        4,
        True,
        "contact and friction implicitly",
        "rodas4 whose steps end where a contact begins or ends, found on its interpolant",
    ),
    "rodas3": StepperFacts(
        3,
        True,
        "contact and friction implicitly",
        "Sandu et al., Atmospheric Environment 31 (1997) 3459: RODAS3, order 3(2), L-stable",
        coupled=True,
    ),
    "imex": StepperFacts(
        2,
        False,
        "friction and damping implicitly",
        "leapfrog (Stoermer, Verlet) in the positions, linearly implicit midpoint rule in the velocities",
    ),
    "rk4": StepperFacts(4, False, "nothing implicitly", "Kutta 1901, the classical method"),
    "dopri5": StepperFacts(
        5, True, "nothing implicitly", "Dormand and Prince, J. Comp. Appl. Math. 6 (1980) 19: order 5(4)"
    ),
    "dop853": StepperFacts(8, True, "nothing implicitly", "SciPy DOP853; a reference"),
    "radau": StepperFacts(5, True, "everything implicitly", "SciPy Radau IIA; a reference"),
}
COUPLED = tuple(name for name, facts in STEPPER_FACTS.items() if facts.coupled)

OK, NOT_FINITE, TOO_DEEP, STALLED, FULL, SEPARATED, TIME_UP, STOPPED, UNTRACKED = range(9)

REASONS = {NOT_FINITE: "not finite", TOO_DEEP: "too deep", STALLED: "stalled", UNTRACKED: "untracked"}
NO_END = "no end"
"""The reason that an `IntegrationError` gives for such an end, and for a contact that does not end."""

STEPS, REJECTIONS, EVALUATIONS, JACOBIANS = range(4)
"""Costs of a stretch: steps, rejected steps, right-hand sides, linearisations."""
