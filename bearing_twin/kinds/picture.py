"""Pictures of runs: a drawing of the bodies beside the curves of the view in the browser."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Sample, ThinnedOutputs
from bearing_twin.base.units import prefixed_unit, readable_unit, with_unit
from bearing_twin.kinds.views import CurvePanel, View, plain_view
from bearing_twin.pictures import (
    BALL_COLOURS,
    GREATEST_LINES,
    LOAD_MAP,
    SIZE,
    TITLE_SIZE,
    ball_style,
    draw_errors,
    finish_picture,
    fitted,
    heading,
    legend_above,
    marker_of,
    style_axes,
)

GREATEST_ROWS = 20_000  # outputs kept; of longer runs every second, fourth ... is
MAX_PANELS, ROWS = 16, 5  # panels of curves; in one column
ERROR_ROW = 0.26  # inches: of a figure's error
BODIES, ROW = 2.2, 2.1  # height of bodies above the curves in rows; of a row in inches
ABOVE, BELOW = 1.2, 0.9  # inches above and below all panels
LEAST_SPAN = 1e-5  # of a panel over its greatest value: smaller changes are below what is computed
POINT = 0.01  # of what is shown of time: a shorter contact is a point
MISSED = 10  # outputs in a contact: fewer may pass its peak by
LABEL = "peak of a contact"
LOAD = "normal_load"  # the channel whose greatest value is named, and whose peaks between outputs are marked


class RunPicture:
    """The picture of a run of any kind: the curves of its view, of channels alone.

    A subclass names that `view`, and fills the place beside or above it by `draw_bodies`. Of the channels those named
    in `kept` are kept and drawn, or all; curves of those in `named` have their names in the drawing of the bodies.
    `peaks` is the table of the records of its contacts, and the columns of their begin, end and greatest load, if there
    are any.
    """

    view: ClassVar[Callable[..., View]] = staticmethod(plain_view)
    peaks: ClassVar[tuple] = ()
    kept: tuple[str, ...] = ()
    named: ClassVar[tuple[str, ...]] = ()
    draw_bodies: Callable[[Figure, SubplotSpec, dict[str, np.ndarray]], None] | None = None

    def __init__(self, scene, choice: Choice):
        self.scene, self.choice, self.first, self.last = scene, choice, None, None
        self.parameters = scene and scene.parameters
        self._greatest: np.ndarray | float = -np.inf  # loads, by their column
        self._contacts = [np.empty((0, 3))]
        self._outputs = ThinnedOutputs(GREATEST_ROWS, self._kept_of)

    def add(self, block: Block) -> None:
        """Add a block."""
        if not len(block):
            return
        self.first, self.last = self.first or block[0], block[-1]
        self._channels = block.channels
        self._outputs.add(block)
        if LOAD in block.values:
            self._greatest = np.maximum(self._greatest, block.values[LOAD].reshape(len(block), -1).max(axis=0))
        if self.peaks:
            table, *columns = self.peaks
            names = [column.name for column in table.columns]
            if len(rows := block.records.get(table.name, ())):
                self._contacts.append(rows[:, [names.index(name) for name in columns]])

    def _kept_of(self, sample: Sample) -> dict[str, np.ndarray]:
        kept = self.kept or sample.values
        return {name: np.array(values) for name, values in sample.values.items() if name in kept}

    def begin(self, time: np.ndarray) -> float:
        """The time [s] from which on the run is drawn."""
        return time[0]

    def title(self) -> str:
        """The words above the picture."""
        title = self.scene.description or self.scene.name if self.scene else "Recorded run"
        return title[:1].upper() + title[1:]

    def write(self, path, errors: Sequence[tuple[str, Mapping[str, float]]] = ()) -> Path:
        """Draw the outputs and, below them, `errors` by `draw_errors`.

        Raises BearingTwinError without outputs, or where the file cannot be written.
        """
        outputs = self._outputs
        drawn = slice(int(np.searchsorted(outputs.time, self.begin(outputs.time))), None)
        values = {name: array[drawn] for name, array in {"time": outputs.time, **outputs.values}.items()}
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        panels = self._panels(values)
        is_beside = self.draw_bodies is not None and len(panels) <= ROWS
        columns = 1 if is_beside else 2
        rows = max(1, -(-len(panels) // columns))
        ratios = (1.0, 1.0) if is_beside else (BODIES if self.draw_bodies else 0.01, rows)
        margin = BELOW + (ERROR_ROW * len(errors) + ABOVE if errors else 0.0)
        figure.set_size_inches(SIZE[0], margin + (SIZE[1] - BELOW if is_beside else ABOVE + ROW * sum(ratios)))
        parts = figure.add_gridspec(1, 2, wspace=0.14) if is_beside else figure.add_gridspec(2, 1, height_ratios=ratios)
        height = figure.get_figheight()
        has_maps = any(len(panel.lines) > GREATEST_LINES for panel in panels)  # whose scales stand right of them
        parts.update(left=0.06, right=0.92 if has_maps else 0.98, top=1.0 - ABOVE / height, bottom=margin / height)
        spacing = {"hspace": min(0.16 * rows, 0.8), "wspace": 0.3 if has_maps else 0.14}
        axes = parts[1].subgridspec(rows, columns, **spacing).subplots(sharex=True, squeeze=False)
        factor, unit = prefixed_unit(float(values["time"][-1]), "s")
        for axis in axes.ravel()[len(panels) :]:
            axis.set_axis_off()
        for axis, panel in zip(axes.ravel(), panels, strict=False):
            self._draw_curves(axis, panel, factor * values["time"], values, factor)
        for axis in axes.ravel()[: len(panels)][-columns:]:  # the last of each column
            axis.tick_params(labelbottom=True)
            axis.set_xlabel(f"time [{unit}]")
        if self.draw_bodies:
            self.draw_bodies(figure, parts[0], values)
        if errors:
            draw_errors(figure.add_axes((0.38, BELOW / height, 0.58, ERROR_ROW * len(errors) / height)), errors)
        return finish_picture(figure, self.title(), self._footer(values["time"]), path, size=17)

    def _panels(self, values) -> list[CurvePanel]:
        """The panels of the view with those of their curves that are kept."""
        panels = self.view(self.parameters, self._channels).panels
        drawn = []
        for panel in panels:
            lines = tuple(line for line in panel.lines if line.series in values)
            suffix = f": {lines[0].label}" if len(lines) == 1 < len(panel.lines) else ""
            drawn += [panel._replace(title=panel.title + suffix, lines=lines)] if lines else []
        return drawn[:MAX_PANELS]

    def _draw_curves(self, axis, panel: CurvePanel, time, values, seconds: float) -> None:
        """One panel of the view over `time`, which is `seconds` times that in s."""
        style_axes(axis)
        curves = np.stack([values[curve.series].reshape(len(time), -1)[:, curve.column] for curve in panel.lines])
        loads, labels = panel.lines[0].series == LOAD, [curve.label for curve in panel.lines]
        begin, end, peak = np.concatenate(self._contacts if loads else self._contacts[:1]).T
        size = float(np.nanmax(np.abs(np.concatenate([curves.ravel(), peak]))))
        unit, factor = readable_unit(panel.unit, size)
        title, up, is_map = panel.title, with_unit(unit).strip(), len(curves) > GREATEST_LINES
        if is_map:
            _draw_map(axis, time, factor * curves, up)
        elif panel.stacked:
            parts = factor * (curves - np.minimum(curves.min(axis=1, keepdims=True), 0.0))  # zero height is anywhere
            axis.stackplot(time, parts, labels=labels, colors=BALL_COLOURS, alpha=0.78, linewidth=0)
        else:
            for curve, values_drawn in zip(panel.lines, factor * curves, strict=True):
                line_style = {"linewidth": 1.6, "marker": marker_of(len(time)), **ball_style(curve.colour)}
                axis.plot(time, values_drawn, label=curve.label if len(curves) > 1 else None, **line_style)
            axis.ticklabel_format(useOffset=False)
        if loads:
            greatest = self._greatest[[curve.column for curve in panel.lines]].max()
            title = f"{title}, peak {factor * max(greatest, peak.max(initial=0.0)):.4g} {unit}"
            first, last = np.searchsorted(values["time"], begin), np.searchsorted(values["time"], end, "right")
            unseen = last - first < MISSED
            _draw_peaks(axis, time, seconds * begin[unseen], seconds * end[unseen], factor * peak[unseen])
        if not is_map:
            _widen(axis, LEAST_SPAN * factor * size)
        axis.margins(x=0.0)
        title = fitted(title, axis.get_position().width * axis.figure.get_figwidth(), TITLE_SIZE)
        heading(axis, title, up=labels[0].rstrip("0123456789, ") or "number" if is_map else up)
        if not is_map and panel.lines[0].series not in self.named:
            legend_above(axis)

    def _footer(self, time: np.ndarray) -> str:
        choice, outputs = self.choice, self._outputs
        thinned = f", one in {outputs.stride} drawn" if outputs.stride > 1 else ""
        parts = [f"{outputs.outputs} output{'s' * (outputs.outputs != 1)}{thinned}"]
        if time[0] > outputs.time[0]:
            parts.append(f"the last {time[-1] - time[0]:.3g} s of {time[-1]:.4g} s")
        parts += [f"{name}: {text}" for name, text in (("law", choice.law), ("stepper", choice.stepper)) if text]
        if self.scene:
            parts.insert(0, self.scene.name)
        return ", ".join(parts)


def _widen(axis, least: float) -> None:
    """Widens the values that an axis shows to a `least` span; nothing but zeros stands at its foot."""
    low, high = axis.get_ylim()
    if not least:
        axis.set_ylim(0.0, 1.0)
    elif high - low < least:
        axis.set_ylim(0.5 * (low + high - least), 0.5 * (low + high + least))


def _draw_map(axis, time, curves, unit: str) -> None:
    """Many curves as a map: their numbers upwards, their values as colours."""
    axis.grid(False)
    limits = {} if curves.any() else {"vmin": 0.0, "vmax": 1.0}
    style = {"cmap": LOAD_MAP, "shading": "nearest", "rasterized": True}
    image = axis.pcolormesh(time, np.arange(len(curves)), curves, **style, **limits)
    axis.yaxis.get_major_locator().set_params(integer=True)
    axis.figure.colorbar(image, cax=axis.inset_axes((1.015, 0.0, 0.015, 1.0)), label=unit)


def _draw_peaks(axis, time, begin: np.ndarray, end: np.ndarray, peak: np.ndarray) -> None:
    """A point for each contact, or a line over its duration, as records do not hold the time of the peak."""
    short = end - begin < POINT * (time[-1] - time[0])
    peak_style = {"color": BALL_COLOURS[5]}
    if short.any():
        axis.plot(0.5 * (begin + end)[short], peak[short], "o", markersize=4, label=LABEL, **peak_style)
    if not short.all():
        label = None if short.any() else LABEL  # one entry in the legend
        axis.hlines(peak[~short], begin[~short], end[~short], label=label, **peak_style)
