"""The report on a run, one for every kind of scene: model, cost, figures, their errors; and JSON."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

LISTED = 3  # values of a list that are shown one by one
DIGITS = 18  # of a whole number that is no float


class Choice(NamedTuple):
    """Elastic law and stepper of a scene, the law's relative load error there, the reason, and what to watch.

    `setting` is the tolerance that the stepper is given, nan for the requested one. `outside` says which specified
    model runs outside its range; `friction` is the friction model, where the scene leaves it open. `finer`: how many
    times as many steps, modes or divisions as were chosen a second run takes.
    """

    law: str
    stepper: str
    law_error: float
    reason: str
    warnings: tuple[str, ...]
    setting: float = math.nan
    outside: tuple[str, ...] = ()
    friction: str = ""
    finer: float = 1.0


class CutShort(NamedTuple):
    """End of a log whose scene goes on, and the end of the scene: output times in s."""

    log_ends: float
    scene_ends: float

    def as_dict(self) -> dict[str, float]:
        """For `--json`."""
        return {"log_ends_s": self.log_ends, "scene_ends_s": self.scene_ends}

    def sentence(self) -> str:
        """A warning for figures of such a log."""
        return (
            f"the log ends at {self.log_ends:.6g} s of the {self.scene_ends:.6g} s that its scene simulates: the run "
            "was interrupted, or there was no room for the rest"
        )


@dataclass(frozen=True, repr=False)
class Report:
    """A run in numbers: models, cost, warnings (`warnings` before the run, `flags` after it) and `figures`.

    `status` is "done", or states what is doubtful or failed. The keys of `figures` end with the SI unit; `errors` holds
    `<figure>_error` in the figure's unit, and errors by source. `outside` is that of the choice. `failure`, of a run
    that broke off, has sentence, reason, time, body and contact.
    """

    scene: str
    law: str
    stepper: str
    choice_reason: str
    warnings: tuple[str, ...]
    flags: tuple[str, ...]
    status: str
    simulated_seconds: float
    compute_seconds: float
    samples: int
    costs: dict[str, int]
    figures: dict[str, Any]
    errors: dict[str, Any] = field(default_factory=dict)
    outside: tuple[str, ...] = ()
    failure: dict[str, Any] | None = None

    @property
    def real_time_factor(self) -> float:
        """Simulated over computed seconds; NaN where the time is not known."""
        return self.simulated_seconds / self.compute_seconds if self.compute_seconds > 0.0 else math.nan

    def __repr__(self) -> str:
        title = f"{self.scene}: {self.status}; {self.simulated_seconds:.6g} s by {self.law} and {self.stepper}"
        return summary_text(title, self.figures)

    def record(self) -> dict[str, Any]:
        """Record of the run for its log: the report, and which of its numbers are costs."""
        return self.as_dict() | {"costs": dict(self.costs)}

    def as_dict(self) -> dict[str, Any]:
        """Plain data for `--json` and tables."""
        return {
            "scene": self.scene,
            "law": self.law,
            "stepper": self.stepper,
            "choice_reason": self.choice_reason,
            "status": self.status,
            **(self.failure or {}),
            "warnings": list(self.warnings),
            "flags": list(self.flags),
            "simulated_s": self.simulated_seconds,
            "compute_s": self.compute_seconds,
            "real_time_factor": self.real_time_factor,
            "samples": self.samples,
            **({"outside_range": list(self.outside)} if self.outside else {}),
            **self.costs,
            **self.figures,
            **self.errors,
        }


def summary_text(title: str, numbers: Mapping[str, Any]) -> str:
    """A short text of a result: the title, and a line for each key with its value, or the range of long ones."""
    return "\n".join([title, *(f"  {key:<36} {_value_text(value)}" for key, value in numbers.items())])


def _value_text(value) -> str:
    values = list(value) if isinstance(value, (list, tuple)) else [value]
    if not all(isinstance(number, (int, float)) for number in values):
        return "-" if value is None else f"{len(values)} rows" if isinstance(value, (list, tuple)) else str(value)
    if len(values) > LISTED:
        return f"{min(values):.6g} to {max(values):.6g} ({len(values)} values)"
    return ", ".join(f"{number:.6g}" for number in values)


def parse_json(text: str | bytes):
    """The data in a JSON text from an untrusted source; ValueError for invalid or too deeply nested JSON.

    An integer of more than 18 digits becomes a float.
    """
    try:
        return json.loads(text, parse_int=lambda digits: int(digits) if len(digits) <= DIGITS else float(digits))
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def json_text(result) -> str:
    """A result as one line of JSON."""
    return json.dumps(json_data(result), allow_nan=False)


def json_data(value):
    """The value as JSON data: lists in place of NumPy arrays, null in place of NaN."""
    if isinstance(value, dict):
        return {str(key): json_data(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_data(item) for item in value]
    if hasattr(value, "tolist"):
        return json_data(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)
