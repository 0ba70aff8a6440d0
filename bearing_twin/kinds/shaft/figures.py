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
from bearing_twin.kinds.bearing.equilibrium import Contacts, ellipses_of, setting_of
from bearing_twin.kinds.bearing.model_error import half_space_error
from bearing_twin.kinds.bearing.models import contact_flags
from bearing_twin.kinds.bearing.ratings import hours_of, lives_of, ratings_of
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
NEGLIGIBLE = (
    1e-10  # of the greatest ball load, of approaches, of stored energy: smaller forces, displacements, works are 0
)
POWERS = 3.0, 10.0 / 3.0  # of ISO/TS 16281: of a load on the inner and on the outer raceway
STRETCH = 50  # outputs that are summed together in all blocks
OF_SHAFT, OF_BEARING = np.array([3, 5, 8, 11]), 4  # columns of sums: ends of their parts; then those of each bearing


class _SecondHalf:
    """Sums, least and greatest of outputs in the second half of a run; before it, of all so far."""

    def __init__(self, width: int):
        self.is_second_half, self._width = False, width
        self._empty()

    def _empty(self) -> None:
        self.count, self.sum = 0, np.zeros(self._width)
        self.least, self.greatest = np.full(self._width, np.inf), np.full(self._width, -np.inf)

    def add(self, rows: np.ndarray, is_late: np.ndarray, first: int) -> None:
        """Add rows (n, width) from output number `first` on; the second half replaces earlier ones."""
        if is_late.any() and not self.is_second_half:
            self.is_second_half = True
            self._empty()
        if self.is_second_half:
            rows, first = rows[is_late], first + int(np.argmax(is_late))
        if len(rows):
            begins = [0, *range(STRETCH - first % STRETCH, len(rows), STRETCH)]
            self.count += len(rows)
            for stretch in np.add.reduceat(rows, begins, axis=0):
                self.sum = self.sum + stretch
            self.least = np.minimum(self.least, rows.min(axis=0))
            self.greatest = np.maximum(self.greatest, rows.max(axis=0))

    @property
    def mean(self) -> np.ndarray:
        """Mean of each column."""
        return self.sum / self.count


