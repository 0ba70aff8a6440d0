"""The figures of an ellipsoid on a plane: its contacts, balances and warnings; of outputs and records alone."""

import math
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.contact.ellipse import ellipse, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import gathered, law_doubt, pressure_doubt, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.ellipsoid.derived import modulus_of
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene
from bearing_twin.kinds.figures import adds_up

LISTED = 200  # contacts named one by one in a report
NOTABLE = 0.01  # of the greatest load: lighter touches say nothing about waves in the body
GREATEST_DRIFT = 1e-6  # of a quaternion's norm in one step
ENERGIES = ("kinetic_energy", "potential_energy", "elastic_energy", "dissipated_viscous", "dissipated_friction")

MEANINGS = {
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

TOUCH = Table("touch", (Channel("time", "s", (), "begin of the contact"),), "a contact that begins")
DEEPEST = Channel("greatest_approach", "m", (), "which damping puts after the greatest load")
CONTACT = Table(
    "contact",
    (
        Channel("time", "s", (), "end of the contact"),
        Channel("start", "s", (), "begin of the contact"),
        Channel("peak_load", "N", (), "greatest normal load"),
        Channel("approach", "m", (), "at the greatest load"),
        Channel("curvature_small", "1/m", (), "of the gap at the greatest load, P in z = P x^2 + Q y^2"),
        Channel("curvature_large", "1/m", (), "of the gap at the greatest load, Q in z = P x^2 + Q y^2"),
        Channel("coefficient", "N/m^1.5", (), "of the elastic law at the greatest load; of a linear one in N/m"),
        Channel("speed_in", "m/s", (), "approach rate at the begin of the contact"),
        Channel("speed_out", "m/s", (), "rate of departure at the end"),
        Channel("impulse_x", "N s", (), "on the body, of gravity and contact together"),
        Channel("impulse_y", "N s", (), "on the body"),
        Channel("impulse_z", "N s", (), "on the body, by the contact alone"),
        DEEPEST,
    ),
    "a contact that has ended",
)


def tables(parameters) -> tuple[Table, ...]:
    """Tables of the records of an ellipsoid on a plane."""
    return TOUCH, CONTACT


class Bounce(NamedTuple):
    """One contact: seconds, N, m, Pa, N s; of one that goes on, peaks are those at the outputs, the rest is None.

    `approach` is the greatest; semi-axes, radii and the law's error are those at the greatest load.
    """

    start: float
    duration: float
    peak_load: float
    approach: float
    semi_axes: tuple[float, float]
    radii: tuple[float, float]
    peak_pressure: float
    law_error: float
    impulse: float | None = None
    friction_impulse: float | None = None
    restitution: float | None = None

    @property
    def open(self) -> bool:
        """True if it has not ended by the last output."""
        return self.impulse is None


def _ended(row: np.ndarray, modulus: float) -> Bounce:
    """One contact from its record, which in logs of earlier versions lacks the greatest approach."""
    end, start, load, approach, small, large, coefficient, into, out, x, y, z, *deepest = map(float, row)
    spot = ellipse(small, large, modulus, load)
    exact = hertz_coefficient(small, large, modulus) if load > 0.0 else 1.0
    return Bounce(
        start=start,
        duration=end - start,
        peak_load=load,
        approach=deepest[0] if deepest else approach,
        semi_axes=(spot.semi_major, spot.semi_minor),
        radii=(0.5 / small, 0.5 / large) if load > 0.0 else (math.inf, math.inf),
        peak_pressure=spot.peak_pressure,
        law_error=coefficient / exact - 1.0 if load > 0.0 else 0.0,
        impulse=z,
        friction_impulse=math.hypot(x, y),
        restitution=out / into if into > 0.0 else None,
    )


class _OpenContact:
    """The greatest load of the contact that goes on, as seen at the outputs."""

    def __init__(self):
        self.start: float | None = None
        self.peak = np.zeros(5)  # load, approach, semi-axes, pressure

    def add(self, block: Block) -> None:
        """Takes a block in: only outputs after the last touch count."""
        touches = block.records.get(TOUCH.name, ())
        if len(touches):
            self.start, self.peak = float(touches[-1, 0]), np.zeros(5)
        ends = block.records.get(CONTACT.name, ())
        if self.start is not None and len(ends) and float(ends[-1, 0]) >= self.start:
            self.start = None
        if self.start is None:
            return
        names = ("normal_load", "approach", "semi_major", "semi_minor", "peak_pressure")
        rows = 1e-9 * block.time_ns >= self.start
        for place, name in enumerate(names):
            self.peak[place] = max(self.peak[place], float(block.values[name][rows].max(initial=0.0)))

    def bounce(self, until: float) -> Bounce:
        """As a bounce that has not ended."""
        load, approach, major, minor, pressure = map(float, self.peak)
        return Bounce(
            self.start, until - self.start, load, approach, (major, minor), (math.inf, math.inf), pressure, 0.0
        )


class EllipsoidFigures:
    """Gathers contacts and the books of energy and momentum of the outputs given out."""

    spent = ENERGIES[3:]
    """Channels of energies that are stored no more."""

    def __init__(self, parameters: EllipsoidOnPlaneScene, choice: Choice):
        self.parameters, self.law = parameters, choice.law
        self.until, self.first, self.last, self.gain, self.scale = 0.0, {}, {}, 0.0, 0.0
        self._ended: list[Bounce] = []
        self._going_on = _OpenContact()

    def add(self, block: Block) -> None:
        stored = sum(block.values[name] for name in ENERGIES[:3])
        total = stored + sum(block.values[name] for name in self.spent)
        if not self.first:
            self.first = self._instant(block, stored, total, 0)
        self.last = self._instant(block, stored, total, -1)
        self.scale = max(self.scale, float(self.brought(block).max()))
        if self.scale > 0.0:
            self.gain = max(self.gain, float(total.max() - self.first["total"]) / self.scale)
        self.until = 1e-9 * float(block.time_ns[-1])
        self._ended.extend(map(self.ended, block.records.get(CONTACT.name, ())))
        self._going_on.add(block)

    def brought(self, block: Block) -> np.ndarray:
        """The energy [J] at the outputs whose most the balances are measured by."""
        return sum(block.values[name] for name in ENERGIES[:3])

    def ended(self, row: np.ndarray) -> Bounce:
        """One contact from its record."""
        return _ended(row, modulus_of(self.parameters))

    def _instant(self, block, stored, total, row):
        kept = {name: block.values[name][row] + 0.0 for name in ("velocity", "angular_momentum", "position")}
        names = (*self.spent, "quaternion_drift")
        numbers = {name: float(block.values[name][row]) for name in names if name in block.values}
        return {"stored": float(stored[row]), "total": float(total[row]), **numbers, **kept}

    def bounces(self) -> list[Bounce]:
        """All contacts, the one that goes on last."""
        goes_on = self._going_on.start is not None
        return [*self._ended, self._going_on.bounce(self.until)] if goes_on else list(self._ended)

    def figures(self) -> dict[str, Any]:
        """Contacts and balances; velocities and angular momentum as changes since the first output.

        The first 200 contacts are listed one by one. `restitution` is that of the first, `resting_since_s` the begin of
        one that goes on at the end.
        """
        bounces = self.bounces()
        velocity, turning = (self.last[name] - self.first[name] for name in ("velocity", "angular_momentum"))
        return {
            "peak_force_n": max((one.peak_load for one in bounces), default=0.0),
            "contact_count": len(bounces),
            "contact_duration_s": math.fsum(one.duration for one in bounces),
            "contacts": [_row(one) for one in bounces[:LISTED]],
            "restitution": bounces[0].restitution if bounces else None,
            "resting_since_s": self._going_on.start,
            "greatest_approach_m": max((one.approach for one in bounces), default=0.0),
            "peak_pressure_pa": max((one.peak_pressure for one in bounces), default=0.0),
            "energy_closure": self.closure,
            "greatest_energy_gain": self.gain,
            "energy_start_j": self.first["stored"],
            "energy_end_j": self.last["stored"],
            "dissipated_viscous_j": self.last["dissipated_viscous"],
            "dissipated_friction_j": self.last["dissipated_friction"],
            "velocity_change_x_m_s": float(velocity[0]),
            "velocity_change_y_m_s": float(velocity[1]),
            "angular_momentum_change_vertical_nms": float(turning[2]),
            "height_at_end_m": float(self.last["position"][2]),
            "quaternion_drift": self.last.get("quaternion_drift", math.nan),
        }

    def flags(self) -> list[str]:
        """Warnings of the run, one sentence each."""
        drift = self.last.get("quaternion_drift", 0.0)
        drifted = (
            f"the quaternion's norm drifted by {drift:.2g} in one step before it was put right: "
            "tighten wanted.tolerance"
        )
        return self.contact_flags() + ([drifted] if drift > GREATEST_DRIFT else [])

    def contact_flags(self) -> list[str]:
        """Warnings of contacts outside Hertz's theory."""
        body, material = self.parameters.body, self.parameters.body.material
        strength = yield_pressure(material, self.parameters.plane.material)
        return self.doubts(strength, wave_transit(2.0 * max(body.semi_axes), material.young_modulus, material.density))

    def doubts(self, strength: float | None, transit: float) -> list[str]:
        """Doubts about the contacts: yield pressure [Pa] or None, and the time [s] a wave takes through a body."""
        loaded = [one for one in self.bounces() if one.peak_load > 0.0]
        if not loaded:
            return []
        hardest = max(loaded, key=lambda one: one.peak_pressure)
        deepest = max(loaded, key=lambda one: one.approach)
        worst = max(loaded, key=lambda one: abs(one.law_error))
        heavy = NOTABLE * max(one.peak_load for one in loaded)
        shortest = min((one.duration for one in loaded if not one.open and one.peak_load > heavy), default=math.inf)
        return gathered(
            pressure_doubt(hardest.peak_pressure, strength),
            width_doubt(deepest.semi_axes[0], deepest.radii[0]),
            width_doubt(deepest.semi_axes[1], deepest.radii[1]),
            None
            if self.law not in LAWS or LAWS[self.law].measured
            else law_doubt(self.law, worst.law_error, worst.semi_axes[1] / worst.semi_axes[0]),
            wave_doubt(shortest, transit),
        )

    @property
    def closure(self) -> float:
        """Energy gained (+) or lost (-) by the numbers, as a share of the greatest energy stored."""
        return (self.last["total"] - self.first["total"]) / self.scale if self.scale > 0.0 else 0.0

    def status(self) -> str:
        return "done" if adds_up(max(abs(self.closure), self.gain), self.parameters) else "failed: energy"


def _row(bounce):
    return {
        "start_s": bounce.start,
        "duration_s": bounce.duration,
        "peak_force_n": bounce.peak_load,
        "impulse_ns": bounce.impulse,
        "friction_impulse_ns": bounce.friction_impulse,
        "restitution": bounce.restitution,
    }
