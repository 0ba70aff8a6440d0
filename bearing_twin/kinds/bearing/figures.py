"""The figures of a bearing run: loads, speeds, contact ellipses, energy balance, and validity of the theory."""

import math
from itertools import accumulate

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Layout
from bearing_twin.contact.elasticity import axis_ratio, ellipse, hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.validity import (
    gathered,
    law_warning,
    wave_transit,
    wave_warning,
)
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.accelerometer import Listener
from bearing_twin.kinds.bearing.friction_torque import catalogue_torque
from bearing_twin.kinds.bearing.geometry import cage_speed, moduli, roll_rate
from bearing_twin.kinds.bearing.models import contact_flags, law_error, touches_at_rest
from bearing_twin.kinds.bearing.parameters import BearingScene, has_sensor, with_chosen_friction
from bearing_twin.kinds.bearing.quantities import missing
from bearing_twin.kinds.bearing.ratings import ratings_of
from bearing_twin.kinds.bearing.rings import PRESCRIBED, QUASI_STATIC, TORQUE, dimension_of
from bearing_twin.kinds.contract import STORED, adds_up

NO_MOTION = 1e-12  # of the regularisation speed of friction: slower sliding is rounding
MOST_STRETCHES = 256  # of outputs, whose sums are kept; more are merged in pairs
RING = {"inner_ring_offset": 3, "inner_ring_tilt": 2, "inner_ring_force": 3, "inner_ring_torque": 2}  # first numbers of
RING_WIDTH = sum(RING.values())
RING_COLUMNS = tuple(slice(end - RING[name], end) for name, end in zip(RING, accumulate(RING.values()), strict=True))
AT_GREATEST = "curvature_small", "curvature_large", "contact_angle", "spin_rate"
CENTRE = "cage_offset", "cage_velocity", "land_force"
ALONE = "pocket_force", "land_force"
SUMS = (
    "time", "orbit_angle", "turned", "count", "load", "torque", "drive_torque", "roll_rate", "speed", "centre",
    "ring", "ring_least", "ring_greatest",
)  # fmt: skip
_READ = (
    "normal_load", "raceway_torque", "inner_ring_torque", "roll_rate", "inner_ring_speed", "orbit_angle",
    "pocket_force", "drive_work", "inner_ring_angle", "inner_ring_load_work", *AT_GREATEST, *RING, *CENTRE,
)  # fmt: skip
MISSING = -1  # as the first column of a missing channel
# Channels that logs of earlier versions lack: their numbers were 0, or are not known.
MAY_BE_MISSING = {"pocket_force", "inner_ring_load_work", "inner_ring_tilt", *CENTRE}


def greatest_of(balls: int) -> np.dtype:
    """Extremes over all outputs of contacts (2 N,), of a ball's inner one and outer one in turn, as the core has them.

    The greatest `load` and AT_GREATEST `there`; outputs `without` a load. `pocket_force` [N] is the greatest of a
    cage on a ball, `land_force` [N] that of a land on the cage.
    """
    contacts = 2 * balls
    columns = ("load", contacts), ("there", (len(AT_GREATEST), contacts)), ("without", contacts)
    return np.dtype([(name, float, size) for name, size in (*columns, *((name, ()) for name in ALONE))])


def stretch_of(balls: int) -> np.dtype:
    """Sums over a stretch of outputs, as the core has them; time [s] and orbit angles (N,) are those of the last one.

    So are `turned` (2,), the work [J] of turning the inner ring and its angle [rad]. Contacts (2 N,) stand as in
    `greatest_of`; `ring` (RING_WIDTH,) has the columns of RING side by side. `centre` (3,): of the cage's centre,
    distance from the axis [m], its square, and x dy/dt - y dx/dt [m^2/s].
    """
    sizes = {"orbit_angle": balls, "turned": 2, "load": 2 * balls, "torque": balls, "centre": 3}
    sizes |= dict.fromkeys(("ring", "ring_least", "ring_greatest"), RING_WIDTH)
    return np.dtype([(name, float, sizes.get(name, ())) for name in SUMS])


