"""Panels in the picture of a study: shares of the variance of a quantity, and the quantity over a sweep."""

import numpy as np

from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading
from bearing_twin.units import labelled
from bearing_twin.uq.swept import SweepInWords

ORDERS = {"first": "alone", "total": "with others"}  # of Sobol's indices, in words
WIDE = 20.0  # the greatest of what is drawn over a sweep, over the least, from which on its axis is logarithmic


def shares_of(quantity) -> dict[str, dict]:
    """Sobol's indices of a quantity by key: `first` and `total` with value, low and high; empty without any."""
    return {key: one for key, one in quantity.get("sobol", {}).items() if key != "refused"}


def draw_shares(axis, name, shares):
    """Sobol's indices as bars with their intervals, the greatest on top."""
    keys = sorted(shares, key=lambda key: shares[key]["total"]["value"])
    frame(axis)
    for place, (order, words) in enumerate(ORDERS.items()):
        values = np.array([shares[key][order]["value"] for key in keys])
        height, at = 0.28, np.arange(len(keys)) + (0.14 if place == 0 else -0.16)
        axis.barh(at, 100.0 * values, height, color=BALL_COLOURS[place], label=words)
        ends = [[shares[key][order][end] for key in keys] for end in ("low", "high")]
        lengths = [
            [100.0 * abs(end - value) if end is not None else 0.0 for end, value in zip(row, values, strict=True)]
            for row in ends
        ]
        axis.errorbar(100.0 * values, at, xerr=lengths, fmt="none", ecolor=STYLE["ink"], elinewidth=1.3, capsize=2.5)
    for at, key in enumerate(keys):
        axis.text(0.6, at + 0.3, key, fontsize=10.5, color=STYLE["ink"], va="bottom")
    axis.set_yticks([])
    axis.set_ylim(-0.5, len(keys) - 0.3)
    axis.set_xlim(0.0, max(100.0, axis.get_xlim()[1]))
    heading(axis, f"{name.replace('_', ' ').capitalize()}: shares of its variance", "share of the variance [%]")


def draw_sweep(axis, sweep, name, shown):
    """Mean, median and the 5 and 95 % quantiles over what is swept, and where the other panels are."""
    words, (unit, factor) = SweepInWords(sweep), shown
    found = [one["quantities"][name] for one in sweep["studies"]]
    curves = {p: [one["quantiles"].get(p, {}).get("value", np.nan) for one in found] for p in ("0.05", "0.50", "0.95")}
    curves["mean"] = [np.nan if one["mean"] is None else one["mean"] for one in found]
    curves = {key: factor * np.array(curve, float) for key, curve in curves.items()}
    frame(axis)
    _spread(axis, "x", np.array(words.values))
    _spread(axis, "y", np.array([*curves.values()]))
    axis.fill_between(
        words.values, curves["0.05"], curves["0.95"], color=BALL_COLOURS[0], alpha=0.2, linewidth=0, label="5 to 95 %"
    )
    look = {"linewidth": 2, "marker": "o", "markersize": 3.5}
    axis.plot(words.values, curves["0.50"], color=BALL_COLOURS[0], label="median", **look)
    axis.plot(words.values, curves["mean"], color=BALL_COLOURS[5], label="mean", **look)
    if words.place is not None:
        axis.axvline(words.place, color=STYLE["ink"], linewidth=1.2, linestyle=":", label="the other panels")
    plain = name.replace("_", " ")
    heading(axis, f"{plain.capitalize()} over the sweep", words.label, labelled(plain, unit))


def _spread(axis, along, numbers):
    """A logarithmic axis where what is drawn along it spans more than a factor WIDE, with its numbers written out."""
    known = numbers[np.isfinite(numbers)]
    if not len(known) or known.min() <= 0.0 or known.max() < WIDE * known.min():
        return
    axis.set(**{f"{along}scale": "log"})
    one = getattr(axis, f"{along}axis")
    one.set_major_formatter("{x:g}")
    one.set_tick_params(which="minor", length=0, labelbottom=False, labelleft=False)
