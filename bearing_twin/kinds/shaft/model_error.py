"""The model errors of a shaft on two bearings, and how its second run is made and compared.

What half-spaces err by in contacts is taken as the equilibrium of the shaft on both bearings answers to it.
"""

import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.sample import Block
from bearing_twin.kinds.bearing.equilibrium import (
    COORDINATES,
    Support,
    azimuths_of,
    equilibrium_error,
    spots_of,
    weighed_solver,
)
from bearing_twin.kinds.bearing.model_error import ALIKE, half_space_error, pushed_by
from bearing_twin.kinds.error_estimates import HERTZ_MENDS, LEFT_OUT, Comparison, Errors, ModelErrors, with_tolerance
from bearing_twin.kinds.shaft.course import speeds_of
from bearing_twin.kinds.shaft.derived import bearing_scene
from bearing_twin.kinds.shaft.equilibrium import balance_of, rotor_of
from bearing_twin.kinds.shaft.figures import LIVES
from bearing_twin.kinds.shaft.models import law_error, shares_of
from bearing_twin.kinds.shaft.motion import FINEST, SETTING
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene

LOADS = {"greatest_ball_load_n": 1.0, "peak_pressure_pa": 1.0 / 3.0}  # figures that go with this power of a load
LIFE = 3.0  # a life goes with the load to the power -3
MODES = "natural_frequencies_hz", "critical_speeds_rad_s"
LIGHT = 1.0 / 6.0  # of balls' mass over the shaft's, by which modes are too high without it: balls go half as far
RANGES = "displacement_range_m", "tilt_range_rad", *(f"{side}_force_range_n" for side in SIDES)
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
        scene, turned = bearing_scene(parameters, side), seat.turned
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


