"""Parts of a kind's view: numbers of every output, things to draw in space, and panels of curves.

A `View` is data: the page in the browser draws it and knows no kind. Names in the fields of solids and marks are those
of the view's series; SI units throughout, angles in radians, quaternions x, y, z, w.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, product
from typing import TYPE_CHECKING, Any, NamedTuple

from bearing_twin.base.sample import Channel

if TYPE_CHECKING:
    import numpy as np

    from bearing_twin.base.sample import Sample

STEEL, DARK, BRASS, GLASS = "steel", "dark", "brass", "glass"
BLUE, ORANGE, GREEN, RED = "blue", "orange", "green", "red"
"""Colours of things; the page gives each a shade that suits its ground."""

PALETTE = -1  # as a colour of many bodies: each has that of its curves
MOST_CURVES = 64  # of a panel
ARC = 12  # points of an arc


class Solid(NamedTuple):
    """`count` rigid bodies of one `shape`: a mapping from its sort to its numbers, such as {"ellipsoid": semi-axes}.

    A body stands at `position` + enlargement x `deviation` (both series (count, 3) or empty), is tilted by enlargement
    x `tilt` (2,), turned by `orientation` (count, 4) or about z by an angle whose cosine and sine are `turn` (2,).
    `marked` bodies show that they turn. `place` is the number of the first body in its series.
    """

    name: str
    words: str
    shape: Mapping[str, Any]
    colour: str = STEEL
    count: int = 1
    position: str = ""
    deviation: str = ""
    orientation: str = ""
    turn: str = ""
    tilt: str = ""
    marked: bool = False
    opacity: float = 1.0
    place: int = 0


class Arrows(NamedTuple):
    """Arrows along `vector` (..., 3), as long as `size` (...), or as the vector where that is empty.

    The longest of the run is drawn `longest` [m] long. Tips, or tails with `from_point`, stand at `point` (..., 3) or,
    with `on`, on the surface of that body of `radius` [m] against the vector.
    """

    name: str
    words: str
    unit: str
    vector: str
    longest: float
    colours: tuple[str, ...] = (GREEN,)
    size: str = ""
    point: str = ""
    on: str = ""
    radius: float = 0.0
    from_point: bool = False


class ContactEllipses(NamedTuple):
    """Contact ellipses across `normal` (..., 3), enlarged, coloured by `pressure`; `point`, `on` as of `Arrows`.

    The major axis is the series `major_axis`, or the direction `along` as seen in the plane of contact.
    """

    name: str
    words: str
    normal: str
    semi_major: str
    semi_minor: str
    pressure: str
    reach: float
    major_axis: str = ""
    along: tuple[float, float, float] = (0.0, 0.0, 1.0)
    point: str = ""
    on: str = ""
    radius: float = 0.0


class MovingMesh(NamedTuple):
    """A surface whose nodes move: `nodes` (n, 2) in the plane of the picture, `triangles`, `values` (n,) as colours.

    The colours go up to the greatest value of the series `scale`. `signs` gives the signs of x and y of each copy
    drawn, as for the other half of a symmetric body.
    """

    name: str
    words: str
    nodes: str
    triangles: Any
    edges: Any
    values: str
    scale: tuple[str, ...]
    signs: tuple[tuple[float, float], ...] = ((1.0, 1.0),)


class Bar(NamedTuple):
    """A straight bar along x from -length / 2, bent downward by enlargement x `deflection` (n,) at even stations."""

    name: str
    words: str
    deflection: str
    length: float
    width: float
    height: float
    colour: str = STEEL


class Trail(NamedTuple):
    """The way of a point, `position` (3,), over the whole run."""

    name: str
    words: str
    position: str
    colour: str = BLUE


class PanelCurve(NamedTuple):
    """One curve of a panel: a column of a series, its name, and the number of its colour; `body` is its place there."""

    series: str
    label: str
    column: int = 0
    colour: int = 0
    body: int = -1


class CurvePanel(NamedTuple):
    """Curves over time on one axis; pictures draw those that are `stacked` on top of each other."""

    title: str
    unit: str
    lines: tuple[PanelCurve, ...]
    stacked: bool = False


class Details(NamedTuple):
    """Details of the selected body of `solid`: for each contact ellipse, pressure, load and more.

    `rows` are (words, series) whose second axis is the contact.
    """

    solid: str
    noun: str
    contacts: tuple[str, ...]
    semi_major: str
    semi_minor: str
    pressure: str
    rows: tuple[tuple[str, str], ...]


class Look(NamedTuple):
    """Camera: `direction` from the middle, which way is up, and the radius [m] of the visible part.

    `around` names series of points (..., 3) that are all to be seen, with `radius` around them and `middle` amid them.
    `at_start` holds the middle (3,) and the radius [m] of the scene as it begins, in the frame of its topics, where
    these are others. `follows` names the body with which the eye of other programs goes, by its frame on /tf, where one
    travels along a plane: they do not know beforehand how far.
    """

    radius: float
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0)
    around: tuple[str, ...] = ()
    at_start: tuple = ()
    follows: str = ""

    @property
    def beginning(self) -> tuple[tuple[float, float, float], float]:
        """Middle (3,) and radius [m] of what is seen as the scene begins, in the frame of its topics."""
        return self.at_start or (self.middle, self.radius)


EYE = Look(1.0)


class Enlarged(NamedTuple):
    """Which displacements are enlarged: the greatest of the series, or `least` [m], is drawn `reach` [m] long."""

    words: str
    series: tuple[str, ...]
    reach: float
    least: float = 0.0


@dataclass(frozen=True)
class View:
    """The view of one scene: `rows` turns a sample of many outputs into the arrays (count, *shape) of `series`.

    `solids` and `marks` may be empty: then there is no picture in space. `period` [s] of the run pass in one second of
    looking; 0 = an eighth of it. `words` says what is drawn.
    """

    series: tuple[Channel, ...]
    rows: Callable[[Sample], Mapping[str, np.ndarray]]
    panels: tuple[CurvePanel, ...]
    solids: tuple[Solid, ...] = ()
    marks: tuple[NamedTuple, ...] = ()
    look: Look = EYE
    enlarged: Enlarged | None = None
    details: Details | None = None
    period: float = 0.0
    words: str = ""
    axes: bool = False


def view_of(channels, drawn=(), rows: Callable[[Sample], Mapping[str, np.ndarray]] | None = None, **parts) -> View:
    """A view with these `parts`, whose series are the channels that they name and those `drawn`, which `rows` makes."""
    named, made = set(_texts(tuple(parts.values()))), {channel.name for channel in drawn}
    used = tuple(channel for channel in channels if channel.name in named - made)
    return View(
        series=(*used, *drawn),
        rows=lambda sample: {channel.name: sample[channel.name] for channel in used} | (rows(sample) if rows else {}),
        **parts,
    )


def _texts(part) -> Iterator[str]:
    """All texts in a part of a view."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, tuple):
        for element in part:
            yield from _texts(element)


