"""Two spheres and two discs: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass
from typing import ClassVar

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.laws import law_names
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material
from bearing_twin.kinds.contract import SceneParameters, lazy_import
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.sections import (
    LOOSEST,
    UNVERIFIED,
    Checked,
    ElasticLaw,
    PointElastic,
    RunSettings,
    SteadyDamping,
    WantedImpact,
    point_laws,
)

HERE = "bearing_twin.kinds.impact"
SPHERES_GIVE = ("curvatures", "stiffness", "alpha")  # what a law may need between spheres
FIXED_STEP = ("rk4", "symplectic_euler")  # as in core/bodies/impact.hpp
PAIR_STEPPERS = ("closed_form", "dop853", *FIXED_STEP)
FIRST, SECOND = "first", "second"  # the bodies, as topics and failures name them


@dataclass(frozen=True)
class Sphere:
    """A homogeneous elastic sphere."""

    radius: float = quantity(0.01905, "m", "radius", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from radius and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Meeting:
    """Motion of two bodies on a line before their impact, the first behind the second; positive = forward."""

    first_velocity: float = quantity(20.0, "m/s", "velocity of the first body")
    second_velocity: float = quantity(0.0, "m/s", "velocity of the second body")
    gap: float = quantity(0.0, "m", "distance of the surfaces at the start", at_least=0.0)

    @property
    def speed(self) -> float:
        """Relative speed [m/s] at which the bodies close in."""
        return self.first_velocity - self.second_velocity


@dataclass(frozen=True)
class SphereContact(SteadyDamping, PointElastic):
    """The law of the contact of two spheres."""

    normal: str = choice("auto", point_laws(*SPHERES_GIVE), "elastic law; auto = hertz, or measured by alpha")
    measured_alpha: float = quantity(
        0.0, "s (m/s)^0.2", "contact time * speed^0.2, for the law measured; 0 = not known", at_least=0.0
    )


@dataclass(frozen=True)
class PairSolver(Checked):
    """Method for the contact of two bodies."""

    stepper: str = choice("auto", ("auto", *PAIR_STEPPERS), "method; auto = the cheapest adequate one")
    step: float = quantity(0.0, "s", "step of rk4 and symplectic_euler; 0 = a 500th of the contact", at_least=0.0)


@dataclass(frozen=True)
class WantedPair(WantedImpact):
    """Requested accuracy and outputs of two bodies."""

    tolerance: float = quantity(
        1e-9, "1", "requested relative error of force and time", at_least=1e-12, at_most=LOOSEST, less=UNVERIFIED
    )


class ImpactParameters(SceneParameters):
    """Base of the scenes of two bodies on a line."""

    resolve = lazy_import(f"{HERE}.derived:resolve")

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of an earlier version."""
        if "wanted" in scene.get("run", {}):
            scene.setdefault("wanted", {})["outputs"] = scene["run"].pop("wanted")
        if "yield_pressure" in scene.get("contact", {}):
            strength = scene["contact"].pop("yield_pressure") / YIELD_ONSET
            for body in ("first", "second", "disc"):
                if body in scene:
                    scene[body]["material"]["yield_strength"] = strength
        return scene


@dataclass(frozen=True)
class TwoSpheresScene(ImpactParameters):
    """Central impact of two elastic spheres (paper 3, sections 2 and 3), without gravity."""

    first: Sphere = section(Sphere)
    second: Sphere = section(Sphere)
    contact: SphereContact = section(SphereContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    wanted: WantedPair = section(WantedPair)
    run: RunSettings = section(RunSettings)

    moved: ClassVar = {
        "contact.yield_pressure": "first.material.yield_strength, second.material.yield_strength "
        "(the pressure over 1.6)",
        "run.wanted": "wanted.outputs",
    }
    check = lazy_import(f"{HERE}.derived:check_spheres")
    closed_form = lazy_import(f"{HERE}.spheres:closed_form")


@dataclass(frozen=True)
class Disc:
    """Both of two equal discs."""

    radius: float = quantity(1.0, "m", "radius", above=0.0)
    thickness: float = quantity(2.0, "m", "length of the line of contact, 2a of paper 3", above=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class DiscContact(ElasticLaw):
    """The law of the line contact."""

    normal: str = choice(
        "auto", lambda: ("auto", *law_names("line", ())), "law; line = eq. (14) of paper 3, auto = johnson"
    )


@dataclass(frozen=True)
class TwoDiscsScene(ImpactParameters):
    """Central impact of two equal elastic discs by a law of line contact (paper 3, section 5.1), without gravity."""

    disc: Disc = section(Disc)
    contact: DiscContact = section(DiscContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    wanted: WantedPair = section(WantedPair)
    run: RunSettings = section(RunSettings)

    moved: ClassVar = {
        "contact.yield_pressure": "disc.material.yield_strength (the pressure over 1.6)",
        "run.wanted": "wanted.outputs",
    }
    facts = facts_at(f"{HERE}.derived:thickness_over_radius", f"{HERE}.derived:speed_share")
    check = lazy_import(f"{HERE}.derived:check_discs")
    closed_form = lazy_import(f"{HERE}.discs:closed_form")
