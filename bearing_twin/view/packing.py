"""Arrays as text in a page: whole numbers of two bytes between the least and the greatest value, compressed.

A column is kept as differences from one output to the next, low bytes apart from high ones: what moves evenly then
takes little room. `data.js` reads this back.
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.base.units import PREFIXES, UNITS

STEPS = 65534  # between the least and the greatest value; 65535 stands for no number
MISSING = 65535
SHARED_RANGE = 64  # columns: wider series have one range for all


def packed(time: np.ndarray, values: Mapping[str, np.ndarray], series: Sequence[Channel]) -> dict[str, Any]:
    """Times [s] (frames,) and series (frames, width) as plain data: what each is, and all numbers as one text."""
    blocks, described = [np.ascontiguousarray(time, "<f8").tobytes()], []
    for channel in series:
        array = np.asarray(values[channel.name], float)
        low, high = _range(array)
        blocks.append(_coded(array, low, high))
        described.append(described_series(channel) | {"low": low.tolist(), "high": high.tolist()})
    content = zlib.compress(b"".join(blocks), 6)
    return {"frames": len(time), "series": described, "data": base64.b64encode(content).decode("ascii")}


def described_series(channel: Channel) -> dict[str, Any]:
    """What a page must know of a series: name, unit, prefixes it may take, shape, meaning."""
    return {
        "name": channel.name,
        "unit": "" if channel.unit == "1" else UNITS[channel.unit].shown if channel.unit in UNITS else channel.unit,
        "prefixes": prefixes(channel.unit),
        "shape": list(channel.shape),
        "meaning": channel.meaning,
    }


def prefixes(unit: str) -> list[tuple[str, float]]:
    """(prefix, factor) that values in this unit may take, the greatest first."""
    known = UNITS.get(unit) or UNITS.get(unit.partition("/")[0])
    return [(prefix, scale) for prefix, scale in PREFIXES.items() if not prefix or (known and prefix in known.prefixes)]


def _range(array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest finite value of each column, or (1,) of all of them together."""
    finite = np.where(np.isfinite(array), array, np.nan)
    if array.shape[1] > SHARED_RANGE:
        finite = finite.reshape(-1, 1)
    empty = np.isnan(finite).all(axis=0)
    finite = np.where(empty, 0.0, finite)
    return np.nanmin(finite, axis=0), np.nanmax(finite, axis=0)


def _coded(array: np.ndarray, low: np.ndarray, high: np.ndarray) -> bytes:
    span = np.where(high > low, high - low, 1.0)
    scaled = np.rint((array - low) / span * STEPS)
    whole = np.where(np.isfinite(scaled), scaled, MISSING).astype(np.uint16).T
    steps = np.diff(whole, axis=1, prepend=np.zeros((len(whole), 1), np.uint16))
    return np.ascontiguousarray(steps.astype("<u2")).view(np.uint8).reshape(-1, 2).T.tobytes()
