"""Defects of a bearing's surfaces, as a scene gives them: waviness and spalls of raceways and of the first ball."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

from bearing_twin.base.parameters import choice, echo, quantity, read, section

SURFACES = ("inner", "outer", "ball")
MOST = 16  # in one bearing
LONGEST_SHARE = 1.0 / 6.0  # of a surface's circumference, of a spall
WIDEST = 2.0 * math.sin(math.radians(60.0))  # of the groove's radius: as wide as contacts go
HIGHEST = 0.002  # of the ball's diameter, of a wave: a tenth of what a contact bears


@dataclass(frozen=True)
class Spall:
    """A pit along the path of the contacts, whose edges a ball bridges."""

    place: float = quantity(
        0.0, "rad", "of its middle, from +x; on the inner ring it turns with the ring, from there on at the start"
    )
    length: float = quantity(0.0, "m", "along rolling", at_least=0.0)
    width: float = quantity(0.0, "m", "across rolling; 0 = as wide as the contact", at_least=0.0)
    depth: float = quantity(1e-3, "m", "deeper than the ball drops changes nothing", above=0.0)


@dataclass(frozen=True)
class Defect:
    """One defect: `waviness` (order, amplitude [m], phase [rad]) or a spall."""

    on: str = choice("outer", SURFACES, "inner, outer: a raceway; ball: the first ball, on its great circle across z")
    waviness: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0),
        "1",
        "order, amplitude [m], phase [rad]: adds to approaches the cosine of order angle + phase, times the amplitude",
    )
    spall: Spall = section(Spall)

    def radius(self, geometry) -> float:
        """Radius [m] of the circle on which contacts run over it."""
        ball, pitch = 0.5 * geometry.ball_diameter, 0.5 * geometry.pitch_diameter
        return {"inner": pitch - ball, "outer": pitch + ball, "ball": ball}[self.on]


def defect_list():
    """The field of a scene: a list of mappings, as `{on: outer, spall: {place: 4.7, length: 1e-3}}`."""
    columns = (("on", "word"), ("waviness", "order, m, rad"), ("spall", "place, length, width, depth"))
    help = "of raceways and of the first ball, waviness or a spall each: heights that add to approaches"
    return dataclasses.field(
        default=(),
        metadata={
            "columns": columns, "help": help, "read": read_defects, "kind": "list", "element": Defect, "most": MOST,
        },
    )  # fmt: skip


def read_defects(given, _columns) -> tuple[tuple, str]:
    """(defects, "") of the list, or ((), the tail of a sentence about what is wrong)."""
    legal = "must be a list of {on: inner | outer | ball} with waviness or spall each"
    if not isinstance(given, (list, tuple)) or len(given) > MOST:
        return (), f" = {echo(given)} {legal}, {MOST} at most"
    found = []
    for number, one in enumerate(given):
        if not isinstance(one, Mapping) or "on" not in one:
            return (), f"[{number}] = {echo(one)} {legal}"
        defect, problems = read(Defect, one)
        if problems:
            return (), f"[{number}].{problems[0]}"
        if (defect.waviness[0] != 0.0) == (defect.spall.length > 0.0):
            return (), f"[{number}] = {echo(one)} {legal}: waviness of an order above 0, or a spall with a length"
        found.append(defect)
    return tuple(found), ""


def defect_problems(defects: tuple[Defect, ...], geometry) -> list[str]:
    """What no bearing of this geometry has, a sentence each."""
    problems = []
    for number, one in enumerate(defects):
        spall, (order, amplitude, _) = one.spall, one.waviness
        conformity = geometry.inner_conformity if one.on == "inner" else geometry.outer_conformity
        longest = LONGEST_SHARE * 2.0 * math.pi * one.radius(geometry)
        widest, highest = WIDEST * conformity * geometry.ball_diameter, HIGHEST * geometry.ball_diameter
        rows = (
            (
                spall.length > longest,
                "spall.length",
                spall.length,
                f"at most a sixth of the way round, {longest:.4g} m",
            ),
            (spall.width > widest, "spall.width", spall.width, f"at most as wide as the groove, {widest:.4g} m"),
            (order != round(order) or order < 0.0, "waviness[0]", order, "a whole number of waves, above 0"),
            (
                abs(amplitude) > highest,
                "waviness[1]",
                amplitude,
                f"at most {highest:.3g} m, as a contact bears no more",
            ),
        )
        problems += [
            f"defects[{number}].{key} = {value:g} must be {legal}" for wrong, key, value, legal in rows if wrong
        ]
    return problems
