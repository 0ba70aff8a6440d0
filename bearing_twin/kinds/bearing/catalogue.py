"""Bearings by designation: boundary dimensions of ISO 15, ball sets and their uncertainty, ratings to judge by.

A row that names no ball set gets one by a rule. Rows come from `config/bearings/`, then from the user's own folder, and
from files that are added; a later row of a designation takes the place of an earlier one.
"""

import dataclasses
import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from bearing_twin.base.errors import SceneError, echo, legal_hint
from bearing_twin.base.parameters import LONGEST_TEXT, choice, quantity, raise_problems, read, text
from bearing_twin.base.units import key_suffix
from bearing_twin.base.yaml_files import BEARINGS

BALL_SET = "balls", "ball_diameter", "pitch_diameter", "inner_conformity", "outer_conformity"
RULE = "rule"
FOUND = {  # sources of ball sets: meanings
    "frequencies": "from the coefficients FTF, BSF and BPFO of Timken (housed unit catalogue, table A-9), on a pitch "
    "circle in the middle; it meets the published ratings",
    "factors": "from the factor f0 of ISO 76 and the static rating by NSK and JTEKT (6305: SKF); it meets their "
    "dynamic ratings and both ratings of four more makers",
    "ratings": "estimated: the set of balls as sold whose ratings are nearest to those by FBJ and NKE; the "
    "uncertainty spans other sets that come near; it meets the ratings by SKF within 4 %",
    "published": "number, ball and pitch diameter as they are published; see its source",
    "literature": "the example of Harris, Rolling Bearing Analysis; it rates 6 % below those published for 7218 today",
    RULE: "estimated by a rule from the boundary dimensions",
    "given": "as its file says",
}


class BallRule(NamedTuple):
    """Ball diameter over (outside - bore), share of the pitch circle that balls fill, uncertainty of both.

    Fitted to the rows of the package, which it meets within it but for the 6200, whose balls are 18 % smaller
    than by the rule (tests/test_catalogue.py).
    """

    diameter: float
    filling: float
    balls_error: int
    diameter_error: float


DEEP_GROOVE, ANGULAR_CONTACT = BallRule(0.29, 0.57, 2, 0.11), BallRule(0.32, 0.90, 1, 0.05)
PITCH_ERROR = 0.015  # relative; greatest offset of the pitch circle from the middle between bore and outside
MAKER = re.compile(r"(SKF|FAG|INA|NSK|NTN|SNR|KOYO|NACHI|TIMKEN|NKE|FBJ)[ -]+")
CLEARANCES = "C2", "CN", "C3", "C4", "C5"  # groups of ISO 5753-1; CN is the normal one
# ISO 5753-1, deep groove bearings: up to this bore [mm], least and greatest radial clearance [um] of each group
GROUPS = (
    (10, (0, 7), (2, 13), (8, 23), (14, 29), (20, 37)),
    (18, (0, 9), (3, 18), (11, 25), (18, 33), (25, 45)),
    (24, (0, 10), (5, 20), (13, 28), (20, 36), (28, 48)),
    (30, (1, 11), (5, 20), (13, 28), (23, 41), (30, 53)),
    (40, (1, 11), (6, 20), (15, 33), (28, 46), (40, 64)),
    (50, (1, 11), (6, 23), (18, 36), (30, 51), (45, 73)),
    (65, (1, 15), (8, 28), (23, 43), (38, 61), (55, 90)),
    (80, (1, 15), (10, 30), (25, 51), (46, 71), (65, 105)),
    (100, (1, 18), (12, 36), (30, 58), (53, 84), (75, 120)),
    (120, (2, 20), (15, 41), (36, 66), (61, 97), (90, 140)),
    (140, (2, 23), (18, 48), (41, 81), (71, 114), (105, 160)),
    (160, (2, 23), (18, 53), (46, 91), (81, 130), (120, 180)),
    (180, (2, 25), (20, 61), (53, 102), (91, 147), (135, 200)),
    (200, (2, 30), (25, 71), (63, 117), (107, 163), (150, 230)),
)
# What makers append to a designation for seals, shields, cages and classes of accuracy, which change no ball set.
SUFFIX = re.compile(
    r"2RS[HRL1J]?|2RZ|RS[HRL1]?|RZ|2Z[R]?|ZZ?|DDU?|VV|LL[UBH]|2NSE|NSE|NR?|TN9?|TV[PH]|TNGN?|M[A]?|J|P[456]|"
    r"BEP?|E[PM]?|"
    r"ECB[PMJY]|CB[PMJY]|C[02345]|CN|GJN|WT|C78|VA\d+|HT|MT\d+|JEM"
)
OTHER_TYPES = {  # types by the beginnings of designations (ISO 15, DIN 623-1)
    "a spherical roller bearing": r"(213|22[2-3]|23[0-2]|23[8-9]|24[0-1])\d\d",
    "a spherical roller thrust bearing": r"29[2-4]\d\d",
    "a cylindrical roller bearing": r"(N|NU|NJ|NUP|NN|NNU|NCF|NNCF)\d{3,5}",
    "a tapered roller bearing": r"(30[23]|31[13]|32[0239]|33[0-2])\d\d",
    "a needle roller bearing": r"(HK|BK|NK|NKI|NKIS|NA|RNA|NKS)\d+",
    "a thrust ball bearing": r"5[1-4][1-4]\d\d",
    "a cylindrical roller thrust bearing": r"8[1-9][1-9]\d\d",
    "a self-aligning ball bearing": r"(1[0-4]|2[23])\d\d",
    "a double-row angular-contact ball bearing": r"(3[0238]|33)\d\d",
    "a double-row deep groove ball bearing": r"4[23]\d\d",
    "a four-point-contact ball bearing": r"QJ[23]?\d+",
    "an insert bearing for a housed unit": r"(UC|UCP|UCF|UCFL|SB|YAR)\d+",
}


