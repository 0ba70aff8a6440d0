"""Parameters of a bearing scene: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from bearing_twin.base.parameters import choice, quantity, section, text
from bearing_twin.contact.friction import AUTO, PATCH_NAMES, POINT, friction_names
from bearing_twin.contact.laws import numbers_missing
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material
from bearing_twin.kinds.bearing import catalogue
from bearing_twin.kinds.bearing.defects import defect_list, defect_problems
from bearing_twin.kinds.bearing.geometry import Fits, Temperatures, clearance_problems, operating_geometry
from bearing_twin.kinds.bearing.lubricant import (
    FORTY,
    NONE,
    Lubricant,
    Surface,
    is_lubricated,
    lubricant_problems,
    rolling_speed,
)
from bearing_twin.kinds.bearing.rings import (
    COMMON_STEPS,
    LOADS,
    QUASI_STATIC,
    Cage,
    Drive,
    Model,
    Rings,
    dimension_of,
    ring_problems,
    torque_problems,
)
from bearing_twin.kinds.contract import SceneParameters, lazy_import
from bearing_twin.kinds.rules import BEARING, facts_at, pick
from bearing_twin.kinds.sections import (
    LOOSEST,
    Bounded,
    Friction,
    PointElastic,
    RunSettings,
    ViscoelasticDamping,
    Wanted,
    check_damping,
    check_key,
    check_run,
    free_fall,
    point_laws,
    resolved_run,
)
from bearing_twin.methods import STEPPER_FACTS

NO_SENSOR, HOUSING = "none", "housing"
FASTEST_SAMPLING = 50e3  # Hz
SAMPLES_A_PULSE = 1.0  # of half the time in which a ball passes a spall


@dataclass(frozen=True)
class Housing:
    """The housing along the sensor's direction, outer ring included."""

    mass: float = quantity(
        5.0,
        "kg",
        "of the housing that moves with the outer ring under a sensor; by itself where the inner ring is held",
        above=0.0,
    )
    stiffness: float = quantity(1.8e9, "N/m", "of what holds it", at_least=0.0)
    damping: float = quantity(3.8e3, "N s/m", "of what holds it", at_least=0.0)


@dataclass(frozen=True)
class Sensor:
    """An accelerometer, whose samples are records of their own rate."""

    on: str = choice(NO_SENSOR, (NO_SENSOR, HOUSING), "where it is; none = there is none")
    direction: tuple[float, float, float] = quantity((0.0, 1.0, 0.0), "1", "along which it measures, of any length")
    rate: float = quantity(12e3, "Hz", "samples a second", above=0.0, at_most=FASTEST_SAMPLING)
    noise: float = quantity(0.0, "m/s^2", "standard deviation of the noise of a sample", at_least=0.0)
    seed: int = quantity(0, "1", "of the noise", at_least=0)

    @property
    def unit_direction(self) -> tuple[float, ...]:
        """The direction, of length 1."""
        return tuple(component / math.hypot(*self.direction) for component in self.direction)


def has_sensor(parameters) -> bool:
    """True if there is an accelerometer on the housing."""
    return parameters.sensor.on != NO_SENSOR


def sensor_problems(parameters, geometry) -> list[str]:
    """Problems of a sensor, one sentence each."""
    sensor, problems = parameters.sensor, []
    if not has_sensor(parameters):
        return problems
    if dimension_of(parameters) == QUASI_STATIC:
        problems.append(
            "sensor.on = housing measures vibration, of which runs of equilibria have none; set model.dimension: free, "
            "with a ring that moves under its load, or prescribed, with one that is held"
        )
    if not any(sensor.direction):
        problems.append("sensor.direction must not be zero; give it along which axis it measures")
    if (stepper := parameters.solver.stepper) not in COMMON_STEPS:
        legal = " or ".join(COMMON_STEPS)
        problems.append(f"solver.stepper = {stepper} takes no samples between its steps; use {legal}")
    ratio = geometry.ball_diameter / geometry.pitch_diameter
    for index, defect in enumerate(parameters.defects):
        share = {"outer": 1.0 - ratio, "inner": 1.0 + ratio, "ball": 1.0 / ratio - ratio}[defect.on]
        speed = 0.5 * share * abs(parameters.drive.changed_speed) * defect.radius(geometry)
        least = SAMPLES_A_PULSE * speed / (0.5 * defect.spall.length) if defect.spall.length else 0.0
        if sensor.rate < least:
            problems.append(
                f"sensor.rate = {sensor.rate:g} Hz is too low for the double pulse of defects[{index}]; "
                f"at least {math.ceil(least)} Hz"
            )
    return problems


