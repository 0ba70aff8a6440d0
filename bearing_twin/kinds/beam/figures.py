"""The figures of a sphere on a beam, a function of outputs and records alone."""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.base.stopping import signal_flag
from bearing_twin.contact.validity import patch_radius
from bearing_twin.kinds.beam.motion import (
    MODE_ORDERS,
    STEP_ORDER,
    channels,
    impact_speed,
    modes_for,
    solve,
    sphere_of,
    steps_for,
    theory_of,
)
from bearing_twin.kinds.beam.parameters import BEAM_THEORIES, EULER, BeamSolver, SphereOnBeamScene
from bearing_twin.kinds.bodies.figures import CONTACT, DURATION, IMPULSE, START, ImpactFigures, contact_warnings
from bearing_twin.kinds.bodies.model_errors import ImpactComparison, relative
from bearing_twin.kinds.error_estimates import BEAM_THEORY, SMALLER, TOLERANCE, ModelErrors

LARGE_DEFLECTION = 0.02  # of the span

EXTREMES = Table(
    "extremes",
    (
        Channel("time", "s", (), "end of the last contact: what follows is free motion"),
        Channel("peak_deflection", "m", (), "greatest by magnitude, of all points and the whole motion"),
        Channel("peak_stress", "Pa", (), "greatest bending stress by magnitude, likewise"),
        Channel("energy_gained", "J", (), "by the method alone"),
        Channel("known_until", "s", (), "to where the motion is solved"),
        Channel("gone", "1", (), "1 where no further contact can follow"),
        Channel("highest_mode", "1", (), "of the beam in the sum"),
    ),
    "what is greatest in the whole motion",
)


FIGURES = (
    *("peak_force_n", "contact_duration_s", "greatest_approach_m", "contact_count", "restitution"),
    *("sphere_velocity_after_m_s", "impulse_ns", "peak_deflection_m", "peak_stress_pa"),
)


TABLES = CONTACT, EXTREMES


class BeamFigures(ImpactFigures):
    """The figures of a sphere on a beam."""

    def __init__(self, parameters: SphereOnBeamScene, choice: Choice):
        super().__init__(parameters, choice)
        self._extremes: dict[str, float] = {}

    @staticmethod
    def speed_of(parameters) -> float:
        return impact_speed(parameters.blow)

    def add(self, block: Block) -> None:
        super().add(block)
        for row in block.records.get("extremes", ()):
            names = (column.name for column in EXTREMES.columns)
            known = zip(names, map(float, row), strict=False)  # an earlier version has fewer
            self._extremes = {name: value for name, value in known if not math.isnan(value)}

    @property
    def restitution(self) -> float | None:
        """Speed of the sphere away from the beam at the end over its speed before; negative: it follows the beam."""
        return -float(self.last["sphere_velocity"]) / self.speed if self.last else None

    @property
    def energy_gained(self) -> float:
        return self._extremes.get("energy_gained", 0.0)

    @property
    def _goes_on(self) -> bool:
        """True where the end of the run cuts the last contact."""
        end = float(self.contacts[-1:, [START, DURATION]].sum())
        return math.isclose(end, self._extremes.get("known_until", math.inf))

    def figures(self) -> dict[str, Any]:
        """Figures of an impact, and deflection and stress of the beam."""
        return {
            **super().figures(),
            "sphere_velocity_after_m_s": float(self.last["sphere_velocity"]) if self.last else None,
            "contact_count": len(self.contacts),
            "peak_deflection_m": self._extremes.get("peak_deflection"),
            "peak_stress_pa": self._extremes.get("peak_stress"),
            "highest_mode": int(self._extremes.get("highest_mode", modes_for(self.parameters))),
            "gravity_m_s2": self.parameters.blow.gravity,
        }

    def flags(self) -> list[str]:
        """Warnings of an impact outside the limits of the theory, one sentence each."""
        peak, (sphere, beam) = self.peak_force, self.parameters.bodies
        half_width = patch_radius(peak, sphere.radius, self.parameters.modulus)
        pressure = 1.5 * peak / (math.pi * half_width**2) if peak > 0.0 else 0.0
        size, body = min((sphere.radius, "radius"), (beam.height, "height"))
        ended = self.contacts[:-1] if self._goes_on else self.contacts
        shortest = float(ended[:, DURATION].min(initial=math.inf))
        warnings = contact_warnings((sphere, beam), pressure, shortest, [(half_width, size, body)])
        return [*warnings, *self._beam_flags()]

    def _beam_flags(self) -> list[str]:
        beam, extremes, flags = self.parameters.beam, self._extremes, []
        stress, deflection = extremes.get("peak_stress", 0.0), extremes.get("peak_deflection", 0.0)
        if 0.0 < beam.material.yield_strength < stress:
            flags.append(
                f"bending stress {stress:.3g} Pa is beyond the beam's strength: the elastic result does not hold"
            )
        if deflection > LARGE_DEFLECTION * beam.span:
            flags.append(f"a deflection of {deflection:.3g} m is large for a span of {beam.span:g} m")
        sphere, total = sphere_of(self.parameters), float(np.sum(self.contacts[:, IMPULSE]))
        limit = 2.0 * sphere.mass * self.speed
        if sphere.gravity == 0.0 and total > limit * (1.0 + 1e-9):
            flags.append(
                f"the impulse of {total:.4g} N s exceeds the bound 2 m v = {limit:.4g} N s: the result is wrong"
            )
        end = extremes.get("known_until", math.inf)
        if self._goes_on:
            begun = f"the contact that begins at {self.contacts[-1, START]:.4g} s"
            until = f"goes on at the end of the run, {end:.4g} s: its duration and impulse are those until then"
            return [*flags, f"{begun} {until}"]
        if extremes and not extremes["gone"]:
            flags.append(f"the sphere may touch the beam again after {end:.4g} s; lengthen run.duration")
        return flags + super().flags()


