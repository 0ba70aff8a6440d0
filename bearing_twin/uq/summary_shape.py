"""What the summary of a study looks like; one that comes from a log is checked by it, whole, before it is used."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from bearing_twin.uq.statistics import MOMENTS
from bearing_twin.uq.study import Study


class Maybe(NamedTuple):
    """The shape of what may be left out."""

    shape: Any


def _text(value) -> bool:
    return isinstance(value, str)


def _whole(value) -> bool:
    return isinstance(value, int) and value >= 0


def _number(value) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)


def _known(value) -> bool:
    return value is None or _number(value)


def _measured(value) -> bool:
    """What is not known yet is NaN, a half-width without a bound infinite."""
    return isinstance(value, (int, float))


def _pair(value) -> bool:
    return value is None or (isinstance(value, list) and len(value) == 2 and all(map(_known, value)))


def _size(value) -> bool:
    return _number(value) and value >= 0


def _error(value) -> bool:
    return value is None or _size(value)


def _modality(value) -> bool:
    return value is None or not any(_misfits(value, {"modes": _whole, "p_value": _known}, "modality"))


def _probability(value) -> bool:
    return value.replace(".", "", 1).isdecimal()


PATH = ("samples", "estimate", "half_width", "low", "high")  # columns of the convergence; without ends in older logs
BANDS = ("0.05", "0.50", "0.95", "mean", "at_mean_inputs")  # columns of a history that are drawn
# A shape is a function that is true of a value, the [shape] of the items of a list, or a mapping of keys to shapes, in
# which a function stands for all other keys. Keys that nothing reads are left out.
_INTERVAL = {"value": _number, "low": _known, "high": _known}
_QUANTITY = {
    "unit": _text,
    "method": _text,
    **dict.fromkeys(MOMENTS, _known),
    **{f"{name}_interval": _pair for name in MOMENTS},
    "quantiles": {_probability: _INTERVAL},
    "unsafe": [_text],
    "refused": {_text: _text},
    "densities": [{**_INTERVAL, "density": _known}],
    "modality": _modality,
    "sobol": Maybe({"refused": Maybe(_text), _text: {"first": _INTERVAL, "total": _INTERVAL}}),
    "runs": Maybe([{"input": _number, "value": _number}]),
    "interpolation_error": Maybe(_number),
    "error": Maybe(_error),
    "errors_by_source": Maybe({_text: _size}),
}
_SUMMARY = {
    **dict.fromkeys(("study", "scene", "sampler", "stopped_because"), _text),
    "samples": _whole,
    "seed": _number,
    "inputs": {_text: _text},
    "quantities": {_text: _QUANTITY},
    "failed": {_text: _whole},
    "doubts": {_text: _whole},
    "notes": [_text],
    "convergence": {
        "quantity": _text,
        "statistic": _text,
        "probability": Maybe(_number),
        "samples": [_whole],
        "estimate": [_measured],
        "half_width": [_measured],
        "low": Maybe([_known]),
        "high": Maybe([_known]),
    },
    "histories": {_text: {"realisations": _whole, "time_s": [_number], **dict.fromkeys(BANDS, Maybe([_number]))}},
    "companions": Maybe({"realisations": _whole, "failed": _whole, "where": _text, "errors_unknown": {_text: _text}}),
    "sweep": Maybe(
        {
            "key": _text,
            "unit": Maybe(_text),
            "at": Maybe(_known),
            "values": Maybe([_number]),
            "studies": [{"value": _number, "quantities": {_text: _QUANTITY}}],
        }
    ),
}


def check_summary(summary, study: Study, samples: int) -> None:
    """Raises ValueError, naming what is wrong, where a summary is not that of the study with so many samples."""
    wrong = next(_misfits(summary, _SUMMARY, "summary"), None) or next(_contradictions(summary, study, samples), None)
    if wrong:
        raise ValueError(f"{wrong} is not as a study gives it")


def _misfits(value, shape, where: str) -> Iterator[str]:
    """The places in a value that have not the shape."""
    if callable(shape):
        if not shape(value):
            yield where
    elif not isinstance(value, type(shape)):
        yield where
    elif isinstance(shape, list):
        for one in value:
            yield from _misfits(one, shape[0], where)
    else:
        named = {key: one for key, one in shape.items() if _text(key)}
        others = next((one for key, one in shape.items() if not _text(key)), None)
        yield from (where for key, one in named.items() if key not in value and not isinstance(one, Maybe))
        for key, one in value.items():
            of = named.get(key, others)
            yield from _misfits(one, getattr(of, "shape", of), f"{where}.{key}") if of else ()


def _contradictions(summary, study: Study, samples: int) -> Iterator[str]:
    """The places in a summary of the right shape that do not fit each other, or the study."""
    path, quantities = summary["convergence"], summary["quantities"]
    sweep = summary.get("sweep", {"key": None, "studies": []})
    for where, fits in (
        ("summary.samples", summary["samples"] == samples),
        ("summary.quantities", quantities.keys() == {*study.quantities}),
        ("summary.histories", summary["histories"].keys() == {*study.histories}),
        ("summary.failed", not summary["failed"] or samples > 0),
        ("summary.convergence", {len(path["samples"])} == {len(path[key]) for key in PATH if key in path}),
        ("summary.convergence", ("low" in path) == ("high" in path)),
        ("summary.convergence", path["quantity"] in quantities),
        ("summary.convergence", path["statistic"] != "quantile" or "probability" in path),
        ("summary.sweep", sweep["key"] == (study.sweep[0] if study.sweep and "sweep" in summary else None)),
    ):
        if not fits:
            yield where
    yield from ("summary.sweep" for one in sweep["studies"] if one["quantities"].keys() != quantities.keys())
    told = {"error", "errors_by_source"} if "companions" in summary else set()
    yield from ("summary.companions" for one in quantities.values() if not told <= one.keys())
    for name, one in summary["histories"].items():
        yield from (
            f"summary.histories.{name}" for key in BANDS if len(one.get(key, one["time_s"])) != len(one["time_s"])
        )
