"""The figures of a shaft on two bearings: a function of its outputs alone."""

import copy
import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.contact.elasticity import Ellipse, ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import gathered
from bearing_twin.kinds.bearing import (
    contact_flags,
    ellipses_of,
    half_space_error,
    hours_of,
    lives_of,
    ratings_of,
    setting_of,
)
from bearing_twin.kinds.contract import adds_up
from bearing_twin.kinds.error_estimates import (
    NOT_MODELLED,
    Comparison,
    Errors,
    ModelErrors,
    with_tolerance,
)
from bearing_twin.kinds.shaft.equilibrium import (
    lever_of,
    loads_of,
    modes_of,
    rotor_of,
    solver_of,
    speeds_of,
    support_with_weight,
)
from bearing_twin.kinds.shaft.motion import FINEST, SETTING, balance_errors, law_error
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene, bearing_scene
from bearing_twin.shapes import groove_curvatures

LIVES = "basic_life", "reference_life"
WORKS = ("load_work", "bearing_work", "cage_work", "dissipated")
NOTHING = 1e-10  # of the greatest ball load, of approaches, of what is stored: forces, ways, works that are less are 0
POWERS = 3.0, 10.0 / 3.0  # of ISO/TS 16281: of a load on the inner and on the outer raceway
STRETCH = 50  # outputs that are summed together, whatever blocks they come in
OF_SHAFT, OF_BEARING = np.array([3, 5, 8, 11]), 4  # columns of sums: where parts end; of each bearing behind them


class _Late:
    """Sums, least and greatest of outputs in the second half of a run, or of all so far before it."""

    def __init__(self, width: int):
        self.begun, self._width = False, width
        self._empty()

    def _empty(self) -> None:
        self.count, self.sum = 0, np.zeros(self._width)
        self.least, self.greatest = np.full(self._width, np.inf), np.full(self._width, -np.inf)

    def add(self, rows: np.ndarray, late: np.ndarray, first: int) -> None:
        """Takes rows (n, width) from output number `first` on in; those before the second half are then forgotten."""
        if late.any() and not self.begun:
            self.begun = True
            self._empty()
        if self.begun:
            rows, first = rows[late], first + int(np.argmax(late))
        if len(rows):
            begins = [0, *range(STRETCH - first % STRETCH, len(rows), STRETCH)]
            self.count += len(rows)
            for stretch in np.add.reduceat(rows, begins, axis=0):
                self.sum = self.sum + stretch
            self.least = np.minimum(self.least, rows.min(axis=0))
            self.greatest = np.maximum(self.greatest, rows.max(axis=0))

    @property
    def mean(self) -> np.ndarray:
        """Of each column."""
        return self.sum / self.count


