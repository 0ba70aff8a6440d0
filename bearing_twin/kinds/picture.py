"""Pictures of runs: what a kind draws of its bodies, beside the curves that its view has in the browser."""

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from bearing_twin import __version__
from bearing_twin.base.sample import Block, Thinned
from bearing_twin.base.units import prefixed, with_unit
from bearing_twin.kinds.views import CurvePanel, View, plain_view
from bearing_twin.pictures import (
    BALL_COLOURS,
    GREATEST_LINES,
    SIZE,
    ball_line,
    finish,
    frame,
    heading,
    key_above,
    marker_of,
    scaled,
)

GREATEST_ROWS = 100_000  # outputs kept; of longer runs every second, fourth ... is
MOST_PANELS, ROWS = 16, 5  # panels of curves; in one column
BODIES, ROW = 2.2, 2.1  # height of bodies above the curves in rows; of a row in inches
ABOVE, BELOW = 1.2, 0.9  # inches above and below all panels
POINT = 0.01  # of what is shown of time: a shorter contact is a point
MISSED = 10  # outputs in a contact: fewer may pass its peak by
LABEL = "peak of a contact"
LOAD = "normal_load"  # the channel whose peaks between outputs are marked


class ChannelValues(Thinned):
    """The channels of a run, thinned; `greatest` is what was seen of each that is one number."""

    def __init__(self):
        super().__init__(GREATEST_ROWS, lambda sample: {name: np.array(one) for name, one in sample.values.items()})
        self.greatest: dict[str, float] = {}

    def add(self, block: Block) -> None:
        super().add(block)
        for name, values in block.values.items():
            if values.ndim == 1:
                self.greatest[name] = max(self.greatest.get(name, -np.inf), float(values.max(initial=-np.inf)))

    def arrays(self) -> dict[str, np.ndarray]:
        """Time [s] as "time", and every channel by name, of the outputs kept; raises LogError without a sample."""
        return {"time": self.time, **self.values}


class RunPicture:
    """The picture of a run of any kind but a bearing: the curves of its view.

    A subclass names that `view`, and fills the place beside or above it by `draw_bodies`. `peaks` is the table of the
    records of its contacts, and the columns of their begin, end and greatest load, if there are any.
    """

    view: ClassVar[Callable[..., View]] = staticmethod(plain_view)
    peaks: ClassVar[tuple] = ()
    draw_bodies: Callable[[Figure, SubplotSpec, dict[str, np.ndarray]], None] | None = None

    def __init__(self, facts):
        self.facts, self._values, self._channels = facts, ChannelValues(), ()
        self._contacts = [np.empty((0, 3))]

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._channels = block.channels
        self._values.add(block)
        if self.peaks:
            table, *wanted = self.peaks
            names = [column.name for column in table.columns]
            if len(rows := block.records.get(table.name, ())):
                self._contacts.append(rows[:, [names.index(name) for name in wanted]])

    def write(self, path, errors=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        values, scene = self._values.arrays(), self.facts.scene
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        panels = self.view(self.facts, self._channels).panels[:MOST_PANELS]
        beside = self.draw_bodies is not None and len(panels) <= ROWS
        columns = 1 if beside else 2
        rows = max(1, -(-len(panels) // columns))
        shares = (1.0, 1.0) if beside else (BODIES if self.draw_bodies else 0.01, rows)
        if not beside:
            figure.set_size_inches(SIZE[0], ABOVE + BELOW + ROW * sum(shares))
        parts = figure.add_gridspec(1, 2, wspace=0.14) if beside else figure.add_gridspec(2, 1, height_ratios=shares)
        tall = figure.get_figheight()
        parts.update(left=0.06, right=0.98, top=1.0 - ABOVE / tall, bottom=BELOW / tall)
        axes = parts[1].subgridspec(rows, columns, hspace=0.8, wspace=0.14).subplots(sharex=True, squeeze=False)
        factor, unit = prefixed(float(values["time"][-1]), "s")
        for axis in axes.ravel()[len(panels) :]:
            axis.set_axis_off()
        for axis, panel in zip(axes.ravel(), panels, strict=False):
            self._draw_curves(axis, panel, factor * values["time"], values, factor)
        for axis in axes[-1]:
            axis.set_xlabel(f"time [{unit}]")
        if self.draw_bodies:
            self.draw_bodies(figure, parts[0], values)
        title = scene.description or scene.name if scene is not None else "Recorded run"
        return finish(figure, title[:1].upper() + title[1:], self._footer(), path, size=17, errors=errors)

    def _draw_curves(self, axis, panel: CurvePanel, time, values, seconds: float) -> None:
        """One panel of the view over `time`, which is `seconds` times that in s."""
        frame(axis)
        curves = {one: values[one.series].reshape(len(time), -1)[:, one.column] for one in panel.lines}
        begin, end, peak = np.concatenate(self._contacts if panel.lines[0].series == LOAD else self._contacts[:1]).T
        factor, unit = scaled(np.concatenate([*curves.values(), peak]), panel.unit)
        many, words = len(curves) > 1, panel.title
        if panel.stacked:
            parts = [factor * (one - min(one.min(), 0.0)) for one in curves.values()]  # of height the zero is anywhere
            labels = [one.label for one in curves]
            axis.stackplot(time, parts, labels=labels, colors=BALL_COLOURS, alpha=0.78, linewidth=0)
        else:
            for one, curve in curves.items():
                look = {"linewidth": 1.6, "marker": marker_of(len(time)), **ball_line(one.colour)}
                axis.plot(time, factor * curve, label=one.label if many else None, **look)
        if self.peaks and panel.lines[0].series == LOAD:
            greatest = max(self._values.greatest[LOAD], float(peak.max(initial=0.0)))
            words = f"{words}, peak {factor * greatest:.5g} {unit}"
            outputs = [np.searchsorted(values["time"], one, side) for one, side in ((begin, "left"), (end, "right"))]
            unseen = np.diff(outputs, axis=0)[0] < MISSED
            _draw_peaks(axis, time, seconds * begin[unseen], seconds * end[unseen], factor * peak[unseen])
        axis.margins(x=0.0)
        heading(axis, words[:90], up=with_unit(unit).strip())
        if len(curves) <= GREATEST_LINES:
            key_above(axis)

    def _footer(self) -> str:
        facts, values = self.facts, self._values
        thinned = f", one in {values.stride} drawn" if values.stride > 1 else ""
        words = [f"{values.outputs} output{'s' * (values.outputs != 1)}{thinned}"]
        words += [f"{name}: {text}" for name, text in (("law", facts.law), ("stepper", facts.stepper)) if text]
        if facts.scene is not None:
            words.insert(0, facts.scene.name)
        return f"{', '.join(words)}; bearing_twin {__version__}"


def _draw_peaks(axis, time, begin: np.ndarray, end: np.ndarray, peak: np.ndarray) -> None:
    """A point for each contact, or a line as long as it: when in a contact its peak is, no record says."""
    short = end - begin < POINT * (time[-1] - time[0])
    look = {"color": BALL_COLOURS[5]}
    if short.any():
        axis.plot(0.5 * (begin + end)[short], peak[short], "o", markersize=4, label=LABEL, **look)
    if not short.all():
        label = None if short.any() else LABEL  # one entry in the legend
        axis.hlines(peak[~short], begin[~short], end[~short], label=label, **look)
