"""The figures and quantities of bodies that collide: functions of outputs and records alone.

`ImpactFigures` are those of an impact of two spheres, two discs, or a sphere on a beam; `BouncingFigures` those of
bodies that bounce, an ellipsoid on a plane or any two.
"""

import math
from typing import Any

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.contact.elasticity import ellipse, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import gathered, law_warning, pressure_warning, wave_warning, width_warning
from bearing_twin.kinds.bodies import LISTED, MEANINGS_OF_ELLIPSOID, MEANINGS_OF_PAIR
from bearing_twin.kinds.bodies.derived import patch_of, transit_of
from bearing_twin.kinds.bodies.parameters import OVERLAP, TwoBodiesScene
from bearing_twin.kinds.contract import adds_up

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
FIGURES = ("peak_force_n", "contact_duration_s", "greatest_approach_m", "restitution", "impulse_ns")
START, DURATION, PEAK_FORCE, IMPULSE, GREATEST_APPROACH, LEAVING, GAINED = range(1, 8)

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
OF_IMPACT, OF_ELLIPSOID, OF_PAIR = (CONTACT,), (TOUCH, BOUNCE), (TOUCH, BOUNCE_OF_PAIR)
"""Tables of the records of two spheres or discs, of an ellipsoid on a plane and of two bodies."""


# Impacts


def contact_rows(contacts, deepest, leaving: float, gained: float) -> np.ndarray:
    """Rows (n, columns) of CONTACT; the last one carries the speed away and the energy gained in all [J]."""
    rows = np.zeros((len(contacts), len(CONTACT.columns)))
    for row, contact, depth in zip(rows, contacts, deepest, strict=True):
        row[: GREATEST_APPROACH + 1] = contact.start + contact.duration, *contact, depth
    rows[-1:, LEAVING], rows[-1:, GAINED] = leaving, gained
    return rows


def contact_warnings(bodies, pressure: float, shortest: float, widths) -> list[str]:
    """Warnings of contacts outside the limits of Hertz's theory, one sentence each.

    `pressure` [Pa] is the greatest, `shortest` [s] the least duration; `widths` are semi-axes [m], what they must be
    small against [m], and its name.
    """
    return gathered(
        pressure_warning(pressure, yield_pressure(*(body.material for body in bodies))),
        *(width_warning(*width) for width in widths),
        wave_warning(shortest, max(map(transit_of, bodies))),
    )