class ShaftFigures:
    """Computes a run's figures block by block."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: ShaftScene, choice: Choice):
        self.parameters, self.choice = parameters, choice
        self._scenes = {side: bearing_scene(parameters, side) for side in SIDES}
        self._ratings = {side: ratings_of(scene) for side, scene in self._scenes.items()}
        self._settings = {side: setting_of(scene, choice.law, 0.0) for side, scene in self._scenes.items()}
        self._greatest = {side: np.zeros((2, 2)) for side in SIDES}  # loads, and angles there, by raceway
        self._second_half = _SecondHalf(OF_SHAFT[-1] + OF_BEARING * len(SIDES))
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}

    def add(self, block: Block) -> None:
        """Add a block."""
        values, force = block.values, block.values["bearing_force"]
        rows = [values["position"], values["tilt"], force.reshape(len(block), -1)]
        for k, side in enumerate(SIDES):
            load, angle = values[f"{side}_normal_load"], values[f"{side}_contact_angle"]
            rows += [np.hypot(force[:, k, 0], force[:, k, 1]), np.abs(force[:, k, 2])]
            rows += [(load[..., raceway] ** power).mean(axis=1) for raceway, power in enumerate(POWERS)]
            for raceway, greatest in enumerate(self._greatest[side].T):
                row = np.unravel_index(load[..., raceway].argmax(), load.shape[:2])
                if load[row][raceway] > greatest[0]:
                    greatest[:] = load[row][raceway], angle[row][raceway]
        is_late = block.time_ns >= 0.5e9 * self.parameters.run.duration
        self._second_half.add(np.column_stack(rows), is_late, block.first_sequence)
        names = ("shaft_speed", "kinetic_energy", "potential_energy", "elastic_energy", *WORKS, "gross_work")
        self._last = {name: float(values[name][-1]) for name in names}
        if not self._first:
            self._first = {name: float(values[name][0]) for name in names}

    @property
    def energy_closure(self) -> float:
        """Energy that the shaft gained (+) or lost (-) by numerical errors, over the gross work.

        If hardly any work is done, it is a share of the tolerance times the stored energy.
        """
        gained = {name: value - self._first[name] for name, value in self._last.items()}
        residual = gained["kinetic_energy"] + gained["potential_energy"] - gained["load_work"]
        residual += gained["bearing_work"] + gained["dissipated"]
        scale = max(gained["gross_work"], self.parameters.wanted.tolerance * self._last["elastic_energy"])
        return residual / scale if scale > 0.0 else 0.0

    def figures(self) -> dict[str, Any]:
        """The run in numbers, SI unit at the end of a key."""
        displacement, tilt, *forces, of_bearings = np.split(self._second_half.mean, OF_SHAFT)
        displacement_range, tilt_range, *force_ranges, _ = np.split(
            self._second_half.greatest - self._second_half.least, OF_SHAFT
        )
        modes, critical = modes_of(self.parameters, self.choice.law)
        load = max(float(greatest[0].max()) for greatest in self._greatest.values())
        approach = approach_of(self._last["elastic_energy"], load)
        angle = approach / lever_of(rotor_of(self.parameters, self.choice.law))
        figures = {
            "shaft_speed_at_end_rad_s": self._last["shaft_speed"],
            "displacement_m": without_rounding(displacement, approach),
            "displacement_range_m": without_rounding(displacement_range, approach),
            "tilt_rad": without_rounding(tilt, angle),
            "tilt_range_rad": without_rounding(tilt_range, angle),
        }
        for side, force, force_range, means in zip(
            SIDES, forces, force_ranges, np.split(of_bearings, len(SIDES)), strict=True
        ):
            of_bearing = {
                "force_n": without_rounding(force, load),
                "force_range_n": without_rounding(force_range, load),
                **self._bearing_figures(side, *means),
            }
            figures |= {f"{side}_{key}": value for key, value in of_bearing.items()}
        figures |= {
            "natural_frequencies_hz": modes.frequencies.tolist(),
            "forward_shares": modes.forward.tolist(),
            "critical_speeds_rad_s": list(critical),
            "energy_closure": self.energy_closure,
        }
        works = without_rounding(np.array([self._last[name] for name in WORKS]), self._last["elastic_energy"])
        return figures | {f"{name}_j": work for name, work in zip(WORKS, works, strict=True)}

    def _bearing_figures(self, side: str, radial: float, axial: float, *powers: float) -> dict[str, float]:
        """Figures of one bearing, from the means of its radial and axial force [N], and of the powers of its loads."""
        speed = self._last["shaft_speed"]
        loads = (np.array([mean ** (1.0 / power)]) for mean, power in zip(powers, POWERS, strict=True))
        lives = lives_of(self._scenes[side], self._ratings[side], (radial, 0.0, axial), *loads)
        figures = {
            "greatest_ball_load_n": float(self._greatest[side][0].max()),
            "peak_pressure_pa": max(contact_ellipse.peak_pressure for contact_ellipse in self._ellipses(side)),
        }
        for life, turns in zip(LIVES, (float(lives.basic), float(lives.reference)), strict=True):
            figures |= {f"{life}_mrev": turns} | ({f"{life}_h": hours_of(turns, speed)} if speed else {})
        return figures

    def _ellipses(self, side: str) -> list[Ellipse]:
        """The contact ellipses at the greatest load on each raceway."""
        setting, materials, ellipses = self._settings[side], self._scenes[side].materials, []
        rings = (-1.0, setting.inner, materials.inner_ring), (1.0, setting.outer, materials.outer_ring)
        for (outward, raceway, ring), (load, angle) in zip(rings, self._greatest[side].T.tolist(), strict=True):
            radial = outward * math.cos(angle)
            gap = groove_curvatures(setting.ball_radius, raceway.locus_radius, raceway.groove_radius, radial)
            ellipses.append(ellipse(*gap, effective_modulus(materials.ball, ring), load))
        return ellipses

    def flags(self) -> list[str]:
        """Warnings of quantities outside the theory's validity, one sentence each."""
        flags = []
        for side, (loads, angles) in self._greatest.items():
            pressure = max(contact_ellipse.peak_pressure for contact_ellipse in self._ellipses(side))
            warnings = contact_flags(self._scenes[side], pressure, angles[1:], loads[:1])
            flags += [f"{side} bearing: {warning}" for warning in gathered(*warnings)]
        return flags

    def status(self) -> str:
        """The status "done", or "failed" with its reason."""
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"


def approach_of(stored: float, load: float) -> float:
    """Size of the approaches of contacts [m] by the energy that they store [J] and the greatest ball load [N]."""
    return stored / load if load > 0.0 else 0.0


def without_rounding(values: np.ndarray, scale: float) -> list:
    """The values, 0 where they are rounding of differences of numbers of size `scale`."""
    return np.where(np.abs(values) <= NEGLIGIBLE * scale, 0.0, values).tolist()


