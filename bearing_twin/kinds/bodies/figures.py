"""The figures and quantities of bodies that collide: functions of outputs and records alone.

`ImpactFigures` are those of an impact of two spheres, two discs, or a sphere on a beam; `BouncingFigures` those of
bodies that bounce, an ellipsoid on a plane or any two.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.contact.elasticity import ellipse, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import gathered, law_doubt, pressure_doubt, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.bodies.derived import ROWS, bodies_of, modulus_of, patch_of, reach_of, sphere_mass
from bearing_twin.kinds.bodies.parameters import OVERLAP, Sphere, TwoBodiesScene
from bearing_twin.kinds.contract import adds_up

LISTED = 200  # contacts named one by one in a report
NOTABLE = 0.01  # of the greatest load: lighter touches say nothing about waves in the body
GREATEST_DRIFT = 1e-6  # of a quaternion's norm in one step

START_COLUMNS = Channel("time", "s", (), "end of the contact"), Channel("start", "s", (), "begin of the contact")
CONTACT = Table(
    "contact",
    (
        *START_COLUMNS,
        Channel("duration", "s", (), "of the contact"),
        Channel("peak_force", "N", (), "greatest contact force"),
        Channel("impulse", "N s", (), "of the contact force"),
        Channel("greatest_approach", "m", (), "greatest mutual approach"),
        Channel("leaving_speed", "m/s", (), "relative speed away at its end"),
        Channel("energy_gained", "J", (), "by the numerical method"),
    ),
    "a contact that has ended",
)
MEANINGS = {
    "peak_force_n": "contact force, greatest over all contacts that have ended",
    "contact_duration_s": "time in contact, sum over all contacts that have ended",
    "contacts": "the contacts that have ended, one by one: begin, duration, greatest force, impulse of the force",
    "greatest_approach_m": "mutual approach, greatest over all contacts that have ended",
    "restitution": "relative speed away over that before, after the last contact that has ended",
    "energy_closure": "energy gained (+) or lost (-) by the numerical method over the initial energy, whole motion",
    "impulse_ns": "of the contact force, sum over all contacts that have ended",
    "impact_speed_m_s": "relative speed at the first touch",
}
FIGURES = ("peak_force_n", "contact_duration_s", "greatest_approach_m", "restitution", "impulse_ns")
START, DURATION, PEAK_FORCE, IMPULSE, DEEPEST, LEAVING, GAINED = range(1, 8)

TOUCH = Table("touch", (Channel("time", "s", (), "begin of the contact"),), "a contact that begins")
_AT_PEAK = (
    *START_COLUMNS,
    Channel("peak_load", "N", (), "greatest normal load"),
    Channel("approach", "m", (), "at the greatest load"),
    Channel("curvature_small", "1/m", (), "of the gap at the greatest load, P in z = P x^2 + Q y^2"),
    Channel("curvature_large", "1/m", (), "of the gap at the greatest load, Q in z = P x^2 + Q y^2"),
    Channel("coefficient", "N/m^1.5", (), "of the elastic law at the greatest load; of a linear one in N/m"),
)
_SPEEDS = (
    Channel("speed_in", "m/s", (), "approach rate at the begin of the contact"),
    Channel("speed_out", "m/s", (), "rate of departure at the end"),
)
_GREATEST = Channel("greatest_approach", "m", (), "which damping puts after the greatest load")
BOUNCE = Table(
    "contact",
    (
        *_AT_PEAK,
        *_SPEEDS,
        Channel("impulse_x", "N s", (), "on the body, of gravity and contact together"),
        Channel("impulse_y", "N s", (), "on the body"),
        Channel("impulse_z", "N s", (), "on the body, by the contact alone"),
        _GREATEST,
    ),
    "a contact that has ended",
)
BOUNCE_OF_PAIR = Table(
    "contact",
    (
        *_AT_PEAK,
        Channel("semi_major", "m", (), "at the greatest load"),
        Channel("semi_minor", "m", (), "at the greatest load"),
        Channel("peak_pressure", "Pa", (), "at the greatest load"),
        *_SPEEDS,
        Channel("impulse", "N s", (), "of the normal load"),
        Channel("friction_impulse", "N s", (), "size of that of friction"),
        _GREATEST,
    ),
    "a contact that has ended",
)
MEANINGS_OF_ELLIPSOID = {
    "peak_force_n": "normal load, greatest over the run; of a contact that goes on, as seen at the outputs",
    "contact_count": "contacts that have begun",
    "contact_duration_s": "time in contact over the run",
    "contacts": f"the first {LISTED} contacts one by one; of one that goes on, no impulse and no restitution",
    "restitution": "speed away over the speed before, of the first contact; none while it goes on",
    "resting_since_s": "begin of the contact that goes on at the end; none where there is none",
    "greatest_approach_m": "greatest over the run; of a contact that goes on, as seen at the outputs",
    "peak_pressure_pa": "Hertz pressure, greatest over the run; of a contact that goes on, as seen at the outputs",
    "energy_closure": "energy gained (+) or lost (-) by the numbers over the run, as a share of the most ever stored",
    "greatest_energy_gain": "the most energy gained by the numbers at any output, as a share of the most ever stored",
    "energy_start_j": "kinetic, elastic and potential, at the start",
    "energy_end_j": "kinetic, elastic and potential, at the end",
    "dissipated_viscous_j": "lost to damping since the start, at the end",
    "dissipated_friction_j": "lost to friction since the start, at the end",
    "velocity_change_x_m_s": "of the centre along x since the start, at the end",
    "velocity_change_y_m_s": "of the centre along y since the start, at the end",
    "angular_momentum_change_vertical_nms": "about the centre, along z, since the start, at the end",
    "height_at_end_m": "of the centre above the plane, at the end",
    "quaternion_drift": "of the norm before it is put right, greatest in one step since the start, at the end",
}
_NOT_OF_PAIR = ("height_at_end_m", "angular_momentum_change_vertical_nms")
MEANINGS_OF_PAIR = {key: text for key, text in MEANINGS_OF_ELLIPSOID.items() if key not in _NOT_OF_PAIR} | {
    "energy_closure": "energy gained (+) or lost (-) by the numbers over the run, as a share of the most ever kinetic "
    "and elastic",
    "greatest_energy_gain": "the most energy gained by the numbers at any output, as the same share",
    **{
        f"velocity_change_{axis}_m_s": f"of the first body's centre along {axis} since the start, at the end"
        for axis in "xyz"
    },
    "held_work_j": "done on held bodies since the start, at the end",
    "tracking_error_m": "most by which opposing points missed their equations at a step's end, over the run",
}


OF_IMPACT, OF_ELLIPSOID, OF_PAIR = (CONTACT,), (TOUCH, BOUNCE), (TOUCH, BOUNCE_OF_PAIR)
"""Tables of the records of two spheres or discs, of an ellipsoid on a plane and of two bodies."""


# Impacts


def contact_rows(contacts, deepest, leaving: float, gained: float) -> np.ndarray:
    """Rows (n, columns) of CONTACT; the last one carries the speed away and the energy gained in all [J]."""
    rows = np.zeros((len(contacts), len(CONTACT.columns)))
    for row, contact, depth in zip(rows, contacts, deepest, strict=True):
        row[:DEEPEST] = contact.start + contact.duration, *contact
        row[DEEPEST] = depth
    if len(rows):
        rows[-1, LEAVING], rows[-1, GAINED] = leaving, gained
    return rows


class ImpactFigures:
    """Gathers the records of an impact and its first and last output; `speed` [m/s] is that of the first touch."""

    def __init__(self, parameters, choice, speed: float):
        self.parameters, self.choice, self.speed = parameters, choice, speed
        self.until, self.initial_energy = 0.0, None
        self.last: dict[str, np.ndarray] = {}
        self._rows: list[np.ndarray] = []

    def add(self, block: Block) -> None:
        if self.initial_energy is None:
            self.initial_energy = float(block.values["kinetic_energy"][0])
        self._rows.append(block.records.get("contact", np.empty((0, len(CONTACT.columns)))))
        self.last = {name: values[-1] for name, values in block.values.items() if values.ndim == 1}
        self.until = 1e-9 * float(block.time_ns[-1])

    @property
    def contacts(self) -> np.ndarray:
        """The contacts so far, rows of CONTACT."""
        return np.concatenate(self._rows) if self._rows else np.empty((0, len(CONTACT.columns)))

    @property
    def peak_force(self) -> float:
        """Greatest contact force [N]."""
        return float(self.contacts[:, PEAK_FORCE].max(initial=0.0))

    @property
    def greatest_approach(self) -> float:
        """Greatest mutual approach [m]."""
        return float(self.contacts[:, DEEPEST].max(initial=0.0))

    @property
    def restitution(self) -> float | None:
        """Relative speed away over relative speed before; None before the first contact has ended."""
        return float(self.contacts[-1, LEAVING]) / self.speed if len(self.contacts) else None

    @property
    def energy_closure(self) -> float:
        """Energy gained (+) or lost (-) by the numerical method, as a share of the initial energy."""
        gained = math.fsum(self.contacts[:, GAINED])
        return gained / self.initial_energy if self.initial_energy else 0.0

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys, over all contacts that have ended."""
        contacts, keys = self.contacts, ("start_s", "duration_s", "peak_force_n", "impulse_ns")
        return {
            "peak_force_n": self.peak_force,
            "contact_duration_s": sum(map(float, contacts[:, DURATION])),
            "contacts": [dict(zip(keys, map(float, row[START:DEEPEST]), strict=True)) for row in contacts],
            "greatest_approach_m": self.greatest_approach,
            "restitution": self.restitution,
            "energy_closure": self.energy_closure,
            "impulse_ns": math.fsum(contacts[:, IMPULSE]),
            "impact_speed_m_s": self.speed,
        }

    def flags(self) -> list[str]:
        """A warning where the outputs do not hold the whole contact."""
        last = max((float(row[START] + row[DURATION]) for row in self.contacts), default=0.0)
        if self.until < last:
            return [f"the outputs end at {self.until:.4g} s, before the contact does at {last:.4g} s"]
        return []

    def status(self) -> str:
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"


