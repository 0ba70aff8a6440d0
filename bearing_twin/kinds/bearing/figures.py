"""What a bearing run found: loads, speeds, ellipses, the energy balance, and what to doubt."""

import math

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.contact.elasticity import approaches_of_loads, coefficient_of, elastic
from bearing_twin.contact.ellipse import axis_ratio, hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus, yield_pressure
from bearing_twin.contact.validity import (
    gathered,
    groove_doubt,
    law_doubt,
    pressure_doubt,
    shoulder_doubt,
    wave_doubt,
    wave_transit,
)
from bearing_twin.kinds.bearing.adequacy import untouched
from bearing_twin.kinds.bearing.figure_rows import MEANINGS, missing
from bearing_twin.kinds.bearing.friction_torque import catalogue_torque
from bearing_twin.kinds.bearing.law_error import law_error
from bearing_twin.kinds.bearing.outputs import ellipses, moduli
from bearing_twin.kinds.bearing.parameters import BearingScene, as_chosen
from bearing_twin.kinds.bearing.ratings import ratings_of
from bearing_twin.kinds.bearing.rings import PRESCRIBED, QUASI_STATIC, dimension_of
from bearing_twin.kinds.bearing.run_up import RunUp
from bearing_twin.kinds.bearing.speeds import off_rolling, speed_figures
from bearing_twin.kinds.bearing.summing import AT_GREATEST, RING_COLUMNS, Sums, centre_figures, columns_of, mean_torque
from bearing_twin.kinds.energy import STORED, adds_up

PERMANENT_PRESSURE = 4.2e9  # Pa; ISO 76: beyond it a ball bearing keeps a dent of 1e-4 ball diameters
NO_SPIN, FREE_OF_SMOOTHING = 1e-3, 10.0  # spin over smoothing speed: no drilling to speak of; within 4 % of its limit
STILL = 1e-5  # of the energy held, or as much as the tolerance leaves open: what is less is no work
ROUNDING = 1e-14  # of a ball's loads times its radius: a torque that is less is none
UNEVEN, SLOW = math.radians(2.0), 0.01  # of spacing, of orbit speed: beyond, a cage is missed