LOADS = {"greatest_ball_load_n": 1.0, "peak_pressure_pa": 1.0 / 3.0}  # figures that follow this power of a load
LIFE = 3.0  # a life follows the power -3 of a load
MODES = "natural_frequencies_hz", "critical_speeds_rad_s"
LIGHT = 1.0 / 6.0  # of balls' mass over the shaft's, by which modes are too high: balls move half as far
RANGES = "displacement_range_m", "tilt_range_rad", *(f"{side}_force_range_n" for side in SIDES)
SIZE = 2.0 / 3.0  # power of a load that the square of a contact ellipse's semi-axis follows


class Response(NamedTuple):
    """Changes of a shaft in balance by stiffer contacts: of its `coordinates` (5,) and the bearings' `forces`.

    `forces` (2, 3) [N] are those of the bearings' contacts on it. For each bearing: the `greatest` load of its contacts
    [N], the greatest `share` by which a contact would carry more at the same approach, and the part of it that is
    `retained`: the shaft moves, so that external loads are carried as before, but a preload by offsets grows.
    """

    coordinates: np.ndarray
    forces: np.ndarray
    greatest: dict[str, float]
    share: dict[str, float]
    retained: dict[str, float]


def _force_on_shaft(contacts: Contacts, azimuths: np.ndarray) -> np.ndarray:
    """Force (3,) [N] of the inner contacts of a bearing, whose balls are at `azimuths` [rad] (N,)."""
    load, angle = contacts.load[:, 0], contacts.angle[:, 0]
    radial = load * np.cos(angle)
    rows = [radial * np.cos(azimuths), radial * np.sin(azimuths), load * np.sin(angle)]
    return np.stack(rows, axis=1).sum(axis=0)


@functools.lru_cache(maxsize=8)
def response_of(
    parameters: ShaftScene, law: str, speed: float, time: float, shares: tuple[float, float], wide: bool
) -> Response:
    """The response of the balance at `time` [s] to contacts that carry more than by their law, by `shares` of bearings.

    With `wide` also by the error of the half-space. It is the difference to a second balance, with higher raceways.
    Raises SceneError where nothing carries the loads.
    """
    solver, support = solver_of(parameters, law, speed), support_with_weight(parameters, loads_of(parameters, time))
    perturbed_solver, base = copy.copy(solver), solver.checked_balance(support)
    added, heights = {}, []
    for side, share, seat, contacts in zip(
        SIDES, shares, solver.rotor.seats, solver.by_bearing(base.contacts), strict=True
    ):
        scene, power = bearing_scene(parameters, side), seat.setting.inner.law.power
        added[side] = share + wide * half_space_error(scene, ellipses_of(scene, contacts)[0])
        heights.append(np.where(contacts.load > 0.0, added[side] * contacts.approach / power, 0.0))
    perturbed_solver.heights = np.concatenate(heights)
    perturbed = perturbed_solver.checked_balance(support)
    response = Response(perturbed.coordinates - base.coordinates, np.zeros((len(SIDES), 3)), {}, {}, {})
    azimuths = np.split(base.azimuths, np.cumsum(solver.balls)[:-1])
    before_and_after = zip(solver.by_bearing(base.contacts), solver.by_bearing(perturbed.contacts), strict=True)
    for k, (side, (before, after)) in enumerate(zip(SIDES, before_and_after, strict=True)):
        error, change = float(np.max(added[side] * before.load)), float(np.abs(after.load - before.load).max())
        response.forces[k] = _force_on_shaft(after, azimuths[k]) - _force_on_shaft(before, azimuths[k])
        response.greatest[side], response.share[side] = float(before.load.max()), float(np.max(added[side]))
        response.retained[side] = change / error if error > 0.0 else 1.0
    return response


