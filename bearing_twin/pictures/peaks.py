"""Peaks of contacts that lie between the outputs of a run, drawn from what was recorded of each."""

import numpy as np

from bearing_twin.pictures.style import BALL_COLOURS

POINT = 0.01  # of what is shown of time: a shorter contact is a point
LABEL = "peak of a contact"


def draw_peaks(axis, span: float, begin: np.ndarray, end: np.ndarray, peak: np.ndarray) -> None:
    """A point for each contact, or a line as long as it: when in a contact its peak is, no record says.

    `span` is what is shown of time; it, `begin`, `end` and `peak` are in the units of the axis.
    """
    short = end - begin < POINT * span
    look = {"color": BALL_COLOURS[5]}
    if short.any():
        axis.plot(0.5 * (begin + end)[short], peak[short], "o", markersize=4, label=LABEL, **look)
    if not short.all():
        label = None if short.any() else LABEL  # one entry in the legend
        axis.hlines(peak[~short], begin[~short], end[~short], label=label, **look)
