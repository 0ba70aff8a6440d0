"""Marks in drawings of bodies: the axes, and ink that can be read."""

import matplotlib
import numpy as np
from matplotlib.patches import FancyArrowPatch

from bearing_twin.pictures.style import STYLE


def axes_mark(axis, left, reach):
    """Draws x and y at the lower left of a drawing that begins at `left` and reaches `reach` up and down."""
    origin = np.array([left + 0.08 * reach, -0.9 * reach])
    for direction, name in (((1.0, 0.0), "x"), ((0.0, 1.0), "y")):
        end = origin + 0.2 * reach * np.array(direction)
        axis.add_artist(FancyArrowPatch(origin, end, arrowstyle="-|>", mutation_scale=11, color=STYLE["soft"], lw=1.2))
        axis.text(
            *(origin + 0.26 * reach * np.array(direction)),
            name,
            ha="center",
            va="center",
            fontsize=11,
            color=STYLE["soft"],
        )


def readable_on(colour):
    """White or ink, whichever can be read on a colour."""
    red, green, blue = matplotlib.colors.to_rgb(colour)
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.6 else STYLE["ink"]
