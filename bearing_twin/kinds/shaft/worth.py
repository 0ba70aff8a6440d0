"""What half-spaces are off by in a shaft's contacts, as the balance of the shaft on both bearings takes it."""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.law_error import half_space_error
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import COORDINATES
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    Support,
    azimuths_of,
    spots_of,
    weighed_solver,
)
from bearing_twin.kinds.bearing.quasi_static.model_error import ALIKE, pushed_by
from bearing_twin.kinds.shaft.derived import bearing_scene
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene
from bearing_twin.kinds.shaft.statics import balance_of, rotor_of

SIZE = 2.0 / 3.0  # power of a load with which the square of a spot's semi-axis goes


class ShaftErrors(NamedTuple):
    """Shares by which a `contact` is off at the same approach, its `load` is, and the greatest load in balance is."""

    contact: float
    load: float
    balanced: float


class Wide(NamedTuple):
    """Of a bearing in balance: the `greatest` contact load [N], its `share` off by half-spaces, the part `kept`.

    What contacts share only moves a shaft whose loads are given; a preload by offsets keeps it.
    """

    greatest: float
    share: float
    kept: float

    def at(self, load: float) -> ShaftErrors:
        """What a contact under `load` [N] is off; its load keeps the whole share where it is not that in balance."""
        share = self.share * (load / self.greatest) ** SIZE if self.greatest else 0.0
        kept = self.kept if abs(load - self.greatest) <= ALIKE * load else 1.0
        return ShaftErrors(share, share * kept, self.share * self.kept)


def moved_ring(place: float, facing: float) -> np.ndarray:
    """The change (5, 5) of a bearing's ring in its own frame by the shaft's coordinates."""
    matrix = np.diag([1.0, 1.0, facing, facing, facing])
    matrix[0, 4], matrix[1, 3] = place, -place
    return matrix


class Moved(NamedTuple):
    """First-order changes of a shaft in balance: its `coordinates` (5,), forces (2, 3) of the bearings on it [N].

    `contacts` has (contacts, shares, changes of their loads [N]) (N, 2) of each bearing.
    """

    coordinates: np.ndarray
    forces: np.ndarray
    contacts: list[tuple]


def response_of(parameters: ShaftScene, law: str, speed: float, time: float, shares_at) -> Moved:
    """What contacts that are too stiff by shares of their load make of the balance at `time` [s].

    `shares_at(scene, contacts)` gives what each contact bears more than its law gives at the same approach. Raises
    SceneError where nothing carries the loads.
    """
    balance, found, loads = balance_of(parameters, law, speed, time), [], np.zeros(COORDINATES)
    seats = rotor_of(parameters, law).seats
    for side, seat, ring, contacts in zip(SIDES, seats, balance.rings, balance.contacts, strict=True):
        scene, turned = bearing_scene(parameters, side), moved_ring(seat.place, seat.facing)
        solver = weighed_solver(scene, seat.setting._replace(speed=speed), azimuths_of(len(contacts.load), seat.first))
        held = solver.solve(Support((False,) * COORDINATES, (0.0,) * COORDINATES, tuple(ring.tolist())))
        shares = shares_at(scene, contacts)
        pushed = pushed_by(solver, held, shares)
        loads += turned.T @ pushed.loads
        found.append((contacts, shares, pushed, turned))
    moved = -np.linalg.pinv(balance.stiffness) @ loads
    forces = [turned.T @ (pushed.loads + pushed.found.stiffness @ turned @ moved) for _, _, pushed, turned in found]
    changes = [(contacts, shares, pushed.contacts(turned @ moved)[0]) for contacts, shares, pushed, turned in found]
    return Moved(moved, -np.array(forces)[:, :3], changes)


def responses(parameters: ShaftScene, law: str, speed: float, time: float, shares_at) -> list[tuple]:
    """The `contacts` of `response_of`."""
    return response_of(parameters, law, speed, time, shares_at).contacts


@functools.lru_cache(maxsize=8)
def moved_by(
    parameters: ShaftScene, law: str, speed: float, time: float, shares: tuple[float, float], wide: bool
) -> dict[str, list[float]]:
    """By how much places and forces of a shaft are off, where all contacts of a bearing are off by such a share.

    With `wide`, and by what bodies are no half-spaces. By figure, in its unit and shape; raises as `response_of`.
    """
    left = iter(shares)  # bearings are asked for one after the other
    found = response_of(
        parameters, law, speed, time, lambda scene, contacts: next(left) + wide * _wide(scene, contacts)
    )
    place, tilt = np.split(np.abs(found.coordinates), [3])
    moved = {"displacement_m": place.tolist(), "tilt_rad": tilt.tolist()}
    return moved | {f"{side}_force_n": np.abs(force).tolist() for side, force in zip(SIDES, found.forces, strict=True)}


def _wide(scene, contacts) -> np.ndarray:
    return half_space_error(scene, spots_of(scene, contacts)[0])


@functools.lru_cache(maxsize=8)
def wide_of(parameters: ShaftScene, law: str, speed: float, time: float) -> dict[str, Wide]:
    """What half-spaces are off by in each bearing, in balance at `time` [s]; raises as `responses`."""
    found = {}
    for side, (contacts, shares, changes) in zip(SIDES, responses(parameters, law, speed, time, _wide), strict=True):
        off = np.abs(shares * contacts.load).max()
        kept = float(np.abs(changes).max() / off) if off > 0.0 else 1.0
        found[side] = Wide(float(contacts.load.max()), float(shares.max()), kept)
    return found