_sum_outputs = Function(
    "core_sum_outputs",
    None,
    (
        *(INTEGERS, REALS, INTEGER, INTEGER, INTEGERS, INTEGER, INTEGER, INTEGER),
        *(REALS_OUT, REALS_OUT, INTEGER, INTEGER, INTEGERS_OUT),
    ),
)
LAST = "time", "orbit_angle", "turned"
MERGED_BY = {"ring_least": np.minimum, "ring_greatest": np.maximum}  # others by addition


def columns_of(layout: Layout) -> np.ndarray:
    """The first column of each channel that is read in a row of all channels; raises ChannelError for one too few."""
    missing = MAY_BE_MISSING.difference(layout.fields)
    missing |= set(CENTRE) if missing.intersection(CENTRE) else set()
    return np.array([MISSING if name in missing else layout.fields[name][0].start for name in _READ])


class Sums:
    """The stretches of a run so far, in memory that does not grow with it, and the greatest of its contacts.

    All stretches are of one length, but for the last: the second half of a run begins within a 128th of it. Outputs are
    summed one after the other, so that sums do not depend on how a stream of them is cut.
    """

    def __init__(self, balls: int):
        self.outputs, self.stretches, self._length = 0, 0, 1
        self._balls, self._greatest = balls, np.zeros(1, greatest_of(balls))
        self._rows = np.zeros(MOST_STRETCHES, stretch_of(balls))

    @property
    def greatest(self) -> np.void:
        """The greatest of all contacts so far, by the names of `greatest_of`."""
        return self._greatest[0]

    @property
    def rows(self) -> np.ndarray:
        """The stretches so far, by the names of `stretch_of`."""
        return self._rows[: self.stretches]

    def add(self, block: Block, columns: np.ndarray) -> None:
        """Add a block."""
        numbers, times, done = block.matrix(), block.time_ns, 0
        room = self._rows.view(float).reshape(len(self._rows), -1)
        while done < len(block):
            remaining, ended = numbers[done:], np.array([0, self.stretches])
            _sum_outputs(
                *(columns, remaining, *remaining.shape, times[done:], self.outputs, self._length, self._balls),
                *(self._greatest.view(float), room, *room.shape, ended),
            )
            summed, self.stretches = ended.tolist()
            done, self.outputs = done + summed, self.outputs + summed
            if done < len(block):
                self._halve()

    def _halve(self) -> None:
        """Merge stretches in pairs, all of which are complete."""
        pairs = self.stretches // 2
        for name in SUMS:
            first, second = self._rows[name][0::2], self._rows[name][1::2]
            self._rows[name][:pairs] = second.copy() if name in LAST else MERGED_BY.get(name, np.add)(first, second)
        self._rows[pairs:] = 0.0
        self.stretches, self._length = pairs, 2 * self._length

    def from_row(self, first: int) -> dict:
        """All stretches from number `first` on as one, by the names of `stretch_of`."""
        rows = self.rows[first:]
        return {
            name: rows[name][-1] if name in LAST else MERGED_BY.get(name, np.add).reduce(rows[name], axis=0)
            for name in SUMS
        }


def _without_rounding(parameters, speed: float) -> float:
    """A speed of balls [rad/s], 0 where it is rounding beside the regularisation speed of friction."""
    slowest = NO_MOTION * parameters.contact.friction_regularisation / (0.5 * parameters.geometry.ball_diameter)
    return 0.0 if abs(speed) <= slowest else float(speed)


def speed_figures(parameters, half: dict, start: dict, angle: float) -> dict[str, float]:
    """Mean speeds [rad/s] over a half of a run, by `Sums.from_row`, which follows the instant `start`.

    Theoretical speeds are those of rolling at the contact angle `angle` [rad].
    """
    geometry, span, speed = parameters.geometry, half["time"] - start["time"], half["speed"] / half["count"]
    diameters, orbits = (geometry.ball_diameter, geometry.pitch_diameter), half["orbit_angle"] - start["orbit_angle"]
    return {
        "cage_speed_rad_s": _without_rounding(parameters, orbits.mean() / span) if span > 0.0 else 0.0,
        "cage_speed_theory_rad_s": float(cage_speed(speed, *diameters, angle)),
        "roll_rate_rad_s": _without_rounding(parameters, half["roll_rate"] / half["count"]),
        "roll_rate_theory_rad_s": float(roll_rate(speed, *diameters, angle)),
    }