PACKAGE = "bearing_twin.kinds.bearing"
LAW_NEEDS = ("curvatures", "frozen", "stiffness", "state")  # that laws may need
STEADY_REFUSED = {"steady": "is not modelled in bearings; legal: hunt_crossley, with contact.restitution_speed"}
MOTIONS = ("rolling", "rest")
STEEPEST = 0.25 * math.pi  # rad: radial bearings end at 45 degrees
RELAXATION_TIME = 1.0e-6  # s, default; no source, see the key's help
ISO_GROOVES = "0.52 is the greatest that ISO 281 rates by its factors"


@dataclass(frozen=True)
class Geometry:
    """Bearing geometry; the rings' axis is z and the ring centres coincide when the offset is zero."""

    balls: int = quantity(8, "1", "number of balls, evenly spaced at the start", at_least=1, at_most=4096)
    ball_diameter: float = quantity(6.746e-3, "m", "ball diameter", above=0.0, at_most=1.0)
    pitch_diameter: float = quantity(28.5e-3, "m", "diameter of the circle of ball centres", above=0.0, at_most=20.0)
    inner_conformity: float = quantity(
        0.52, "1", f"inner groove radius / ball diameter; {ISO_GROOVES}", above=0.5, at_most=10.0
    )
    outer_conformity: float = quantity(
        0.52, "1", f"outer groove radius / ball diameter; {ISO_GROOVES}", above=0.5, at_most=10.0
    )
    radial_clearance: float = quantity(
        -6.0e-6,
        "m",
        "radial internal clearance: free travel of the inner ring across a diameter; negative = interference",
    )
    contact_angle: float = quantity(
        0.0,
        "rad",
        "of a bearing without load, in place of radial_clearance; 0 = radial_clearance holds",
        at_least=0.0,
        at_most=STEEPEST,
    )
    designation: str = text(
        "",
        "of the catalogue (`bearing_twin bearing --list`); its row fills in the keys of geometry that are left out",
        catalogue.designations,
        stands_for_section=True,
    )


@dataclass(frozen=True)
class Materials:
    """Materials by name (see `materials.MATERIALS`) or by value."""

    ball: Material = section(Material, "steel", MATERIALS)
    inner_ring: Material = section(Material, "steel", MATERIALS)
    outer_ring: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class BearingContact(ViscoelasticDamping, Friction, PointElastic):
    """The laws of one ball-raceway contact; balls among themselves have the same damping and friction at a point."""

    normal: str = choice("auto", point_laws(*LAW_NEEDS), "elastic law; auto = the cheapest adequate one")
    friction: str = choice(
        POINT,
        lambda: (AUTO, *friction_names()),
        "point = by the slip at the contact point; others = over the whole contact patch (patch = spot); "
        "auto = the cheapest adequate one, also where it is left out and there is a lubricant",
        aliases=PATCH_NAMES,
    )
    friction_regularisation: float = quantity(
        0.0,
        "m/s",
        "slip speed at which friction reaches 71 % of its limit; 0 = 0.01, with a lubricant 0.5 % of the speed of "
        "rolling where that is less; no source: smaller is truer and stiffer",
        at_least=0.0,
    )
    damping_law: str = choice(
        "hunt_crossley", ("hunt_crossley",), "of a restitution below 1: it loses more when faster", STEADY_REFUSED
    )