class Designation(NamedTuple):
    """A bearing of the catalogue by name, and its group of clearance, "" for the normal one."""

    name: str
    clearance: str = ""


def read_designation(text: str) -> Designation | None:
    """The bearing that a text such as 6205-2RS/C3 names, None if the catalogue has no such designation.

    Raises SceneError for bearings of other types, which are not modelled, and for unknown groups of clearance.
    """
    label = str(text).strip()
    if label in entries():
        return Designation(label)
    label = label.upper()
    if len(label) > LONGEST_TEXT or not label.isascii():
        return None
    maker = match[1] if (match := MAKER.match(label)) else ""
    label = MAKER.sub("", label, count=1)
    for name in sorted(filter(label.startswith, entries()), key=len, reverse=True):
        suffixes, clearance = label[len(name) :], ""
        while suffixes := suffixes.lstrip("-/ ."):
            match = SUFFIX.match(suffixes)
            if not match:
                break
            clearance = match[0] if match[0] in CLEARANCES else clearance
            suffixes = suffixes[match.end() :]
        if not suffixes:
            name = name + maker if name + maker in entries() else name
            return Designation(name, "" if clearance == "CN" else clearance)
        if re.fullmatch(r"C\d", suffixes):
            raise SceneError(
                f"{echo(text)}: {suffixes} is no group of radial clearance; legal: {', '.join(CLEARANCES)}"
            )
    base = re.split(r"[-/ ]", label)[0]
    for bearing_type, pattern in OTHER_TYPES.items():
        if re.fullmatch(rf"(?:{pattern})[A-Z0-9]{{0,6}}" if not base.isdigit() else pattern, base):
            raise SceneError(
                f"{echo(text)} is {bearing_type}: no deep-groove or angular-contact ball bearing of one row, which are "
                "those that are modelled; `bearing_twin bearing --list` has the catalogue"
            )
    return None


@dataclass(frozen=True)
class Entry:
    """One row of a catalogue: dimensions, ball set, how sure it is, and the ratings published for it."""

    bore: float = quantity(0.0, "m", "bore diameter", above=0.0)
    outside_diameter: float = quantity(0.0, "m", "outside diameter", above=0.0)
    width: float = quantity(0.0, "m", "width; 0 = not given", at_least=0.0)
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
    pitch_diameter_doubt: float = quantity(0.0, "m", "by how much the pitch diameter may be wrong", at_least=0.0)
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


@functools.cache
def entries() -> dict[str, Entry]:
    """The catalogue: every designation with its row, read once; raises SceneError for a file that cannot be used."""
    catalogue: dict[str, Entry] = {}
    for rows, origin in BEARINGS.load_all():
        catalogue.update(read_entries(rows, origin))
    return catalogue


def add_file(name) -> list[str]:
    """Add the rows of a YAML file to the catalogue of this process; returns their designations. Raises SceneError."""
    path = BEARINGS.find(name)
    added = read_entries(BEARINGS.load(BEARINGS.read_text(path), str(path)), str(path))
    entries().update(added)
    return list(added)


def designations() -> tuple[str, ...]:
    """All designations, sorted."""
    return tuple(sorted(entries()))


def clearance_limits(entry: Entry, group: str = "") -> tuple[float, float]:
    """Least and greatest radial clearance [m] of a deep groove bearing as made; zeros where no group is known.

    `group` is one of CLEARANCES, "" for the row's own or the normal one.
    """
    if entry.radial_clearance != (0.0, 0.0) and not group:
        return entry.radial_clearance
    column = 1 + CLEARANCES.index(group or "CN")
    return next(
        (tuple(1e-6 * limit for limit in row[column]) for row in GROUPS if entry.bore <= 1e-3 * row[0]), (0.0, 0.0)
    )


def geometry_of(entry: Entry, group: str = "") -> dict[str, float]:
    """The keys of `geometry` of a scene that a row gives; the clearance is the mean of its limits."""
    angle = {"contact_angle": entry.contact_angle} if entry.contact_angle else {}
    return {
        **{key: getattr(entry, key) for key in BALL_SET},
        **(angle or {"radial_clearance": 0.5 * sum(clearance_limits(entry, group))}),
    }