class BeamComparison(ImpactComparison):
    """Comparison of two runs of a sphere on a beam, as of two bodies on a line."""

    def refined(self):
        """By modes, as many modes and steps as a tenth of the error takes."""
        parameters = self.parameters.resolve()
        modes = math.ceil(modes_for(parameters) * TOLERANCE ** (-1.0 / MODE_ORDERS[theory_of(parameters)])) | 1
        steps = math.ceil(steps_for(parameters, "modes") * TOLERANCE ** (-1.0 / STEP_ORDER))
        solver = dataclasses.replace(parameters.solver, modes=modes, steps=steps)
        return dataclasses.replace(parameters, solver=solver), self.choice._replace(stepper="modes")

    @property
    def smaller(self) -> str:
        if self.choice.stepper == "sinusoidal":
            return "set solver.stepper: modes, which solves for the force"
        if self.parameters.solver.modes or self.parameters.solver.steps:
            return "leave solver.modes and solver.steps out, or raise them"
        return SMALLER


TRIAL, SHARE = 1e-4, 0.1  # tolerance of the comparison of both theories: the least, and over that of the scene
INSTANTS = 100  # of a contact, at which forces are compared


class TheoryErrors(NamedTuple):
    """Errors of Euler's beam against Timoshenko's.

    `figures` in their units; relative ones of the greatest force and of the time in contact, and of the force over the
    greatest, while Timoshenko's beam is touched; `contacts` is the greater number of both.
    """

    figures: dict[str, float]
    peaks: float
    forces: float
    contacts: int


@functools.lru_cache(maxsize=64)
def theory_errors(parameters: SphereOnBeamScene) -> TheoryErrors:
    """Errors of Euler's beam in a checked scene: the impact is computed by both theories."""
    options = dataclasses.replace(parameters.wanted, tolerance=max(SHARE * parameters.wanted.tolerance, TRIAL))
    coarse = dataclasses.replace(parameters, solver=BeamSolver(), wanted=options)
    scenes = [
        dataclasses.replace(coarse, beam=dataclasses.replace(coarse.beam, theory=theory)) for theory in BEAM_THEORIES
    ]
    with signal_flag():
        impacts = [solve(scene) for scene in scenes]
    spans = impacts[1].records["contact"][:, [START, DURATION]]
    instants = [np.linspace(start, start + lasts, INSTANTS) for start, lasts in spans]
    times = np.maximum.accumulate(np.concatenate([*instants, impacts[1].time[-1:]]))  # a contact may outlast the run
    figures, forces = [], []
    for scene, impact in zip(scenes, impacts, strict=True):
        values = dict(zip((channel.name for channel in channels(scene)), impact.outputs_at(times), strict=True))
        writer = BeamFigures(scene, None)
        writer.add(Block(channels(scene), 0, np.rint(1e9 * times).astype(np.int64), values, impact.records))
        figures.append(writer.figures())
        forces.append(values["normal_load"])
    euler, shear = figures
    known = [key for key in FIGURES if euler[key] is not None]
    return TheoryErrors(
        {key: abs(euler[key] - shear[key]) for key in known},
        max(relative(euler[key], shear[key]) for key in FIGURES[:2]),
        float(np.abs(forces[0] - forces[1]).max()) / shear["peak_force_n"],
        max(euler["contact_count"], shear["contact_count"]),
    )


class BeamModelErrors(ModelErrors):
    """Euler's beam against Timoshenko's."""

    outputs = ("peaks", "forces")
    law_source, law_mend = BEAM_THEORY, "beam.theory: timoshenko knows shear and rotary inertia"

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Of Euler's beam against Timoshenko's; that of Timoshenko's is not known."""
        known = theory_of(self.parameters) == EULER and figures["contact_count"]
        return theory_errors(self.parameters).figures if known else {}

    def law_of(self, output: str) -> float:
        """Of Euler's beam against Timoshenko's: of its peaks, and of forces over time those of later contacts, too."""
        if theory_of(self.parameters) != EULER:
            return 0.0
        errors = theory_errors(self.parameters)
        return errors.peaks if output == "peaks" else max(errors.peaks, errors.forces)

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """The next term of the sphere's shape, (a / R)^2 of the load at an approach; peaks go with its power 2/5."""
        sphere, beam, peak = self.parameters.sphere, self.parameters.beam, figures["peak_force_n"]
        width = patch_radius(peak, sphere.radius, self.parameters.modulus)
        share = (width / min(sphere.radius, beam.height)) ** 2 / 2.5
        return {key: share * abs(figures[key]) for key in FIGURES[:3]}

    def notes(self) -> dict[str, str]:
        notes = {"vibration": "waves in the sphere, and across the beam's width and height, are not computed"}
        if theory_of(self.parameters) != EULER:
            notes[BEAM_THEORY] = "Timoshenko's beam holds for waves down to a height or two; its error is not known"
        elif theory_errors(self.parameters).contacts > 1:
            notes[BEAM_THEORY] = "the motion after a second contact depends on shear, which Euler's beam neglects"
        return notes
