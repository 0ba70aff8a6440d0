"""What a run cost, what it found, and how far to trust it."""

from dataclasses import dataclass, field

import numpy as np

from bearing_twin.fidelity import Choice
from bearing_twin.reference.kinematics import cage_speed, roll_rate
from bearing_twin.sample import Block
from bearing_twin.scene import Scene
from bearing_twin.scenes.bearing_outputs import contact_details

PERMANENT_PRESSURE = 4.2e9  # Pa; ISO 76: beyond it a ball bearing keeps a dent of 1e-4 ball diameters
WIDEST_ELLIPSE = 0.1  # semi-major axis / ball radius beyond which the half-space theory is doubtful
ENERGY_GAIN = 0.01  # of the work moved; more is never a success


@dataclass(frozen=True)
class Report:
    """The run in numbers; arrays have one value a ball, or ball x (inner, outer).

    Means are over the second half of the run, `greatest_*` over all of it, ellipses at the greatest load.
    """

    scene: str
    law: str
    stepper: str
    choice_reason: str
    warnings: tuple[str, ...]
    flags: tuple[str, ...]
    status: str
    simulated_seconds: float
    compute_seconds: float
    samples: int
    costs: dict[str, int]
    cage_speed: float
    cage_speed_theory: float
    roll_rate: float
    roll_rate_theory: float
    energy_closure: float
    drive_work: float
    dissipated: float
    drive_torque: float
    mean_load: np.ndarray
    greatest_load: np.ndarray
    friction_torque: np.ndarray
    contact_angle: np.ndarray
    semi_major: np.ndarray
    semi_minor: np.ndarray
    peak_pressure: np.ndarray

    @property
    def real_time_factor(self) -> float:
        """Simulated over computed seconds, compilation apart."""
        return self.simulated_seconds / self.compute_seconds if self.compute_seconds > 0.0 else 0.0

    def as_dict(self) -> dict:
        """Plain data with the SI unit at the end of each key, for `--json`, metadata and tables."""
        pairs = {}
        for key, unit, array in (
            ("normal_load", "n", self.mean_load),
            ("greatest_normal_load", "n", self.greatest_load),
            ("contact_angle", "rad", self.contact_angle),
            ("semi_major", "m", self.semi_major),
            ("semi_minor", "m", self.semi_minor),
            ("peak_pressure", "pa", self.peak_pressure),
        ):
            for side, ring in enumerate(("inner", "outer")):
                pairs[f"{key}_{ring}_{unit}"] = [float(v) for v in array[:, side]]
        return {
            "scene": self.scene,
            "law": self.law,
            "stepper": self.stepper,
            "choice_reason": self.choice_reason,
            "status": self.status,
            "warnings": list(self.warnings),
            "flags": list(self.flags),
            "simulated_s": self.simulated_seconds,
            "compute_s": self.compute_seconds,
            "real_time_factor": self.real_time_factor,
            "samples": self.samples,
            **self.costs,
            "cage_speed_rad_s": self.cage_speed,
            "cage_speed_theory_rad_s": self.cage_speed_theory,
            "roll_rate_rad_s": self.roll_rate,
            "roll_rate_theory_rad_s": self.roll_rate_theory,
            "energy_closure": self.energy_closure,
            "drive_work_j": self.drive_work,
            "dissipated_j": self.dissipated,
            "drive_torque_nm": self.drive_torque,
            **pairs,
            "friction_torque_nm": [float(v) for v in self.friction_torque],
        }


