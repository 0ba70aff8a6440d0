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
KEY, SINCE = "predicted_cost", "since_s"


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


class Account:
    """What the choices of a run foretell, one after the other: of the last one what it takes, of all what they err.

    `errors` are the greatest foretold of each output, of those that every choice foretold.
    """

    def __init__(self, predicted: Mapping[str, Any] | None):
        self.errors = _errors_in(predicted)
        self._predicted, self._since, self._before = predicted, 0.0, {}

    def goes_on(self, predicted: Mapping[str, Any] | None, seconds: float, costs: Mapping[str, int]) -> None:
        """Another choice is in use from `seconds` [s] on, when the run had taken these costs."""
        errors = _errors_in(predicted)
        self.errors = {key: max(self.errors[key], errors[key]) for key in self.errors.keys() & errors.keys()}
        self._predicted, self._since, self._before = predicted, seconds, dict(costs)

    def told(self, costs: Mapping[str, int], seconds: float) -> dict[str, Any]:
        """As `cost_told` for a run of `seconds` [s] with these costs, from when the last choice began: `since_s`."""
        own = {name: count - self._before.get(name, 0) for name, count in costs.items()}
        told = cost_told(self._predicted, own, seconds - self._since)
        return {key: one | ({SINCE: self._since} if self._since else {}) for key, one in told.items()}


def logged(said: Mapping[str, Any]) -> tuple[dict[str, float], dict[str, Any]] | None:
    """As `Account` has `errors` and `told`, of a choice made under way, as a log's record of a run says.

    None where it says of none, or anything else.
    """
    cost, wanted = said.get(KEY), said.get("wanted_errors")
    if not (isinstance(cost, Mapping) and isinstance(wanted, Mapping) and str(cost.get("counted")) in WORDS):
        return None
    numbers = [cost.get(name) for name in ("predicted", "taken", "ratio", SINCE)]
    if not all(isinstance(one, int | float) and math.isfinite(one) for one in numbers):
        return None
    rows = {f"{output.removesuffix('s')}_error": one for output, one in wanted.items() if isinstance(one, Mapping)}
    return _errors_in({key: one.get("predicted") for key, one in rows.items()}), {KEY: dict(cost)}


def _errors_in(predicted: Mapping[str, Any] | None) -> dict[str, float]:
    return {key: one for key, one in (predicted or {}).items() if key.endswith("_error") and isinstance(one, float)}


def cost_in_words(told: Mapping[str, Any]) -> str:
    """What `cost_told` says, for people."""
    since = f" from {told[SINCE]:.6g} s on" if SINCE in told else ""
    sentence = f"{told['taken']} {WORDS[told['counted']]}{since}, foretold {two_digits(told['predicted'])}"
    if BESIDE in told:
        sentence += f"; not counted: {told[BESIDE]} evaluations of what acts on a ball, to find how balls move"
    return f"{sentence}; {told['reason']}" if "reason" in told else sentence