CONTACT = BearingContact(
    relaxation_time=RELAXATION_TIME,
    restitution_speed=0.1,
    friction_coefficient=0.08,
)
SMOOTHING, CREEP = 0.01, 0.005  # m/s of slip, share of the speed of rolling: where friction is smoothed by default


@dataclass(frozen=True)
class GivenRatings:
    """Ratings of a catalogue, in place of those that follow from the geometry."""

    dynamic: float = quantity(0.0, "N", "basic dynamic rating; 0 = by ISO 281 from the geometry", at_least=0.0)
    static: float = quantity(0.0, "N", "basic static rating; 0 = by ISO 76 from the geometry", at_least=0.0)


@dataclass(frozen=True)
class Initial:
    """The start of the balls."""

    motion: str = choice("rolling", MOTIONS, "rolling = kinematic rolling at the drive's speed; rest = balls at rest")


def _steppers() -> tuple[str, ...]:
    return ("auto", *STEPPER_FACTS)


@dataclass(frozen=True)
class Solver(Bounded):
    """The integration of the equations."""

    stepper: str = choice("auto", _steppers, "integration method; auto = the cheapest adequate one")
    step: float = quantity(0.0, "s", "step of fixed-step methods; 0 = chosen from the scene's stiffness", at_least=0.0)
    check: str = check_key()


LEAST_TOLERANCE = 1e-10  # at 1e-11 every second step is rejected for rounding, and 16 times as many are taken
ROUNDED = "less than double precision gives in a bearing, whose approaches are small differences of positions"
ERROR_WANTED = "requested error of loads, over the greatest, and of friction, over mu N"


@dataclass(frozen=True)
class WantedLoads(Wanted):
    """Requested outputs of a bearing, whose loads may be had without friction."""

    outputs: str = choice(
        "history",
        ("history", LOADS),
        "history = every channel over time; loads = friction torque, slip and losses may be left out, so that "
        "model.dimension: auto may be quasi_static",
        widest=True,
    )
    tolerance: float = quantity(1e-3, "1", ERROR_WANTED, at_least=LEAST_TOLERANCE, at_most=LOOSEST, less=ROUNDED)


