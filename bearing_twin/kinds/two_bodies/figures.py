"""The figures of two bodies: contacts, balances, what to doubt; of outputs and records alone."""

import math
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.ellipsoid.figures import CONTACT as ELLIPSOID_CONTACT
from bearing_twin.kinds.ellipsoid.figures import DEEPEST, TOUCH, Bounce, EllipsoidFigures
from bearing_twin.kinds.ellipsoid.figures import MEANINGS as OF_ELLIPSOID
from bearing_twin.kinds.two_bodies.derived import ROWS, modulus_of, reach_of
from bearing_twin.kinds.two_bodies.outputs import SPENT
from bearing_twin.kinds.two_bodies.parameters import OVERLAP

CONTACT = Table(
    "contact",
    (
        *ELLIPSOID_CONTACT.columns[:7],
        Channel("semi_major", "m", (), "at the greatest load"),
        Channel("semi_minor", "m", (), "at the greatest load"),
        Channel("peak_pressure", "Pa", (), "at the greatest load"),
        *ELLIPSOID_CONTACT.columns[7:9],
        Channel("impulse", "N s", (), "of the normal load"),
        Channel("friction_impulse", "N s", (), "size of that of friction"),
        DEEPEST,
    ),
    "a contact that has ended",
)
LEFT_OUT = ("height_at_end_m", "angular_momentum_change_vertical_nms")
MEANINGS = {key: text for key, text in OF_ELLIPSOID.items() if key not in LEFT_OUT} | {
    "energy_closure": "energy gained (+) or lost (-) by the numbers over the run, as a share of the most ever kinetic "
    "and elastic",
    "greatest_energy_gain": "the most energy gained by the numbers at any output, as the same share",
    "velocity_change_x_m_s": "of the first body's centre along x since the start, at the end",
    "velocity_change_y_m_s": "of the first body's centre along y since the start, at the end",
    "velocity_change_z_m_s": "of the first body's centre along z since the start, at the end",
    "held_work_j": "done on held bodies since the start, at the end",
    "tracking_error_m": "most by which opposing points missed their equations at a step's end, over the run",
}


def tables(parameters) -> tuple[Table, ...]:
    """What two bodies record."""
    return TOUCH, CONTACT


class TwoBodiesFigures(EllipsoidFigures):
    """Gathers contacts and the books of energy and momentum of the outputs given out."""

    spent = SPENT

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._off = 0.0

    def add(self, block: Block) -> None:
        super().add(block)
        self._off = float(block.values["tracking_error"][-1])

    def brought(self, block: Block) -> np.ndarray:
        """Kinetic and elastic: potential energy has its zero anywhere."""
        return block.values["kinetic_energy"] + block.values["elastic_energy"]

    def ended(self, row: np.ndarray) -> Bounce:
        """One contact from its record."""
        end, start, load, approach, small, large, coefficient, major, minor, pressure, *rest = map(float, row)
        into, out, impulse, rub, *deepest = rest
        ellipse = small > 0.0 and load > 0.0 and self.law != OVERLAP
        exact = hertz_coefficient(small, large, modulus_of(self.parameters)) if ellipse else 1.0
        return Bounce(
            start=start,
            duration=end - start,
            peak_load=load,
            approach=deepest[0] if deepest else approach,
            semi_axes=(major, minor),
            radii=(0.5 / small if small > 0.0 else math.inf, 0.5 / large if large > 0.0 else math.inf),
            peak_pressure=pressure,
            law_error=coefficient / exact - 1.0 if ellipse else 0.0,
            impulse=impulse,
            friction_impulse=rub,
            restitution=out / into if into > 0.0 else None,
        )

    def figures(self) -> dict[str, Any]:
        """As of an ellipsoid on a plane; `restitution` is that of the first contact, along the normal."""
        change = self.last["velocity"] - self.first["velocity"]
        more = {
            "velocity_change_z_m_s": float(change[2]),
            "held_work_j": self.last["held_work"],
            "tracking_error_m": self._off,
        }
        found = super().figures() | more
        return {key: found[key] for key in MEANINGS}

    def contact_flags(self) -> list[str]:
        """What in the contacts lies outside the theory."""
        one, other = self.parameters.first, self.parameters.second
        transits = [
            wave_transit(2.0 * reach_of(body), body.material.young_modulus, body.material.density)
            for body in (one, other)
            if ROWS[body.shape].solid
        ]
        return self.doubts(yield_pressure(one.material, other.material), max(transits))