def lines_of(channel: Channel) -> tuple[PanelCurve, ...]:
    """Curves of all the numbers of a channel, the first MOST_CURVES of them."""
    if not channel.shape:
        return (PanelCurve(channel.name, channel.name.replace("_", " ")),)
    numbers = (map(str, range(count)) for count in channel.shape)
    labels = "xyzw"[: channel.width] if channel.shape in ((3,), (4,)) else map(", ".join, product(*numbers))
    return tuple(PanelCurve(channel.name, label, k, k) for k, label in enumerate(islice(labels, MOST_CURVES)))


def panel_of(channel: Channel) -> CurvePanel:
    """The panel of one channel."""
    name = channel.name.replace("_", " ").capitalize()
    return CurvePanel(f"{name}: {channel.meaning}" if channel.meaning else name, channel.unit, lines_of(channel))


def curves(title: str, unit: str, *rows: tuple) -> CurvePanel:
    """A panel of rows (series, words) or (series, words, column), each with the next colour."""
    lines = tuple(PanelCurve(row[0], row[1], row[2] if len(row) > 2 else 0, index) for index, row in enumerate(rows))
    return CurvePanel(title, unit, lines)


def energies(*rows: tuple) -> CurvePanel:
    """The panel of energies with their sum."""
    return curves("Energy", "J", *rows)._replace(stacked=True)


def along_axes(series: str, first: int = 0) -> tuple[tuple, ...]:
    """Rows of `curves` for a vector along x, y and z, whose numbers are the columns of a series from `first` on."""
    return tuple((series, axis, first + k) for k, axis in enumerate("xyz"))


def ball_curves(title: str, unit: str, series: str, balls: int, raceway: int) -> CurvePanel:
    """A panel of a series (balls, 2) on raceway 0 (inner) or 1 (outer): one curve a ball, of the first MOST_CURVES."""
    return CurvePanel(
        title,
        unit,
        tuple(PanelCurve(series, f"ball {k}", 2 * k + raceway, k, k) for k in range(min(balls, MOST_CURVES))),
    )


def grooved_ring(bottom: float, groove: float, steepest: float, back: float, face: float) -> list[list[tuple]]:
    """The section (radius, z) below z = 0 of a ring as strokes; a stroke is smooth, between strokes are edges.

    The arc of its groove has its bottom at the radius `bottom`, is curved by the radius `groove`, which is negative
    outside a ring, and ends where it is as steep as `steepest` [rad]; the ring has its `back` and its `face` there.
    """
    angles = [steepest * k / (ARC - 1) for k in range(ARC)]
    arc = [(bottom - groove * (1.0 - math.cos(angle)), -abs(groove) * math.sin(angle)) for angle in angles]
    rim = (arc[-1][0], face)
    return [arc, [arc[-1], rim], [rim, (back, face)], [(back, face), (back, 0.0)], [(back, 0.0), arc[0]]]


def plain_view(parameters, channels) -> View:
    """The view of a kind that has none of its own: every channel over time."""
    return view_of(channels, panels=tuple(panel_of(channel) for channel in channels if channel.width <= MOST_CURVES))