@dataclass
class Statistics:
    """Gathers a run's figures block by block, in memory that does not grow with the run."""

    scene: Scene
    ball_radius: float
    samples: int = 0
    first: dict = field(default_factory=dict)
    last: dict = field(default_factory=dict)

    def __post_init__(self):
        balls = self.scene.parameters.geometry.balls
        self.greatest_load = np.zeros((balls, 2))
        self.at_greatest = {
            name: np.zeros((balls, 2)) for name in ("curvature_small", "curvature_large", "contact_angle")
        }
        self.periods: list[dict] = []

    def add(self, block: Block) -> None:
        """Takes a block in."""
        load = block.values["normal_load"]
        row = load.argmax(axis=0)
        here = np.take_along_axis(load, row[None], axis=0)[0]
        better = here > self.greatest_load
        self.greatest_load = np.where(better, here, self.greatest_load)
        for name, kept in self.at_greatest.items():
            kept[better] = np.take_along_axis(block.values[name], row[None], axis=0)[0][better]
        if not self.samples:
            self.first = self._instant(block, 0)
        self.last = self._instant(block, len(block) - 1)
        self.samples += len(block)
        self.periods.append(
            {
                "time": self.last["time"],
                "orbit_angle": self.last["orbit_angle"],
                "count": len(block),
                "load": load.sum(axis=0),
                "torque": np.linalg.norm(block.values["raceway_torque"], axis=-1).sum(axis=0),
                "drive_torque": -block.values["inner_ring_torque"][:, 2].sum(),
                "roll_rate": block.values["roll_rate"].mean(axis=1).sum(),
                "speed": block.values["inner_ring_speed"].sum(),
            }
        )
        if len(self.periods) > 256:
            self.periods = [self._merge(a, b) for a, b in zip(self.periods[::2], self.periods[1::2], strict=False)] + (
                self.periods[-1:] if len(self.periods) % 2 else []
            )

    @staticmethod
    def _merge(a: dict, b: dict) -> dict:
        sums = ("count", "load", "torque", "drive_torque", "roll_rate", "speed")
        return {**b, **{name: a[name] + b[name] for name in sums}}

    @staticmethod
    def _instant(block: Block, row: int) -> dict:
        names = ("kinetic_energy", "elastic_energy", "potential_energy", "drive_work", "dissipated")
        values = {name: float(block.values[name][row]) for name in names}
        return {
            "time": 1e-9 * int(block.time_ns[row]),
            "orbit_angle": block.values["orbit_angle"][row].copy(),
            **values,
        }

    def _second_half(self) -> tuple[dict, dict]:
        """The merged second half of the run, and the instant it starts from."""
        middle = 0.5 * (self.first["time"] + self.last["time"])
        late = [period for period in self.periods if period["time"] > middle] or self.periods[-1:]
        before = self.periods[len(self.periods) - len(late) - 1] if len(late) < len(self.periods) else self.first
        merged = late[0]
        for period in late[1:]:
            merged = self._merge(merged, period)
        return merged, before

    def energy_closure(self, gross_work: float) -> float:
        """Energy gained (+) or lost (-) by the numbers alone, as a share of the work moved through the bearing."""
        stored = ("kinetic_energy", "elastic_energy", "potential_energy")
        change = sum(self.last[name] - self.first[name] for name in stored)
        residual = change + self.last["dissipated"] - self.last["drive_work"]
        scale = max(gross_work, self.last["dissipated"], abs(change))
        return residual / scale if scale > 0.0 else 0.0

    def report(self, choice: Choice, costs: dict, gross_work: float, compute_seconds: float, ahead: int) -> Report:
        """The report so far; `ahead` outputs are computed but not given out, their time is shared accordingly."""
        geometry = self.scene.parameters.geometry
        late, before = self._second_half()
        span = late["time"] - before["time"]
        orbit = late["orbit_angle"] - before["orbit_angle"]
        speed = late["speed"] / late["count"]
        closure = self.energy_closure(gross_work)
        peak = {
            **self.at_greatest,
            "normal_load": self.greatest_load,
            "approach": self.greatest_load,
            "normal": np.broadcast_to([1.0, 0.0, 0.0], (*self.greatest_load.shape, 3)),
        }
        details = contact_details(self.scene.parameters, peak)
        flags = []
        if details["peak_pressure"].max() > PERMANENT_PRESSURE:
            flags.append(
                f"peak pressure {details['peak_pressure'].max():.3g} Pa is beyond 4.2 GPa: real raceways keep dents"
            )
        if details["semi_major"].max() > WIDEST_ELLIPSE * self.ball_radius:
            flags.append(
                f"contact ellipse of {details['semi_major'].max():.3g} m is wide for the ball: Hertz's flat half-space is a rough picture"
            )
        if closure > ENERGY_GAIN:
            flags.append(
                f"energy grew by {100 * closure:.2g} % of the work moved: shorten the step or tighten the tolerance"
            )
        diameters = geometry.ball_diameter, geometry.pitch_diameter
        share = self.samples / (self.samples + ahead)
        return Report(
            scene=self.scene.name,
            law=choice.law,
            stepper=choice.stepper,
            choice_reason=choice.reason,
            warnings=choice.warnings,
            flags=tuple(flags),
            status="failed: energy" if closure > ENERGY_GAIN else "done",
            simulated_seconds=self.last["time"],
            compute_seconds=compute_seconds * share,
            samples=self.samples,
            costs=costs,
            cage_speed=float(orbit.mean() / span) if span > 0.0 else 0.0,
            cage_speed_theory=cage_speed(speed, *diameters),
            roll_rate=late["roll_rate"] / late["count"],
            roll_rate_theory=roll_rate(speed, *diameters),
            energy_closure=closure,
            drive_work=self.last["drive_work"],
            dissipated=self.last["dissipated"],
            drive_torque=late["drive_torque"] / late["count"],
            mean_load=late["load"] / late["count"],
            greatest_load=self.greatest_load,
            friction_torque=late["torque"] / late["count"],
            contact_angle=self.at_greatest["contact_angle"],
            semi_major=details["semi_major"],
            semi_minor=details["semi_minor"],
            peak_pressure=details["peak_pressure"],
        )
