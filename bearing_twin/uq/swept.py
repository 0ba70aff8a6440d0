"""The sweep of a study as its summary has it: which key, at which values, and where the study itself stands in it."""

from collections.abc import Callable, Mapping
from typing import Any

from bearing_twin.units import labelled, unit_for_people, with_unit
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.scene_keys import numeric_keys, value_at
from bearing_twin.uq.study import Study


def sweep_head(study: Study) -> dict[str, Any]:
    """Key, unit and values [SI] of a sweep, and the value `at` which the scene of the study has the key."""
    key, values = study.sweep
    at = value_at(study.scene, key)
    at = float(at) if isinstance(at, (int, float)) else None
    return {"key": key, "unit": numeric_keys(study.kind)[key].unit, "at": at, "values": list(values)}


def sweep_of(result: StudyResult) -> dict[str, Any] | None:
    """The sweep of a result, also of one whose log an earlier version wrote; None without one."""
    summary = result.summary
    return {**sweep_head(result.study), **summary["sweep"]} if "sweep" in summary else None


class SweepInWords:
    """How people read a sweep: `key`, `unit`, `label` of an axis, the `values` that have a study, and its own `place`.

    `shown(unit, size)` gives (unit, factor) in which values of that size are told. `at` tells the place, empty where a
    log does not say it; `ended` is empty where every value has its study.
    """

    def __init__(self, sweep: Mapping[str, Any], shown: Callable = unit_for_people):
        values, at = [one["value"] for one in sweep["studies"]], sweep.get("at")
        unit, factor = shown(sweep.get("unit", "1"), max(map(abs, [*values, at or 0.0])))
        self.key, self.unit, self.label = sweep["key"], unit, labelled(sweep["key"], unit)
        self.values, self.place = [factor * one for one in values], None if at is None else factor * at
        self.at = "" if at is None else f"{self.key} = {self.place:.6g}{with_unit(unit)}"
        asked = len(sweep.get("values", values))
        left = f"{asked - len(values)} of the {asked} values of its sweep" if values else "its sweep"
        self.ended = f"the study ended before {left}" if asked > len(values) else ""
