"""Every number and choice of a bearing scene: its YAML keys, units, defaults and limits in one place."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass

from bearing_twin.contact.damping import damping_for_restitution
from bearing_twin.contact.materials import MATERIALS, Material
from bearing_twin.parameters import choice, quantity, section

ELASTIC_LAWS = ("hertz", "hertz_exact", "volumetric", "constant")
REFUSED_LAWS = {
    "hertz_differential": "carries the shape of each ellipse as states, which a bearing's motion has no room for; use "
    "hertz, the same load to 1e-10 and cheaper, or bearing_twin.contact.differential in a motion of your own"
}
STEPPERS = ("rodas4", "rodas4_landing", "rodas3", "imex", "rk4", "dopri5", "dop853", "radau")
FRICTIONS = ("point", "spot")
MOTIONS = ("rolling", "rest")
RELAXATION_TIME = 1.0e-6  # s, unless the scene says otherwise


@dataclass(frozen=True)
class Geometry:
    """Bearing geometry; the rings' axis is z and the ring centres coincide when the offset is zero."""

    balls: int = quantity(8, "1", "number of balls, evenly spaced at the start", at_least=1, at_most=4096)
    ball_diameter: float = quantity(6.746e-3, "m", "ball diameter", above=0.0)
    pitch_diameter: float = quantity(28.5e-3, "m", "diameter of the circle of ball centres", above=0.0)
    inner_conformity: float = quantity(0.52, "1", "inner groove radius / ball diameter", above=0.5, at_most=10.0)
    outer_conformity: float = quantity(0.52, "1", "outer groove radius / ball diameter", above=0.5, at_most=10.0)
    radial_clearance: float = quantity(
        -6.0e-6,
        "m",
        "radial internal clearance: free travel of the inner ring across a diameter; negative = interference",
    )


@dataclass(frozen=True)
class Materials:
    """Materials by name (see `materials.MATERIALS`) or by value."""

    ball: Material = section(Material, "steel", MATERIALS)
    inner_ring: Material = section(Material, "steel", MATERIALS)
    outer_ring: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Contact:
    """The laws of one ball-raceway contact."""

    normal: str = choice("auto", ("auto", *ELASTIC_LAWS), "elastic law; auto = the cheapest adequate one", REFUSED_LAWS)
    damping: float = quantity(
        0.0, "s/m", "viscous term of Hunt and Crossley: damping * elastic load * approach rate", at_least=0.0
    )
    relaxation_time: float = quantity(
        RELAXATION_TIME,
        "s",
        "viscous term of a viscoelastic contact: relaxation_time * stiffness * approach rate",
        at_least=0.0,
    )
    restitution: float = quantity(
        1.0,
        "1",
        "of a ball on a raceway at restitution_speed; below 1 it takes the place of damping and relaxation_time",
        above=0.0,
        at_most=1.0,
    )
    restitution_speed: float = quantity(
        0.1, "m/s", "approach speed at which restitution holds; faster contacts lose more", above=0.0
    )
    friction: str = choice(
        "point", FRICTIONS, "on a raceway: by the slip at the contact point, or over the spot that slides and spins"
    )
    friction_coefficient: float = quantity(0.08, "1", "Coulomb friction coefficient", at_least=0.0, at_most=10.0)
    friction_regularisation: float = quantity(
        0.01, "m/s", "slip speed at which friction reaches 71 % of its limit", above=0.0
    )
    yield_pressure: float = quantity(
        3.2e9, "Pa", "peak pressure of first yield, 1.6 times the strength of the weaker body", above=0.0
    )


@dataclass(frozen=True)
class Change:
    """One change of the drive while it runs, added to what it was."""

    time: float = quantity(0.0, "s", "when the drive changes; 0 = never", at_least=0.0)
    speed: float = quantity(0.0, "rad/s", "added to the wanted speed, which is approached at drive.acceleration")
    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "added to the inner ring's offset, at once")


@dataclass(frozen=True)
class Drive:
    """Prescribed motion of the inner ring; the outer ring is at rest."""

    speed: float = quantity(183.26, "rad/s", "speed of the inner ring about +z")
    acceleration: float = quantity(2000.0, "rad/s^2", "rate at which a commanded speed is approached", above=0.0)
    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "displacement of the inner ring's centre")
    change: Change = section(Change)


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
    gravity: tuple[float, float, float] = quantity(
        (0.0, -9.80665, 0.0), "m/s^2", "acceleration of free fall; zeros switch it off"
    )
    initial: Initial = section(Initial)
    solver: Solver = section(Solver)
    run: Run = section(Run)


GREATEST_INTERFERENCE = 0.02  # of the ball diameter: beyond it the contacts are no longer small
GREATEST_CLEARANCE = 0.1  # of the ball diameter: beyond it the grooves no longer hold the balls
GREATEST_SQUEEZE = 0.02  # of the ball diameter: approaches of a ball's two contacts together, as of an interference
GREATEST_ANGLE = math.radians(60.0)  # contact angle: beyond it contacts lie on the edges of the grooves
GREATEST_OUTPUT_COUNT = 1e9


def viscous_terms(contact: Contact) -> tuple[float, float]:
    """Hunt and Crossley's damping [s/m] and the relaxation time [s] of the contacts: given, or from a restitution."""
    if contact.restitution == 1.0:
        return contact.damping, contact.relaxation_time
    return damping_for_restitution(contact.restitution, contact.restitution_speed), 0.0


