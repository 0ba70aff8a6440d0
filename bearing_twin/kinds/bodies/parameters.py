"""Bodies that collide: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass
from typing import ClassVar

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.laws import law_names
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material, effective_modulus
from bearing_twin.kinds.contract import SceneParameters, lazy_import
from bearing_twin.kinds.rules import facts_at
from bearing_twin.kinds.sections import (
    LOOSEST,
    UNVERIFIED,
    Checked,
    ElasticLaw,
    Friction,
    PointElastic,
    RunSettings,
    SteadyDamping,
    ViscoelasticDamping,
    Wanted,
    WantedImpact,
    free_fall,
    peak_and_impulse,
    point_laws,
)

HERE = "bearing_twin.kinds.bodies"
DERIVED = f"{HERE}.derived"
SPHERES_GIVE = ("curvatures", "stiffness", "alpha")  # what a law may need between spheres
GIVES = ("curvatures", "frozen", "stiffness", "state")  # and between bodies that bounce
FIXED_STEP = ("rk4", "symplectic_euler")  # as in core/bodies/impact.cpp
FEWEST_STEPS, FEW_STEPS = 8, 16  # of a fixed-step method in the shortest contact: refused below, warned below
MOST_STEPS = 100_000  # of it in a contact: refused above, as rounding is all that more of them add
SHAPES = ("plane", "sphere", "ellipsoid", "superellipsoid", "groove")
TRACKINGS = ("closed", "algebraic", "differential")
OVERLAP = "overlap"
FREE, HELD = "free", "held"
FIRST, SECOND, BODY, PLANE = "first", "second", "body", "plane"  # the bodies, as topics and failures name them

Vector = tuple[float, float, float]
ZERO = (0.0, 0.0, 0.0)


def _turn():
    return quantity(ZERO, "rad", "from its own axes on the fixed ones: angle times axis of one rotation")


def _velocity():
    return quantity(ZERO, "m/s", "of the centre")


def _angular_velocity():
    return quantity(ZERO, "rad/s", "in fixed axes")


class BodiesScene(SceneParameters):
    """Base of the scenes of bodies that collide: the two `bodies`, and their `names` in topics and failures."""

    names: ClassVar = (FIRST, SECOND)
    moved: ClassVar = {
        "contact.yield_pressure": "material.yield_strength of each body (the pressure over 1.6)",
        "run.wanted": "wanted.outputs",
        "friction": "contact.friction, contact.friction_coefficient and contact.friction_regularisation",
    }

    @property
    def bodies(self) -> tuple:
        return self.first, self.second

    @property
    def modulus(self) -> float:
        """Effective modulus [Pa] of the pair."""
        return effective_modulus(*(one.material for one in self.bodies))

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of an earlier version."""
        contact = scene.get("contact", {})
        if "wanted" in scene.get("run", {}):
            scene.setdefault("wanted", {})["outputs"] = scene["run"].pop("wanted")
        if "yield_pressure" in contact:
            strength = contact.pop("yield_pressure") / YIELD_ONSET
            for body in (FIRST, SECOND, "disc", BODY, PLANE):
                if body in scene:
                    scene[body]["material"]["yield_strength"] = strength
        if BODY in scene:
            friction = scene.pop("friction", {})
            names = {"form": "friction", "coefficient": "friction_coefficient"}
            names["regularisation"] = "friction_regularisation"
            contact |= {names[key]: value for key, value in friction.items() if key in names}
            if contact.get("restitution_speed", 0.0) > 0.0:
                contact["damping_law"] = "hunt_crossley"
            if isinstance(scene.get("gravity"), (int, float)):
                scene["gravity"] = [0.0, 0.0, -scene["gravity"]]
        return scene


class Body:
    """Base of bodies: what those without a key for it have."""

    mass: ClassVar = 0.0
    motion: ClassVar = FREE


@dataclass(frozen=True)
class Sphere(Body):
    """A homogeneous elastic sphere."""

    shape: ClassVar = "sphere"
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

    stepper: str = choice(
        "auto", ("auto", "closed_form", "dop853", *FIXED_STEP), "method; auto = the cheapest adequate one"
    )
    step: float = quantity(0.0, "s", "step of rk4 and symplectic_euler; 0 = a 500th of the contact", at_least=0.0)


@dataclass(frozen=True)
class WantedPair(WantedImpact):
    """Requested accuracy and outputs of two bodies."""

    tolerance: float = quantity(
        1e-9, "1", "requested relative error of force and time", at_least=1e-12, at_most=LOOSEST, less=UNVERIFIED
    )


