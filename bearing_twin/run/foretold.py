"""What a run was foretold to take beside what it took, counted in what is the same on every machine: the one writer."""

import math
from collections.abc import Mapping
from typing import Any

from bearing_twin.report import BESIDE
from bearing_twin.units import two_digits

MUCH = 3.0  # times what was foretold: a run that took more says so
WORDS = {
    "ball_rates": "evaluations of a ball's rates",
    "evaluations": "evaluations of the equations of motion",
    "steps": "steps",
    "equilibria": "equilibria",
}
"""What a prediction may count, by its name in the costs of a run."""
KEY = "predicted_cost"


def cost_told(predicted: Mapping[str, Any] | None, costs: Mapping[str, int], seconds: float) -> dict[str, Any]:
    """The key `predicted_cost` of a report on `seconds` [s] of a run; empty where nothing was foretold, or counted.

    What a choice `predicted` says what is `counted`, how much of it there is `at_start`, `a_second`, and `a_touch` of
    those that the run had. What finding how balls move took `before` the run, and in it, is told beside these.
    """
    given = predicted or {}
    counted, numbers = given.get("counted"), [given.get(name, 0.0) for name in ("at_start", "a_second", "a_touch")]
    if (
        not isinstance(counted, str) or counted not in WORDS or not all(isinstance(one, int | float) for one in numbers)
    ):  # a log may say anything
        return {}
    taken = costs.get(counted, 0)
    foretold = numbers[0] + numbers[1] * seconds + numbers[2] * costs.get("touches", 0)
    if not (taken and math.isfinite(foretold) and foretold > 0.0):
        return {}
    told = {"counted": counted, "predicted": foretold, "taken": taken, "ratio": taken / foretold}
    before = given.get("before")
    beside = costs.get(BESIDE, 0) + (before if isinstance(before, int) else 0)
    told |= {BESIDE: beside} if beside > 0 else {}
    if told["ratio"] > MUCH:
        times, where = two_digits(told["ratio"]), given.get("motion", "-")
        why = f"it moves otherwise than what was measured ({where}), or parts were made again to keep what is wanted"
        if numbers[2]:
            why = f"it stays in contact, of which no table has a row, or bounces otherwise than measured ({where})"
        told["reason"] = f"the run took {times} times the {WORDS[counted]} that were foretold: {why}"
    return {KEY: told}


def cost_in_words(told: Mapping[str, Any]) -> str:
    """What `cost_told` says, for people."""
    sentence = f"{told['taken']} {WORDS[told['counted']]}, foretold {two_digits(told['predicted'])}"
    if BESIDE in told:
        sentence += f"; not counted: {told[BESIDE]} evaluations of what acts on a ball, to find how balls move"
    return f"{sentence}; {told['reason']}" if "reason" in told else sentence
