"""Equilibria of balls that move, their axes of spin as in rolling, or settled with all friction.

Where axes have settled (`settled`) what a ball's motion does to it, and what friction does to the ring, are numbers
over its azimuth, with which the balls and the ring are in balance as at rest. A ring that is free stands elsewhere
then, and the motion there is looked for again until both agree.
"""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.names import AUTO
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.controls import SETTLED, SHARED
from bearing_twin.kinds.bearing.quasi_static.axes import settling_matters
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts
from bearing_twin.kinds.bearing.quasi_static.marched import March, marched
from bearing_twin.kinds.bearing.quasi_static.settled import LEAVING, OFF, Turn, no_turn, off_by, settled_turn
from bearing_twin.kinds.bearing.quasi_static.shares import begins_settled, control_of
from bearing_twin.kinds.bearing.quasi_static.statics import (
    Equilibrium,
    EquilibriumSolver,
    Support,
    azimuths_of,
    solver_of,
    support_of,
    weighed_solver,
)
from bearing_twin.kinds.bearing.quasi_static.surroundings import TAKEN, Acting, Surroundings
from bearing_twin.kinds.bearing.quasi_static.turn_table import (
    ALONG,
    HEAVY,
    HOLDING,
    INERTIA,
    NO_TABLE,
    ORBIT,
    PITCH,
    ROLL,
    SIZE,
    SIZES,
    SPEED,
    VISCOUS,
    add_ring_friction,
    friction_at,
    put_friction,
    put_settled,
    without_shares,
)

CHECKS = 32  # places of balls at which equilibria are held against balls that were moved
TWICE = 2  # solutions: friction acts along the contacts of the first
ROUNDS = 12  # in which a free ring and the motion of balls agree at the latest; 2 to 6 do
KEPT = 4  # scenes: who chooses a model, begins a run and tells what it is worth all ask for one
# Of the greatest load: the force by which the place of the ring may be off, with which they end, and after all of them.
AGREE, AGREED = 1e-5, 1e-4
NOTHING = 1e-11  # of the greatest load: friction that is less is what the search leaves of nothing
APART = 1e-6  # relative: changes that are less are rounding


class InMotion(NamedTuple):
    """An equilibrium, the table that it holds, and the balls' motion; why that has not settled is told."""

    found: Equilibrium
    table: np.ndarray
    turn: Turn


def table_of(parameters, setting, coordinates, turn: Turn) -> np.ndarray:
    """What a settled motion does to a ball (M, SIZES) at M azimuths, the ring at `coordinates` (5,)."""
    azimuths, table = azimuths_of(turn.looks, 0.0), np.zeros((turn.looks, SIZES))
    whole, orbit = turn.whole(azimuths)
    acting, pushed_on = _acting(parameters, setting, turn.standing(coordinates), azimuths, whole, orbit)
    angle = acting.contacts.angle
    for side, rubbing in enumerate(acting.friction):
        force = np.where(np.abs(rubbing) > NOTHING * acting.contacts.load.max(), rubbing, 0.0)
        pushed = force + acting.normal_of(side, acting.viscous[side])
        table[:, 2 * side], table[:, 2 * side + 1] = pushed[:, 0], pushed[:, 2]
        table[:, SIZE + side] = np.cos(angle[:, side]) * force[:, 2] - np.sin(angle[:, side]) * force[:, 0]
        table[:, ALONG + side], table[:, VISCOUS + side] = force[:, 1], acting.viscous[side]
    table[:, HEAVY] = setting.ball_mass * (setting.outer.locus_radius + whole[:, 0]) * orbit**2
    table[:, INERTIA : INERTIA + 2] = turn.inertia(setting.ball_mass, table[:, HEAVY], pushed_on, azimuths)
    table[:, ORBIT], table[:, ROLL], table[:, PITCH] = turn.orbit, turn.orbit - whole[:, 6], whole[:, 4]
    table[:, SPEED] = setting.speed
    table[:, HOLDING] = setting.lever * np.sin(angle[:, 0]) * table[:, ALONG]
    return table


def _acting(parameters, setting, rings, azimuths, whole, orbit) -> tuple[Acting, np.ndarray]:
    """What acts on a ball that goes round so, and the whole force (M, 3) [N] with its weight; `rings` as they stand."""
    parts, forces = [], np.zeros((len(azimuths), 3))
    for k, ring in enumerate(rings):
        there = slice(k, None, len(rings))
        around = Surroundings(parameters, setting, ring[:5], azimuths[there], parameters.gravity, ring[5:])
        parts.append(around.wrench(whole[there], orbit[there]))
        forces[there] = parts[-1].force() + around.weight
    return (parts[0] if len(parts) == 1 else _together(parts)), forces


