"""Law and method of a shaft on two bearings, and what speaks against equilibria of its balls."""

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.kinds.bearing import models as of_bearings
from bearing_twin.kinds.bearing.equilibrium import centrifugal_ratio, equilibrium_error
from bearing_twin.kinds.rules import SHAFT, answers, sentences
from bearing_twin.kinds.shaft.course import speeds_of
from bearing_twin.kinds.shaft.derived import bearing_scene
from bearing_twin.kinds.shaft.equilibrium import balance_of
from bearing_twin.kinds.shaft.modes import modes_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

SAME = 1e-9  # relative: speeds nearer than this are one
FAST = 1000.0  # Hz: balls that are in balance at every instant answer later motion at once


def law_error(parameters: ShaftScene, law: str) -> float:
    """Greatest relative load error of a law against exact Hertz at the nominal contacts of both bearings."""
    return max(of_bearings.law_error(law, bearing_scene(parameters, side)) for side in SIDES)


def shares_of(parameters: ShaftScene, law: str, commanded: float = 0.0) -> dict[str, float]:
    """The centrifugal load over that on the inner raceway by bearing, in balance at the greatest speed [rad/s].

    That is the scene's, or a greater `commanded` one. Of the loads at the run's start and end those count under which
    it is greater. Raises SceneError where nothing carries them.
    """
    speed, shares = max(speeds_of(parameters), key=abs), dict.fromkeys(SIDES, 0.0)
    speed = commanded if commanded > abs(speed) * (1.0 + SAME) else speed
    for time in (0.0, float(parameters.run.duration)):
        for side, contacts in zip(SIDES, balance_of(parameters, law, float(speed), time).contacts, strict=True):
            shares[side] = max(shares[side], centrifugal_ratio(contacts))
    return shares


def choose(parameters: ShaftScene) -> Choice:
    """Law and method; raises SceneError where the shaft is not in balance as its run begins, or as it ends."""
    found, warnings = answers(SHAFT, parameters), []
    law = found["contact.normal"].value
    balance_of(parameters, law, float(parameters.drive.speed))
    end = float(parameters.run.duration)
    try:
        balance_of(parameters, law, float(speeds_of(parameters)[-1]), end)
    except SceneError as problem:
        raise SceneError(f"at {end:g} s, where the run ends, {problem}") from problem
    error = law_error(parameters, law)
    share = max(shares_of(parameters, law).values())
    if equilibrium_error(share) > parameters.wanted.tolerance:
        warnings.append(
            f"the centrifugal load is {share:.2g} of a contact's, where balls in balance are off by up to "
            f"{100.0 * equilibrium_error(share):.2g} % of the greatest load until the axes of their spin have settled"
        )
    slow = [f"{one:.4g}" for one in modes_of(parameters, law)[0].frequencies if one > FAST]
    if slow:
        warnings.append(
            f"motion at {' and '.join(slow)} Hz is near that of balls by themselves, which are taken to be in balance "
            "at once; a scene of the kind bearing moves them, on one ring with mass"
        )
    if error > parameters.wanted.tolerance:
        warnings.append(f"the law {law} is {100.0 * error:.2g} % off exact Hertz here; contact.normal: hertz is exact")
    reason = (
        f"{sentences(found)}; balls are in balance at every instant, in cages that orbit as loaded balls roll; the "
        f"centrifugal load is at most {share:.2g} of a contact's"
    )
    return Choice(law, found["solver.stepper"].value, error, reason, tuple(warnings))