class ShaftComparison(Comparison):
    """Loads of all balls over the greatest."""

    exact = (*Comparison.exact, "shaft_speed_at_end_rad_s", "forward_shares", *MODES)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self.outputs = {"ball_loads": "of any contact at any output, relative to the greatest load"}

    def refined(self):
        """A fraction of the tolerance, and twice the least steps a turn."""
        parameters, choice = with_tolerance(self.parameters, self.choice, FINEST / SETTING)
        return parameters, choice._replace(finer=2.0 * choice.finer)

    def differences(self, first: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of the loads of both bearings."""
        names = [f"{side}_normal_load" for side in SIDES]
        errors = [np.abs(first[name] - second[name]).max(axis=(1, 2)) for name in names]
        sizes = [first[name].max(axis=(1, 2)) for name in names]
        return {"ball_loads": (np.maximum(*errors), np.maximum(*sizes))}


class ShaftModelErrors(ModelErrors):
    """The law against exact Hertz; equilibria against balls that move."""

    outputs = ("ball_loads",)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._fastest = 0.0  # rad/s, of the outputs so far: a command may go beyond the scene's speeds
        self._stored = 0.0  # J, in the contacts at the last output

    def add(self, block: Block) -> None:
        """Add a block."""
        super().add(block)
        self._fastest = max(self._fastest, float(np.abs(block.values["shaft_speed"]).max(initial=0.0)))
        self._stored = float(block.values["elastic_energy"][-1])

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors, with the negligible errors of figures."""
        return dataclasses.replace(super().errors(figures), negligible=self._negligible(figures))

    def _negligible(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of forces and displacements within the tolerance of the loads of which they are differences."""
        tolerance = self.parameters.wanted.tolerance
        load = max(figures[f"{side}_greatest_ball_load_n"] for side in SIDES)
        approach, lever = approach_of(self._stored, load), lever_of(rotor_of(self.parameters, self.choice.law))
        sizes = {
            "displacement{}_m": approach,
            "tilt{}_rad": approach / lever,
            **{f"{side}_force{{}}_n": load for side in SIDES},
        }
        return {key.format(part): tolerance * size for key, size in sizes.items() for part in ("", "_range")}

    def _balance_errors(self) -> dict[str, float]:
        """Errors of the balance, as `balance_errors`; none where a commanded speed changes the scene's own loads."""
        try:
            return balance_errors(self.parameters, self.choice.law, self._fastest)
        except SceneError:
            return {}

    def _load_errors(self, figures: Mapping[str, Any], shares: Mapping[str, float]) -> dict[str, float]:
        return {
            f"{side}_{key}": power * shares[side] * abs(figures[f"{side}_{key}"])
            for side in SIDES
            for key, power in LOADS.items()
        }

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of loads at most by the coefficient of a contact, as of held rings, and the response of the shaft."""
        share = law_error(self.parameters, self.choice.law)
        loads = self._load_errors(figures, dict.fromkeys(SIDES, share))
        return loads | self._motion_errors(figures, (share, share), False) if self._balance_errors() else loads

    def law_of(self, output: str) -> float:
        """The greatest error of the coefficient of a contact."""
        return law_error(self.parameters, self.choice.law)

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of equilibria, as measured against the motion of balls, and of the half-space."""
        of_balance = self._balance_errors()
        if not of_balance:
            return {}
        errors, end = self._load_errors(figures, of_balance), self._response((0.0, 0.0), True)
        for side in SIDES:
            load = f"{side}_greatest_ball_load_n"
            pressure = f"{side}_peak_pressure_pa"
            greatest, share, retained = end.greatest[side], end.share[side], end.retained[side]
            error = share * (figures[load] / greatest) ** SIZE if greatest else 0.0
            errors[load] += error * retained * abs(figures[load])
            errors[pressure] += error * (retained + 1.0) / 3.0 * abs(figures[pressure])
            for life in (f"{side}_reference_life_mrev", f"{side}_reference_life_h"):
                if math.isfinite(figures.get(life, math.inf)):
                    errors[life] = LIFE * share * retained * figures[life]
        return errors | self._motion_errors(figures, tuple(of_balance[side] for side in SIDES), True)

    def _response(self, shares: tuple[float, float], wide: bool) -> Response:
        """The response to these shares in the balance at the end of the run."""
        speed, duration = float(speeds_of(self.parameters)[-1]), float(self.parameters.run.duration)
        return response_of(self.parameters, self.choice.law, speed, duration, shares, wide)

    def _motion_errors(self, figures: Mapping[str, Any], shares: tuple[float, ...], wide: bool) -> dict[str, Any]:
        """Errors of displacements, forces and modes by contacts that carry these shares more, in balance at the end."""
        end = self._response(shares, wide)
        share, (displacement, tilt) = max(end.share.values()), np.split(np.abs(end.coordinates), [3])
        errors = {"displacement_m": displacement.tolist(), "tilt_rad": tilt.tolist()}
        errors |= {f"{side}_force_n": np.abs(value).tolist() for side, value in zip(SIDES, end.forces, strict=True)}
        errors |= {key: [share * abs(value) for value in figures[key]] for key in RANGES if key in figures}
        seats = rotor_of(self.parameters, self.choice.law).seats
        balls = sum(
            getattr(self.parameters, side).geometry.balls * seat.setting.ball_mass
            for side, seat in zip(SIDES, seats, strict=True)
        )
        higher = 0.5 * share + wide * LIGHT * balls / self.parameters.shaft.mass
        errors |= {key: [higher * abs(value) for value in figures[key]] for key in MODES if key in figures}
        return {key: error for key, error in errors.items() if key in figures}

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