@dataclass(frozen=True)
class BearingScene(SceneParameters):
    """Balls between two grooved raceways (paper 1, section 5)."""

    geometry: Geometry = section(Geometry)
    fits: Fits = section(Fits)
    temperatures: Temperatures = section(Temperatures)
    ratings: GivenRatings = section(GivenRatings)
    materials: Materials = section(Materials)
    model: Model = section(Model)
    contact: BearingContact = section(BearingContact, default=CONTACT)
    lubricant: Lubricant = section(Lubricant)
    surface: Surface = section(Surface)
    temperature: float = quantity(FORTY, "K", "of the lubricant, such as 60°C", above=0.0)
    drive: Drive = section(Drive)
    rings: Rings = section(Rings)
    cage: Cage = section(Cage)
    gravity: tuple[float, float, float] = free_fall(0.0, -1.0, 0.0)
    initial: Initial = section(Initial)
    defects: tuple = defect_list()
    housing: Housing = section(Housing)
    sensor: Sensor = section(Sensor)
    solver: Solver = section(Solver)
    wanted: WantedLoads = section(WantedLoads)
    run: RunSettings = section(RunSettings, default=RunSettings(1.0, 1000.0, 100.0))

    moved: ClassVar = {
        "contact.yield_pressure": "materials.*.yield_strength, which is the yield pressure over 1.6",
    }
    facts = facts_at(
        f"{PACKAGE}.models:axis_ratio",
        f"{PACKAGE}.models:slip_at_start",
        f"{PACKAGE}.models:ring_shift",
        f"{PACKAGE}.models:relative_acceleration",
        f"{PACKAGE}.models:centrifugal_share",
    )
    missing_figures: ClassVar = lazy_import(f"{PACKAGE}.quantities:missing")

    @staticmethod
    def completed(scene: dict) -> tuple[dict, list[str]]:
        """The plain data of a scene with the row of its designation, and with friction `auto` where it has a lubricant.

        Spin of contacts is a part of the torque of a lubricated bearing.
        """
        contact, lubricant = scene.get("contact", {}), scene.get("lubricant")
        has_lubricant = isinstance(lubricant, Mapping) and lubricant.get("kind", NONE) != NONE
        if has_lubricant and isinstance(contact, Mapping) and "friction" not in contact:
            scene = {**scene, "contact": {**contact, "friction": AUTO}}
        return catalogue.completed(scene)

    @staticmethod
    def upgraded(scene: dict) -> dict:
        """The plain data of a scene in today's words, from those of an earlier version."""
        if "yield_pressure" in scene.get("contact", {}):
            strength = scene["contact"].pop("yield_pressure") / YIELD_ONSET
            for body in ("ball", "inner_ring", "outer_ring"):
                scene["materials"][body]["yield_strength"] = strength
        return scene

    def resolve(self) -> "BearingScene":
        """The parameters of a checked scene; a restitution leaves no relaxation time."""
        smoothing = self.contact.friction_regularisation or self._smoothing()
        contact = dataclasses.replace(
            self.contact, relaxation_time=viscous_terms(self.contact)[1], friction_regularisation=smoothing
        )
        cage = dataclasses.replace(self.cage, kind=pick(BEARING, "cage.kind", self, self.cage.kind).value)
        return dataclasses.replace(self, contact=contact, cage=cage, run=resolved_run(self.run))

    def _smoothing(self) -> float:
        """Slip speed [m/s] below which friction is smoothed by default: in oil friction saturates with the rolling."""
        drive = self.drive
        rolling = rolling_speed(self.geometry, max(abs(drive.speed), abs(drive.changed_speed)))
        return min(SMOOTHING, CREEP * rolling or SMOOTHING) if is_lubricated(self) else SMOOTHING

    def check(self) -> list[str]:
        """Contradictions between keys, one sentence each that names keys, values and limits."""
        if problems := clearance_problems(self):
            return problems
        geometry, run, drive = operating_geometry(self), self.run, self.drive
        ball, pitch, clearance = geometry.ball_diameter, geometry.pitch_diameter, geometry.radial_clearance
        crowded = geometry.balls >= 2 and pitch > ball > pitch * math.sin(math.pi / geometry.balls)
        fitting = math.floor(math.pi / math.asin(min(ball / pitch, 1.0)))
        widest = 0.5 * (pitch / ball + 1.0)
        least = -GREATEST_INTERFERENCE * ball
        greatest = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * ball
        rows = (
            (
                pitch <= ball,
                f"geometry.pitch_diameter = {pitch:g} m leaves no inner raceway; it must exceed geometry.ball_diameter "
                f"= {ball:g} m",
            ),
            (
                crowded,
                f"geometry.balls = {geometry.balls} balls of {ball:g} m do not fit on a circle of {pitch:g} m; at most "
                f"{fitting} do, or geometry.ball_diameter at most {pitch * math.sin(math.pi / geometry.balls):.6g} m",
            ),
            (
                geometry.outer_conformity >= widest,
                f"geometry.outer_conformity = {geometry.outer_conformity:g} makes the groove wider than the outer "
                f"ring; it must be below {widest:.6g} for this ball and pitch diameter",
            ),
            (
                not least <= clearance <= greatest,
                f"geometry.radial_clearance = {clearance:g} m is outside what grooves of a ball of {ball:g} m hold; it "
                f"must be between {least:.6g} and {greatest:.6g} m",
            ),
        )
        problems = [sentence for wrong, sentence in rows if wrong]
        if least <= clearance <= greatest:
            problem = _offset_problem("drive.offset", drive.offset, geometry) or _offset_problem(
                "drive.offset + drive.change.offset", drive.changed_offset, geometry
            )
            problems += [problem] if problem else []
        problems += [
            *ring_problems(self),
            *defect_problems(self.defects, geometry),
            *sensor_problems(self, geometry),
            *torque_problems(self, dimension_of(self) == QUASI_STATIC),
            *numbers_missing(self.contact),
            *check_damping(self.contact, False, {"relaxation_time": RELAXATION_TIME}),
            *check_run(run),
        ]
        problems += [] if problems else lubricant_problems(self)
        if not (run.duration and run.output_rate):
            problems.append("run.duration and run.output_rate of a bearing must be above 0; give seconds and Hz")
        return problems


