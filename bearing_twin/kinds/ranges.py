"""Ranges of validity of models: one table, one row a model and a number of the scene known before the run.

A kind gives these numbers as `facts` of its parameters. What shows only in the run, as a pressure beyond yield, is a
flag of the run. Models without a row have no range that is known: `linear` and `measured` are the user's own numbers,
exact Hertz holds for every ellipse, and steppers refuse steps beyond their limits themselves.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from bearing_twin.base.errors import SceneError
from bearing_twin.base.units import with_unit
from bearing_twin.contact.validity import LAW_TOLERANCE
from bearing_twin.kinds.contract import lazy_import
from bearing_twin.kinds.error_estimates import LARGE

ON = "on"  # of solver.allow_invalid
OUTSIDE = "outside_range"  # the mark on all that such a run gives out: channel, topic, key
FASTEST_CHANGE = 1000.0  # 1/s: balls preloaded by 10 um leave rolling by 9e-4 then (`tests/test_ranges.py`)
SPOT_LAWS = ("hertz", "hertz_exact", "volumetric", "constant", "hertz_differential", "hertz_unprojected")


class Range(NamedTuple):
    """Range of validity of `models` of the `key`: `fact` (in words, unit) from `least` to `greatest`, and `why`.

    `instead` is what to ask for beyond.
    """

    key: str
    models: tuple[str, ...]
    fact: str
    words: str
    unit: str
    least: float
    greatest: float
    why: str
    instead: str

    @property
    def limits(self) -> str:
        """The range in words."""
        low = f"from {self.least:g}{with_unit(self.unit)}" if self.least > -math.inf else ""
        high = f"up to {self.greatest:g}{with_unit(self.unit)}" if self.greatest < math.inf else ""
        return " ".join(filter(None, (low, high)))

    def left(self, model: str, value: float) -> str:
        """The sentence about a specified model where the fact has this value."""
        return (
            f"{self.key} = {model} is outside its range: {self.words} is {value:.3g}{with_unit(self.unit)}, "
            f"and it holds {self.limits} ({self.why}); {self.instead}"
        )


RANGES = (
    Range(
        "contact.normal", ("volumetric",), "axis_ratio", "b/a of the narrowest contact", "", 0.063, math.inf,
        "below it the error of the load exceeds the 0.5 % that paper 1, section 4, states",
        "take contact.normal: hertz",
    ),
    Range(
        "contact.normal", ("constant",), "coefficient_change",
        "the change of Hertz's coefficient over the body, relative to that of the start,", "", -math.inf, LAW_TOLERANCE,
        "the coefficient is that of the start", "take contact.normal: hertz",
    ),
    Range(
        "contact.normal", SPOT_LAWS, "greatest_exponent", "the greatest exponent of a superellipsoid", "", -math.inf,
        2.0, "above 2 it has flat places, where contacts are not elliptic", "take contact.normal: overlap",
    ),
    Range(
        "contact.normal", ("line", "johnson"), "thickness_over_radius", "thickness over radius", "", 1.0, math.inf,
        "both assume plane strain", "take kind: soft_discs with against: disc and plane: stress",
    ),
    Range(
        "contact.normal", ("line", "johnson"), "speed_share",
        "the speed of each disc over that of waves in it", "", -math.inf, 0.14,
        "there the error of the force against finite elasticity is 42 %, and no faster disc was compared",
        "take kind: soft_discs with against: disc",
    ),
    Range(
        "contact.friction", ("spot", "spot_medium", "spot_fine", "pade1", "pade2"), "axis_ratio",
        "b/a of the narrowest contact", "",
        0.03, math.inf, "narrower ellipses were not compared with the exact solution", "take contact.friction: point",
    ),
    Range(
        "model.dimension", ("quasi_static",), "slip_at_start",
        "the relative deviation of the balls from rolling at the start", "", -math.inf, 0.0,
        "balls that start from rest skid, and those of equilibria roll", "take model.dimension: prescribed or free",
    ),
    Range(
        "model.dimension", ("quasi_static",), "ring_shift", "drive.change.offset", "m", -math.inf, 0.0,
        "contacts ring after a sudden displacement of the ring", "take model.dimension: prescribed",
    ),
    Range(
        "model.dimension", ("quasi_static",), "relative_acceleration",
        "drive.acceleration over the least speed", "1/s", -math.inf,
        FASTEST_CHANGE,
        "balls preloaded by 10 um roll, within 1e-3, while the speed changes more slowly",
        "take model.dimension: prescribed or free",
    ),
    Range(
        "model.dimension", ("quasi_static",), "centrifugal_share",
        "the centrifugal load over that on the inner raceway, of balls with a tenth of the greatest load or more,",
        "", -math.inf, 1.4,
        "`bearing_twin chart dimensions` compared no more", "take model.dimension: prescribed or free",
    ),
    Range(
        "beam.theory", ("euler",), "shear_share",
        "the share of shear in the static deflection, 2.4 (1 + nu) (height / span)^2,", "", -math.inf, LARGE,
        "Euler's beam has no shear", "take beam.theory: timoshenko",
    ),
    Range(
        "beam.theory", ("euler",), "first_peak_error",
        "the error of the first peak of force against Timoshenko's beam", "", -math.inf, LARGE,
        "the impact is calculated by both theories", "take beam.theory: timoshenko",
    ),
    Range(
        "formulation", ("linear",), "speed_share", "the speed of the disc over that of waves in it", "", -math.inf,
        0.01, "beyond it strains exceed 5 %, which are not small", "take formulation: stvk or neo_hookean",
    ),
    Range(
        "plane", ("stress",), "thickness_over_radius", "thickness over radius", "", -math.inf, 1.0,
        "thicker discs are nearer to plane strain", "take plane: strain",
    ),
    Range(
        "mesh.integration", ("full",), "poisson_ratio_in_strain", "Poisson's ratio in plane strain", "", -math.inf,
        0.45, "bilinear elements lock beyond it", "take mesh.integration: selective",
    ),
)  # fmt: skip
"""Every range that a specified model may leave before it runs."""


def facts_at(*places: str) -> dict[str, Callable[[Any], float | None]]:
    """Facts by name: functions of the parameters at "module:name", imported at their first use."""
    return {place.partition(":")[2]: lazy_import(place) for place in places}


def least_of(key: str, fact: str) -> float:
    """The least value of a fact down to which models of a key hold."""
    return next(row.least for row in RANGES if (row.key, row.fact) == (key, fact))


def allowed(parameters) -> bool:
    """True if the scene lets models run outside their ranges."""
    return _at(parameters, "solver.allow_invalid") == ON


def left_by(parameters, only: tuple[str, str] | None = None) -> tuple[str, ...]:
    """One sentence for each range that a specified model leaves; a fact that is None, or has no value, leaves none.

    With `only`, a key and a model, those of this model that a rule has chosen.
    """
    facts, found = parameters.facts, []
    for row in RANGES:
        model = _at(parameters, row.key)
        if only is not None:
            model = only[1] if row.key == only[0] else ""
        if row.fact not in facts or model not in row.models:
            continue
        try:
            value = facts[row.fact](parameters)
        except SceneError:  # a scene that has no start is refused where its model is chosen
            continue
        if value is not None and not row.least <= value <= row.greatest:
            found.append(row.left(model, value))
    return tuple(found)


def _at(parameters, key: str):
    """The value at that key, None where there is none."""
    for word in key.split("."):
        parameters = getattr(parameters, word, None)
    return parameters