class PairFigures(ImpactFigures):
    """The figures of two spheres or two discs."""

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice, parameters.motion.speed)

    def flags(self) -> list[str]:
        """Warnings: conditions outside the theory, and outputs that end before the contact."""
        if not len(self.contacts):
            return []
        bodies, flags = bodies_of(self.parameters), super().flags()
        spheres = isinstance(bodies[0], Sphere)
        _, half_width, pressure = patch_of(self.parameters, self.peak_force)
        transits = []
        for one in bodies:
            volume = 4.0 / 3.0 * math.pi * one.radius**3
            density = sphere_mass(one) / volume if spheres else one.material.density
            transits.append(wave_transit(2.0 * one.radius, one.material.young_modulus, density))
        found = gathered(
            pressure_doubt(pressure, yield_pressure(*(one.material for one in bodies))),
            width_doubt(half_width, min(one.radius for one in bodies), "smaller radius" if spheres else "radius"),
            wave_doubt(float(self.contacts[:, DURATION].min()), max(transits)),
        )
        # A law that is specified has a range of thicknesses, which says so.
        if not spheres and bodies[0].thickness < bodies[0].radius and self.parameters.contact.normal == "auto":
            found.append(
                f"a thickness of {bodies[0].thickness:g} m is below the radius of {bodies[0].radius:g} m: both assume "
                "plane strain"
            )
        return found + flags