def _together(parts: list[Acting]) -> Acting:
    """Of many rings, each at as many azimuths, in their order."""

    def joined(values):
        return np.stack(values, axis=1).reshape(-1, *values[0].shape[1:])

    normals, viscous, friction, moment, contacts = zip(*parts, strict=True)
    sided = ([joined(side) for side in zip(*one, strict=True)] for one in (normals, viscous, friction))
    return Acting(*sided, joined(moment), Contacts(*(joined(one) for one in zip(*contacts, strict=True))))


def rubbed(solver: EquilibriumSolver, support: Support, table: np.ndarray) -> Equilibrium:
    """The equilibrium with what this table holds. Raises SceneError as the solver does."""
    rows, on_ring = np.zeros((len(solver.azimuths), SIZES)), np.zeros(5)
    for k, azimuth in enumerate(solver.azimuths):
        friction_at(table, azimuth, k, rows)
    setting = without_shares(solver.setting)._replace(speed=0.0)
    for _ in range(TWICE):
        on_ring[:] = 0.0
        add_ring_friction(solver.setting, solver.directions, rows, on_ring)
        weights = solver.weights + rows[:, 0:2] + rows[:, 2:4] + rows[:, INERTIA : INERTIA + 2]
        rubbing = EquilibriumSolver(setting, solver.azimuths, weights)
        found = rubbing.solve(support._replace(loads=tuple((np.array(support.loads) - on_ring).tolist())))
        put_friction(found.contacts, rows)
        put_settled(found.contacts, rows)
    return found._replace(loads=found.loads + on_ring)


def in_motion(
    parameters, solver: EquilibriumSolver, support: Support, near: Turn | None = None, search: bool = True
) -> InMotion:
    """The equilibrium with what moving balls add, their axes as `model.control` says. Raises as the solver does.

    Left to itself, they have settled where that matters. A motion `near` the one that has settled is where that is
    looked for first; without `search`, as at a speed that only passes, shortly and next to it alone. Where there was
    none nearby none is looked for.
    """
    found = solver.solve(support)
    turn = near if near is not None and near.why else no_turn("")
    known = near is not None and len(near.motion)
    if not turn.why and (search or known) and _settles(parameters, solver, support, found):
        settled = _settled(parameters, solver, support, found, near if known else None, not search)
        if not settled.turn.why:
            return settled
        turn = settled.turn
    return InMotion(found._replace(apart=turn.apart), NO_TABLE, turn)


