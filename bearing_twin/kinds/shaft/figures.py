"""The figures of a shaft on two bearings: a function of its outputs alone."""

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
    ALIKE,
    COORDINATES,
    Support,
    azimuths_of,
    contact_flags,
    ellipses_of,
    equilibrium_error,
    half_space_error,
    heights_of,
    hours_of,
    lives_of,
    ratings_of,
    response_to,
    setting_of,
    weighed_solver,
)
from bearing_twin.kinds.contract import adds_up
from bearing_twin.kinds.error_estimates import HERTZ_MENDS, LEFT_OUT, Comparison, Errors, ModelErrors, with_tolerance
from bearing_twin.kinds.shaft.equilibrium import balance_of, modes_of, rotor_of, speeds_of
from bearing_twin.kinds.shaft.motion import FINEST, SETTING, law_error, shares_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene, bearing_scene
from bearing_twin.shapes.closed_forms import groove_curvatures

HALF = "over the second half of the run"
LATE = f"mean {HALF}"
WHIRL = "in balance at the scene's last speed and loads, balls where they start"
MEANINGS = {
    "shaft_speed_at_end_rad_s": "of the shaft about its axis, at the end",
    "displacement_m": f"of the shaft's centre of mass, {LATE}",
    "displacement_range_m": f"greatest minus least, {HALF}",
    "tilt_rad": f"of the shaft about x and y, {LATE}",
    "tilt_range_rad": f"greatest minus least, {HALF}",
    **{
        f"{side}_{key}": words
        for side in SIDES
        for key, words in (
            ("force_n", f"of the {side} bearing on the shaft, {LATE}"),
            ("force_range_n", f"greatest minus least of that, {HALF}"),
            ("greatest_ball_load_n", f"of any contact of the {side} bearing, greatest over the run"),
            ("peak_pressure_pa", f"in the {side} bearing, at the greatest load on each raceway"),
            ("basic_life_mrev", f"of the {side} bearing in 1e6 turns, ISO 281, under its mean sizes of force {HALF}"),
            ("basic_life_h", "the same in hours at the shaft's speed at the end, where it turns then"),
            ("reference_life_mrev", f"of the {side} bearing by ISO/TS 16281, from the loads of all balls {HALF}"),
            ("reference_life_h", "the same in hours, as above"),
        )
    },
    "natural_frequencies_hz": f"of the shaft on its bearings, rising, {WHIRL}",
    "forward_shares": "of each of these motions: 1 whirls as the shaft turns, 0 against it, 1/2 in a line or axial",
    "critical_speeds_rad_s": f"at which a forward whirl goes round with the shaft, as stiff as {WHIRL}",
    "energy_closure": "energy of the shaft gained (+) or lost (-) by the numbers over the run, as a share of the work "
    "that loads and bearings did either way, or of wanted.tolerance times what is stored where that is more",
    "load_work_j": "of loads and unbalances on the shaft since the start, at the end",
    "bearing_work_j": "of the shaft on its bearings since the start, at the end, without what is dissipated",
    "cage_work_j": "of both cages on the balls that they lead round since the start, at the end",
    "dissipated_j": "in viscous contacts since the start, at the end",
}
LIVES = "basic_life", "reference_life"
WORKS = ("load_work", "bearing_work", "cage_work", "dissipated")
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
        found = {
            "shaft_speed_at_end_rad_s": self._last["shaft_speed"],
            "displacement_m": place.tolist(),
            "displacement_range_m": moved.tolist(),
            "tilt_rad": tilt.tolist(),
            "tilt_range_rad": tilted.tolist(),
        }
        for side, force, swing, means in zip(SIDES, forces, swings, np.split(of_bearings, len(SIDES)), strict=True):
            of_bearing = {"force_n": force.tolist(), "force_range_n": swing.tolist(), **self._of_bearing(side, *means)}
            found |= {f"{side}_{key}": value for key, value in of_bearing.items()}
        found |= {
            "natural_frequencies_hz": modes.frequencies.tolist(),
            "forward_shares": modes.forward.tolist(),
            "critical_speeds_rad_s": list(critical),
            "energy_closure": self.energy_closure,
        }
        return found | {f"{name}_j": self._last[name] for name in WORKS}

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
        """What in this run lies outside the theory's validity, one sentence each."""
        found = []
        for side, (loads, angles) in self._greatest.items():
            ellipses = self._ellipses(side)
            pressure, widths = max(one.peak_pressure for one in ellipses), [one.semi_major for one in ellipses]
            warnings = contact_flags(self._scenes[side], pressure, widths, angles[1:], loads[:1])
            found += [f"{side} bearing: {one}" for one in gathered(*warnings)]
        return found

    def status(self) -> str:
        """Gives "done", or what failed."""
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"


