"""Every number and choice of a bearing scene: its YAML keys, units, defaults and limits in one place."""

from dataclasses import dataclass, field

from bearing_twin.materials import Material
from bearing_twin.parameters import quantity, choice, section

ELASTIC_LAWS = ("hertz", "hertz_exact", "volumetric", "constant")
STEPPERS = ("rk4", "rodas4", "dop853", "radau")
MOTIONS = ("rolling", "rest")


@dataclass(frozen=True)
class Geometry:
    """Bearing geometry; the rings' axis is z and the ring centres coincide when the offset is zero."""

    balls: int = quantity(8, "1", "number of balls, evenly spaced at the start", at_least=1, at_most=4096)
    ball_diameter: float = quantity(6.746e-3, "m", "ball diameter", above=0.0)
    pitch_diameter: float = quantity(28.5e-3, "m", "diameter of the circle of ball centres", above=0.0)
    inner_conformity: float = quantity(0.52, "1", "inner groove radius / ball diameter", above=0.5, at_most=10.0)
    outer_conformity: float = quantity(0.52, "1", "outer groove radius / ball diameter", above=0.5, at_most=10.0)
    radial_clearance: float = quantity(
        -6.0e-6, "m", "radial internal clearance: free travel of the inner ring across a diameter; negative = interference"
    )


@dataclass(frozen=True)
class Materials:
    """Materials by name (see `materials.MATERIALS`) or by value."""

    ball: Material = section(Material, "steel")
    inner_ring: Material = section(Material, "steel")
    outer_ring: Material = section(Material, "steel")


@dataclass(frozen=True)
class Contact:
    """The laws of one ball-raceway contact."""

    normal: str = choice("auto", ("auto", *ELASTIC_LAWS), "elastic law; auto = the cheapest adequate one")
    damping: float = quantity(
        0.2, "s/m", "viscous term: normal load = elastic load * (1 + damping * approach rate), never below zero", at_least=0.0
    )
    friction_coefficient: float = quantity(0.08, "1", "Coulomb friction coefficient", at_least=0.0, at_most=10.0)
    friction_regularisation: float = quantity(
        0.01, "m/s", "slip speed at which friction reaches 71 % of its limit", above=0.0
    )


@dataclass(frozen=True)
class Drive:
    """Prescribed motion of the inner ring; the outer ring is at rest."""

    speed: float = quantity(183.26, "rad/s", "speed of the inner ring about +z")
    acceleration: float = quantity(2000.0, "rad/s^2", "rate at which a commanded speed is approached", above=0.0)
    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "displacement of the inner ring's centre")


@dataclass(frozen=True)
class Initial:
    """How the balls start."""

    motion: str = choice("rolling", MOTIONS, "rolling = kinematic rolling at the drive's speed; rest = balls at rest")


@dataclass(frozen=True)
class Solver:
    """How the equations are integrated."""

    stepper: str = choice("auto", ("auto", *STEPPERS), "integration method; auto = the cheapest adequate one")
    tolerance: float = quantity(1e-3, "1", "wanted relative error of load and friction torque", above=0.0, at_most=0.1)
    step: float = quantity(0.0, "s", "step of fixed-step methods; 0 = chosen from the scene's stiffness", at_least=0.0)


@dataclass(frozen=True)
class Run:
    """What is computed and how often it is given out."""

    duration: float = quantity(1.0, "s", "simulated time", above=0.0, at_most=86400.0)
    output_rate: float = quantity(1000.0, "Hz", "solver outputs; every one is in the log", above=0.0, at_most=1e8)
    publish_rate: float = quantity(100.0, "Hz", "wrenches, contacts and state", above=0.0, at_most=1e6)


@dataclass(frozen=True)
class BearingScene:
    """Balls between two grooved raceways (paper 1, section 5)."""

    geometry: Geometry = section(Geometry)
    materials: Materials = section(Materials)
    contact: Contact = section(Contact)
    drive: Drive = section(Drive)
    gravity: tuple[float, float, float] = quantity((0.0, -9.80665, 0.0), "m/s^2", "acceleration of free fall; zeros switch it off")
    initial: Initial = section(Initial)
    solver: Solver = section(Solver)
    run: Run = section(Run)