class ShaftFigures:
    """Gathers a run's figures block by block."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: ShaftScene, choice: Choice):
        self.parameters, self.choice = parameters, choice
        self._scenes = {side: bearing_scene(parameters, side) for side in SIDES}
        self._ratings = {side: ratings_of(scene) for side, scene in self._scenes.items()}
        self._settings = {side: setting_of(scene, choice.law, 0.0) for side, scene in self._scenes.items()}
        self._greatest = {side: np.zeros((2, 2)) for side in SIDES}  # loads, and angles there, by raceway
        self._late = _Late(OF_SHAFT[-1] + OF_BEARING * len(SIDES))
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}

    def add(self, block: Block) -> None:
        """Takes a block in."""
        values, force = block.values, block.values["bearing_force"]
        rows = [values["position"], values["tilt"], force.reshape(len(block), -1)]
        for k, side in enumerate(SIDES):
            load, angle = values[f"{side}_normal_load"], values[f"{side}_contact_angle"]
            rows += [np.hypot(force[:, k, 0], force[:, k, 1]), np.abs(force[:, k, 2])]
            rows += [(load[..., raceway] ** power).mean(axis=1) for raceway, power in enumerate(POWERS)]
            for raceway, greatest in enumerate(self._greatest[side].T):
                at = np.unravel_index(load[..., raceway].argmax(), load.shape[:2])
                if load[at][raceway] > greatest[0]:
                    greatest[:] = load[at][raceway], angle[at][raceway]
        late = block.time_ns >= 0.5e9 * self.parameters.run.duration
        self._late.add(np.column_stack(rows), late, block.first_sequence)
        names = ("shaft_speed", "kinetic_energy", "potential_energy", "elastic_energy", *WORKS, "gross_work")
        self._last = {name: float(values[name][-1]) for name in names}
        if not self._first:
            self._first = {name: float(values[name][0]) for name in names}

    @property
    def energy_closure(self) -> float:
        """Energy that the shaft gained (+) or lost (-) by the numbers alone, over the work done on it either way.

        Where hardly anything moves it is a share of what the tolerance leaves open of the energy stored.
        """
        gained = {name: value - self._first[name] for name, value in self._last.items()}
        residual = gained["kinetic_energy"] + gained["potential_energy"] - gained["load_work"]
        residual += gained["bearing_work"] + gained["dissipated"]
        scale = max(gained["gross_work"], self.parameters.wanted.tolerance * self._last["elastic_energy"])
        return residual / scale if scale > 0.0 else 0.0

    def figures(self) -> dict[str, Any]:
        """The run in numbers, SI unit at the end of a key."""
        place, tilt, *forces, of_bearings = np.split(self._late.mean, OF_SHAFT)
        moved, tilted, *swings, _ = np.split(self._late.greatest - self._late.least, OF_SHAFT)
        modes, critical = modes_of(self.parameters, self.choice.law)
        load = max(float(greatest[0].max()) for greatest in self._greatest.values())
        way = approach_of(self._last["elastic_energy"], load)
        angle = way / lever_of(rotor_of(self.parameters, self.choice.law))
        found = {
            "shaft_speed_at_end_rad_s": self._last["shaft_speed"],
            "displacement_m": settled(place, way),
            "displacement_range_m": settled(moved, way),
            "tilt_rad": settled(tilt, angle),
            "tilt_range_rad": settled(tilted, angle),
        }
        for side, force, swing, means in zip(SIDES, forces, swings, np.split(of_bearings, len(SIDES)), strict=True):
            of_bearing = {
                "force_n": settled(force, load),
                "force_range_n": settled(swing, load),
                **self._of_bearing(side, *means),
            }
            found |= {f"{side}_{key}": value for key, value in of_bearing.items()}
        found |= {
            "natural_frequencies_hz": modes.frequencies.tolist(),
            "forward_shares": modes.forward.tolist(),
            "critical_speeds_rad_s": list(critical),
            "energy_closure": self.energy_closure,
        }
        works = settled(np.array([self._last[name] for name in WORKS]), self._last["elastic_energy"])
        return found | {f"{name}_j": work for name, work in zip(WORKS, works, strict=True)}

    def _of_bearing(self, side: str, radial: float, axial: float, *powers: float) -> dict[str, float]:
        """Figures of one bearing, from the means of its radial and axial force [N], and of the powers of its loads."""
        speed = self._last["shaft_speed"]
        loads = (np.array([mean ** (1.0 / power)]) for mean, power in zip(powers, POWERS, strict=True))
        lives = lives_of(self._scenes[side], self._ratings[side], (radial, 0.0, axial), *loads)
        found = {
            "greatest_ball_load_n": float(self._greatest[side][0].max()),
            "peak_pressure_pa": max(one.peak_pressure for one in self._ellipses(side)),
        }
        for life, turns in zip(LIVES, (float(lives.basic), float(lives.reference)), strict=True):
            found |= {f"{life}_mrev": turns} | ({f"{life}_h": hours_of(turns, speed)} if speed else {})
        return found

    def _ellipses(self, side: str) -> list[Ellipse]:
        """The contact ellipses at the greatest load on each raceway."""
        setting, materials, found = self._settings[side], self._scenes[side].materials, []
        rings = (-1.0, setting.inner, materials.inner_ring), (1.0, setting.outer, materials.outer_ring)
        for (outward, raceway, ring), (load, angle) in zip(rings, self._greatest[side].T.tolist(), strict=True):
            radial = outward * math.cos(angle)
            gap = groove_curvatures(setting.ball_radius, raceway.locus_radius, raceway.groove_radius, radial)
            found.append(ellipse(*gap, effective_modulus(materials.ball, ring), load))
        return found

    def flags(self) -> list[str]:
        """Warnings of a run outside the limits of the theory, one sentence each."""
        found = []
        for side, (loads, angles) in self._greatest.items():
            pressure = max(one.peak_pressure for one in self._ellipses(side))
            warnings = contact_flags(self._scenes[side], pressure, angles[1:], loads[:1])
            found += [f"{side} bearing: {one}" for one in gathered(*warnings)]
        return found

    def status(self) -> str:
        """Gives "done", or what failed."""
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"


def approach_of(stored: float, load: float) -> float:
    """Size of the approaches of contacts [m] by the energy that they store [J] and the greatest ball load [N]."""
    return stored / load if load > 0.0 else 0.0


def settled(values: np.ndarray, scale: float) -> list:
    """The values, without those that are nothing beside the scale of what they are differences of."""
    return np.where(np.abs(values) <= NOTHING * scale, 0.0, values).tolist()


LOADS = {"greatest_ball_load_n": 1.0, "peak_pressure_pa": 1.0 / 3.0}  # figures that go with this power of a load
LIFE = 3.0  # a life goes with the load to the power -3
MODES = "natural_frequencies_hz", "critical_speeds_rad_s"
LIGHT = 1.0 / 6.0  # of balls' mass over the shaft's, by which modes are too high without it: balls go half as far
RANGES = "displacement_range_m", "tilt_range_rad", *(f"{side}_force_range_n" for side in SIDES)
SIZE = 2.0 / 3.0  # power of a load with which the square of a contact ellipse's semi-axis goes


class Response(NamedTuple):
    """Changes of a shaft in balance where contacts are stiffer: of its `coordinates` (5,) and the bearings' `forces`.

    `forces` (2, 3) [N] are those of the bearings' contacts on it. For each bearing: the `greatest` load of its contacts
    [N], the greatest `share` by which a contact would carry more at the same approach, and the part of it that is
    `kept`: the shaft gives way, so that loads from outside are carried as before, but a preload by offsets grows.
    """

    coordinates: np.ndarray
    forces: np.ndarray
    greatest: dict[str, float]
    share: dict[str, float]
    kept: dict[str, float]


@functools.lru_cache(maxsize=8)
def response_of(
    parameters: ShaftScene, law: str, speed: float, time: float, shares: tuple[float, float], wide: bool
) -> Response:
    """The response of the balance at `time` [s] to contacts that carry more than by their law, by `shares` of bearings.

    With `wide` also by the error of the half-space. Found by a second balance, with raceways higher by as much.
    Raises SceneError where nothing carries the loads.
    """
    solver, support = solver_of(parameters, law, speed), support_with_weight(parameters, loads_of(parameters, time))
    more, heights, found, level = {}, [], [], solver.checked_balance(support)
    both = solver.by_bearing(level.contacts)
    for side, share, seat, contacts in zip(SIDES, shares, solver.rotor.seats, both, strict=True):
        scene, power = bearing_scene(parameters, side), seat.setting.inner.law.power
        more[side] = share + wide * half_space_error(scene, ellipses_of(scene, contacts)[0])
        heights.append(np.where(contacts.load > 0.0, more[side] * contacts.approach / power, 0.0))
    other = copy.copy(solver)
    other.heights = np.concatenate(heights)
    higher_up = other.checked_balance(support)
    greatest, most, kept, edges = {}, {}, {}, np.cumsum(solver.balls)[:-1]
    for one in (level, higher_up):
        contacts = one.contacts
        load, angle = contacts.load[:, 0], contacts.angle[:, 0]
        across = load * np.cos(angle)
        push = np.stack([across * np.cos(one.azimuths), across * np.sin(one.azimuths), load * np.sin(angle)], axis=1)
        found.append([np.split(contacts.load, edges), [part.sum(axis=0) for part in np.split(push, edges)]])
    (loads, forces), (higher, pushed) = found
    for side, load, now in zip(SIDES, loads, higher, strict=True):
        error = float(np.max(more[side] * load))
        greatest[side], most[side] = float(load.max()), float(np.max(more[side]))
        kept[side] = float(np.abs(now - load).max()) / error if error > 0.0 else 1.0
    return Response(higher_up.coordinates - level.coordinates, np.subtract(pushed, forces), greatest, most, kept)


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
        errors = [np.abs(own[name] - second[name]).max(axis=(1, 2)) for name in names]
        sizes = [own[name].max(axis=(1, 2)) for name in names]
        return {"ball_loads": (np.maximum(*errors), np.maximum(*sizes))}


class ShaftModelErrors(ModelErrors):
    """The law against exact Hertz; equilibria against balls that move."""

    outputs = ("ball_loads",)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._fastest = 0.0  # rad/s, of the outputs so far: a command may go beyond the scene's speeds
        self._stored = 0.0  # J, in the contacts at the last output

    def add(self, block: Block) -> None:
        """Takes a block in."""
        super().add(block)
        self._fastest = max(self._fastest, float(np.abs(block.values["shaft_speed"]).max(initial=0.0)))
        self._stored = float(block.values["elastic_energy"][-1])

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors, and up to which errors figures are not named."""
        return dataclasses.replace(super().errors(figures), negligible=self._negligible(figures))

    def _negligible(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of forces and displacements within the tolerance of the loads of which they are differences."""
        tolerance, load = (
            self.parameters.wanted.tolerance,
            max(figures[f"{side}_greatest_ball_load_n"] for side in SIDES),
        )
        way, lever = approach_of(self._stored, load), lever_of(rotor_of(self.parameters, self.choice.law))
        sizes = {"displacement{}_m": way, "tilt{}_rad": way / lever, **{f"{side}_force{{}}_n": load for side in SIDES}}
        return {key.format(part): tolerance * size for key, size in sizes.items() for part in ("", "_range")}

    def _balance_errors(self) -> dict[str, float]:
        """Errors of the balance, as `balance_errors`; none where a commanded speed changes the scene's own loads."""
        try:
            return balance_errors(self.parameters, self.choice.law, self._fastest)
        except SceneError:
            return {}

    def _of_loads(self, figures: Mapping[str, Any], shares: Mapping[str, float]) -> dict[str, float]:
        return {
            f"{side}_{key}": power * shares[side] * abs(figures[f"{side}_{key}"])
            for side in SIDES
            for key, power in LOADS.items()
        }

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """At most what the coefficient of a contact is wrong by: as of rings that are held; places as they answer."""
        share = law_error(self.parameters, self.choice.law)
        loads = self._of_loads(figures, dict.fromkeys(SIDES, share))
        return loads | self._of_motion(figures, (share, share), False) if self._balance_errors() else loads

    def law_of(self, output: str) -> float:
        """At most what the coefficient of a contact is wrong by."""
        return law_error(self.parameters, self.choice.law)

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of equilibria, as measured against the motion of balls, and of the half-space."""
        of_balance = self._balance_errors()
        if not of_balance:
            return {}
        found, end = self._of_loads(figures, of_balance), self._response((0.0, 0.0), True)
        for side in SIDES:
            load = f"{side}_greatest_ball_load_n"
            pressure = f"{side}_peak_pressure_pa"
            greatest, share, kept = end.greatest[side], end.share[side], end.kept[side]
            here = share * (figures[load] / greatest) ** SIZE if greatest else 0.0
            found[load] += here * kept * abs(figures[load])
            found[pressure] += here * (kept + 1.0) / 3.0 * abs(figures[pressure])
            for life in (f"{side}_reference_life_mrev", f"{side}_reference_life_h"):
                if math.isfinite(figures.get(life, math.inf)):
                    found[life] = LIFE * share * kept * figures[life]
        return found | self._of_motion(figures, tuple(of_balance[side] for side in SIDES), True)

    def _response(self, shares: tuple[float, float], wide: bool) -> Response:
        """The response to these shares in the balance at the end of the run."""
        speed, duration = float(speeds_of(self.parameters)[-1]), float(self.parameters.run.duration)
        return response_of(self.parameters, self.choice.law, speed, duration, shares, wide)

    def _of_motion(self, figures: Mapping[str, Any], shares: tuple[float, ...], wide: bool) -> dict[str, Any]:
        """Errors of places, forces and modes where contacts carry these shares more, in the balance at the end."""
        end = self._response(shares, wide)
        most, (place, tilt) = max(end.share.values()), np.split(np.abs(end.coordinates), [3])
        found = {"displacement_m": place.tolist(), "tilt_rad": tilt.tolist()}
        found |= {f"{side}_force_n": np.abs(one).tolist() for side, one in zip(SIDES, end.forces, strict=True)}
        found |= {key: [most * abs(one) for one in figures[key]] for key in RANGES if key in figures}
        seats = rotor_of(self.parameters, self.choice.law).seats
        balls = sum(
            getattr(self.parameters, side).geometry.balls * seat.setting.ball_mass
            for side, seat in zip(SIDES, seats, strict=True)
        )
        higher = 0.5 * most + wide * LIGHT * balls / self.parameters.shaft.mass
        found |= {key: [higher * abs(one) for one in figures[key]] for key in MODES if key in figures}
        return {key: error for key, error in found.items() if key in figures}

    def notes(self) -> dict[str, str]:
        """Sources that the errors do not contain."""
        speed = f"at {self._fastest:.4g} rad/s, as commanded, nothing carries the scene's own loads: what equilibria "
        unknown = {} if self._balance_errors() else {NOT_MODELLED: f"{speed}leave out is not known"}
        return unknown | {
            "balls": "skidding, friction, forces on the cages and the balls' own ringing, above about 1 kHz, are not "
            "computed",
            "structure": "shaft and housings are rigid",
            "works": "those of loads and bearings have errors of a tenth of wanted.tolerance of what was done either "
            "way, of which little may be left over whole turns, and by up to twice the tolerance where the speed "
            "changes or shaft.start is equilibrium; energy_closure, the balance of both, shows less of them",
        }
