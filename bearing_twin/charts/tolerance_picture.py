"""The picture of what a tolerance is worth: error got over tolerance asked, and what runs say of it."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.charts.bearing_variants import CASES
from bearing_twin.charts.companion_cost import LENGTHS, companion_shares
from bearing_twin.charts.table import DONE
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, save_chart
from bearing_twin.run.doubt import MUCH

NEAR, FAR = 3.0, 10.0  # factors between estimate and true error


def _look(number: int, case: str, alone: bool = False) -> dict:
    if alone:
        return {"color": STYLE["ink"], "marker": "P"}
    if case not in CASES:
        return {"color": STYLE["soft"], "marker": "."}
    return {"color": BALL_COLOURS[number % len(BALL_COLOURS)], "marker": "os^Dv"[number // len(BALL_COLOURS)]}


def draw(points: list, path: Path) -> None:
    """Error got over tolerance asked, and estimates over true errors; open marks are doubtful runs.

    Below them is what the companion takes of the steps of these runs, and of those at length, which have no errors.
    """
    figure = Figure(figsize=(15, 13), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(8, 5))
    left, right = upper.subplots(1, 2)
    long, points = ([p for p in points if (p.method in LENGTHS) == one] for one in (True, False))
    _draw_companion(lower.subplots(), points, long)
    good, names = [p for p in points if p.status == DONE], list(dict.fromkeys(p.problem for p in points))
    for number, case in enumerate(names):
        look = _look(number, case)
        for p in (p for p in good if p.problem == case):
            alone = np.isnan(p.friction_error)
            mine = _look(number, case, alone)
            fill, size = "none" if p.doubtful else mine["color"], 0.5 if alone else 1.0
            shift = 1.0 + 0.03 * (min(number, len(CASES)) - 0.5 * len(CASES)) + 0.5 * alone  # side by side
            marked = {"mfc": fill, "mec": mine["color"]}
            left.plot(p.setting * shift, p.error, mine["marker"], **marked, ms=9 * size, mew=1.6 * size)
            right.plot(
                [true for _, true in p.pairs],
                p.ratios,
                mine["marker"],
                **marked,
                ms=8 * size,
                mew=1.4 * size,
                linestyle="none",
            )
        lost = [p.setting for p in points if p.problem == case and p.status != DONE]
        left.plot(lost, [1.0] * len(lost), "x", color=look["color"], ms=11, mew=2.5)
        label = case if case in CASES else "variants" if case == names[-1] else None
        left.plot([], [], look["marker"], mfc=look["color"], mec=look["color"], ms=9, linestyle="none", label=label)
    if any(np.isnan(p.friction_error) for p in good):
        left.plot([], [], "P", mfc=STYLE["ink"], mec=STYLE["ink"], ms=5, linestyle="none", label="loads alone wanted")
    heading(left, "error got (open: the run calls itself doubtful; crosses: stopped)")
    _finish(left, right, points)
    upper.legend(loc="outside right upper", fontsize=12, frameon=False)
    save_chart(figure, "A tolerance and what it is worth", path)


def _draw_companion(axis, short: list, long: list) -> None:
    """What the companion takes of the steps of runs, over these steps."""
    kinds = (
        ("shortened, beside a truth", STYLE["soft"], "o", 5, short),
        ("as users make them: as shipped, or of 1 s", BALL_COLOURS[0], ".", 5, long),
    )
    for name, colour, mark, size, runs in kinds:
        steps, shares = companion_shares(runs)
        if len(shares):
            label = f"{name}: {np.median(shares):.3g} % as a median of {len(shares)}"
            axis.plot(steps, shares, mark, color=colour, ms=size, label=label)
    axis.axhline(100.0 * MUCH, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.set(xscale="log", yscale="log")
    heading(axis, f"what the companion takes (above the dotted {100.0 * MUCH:g} % a run says what took it)")
    axis.set(xlabel="steps of balls in the run", ylabel="share of these steps [%]")
    frame(axis)
    axis.legend(loc="lower left", fontsize=12, frameon=False)


def draw_all(points: list, path: Path, title: str) -> None:
    """As `draw`, of problems whose names would be too many; those that miss and do not say so stand out."""
    figure = Figure(figsize=(14, 7.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    good = [p for p in points if p.status == DONE]
    calm = [p for p in good if not p.missed and not p.doubtful]
    kinds = (
        ("done", STYLE["edge"], "o", [p for p in calm if p.kept]),
        ("done, reference further off", STYLE["ink"], "+", [p for p in calm if not p.kept]),
        ("doubtful", BALL_COLOURS[0], "x", [p for p in good if p.doubtful]),
        ("missed, not said", BALL_COLOURS[5], "D", [p for p in good if p.missed and not p.doubtful]),
    )
    for number, (label, colour, mark, mine) in enumerate(kinds):
        look = {"marker": mark, "linestyle": "none", "color": colour, "ms": 6}
        scatter = 1.0 + 0.5 * np.linspace(-0.5, 0.5, max(len(mine), 1)) + 0.1 * number  # side by side
        left.plot([p.setting * one for p, one in zip(mine, scatter, strict=False)], [p.error for p in mine], **look)
        right.plot([true for p in mine for _, true in p.pairs], [one for p in mine for one in p.ratios], **look)
        left.plot([], [], **look, label=f"{label}: {len(mine)}")
    heading(left, "error got")
    _finish(left, right, points)
    figure.legend(loc="outside right upper", fontsize=11, frameon=False, handletextpad=0.1)
    save_chart(figure, title, path)


def _finish(left, right, points: list) -> None:
    """Lines and scales of both panels."""
    ends = np.array([min(p.setting for p in points), max(p.setting for p in points)])
    left.plot(ends, ends, color=STYLE["ink"], linewidth=1.5)
    middle = float(np.sqrt(ends.prod()))
    left.text(0.8 * middle, 1.5 * middle, "as asked", ha="right", fontsize=13, color=STYLE["ink"])
    for factor in (1.0 / FAR, 1.0 / NEAR, 1.0, NEAR, FAR):
        right.axhline(
            factor, color=STYLE["ink"], linewidth=1.5 if factor == 1.0 else 1.0, linestyle="-" if factor == 1.0 else ":"
        )
    left.set(
        xscale="log", yscale="log", xlabel="tolerance asked for", ylabel="true error of load or friction, the greater"
    )
    right.set(xscale="log", yscale="log", xlabel="true error", ylabel="what the run says of it / true error")
    heading(right, f"estimates (dotted: factors {NEAR:g} and {FAR:g})")
    for axis in (left, right):
        frame(axis)
