"""Steppers by name, with order, treatment of stiffness and source, for those who only read a scene: no arrays."""

from typing import NamedTuple


class StepperFacts(NamedTuple):
    """What a stepper is: its order, whether its step adapts, how it treats stiffness, and where it comes from."""

    order: int
    adaptive: bool
    treats: str
    source: str


STEPPER_FACTS = {
    "rodas4": StepperFacts(
        4,
        True,
        "contact and friction implicitly",
        "Hairer and Wanner, Solving ODE II, 2nd ed. 1996, section IV.7: RODAS, order 4(3), L-stable",
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
