"""Colours that stay apart for colour-blind eyes (Okabe and Ito), the same in every chart."""

STYLE = {"ink": "#22303c", "soft": "#71808c", "panel": "#eef1f4", "ring": "#cfd6dc", "edge": "#8a97a3"}

BALL_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000", "#B8A800")
GREATEST_LINES = 12  # more lines than this cannot be told apart: a map of ball against time takes their place

RACEWAYS = ("inner", "outer")
RACEWAY_COLOURS = ("#0072B2", "#D55E00")
LOAD_MAP = "cividis"


def ball_line(ball: int) -> dict:
    """Colour and dashes of a ball's line: colours come round again after eight balls, then dashed."""
    return {"color": BALL_COLOURS[ball % len(BALL_COLOURS)], "linestyle": "-" if ball < len(BALL_COLOURS) else "--"}


def heading(axis, text: str) -> None:
    """The title of a panel, above its left edge."""
    axis.set_title(text, loc="left", fontsize=13.5, color=STYLE["ink"])


def frame(axis) -> None:
    """A quiet panel: light ground, white grid, no border."""
    axis.set_facecolor(STYLE["panel"])
    axis.grid(True, color="white", linewidth=1.2)
    axis.set_axisbelow(True)
    for spine in axis.spines.values():
        spine.set_visible(False)
    axis.tick_params(length=0, labelsize=11, labelcolor=STYLE["ink"])
    axis.xaxis.label.set(size=12, color=STYLE["ink"])
    axis.yaxis.label.set(size=12, color=STYLE["ink"])
