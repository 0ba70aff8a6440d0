"""The figures of a shaft on two bearings: a function of its outputs alone."""

import math
from typing import Any

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus, yield_pressure
from bearing_twin.contact.validity import gathered, groove_doubt, pressure_doubt, shoulder_doubt
from bearing_twin.kinds.bearing.equilibrium import setting_of
from bearing_twin.kinds.bearing.ratings import hours_of, lives_of, ratings_of
from bearing_twin.kinds.figures import adds_up
from bearing_twin.kinds.shaft.derived import bearing_scene
from bearing_twin.kinds.shaft.modes import modes_of
from bearing_twin.kinds.shaft.parameters import SIDES, ShaftScene
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
ROWS = {"position": 3, "tilt": 2, "bearing_force": 6}  # channels whose mean and range are figures, and their widths
POWERS = 3.0, 10.0 / 3.0  # of ISO/TS 16281: of a load on the inner and on the outer raceway


class _Late:
    """Sums, least and greatest of outputs in the second half of a run, or of all so far before it."""

    def __init__(self, width: int):
        self.begun = False
        self._width = width
        self._empty()

    def _empty(self) -> None:
        self.count, self.sum = 0, np.zeros(self._width)
        self.least, self.greatest = np.full(self._width, np.inf), np.full(self._width, -np.inf)

    def add(self, rows: np.ndarray, late: np.ndarray) -> None:
        """Takes rows (n, width) in; those before the second half are forgotten when it begins."""
        if late.any() and not self.begun:
            self.begun = True
            self._empty()
        rows = rows[late] if self.begun else rows
        if len(rows):
            self.count += len(rows)
            self.sum = self.sum + rows.sum(axis=0)  # a copy keeps the one before
            self.least = np.minimum(self.least, rows.min(axis=0))
            self.greatest = np.maximum(self.greatest, rows.max(axis=0))

    @property
    def mean(self) -> np.ndarray:
        """Of each column."""
        return self.sum / self.count


class _OfBearing:
    """What figures need of one bearing: greatest loads with their angles (2,) and ellipses, sums for its lives."""

    def __init__(self):
        self.load, self.angle = np.zeros(2), np.zeros(2)
        self.spots: tuple = ()  # once they are asked for
        self.late = _Late(4)  # radial and axial force, mean powers of the loads on inner and outer raceway

    def add(self, load, angle, force, late) -> None:
        """Takes loads and angles (n, balls, 2), forces (n, 3) in."""
        flat = load.reshape(-1, 2)
        for side, row in enumerate(flat.argmax(axis=0)):
            if flat[row, side] > self.load[side]:
                self.load[side], self.angle[side] = flat[row, side], angle.reshape(-1, 2)[row, side]
                self.spots = ()
        powers = [(load[..., side] ** power).mean(axis=1) for side, power in enumerate(POWERS)]
        radial, axial = np.hypot(force[:, 0], force[:, 1]), np.abs(force[:, 2])
        self.late.add(np.stack([radial, axial, *powers], axis=1), late)