LOADS = {"greatest_ball_load_n": 1.0, "peak_pressure_pa": 1.0 / 3.0}  # figures that go with this power of a load
LIFE = 3.0  # a life goes with the load to the power -3
MODES = "natural_frequencies_hz", "critical_speeds_rad_s"
LIGHT = 1.0 / 6.0  # of balls' mass over the shaft's, by which modes are too high without it: balls go half as far
RANGES = "displacement_range_m", "tilt_range_rad", *(f"{side}_force_range_n" for side in SIDES)
SIZE = 2.0 / 3.0  # power of a load with which the square of a spot's semi-axis goes


class LoadShares(NamedTuple):
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

    def at(self, load: float) -> LoadShares:
        """What a contact under `load` [N] is off; its load keeps the whole share where it is not that in balance."""
        share = self.share * (load / self.greatest) ** SIZE if self.greatest else 0.0
        kept = self.kept if abs(load - self.greatest) <= ALIKE * load else 1.0
        return LoadShares(share, share * kept, self.share * self.kept)


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
        place = Support((False,) * COORDINATES, (0.0,) * COORDINATES, tuple(ring.tolist()))
        held, shares = solver.solve(place), shares_at(scene, contacts)
        respond = functools.partial(response_to, solver, place, held, heights_of(solver, held, shares))
        loads += turned.T @ respond().ring_loads
        found.append((contacts, shares, turned, respond))
    moved = -np.linalg.pinv(balance.stiffness) @ loads
    responses = [respond(held=turned @ moved) for _, _, turned, respond in found]
    forces = [turned.T @ one.ring_loads for (_, _, turned, _), one in zip(found, responses, strict=True)]
    changes = [(contacts, shares, one.loads) for (contacts, shares, *_), one in zip(found, responses, strict=True)]
    return Moved(moved, -np.array(forces)[:, :3], changes)


@functools.lru_cache(maxsize=8)
def moved_by(
    parameters: ShaftScene, law: str, speed: float, time: float, shares: tuple[float, float], wide: bool
) -> dict[str, list[float]]:
    """By how much places and forces of a shaft are off, where all contacts of a bearing are wrong by such a share.

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
    return half_space_error(scene, ellipses_of(scene, contacts)[0])


@functools.lru_cache(maxsize=8)
def wide_of(parameters: ShaftScene, law: str, speed: float, time: float) -> dict[str, Wide]:
    """What half-spaces are wrong by in each bearing, in balance at `time` [s]; raises as `response_of`."""
    found = {}
    response = response_of(parameters, law, speed, time, _wide)
    for side, (contacts, shares, changes) in zip(SIDES, response.contacts, strict=True):
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


class ShaftModelErrors(ModelErrors):
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
        """At most what the coefficient of a contact is wrong by: as of rings that are held; places as they answer."""
        share = law_error(self.parameters, self.choice.law)
        loads = self._of_loads(figures, dict.fromkeys(SIDES, share))
        return loads | self._of_motion(figures, (share, share), False) if self._shares() else loads

    def law_of(self, output: str) -> tuple[float, str]:
        """At most what the coefficient of a contact is wrong by."""
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

    def _wide(self, side: str, load: float) -> LoadShares:
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
            "works": "those of loads and bearings have errors of a tenth of wanted.tolerance of what was done either "
            "way, of which little may be left over whole turns, and by up to twice the tolerance where the speed "
            "changes or shaft.start is equilibrium; energy_closure is the balance of both and tells less",
        }