class BearingFigures:
    """Gathers a run's figures block by block, in memory that does not grow with the run."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.choice, self.law = as_chosen(parameters, choice), choice, choice.law
        self.first, self.last = {}, {}
        self._balls = parameters.geometry.balls
        self._static = ratings_of(parameters).static
        self._sums, self._run_up = Sums(self._balls), RunUp(parameters)
        self._layout, self._columns = None, None
        self._made: dict = {}  # of the outputs so far, what several figures and flags are made of

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._made = {}
        layout = block.values.layout
        if layout is not self._layout:
            self._layout, self._columns = layout, columns_of(layout)
        self._sums.add(block, self._columns)
        self._run_up.add(block)
        if not self.first:
            self.first = self._instant(block, 0)
        self.last = self._instant(block, len(block) - 1)

    @property
    def samples(self) -> int:
        """Outputs so far."""
        return self._sums.outputs

    @property
    def greatest_load(self) -> np.ndarray:
        """Greatest loads [N] of the contacts (N, 2)."""
        return self._sums.greatest.load.reshape(-1, 2)

    @property
    def at_greatest(self) -> dict[str, np.ndarray]:
        """Shapes of the contacts (N, 2) at their greatest loads, by channel."""
        return dict(zip(AT_GREATEST, self._sums.greatest.there.reshape(len(AT_GREATEST), -1, 2), strict=True))

    @staticmethod
    def _instant(block: Block, row: int) -> dict:
        names = (*STORED, "drive_work", "dissipated", "inner_ring_speed")
        names += ("gross_work",) if "gross_work" in block.values else ()  # logs of the first version have none
        values = {name: float(block.values[name][row]) for name in names}
        return {
            "time": 1e-9 * int(block.time_ns[row]),
            "orbit_angle": block.values["orbit_angle"][row].copy(),
            "turned": (values["drive_work"], float(block.values["inner_ring_angle"][row])),
            **values,
        }

    def _second_half(self) -> tuple[dict, dict]:
        """The merged second half of the run, and the instant it starts from."""
        if "halves" not in self._made:
            self._made["halves"] = self._halved()
        return self._made["halves"]

    def _halved(self) -> tuple[dict, dict]:
        times, angles, turned = self._sums.ends()
        middle = 0.5 * (self.first["time"] + times[-1])
        first = min(int(np.searchsorted(times, middle, side="right")), len(times) - 1)
        before = self.first
        if first:
            before = {"time": times[first - 1], "orbit_angle": angles[first - 1], "turned": turned[first - 1]}
        return self._sums.from_row(first), before

    def _work_known(self, late: dict, before: dict) -> bool:
        """True if the work of turning the ring is known over this part of the run: apart from loads, without a shift.

        A shift of a ring that is held is work of the drive. Logs of earlier versions hold no work of loads.
        """
        change = self.parameters.drive.change
        shifted = change.time and any(change.offset) and before["time"] <= change.time <= late["time"]
        apart = "inner_ring_load_work" in self._layout.places or dimension_of(self.parameters) == PRESCRIBED
        return apart and not shifted

    @property
    def energy_closure(self) -> float:
        """Energy gained (+) or lost (-) by the numbers alone, as a share of the work moved through the bearing.

        The work counts each contact's power by its magnitude; logs of the first version hold only the sum. Where hardly
        anything does work, as without friction, it is a share of what the tolerance leaves open of the energy held.
        """
        change = sum(self.last[name] - self.first[name] for name in STORED)
        lost, work = (self.last[name] - self.first[name] for name in ("dissipated", "drive_work"))
        residual = change + lost - work
        moved = self.last["gross_work"] - self.first["gross_work"] if "gross_work" in self.last else abs(work)
        held = sum(abs(self.last[name]) for name in STORED)
        scale = max(moved, lost, abs(change), max(STILL, self.parameters.wanted.tolerance) * held)
        return residual / scale if scale > 0.0 else 0.0

    def _peaks(self) -> dict[str, np.ndarray]:
        """Ellipses and pressures at each contact's greatest load."""
        if "peaks" not in self._made:
            curvatures = (self.at_greatest[name] for name in ("curvature_small", "curvature_large"))
            found = ellipses(moduli(self.parameters.materials), *curvatures, self.greatest_load)
            self._made["peaks"] = dict(zip(("semi_major", "semi_minor", "peak_pressure"), found, strict=True))
        return self._made["peaks"]

    def _law_doubt(self) -> str | None:
        """Doubt about the elastic law where it is furthest off exact Hertz, over the contacts that carried load."""
        curvatures = [self.at_greatest[name] for name in ("curvature_small", "curvature_large")]
        errors = law_error(self.parameters, self.law, *curvatures, self.greatest_load)
        if errors is None or not errors.any():
            return None
        side, ball = divmod(int(np.abs(errors.T).argmax()), len(errors))
        at = (float(one[ball, side]) for one in curvatures)
        return law_doubt(self.law, float(errors[ball, side]), axis_ratio(*at))

    def _smoothing_doubt(self, fastest: float) -> str | None:
        """Doubt about a drilling torque whose spots spin at most this fast [m/s] at their ends."""
        contact = self.parameters.contact
        smoothing = contact.friction_regularisation
        hidden = NO_SPIN * smoothing < fastest < FREE_OF_SMOOTHING * smoothing
        if not (hidden and FRICTIONS[contact.friction].over_spot):
            return None
        return (
            f"the spots spin at {fastest:.2g} m/s at most, which contact.friction_regularisation = {smoothing:g} m/s "
            f"smooths: drilling torques are too small; set it to {fastest / FREE_OF_SMOOTHING:.1g} m/s or less"
        )

    def _half_period(self) -> float:
        """Half a period [s] of a ball between its contacts at their greatest load: its contacts are no shorter."""
        materials, law, stiffness = self.parameters.materials, LAWS[self.law], 0.0
        for side, ring in enumerate((materials.inner_ring, materials.outer_ring)):
            load = self.greatest_load[:, side]
            small, large = (self.at_greatest[name][:, side] for name in ("curvature_small", "curvature_large"))
            ball = int(load.argmax())
            if load[ball] > 0.0:
                modulus, at = effective_modulus(materials.ball, ring), (float(small[ball]), float(large[ball]))
                given = law.number(self.parameters.contact, hertz_coefficient(*at, modulus))
                coefficient = coefficient_of(law.name, *at, modulus, given)
                approach = approaches_of_loads(coefficient, law.power, float(load[ball]))
                stiffness += elastic(coefficient, law.power, approach).stiffness
        mass = materials.ball.density * math.pi / 6.0 * self.parameters.geometry.ball_diameter**3
        return math.pi * math.sqrt(mass / stiffness) if stiffness > 0.0 else math.inf

    def _cage_doubt(self) -> str | None:
        """Doubt about a bearing without a cage whose balls leave even spacing, or go round as they would not roll."""
        parameters, found = self.parameters, []
        if parameters.cage.kind != "none" or dimension_of(parameters) == QUASI_STATIC:
            return None
        if not self.greatest_load[:, 0].any():
            return None  # nothing drives the balls, which a warning says; no cage mends that
        off_even = float(self._sums.greatest.off_even[0])
        if off_even > UNEVEN:
            found.append(f"their spacing leaves even by {off_even:.2g} rad")
        steady = parameters.initial.motion == "rolling" and not parameters.drive.change.time
        off = off_rolling(speed_figures(parameters, *self._second_half())) if steady else 0.0
        if SLOW < abs(off) < 1.0:
            found.append(f"they go round {100.0 * off:+.2g} % off rolling")
        return f"nothing keeps the balls apart and {' and '.join(found)}; set cage.kind: even" if found else None

    def _touch_doubt(self) -> str | None:
        """Doubt about an inner ring that balls touch at no output."""
        if self.greatest_load[:, 0].any():
            return None
        return untouched(self.parameters, self.last["inner_ring_speed"], self.last["drive_work"])

    def flags(self) -> list[str]:
        """What in this run lies outside the theory's validity, one sentence each."""
        peaks = self._peaks()
        pressure, widths = peaks["peak_pressure"].max(), peaks["semi_major"].max(axis=0)
        materials = self.parameters.materials
        ball, geometry = materials.ball, self.parameters.geometry
        diameter, conformities = geometry.ball_diameter, (geometry.inner_conformity, geometry.outer_conformity)
        return gathered(
            pressure_doubt(pressure, yield_pressure(materials.ball, materials.inner_ring, materials.outer_ring)),
            f"peak pressure {pressure:.3g} Pa is beyond 4.2e+09 Pa: real raceways keep dents"
            if pressure > PERMANENT_PRESSURE
            else None,
            groove_doubt(widths, 0.5 * diameter, conformities),
            shoulder_doubt(geometry.contact_angle, self.at_greatest["contact_angle"][:, 1], self.greatest_load[:, 0]),
            self._law_doubt(),
            self._cage_doubt(),
            self._touch_doubt(),
            wave_doubt(self._half_period(), wave_transit(diameter, ball.young_modulus, ball.density)),
            self._smoothing_doubt(float((peaks["semi_major"] * np.abs(self.at_greatest["spin_rate"])).max())),
        )

    def status(self) -> str:
        """Gives "done", or what failed."""
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"

    def figures(self) -> dict:
        """The run in numbers, SI unit at the end of a key; one value a ball where it is a list: see `figure_rows`."""
        late, before = self._second_half()
        peaks = self._peaks()
        place, tilt, force, moment = ((late["ring"] / late["count"])[columns] for columns in RING_COLUMNS)
        moved, _, swing, _ = ((late["ring_greatest"] - late["ring_least"])[columns] for columns in RING_COLUMNS)
        pairs = {}
        for key, unit, array in (
            ("normal_load", "n", late["load"].reshape(-1, 2) / late["count"]),
            ("greatest_normal_load", "n", self.greatest_load),
            ("contact_angle", "rad", self.at_greatest["contact_angle"]),
            ("semi_major", "m", peaks["semi_major"]),
            ("semi_minor", "m", peaks["semi_minor"]),
            ("peak_pressure", "pa", peaks["peak_pressure"]),
            ("share_without_contact", "", self._sums.greatest.without.reshape(-1, 2) / self.samples),
        ):
            for side, ring in enumerate(("inner", "outer")):
                pairs[f"{key}_{ring}_{unit}".rstrip("_")] = array[:, side].tolist()
        found = {
            "inner_ring_speed_at_end_rad_s": self.last["inner_ring_speed"],
            "run_up_time_s": self._run_up.time_to(self.last["inner_ring_speed"]),
            **speed_figures(self.parameters, late, before),
            "energy_closure": self.energy_closure,
            "drive_work_j": self.last["drive_work"],
            "dissipated_j": self.last["dissipated"],
            "drive_torque_nm": mean_torque(late, before, self._work_known(late, before)),
            "catalogue_drive_torque_nm": catalogue_torque(
                self.parameters, self._static, force, float(late["speed"] / late["count"])
            ),
            "ring_displacement_m": place.tolist(),
            "misalignment_rad": tilt.tolist(),
            "ring_force_n": force.tolist(),
            "ring_moment_nm": moment.tolist(),
            "ring_displacement_range_m": moved.tolist(),
            "ring_force_range_n": swing.tolist(),
            **pairs,
            "cage_slip": float(late["cage_slip"] / late["count"]),
            "greatest_pocket_force_n": float(self._sums.greatest.pocket_force[0]),
            **centre_figures(late["centre"] / late["count"], self._sums.greatest),
            "friction_torque_nm": self._torques(late),
        }
        absent = missing(self.parameters, self.choice.stepper == QUASI_STATIC)
        return {key: value for key, value in found.items() if key not in absent}

    def _torques(self, late: dict) -> list[float]:
        """Mean torques of the raceways on the balls [N m]; 0 where rounding alone is left of them."""
        torque, load = (late[name].reshape(-1, width) / late["count"] for name, width in (("torque", 1), ("load", 2)))
        least = ROUNDING * 0.5 * self.parameters.geometry.ball_diameter * load.sum(axis=1)
        return [float(one) for one in np.where(torque[:, 0] > least, torque[:, 0], 0.0)]


def meanings() -> dict[str, str]:
    """What each key of the figures is."""
    return dict(MEANINGS)