def _settles(parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> bool:
    """Whether axes are to have settled in an equilibrium, found with those of rolling."""
    control = control_of(parameters)
    return control == SETTLED or (control == AUTO and settling_matters(parameters, solver, support, found))


def _settled(
    parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium, turn, passing: bool
) -> InMotion:
    """As `in_motion`, with axes that have settled; with the reason where they do not."""
    setting, at, tried, near = solver.setting, found.coordinates, [], turn
    if turn is not None and turn.ring is not None:
        at = np.where(support.free, turn.ring, at)
    for tries in range(ROUNDS):
        turn = settled_turn(parameters, setting, at, turn if isinstance(turn, Turn) else None, passing=passing)
        if turn.why in LEAVING and not passing:
            return _marched(parameters, solver, support, found, near, turn.why)
        if turn.why:
            return InMotion(found, NO_TABLE, turn)
        table = table_of(parameters, setting, at, turn)
        try:
            found = rubbed(solver, support, table)
        except SceneError:
            return InMotion(found, NO_TABLE, no_turn("nothing carries the load once they have settled"))
        off = found.coordinates - at
        left = np.abs(found.stiffness @ off / solver.scales).max() / found.contacts.load.max()
        if left <= (AGREE if tries < ROUNDS - 1 else AGREED):
            return InMotion(found._replace(settled=off_by(turn)), table, turn._replace(ring=found.coordinates))
        tried.append((at * solver.scales, off * solver.scales))
        at = _next(*zip(*tried, strict=True)) / solver.scales
    return InMotion(found, NO_TABLE, no_turn("the ring and its balls do not agree on where they stand"))


def _marched(
    parameters, solver: EquilibriumSolver, support: Support, rolling: Equilibrium, near, leaves: str
) -> InMotion:
    """As `_settled`, where a ball `leaves` a raceway on its way; `near` may be the motion itself."""
    turn = near
    if not isinstance(near, March) or near.given != (solver.setting.speed, support):
        turn = marched(parameters, solver.setting, support, rolling)
    if turn is None:
        return InMotion(rolling, NO_TABLE, no_turn(leaves))
    if turn.why:
        off = _off_by(parameters, solver, support, turn)
        return InMotion(rolling, NO_TABLE, no_turn(f"{leaves}, and {turn.why}", off))
    try:
        if turn.table is None:
            table = table_of(parameters, solver.setting, rolling.coordinates, turn)
            off = max(OFF, _off_by(parameters, solver, support, turn, table))
            turn = turn._replace(table=table, off=off)
        found = rubbed(solver, support, turn.table)
    except SceneError:
        return InMotion(rolling, NO_TABLE, no_turn("nothing carries the load once they have settled"))
    return InMotion(found._replace(settled=turn.off), turn.table, turn._replace(ring=found.coordinates))


def _off_by(parameters, solver: EquilibriumSolver, support: Support, turn: March, table=None) -> float:
    """What loads of equilibria are off those of the balls that were moved, over the greatest.

    Of equilibria with this table, or with axes of rolling.
    """
    balls, off = parameters.geometry.balls, 0.0
    passed = len(turn.motion) // balls
    azimuths = azimuths_of(len(turn.motion), 0.0)
    for first in range(0, passed, max(1, passed // CHECKS)):
        there = slice(first, None, passed)
        weighed = weighed_solver(parameters, solver.setting, azimuths[there])
        found = weighed.solve(support) if table is None else rubbed(weighed, support, table)
        off = max(off, float(np.abs(found.contacts.load - turn.loads[there]).max() / turn.loads.max()))
    return off


def _next(places, offs) -> np.ndarray:
    """Where the ring is to be tried next, after some places (5,) and by how much each was off (Anderson's method).

    Taken one after another the places may lead away: friction along the grooves answers a ring beside the axis across.
    """
    place, off = places[-1], offs[-1]
    if len(offs) == 1:
        return place + off
    moved, changed = np.diff(places, axis=0).T, np.diff(offs, axis=0).T
    return place + off - (moved + changed) @ np.linalg.lstsq(changed, off, rcond=APART)[0]


@functools.lru_cache(KEPT)
def scene_in_motion(parameters, law: str) -> InMotion:
    """`in_motion` as the scene loads its ring or holds it, kept, with what it has `taken`; raises SceneError."""
    before = TAKEN.evaluations
    found = in_motion(parameters, solver_of(parameters, law), support_of(parameters))
    return found._replace(turn=found.turn._replace(taken=TAKEN.evaluations - before))


def turn_of_scene(parameters, law: str) -> Turn | None:
    """The settled motion in which a scene begins, from which those nearby are found, or why it is none.

    None where axes are those of rolling there, or nothing carries the load.
    """
    if not begins_settled(parameters):
        return None
    try:
        turn = scene_in_motion(parameters, law).turn
    except SceneError:
        return None
    return turn if turn.why or len(turn.motion) else None


def as_in_run(parameters, law: str, solver: EquilibriumSolver, support: Support) -> Equilibrium:
    """The equilibrium with axes of spin as in a run of the scene, from where that begins; raises SceneError."""
    return in_motion(parameters, solver, support, turn_of_scene(parameters, law), begins_settled(parameters)).found


def control_found(parameters, turn: Turn) -> str:
    """What the axes of spin of an equilibrium with this motion are, a word of `model.control` other than `auto`."""
    if len(turn.motion):
        return SETTLED
    control = control_of(parameters)
    return SHARED if control in (AUTO, SETTLED) else control


def rolling_still(turn: Turn) -> str:
    """That axes were asked to have settled and have not, and why; "" where they have."""
    return f"model.control = settled: balls have the axes of spin of rolling, because {turn.why}" if turn.why else ""


def solved_in_motion(parameters, solver: EquilibriumSolver, support: Support) -> Equilibrium:
    """The equilibrium (as by the solver) with what moving balls add to it, where there is any.

    Its stiffness is that of the balance, what they add being what it is. Raises SceneError as the solver does.
    """
    return in_motion(parameters, solver, support).found
