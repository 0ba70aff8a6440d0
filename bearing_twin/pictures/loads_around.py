"""Loads of the balls around a bearing."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from bearing_twin.pictures.style import RACEWAY_COLOURS, RACEWAYS, STYLE

NUMBERS = 0.25 * np.pi  # azimuth [rad] near which the numbers of the circles stand, where nothing pushes


def draw_loads_around(axis, azimuth, loads, push) -> None:
    """Bars of `loads` (N, 2) [N] on both raceways at `azimuth` (N,) [rad], an arrow along `push` (2,) [N] on the ring.

    `axis` is polar, 0 is +x. A push below a thousandth of the greatest load has no arrow.
    """
    width, greatest = 2.0 * np.pi / len(azimuth), float(loads.max()) or 1.0
    for race, (name, colour, shift) in enumerate(zip(RACEWAYS, RACEWAY_COLOURS, (-0.18, 0.18), strict=True)):
        axis.bar(azimuth + shift * width, loads[:, race], 0.34 * width, color=colour, label=f"{name} raceway")
    axis.set_ylim(0.0, 1.12 * greatest)
    aside, numbers = {"facecolor": STYLE["panel"], "edgecolor": "none", "alpha": 0.85, "pad": 0.6}, NUMBERS
    if np.linalg.norm(push) > 1e-3 * greatest:
        direction = np.arctan2(push[1], push[0])
        look = {"arrowstyle": "-|>", "lw": 2.5, "color": STYLE["ink"], "mutation_scale": 19}
        axis.annotate("", (direction, 0.7 * greatest), (direction, 0.0), arrowprops=look, zorder=5)
        words = {"ha": "center", "va": "center", "fontsize": 11, "color": STYLE["ink"], "bbox": aside, "zorder": 6}
        axis.text(direction, 0.78 * greatest, "load", **words)
        numbers = direction + np.pi
    axis.set_facecolor(STYLE["panel"])
    axis.grid(True, color="white", linewidth=1.2)
    axis.spines["polar"].set_color(STYLE["edge"])
    axis.tick_params(labelsize=10.5, labelcolor=STYLE["ink"])
    axis.yaxis.set_major_locator(MaxNLocator(4, prune="lower"))
    gaps = azimuth + 0.5 * width  # where no bar hides the numbers
    axis.set_rlabel_position(np.degrees(gaps[np.cos(gaps - numbers).argmax()]))
    for label in axis.get_yticklabels():
        label.set(ha="center", bbox=aside)
