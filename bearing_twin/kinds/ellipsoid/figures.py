"""What a run of an ellipsoid on a plane found: its contacts, the balances, and what to doubt."""

import math
from typing import NamedTuple

from bearing_twin.contact.ellipse import ellipse, hertz_coefficient
from bearing_twin.contact.validity import gathered, law_doubt, pressure_doubt, wave_doubt, wave_transit, width_doubt
from bearing_twin.kinds.ellipsoid.chunk import (
    BEGAN,
    ENDED,
    IMPULSE_X,
    IMPULSE_Y,
    IMPULSE_Z,
    PEAK_APPROACH,
    PEAK_COEFFICIENT,
    PEAK_LARGE,
    PEAK_LOAD,
    PEAK_SMALL,
    SPEED_IN,
    SPEED_OUT,
)
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene
from bearing_twin.kinds.impact.impact import ENERGY_GAIN
from bearing_twin.sample import Block

LISTED = 200  # contacts named one by one in a report
NOTABLE = 0.01  # of the greatest load: lighter touches say nothing about waves in the body
ENERGIES = ("kinetic_energy", "potential_energy", "elastic_energy", "dissipated_viscous", "dissipated_friction")


class Bounce(NamedTuple):
    """One contact: seconds, N, m, N s; `restitution` None where it has not ended by the last output."""

    start: float
    duration: float
    open: bool
    peak_load: float
    approach: float
    small: float
    large: float
    coefficient: float
    impulse: float | None
    friction_impulse: float | None
    restitution: float | None


def _bounce(row, until):
    ended = row[ENDED] <= until  # False for NaN too
    into, out = float(row[SPEED_IN]), float(row[SPEED_OUT])
    return Bounce(
        float(row[BEGAN]),
        float((row[ENDED] if ended else until) - row[BEGAN]),
        not ended,
        float(row[PEAK_LOAD]),
        float(row[PEAK_APPROACH]),
        float(row[PEAK_SMALL]),
        float(row[PEAK_LARGE]),
        float(row[PEAK_COEFFICIENT]),
        float(row[IMPULSE_Z]) if ended else None,
        math.hypot(row[IMPULSE_X], row[IMPULSE_Y]) if ended else None,
        out / into if ended and into > 0.0 else None,
    )


def bounces_until(records, open_record, until: float) -> list[Bounce]:
    """The contacts begun by `until` [s], from rows of a chunk's records and the row of the contact still going on."""
    rows = records if open_record is None else [*records, open_record]
    return [_bounce(row, until) for row in rows if row[BEGAN] <= until]


def contact_figures(bounces: list[Bounce], modulus: float) -> dict:
    """What the contacts amount to, by SI-suffixed keys; the first 200 one by one."""
    lasting = bool(bounces) and bounces[-1].open
    return {
        "peak_force_n": max((one.peak_load for one in bounces), default=0.0),
        "contact_count": len(bounces),
        "contact_duration_s": math.fsum(one.duration for one in bounces),
        "contacts": [_row(one) for one in bounces[:LISTED]],
        "restitution": bounces[0].restitution if bounces else None,
        "resting_since_s": bounces[-1].start if lasting else None,
        "greatest_approach_m": max((one.approach for one in bounces), default=0.0),
        "peak_pressure_pa": max((_ellipse(one, modulus).peak_pressure for one in bounces), default=0.0),
    }


def contact_flags(bounces: list[Bounce], parameters: EllipsoidOnPlaneScene, law: str, modulus: float) -> list[str]:
    """What in the contacts lies outside the theory, one sentence each."""
    loaded = [one for one in bounces if one.peak_load > 0.0]
    if not loaded:
        return []
    body, material = parameters.body, parameters.body.material
    hardest = max(loaded, key=lambda one: _ellipse(one, modulus).peak_pressure)
    deepest = max(loaded, key=lambda one: one.approach)
    worst = max(loaded, key=lambda one: abs(_law_error(one, modulus)))
    wide, spot = _ellipse(deepest, modulus), _ellipse(worst, modulus)
    heavy = NOTABLE * max(one.peak_load for one in loaded)
    shortest = min((one.duration for one in loaded if not one.open and one.peak_load > heavy), default=math.inf)
    return gathered(
        pressure_doubt(_ellipse(hardest, modulus).peak_pressure, parameters.contact.yield_pressure),
        width_doubt(wide.semi_major, 0.5 / deepest.small),
        width_doubt(wide.semi_minor, 0.5 / deepest.large),
        law_doubt(law, _law_error(worst, modulus), spot.semi_minor / spot.semi_major),
        wave_doubt(shortest, wave_transit(2.0 * max(body.semi_axes), material.young_modulus, material.density)),
    )


def _ellipse(bounce, modulus):
    return ellipse(bounce.small, bounce.large, modulus, bounce.peak_load)


def _law_error(bounce, modulus):
    return bounce.coefficient / hertz_coefficient(bounce.small, bounce.large, modulus) - 1.0


def _row(bounce):
    return {
        "start_s": bounce.start,
        "duration_s": bounce.duration,
        "peak_force_n": bounce.peak_load,
        "impulse_ns": bounce.impulse,
        "friction_impulse_ns": bounce.friction_impulse,
        "restitution": bounce.restitution,
    }


class Books:
    """Energy and momentum of the outputs given out."""

    def __init__(self):
        self.until, self.first, self.last, self.gain, self.scale = 0.0, {}, {}, 0.0, 0.0

    def add(self, block: Block) -> None:
        """Takes a block in."""
        stored = sum(block.values[name] for name in ENERGIES[:3])
        total = stored + sum(block.values[name] for name in ENERGIES[3:])
        if not self.first:
            self.first = self._instant(block, stored, total, 0)
        self.last = self._instant(block, stored, total, -1)
        self.scale = max(self.scale, float(stored.max()))
        if self.scale > 0.0:
            self.gain = max(self.gain, float(total.max() - self.first["total"]) / self.scale)
        self.until = 1e-9 * float(block.time_ns[-1])

    @staticmethod
    def _instant(block, stored, total, row):
        kept = {name: block.values[name][row] + 0.0 for name in ("velocity", "angular_momentum")}
        lost = {name: float(block.values[name][row]) for name in ENERGIES[3:]}
        return {"stored": float(stored[row]), "total": float(total[row]), **lost, **kept}

    def figures(self) -> dict:
        """Balances by SI-suffixed keys; velocities and angular momentum as changes since the first output."""
        velocity, turning = (self.last[name] - self.first[name] for name in ("velocity", "angular_momentum"))
        return {
            "energy_closure": self.closure,
            "greatest_energy_gain": self.gain,
            "energy_start_j": self.first["stored"],
            "energy_end_j": self.last["stored"],
            "dissipated_viscous_j": self.last["dissipated_viscous"],
            "dissipated_friction_j": self.last["dissipated_friction"],
            "velocity_change_x_m_s": float(velocity[0]),
            "velocity_change_y_m_s": float(velocity[1]),
            "angular_momentum_change_vertical_nms": float(turning[2]),
        }

    @property
    def closure(self) -> float:
        """Energy gained by the numbers, as a share of the greatest energy stored."""
        return (self.last["total"] - self.first["total"]) / self.scale if self.scale > 0.0 else 0.0

    @property
    def status(self) -> str:
        """ "done", or what failed."""
        wrong = not max(abs(self.closure), self.gain) <= ENERGY_GAIN
        return "failed: energy" if wrong else "done"