def completed(scene: dict) -> tuple[dict, list[str]]:
    """The plain data of a scene with the row of `geometry.designation` filled in, and its problems.

    Keys of the scene have precedence. If none is missing, the designation is a mere name, known or not, so that a log
    can be read without the catalogue of its bearing.
    """
    geometry = scene.get("geometry")
    if not isinstance(geometry, Mapping) or geometry.get("designation", "") == "":
        return scene, []
    has_clearance = "radial_clearance" in geometry or "contact_angle" in geometry
    if has_clearance and set(BALL_SET) <= geometry.keys():
        return scene, []
    text = str(geometry["designation"])
    try:
        designation = read_designation(text)
    except SceneError as problem:
        return scene, [f"geometry.designation: {problem}"]
    if designation is None:
        return scene, [
            f"geometry.designation = {echo(text)} is not in the catalogue; {legal_hint(text, designations())}"
        ]
    entry = entries()[designation.name]
    if designation.clearance and entry.contact_angle:
        return scene, [f"geometry.designation = {echo(text)}: clearance groups are those of deep groove bearings"]
    row = geometry_of(entry, designation.clearance)
    if has_clearance:
        row = {key: row[key] for key in BALL_SET}
    return {**scene, "geometry": {**row, **geometry, "designation": designation.name}}, []


def _description(name: str) -> str:
    entry = entries()[name]
    sizes = " x ".join(f"{1e3 * size:g}" for size in (entry.bore, entry.outside_diameter, entry.width) if size)
    return f"{name}, {sizes} mm, {entry.balls} balls of {1e3 * entry.ball_diameter:g} mm"


class _Scenes(dict):
    """Scenes by designation, also with suffixes of makers, such as 6205-2RS/C3."""

    def __contains__(self, text) -> bool:
        return super().__contains__(text) or read_designation(text) is not None

    def __missing__(self, text) -> dict:
        designation = read_designation(text)
        if designation is None:
            raise KeyError(text)
        name, clearance = designation
        described = _description(name)
        if clearance:
            name, described = f"{name}_{clearance}", f"{described}, clearance {clearance}"
        return _scene(name, described, str(text))


def _scene(name: str, description: str, designation: str) -> dict:
    return {"kind": "bearing", "name": name, "description": description, "geometry": {"designation": designation}}


def catalogue_scenes() -> Mapping[str, dict]:
    """The plain data of a scene for each designation, with the defaults of everything but its geometry."""
    return _Scenes({name: _scene(name, _description(name), name) for name in designations()})


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
    if not problems and entry.contact_angle == 0.0 and clearance_limits(entry) == (0.0, 0.0):
        problems.append(
            f"radial_clearance is not given, and ISO 5753-1 is known here for bores up to 200 mm, not {entry.bore:g} "
            "m: give it, or dimensions with their unit, as 40mm"
        )
    return problems


def by_rule(entry: Entry) -> tuple[int, float]:
    """Number and diameter [m] of the balls by the rule; a diameter of the row is kept."""
    rule = _rule(entry)
    ball = entry.ball_diameter or rule.diameter * (entry.outside_diameter - entry.bore)
    return max(3, round(rule.filling * math.pi * _pitch(entry) / ball)), ball


def _rule(entry: Entry) -> BallRule:
    return ANGULAR_CONTACT if entry.contact_angle else DEEP_GROOVE


def _pitch(entry: Entry) -> float:
    return entry.pitch_diameter or 0.5 * (entry.bore + entry.outside_diameter)


def _with_balls(entry: Entry) -> Entry:
    """The row with pitch circle and ball set; missing values follow from the rule, with its uncertainty."""
    estimates = {}
    if not entry.pitch_diameter:
        estimates = {"pitch_diameter": _pitch(entry), "pitch_diameter_doubt": PITCH_ERROR * _pitch(entry)}
    rule = _rule(entry)
    balls, ball = by_rule(entry)
    if not entry.ball_diameter:
        estimates |= {"found": RULE, "ball_diameter": ball, "ball_diameter_doubt": rule.diameter_error * ball}
    if not entry.balls:
        estimates |= {"found": RULE, "balls": balls, "balls_doubt": rule.balls_error}
    return dataclasses.replace(entry, **estimates)


def row_of(name: str) -> dict:
    """The row of a designation with SI-suffixed keys; ranges are (least, greatest), None where nothing is published."""
    entry = entries()[name]
    columns = {
        f"{field.name}{key_suffix(field.metadata.get('unit', ''))}": getattr(entry, field.name)
        for field in dataclasses.fields(entry)
        if field.name not in ("dynamic", "static")
    }
    return {
        "designation": name,
        **columns,
        "width_m": entry.width or None,
        "radial_clearance_m": None if entry.contact_angle else list(clearance_limits(entry)),
        "found_means": FOUND[entry.found],
        "published_dynamic_rating_n": list(entry.dynamic) if entry.dynamic[1] else None,
        "published_static_rating_n": list(entry.static) if entry.static[1] else None,
    }