class ShaftFigures:
    """Gathers a run's figures block by block."""

    def __init__(self, parameters: ShaftScene, choice: Choice):
        self.parameters, self.choice = parameters, choice
        self._scenes = {side: bearing_scene(parameters, side) for side in SIDES}
        self._ratings = {side: ratings_of(scene) for side, scene in self._scenes.items()}
        self._settings = {side: setting_of(scene, choice.law, 0.0) for side, scene in self._scenes.items()}
        self._modes: tuple = ()
        self.bearings = {side: _OfBearing() for side in SIDES}
        self._late = _Late(sum(ROWS.values()))
        self._first: dict[str, float] = {}
        self._last: dict[str, float] = {}

    def add(self, block: Block) -> None:
        """Takes a block in."""
        values = block.values
        late = block.time_ns >= 0.5e9 * self.parameters.run.duration
        rows = [values[name].reshape(len(block), width) for name, width in ROWS.items()]
        self._late.add(np.concatenate(rows, axis=1), late)
        loads = [values[f"{side}_normal_load"] for side in SIDES]
        for k, (side, load) in enumerate(zip(SIDES, loads, strict=True)):
            self.bearings[side].add(load, values[f"{side}_contact_angle"], values["bearing_force"][:, k], late)
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
        edges = np.cumsum(list(ROWS.values()))[:-1]
        place, tilt, force = np.split(self._late.mean, edges)
        moved, tilted, swing = np.split(self._late.greatest - self._late.least, edges)
        self._modes = self._modes or modes_of(self.parameters, self.choice.law)
        modes, critical = self._modes
        found = {
            "shaft_speed_at_end_rad_s": self._last["shaft_speed"],
            "displacement_m": place.tolist(),
            "displacement_range_m": moved.tolist(),
            "tilt_rad": tilt.tolist(),
            "tilt_range_rad": tilted.tolist(),
        }
        for k, side in enumerate(SIDES):
            found[f"{side}_force_n"] = force[3 * k : 3 * k + 3].tolist()
            found[f"{side}_force_range_n"] = swing[3 * k : 3 * k + 3].tolist()
            found |= {f"{side}_{key}": value for key, value in self._of_bearing(side).items()}
        found |= {
            "natural_frequencies_hz": modes.frequencies.tolist(),
            "forward_shares": modes.forward.tolist(),
            "critical_speeds_rad_s": list(critical),
            "energy_closure": self.energy_closure,
        }
        return found | {f"{name}_j": self._last[name] for name in WORKS}

    def _of_bearing(self, side: str) -> dict[str, float]:
        own = self.bearings[side]
        radial, axial, *powers = own.late.mean
        inner, outer = (mean ** (1.0 / power) for mean, power in zip(powers, POWERS, strict=True))
        force, loads = (radial, 0.0, axial), (np.array([inner]), np.array([outer]))
        lives = lives_of(self._scenes[side], self._ratings[side], force, *loads)
        speed = float(self._last["shaft_speed"])
        found = {
            "greatest_ball_load_n": float(own.load.max()),
            "peak_pressure_pa": max(spot.peak_pressure for spot in self._spots(side)),
        }
        for life, turns in zip(LIVES, (float(lives.basic), float(lives.reference)), strict=True):
            found |= {f"{life}_mrev": turns} | ({f"{life}_h": hours_of(turns, speed)} if speed else {})
        return found

    def _spots(self, side: str) -> tuple:
        """The ellipses at the greatest load on each raceway."""
        own, setting, materials = self.bearings[side], self._settings[side], self._scenes[side].materials
        if not own.spots:
            found = []
            for k, (raceway, ring) in enumerate(
                ((setting.inner, materials.inner_ring), (setting.outer, materials.outer_ring))
            ):
                radial = (2.0 * k - 1.0) * math.cos(own.angle[k])
                small, large = groove_curvatures(
                    setting.ball_radius, raceway.locus_radius, raceway.groove_radius, radial
                )
                found.append(ellipse(small, large, effective_modulus(materials.ball, ring), float(own.load[k])))
            own.spots = tuple(found)
        return own.spots

    def flags(self) -> list[str]:
        """What in this run lies outside the theory's validity, one sentence each."""
        found = []
        for side in SIDES:
            mounted, spots, own = getattr(self.parameters, side), self._spots(side), self.bearings[side]
            geometry, materials = mounted.geometry, mounted.materials
            limit = yield_pressure(materials.ball, materials.inner_ring, materials.outer_ring)
            conformities = geometry.inner_conformity, geometry.outer_conformity
            doubts = gathered(
                pressure_doubt(max(spot.peak_pressure for spot in spots), limit),
                groove_doubt([spot.semi_major for spot in spots], 0.5 * geometry.ball_diameter, conformities),
                shoulder_doubt(geometry.contact_angle, own.angle[1:], own.load[:1]),
            )
            found += [f"{side} bearing: {doubt}" for doubt in doubts]
        return found

    def status(self) -> str:
        """Gives "done", or what failed."""
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"
