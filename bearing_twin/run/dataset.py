"""A run or a log as a data set of xarray: named axes, units, and what computed it."""

import json
from typing import NamedTuple

import numpy as np

import bearing_twin
from bearing_twin.base.errors import import_optional
from bearing_twin.base.sample import Channel
from bearing_twin.kinds import KINDS

LABELS = {
    "axis": ("x", "y", "z"),
    "quaternion": ("x", "y", "z", "w"),
    "about": ("x", "y"),
    "in_plane": ("x", "y"),
}
"""Labels along an axis of this name; along others stand whole numbers from 0."""


class ChannelAxis(NamedTuple):
    """An axis of a channel: its name, and a label for each place along it."""

    name: str
    labels: tuple[str | int, ...]


def axes_of(channel: Channel, kind: str | None) -> tuple[ChannelAxis, ...]:
    """The axes of a channel's shape: as the channel declares them, else by the bodies and contacts of the kind.

    An axis along which `Kind.place_of` names other bodies is called by their first word and labelled by number, one
    along which it names other contacts is `contact`. Of the rest one of length 3 is `axis`, one of length 4 a
    `quaternion`. Without a scene `kind` is None, and axes are called by their channel.
    """
    return tuple(_axis(channel, kind, dimension) for dimension in range(len(channel.shape)))


def _axis(channel: Channel, kind: str | None, dimension: int) -> ChannelAxis:
    size = channel.shape[dimension]
    if channel.axes:
        return _named_axis(channel.axes[dimension], size)
    if kind is None:
        return _named_axis(f"{channel.name}_{dimension}", size)
    bodies, contacts = zip(
        *(KINDS[kind].place_of(channel, _index(channel, dimension, k)) for k in range(size)), strict=True
    )
    if size > 1 and len(set(contacts)) == size:
        return ChannelAxis("contact", contacts)
    if bodies[0][-1:].isdigit() and len(set(bodies)) == size:
        return ChannelAxis(bodies[0].split()[0], tuple(range(size)))
    return _named_axis({3: "axis", 4: "quaternion"}.get(size, f"{channel.name}_{dimension}"), size)


def _index(channel: Channel, dimension: int, k: int) -> tuple[int, ...]:
    return tuple(k if other == dimension else 0 for other in range(len(channel.shape)))


def _named_axis(name: str, size: int) -> ChannelAxis:
    labels = LABELS.get(name, ())
    return ChannelAxis(name, labels if len(labels) == size else tuple(range(size)))


TIME = "time"


def dataset_of(stream, blocks=None):
    """All outputs of a run or a log, or its given `blocks`, as an `xarray.Dataset`, bit for bit.

    One variable a channel, (time, *axes), with `units` and `long_name`; coordinates `time` [s], `time_ns` (int64) and
    `sequence`, and labels along the axes. Tables of records are variables `<table>_<column>` over `<table>_record`.
    Attributes hold the scene as YAML, law and stepper, and the report. A run is computed by this, a log read, and all
    of it is held in memory. Raises BearingTwinError without xarray, and whatever the run or the log raises.
    """
    xarray = import_optional("xarray", "export")
    blocks = list(stream.blocks() if blocks is None else blocks)
    scene = stream.scene
    kind = None if scene is None else scene.kind
    times = np.concatenate([block.time_ns for block in blocks]) if blocks else np.zeros(0, np.int64)
    numbers = [np.arange(block.first_sequence, block.first_sequence + len(block)) for block in blocks]
    coordinates = {
        TIME: (TIME, 1e-9 * times, {"units": "s", "long_name": "simulation time"}),
        "time_ns": (TIME, times, {"units": "ns", "long_name": "simulation time, exact"}),
        "sequence": (TIME, np.concatenate(numbers) if numbers else times, {"long_name": "number of the output"}),
    }
    variables = {}
    for channel in stream.channels:
        axes = axes_of(channel, kind)
        coordinates |= {axis.name: (axis.name, np.array(axis.labels)) for axis in axes}
        values = np.concatenate([block.values[channel.name] for block in blocks])
        dimensions = (TIME, *(axis.name for axis in axes))
        variables[channel.name] = (dimensions, values, _attributes(channel))
    variables |= _records(blocks, scene)
    return xarray.Dataset(variables, coordinates, source_of(stream))


def _attributes(channel) -> dict[str, str]:
    """`units` and `long_name` of a channel."""
    return {"units": channel.unit, "long_name": channel.meaning}


def source_of(stream) -> dict[str, str]:
    """Origin of the numbers of a stream, as texts: scene, model, report, version."""
    choice, report = stream.choice, stream.report
    record = report if isinstance(report, dict) or report is None else report.record()
    known = {"law": choice.law, "stepper": choice.stepper, "choice_reason": choice.reason} if choice else {}
    return {
        "source": f"bearing_twin {bearing_twin.__version__}",
        "scene": "" if stream.scene is None else stream.scene.text,
        **known,
        "report": json.dumps(record, default=str),
    }


def _records(blocks, scene) -> dict:
    variables = {}
    for table in scene.tables if scene else ():
        rows = [block.records[table.name] for block in blocks if len(block.records.get(table.name, ()))]
        matrix = np.concatenate(rows) if rows else np.zeros((0, len(table.columns)))
        for index, column in enumerate(table.columns):
            variables[f"{table.name}_{column.name}"] = (f"{table.name}_record", matrix[:, index], _attributes(column))
    return variables