@dataclass(frozen=True)
class TwoSpheresScene(BodiesScene):
    """Central impact of two elastic spheres (paper 3, sections 2 and 3), without gravity."""

    first: Sphere = section(Sphere)
    second: Sphere = section(Sphere)
    contact: SphereContact = section(SphereContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    wanted: WantedPair = section(WantedPair)
    run: RunSettings = section(RunSettings)

    check = lazy_import(f"{DERIVED}:check_spheres")
    resolve = lazy_import(f"{DERIVED}:resolve")
    closed_form = lazy_import(f"{HERE}.impact:closed_spheres")


@dataclass(frozen=True)
class Disc(Body):
    """Both of two equal discs."""

    shape: ClassVar = "disc"
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
class TwoDiscsScene(BodiesScene):
    """Central impact of two equal elastic discs by a law of line contact (paper 3, section 5.1), without gravity."""

    disc: Disc = section(Disc)
    contact: DiscContact = section(DiscContact)
    motion: Meeting = section(Meeting)
    solver: PairSolver = section(PairSolver)
    wanted: WantedPair = section(WantedPair)
    run: RunSettings = section(RunSettings)

    facts = facts_at(f"{DERIVED}:thickness_over_radius", f"{DERIVED}:speed_share")
    check = lazy_import(f"{DERIVED}:check_discs")
    resolve = lazy_import(f"{DERIVED}:resolve")
    closed_form = lazy_import(f"{HERE}.impact:closed_discs")

    @property
    def bodies(self) -> tuple[Disc, Disc]:
        return self.disc, self.disc


@dataclass(frozen=True)
class EllipsoidBody(Body):
    """A homogeneous ellipsoid."""

    shape: ClassVar = "ellipsoid"
    semi_axes: Vector = quantity((0.1, 0.1, 0.1), "m", "along its own x, y and z", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from semi-axes and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class PlaneBody(Body):
    """The half-space z < 0, at rest."""

    shape: ClassVar = "plane"
    motion: ClassVar = HELD
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Start:
    """Initial state of the ellipsoid, in fixed axes with z up."""

    height: float = quantity(1.0, "m", "of the lowest point above the plane; negative = pressed in")
    turn: Vector = _turn()
    velocity: Vector = _velocity()
    angular_velocity: Vector = _angular_velocity()


@dataclass(frozen=True)
class EllipsoidContact(ViscoelasticDamping, SteadyDamping, Friction, PointElastic):
    """The laws of the contact."""

    normal: str = choice("auto", point_laws(*GIVES), "elastic law; auto = the cheapest adequate one")


@dataclass(frozen=True)
class EllipsoidSolver(Checked):
    """Method of integration."""

    stepper: str = choice("auto", ("auto", "dop853", "rk4"), "method; auto = dop853")
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
class EllipsoidOnPlaneScene(BodiesScene):
    """A homogeneous ellipsoid over an elastic half-space, under gravity (paper 1, section 5, first example)."""

    body: EllipsoidBody = section(EllipsoidBody)
    plane: PlaneBody = section(PlaneBody)
    start: Start = section(Start)
    gravity: Vector = free_fall(0.0, 0.0, -1.0, along=", along -z")
    contact: EllipsoidContact = section(EllipsoidContact, default=EllipsoidContact(damping_law="steady"))
    solver: EllipsoidSolver = section(EllipsoidSolver)
    wanted: WantedOfEllipsoid = section(WantedOfEllipsoid)
    run: RunSettings = section(RunSettings, default=RunSettings(2.0, 2000.0, 0.0))

    names: ClassVar = (BODY, PLANE)
    facts = facts_at(f"{DERIVED}:axis_ratio", f"{DERIVED}:coefficient_change")
    check = lazy_import(f"{DERIVED}:check_ellipsoid")
    resolve = lazy_import(f"{DERIVED}:resolve_bouncing")

    @property
    def bodies(self) -> tuple[EllipsoidBody, PlaneBody]:
        return self.body, self.plane


@dataclass(frozen=True)
class Shaped:
    """One body: its surface, its mass, and how it starts, in fixed axes."""

    shape: str = choice(
        "sphere", SHAPES, "plane = all below its own z = 0; groove = inside of a ring-shaped tube about its own z"
    )
    radius: float = quantity(0.01, "m", "of a sphere, or of the tube of a groove", above=0.0)
    ring_radius: float = quantity(0.0, "m", "of the circle in the middle of a groove's tube", at_least=0.0)
    semi_axes: Vector = quantity(ZERO, "m", "of an ellipsoid or superellipsoid along its own x, y and z", at_least=0.0)
    exponents: tuple[float, float] = quantity(
        (2.0, 2.0), "1", "n, m of a superellipsoid (|x/a|^n + |y/b|^n)^(m/n) + |z/c|^m = 1", above=0.0
    )
    mass: float = quantity(0.0, "kg", "mass; 0 = from shape and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)
    motion: str = choice(
        FREE,
        (FREE, HELD),
        "held = keeps its velocity and angular velocity, whatever presses; planes and grooves must be",
    )
    position: Vector = quantity(ZERO, "m", "of the centre at the start")
    turn: Vector = _turn()
    velocity: Vector = _velocity()
    angular_velocity: Vector = _angular_velocity()


@dataclass(frozen=True)
class PairContact(EllipsoidContact):
    """The laws of the contact."""

    normal: str = choice(
        "auto",
        lambda: (*point_laws(*GIVES)(), OVERLAP),
        "elastic law; overlap = volumetric law over the true overlap; auto = hertz, of a superellipsoid overlap",
    )
    tracking: str = choice(
        "auto", ("auto", *TRACKINGS), "opposing points by (paper 1, eqs. 1-3); auto = closed where there is one"
    )


@dataclass(frozen=True)
class WantedOfPair(Wanted):
    """Requested outputs and tolerance of two bodies."""

    tolerance: float = peak_and_impulse(1e-4, at_least=1e-11)


@dataclass(frozen=True)
class TwoBodiesScene(BodiesScene):
    """Two bodies on each other, under gravity (paper 1, sections 2 to 4)."""

    first: Shaped = section(Shaped, default=Shaped(position=(0.0, 0.0, 0.011)))
    second: Shaped = section(Shaped, default=Shaped(shape="plane", motion=HELD))
    gravity: Vector = free_fall(0.0, 0.0, -1.0)
    contact: PairContact = section(PairContact, default=PairContact(damping_law="steady"))
    solver: Checked = section(Checked)
    wanted: WantedOfPair = section(WantedOfPair)
    run: RunSettings = section(RunSettings, default=RunSettings(0.1, 5000.0, 0.0))

    facts = facts_at(f"{DERIVED}:axis_ratio", f"{DERIVED}:greatest_exponent")
    check = lazy_import(f"{DERIVED}:check_pair")
    resolve = lazy_import(f"{DERIVED}:resolve_bouncing")