GREATEST_INTERFERENCE = 0.02  # of the ball diameter: beyond it the contacts are no longer small
GREATEST_SQUEEZE = 0.02  # of the ball diameter: approaches of a ball's two contacts together, as of an interference
GREATEST_ANGLE = math.radians(60.0)  # contact angle: beyond it contacts lie on the edges of the grooves


def viscous_terms(contact: BearingContact) -> tuple[float, float]:
    """Hunt and Crossley's damping [s/m] and the relaxation time [s] of the contacts: given, or from a restitution."""
    from bearing_twin.contact.laws import damping_for_restitution

    if contact.restitution == 1.0:
        return contact.damping, contact.relaxation_time
    return damping_for_restitution(contact.restitution, contact.restitution_speed), 0.0


@functools.lru_cache(64)  # equal scenes stay one object, which copies of a run's writers share
def with_friction(parameters: BearingScene, friction: str) -> BearingScene:
    """The same scene with this friction model if its own is `auto`."""
    if parameters.contact.friction != AUTO:
        return parameters
    return dataclasses.replace(parameters, contact=dataclasses.replace(parameters.contact, friction=friction))


def with_chosen_friction(parameters: BearingScene, choice=None) -> BearingScene:
    """The scene with the friction model of a choice, else of the rules, if its own is `auto`."""
    if parameters.contact.friction != AUTO:
        return parameters
    name = getattr(choice, "friction", "")  # that of a log may be any text
    if name not in friction_names():
        name = pick(BEARING, "contact.friction", parameters).value
    return with_friction(parameters, name)


def _offset_problem(key: str, offset: tuple[float, float, float], geometry: Geometry) -> str:
    """Problem of this offset of the inner ring for a ball anywhere along its orbit, "" if there is none.

    Between the centres of the grooves lie A_r = (f_i + f_o - 1) D - c/2 + r cos(psi) and A_z = z; the ball is squeezed
    by hypot(A_r, A_z) - (f_i + f_o - 1) D at the angle of this line, most of all where the radial offset r points.
    """
    ball, radial, axial = geometry.ball_diameter, math.hypot(*offset[:2]), abs(offset[2])
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * ball
    middle, limit = free - 0.5 * geometry.radial_clearance, GREATEST_SQUEEZE * ball
    squeeze = math.hypot(middle + radial, axial) - free
    if squeeze > limit and radial + axial > 0.0:
        # the root s of |(middle, 0) + s (radial, axial)| = free + limit
        length = math.hypot(radial, axial)
        half_b, c = middle * radial / length, (free + limit) ** 2 - middle**2
        longest = c / (half_b + math.sqrt(half_b**2 + c)) if c > 0.0 else 0.0
        return (
            f"{key} = {list(offset)} m squeezes a ball by {squeeze:.4g} m between the raceways, more than a contact "
            f"bears ({limit:.4g} m, {100.0 * GREATEST_SQUEEZE:g} % of its diameter); in this direction its length must "
            f"be below {longest:.5g} m"
        )
    # of all balls that touch both raceways, the one nearest to the middle of the groove's opening
    nearest = max(middle - radial, math.sqrt(max(free**2 - axial**2, 0.0)) if axial < free else -math.inf)
    angle = math.atan2(axial, nearest)
    if nearest <= middle + radial and angle > GREATEST_ANGLE:
        return (
            f"{key} = {list(offset)} m brings contacts to an angle of {math.degrees(angle):.3g} degrees, on the edge "
            f"of the grooves; at most {math.degrees(GREATEST_ANGLE):.3g} degrees: shorten its part along z, or lower "
            "geometry.radial_clearance"
        )
    return ""