class ShaftComparison(Comparison):
    """Loads of all balls over the greatest."""

    exact = (*Comparison.exact, "shaft_speed_at_end_rad_s", "forward_shares", *MODES)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self.outputs = {"ball_loads": "of any contact at any output, over the greatest load"}

    def refined(self):
        """A fraction of the tolerance, and twice the least steps a turn."""
        parameters, choice = with_tolerance(self.parameters, self.choice, FINEST / SETTING)
        return parameters, choice._replace(finer=2.0 * choice.finer)

    def differences(self, own: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of the loads of both bearings."""
        names = [f"{side}_normal_load" for side in SIDES]
        apart = [np.abs(own[name] - second[name]).max(axis=(1, 2)) for name in names]
        sizes = [own[name].max(axis=(1, 2)) for name in names]
        return {"ball_loads": (np.maximum(*apart), np.maximum(*sizes))}


class ShaftDoubt(ModelErrors):
    """The law against exact Hertz; equilibria against balls that move."""

    outputs = ("ball_loads",)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._fastest = 0.0  # rad/s, of the outputs so far: a command may go beyond the scene's speeds

    def add(self, block: Block) -> None:
        """Takes a block in."""
        super().add(block)
        self._fastest = max(self._fastest, float(np.abs(block.values["shaft_speed"]).max(initial=0.0)))

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """Of vectors for each number; lives in hours err as those in turns do."""
        errors = super().errors(figures)
        for key in errors.figures.keys() & figures.keys():
            of, value = errors.figures[key], figures[key]
            if isinstance(value, list):
                of |= {source: [one] * len(value) for source, one in of.items() if not isinstance(one, list)}
        for side in SIDES:
            for turns, hours in ((f"{side}_{life}_mrev", f"{side}_{life}_h") for life in LIVES):
                if hours in figures and turns in errors.figures and math.isfinite(figures[turns]):
                    slow = figures[hours] / figures[turns]
                    errors.figures[hours] = {source: slow * one for source, one in errors.figures[turns].items()}
        return errors

    def _shares(self) -> dict[str, float]:
        """As `shares_of`; none where the scene's own loads are not carried at the speed that was commanded."""
        try:
            return shares_of(self.parameters, self.choice.law, self._fastest)
        except SceneError:
            return {}

    def _of_loads(self, figures: Mapping[str, Any], shares: Mapping[str, float]) -> dict[str, float]:
        return {
            f"{side}_{key}": power * shares[side] * abs(figures[f"{side}_{key}"])
            for side in SIDES
            for key, power in LOADS.items()
        }

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """At most what the coefficient of a contact is off by: as of rings that are held; places as they answer."""
        share = law_error(self.parameters, self.choice.law)
        loads = self._of_loads(figures, dict.fromkeys(SIDES, share))
        return loads | self._of_motion(figures, (share, share), False) if self._shares() else loads

    def law_of(self, output: str) -> tuple[float, str]:
        """At most what the coefficient of a contact is off by."""
        return law_error(self.parameters, self.choice.law), HERTZ_MENDS

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """What was measured of equilibria against the motion of balls, and what bodies are no half-spaces."""
        shares = self._shares()
        if not shares:
            return {}
        wide = {side: self._wide(side, figures[f"{side}_greatest_ball_load_n"]) for side in SIDES}
        still = {side: equilibrium_error(share) for side, share in shares.items()}
        found = self._of_loads(figures, {side: still[side] + one.load for side, one in wide.items()})
        for side, one in wide.items():
            pressure, life = f"{side}_peak_pressure_pa", f"{side}_reference_life_mrev"
            found[pressure] += one.contact / 3.0 * abs(figures[pressure])
            found[life] = LIFE * one.balanced * abs(figures[life])
        return found | self._of_motion(figures, tuple(still[side] for side in SIDES), True)

    def _of_motion(self, figures: Mapping[str, Any], shares: tuple[float, ...], wide: bool) -> dict[str, Any]:
        """What places, forces and modes are off where contacts are by these shares, as `moved_by` has it at the end."""
        speed, end = float(speeds_of(self.parameters)[-1]), float(self.parameters.run.duration)
        most = max(
            share + wide * wide_of(self.parameters, self.choice.law, speed, end)[side].share
            for side, share in zip(SIDES, shares, strict=True)
        )
        found = dict(moved_by(self.parameters, self.choice.law, speed, end, shares, wide))
        found |= {key: [most * abs(one) for one in figures[key]] for key in RANGES if key in figures}
        seats = rotor_of(self.parameters, self.choice.law).seats
        balls = sum(
            getattr(self.parameters, side).geometry.balls * seat.setting.ball_mass
            for side, seat in zip(SIDES, seats, strict=True)
        )
        higher = 0.5 * most + wide * LIGHT * balls / self.parameters.shaft.mass
        found |= {key: [higher * abs(one) for one in figures[key]] for key in MODES if key in figures}
        return {key: error for key, error in found.items() if key in figures}

    def _wide(self, side: str, load: float) -> ShaftErrors:
        """As `Wide.at`, by the balance at the run's start or end whose greatest load is nearer to this one [N]."""
        speeds, end = speeds_of(self.parameters), float(self.parameters.run.duration)
        ends = (speeds[0], 0.0), (speeds[-1], end)
        both = [wide_of(self.parameters, self.choice.law, float(speed), time)[side] for speed, time in ends]
        return min(both, key=lambda one: abs(one.greatest - load)).at(load)

    def notes(self) -> dict[str, str]:
        """What is not in the errors."""
        speed = f"at {self._fastest:.4g} rad/s, as commanded, nothing carries the scene's own loads: what equilibria "
        unknown = {} if self._shares() else {LEFT_OUT: f"{speed}leave out is not known"}
        return unknown | {
            "balls": "skidding, friction, forces on the cages and the balls' own ringing, above about 1 kHz, are not "
            "computed",
            "structure": "shaft and housings are rigid",
            "works": "those of loads and bearings are off by about a tenth of wanted.tolerance of what was done either "
            "way, of which little may be left over whole turns, and by up to twice the tolerance where the speed "
            "changes or shaft.start is equilibrium; energy_closure is the balance of both and tells less",
        }
