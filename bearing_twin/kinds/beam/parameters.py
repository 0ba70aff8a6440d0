"""A sphere on a beam: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass
from typing import ClassVar

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material
from bearing_twin.kinds.bodies.parameters import BodiesScene, Body, Sphere
from bearing_twin.kinds.contract import lazy_import
from bearing_twin.kinds.rules import facts_at
from bearing_twin.kinds.sections import LOOSEST, UNVERIFIED, Checked, RunSettings, WantedImpact

BEAM_METHODS = ("modes", "volterra", "sinusoidal")
EULER, TIMOSHENKO = BEAM_THEORIES = ("euler", "timoshenko")
MOTION = "bearing_twin.kinds.beam.motion"
BODY, BEAM = "sphere", "beam"  # the bodies, as topics and failures name them


@dataclass(frozen=True)
class BeamParameters(Body):
    """A simply supported beam of rectangular section at rest; its own weight bends it before, and is left out."""

    shape: ClassVar = "beam"
    span: float = quantity(0.1535, "m", "distance of the supports", above=0.0)
    width: float = quantity(0.01, "m", "width across the motion of the sphere", above=0.0)
    height: float = quantity(0.01, "m", "height along the motion of the sphere", above=0.0)
    theory: str = choice(
        "auto", ("auto", *BEAM_THEORIES), "timoshenko knows shear and rotary inertia; auto = timoshenko"
    )
    damping_ratio: float = quantity(0.0, "1", "of every mode, as a share of critical damping", at_least=0.0, below=1.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Blow:
    """Speed of the sphere, or the height it has fallen from."""

    speed: float = quantity(0.0, "m/s", "speed at the first touch; 0 = from drop_height", at_least=0.0)
    drop_height: float = quantity(0.0, "m", "free fall before the first touch", at_least=0.0)
    gravity: float = quantity(0.0, "m/s^2", "on the sphere, along its motion, after the first contact; 0 = none")
    point: float = quantity(
        0.5, "1", "where on the beam, as a share of the span from one support", at_least=1e-6, at_most=0.999999
    )


@dataclass(frozen=True)
class BeamSolver(Checked):
    """Method of computation of sphere and beam."""

    stepper: str = choice("auto", ("auto", *BEAM_METHODS), "method; auto = modes; sinusoidal breaks the energy balance")
    modes: int = quantity(0, "1", "highest mode; 0 = from the tolerance", at_least=0, at_most=4000)
    steps: int = quantity(0, "1", "steps a Hertz contact time; 0 = from the tolerance", at_least=0, at_most=200000)


@dataclass(frozen=True)
class WantedOfBeam(WantedImpact):
    """Requested outputs and tolerance of a sphere on a beam."""

    tolerance: float = quantity(
        1e-6, "1", "requested relative error of forces and times", at_least=1e-10, at_most=LOOSEST, less=UNVERIFIED
    )


@dataclass(frozen=True)
class BeamOutputs:
    """Points of the beam whose motion is given, besides the point of impact."""

    points: tuple[float, float, float] = quantity(
        (0.25, 0.5, 0.75), "1", "of deflection and stress, as shares of the span", at_least=0.0, at_most=1.0
    )
    stations: int = quantity(41, "1", "evenly spaced points of the beam's shape", at_least=3, at_most=1001)


@dataclass(frozen=True)
class SphereOnBeamScene(BodiesScene):
    """A sphere strikes a simply supported beam (paper 2)."""

    beam: BeamParameters = section(BeamParameters)
    sphere: Sphere = section(Sphere)
    blow: Blow = section(Blow)
    outputs: BeamOutputs = section(BeamOutputs)
    solver: BeamSolver = section(BeamSolver)
    wanted: WantedOfBeam = section(WantedOfBeam)
    run: RunSettings = section(RunSettings)

    names: ClassVar = (BODY, BEAM)
    moved: ClassVar = BodiesScene.moved | {
        "contact.yield_stress": "beam.material.yield_strength",
        "solver.static_tail": "solver.modes, above which all modes bend statically",
    }
    facts = facts_at(f"{MOTION}:shear_share")
    check = lazy_import(f"{MOTION}:check_beam")
    resolve = lazy_import(f"{MOTION}:resolve")

    @property
    def bodies(self) -> tuple[Sphere, BeamParameters]:
        return self.sphere, self.beam

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of an earlier version."""
        contact = scene.pop("contact", {})
        scene.get("solver", {}).pop("static_tail", None)
        scene["beam"].setdefault("theory", EULER)
        if "wanted" in scene.get("run", {}):
            scene.setdefault("wanted", {})["outputs"] = scene["run"].pop("wanted")
        if "yield_pressure" in contact:
            scene["sphere"]["material"]["yield_strength"] = contact["yield_pressure"] / YIELD_ONSET
        if "yield_stress" in contact:
            scene["beam"]["material"]["yield_strength"] = contact["yield_stress"]
        return scene
