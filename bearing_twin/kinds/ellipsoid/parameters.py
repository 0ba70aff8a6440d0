"""An ellipsoid on a plane: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass
from typing import ClassVar

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material
from bearing_twin.kinds.contract import SceneParameters, lazy_import
from bearing_twin.kinds.ranges import facts_at
from bearing_twin.kinds.sections import (
    Checked,
    Friction,
    PointElastic,
    RunSettings,
    SteadyDamping,
    ViscoelasticDamping,
    Wanted,
    free_fall,
    peak_and_impulse,
    point_laws,
)

DERIVED = "bearing_twin.kinds.ellipsoid.derived"
GIVES = ("curvatures", "frozen", "stiffness", "state")  # what a law may need in this kind
ELLIPSOID_STEPPERS = ("dop853", "rk4")
BODY, PLANE = "body", "plane"  # the bodies, as topics and failures name them


@dataclass(frozen=True)
class EllipsoidBody:
    """A homogeneous ellipsoid."""

    semi_axes: tuple[float, float, float] = quantity((0.1, 0.1, 0.1), "m", "along its own x, y and z", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from semi-axes and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class PlaneBody:
    """The half-space z < 0, at rest."""

    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Start:
    """Initial state of the ellipsoid, in fixed axes with z up."""

    height: float = quantity(1.0, "m", "of the lowest point above the plane; negative = pressed in")
    turn: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), "rad", "from its own axes on the fixed ones: angle times axis of one rotation"
    )
    velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m/s", "of the centre")
    angular_velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "rad/s", "in fixed axes")


@dataclass(frozen=True)
class EllipsoidContact(ViscoelasticDamping, SteadyDamping, Friction, PointElastic):
    """The laws of the contact."""

    normal: str = choice("auto", point_laws(*GIVES), "elastic law; auto = the cheapest adequate one")


@dataclass(frozen=True)
class EllipsoidSolver(Checked):
    """Method of integration."""

    stepper: str = choice("auto", ("auto", *ELLIPSOID_STEPPERS), "method; auto = dop853")
    step: float = quantity(
        0.0,
        "s",
        "step of rk4 in contact; 0 = a 64th of the shortest contact, or less where friction is fast",
        at_least=0.0,
    )


@dataclass(frozen=True)
class WantedOfEllipsoid(Wanted):
    """Requested accuracy and outputs of an ellipsoid on a plane."""

    tolerance: float = peak_and_impulse(1e-6, at_least=1e-12)


@dataclass(frozen=True)
class EllipsoidOnPlaneScene(SceneParameters):
    """A homogeneous ellipsoid over an elastic half-space, under gravity (paper 1, section 5, first example)."""

    body: EllipsoidBody = section(EllipsoidBody)
    plane: PlaneBody = section(PlaneBody)
    start: Start = section(Start)
    gravity: tuple[float, float, float] = free_fall(0.0, 0.0, -1.0, along=", along -z")
    contact: EllipsoidContact = section(EllipsoidContact, default=EllipsoidContact(damping_law="steady"))
    solver: EllipsoidSolver = section(EllipsoidSolver)
    wanted: WantedOfEllipsoid = section(WantedOfEllipsoid)
    run: RunSettings = section(RunSettings, default=RunSettings(2.0, 2000.0, 0.0))

    moved: ClassVar = {
        "contact.yield_pressure": "body.material.yield_strength and plane.material.yield_strength "
        "(the pressure over 1.6)",
        "friction": "contact.friction, contact.friction_coefficient and contact.friction_regularisation",
    }
    facts = facts_at(f"{DERIVED}:axis_ratio", f"{DERIVED}:coefficient_change")
    check = lazy_import(f"{DERIVED}:check_ellipsoid")
    resolve = lazy_import(f"{DERIVED}:resolve")

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of an earlier version."""
        contact, friction = scene.get("contact", {}), scene.pop("friction", {})
        names = {"form": "friction", "coefficient": "friction_coefficient", "regularisation": "friction_regularisation"}
        contact |= {names[key]: value for key, value in friction.items() if key in names}
        if "yield_pressure" in contact:
            strength = contact.pop("yield_pressure") / YIELD_ONSET
            for body in ("body", "plane"):
                scene[body]["material"]["yield_strength"] = strength
        if contact.get("restitution_speed", 0.0) > 0.0:
            contact["damping_law"] = "hunt_crossley"
        if isinstance(scene.get("gravity"), (int, float)):
            scene["gravity"] = [0.0, 0.0, -scene["gravity"]]
        return scene