def mean_torque(half: dict, start: dict, known: bool) -> float:
    """The mean torque of the drive [N m] over a half of a run, which follows the instant `start`.

    It is work over angle if the work of turning is `known` and the ring turned, else the mean of the outputs, which
    has the noise of single outputs.
    """
    (work, angle), (work_before, angle_before) = half["turned"], start["turned"]
    if not known or angle == angle_before or math.isnan(work):
        return float(half["drive_torque"] / half["count"])
    return float((work - work_before) / (angle - angle_before))


RUN_UP_SHARE = 0.99  # of the change of speed over the run
LEAST_RISE = 1e-3  # relative: smaller increases of the change are not stored


class RunUp:
    """The greatest changes of a speed so far, upwards and downwards, and their times."""

    def __init__(self, parameters):
        self._turned = parameters.drive.kind == TORQUE
        self._changes = {up: ([0.0], [0.0]) for up in (True, False)}  # times and changes
        self._first: float | None = None

    def add(self, block: Block) -> None:
        """Add the speeds of a block, if a torque turns the ring."""
        speeds = block.values["inner_ring_speed"].tolist() if self._turned else ()
        for time, speed in zip(block.time_ns.tolist(), speeds, strict=False):
            self._first = speed if self._first is None else self._first
            times, changes = self._changes[speed > self._first]
            if abs(speed - self._first) > changes[-1] * (1.0 + LEAST_RISE):
                times.append(1e-9 * time)
                changes.append(abs(speed - self._first))

    def time_to(self, last: float) -> float:
        """Time [s] of the first RUN_UP_SHARE of the change from first to `last` speed; 0 without a change."""
        change = last - (last if self._first is None else self._first)
        times, changes = self._changes[change > 0.0]
        return float(np.interp(RUN_UP_SHARE * abs(change), changes, times))


NO_SPIN, FREE_OF_SMOOTHING = 1e-3, 10.0  # spin over smoothing speed: hardly any friction; 4 % below its limit
NO_WORK = 1e-5  # of the stored energy, or the tolerance if that is more: smaller work is negligible


