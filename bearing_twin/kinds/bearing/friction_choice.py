"""Which friction model a bearing's scene needs, `contact.friction: auto`: by what its spots would resist spin with.

Force and torque of each contact are to be as exact as is wanted, at the contacts of balls that roll in balance. `point`
is asked there what it lacks, and where balls slide at first also at a slip as fast as the spots' ends spin. What sums
over spots, and closed forms, err by is measured by the spots' shape and spin, and holds whatever the slip
(`spot_errors`): so a finer rule of points is taken where the tolerance asks for it.
"""

import dataclasses
import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.ellipse import elliptic_b_d
from bearing_twin.contact.friction import FRICTIONS, FrictionModel, roughness
from bearing_twin.contact.names import AUTO, POINT
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.facts import axis_ratio
from bearing_twin.kinds.bearing.measured import as_cheap, friction_costs
from bearing_twin.kinds.bearing.outputs import ellipses, moduli
from bearing_twin.kinds.bearing.parameters import LOADS, BearingScene, rubbing_by
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import Contacts
from bearing_twin.kinds.bearing.quasi_static.equilibrium import solver_of, weighed_support
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, dimension_of, spots_built
from bearing_twin.kinds.bearing.spot_errors import greatest_error
from bearing_twin.kinds.ranges import RANGES
from bearing_twin.report import Choice

FINEST = "spot_fine"
KEPT = 64  # scenes whose choice is remembered
NARROWEST = next(one.least for one in RANGES if one.key == "contact.friction")


class Weighed(NamedTuple):
    """A friction model, its cost over that of `point`, and its `error`: force over mu N, torque over mu N R."""

    model: FrictionModel
    cost: float
    error: float


class Chosen(NamedTuple):
    """The friction model of a scene and why."""

    name: str
    reason: str


def as_chosen(parameters: BearingScene, choice: Choice | None = None) -> BearingScene:
    """The scene with a friction model in the place of `auto`: that which `choice` names, if any, else as chosen now."""
    if parameters.contact.friction != AUTO:
        return parameters
    named = choice is not None and choice.friction in FRICTIONS  # a log may say anything
    name = choice.friction if named else chosen_friction(parameters).name
    return _rubbing_kept(parameters, name)


_rubbing_kept = functools.lru_cache(KEPT)(rubbing_by)  # one scene for all who ask: a copy of a run's writers shares it


@functools.lru_cache(KEPT)
def chosen_friction(parameters: BearingScene) -> Chosen:
    """The cheapest friction model that is adequate for a scene, else the most exact, and why.

    Of those `as_cheap` the first in the table of friction models is taken.
    """
    why = _no_spots(parameters)
    if why:
        return Chosen(POINT, f"friction at a point, because {why}")
    try:
        rows = _weighed(parameters)
    except SceneError:  # of a bearing without balance: what runs it says why
        return Chosen(POINT, "friction at a point, because the bearing finds no balance to judge others in")
    wanted = parameters.wanted.tolerance
    first, *_ = as_cheap([one for one in rows if one.error <= wanted]) or [min(rows, key=lambda one: one.error)]
    why = f"the cheapest within the wanted {wanted:g}"
    if first.model.name == FINEST:
        why = f"because no other is within the wanted {wanted:g}"
    if first.error > wanted:
        why = f"because none is within the wanted {wanted:g}"
    reason = f"friction {first.model.name}, {why}: {told_off(first)}"
    closer = [one for one in rows if one.error < first.error and one.cost > first.cost]
    cheaper = [one for one in rows if one.cost < first.cost and one.error > wanted]
    if cheaper:
        best = min(cheaper, key=lambda one: one.error)
        reason += f"; {best.model.name} would be off by {best.error:.2g}"
    if closer:
        best = min(closer, key=lambda one: one.cost)
        reason += f"; {best.model.name} would cost {best.cost / first.cost:.2g} times as much"
    return Chosen(first.model.name, reason)


def told_off(one: Weighed) -> str:
    """What a friction model errs by, in words."""
    most, slip = ("at most ", ", whatever its slip") if one.model.over_spot else ("", "")
    return f"off by {most}{one.error:.2g} of mu N, or mu N R of a ball, in a contact{slip}"