class ImpactFigures:
    """Gathers the records of an impact and its first and last output."""

    def __init__(self, parameters, choice):
        self.parameters, self.choice, self.speed = parameters, choice, self.speed_of(parameters)
        self.until, self.initial_energy = 0.0, None
        self.last: dict[str, np.ndarray] = {}
        self._rows = [np.empty((0, len(CONTACT.columns)))]

    @staticmethod
    def speed_of(parameters) -> float:
        """Speed [m/s] at the first touch."""
        return parameters.motion.speed

    def add(self, block: Block) -> None:
        if self.initial_energy is None:
            self.initial_energy = float(block.values["kinetic_energy"][0])
        self._rows.append(block.records.get("contact", self._rows[0]))
        self.last = {name: values[-1] for name, values in block.values.items() if values.ndim == 1}
        self.until = 1e-9 * float(block.time_ns[-1])

    @property
    def contacts(self) -> np.ndarray:
        """The contacts so far, rows of CONTACT."""
        return np.concatenate(self._rows)

    @property
    def peak_force(self) -> float:
        """Greatest contact force [N]."""
        return float(self.contacts[:, PEAK_FORCE].max(initial=0.0))

    @property
    def restitution(self) -> float | None:
        """Relative speed away over relative speed before; None before the first contact has ended."""
        return float(self.contacts[-1, LEAVING]) / self.speed if len(self.contacts) else None

    @property
    def energy_gained(self) -> float:
        """Energy [J] gained by the numerical method."""
        return math.fsum(self.contacts[:, GAINED])

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys, over all contacts that have ended."""
        contacts, keys = self.contacts, ("start_s", "duration_s", "peak_force_n", "impulse_ns")
        return {
            "peak_force_n": self.peak_force,
            "contact_duration_s": sum(map(float, contacts[:, DURATION])),
            "contacts": [dict(zip(keys, map(float, row[START:GREATEST_APPROACH]), strict=True)) for row in contacts],
            "greatest_approach_m": float(contacts[:, GREATEST_APPROACH].max(initial=0.0)),
            "restitution": self.restitution,
            "energy_closure": self.energy_gained / self.initial_energy if self.initial_energy else 0.0,
            "impulse_ns": math.fsum(contacts[:, IMPULSE]),
            "impact_speed_m_s": self.speed,
        }

    def flags(self) -> list[str]:
        """A warning where the outputs do not hold the whole contact."""
        last = float(self.contacts[:, [START, DURATION]].sum(axis=1).max(initial=0.0))
        if self.until >= last:
            return []
        return [f"the outputs end at {self.until:.4g} s, before the contact does at {last:.4g} s"]

    def status(self) -> str:
        return "done" if adds_up(self.figures()["energy_closure"], self.parameters) else "failed: energy"


class PairFigures(ImpactFigures):
    """The figures of two spheres or two discs."""

    def flags(self) -> list[str]:
        """Warnings: conditions outside the theory, and outputs that end before the contact."""
        if not len(self.contacts):
            return []
        bodies, (_, half_width, pressure) = self.parameters.bodies, patch_of(self.parameters, self.peak_force)
        shortest, size = float(self.contacts[:, DURATION].min()), min(body.radius for body in bodies)
        warnings = contact_warnings(bodies, pressure, shortest, [(half_width, size, "smaller radius")])
        thickness = getattr(bodies[0], "thickness", math.inf)
        # A law that is specified has a range of thicknesses, which says so.
        if thickness < size and self.parameters.contact.normal == "auto":
            warnings.append(
                f"a thickness of {thickness:g} m is below the radius of {size:g} m: both assume plane strain"
            )
        return warnings + super().flags()


# Bodies that bounce

PEAKS = {
    "normal_load": "peak_load", "approach": "greatest_approach", "semi_major": "semi_major", "semi_minor": "semi_minor",
    "peak_pressure": "peak_pressure",
}  # fmt: skip
"""Channels whose greatest values at the outputs are those of the present contact, and its columns."""
LISTED_AS = {
    "start_s": "start", "duration_s": "duration", "peak_force_n": "peak_load", "impulse_ns": "impulse",
    "friction_impulse_ns": "friction_impulse", "restitution": "restitution",
}  # fmt: skip


class BouncingFigures:
    """Contacts and the balances of energy and momentum of the outputs.

    Of an ellipsoid on a plane and of two bodies, whose records hold the contact ellipse, whose potential energy has its
    zero anywhere, and which may do work on a held body.
    """

    stored = ("kinetic_energy", "potential_energy", "elastic_energy")

    def __init__(self, parameters, choice: Choice):
        self.parameters, self.law, self.pair = parameters, choice.law, isinstance(parameters, TwoBodiesScene)
        self.until, self.first, self.last, self.gain, self.scale = 0.0, {}, {}, 0.0, 0.0
        self._columns = [channel.name for channel in (BOUNCE_OF_PAIR if self.pair else BOUNCE).columns]
        self._spent = ("dissipated_viscous", "dissipated_friction", *(("held_work",) if self.pair else ()))
        self._brought = (self.stored[0], self.stored[2]) if self.pair else self.stored
        self._rows: list[np.ndarray] = []
        self._open, self._peaks = None, np.zeros(0)  # start [s] of the present contact

    def add(self, block: Block) -> None:
        stored = sum(block.values[name] for name in self.stored)
        total = stored + sum(block.values[name] for name in self._spent)
        if not self.first:
            self.first = self._instant(block, stored, total, 0)
        self.last = self._instant(block, stored, total, -1)
        self.scale = max(self.scale, float(np.abs(sum(block.values[name] for name in self._brought)).max()))
        if self.scale > 0.0:
            self.gain = max(self.gain, float(total.max() - self.first["total"]) / self.scale)
        self.until = 1e-9 * float(block.time_ns[-1])
        touches, ends = (block.records.get(table.name, ()) for table in (TOUCH, BOUNCE))
        if len(ends):
            self._rows.append(ends)
        if len(touches):
            self._open, self._peaks = float(touches[-1, 0]), np.zeros(len(PEAKS))
        if self._open is not None and len(ends) and float(ends[-1, 0]) >= self._open:
            self._open = None
        if self._open is not None:
            rows = 1e-9 * block.time_ns >= self._open
            self._peaks = np.maximum(self._peaks, [block.values[name][rows].max(initial=0.0) for name in PEAKS])

    def _instant(self, block, stored, total, row):
        vectors = {name: block.values[name][row] + 0.0 for name in ("velocity", "angular_momentum", "position")}
        names = (*self._spent, "quaternion_drift", "tracking_error")
        numbers = {name: float(block.values[name][row]) for name in names if name in block.values}
        return {"stored": float(stored[row]), "total": float(total[row]), **numbers, **vectors}

    def contacts(self) -> dict[str, np.ndarray]:
        """Columns (n,) of all contacts in SI, the present one last, with NaN for values at its end."""
        rows = np.concatenate(self._rows) if self._rows else np.empty((0, len(self._columns)))
        columns = dict(zip(self._columns, rows.T, strict=False))
        columns.setdefault("greatest_approach", columns["approach"])  # logs of earlier versions lack it
        loaded, modulus = columns["peak_load"] > 0.0, self.parameters.modulus
        gap = [np.where(loaded, columns[f"curvature_{size}"], 1.0) for size in ("small", "large")]
        if not self.pair:
            patch = np.where(loaded, ellipse(*gap, modulus, columns["peak_load"]), 0.0)
            columns |= dict(zip(("semi_major", "semi_minor", "peak_pressure"), patch, strict=True))
            columns |= {
                "impulse": columns["impulse_z"],
                "friction_impulse": np.hypot(columns["impulse_x"], columns["impulse_y"]),
            }
        elliptic = loaded & (gap[0] > 0.0) & (self.law != OVERLAP)
        exact = hertz_coefficient(*np.where(elliptic, gap, 1.0), modulus)
        approach_speed = np.where(columns["speed_in"] > 0.0, columns["speed_in"], math.nan)
        columns |= {
            "duration": columns["time"] - columns["start"],
            "law_error": np.where(elliptic, columns["coefficient"] / exact - 1.0, 0.0),
            "restitution": columns["speed_out"] / approach_speed,
        }
        if self._open is None:
            return columns
        last = {"start": self._open, "duration": self.until - self._open, "law_error": 0.0}
        last |= dict(zip(PEAKS.values(), self._peaks, strict=True))
        return {name: np.append(column, last.get(name, math.nan)) for name, column in columns.items()}

    def figures(self) -> dict[str, Any]:
        """Contacts and balances; velocities and angular momentum as changes since the first output."""
        contacts, last = self.contacts(), self.last
        velocity, turning = (last[name] - self.first[name] for name in ("velocity", "angular_momentum"))
        listed = {key: contacts[name][:LISTED].tolist() for key, name in LISTED_AS.items()}
        rows = [
            {key: None if math.isnan(value) else value for key, value in zip(listed, row, strict=True)}
            for row in zip(*listed.values(), strict=True)
        ]
        greatest = {name: float(contacts[name].max(initial=0.0)) for name in PEAKS.values()}
        figures = {
            "peak_force_n": greatest["peak_load"],
            "contact_count": len(contacts["start"]),
            "contact_duration_s": math.fsum(contacts["duration"]),
            "contacts": rows,
            "restitution": rows[0]["restitution"] if rows else None,
            "resting_since_s": self._open,
            "greatest_approach_m": greatest["greatest_approach"],
            "peak_pressure_pa": greatest["peak_pressure"],
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
        return {key: figures[key] for key in (MEANINGS_OF_PAIR if self.pair else MEANINGS_OF_ELLIPSOID)}

    def flags(self) -> list[str]:
        """Warnings of the run, one sentence each: contacts outside Hertz's theory, and the quaternion's drift."""
        flags, drift = self._contact_flags(), self.last.get("quaternion_drift", 0.0)
        if drift > GREATEST_DRIFT:
            flags.append(
                f"the quaternion's norm drifted by {drift:.2g} in one step before normalisation: "
                "tighten wanted.tolerance"
            )
        return flags

    def _contact_flags(self) -> list[str]:
        contacts = self.contacts()
        loaded = {name: column[contacts["peak_load"] > 0.0] for name, column in contacts.items()}
        load, duration = loaded["peak_load"], loaded["duration"]
        if not len(load):
            return []
        deepest = {name: column[np.argmax(loaded["greatest_approach"])] for name, column in loaded.items()}
        curvatures = [("semi_major", "curvature_small"), ("semi_minor", "curvature_large")]
        widths = [
            (deepest[axis], 0.5 / deepest[curvature]) for axis, curvature in curvatures if deepest[curvature] > 0.0
        ]
        heavy = (load > NOTABLE * load.max()) & np.isfinite(loaded["impulse"])
        shortest = float(duration[heavy].min(initial=math.inf))
        warnings = contact_warnings(self.parameters.bodies, float(loaded["peak_pressure"].max()), shortest, widths)
        if self.law in LAWS and not LAWS[self.law].measured:
            worst = np.argmax(np.abs(loaded["law_error"]))
            ratio = loaded["semi_minor"][worst] / loaded["semi_major"][worst]
            warnings += gathered(law_warning(self.law, loaded["law_error"][worst], ratio))
        return warnings

    @property
    def closure(self) -> float:
        """Energy gained (+) or lost (-) by the method, as a share of the greatest energy stored."""
        return (self.last["total"] - self.first["total"]) / self.scale if self.scale > 0.0 else 0.0

    def status(self) -> str:
        return "done" if adds_up(max(abs(self.closure), self.gain), self.parameters) else "failed: energy"
