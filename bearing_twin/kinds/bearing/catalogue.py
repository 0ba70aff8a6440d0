"""Bearings by designation: boundary dimensions of ISO 15, ball sets with their doubts, published ratings to judge by.

A row that names no ball set gets one by a rule. Rows come from `config/bearings/`, then from the user's own folder, and
from files that are added; a later row of a designation takes the place of an earlier one.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from bearing_twin.errors import SceneError
from bearing_twin.parameters import LONGEST_TEXT, choice, echo, quantity, raise_problems, read, text
from bearing_twin.shelf import BEARINGS
from bearing_twin.spelling import unknown

RULE = "rule"
FOUND = {  # how a ball set was found: what that means
    "frequencies": "number and diameter from the frequency coefficients FTF, BSF and BPFO that a maker publishes "
    "(Timken, housed unit catalogue, table A-9), on a pitch circle in the middle; published ratings, which had no part "
    "in it, check the set: it meets them",
    "factors": "number and diameter from the factor f0 of ISO 76, which tells diameter over pitch circle, and the "
    "static rating that NSK and JTEKT publish (6305: SKF); their dynamic ratings and both ratings of four more makers, "
    "which had no part in it, check the set: it meets them",
    "ratings": "estimated: the number and the ball size sold (steps of 1/64 inch, and some of whole millimetres) whose "
    "ratings by ISO 281 and ISO 76 are nearest to those published by FBJ and NKE; the doubts reach to other sets that "
    "come near; the ratings by SKF, which had no part in it, check the set: it meets them within 4 %",
    "literature": "the example of Harris, Rolling Bearing Analysis; it rates 6 % below those published for 7218 today",
    RULE: "estimated by a rule from the boundary dimensions",
    "given": "as its file says",
}


class BallRule(NamedTuple):
    """Ball diameter over (outside - bore), part of the pitch circle that the balls fill, doubts of number and diameter.

    Fitted to the rows of the package, which it meets within its doubts but for the 6200, whose balls are 18 % smaller
    than by the rule (tests/test_catalogue.py).
    """

    diameter: float
    filling: float
    balls_doubt: int
    diameter_doubt: float


DEEP_GROOVE, ANGULAR_CONTACT = BallRule(0.29, 0.57, 2, 0.11), BallRule(0.32, 0.90, 1, 0.05)
PITCH_DOUBT = 0.015  # relative; makers place the pitch circle off the middle between bore and outside by up to this
# ISO 5753-1, group N of radial clearance of deep groove bearings: up to this bore [m], least and greatest [m]
NORMAL_CLEARANCE = (
    (10e-3, 2e-6, 13e-6),
    (18e-3, 3e-6, 18e-6),
    (24e-3, 5e-6, 20e-6),
    (30e-3, 5e-6, 20e-6),
    (40e-3, 6e-6, 20e-6),
    (50e-3, 6e-6, 23e-6),
    (65e-3, 8e-6, 28e-6),
    (80e-3, 10e-6, 30e-6),
    (100e-3, 12e-6, 36e-6),
    (120e-3, 15e-6, 41e-6),
    (140e-3, 18e-6, 48e-6),
    (160e-3, 18e-6, 53e-6),
    (180e-3, 20e-6, 61e-6),
    (200e-3, 25e-6, 71e-6),
)


@dataclass(frozen=True)
class Entry:
    """One row of a catalogue: dimensions, ball set, how sure it is, and the ratings published for it."""

    bore: float = quantity(0.0, "m", "bore diameter", above=0.0)
    outside_diameter: float = quantity(0.0, "m", "outside diameter", above=0.0)
    width: float = quantity(0.0, "m", "width; 0 = not told", at_least=0.0)
    balls: int = quantity(0, "1", "number of balls; 0 = by the rule", at_least=0, at_most=4096)
    ball_diameter: float = quantity(0.0, "m", "ball diameter; 0 = by the rule", at_least=0.0)
    pitch_diameter: float = quantity(0.0, "m", "of the pitch circle; 0 = in the middle", at_least=0.0)
    inner_conformity: float = quantity(0.52, "1", "inner groove radius / ball diameter", above=0.5, at_most=10.0)
    outer_conformity: float = quantity(0.52, "1", "outer groove radius / ball diameter", above=0.5, at_most=10.0)
    contact_angle: float = quantity(0.0, "rad", "without load; 0 = a deep groove bearing", at_least=0.0, at_most=0.7854)
    radial_clearance: tuple[float, float] = quantity(
        (0.0, 0.0), "m", "least and greatest as made; zeros = group N of ISO 5753-1 by the bore"
    )
    found: str = choice("given", tuple(FOUND), "how the ball set was found")
    source: str = text("", "where its numbers are from")
    balls_doubt: int = quantity(0, "1", "by how many the number of balls may be wrong", at_least=0, at_most=4096)
    ball_diameter_doubt: float = quantity(0.0, "m", "by how much the ball diameter may be wrong", at_least=0.0)
    dynamic: tuple[float, float] = quantity((0.0, 0.0), "N", "least and greatest dynamic rating published; 0 = none")
    static: tuple[float, float] = quantity((0.0, 0.0), "N", "least and greatest static rating published; 0 = none")


def read_entries(rows, origin: str) -> dict[str, Entry]:
    """The rows of one file, ball sets filled in; raises SceneError that names every problem."""
    if not isinstance(rows, Mapping) or not rows:
        raise SceneError(f"{origin} holds no bearings; begin each with its designation, as 6308X: {{bore: 40e-3, ...}}")
    entries, problems = {}, []
    for name, row in rows.items():
        name = str(name)
        if not name.isalnum() or len(name) > LONGEST_TEXT:
            problems.append(f"{echo(name)} must be a designation of letters and digits")
            continue
        entry, wrong = read(Entry, row)
        wrong = wrong or _contradictions(entry)
        problems += [f"{name}: {problem}" for problem in wrong]
        if not wrong:
            entries[name] = _with_balls(entry)
    raise_problems(origin, problems)
    return entries


def entries() -> dict[str, Entry]:
    """The catalogue: every designation with its row, read once; raises SceneError for a file that cannot be used."""
    if not _CATALOGUE:
        for rows, origin in BEARINGS.every():
            _CATALOGUE.update(read_entries(rows, origin))
    return _CATALOGUE


_CATALOGUE: dict[str, Entry] = {}


def add_file(name) -> list[str]:
    """Adds the rows of a YAML file to the catalogue of this process; their designations. Raises SceneError."""
    path = BEARINGS.find(name)
    found = read_entries(BEARINGS.load(BEARINGS.read_text(path), str(path)), str(path))
    entries().update(found)
    return list(found)


def designations() -> tuple[str, ...]:
    """All designations, sorted."""
    return tuple(sorted(entries()))


def clearance_of(entry: Entry) -> tuple[float, float]:
    """Least and greatest radial clearance [m] of a deep groove bearing as made; zeros where no group is known."""
    if entry.radial_clearance != (0.0, 0.0):
        return entry.radial_clearance
    return next(((low, high) for bore, low, high in NORMAL_CLEARANCE if entry.bore <= bore), (0.0, 0.0))


def geometry_of(entry: Entry) -> dict[str, float]:
    """The keys of `geometry` of a scene that a row gives; the clearance is the middle of what is made."""
    gap = {"contact_angle": entry.contact_angle} if entry.contact_angle else {}
    return {
        "balls": entry.balls,
        "ball_diameter": entry.ball_diameter,
        "pitch_diameter": entry.pitch_diameter,
        "inner_conformity": entry.inner_conformity,
        "outer_conformity": entry.outer_conformity,
        **(gap or {"radial_clearance": 0.5 * sum(clearance_of(entry))}),
    }


def completed(scene: dict) -> tuple[dict, list[str]]:
    """The plain data of a scene with the row of `geometry.designation` filled in, and what is wrong with it.

    What the scene gives itself stays. Where it leaves nothing out the designation is but a name, known or not: so a log
    is read where its catalogue is not at hand.
    """
    given = scene.get("geometry")
    if not isinstance(given, Mapping) or given.get("designation", "") == "":
        return scene, []
    gaps = {"radial_clearance", "contact_angle"} & given.keys()
    if gaps and {"balls", "ball_diameter", "pitch_diameter", "inner_conformity", "outer_conformity"} <= given.keys():
        return scene, []
    name = str(given["designation"])
    if name not in entries():
        return scene, [f"geometry.designation = {echo(name)} is not in the catalogue; {unknown(name, designations())}"]
    row = geometry_of(entries()[name])
    if gaps:
        row = {key: value for key, value in row.items() if key not in ("radial_clearance", "contact_angle")}
    return {**scene, "geometry": {**row, **given}}, []


def _description(name: str) -> str:
    entry = entries()[name]
    sizes = " x ".join(f"{1e3 * size:g}" for size in (entry.bore, entry.outside_diameter, entry.width) if size)
    return f"{name}, {sizes} mm, {entry.balls} balls of {1e3 * entry.ball_diameter:g} mm"


def scenes() -> Mapping[str, dict]:
    """The plain data of a scene for each designation, with the defaults of everything but its geometry."""
    return {
        name: {"kind": "bearing", "name": name, "description": _description(name), "geometry": {"designation": name}}
        for name in designations()
    }


def _contradictions(entry: Entry) -> list[str]:
    problems = []
    if not 0.0 < entry.bore < entry.outside_diameter:
        problems.append(
            f"bore = {entry.bore:g} m and outside_diameter = {entry.outside_diameter:g} m leave no room; give both, "
            "the outside diameter greater"
        )
    for key in ("radial_clearance", "dynamic", "static"):
        low, high = getattr(entry, key)
        if low > high:
            problems.append(f"{key} = {[low, high]} must be the least and the greatest, in this order")
    if not problems and entry.contact_angle == 0.0 and clearance_of(entry) == (0.0, 0.0):
        problems.append("radial_clearance is not told, and ISO 5753-1 is known here for bores up to 200 mm; give it")
    return problems


def by_rule(entry: Entry) -> tuple[int, float]:
    """Number and diameter [m] of the balls by the rule; a given diameter is kept."""
    rule = ANGULAR_CONTACT if entry.contact_angle else DEEP_GROOVE
    ball = entry.ball_diameter or rule.diameter * (entry.outside_diameter - entry.bore)
    return max(3, round(rule.filling * math.pi * _pitch(entry) / ball)), ball


def _pitch(entry: Entry) -> float:
    return entry.pitch_diameter or 0.5 * (entry.bore + entry.outside_diameter)


def _with_balls(entry: Entry) -> Entry:
    """The row with pitch circle and ball set; what it leaves out is found by the rule, with its doubts."""
    found = {"pitch_diameter": _pitch(entry)}
    rule = ANGULAR_CONTACT if entry.contact_angle else DEEP_GROOVE
    balls, ball = by_rule(entry)
    if not entry.ball_diameter:
        found |= {"found": RULE, "ball_diameter": ball, "ball_diameter_doubt": rule.diameter_doubt * ball}
    if not entry.balls:
        found |= {"found": RULE, "balls": balls, "balls_doubt": rule.balls_doubt}
    return dataclasses.replace(entry, **found)