def of_pinned(parameters: BearingScene) -> tuple[str, list[str]]:
    """What a friction model over spots that the scene asks for errs by, in words, and warnings of it.

    Nothing is told where spots are not looked at, or the bearing finds no balance.
    """
    contact, wanted = parameters.contact, parameters.wanted
    model = FRICTIONS[contact.friction]
    left = dataclasses.replace(parameters, contact=dataclasses.replace(contact, friction=AUTO))
    if not model.over_spot or _no_spots(left):
        return "", roughness(model)
    try:
        rows = {one.model.name: one for one in _weighed(left)}
    except SceneError:
        return "", roughness(model)
    mine = rows[model.name]
    if mine.error <= wanted.tolerance:
        return told_off(mine), []
    warning = f"contact.friction = {model.name} is {told_off(mine)}, more than the wanted {wanted.tolerance:g}"
    other = rows[chosen_friction(left).name]
    if other.error < mine.error:
        warning += f"; auto takes {other.model.name}, off by at most {other.error:.2g}"
    return told_off(mine), [warning]


def _no_spots(parameters) -> str:
    """Why friction over spots is not looked at."""
    if parameters.wanted.outputs == LOADS:
        return "loads alone are wanted"
    if dimension_of(parameters) == QUASI_STATIC:
        return "equilibria hold no friction"
    if not parameters.contact.friction_coefficient:
        return "contact.friction_coefficient is 0"
    if not spots_built(parameters):
        return "no other is built for a ring that tilts or moves"
    if axis_ratio(parameters) < NARROWEST:
        return f"errors over spots narrower than b/a = {NARROWEST:g} are not known"
    return ""


def _weighed(parameters) -> list[Weighed]:
    """The friction models, in the order of their table; the finest is what `point` is off from."""
    costs, errors = friction_costs(parameters), dict.fromkeys(FRICTIONS, 0.0)
    contact, radius = parameters.contact, 0.5 * parameters.geometry.ball_diameter
    for load, major, minor, slip, spin in _met(parameters):
        given = (load, major, minor, *slip, spin, contact.friction_coefficient, contact.friction_regularisation)
        limit = contact.friction_coefficient * load * np.array([1.0, 1.0, radius])
        finest, ratio = np.array(FRICTIONS[FINEST].rubbing(*given)), minor / major
        b, d = elliptic_b_d(ratio)
        pure = 0.375 * (b + ratio * ratio * d) * major / radius  # torque of pure spin over mu N R
        for name, model in FRICTIONS.items():
            if model.over_spot:
                off = greatest_error(name, ratio, spin * major / contact.friction_regularisation)
                error = max(off.force, pure * off.torque)
            else:
                error = float(np.abs((np.array(model.rubbing(*given)) - finest) / limit).max())
            errors[name] = max(errors[name], error)
    return [Weighed(model, costs[name], errors[name]) for name, model in FRICTIONS.items()]


def _met(parameters):
    """Load [N], semi-axes [m], slip (2,) along them [m/s] and spin [rad/s] of the contacts friction is judged in."""
    contact = parameters.contact
    law = "hertz_exact" if contact.normal == AUTO else contact.normal
    for scene in _settings(parameters):
        contacts = solver_of(scene, law).solve(weighed_support(scene)).contacts
        curvatures, spins = (contacts.curvature_small, contacts.curvature_large), _spins(contacts, scene.drive.speed)
        major, minor, _ = ellipses(moduli(scene.materials), *curvatures, contacts.load)
        slides = scene.initial.motion == "rest" or scene.drive.change.time
        rows = {
            (load, a, b, spin)
            for one in zip(contacts.load, major, minor, spins, strict=True)
            for load, a, b, spin in zip(*map(np.ndarray.tolist, one), strict=True)
            if load > 0.0
        }
        for load, a, b, spin in rows:
            for slip in ((0.0, 0.0), (spin * a, 0.0), (0.0, spin * a)) if slides else ((0.0, 0.0),):
                yield load, a, b, slip, spin


def _spins(contacts: Contacts, speed: float) -> np.ndarray:
    """Spin (N, 2) of a ball against each raceway about the normal [rad/s], where one of them takes all of it."""
    turning = np.stack([speed - contacts.orbit, -contacts.orbit], axis=1) + contacts.roll[:, None]
    return np.abs(turning * np.sin(contacts.angle) - contacts.pitch[:, None] * np.cos(contacts.angle))


def _settings(parameters):
    """The scene as it starts, and as its drive's change leaves it."""
    drive = parameters.drive
    yield parameters
    if drive.change.time:
        changed = dataclasses.replace(drive, offset=drive.changed_offset, speed=drive.speed + drive.change.speed)
        yield dataclasses.replace(parameters, drive=changed)