class BearingFigures:
    """Computes a run's figures block by block, in memory that does not grow with the run."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.choice, self.law = with_chosen_friction(parameters, choice), choice, choice.law
        self.first, self.last = {}, {}
        self._balls = parameters.geometry.balls
        self._static = ratings_of(parameters).static
        self._sums, self._run_up = Sums(self._balls), RunUp(parameters)
        self._layout, self._columns = None, None
        self._listener = Listener(parameters) if has_sensor(parameters) else None

    def add(self, block: Block) -> None:
        """Add a block."""
        layout = block.values.layout
        if layout is not self._layout:
            self._layout, self._columns = layout, columns_of(layout)
        self._sums.add(block, self._columns)
        self._run_up.add(block)
        if self._listener:
            self._listener.add(block)
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
        return self._sums.greatest["load"].reshape(-1, 2)

    @property
    def at_greatest(self) -> dict[str, np.ndarray]:
        """Shapes of the contacts (N, 2) at their greatest loads, by channel."""
        return dict(zip(AT_GREATEST, self._sums.greatest["there"].reshape(len(AT_GREATEST), -1, 2), strict=True))

    def _rolling_angle(self) -> float:
        """Contact angle [rad] at which balls roll: the mean of all contacts, each by its greatest load."""
        loads = self.greatest_load
        return float((loads * np.abs(self.at_greatest["contact_angle"])).sum() / loads.sum()) if loads.any() else 0.0

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
        """The merged second half of the run, and the instant before it."""
        rows = self._sums.rows
        middle = 0.5 * (self.first["time"] + rows["time"][-1])
        first = min(int(np.searchsorted(rows["time"], middle, side="right")), len(rows) - 1)
        return self._sums.from_row(first), rows[first - 1] if first else self.first

    def _work_known(self, half: dict, start: dict) -> bool:
        """True if the work of turning the ring over this part of the run is known, without that of loads and shifts.

        A shift of a held ring is work of the drive, and so is all work of equilibria. Logs of earlier versions have no
        work of loads.
        """
        change = self.parameters.drive.change
        shifted = change.time and any(change.offset) and start["time"] <= change.time <= half["time"]
        separate = "inner_ring_load_work" in self._layout.fields or dimension_of(self.parameters) == PRESCRIBED
        return separate and not shifted and dimension_of(self.parameters) != QUASI_STATIC

    @property
    def energy_closure(self) -> float | None:
        """Energy gained (+) or lost (-) by numerical errors, as a share of the gross work of the contacts.

        Gross work counts each contact's power by its magnitude; logs of the first version have only the sum. If hardly
        any work is done, as without friction, it is a share of the tolerance times the stored energy. None where a
        torque drives the ring over defects, the work of whose heights is not computed.
        """
        if self.parameters.defects and self.parameters.drive.kind == TORQUE:
            return None
        change = sum(self.last[name] - self.first[name] for name in STORED)
        dissipated, work = (self.last[name] - self.first[name] for name in ("dissipated", "drive_work"))
        residual = change + dissipated - work
        gross = self.last["gross_work"] - self.first["gross_work"] if "gross_work" in self.last else abs(work)
        stored = sum(abs(self.last[name]) for name in STORED)
        scale = max(gross, dissipated, abs(change), max(NO_WORK, self.parameters.wanted.tolerance) * stored)
        return residual / scale if scale > 0.0 else 0.0

    def _peaks(self) -> dict[str, np.ndarray]:
        """Ellipses and pressures at each contact's greatest load."""
        curvatures = (self.at_greatest[name] for name in ("curvature_small", "curvature_large"))
        ellipses = ellipse(*curvatures, np.array(moduli(self.parameters.materials)), self.greatest_load)
        return dict(zip(("semi_major", "semi_minor", "peak_pressure"), ellipses, strict=True))

    def _law_warning(self) -> str | None:
        """Warning of the elastic law at its greatest error against exact Hertz, over the contacts that carried load."""
        curvatures = [self.at_greatest[name] for name in ("curvature_small", "curvature_large")]
        errors = law_error(self.parameters, self.law, *curvatures, self.greatest_load)
        if errors is None or not errors.any():
            return None
        side, ball = divmod(int(np.abs(errors.T).argmax()), len(errors))
        gap = (float(curvature[ball, side]) for curvature in curvatures)
        return law_warning(self.law, float(errors[ball, side]), axis_ratio(*gap))

    def _smoothing_warning(self, fastest: float) -> str | None:
        """Warning of a spin torque whose contact patches spin at most this fast [m/s] at their rims."""
        contact = self.parameters.contact
        smoothing = contact.friction_regularisation
        hidden = NO_SPIN * smoothing < fastest < FREE_OF_SMOOTHING * smoothing
        if not (hidden and FRICTIONS[contact.friction].over_patch):
            return None
        return (
            f"contact patches spin at {fastest:.2g} m/s at most, which contact.friction_regularisation = "
            f"{smoothing:.3g} m/s smooths: torques of spin are too small; set it to "
            f"{fastest / FREE_OF_SMOOTHING:.1g} m/s or less"
        )

    def _half_period(self) -> float:
        """Half a period [s] of a ball between its contacts at their greatest load by Hertz, the shortest contact."""
        load, ball = self.greatest_load, self.parameters.materials.ball
        stiffness = 0.0
        for side, modulus in enumerate(moduli(self.parameters.materials)):
            heaviest = load[:, side].argmax()
            gap = (float(self.at_greatest[name][heaviest, side]) for name in ("curvature_small", "curvature_large"))
            stiffness += 1.5 * (hertz_coefficient(*gap, modulus) ** 2 * load[heaviest, side]) ** (1.0 / 3.0)
        mass = ball.density * math.pi / 6.0 * self.parameters.geometry.ball_diameter**3
        return math.pi * math.sqrt(mass / stiffness) if stiffness > 0.0 else math.inf

    def _touch_warning(self) -> str | None:
        """Warning of an inner ring that balls touch at no output."""
        if self.greatest_load[:, 0].any():
            return None
        if self.last["drive_work"]:
            return (
                "balls touch the inner ring between outputs alone, unseen by its loads: give a greater run.output_rate"
            )
        if not touches_at_rest(self.parameters):
            return None  # which is warned of before the run
        return (
            f"at {self.last['inner_ring_speed']:g} rad/s centrifugal loads lift the balls off the inner ring: it "
            "carries and drives none: lower drive.speed, which is in rad/s, or press the rings together harder"
        )

    def flags(self) -> list[str]:
        """Warnings of quantities outside the theory's validity, one sentence each."""
        peaks = self._peaks()
        angles, loads = self.at_greatest["contact_angle"][:, 1], self.greatest_load[:, 0]
        ball, diameter = self.parameters.materials.ball, self.parameters.geometry.ball_diameter
        return gathered(
            *contact_flags(self.parameters, peaks["peak_pressure"].max(), angles, loads),
            self._law_warning(),
            self._touch_warning(),
            wave_warning(self._half_period(), wave_transit(diameter, ball.young_modulus, ball.density)),
            self._smoothing_warning(float((peaks["semi_major"] * np.abs(self.at_greatest["spin_rate"])).max())),
        )

    def status(self) -> str:
        """The status "done", or "failed" with its reason."""
        closure = self.energy_closure
        return "done" if closure is None or adds_up(closure, self.parameters) else "failed: energy"

    def figures(self) -> dict:
        """The run in numbers, SI unit at the end of a key; one value a ball where it is a list."""
        half, start = self._second_half()
        peaks, speeds = self._peaks(), speed_figures(self.parameters, half, start, self._rolling_angle())
        rolling = speeds["cage_speed_theory_rad_s"]
        displacement, tilt, force, moment = ((half["ring"] / half["count"])[columns] for columns in RING_COLUMNS)
        spread = half["ring_greatest"] - half["ring_least"]
        displacement_range, _, force_range, _ = (spread[columns] for columns in RING_COLUMNS)
        distance, square, turned = (half["centre"] / half["count"]).tolist()
        pairs = {}
        for key, unit, array in (
            ("normal_load", "n", half["load"].reshape(-1, 2) / half["count"]),
            ("greatest_normal_load", "n", self.greatest_load),
            ("contact_angle", "rad", self.at_greatest["contact_angle"]),
            ("semi_major", "m", peaks["semi_major"]),
            ("semi_minor", "m", peaks["semi_minor"]),
            ("peak_pressure", "pa", peaks["peak_pressure"]),
            ("share_without_contact", "", self._sums.greatest["without"].reshape(-1, 2) / self.samples),
        ):
            for side, ring in enumerate(("inner", "outer")):
                pairs[f"{key}_{ring}_{unit}".rstrip("_")] = array[:, side].tolist()
        figures = {
            "inner_ring_speed_at_end_rad_s": self.last["inner_ring_speed"],
            "run_up_time_s": self._run_up.time_to(self.last["inner_ring_speed"]),
            **speeds,
            "energy_closure": self.energy_closure,
            "drive_work_j": self.last["drive_work"],
            "dissipated_j": self.last["dissipated"],
            "drive_torque_nm": mean_torque(half, start, self._work_known(half, start)),
            "catalogue_drive_torque_nm": catalogue_torque(
                self.parameters, self._static, force, float(half["speed"] / half["count"])
            ),
            "ring_displacement_m": displacement.tolist(),
            "misalignment_rad": tilt.tolist(),
            "ring_force_n": force.tolist(),
            "ring_moment_nm": moment.tolist(),
            "ring_displacement_range_m": displacement_range.tolist(),
            "ring_force_range_n": force_range.tolist(),
            **pairs,
            "cage_slip": 1.0 - speeds["cage_speed_rad_s"] / rolling if rolling else 0.0,
            "greatest_pocket_force_n": float(self._sums.greatest["pocket_force"]),
            "cage_eccentricity_m": distance,
            "cage_whirl_rad_s": turned / square if square > 0.0 else 0.0,
            "greatest_land_force_n": float(self._sums.greatest["land_force"]),
            "friction_torque_nm": (half["torque"] / half["count"]).tolist(),
            **(self._listener.figures() if self._listener else {}),
        }
        absent = missing(self.parameters, self.choice.stepper == QUASI_STATIC)
        return {key: value for key, value in figures.items() if key not in absent}
