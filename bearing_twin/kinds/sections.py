"""One vocabulary: the sections that kinds of scenes share, their keys, units, limits and meanings.

A kind takes a section as it is, with defaults of its own (`section(..., default=...)`), or narrows the legal values of
a word in a subclass. What a kind leaves out it cannot do.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

from bearing_twin.base.errors import SceneError
from bearing_twin.base.parameters import choice, quantity, read_number
from bearing_twin.contact.friction import PATCH_NAMES, friction_names
from bearing_twin.contact.laws import law_names
from bearing_twin.kinds.error_estimates import NO_CHECK, SECOND_RUN

STANDARD_GRAVITY = 9.80665  # m/s^2
GREATEST_OUTPUT_COUNT = 1e9
GREATEST_DURATION = 86400.0  # s
UNVERIFIED = "less than a second run verifies in double precision, as approaches are small differences of positions"
WHOLE = 1e-6  # relative: a ratio of rates this near to a whole number is one


@dataclass(frozen=True)
class ElasticLaw:
    """The elastic law of a contact."""

    normal: str = choice("auto", ("auto",), "elastic law; auto = the cheapest adequate one")


@dataclass(frozen=True)
class PointElastic(ElasticLaw):
    """Elastic law of a contact at a point."""

    stiffness: float = quantity(0.0, "N/m", "of one contact, for the law linear", at_least=0.0)


def free_fall(*direction: float, along: str = ""):
    """The key `gravity` [m/s^2]: standard gravity along a direction, by default; `along` is what must hold."""
    standard = tuple(STANDARD_GRAVITY * part for part in direction)
    return quantity(standard, "m/s^2", f"acceleration of free fall{along}; zeros switch it off")


def point_laws(*numbers: str):
    """Laws that `normal` may name at a point, where the kind gives `given` of their needs; called late by `choice`."""
    return lambda: ("auto", *law_names("point", numbers))


@dataclass(frozen=True)
class Damping:
    """The viscous part of a contact's load, set by one key: a coefficient, or a restitution below 1."""

    damping: float = quantity(
        0.0, "s/m", "viscous term of Hunt and Crossley: damping * elastic load * approach rate", at_least=0.0
    )
    restitution: float = quantity(
        1.0,
        "1",
        "coefficient of restitution, from which the viscous term follows by damping_law; 1 = as the other keys say",
        above=0.0,
        at_most=1.0,
    )
    damping_law: str = choice(
        "hunt_crossley",
        ("hunt_crossley", "steady"),
        "of a restitution below 1; hunt_crossley loses more when faster, steady the same share at every speed",
    )
    restitution_speed: float = quantity(
        0.0,
        "m/s",
        "approach speed at which the restitution holds (hunt_crossley); 0 = that of the only impact there is; "
        "no source: 0.1 m/s is a choice, as it must hold at some speed",
        at_least=0.0,
    )


@dataclass(frozen=True)
class ViscoelasticDamping(Damping):
    """Damping with the viscous term of a viscoelastic half-space."""

    relaxation_time: float = quantity(
        0.0,
        "s",
        "viscous term of a viscoelastic contact: relaxation_time * stiffness * approach rate; "
        "no source: 1 us damps the ringing of a 6203's balls by a seventh of critical",
        at_least=0.0,
    )


@dataclass(frozen=True)
class SteadyDamping(Damping):
    """Damping with the viscous term of steady damping by its own coefficient."""

    viscosity: float = quantity(
        0.0, "N s/m^1.25", "viscous term viscosity * approach^(1/4) * approach rate (steady)", at_least=0.0
    )


@dataclass(frozen=True)
class Friction:
    """Friction in a contact."""

    friction: str = choice(
        "point",
        friction_names,
        "point = by the slip at the contact point; others = over the whole contact patch (patch = spot)",
        aliases=PATCH_NAMES,
    )
    friction_coefficient: float = quantity(
        0.0,
        "1",
        "Coulomb friction coefficient; no source: 0.08 is a guess for steel that is lubricated but not parted by oil",
        at_least=0.0,
        at_most=10.0,
    )
    friction_regularisation: float = quantity(
        1e-3,
        "m/s",
        "slip speed at which friction reaches 71 % of its limit; no source: smaller is truer and stiffer, and 10 mm/s "
        "are 0.5 % of the speed of a 6203's raceway at 1750 rpm",
        above=0.0,
    )


LOOSEST = 0.1  # tolerance that can be wanted


@dataclass(frozen=True)
class Wanted:
    """Requested outputs of a run, and their tolerance."""

    outputs: str = choice("history", ("history",), "history = every channel over time", widest=True)
    tolerance: float = quantity(1e-3, "1", "requested error", at_least=1e-13, at_most=LOOSEST)


def peak_and_impulse(default: float, at_least: float):
    """A field for the wanted tolerance of a body that bounces, of which a second run gives the error."""
    what = "requested error of a contact's peak load and impulse, over the greatest"
    return quantity(default, "1", what, at_least=at_least, at_most=LOOSEST, less=UNVERIFIED)


@dataclass(frozen=True)
class WantedImpact(Wanted):
    """Requested outputs of an impact, whose figures may be had without its history."""

    outputs: str = choice(
        "history",
        ("history", "peaks"),
        "history = every channel over time; peaks = contact time and peak force alone",
        widest=True,
    )


def solved_whole(parameters) -> bool:
    """True for an impact, which is solved as a whole before its first output."""
    return isinstance(getattr(parameters, "wanted", None), WantedImpact)


@dataclass(frozen=True)
class Bounded:
    """True if specified models keep to their ranges."""

    allow_invalid: str = choice(
        "off",
        ("off", "on"),
        "on = a specified model runs outside its range too; every output is marked, and the run is never done",
    )


