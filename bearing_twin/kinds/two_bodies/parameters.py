"""Two bodies with implicit surfaces: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass

from bearing_twin.base.parameters import choice, quantity, section
from bearing_twin.contact.materials import MATERIALS, Material
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

DERIVED = "bearing_twin.kinds.two_bodies.derived"
GIVES = ("curvatures", "frozen", "stiffness", "state")  # what a law may need here
SHAPES = ("plane", "sphere", "ellipsoid", "superellipsoid", "groove")
TRACKINGS = ("closed", "algebraic", "differential")
OVERLAP = "overlap"
FREE, HELD = "free", "held"
FIRST, SECOND = "first", "second"  # the bodies, as topics and failures name them


@dataclass(frozen=True)
class Shaped:
    """One body: its surface, its mass, and how it starts, in fixed axes."""

    shape: str = choice(
        "sphere", SHAPES, "plane = all below its own z = 0; groove = inside of a ring-shaped tube about its own z"
    )
    radius: float = quantity(0.01, "m", "of a sphere, or of the tube of a groove", above=0.0)
    ring_radius: float = quantity(0.0, "m", "of the circle in the middle of a groove's tube", at_least=0.0)
    semi_axes: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), "m", "of an ellipsoid or superellipsoid along its own x, y and z", at_least=0.0
    )
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
    position: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "of the centre at the start")
    turn: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0), "rad", "from its own axes on the fixed ones: angle times axis of one rotation"
    )
    velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m/s", "of the centre")
    angular_velocity: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "rad/s", "in fixed axes")


@dataclass(frozen=True)
class PairContact(ViscoelasticDamping, SteadyDamping, Friction, PointElastic):
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
    """What is wanted of two bodies."""

    tolerance: float = peak_and_impulse(1e-4, at_least=1e-11)


@dataclass(frozen=True)
class TwoBodiesScene(SceneParameters):
    """Two bodies on each other, under gravity (paper 1, sections 2 to 4)."""

    first: Shaped = section(Shaped, default=Shaped(position=(0.0, 0.0, 0.011)))
    second: Shaped = section(Shaped, default=Shaped(shape="plane", motion=HELD))
    gravity: tuple[float, float, float] = free_fall(0.0, 0.0, -1.0)
    contact: PairContact = section(PairContact, default=PairContact(damping_law="steady"))
    solver: Checked = section(Checked)
    wanted: WantedOfPair = section(WantedOfPair)
    run: RunSettings = section(RunSettings, default=RunSettings(0.1, 5000.0, 0.0))

    facts = facts_at(f"{DERIVED}:axis_ratio", f"{DERIVED}:greatest_exponent")
    check = lazy_import(f"{DERIVED}:check")
    resolve = lazy_import(f"{DERIVED}:resolve")