# Bodies that bounce


class Bounce(NamedTuple):
    """One contact: seconds, N, m, Pa, N s; of one that goes on, peaks are those at the outputs, the rest is None.

    `approach` is the greatest; semi-axes, radii and the law's error are those at the greatest load.
    """

    start: float
    duration: float
    peak_load: float
    approach: float
    semi_axes: tuple[float, float]
    peak_pressure: float
    radii: tuple[float, float] = (math.inf, math.inf)
    law_error: float = 0.0
    impulse: float | None = None
    friction_impulse: float | None = None
    restitution: float | None = None

    @property
    def open(self) -> bool:
        """True if it has not ended by the last output."""
        return self.impulse is None


class BouncingFigures:
    """Gathers contacts and the books of energy and momentum of the outputs given out.

    Of an ellipsoid on a plane and of two bodies, whose records hold the contact ellipse, whose potential energy has its
    zero anywhere, and which may do work on a held body.
    """

    stored = ("kinetic_energy", "potential_energy", "elastic_energy")
    peaks = ("normal_load", "approach", "semi_major", "semi_minor", "peak_pressure")
    """Channels whose greatest is that of a contact that goes on, as seen at the outputs."""

    def __init__(self, parameters, choice: Choice):
        self.parameters, self.law, self.pair = parameters, choice.law, isinstance(parameters, TwoBodiesScene)
        self.until, self.first, self.last, self.gain, self.scale = 0.0, {}, {}, 0.0, 0.0
        self._columns = [channel.name for channel in (BOUNCE_OF_PAIR if self.pair else BOUNCE).columns]
        self._spent = ("dissipated_viscous", "dissipated_friction", *(("held_work",) if self.pair else ()))
        self._brought = (self.stored[0], self.stored[2]) if self.pair else self.stored
        self._ended: list[Bounce] = []
        self._open, self._open_peaks = None, np.zeros(0)  # begin [s] of the contact that goes on

    def add(self, block: Block) -> None:
        stored = sum(block.values[name] for name in self.stored)
        total = stored + sum(block.values[name] for name in self._spent)
        if not self.first:
            self.first = self._instant(block, stored, total, 0)
        self.last = self._instant(block, stored, total, -1)
        self.scale = max(self.scale, float(sum(block.values[name] for name in self._brought).max()))
        if self.scale > 0.0:
            self.gain = max(self.gain, float(total.max() - self.first["total"]) / self.scale)
        self.until = 1e-9 * float(block.time_ns[-1])
        touches, ends = (block.records.get(table.name, ()) for table in (TOUCH, BOUNCE))
        self._ended.extend(map(self._bounce, ends))
        if len(touches):
            self._open, self._open_peaks = float(touches[-1, 0]), np.zeros(len(self.peaks))
        if self._open is not None and len(ends) and float(ends[-1, 0]) >= self._open:
            self._open = None
        if self._open is not None:
            rows = 1e-9 * block.time_ns >= self._open
            seen = [block.values[name][rows].max(initial=0.0) for name in self.peaks]
            self._open_peaks = np.maximum(self._open_peaks, seen)

    def _instant(self, block, stored, total, row):
        kept = {name: block.values[name][row] + 0.0 for name in ("velocity", "angular_momentum", "position")}
        names = (*self._spent, "quaternion_drift", "tracking_error")
        numbers = {name: float(block.values[name][row]) for name in names if name in block.values}
        return {"stored": float(stored[row]), "total": float(total[row]), **numbers, **kept}

    def _bounce(self, row: np.ndarray) -> Bounce:
        """One contact from its record, which in logs of earlier versions lacks the greatest approach."""
        one = dict(zip(self._columns, map(float, row), strict=False))
        modulus, load = modulus_of(self.parameters), one["peak_load"]
        small, large = curvatures = one["curvature_small"], one["curvature_large"]
        if self.pair:
            semi_axes, pressure = (one["semi_major"], one["semi_minor"]), one["peak_pressure"]
            impulse, rub = one["impulse"], one["friction_impulse"]
        else:
            *semi_axes, pressure = ellipse(small, large, modulus, load)
            impulse, rub = one["impulse_z"], math.hypot(one["impulse_x"], one["impulse_y"])
        elliptic = small > 0.0 and load > 0.0 and self.law != OVERLAP
        exact = hertz_coefficient(small, large, modulus) if elliptic else 1.0
        return Bounce(
            start=one["start"],
            duration=one["time"] - one["start"],
            peak_load=load,
            approach=one.get("greatest_approach", one["approach"]),
            semi_axes=tuple(semi_axes),
            peak_pressure=pressure,
            radii=tuple(0.5 / one if one > 0.0 and load > 0.0 else math.inf for one in curvatures),
            law_error=one["coefficient"] / exact - 1.0 if elliptic else 0.0,
            impulse=impulse,
            friction_impulse=rub,
            restitution=one["speed_out"] / one["speed_in"] if one["speed_in"] > 0.0 else None,
        )

    def bounces(self) -> list[Bounce]:
        """All contacts, the one that goes on last."""
        if self._open is None:
            return list(self._ended)
        load, approach, major, minor, pressure = map(float, self._open_peaks)
        return [*self._ended, Bounce(self._open, self.until - self._open, load, approach, (major, minor), pressure)]

    def figures(self) -> dict[str, Any]:
        """Contacts and balances; velocities and angular momentum as changes since the first output."""
        bounces, last = self.bounces(), self.last
        velocity, turning = (last[name] - self.first[name] for name in ("velocity", "angular_momentum"))
        found = {
            "peak_force_n": max((one.peak_load for one in bounces), default=0.0),
            "contact_count": len(bounces),
            "contact_duration_s": math.fsum(one.duration for one in bounces),
            "contacts": [
                {
                    "start_s": one.start,
                    "duration_s": one.duration,
                    "peak_force_n": one.peak_load,
                    "impulse_ns": one.impulse,
                    "friction_impulse_ns": one.friction_impulse,
                    "restitution": one.restitution,
                }
                for one in bounces[:LISTED]
            ],
            "restitution": bounces[0].restitution if bounces else None,
            "resting_since_s": self._open,
            "greatest_approach_m": max((one.approach for one in bounces), default=0.0),
            "peak_pressure_pa": max((one.peak_pressure for one in bounces), default=0.0),
            "energy_closure": self.closure,
            "greatest_energy_gain": self.gain,
            "energy_start_j": self.first["stored"],
            "energy_end_j": last["stored"],
            "dissipated_viscous_j": last["dissipated_viscous"],
            "dissipated_friction_j": last["dissipated_friction"],
            **{f"velocity_change_{axis}_m_s": float(change) for axis, change in zip("xyz", velocity, strict=True)},
            "angular_momentum_change_vertical_nms": float(turning[2]),
            "height_at_end_m": float(last["position"][2]),
            "quaternion_drift": last.get("quaternion_drift", math.nan),
            "held_work_j": last.get("held_work"),
            "tracking_error_m": last.get("tracking_error"),
        }
        return {key: found[key] for key in (MEANINGS_OF_PAIR if self.pair else MEANINGS_OF_ELLIPSOID)}

    def flags(self) -> list[str]:
        """Warnings of the run, one sentence each: contacts outside Hertz's theory, and the quaternion's drift."""
        flags, drift = self._contact_flags(), self.last.get("quaternion_drift", 0.0)
        if drift > GREATEST_DRIFT:
            flags.append(
                f"the quaternion's norm drifted by {drift:.2g} in one step before it was put right: "
                "tighten wanted.tolerance"
            )
        return flags

    def _contact_flags(self) -> list[str]:
        loaded, bodies = [one for one in self.bounces() if one.peak_load > 0.0], bodies_of(self.parameters)
        if not loaded:
            return []
        transits = [
            wave_transit(2.0 * reach_of(one), one.material.young_modulus, one.material.density)
            for one in bodies
            if ROWS[one.shape].solid
        ]
        hardest = max(loaded, key=lambda one: one.peak_pressure)
        deepest = max(loaded, key=lambda one: one.approach)
        worst = max(loaded, key=lambda one: abs(one.law_error))
        heavy = NOTABLE * max(one.peak_load for one in loaded)
        shortest = min((one.duration for one in loaded if not one.open and one.peak_load > heavy), default=math.inf)
        return gathered(
            pressure_doubt(hardest.peak_pressure, yield_pressure(*(one.material for one in bodies))),
            *(width_doubt(*pair) for pair in zip(deepest.semi_axes, deepest.radii, strict=True)),
            None
            if self.law not in LAWS or LAWS[self.law].measured
            else law_doubt(self.law, worst.law_error, worst.semi_axes[1] / worst.semi_axes[0]),
            wave_doubt(shortest, max(transits)),
        )

    @property
    def closure(self) -> float:
        """Energy gained (+) or lost (-) by the numbers, as a share of the greatest energy stored."""
        return (self.last["total"] - self.first["total"]) / self.scale if self.scale > 0.0 else 0.0

    def status(self) -> str:
        return "done" if adds_up(max(abs(self.closure), self.gain), self.parameters) else "failed: energy"
