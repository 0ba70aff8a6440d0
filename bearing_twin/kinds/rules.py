"""The rules by which models and methods are chosen, and ranges of validity of models: tables for all kinds of scenes.

A key that a scene leaves open (`auto`, 0 or left out) is answered by the first row of that key whose condition holds; a
value that the scene gives is kept. `bearing_twin scenes --rules` lists the table, `choice_reason` of a run has the
sentences of the rows that applied, and `bearing_twin chart choice` holds the choices against cheaper and dearer models.
Nothing is measured, predicted or changed while a scene runs.

A range is of a model and a number of the scene known before the run, which a kind gives among the `facts` of its
parameters. What shows only in the run, as a pressure beyond yield, is a flag of the run. Models without a row have no
range that is known: `linear` and `measured` are the user's own numbers, exact Hertz holds for every ellipse, and
steppers refuse steps beyond their limits themselves.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from bearing_twin.base.errors import SceneError
from bearing_twin.base.units import with_unit
from bearing_twin.contact.friction import AUTO
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.validity import LAW_TOLERANCE
from bearing_twin.kinds.contract import lazy_import
from bearing_twin.kinds.error_estimates import LARGE
from bearing_twin.methods import COUPLED

BEARING, SHAFT, SPHERES, DISCS = "bearing", "shaft", "two_spheres", "two_discs"
BEAM, ELLIPSOID, BODIES, SOFT = "sphere_on_beam", "ellipsoid_on_plane", "two_bodies", "soft_discs"
FACTS = "bearing_twin.kinds.bearing.models"  # where conditions of a bearing are
SETTING = "tolerance of the steps"  # what the stepper is given, by wanted.tolerance


def always(parameters) -> bool:
    """True: the condition of a row that is the last of its key."""
    return True


class Rule(NamedTuple):
    """A row: in scenes of `kinds`, `key` is `choice` if `when`, since `why`.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of scenes.
    key : str
        The key of the scene that is answered, or `SETTING`.
    choice : str
        The value, or words for one that is computed.
    when : str
        The condition in words; "" where no other row holds.
    why : str
        The sentence that a report gives as the reason.
    holds : callable
        The condition, a function of the scene's parameters.
    value : callable or None
        The value as a function of the parameters, where it is computed.
    example : tuple of str
        A shipped scene, and what differs from it, to which the row applies.
    """

    kinds: tuple[str, ...]
    key: str
    choice: str
    when: str
    why: str
    holds: Callable[[Any], bool] = always
    value: Callable[[Any], Any] | None = None
    example: tuple[str, ...] = ()

    def sentence(self, value) -> str:
        """The choice with its reason."""
        return f"{_named(self.key)}{f'{value:g}' if isinstance(value, float) else value}, {self.why}"


class Answer(NamedTuple):
    """The value of a key, the sentence that says why, and the row; None where the scene itself gives the value."""

    value: Any
    sentence: str
    rule: Rule | None


NAMED_BY_VALUE = "contact.normal", "model.dimension", "solver.stepper"
WORDS = {  # of a key in sentences, before its value
    "contact.friction": "friction",
    "cage.kind": "cage",
    "contact.tracking": "contact points",
    "beam.theory": "beam theory",
    "mesh.divisions": "divisions",
    "solver.modes": "highest mode",
    "solver.steps": "steps a contact",
}
RESOLVED = "cage.kind", "mesh.divisions"  # answered when a scene is read: the scene then holds the answer


def _looser(tolerance: float) -> Callable[[Any], bool]:
    return lambda scene: scene.wanted.tolerance >= tolerance


def _times(share: float) -> Callable[[Any], float]:
    return lambda scene: float(f"{min(max(share * scene.wanted.tolerance, LEAST_SETTING), GREATEST_SETTING):.3g}")


LEAST_SETTING, GREATEST_SETTING = 1e-9, 0.1  # of a step: below, steps are rejected for rounding; above, none was tried
HERTZ = "because it is exact to 1e-10, and no law that follows the curvatures costs less"
RODAS4 = "because it is L-stable and of order 4: accuracy alone limits its steps, not the stiffness of the contacts"
DOP853 = "because it is explicit and of order 8, and its steps follow the contact's own time"

RULES = (
    # Elastic law
    Rule(
        (BODIES,), "contact.normal", "overlap", "a body is a superellipsoid",
        "because a superellipsoid has flat places, where no contact is an ellipse",
        lambda scene: "superellipsoid" in (scene.first.shape, scene.second.shape),
        example=("two_bodies_superellipsoid",),
    ),
    Rule(
        (SPHERES,), "contact.normal", "measured", "contact.measured_alpha is given",
        "because the scene gives the coefficient that was measured",
        lazy_import("bearing_twin.kinds.bodies.derived:is_measured"),
        example=("two_spheres", "contact.measured_alpha=2e-5"),
    ),
    Rule(
        (DISCS,), "contact.normal", "johnson", "",
        "because thick, slow discs follow Johnson's line contact to 4 %", example=("two_discs", "contact.normal=auto"),
    ),
    Rule((BEARING, SHAFT, SPHERES, ELLIPSOID, BODIES), "contact.normal", "hertz", "", HERTZ, example=("bearing_6203",)),
    # Dimension and cage of a bearing
    Rule(
        (BEARING,), "model.dimension", "free", "a torque turns the shaft and the inner ring follows loads",
        "because a torque turns the ring under a load: it moves with its mass, in one step with all balls",
        lazy_import(f"{FACTS}:is_torque_driven_under_load"), example=("bearing_6203_run_up", "model.dimension=auto"),
    ),
    Rule(
        (BEARING,), "model.dimension", "free",
        "the ring follows loads, has mass and a cage, and loads alone are wanted",
        "because equilibria of a ring with mass have errors of load up to 1.4 % at an instant: it moves with its mass",
        lazy_import(f"{FACTS}:moves_for_loads_alone"),
        example=("bearing_6203_rig_400N", "model.dimension=auto", "wanted.outputs=loads"),
    ),
    Rule(
        (BEARING,), "model.dimension", "quasi_static", "the inner ring follows loads or is tilted",
        "because the inner ring is loaded or tilted: every output is an equilibrium with evenly spaced balls; friction "
        "torque, skidding and ringing are not in it",
        lazy_import(f"{FACTS}:is_in_equilibrium"), example=("bearing_218_thrust",),
    ),
    Rule(
        (BEARING,), "model.dimension", "prescribed", "",
        "because the drive holds the inner ring: balls move, and friction torque, slip and losses are computed",
        example=("bearing_6203",),
    ),
    Rule(
        (BEARING,), "cage.kind", "none", f"a cage is wanted, and solver.stepper is another than {' or '.join(COUPLED)}",
        "because solver.stepper moves balls without a cage, although they have clearance; "
        f"{' or '.join(COUPLED)} moves one",
        lazy_import(f"{FACTS}:cannot_move_cage"), example=("bearing_6203_loose", "solver.stepper=imex"),
    ),
    Rule(
        (BEARING,), "cage.kind", "even", "balls that move leave a raceway on their way round, or the ring has mass",
        "because balls with clearance bunch up without a cage, and orbit up to 9 % slower than rolling",
        lazy_import(f"{FACTS}:needs_cage"), example=("bearing_6203_loose",),
    ),
    Rule((BEARING,), "cage.kind", "none", "", "because every ball carries load all its way", example=("bearing_6203",)),
    # Friction of a bearing
    Rule(
        (BEARING,), "contact.friction", "point", "no friction is computed or wanted",
        "because no friction is computed (equilibria, a coefficient of 0) or wanted (loads alone)",
        lazy_import(f"{FACTS}:is_without_friction"),
        example=("bearing_6203", "contact.friction=auto", "wanted.outputs=loads"),
    ),
    Rule(
        (BEARING,), "contact.friction", "point", "the narrowest contact has b/a below 0.03",
        "because the error of friction over narrower contact patches is not known",
        lazy_import(f"{FACTS}:is_too_narrow"),
        example=("bearing_6203", "contact.friction=auto", "geometry.inner_conformity=0.502"),
    ),
    Rule(
        (BEARING,), "contact.friction", "point", "wanted.tolerance is 5 % or more",
        "because the torque of spin, 3/8 mu N a E, is at most about 5 % of mu N R",
        _looser(0.05), example=("bearing_6203", "contact.friction=auto", "wanted.tolerance=0.05"),
    ),
    Rule(
        (BEARING,), "contact.friction", "point", "nothing acts along the axis or tilts the inner ring",
        "because no contact has an angle, so that none spins",
        lazy_import(f"{FACTS}:no_contact_spins"), example=("bearing_6203_greased",),
    ),
    Rule(
        (BEARING,), "contact.friction", "spot",
        "spin is slow at the rim of the contact patch, the tolerance is 3 %, or there is a lubricant",
        "because 6 x 16 points over the contact patch are exact where spin is slow at its rim, and to 3 % elsewhere; "
        "friction on a film is known less well",
        lazy_import(f"{FACTS}:spins_slowly"), example=("bearing_6203", "contact.friction=auto"),
    ),
    Rule(
        (BEARING,), "contact.friction", "spot_medium", "wanted.tolerance is 1 % or more",
        "because 12 x 32 points over the contact patch are exact to 1 % where spin is fast",
        _looser(0.01), example=("bearing_6203_fast", "contact.friction=auto", "wanted.tolerance=0.01"),
    ),
    Rule(
        (BEARING,), "contact.friction", "spot_fine", "",
        "because spin is fast at the rim of the contact patch, and the tolerance asks for 24 x 96 points",
        example=("bearing_6203_fast", "contact.friction=auto"),
    ),
    # Stepper
    Rule((BEARING, SHAFT), "solver.stepper", "rodas4", "", RODAS4, example=("bearing_6203",)),
    Rule(
        (SPHERES,), "solver.stepper", "closed_form", "the contact is elastic, or peaks alone are wanted",
        "because contact time and peak force follow from a quadrature that is exact to 1e-12",
        lazy_import("bearing_twin.kinds.bodies.derived:spheres_closed"), example=("two_spheres",),
    ),
    Rule(
        (DISCS,), "solver.stepper", "closed_form", "peaks alone are wanted, or the tolerance is 1e-6 or more",
        "because contact time and peak force follow from a quadrature exact to 1e-12, and the force over time to 1e-7",
        lambda scene: scene.wanted.outputs == "peaks" or scene.wanted.tolerance >= 1e-6,
        example=("two_discs", "wanted.outputs=peaks"),
    ),
    Rule(
        (SPHERES, DISCS, ELLIPSOID, BODIES), "solver.stepper", "dop853", "", DOP853, example=("ellipsoid_on_plane",),
    ),
    Rule(
        (BEAM,), "solver.stepper", "modes", "",
        "because cubic forces between steps reach the tolerance in steps that do not follow the highest mode",
        example=("sphere_on_beam",),
    ),
    Rule(
        (SOFT,), "solver.stepper", "central_differences", "",
        "because it is explicit and conserves energy, and its steps resolve the waves in the disc",
        example=("soft_discs_mean",),
    ),
    # How a requested tolerance becomes a setting, a mesh, modes and steps
    Rule(
        (BEARING,), SETTING, "wanted.tolerance", "balls collide with the pockets of a cage",
        "because an error grows with every impact on a pocket, so that a smaller one is met for hardly longer",
        lazy_import(f"{FACTS}:balls_hit_pockets"), _times(1.0), ("bearing_6203_guided_cage",),
    ),
    Rule(
        (BEARING,), SETTING, "wanted.tolerance / 500", "a torque turns the shaft, so that it may be slow",
        "because balls that carry nothing hop between the raceways while the shaft is slow, and where they land "
        "depends on every step before",
        lazy_import(f"{FACTS}:balls_may_hop"), _times(0.002), ("bearing_6203_run_up",),
    ),
    Rule(
        (BEARING,), SETTING, "wanted.tolerance / 10",
        "balls cross waves or spalls, or leave the load zone of a ring with an axial load or a moment",
        "because balls that touch one raceway alone bounce there and slide, and every bounce adds an error, so that "
        "the tolerance is met for up to 1.6 times the time",
        lazy_import(f"{FACTS}:light_balls_slide"), _times(0.1), ("bearing_6205_spall_inner",),
    ),
    Rule(
        (BEARING,), SETTING, "wanted.tolerance / 5",
        "contacts ring: a sudden change, unbalance, or little damping",
        "because contacts ring after a sudden change, and little stops them, so that the errors of many steps add up",
        lazy_import(f"{FACTS}:contacts_vibrate"), _times(0.2), ("bearing_6203_sudden",),
    ),
    Rule(
        (BEARING,), SETTING, "20 wanted.tolerance", "every ball rolls from the start under a steady load",
        "because the error of balls that roll under a steady load is far below the tolerance of a step",
        lazy_import(f"{FACTS}:rolls_steadily"), _times(20.0), ("bearing_6203",),
    ),
    Rule(
        (BEARING,), SETTING, "wanted.tolerance / 2", "",
        "because the errors of steps add up while loads change round the bearing",
        value=_times(0.5), example=("bearing_6203_rig_400N",),
    ),
    Rule(
        (SOFT,), "mesh.divisions", "by the order of convergence", "",
        "because the error of the force falls with the divisions, and grows with the stiffness of the penalty",
        value=lazy_import("bearing_twin.kinds.soft_discs.derived:divisions_of"), example=("soft_discs_mean",),
    ),
    Rule(
        (BEAM,), "beam.theory", "timoshenko", "",
        "because it knows shear and rotary inertia, which change peaks of short contacts and all later ones",
        example=("sphere_on_beam_drop_50mm", "beam.theory=auto"),
    ),
    Rule(
        (BEAM,), "solver.modes", "by the contact time", "",
        "because modes whose period is short against the contact answer it as static bending does",
        value=lazy_import("bearing_twin.kinds.beam.motion:modes_for"), example=("sphere_on_beam",),
    ),
    Rule(
        (BEAM,), "solver.steps", "by the order of the force", "",
        "because the error falls with the fourth power of the steps",
        value=lazy_import("bearing_twin.kinds.beam.motion:steps_of"), example=("sphere_on_beam",),
    ),
    Rule(
        (BODIES,), "contact.tracking", "closed", "a closed form gives the opposing points of both shapes",
        "because it is exact and needs no iteration",
        lazy_import("bearing_twin.kinds.bodies.derived:has_closed_form"), example=("two_bodies_groove",),
    ),
    Rule(
        (BODIES,), "contact.tracking", "algebraic", "",
        "because Newton's method finds the opposing points at every step, so that no error accumulates",
        example=(
            "two_bodies_ellipsoid", "second.shape=ellipsoid", "second.semi_axes=2cm,2cm,2cm",
            "second.position=0,0,-2cm",
        ),
    ),
)  # fmt: skip
"""Every rule, the first that holds deciding; at most 40."""


def pick(kind: str, key: str, parameters, specified=AUTO) -> Answer:
    """The answer to one key of a scene.

    Parameters
    ----------
    kind : str
        Kind of the scene.
    key : str
        The key, as in `Rule.key`.
    parameters : object
        The parameters of the scene, of its kind's own type.
    specified
        The value in the scene; `auto`, 0 and "" leave it open.

    Raises
    ------
    SceneError
        Where a condition needs an equilibrium, and the bearing has none.
    """
    if specified in (AUTO, 0, "") or key in RESOLVED:
        for row in RULES:
            if kind in row.kinds and key == row.key and row.holds(parameters):
                value = row.choice if row.value is None else row.value(parameters)
                if specified in (AUTO, 0, "", value):
                    return Answer(value, row.sentence(value), row)
                break
    return Answer(specified, f"{_named(key)}{specified}, as specified", None)


def answers(kind: str, parameters) -> dict[str, Answer]:
    """The answers to all keys that rules of a kind are about, by key."""
    keys = dict.fromkeys(row.key for row in RULES if kind in row.kinds)
    return {key: pick(kind, key, parameters, _at(parameters, key)) for key in keys}


def sentences(chosen: dict[str, Answer]) -> str:
    """The reasons of answers, as a report has them."""
    return "; ".join(answer.sentence for answer in chosen.values())


def _named(key: str) -> str:
    return "" if key in NAMED_BY_VALUE else f"{WORDS.get(key, key)} "


def _at(parameters, key: str, missing=AUTO):
    """Value of a key of the scene; `missing` where it has no such key."""
    for word in key.split("."):
        parameters = getattr(parameters, word, missing)
    return parameters


# Ranges of validity

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


def facts_at(*functions: str) -> dict[str, Callable[[Any], float | None]]:
    """Facts by name: functions of the parameters at "module:name", imported at their first use."""
    return {function.partition(":")[2]: lazy_import(function) for function in functions}


def least_of(key: str, fact: str) -> float:
    """The least value of a fact down to which models of a key hold."""
    return next(row.least for row in RANGES if (row.key, row.fact) == (key, fact))


def allowed(parameters) -> bool:
    """True if the scene lets models run outside their ranges."""
    return _at(parameters, "solver.allow_invalid", None) == ON


def left_by(parameters, only: tuple[str, str] | None = None) -> tuple[str, ...]:
    """One sentence for each range that a specified model leaves; a fact that is None, or has no value, leaves none.

    With `only`, a key and a model, those of this model that a rule has chosen.
    """
    facts, sentences = parameters.facts, []
    for row in RANGES:
        model = _at(parameters, row.key, None)
        if only is not None:
            model = only[1] if row.key == only[0] else ""
        if row.fact not in facts or model not in row.models:
            continue
        try:
            value = facts[row.fact](parameters)
        except SceneError:  # a scene that has no start is refused where its model is chosen
            continue
        if value is not None and not row.least <= value <= row.greatest:
            sentences.append(row.left(model, value))
    return tuple(sentences)


# Warnings that a choice says, alike in several kinds


def drift(law: str) -> list[str]:
    """A warning of a law that carries a state whose errors add up, or none; names that are no law's have none."""
    if law not in LAWS or not LAWS[law].carries or LAWS[law].keeps:
        return []
    return [f"nothing pulls the errors of {law} back; contact.normal: hertz_differential does"]


LEAST_SHARE = 0.25  # tuned: a hollow sphere with a wall of a tenth of its radius has 0.27 of the solid one's mass
MOST_SHARE = 4.0  # tuned: with another body attached, as a hammer's head


def odd_mass(key: str, mass: float, homogeneous: float) -> list[str]:
    """A warning of a given mass [kg] that size and density contradict, by which a homogeneous body has `whole`."""
    if not mass or LEAST_SHARE * homogeneous <= mass <= MOST_SHARE * homogeneous:
        return []
    return [
        f"{key} = {mass:.4g} kg is {mass / homogeneous:.2g} times the {homogeneous:.4g} kg that size and density give; "
        f"check all three, or leave {key} out"
    ]


def idle_step(step: float, stepper: str, fixed: tuple[str, ...]) -> list[str]:
    """Warning of a specified `step` [s] without effect, where the stepper is none of those with `fixed` steps."""
    if not step or stepper in fixed:
        return []
    return [f"solver.step does nothing with {stepper}; solver.stepper: {fixed[0]} takes it"]
