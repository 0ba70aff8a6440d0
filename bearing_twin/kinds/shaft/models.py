"""Law and method of a shaft on two bearings, and what speaks against equilibria of its balls."""

import math

from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing import models as of_bearings
from bearing_twin.kinds.bearing.still import centrifugal_share, still_error
from bearing_twin.kinds.charted import (
    EVEN_SHAFT,
    HURRIED_SHAFT,
    KNOCKED_SHAFT,
    UNEVEN_SHAFT,
    evaluations_of,
    in_words,
    predicted,
    row_of,
)
from bearing_twin.kinds.law_words import HERTZ_FOLLOWS
from bearing_twin.kinds.shaft.derived import bearing_scene, speeds_of
from bearing_twin.kinds.shaft.modes import modes_of
from bearing_twin.kinds.shaft.parameters import SETTLED, SIDES, ShaftScene
from bearing_twin.kinds.shaft.statics import balance_of
from bearing_twin.report import Choice

METHOD = "rodas4"
DIFFER = 0.5  # of the greatest load in a bearing: where the least is less, stiffness changes as balls pass
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
            shares[side] = max(shares[side], centrifugal_share(contacts))
    return shares


def choose(parameters: ShaftScene) -> Choice:
    """Law and method; raises SceneError where the shaft is not in balance as its run begins, or as it ends."""
    asked, warnings = parameters.contact.normal, []
    law = "hertz" if asked == "auto" else asked
    balance_of(parameters, law, float(parameters.drive.speed))
    end = float(parameters.run.duration)
    try:
        balance_of(parameters, law, float(speeds_of(parameters)[-1]), end)
    except SceneError as problem:
        raise SceneError(f"at {end:g} s, where the run ends, {problem}") from problem
    error = law_error(parameters, law)
    share = max(shares_of(parameters, law).values())
    if still_error(share) > parameters.wanted.tolerance:
        warnings.append(
            f"the centrifugal load is {share:.2g} of a contact's, where balls in balance are off by up to "
            f"{100.0 * still_error(share):.2g} % in load until the axes of their spin have settled"
        )
    told, why_so = _foretold(parameters, law)
    slow = [f"{one:.4g}" for one in modes_of(parameters, law)[0].frequencies if one > FAST]
    if slow:
        warnings.append(
            f"motion at {' and '.join(slow)} Hz is near that of balls by themselves, which are taken to be in balance "
            "at once; a scene of the kind bearing moves them, on one ring with mass"
        )
    if error > parameters.wanted.tolerance:
        warnings.append(f"the law {law} is {100.0 * error:.2g} % off exact Hertz here; contact.normal: hertz is not")
    why = HERTZ_FOLLOWS if asked == "auto" else f"{law}, as the scene asks"
    reason = (
        f"{why}; balls in balance at every instant, in cages that go round as loaded balls roll; {METHOD} for the "
        f"shaft, whose stiffness is exact; the centrifugal load is at most {share:.2g} of a contact's, where loads are "
        f"within {100.0 * still_error(share):.2g} % of those of moving balls; {why_so}"
    )
    return Choice(law, METHOD, error, reason, tuple(warnings), predicted=told)


def _motions_of(parameters: ShaftScene, law: str) -> tuple[str, ...]:
    """Problems of `chart motions` that a shaft is like, hardest first."""
    shaft, found = parameters.shaft, [EVEN_SHAFT]
    contacts = balance_of(parameters, law, float(parameters.drive.speed)).contacts
    if any(one.load.min() < DIFFER * one.load.max() for one in contacts):
        found.insert(0, UNEVEN_SHAFT)
    begins = shaft.start != SETTLED and len(shaft.unbalances)
    if parameters.drive.change.time:
        found.insert(0, HURRIED_SHAFT)
    if shaft.change.time or len(shaft.table) or begins:
        found.insert(0, KNOCKED_SHAFT)
    return tuple(found)


def _foretold(parameters: ShaftScene, law: str) -> tuple[dict | None, str]:
    """What the rows of motions that a shaft is like foretell, the most of all, and a sentence on it.

    Evaluations go with turns at the greatest speed, but after a jump of the load, where it rings, with time.
    """
    wanted, rows = parameters.wanted.tolerance, []
    for motion in _motions_of(parameters, law):
        row = row_of("motions", motion, METHOD, wanted)
        if row is None:
            return None, f"nothing is foretold of it, as no table has a row of it in the motion {motion}"
        rows.append(row)
    turns = max(map(abs, speeds_of(parameters))) / (2.0 * math.pi)
    counts = [(row.problem, evaluations_of(row)) for row in rows]
    at_start = max(one.at_start for _, one in counts)
    a_second = max(one.a_second if name == KNOCKED_SHAFT else one.an_event * turns for name, one in counts)
    worst = max(rows, key=lambda row: row.error)
    told = predicted(worst, "evaluations", at_start, a_second, output="ball_load")
    return told, in_words("motions", worst, wanted)