def resolve(parameters: BearingScene) -> BearingScene:
    """The parameters of a checked scene; a restitution leaves no relaxation time."""
    contact = dataclasses.replace(parameters.contact, relaxation_time=viscous_terms(parameters.contact)[1])
    return dataclasses.replace(parameters, contact=contact)


def check(parameters: BearingScene) -> list[str]:
    """What is impossible although each number alone is legal; one line a problem, naming keys, values and limits."""
    geometry, run = parameters.geometry, parameters.run
    ball, pitch = geometry.ball_diameter, geometry.pitch_diameter
    problems = []
    if pitch <= ball:
        problems.append(
            f"geometry.pitch_diameter = {pitch:g} m leaves no inner raceway; "
            f"it must exceed geometry.ball_diameter = {ball:g} m"
        )
    elif geometry.balls >= 2 and ball > pitch * math.sin(math.pi / geometry.balls):
        fitting = math.floor(math.pi / math.asin(ball / pitch))
        widest = pitch * math.sin(math.pi / geometry.balls)
        problems.append(
            f"geometry.balls = {geometry.balls} balls of {ball:g} m do not fit on a circle of {pitch:g} m; "
            f"at most {fitting} do, or geometry.ball_diameter at most {widest:.6g} m"
        )
    widest = 0.5 * (pitch / ball + 1.0)
    if geometry.outer_conformity >= widest:
        problems.append(
            f"geometry.outer_conformity = {geometry.outer_conformity:g} makes the groove wider than the outer ring; "
            f"it must be below {widest:.6g} for this ball and pitch diameter"
        )
    if not -GREATEST_INTERFERENCE * ball <= geometry.radial_clearance <= GREATEST_CLEARANCE * ball:
        problems.append(
            f"geometry.radial_clearance = {geometry.radial_clearance:g} m is outside what a ball of {ball:g} m bears; "
            f"it must be between {-GREATEST_INTERFERENCE * ball:.6g} and {GREATEST_CLEARANCE * ball:.6g} m"
        )
    first, added = parameters.drive.offset, parameters.drive.change.offset
    changed = tuple(a + b for a, b in zip(first, added, strict=True))
    for key, vector in (("drive.offset", first), ("drive.offset + drive.change.offset", changed)):
        found = _check_offset(key, vector, geometry)
        if found:
            problems.append(found)
            break
    problems += _check_restitution(parameters.contact)
    if run.publish_rate > run.output_rate:
        problems.append(
            f"run.publish_rate = {run.publish_rate:g} Hz cannot exceed run.output_rate = {run.output_rate:g} Hz; "
            f"raise the latter or lower the former"
        )
    if run.duration * run.output_rate > GREATEST_OUTPUT_COUNT:
        problems.append(
            f"run.duration * run.output_rate = {run.duration * run.output_rate:g} outputs is too many; "
            f"at most {GREATEST_OUTPUT_COUNT:g}"
        )
    return problems


def _check_offset(key: str, vector: tuple[float, float, float], geometry: Geometry) -> str:
    """What is wrong with this displacement of the inner ring for a ball anywhere on its way round, "" if nothing.

    Between the centres of the grooves lie A_r = (f_i + f_o - 1) D - c/2 + r cos(psi) and A_z = z; the ball is squeezed
    by hypot(A_r, A_z) - (f_i + f_o - 1) D at the angle of this line, most of all where the radial offset r points.
    """
    ball, radial, axial = geometry.ball_diameter, math.hypot(*vector[:2]), abs(vector[2])
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * ball
    middle, limit = free - 0.5 * geometry.radial_clearance, GREATEST_SQUEEZE * ball
    squeeze = math.hypot(middle + radial, axial) - free
    if squeeze > limit and radial + axial > 0.0:
        # the root s of |(middle, 0) + s (radial, axial)| = free + limit
        length = math.hypot(radial, axial)
        along = middle * radial / length
        longest = (free + limit) ** 2 - middle**2
        longest = longest / (along + math.sqrt(along**2 + longest)) if longest > 0.0 else 0.0
        return (
            f"{key} = {list(vector)} m squeezes a ball by {squeeze:.4g} m between the raceways, more than a contact "
            f"bears ({limit:.4g} m, {100.0 * GREATEST_SQUEEZE:g} % of its diameter); in this direction its length must "
            f"be below {longest:.5g} m"
        )
    # of all balls that touch both raceways, the one nearest to the middle of the groove's opening
    nearest = max(middle - radial, math.sqrt(max(free**2 - axial**2, 0.0)) if axial < free else -math.inf)
    angle = math.atan2(axial, nearest)
    if nearest <= middle + radial and angle > GREATEST_ANGLE:
        return (
            f"{key} = {list(vector)} m brings contacts to an angle of {math.degrees(angle):.3g} degrees, on the edge "
            f"of the grooves; at most {math.degrees(GREATEST_ANGLE):.3g} degrees: shorten its part along z, or lower "
            "geometry.radial_clearance"
        )
    return ""


def _check_restitution(contact: Contact) -> list[str]:
    if contact.restitution == 1.0:
        return []
    return [
        f"contact.restitution = {contact.restitution:g} and contact.{name} = {value:g} {unit} both set the damping; "
        "leave one of them out"
        for name, value, unit, left_out in (
            ("damping", contact.damping, "s/m", (0.0,)),
            ("relaxation_time", contact.relaxation_time, "s", (0.0, RELAXATION_TIME)),
        )
        if value not in left_out
    ]