def check_key():
    """The key `solver.check`."""
    return choice(
        SECOND_RUN,
        (SECOND_RUN, NO_CHECK),
        "second_run = a second run at a fraction of the tolerance gives the error of the method; it changes no figure",
    )


@dataclass(frozen=True)
class Checked(Bounded):
    """True if a second run gives the error of the method."""

    check: str = check_key()


@dataclass(frozen=True)
class RunSettings:
    """Duration and rates of outputs; zeros are replaced by what suits the scene."""

    duration: float = quantity(
        0.0, "s", "simulated time; 0 = the whole contact and some more", at_least=0.0, at_most=GREATEST_DURATION
    )
    output_rate: float = quantity(
        0.0, "Hz", "solver outputs, every one of them in the log; 0 = chosen", at_least=0.0, at_most=1e9
    )
    publish_rate: float = quantity(
        0.0,
        "Hz",
        "of wrenches and contacts, a whole part of output_rate; 0 = all outputs",
        at_least=0.0,
        at_most=1e9,
    )


def resolved_run(run: RunSettings, duration_needed: float = 0.0, outputs: int = 0) -> RunSettings:
    """The run with its zeros replaced: `duration_needed` [s] long, about `outputs` outputs, all of them published.

    Where a publish rate alone is given, the outputs are a whole multiple of it. Raises SceneError for a motion that
    would last longer than any run.
    """
    if not run.duration and not duration_needed <= GREATEST_DURATION:
        raise SceneError(
            f"the whole contact would take {duration_needed:.3g} s; give run.duration, up to {GREATEST_DURATION:g} s, "
            "or a greater speed"
        )
    duration = run.duration or float(f"{duration_needed:.4g}")
    output_rate = run.output_rate or 1e9 / max(1, round(1e9 * duration / outputs))
    if run.publish_rate and not run.output_rate:
        output_rate = run.publish_rate * max(1, round(output_rate / run.publish_rate))
    return dataclasses.replace(
        run, duration=duration, output_rate=output_rate, publish_rate=run.publish_rate or output_rate
    )


def check_run(run: RunSettings) -> list[str]:
    """Problems of a run's rates and duration."""
    problems = []
    if run.output_rate and run.publish_rate:
        every = run.output_rate / run.publish_rate
        if every < 1.0 - WHOLE:
            problems.append(
                f"run.publish_rate = {run.publish_rate:g} Hz cannot exceed run.output_rate = {run.output_rate:g} Hz; "
                "raise the latter or lower the former"
            )
        elif abs(every - round(every)) > WHOLE * every:
            near = [run.output_rate / count for count in (math.ceil(every), math.floor(every))]
            problems.append(
                f"run.publish_rate = {run.publish_rate:g} Hz does not divide run.output_rate = {run.output_rate:g} Hz; "
                f"use {near[0]:g} or {near[1]:g} Hz"
            )
    if run.duration * run.output_rate > GREATEST_OUTPUT_COUNT:
        problems.append(
            f"run.duration * run.output_rate = {run.duration * run.output_rate:g} outputs is too many; at most "
            f"{GREATEST_OUTPUT_COUNT:g}"
        )
    return problems


VISCOUS = {"damping": "s/m", "relaxation_time": "s", "viscosity": "N s/m^1.25"}


def damped_twice(contact) -> list[str]:
    """Problems as by `check_damping`, of a section as written: defaults of a kind count where they stand there."""
    numbers = (
        {name: read_number(value, VISCOUS.get(name, ""))[0] for name, value in contact.items()}
        if isinstance(contact, Mapping)
        else {}
    )
    restitution = numbers.get("restitution")
    return _one_viscous_term({name: numbers[name] for name in VISCOUS if numbers.get(name)}, restitution or 1.0)


def _one_viscous_term(terms: Mapping[str, float], restitution: float) -> list[str]:
    """The problem that more than one number of a contact gives its viscous term, if they do."""
    named = [f"contact.{name} = {value:g}" for name, value in terms.items()]
    if restitution < 1.0:
        named.append(f"contact.restitution = {restitution:g}")
    return [f"{' and '.join(named)} all set the viscous term; keep one of them"] if len(named) > 1 else []


def check_damping(contact: Damping, only_impact: bool, defaults: dict[str, float] | None = None) -> list[str]:
    """Contradictions among the viscous keys; `only_impact`: the scene knows the speed of its impact.

    `defaults` are values that a kind has by default and that a restitution replaces.
    """
    defaults = defaults or {}
    values = {name: getattr(contact, name, 0.0) for name in VISCOUS}
    terms = {name: value for name, value in values.items() if value not in (0.0, defaults.get(name))}
    problems = _one_viscous_term(terms, contact.restitution)
    steady = contact.damping_law == "steady"
    if contact.restitution < 1.0 and not steady and contact.restitution_speed == 0.0 and not only_impact:
        problems.append(
            "contact.restitution by contact.damping_law: hunt_crossley holds at one speed; give "
            "contact.restitution_speed above 0"
        )
    if steady and contact.restitution_speed > 0.0:
        problems.append(
            "contact.restitution_speed belongs to contact.damping_law: hunt_crossley; a steady restitution holds at "
            "every speed, so leave one of them out"
        )
    return problems


ALIASES = {"solver.tolerance": "wanted.tolerance", "solver.companion": "solver.check"}
"""Other names that stay accepted."""
FORMER_VALUES = {"solver.check": {"on": SECOND_RUN, True: SECOND_RUN, "off": NO_CHECK, False: NO_CHECK}}
"""Other values that stay accepted, by key."""
