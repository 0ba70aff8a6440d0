"""Rings and cage of a scene: drive, loads, support, spacing of the balls, and dimension of the model."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import math
from dataclasses import dataclass, replace

from bearing_twin.base.parameters import choice, number_table, quantity, section
from bearing_twin.contact.friction import AUTO
from bearing_twin.methods import COUPLED

SHARED, OUTER, INNER = "shared", "outer", "inner"
CONTROLS = {AUTO: (1.0, 1.0), SHARED: (1.0, 1.0), OUTER: (0.0, 2.0), INNER: (2.0, 0.0)}
"""Words of `model.control`: shares of the gyroscopic moment that friction carries on the inner and outer raceway."""
ALIASES = {"settled": SHARED}  # words of earlier versions

LOAD_COLUMNS = (("time", "s"), ("x", "N"), ("y", "N"), ("z", "N"), ("about x", "N m"), ("about y", "N m"))


@dataclass(frozen=True)
class LoadChange:
    """One change of the load while it runs, added at once."""

    time: float = quantity(0.0, "s", "when the load changes; 0 = never", at_least=0.0)
    load: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "N", "added to load")
    moment: tuple[float, float] = quantity((0.0, 0.0), "N m", "added to moment")


def steady_load(point: str):
    """The key `load` [N]: the force on a body at a point, as `on the inner ring at its centre`."""
    return quantity((0.0, 0.0, 0.0), "N", f"force {point}")


def steady_moment(body: str):
    """The key `moment` [N m] about x and y."""
    return quantity((0.0, 0.0), "N m", f"on {body} about x and y")


def load_table():
    """The key `table`: rows of LOAD_COLUMNS, or the name of a CSV file of them."""
    return number_table(
        LOAD_COLUMNS, "loads over time, added to load and moment; straight between rows, then as the last"
    )


SPEED, TORQUE = "speed", "torque"  # drive.kind
TORQUE_COLUMNS = (("time", "s"), ("torque", "N m"))


@dataclass(frozen=True)
class SpeedChange:
    """One change of the drive's speed while it runs, added to it."""

    time: float = quantity(0.0, "s", "when the drive changes; 0 = never", at_least=0.0)
    speed: float = quantity(0.0, "rad/s", "added to the prescribed speed, which is approached at drive.acceleration")


@dataclass(frozen=True)
class Change(SpeedChange):
    """One change of the drive while it runs."""

    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "added to the inner ring's offset, at once")


@dataclass(frozen=True)
class Drive:
    """Drive of the inner ring, and its held position; the outer ring is at rest."""

    kind: str = choice(
        SPEED,
        (SPEED, TORQUE),
        "speed = the inner ring turns as prescribed; torque = its speed follows from torque, inertia and friction",
    )
    speed: float = quantity(183.26, "rad/s", "speed of the inner ring about +z; where a torque turns it, at the start")
    acceleration: float = quantity(2000.0, "rad/s^2", "rate at which a commanded speed is approached", above=0.0)
    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "displacement of the inner ring's centre")
    tilt: tuple[float, float] = quantity((0.0, 0.0), "rad", "misalignment of the inner ring about x and y")
    change: Change = section(Change)
    torque: float = quantity(0.0, "N m", "on the inner ring about +z, by drive.kind: torque; loads give none")
    torque_table: tuple = number_table(
        TORQUE_COLUMNS, "torque over time, added to drive.torque; straight between rows, then as the last"
    )
    inertia: float = quantity(
        0.0, "kg m^2", "about the axis, of what the torque turns besides rings.inner.inertia[1]", at_least=0.0
    )
    damping: float = quantity(0.0, "N m s", "viscous, about the axis: the braking torque over the speed", at_least=0.0)
    greatest_speed: float = quantity(1.0e4, "rad/s", "by drive.kind: torque; a run that exceeds it ends", above=0.0)

    @property
    def changed_speed(self) -> float:
        """The speed [rad/s] after the change."""
        return self.speed + self.change.speed

    @property
    def changed_offset(self) -> tuple[float, float, float]:
        """Displacement of the ring's centre [m] after the change."""
        x, y, z = (offset + change for offset, change in zip(self.offset, self.change.offset, strict=True))
        return x, y, z


def shaft_inertia(parameters) -> float:
    """Moment of inertia [kg m^2] about the axis of all that a torque turns."""
    return parameters.rings.inner.inertia[1] + parameters.drive.inertia


def cage_inertia(parameters) -> float:
    """The cage's moment of inertia about its axis [kg m^2]."""
    cage = parameters.cage
    return cage.inertia or cage.mass * (0.5 * parameters.geometry.pitch_diameter) ** 2


def torque_problem(parameters, torque: float) -> str:
    """Problem of a torque [N m] that turns the ring to drive.greatest_speed within an output; "" if there is none."""
    drive = parameters.drive
    limit = drive.greatest_speed * (shaft_inertia(parameters) * parameters.run.output_rate + drive.damping)
    if abs(torque) <= limit:
        return ""
    return (
        f"a torque of {torque:g} N m turns the inner ring from rest to drive.greatest_speed = {drive.greatest_speed:g} "
        f"rad/s between two outputs; take at most {limit:.3g} N m, or more drive.inertia"
    )


def torque_problems(parameters, in_equilibrium: bool) -> list[str]:
    """Contradictions of a drive that gives a torque, one sentence each."""
    drive = parameters.drive
    if drive.kind == SPEED:
        idle = [f"drive.{key}" for key in ("torque", "torque_table", "inertia", "damping") if getattr(drive, key)]
        return [f"{' and '.join(idle)} act where drive.kind is torque; set it, or leave them out"] if idle else []
    greatest = max((drive.torque, *(drive.torque + added for _, added in drive.torque_table)), key=abs)
    rows = (
        (
            in_equilibrium,
            "drive.kind = torque has the speed follow from friction, which equilibria leave out; use model.dimension: "
            "prescribed, or free with rings.inner.mass",
        ),
        (
            shaft_inertia(parameters) == 0.0,
            "drive.kind = torque wants an inertia about the axis; give drive.inertia, or rings.inner.inertia[1], above "
            "0 kg m^2",
        ),
        (
            drive.change.time,
            "drive.change changes a prescribed speed or offset, but drive.kind = torque: give drive.torque_table, or a "
            "load on a ring with mass",
        ),
        (
            abs(drive.speed) >= drive.greatest_speed,
            f"drive.speed = {drive.speed:g} rad/s must be below drive.greatest_speed = {drive.greatest_speed:g} rad/s",
        ),
    )
    problems = [sentence for wrong, sentence in rows if wrong]
    return problems or list(filter(None, [torque_problem(parameters, greatest)]))


def scenes_by_speed(parameters) -> list:
    """The scene, and the scene at its changed speed if it has one."""
    drive = parameters.drive
    if not drive.change.speed:
        return [parameters]
    return [parameters, replace(parameters, drive=replace(drive, speed=drive.changed_speed))]


COORDINATE_NAMES = ("x", "y", "z", "theta_x", "theta_y")
FREE = {  # rings.inner.free: which of the coordinates follow the loads
    "none": (False, False, False, False, False),
    "radial": (True, True, False, False, False),
    "axial": (False, False, True, False, False),
    "displacement": (True, True, True, False, False),
    "all": (True, True, True, True, True),
}
CENTRED, BALLS, INNER_LAND, OUTER_LAND = "centred", "balls", "inner", "outer"
SHOULDER = 0.3  # ball diameters: distance of a ring's land from the pitch circle
QUASI_STATIC, PRESCRIBED, FREE_RING = "quasi_static", "prescribed", "free"
EVEN, POCKETS = "even", "pockets"
LOADS = "loads"  # of wanted.outputs
COMMON_STEPS = AUTO, *COUPLED  # of solver.stepper: methods with common steps of all balls


@dataclass(frozen=True)
class RingSupport:
    """Springs and dampers between the inner ring and the housing, at rest at the drive's offset and tilt."""

    stiffness: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "N/m", "along x, y, z", at_least=0.0)
    damping: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "N s/m", "along x, y, z", at_least=0.0)
    tilt_stiffness: float = quantity(0.0, "N m/rad", "about x and y", at_least=0.0)
    tilt_damping: float = quantity(0.0, "N m s/rad", "about x and y", at_least=0.0)


@dataclass(frozen=True)
class InnerRing:
    """Loads on the inner ring, and its freedom; a coordinate that is not free is held by the drive."""

    load: tuple[float, float, float] = steady_load("on the inner ring at its centre")
    moment: tuple[float, float] = steady_moment("the inner ring")
    free: str = choice(
        "auto", ("auto", *FREE), "coordinates that follow the loads; auto = displacement with a load, all with a moment"
    )
    mass: float = quantity(
        0.0, "kg", "of the ring and what turns with it; it weighs, and moves with model.dimension: free", at_least=0.0
    )
    inertia: tuple[float, float] = quantity(
        (0.0, 0.0), "kg m^2", "of the same about a diameter, and about its axis", at_least=0.0
    )
    unbalance: float = quantity(0.0, "kg m", "mass times radius off the axis, at +x when the run starts", at_least=0.0)
    change: LoadChange = section(LoadChange)
    table: tuple = load_table()
    support: RingSupport = section(RingSupport)


@dataclass(frozen=True)
class Rings:
    """The rings; the outer one is at rest."""

    inner: InnerRing = section(InnerRing)


@dataclass(frozen=True)
class Cage:
    """The cage, which spaces the balls: its angle moves, and with `guidance` its centre."""

    kind: str = choice(
        AUTO,
        (AUTO, "none", EVEN, POCKETS),
        "even = balls stay evenly spaced, at one orbit speed that follows from their balance; pockets = contacts; auto "
        "= even where balls have clearance, else none",
    )
    inertia: float = quantity(0.0, "kg m^2", "about its axis; 0 = mass on the pitch circle", at_least=0.0)
    mass: float = quantity(
        5.0e-3, "kg", "of the cage; gives its inertia where none is given; no source: a guess for a 6203", at_least=0.0
    )
    pocket_clearance: float = quantity(
        2.0e-4, "m", "free travel of a ball along the pitch circle; no source: 3 % of a 6203's ball", at_least=0.0
    )
    stiffness: float = quantity(
        1.0e6,
        "N/m",
        "of the cage where it touches balls or a land; no source: a hundredth of a raceway's, for a cage gives way",
        above=0.0,
    )
    relaxation_time: float = quantity(
        3.0e-5, "s", "viscous over elastic part of the same; no source: bumps die out within a period", at_least=0.0
    )
    friction: float = quantity(
        0.05, "1", "coefficient of the same; no source: a guess for lubricated cages", at_least=0.0, at_most=10.0
    )
    guidance: str = choice(
        CENTRED,
        (CENTRED, BALLS, INNER_LAND, OUTER_LAND),
        "of pockets: centred = the cage's centre stays; else it moves, carried by balls alone, or by a ring's land",
    )
    land_clearance: float = quantity(
        1.0e-4, "m", "radial, between cage and the land that guides it; no source: half that of pockets", above=0.0
    )
    land_radius: float = quantity(
        0.0, "m", "of that land; 0 = pitch radius less (inner) or plus (outer) 0.3 ball diameters", at_least=0.0
    )


@dataclass(frozen=True)
class Model:
    """The dimension of the model: which parts move by themselves."""

    dimension: str = choice(
        "auto",
        ("auto", QUASI_STATIC, PRESCRIBED, FREE_RING),
        "quasi_static = every output is an equilibrium at the balls' places; prescribed = balls move, the ring is held "
        "by the drive; free = balls move, and the ring with its mass",
    )
    control: str = choice(
        AUTO,
        tuple(CONTROLS),
        "raceway control of the balls in equilibrium: outer, inner = that raceway alone carries gyroscopic moments and "
        "sets the pitch of a ball's axis; shared = both carry them; auto = outer by Harris' criterion, else shared",
        aliases=ALIASES,
    )


def moving_centre(parameters) -> bool:
    """True if the cage's centre moves."""
    return parameters.cage.guidance != CENTRED and dimension_of(parameters) == FREE_RING


def tilts(parameters) -> bool:
    """True if the inner ring is tilted or may tilt."""
    return any(parameters.drive.tilt) or any(free_coordinates(parameters)[3:])


def land_radius(parameters) -> float:
    """Radius [m] of the land that guides the cage."""
    geometry, cage = parameters.geometry, parameters.cage
    side = -1.0 if cage.guidance == INNER_LAND else 1.0
    return cage.land_radius or 0.5 * geometry.pitch_diameter + side * SHOULDER * geometry.ball_diameter


def free_coordinates(parameters) -> tuple[bool, ...]:
    """Which of x, y, z, theta_x, theta_y of the inner ring follow their loads."""
    ring = parameters.rings.inner
    if ring.free != "auto":
        return FREE[ring.free]
    rows = ring.table
    if any(ring.moment) or any(ring.change.moment) or any(any(row[4:]) for row in rows):
        return FREE["all"]
    if any(ring.change.load) or ring.unbalance or rows:
        return FREE["displacement"]
    return FREE["displacement" if any(ring.load) else "none"]


def dimension_of(parameters) -> str:
    """The dimension of a scene; `auto` is quasi_static where the ring is loaded, free or tilted.

    It is free where a torque turns such a ring, or it has mass, balls have a cage, and only loads are requested.
    """
    has_freedom, drive = any(free_coordinates(parameters)), parameters.drive
    if parameters.model.dimension != "auto":
        return parameters.model.dimension
    massive = parameters.rings.inner.mass and parameters.cage.kind != "none" and parameters.wanted.outputs == LOADS
    if has_freedom and (drive.kind == TORQUE or massive):
        return FREE_RING
    return QUASI_STATIC if drive.kind != TORQUE and (has_freedom or any(drive.tilt)) else PRESCRIBED


def idle_loads(parameters, load, moment, *names: str) -> list[str]:
    """Problem of a load [N] (3,) and a moment [N m] (2,) of these names that act on held coordinates."""
    free = free_coordinates(parameters)
    idle = [
        f"{name}[{i}] = {value:g} {unit}"
        for name, unit, values, freedom in zip(names, ("N", "N m"), (load, moment), (free[:3], free[3:]), strict=True)
        for i, (value, is_free) in enumerate(zip(values, freedom, strict=True))
        if value != 0.0 and not is_free
    ]
    if not idle:
        return []
    return [
        f"{' and '.join(idle)} acts on a coordinate that rings.inner.free = {parameters.rings.inner.free} holds; leave "
        "the load out or free the coordinate"
    ]


def ring_problems(parameters) -> list[str]:
    """Contradictions of loads, freedom, cage and dimension, one sentence each."""
    ring, free, drive, cage = parameters.rings.inner, free_coordinates(parameters), parameters.drive, parameters.cage
    dimension, stepper = dimension_of(parameters), parameters.solver.stepper
    prescribed, massive, moves = dimension == PRESCRIBED, dimension == FREE_RING, dimension != QUASI_STATIC
    problems = []
    for name, load, moment in (
        ("", ring.load, ring.moment),
        ("change.", ring.change.load, ring.change.moment),
        *((f"table[{index}].", row[1:4], row[4:]) for index, row in enumerate(ring.table)),
    ):
        names = f"rings.inner.{name}load", f"rings.inner.{name}moment"
        problems = problems or idle_loads(parameters, load, moment, *names)
    support = ring.support
    springs = *support.stiffness, *support.damping, support.tilt_stiffness, support.tilt_damping
    dynamic = any((*ring.change.load, *ring.change.moment, ring.unbalance, ring.table)) or any(springs)
    bodies = (
        ("a ring with mass", massive),
        ("a shaft by a torque", drive.kind == TORQUE and moves),
        ("a cage", cage.kind not in (AUTO, "none") and moves),
    )
    moving = [body for body, is_moving in bodies if is_moving]
    pockets, pitch = cage.kind == POCKETS and moves, pocket_pitch(parameters.geometry)
    guided, guidance = cage.guidance != CENTRED, f"cage.guidance = {cage.guidance}"
    radius, inside = 0.5 * parameters.geometry.pitch_diameter, cage.guidance == INNER_LAND
    on_land = cage.guidance in (INNER_LAND, OUTER_LAND) and cage.land_radius
    in_pockets = guided and cage.kind == POCKETS
    rows = (
        (
            prescribed and any(free),
            "model.dimension = prescribed holds the inner ring, so that loads do not move it; use "
            "model.dimension: free with rings.inner.mass, or quasi_static, or rings.inner.free: none without loads",
        ),
        (
            massive and not any(free),
            "model.dimension = free has no free coordinate; give rings.inner.load, or rings.inner.free: all",
        ),
        (massive and ring.mass == 0.0, "model.dimension = free wants rings.inner.mass above 0 kg"),
        (
            massive and any(free[3:]) and ring.inertia[0] == 0.0,
            "a ring free to tilt wants rings.inner.inertia[0], about a diameter, above 0 kg m^2",
        ),
        (
            massive and any(drive.change.offset),
            "drive.change.offset moves a ring that is held; use rings.inner.change.load with model.dimension: free",
        ),
        (
            not massive and dynamic,
            "rings.inner.change.load, table, unbalance and support act on a ring with mass; use model.dimension: free "
            "with rings.inner.mass",
        ),
        (
            moving and stepper not in COMMON_STEPS,
            f"solver.stepper = {stepper} does not move {' or '.join(moving)}; use rodas4",
        ),
        (
            pockets and cage.mass == 0.0 and cage.inertia == 0.0,
            "cage.kind = pockets wants cage.mass or cage.inertia above 0; a cage without is even",
        ),
        (
            pockets and cage.pocket_clearance >= 0.5 * pitch,
            f"cage.pocket_clearance = {cage.pocket_clearance:g} m reaches into the next pocket; at most "
            f"{0.5 * pitch:.4g} m",
        ),
        (guided and not in_pockets, f"{guidance} guides a cage of kind pockets; set cage.kind: pockets"),
        (
            in_pockets and prescribed,
            f"{guidance} is built for a ring with mass; set model.dimension: free with rings.inner.mass",
        ),
        (
            in_pockets and (any(free[3:]) or any(drive.tilt)),
            f"{guidance} is not built for a ring that tilts; use rings.inner.free: displacement",
        ),
        (in_pockets and cage.mass == 0.0, f"{guidance} moves the cage's mass; give cage.mass above 0 kg"),
        (
            in_pockets and on_land and ((cage.land_radius >= radius) if inside else (cage.land_radius <= radius)),
            f"cage.land_radius = {cage.land_radius:g} m: the land of the {cage.guidance} ring lies "
            f"{'inside' if inside else 'outside'} the pitch circle, whose radius is {radius:.4g} m",
        ),
    )
    return problems + [sentence for wrong, sentence in rows if wrong]


def separates_balls(cage, geometry, reach: float) -> bool:
    """True if a cage keeps more than `reach` [m] between the surfaces of neighbours, as long as its pockets hold."""
    if cage.kind == POCKETS:
        return pocket_pitch(geometry) - geometry.ball_diameter - cage.pocket_clearance > reach
    return cage.kind == EVEN


def pocket_pitch(geometry) -> float:
    """From the middle of a pocket to that of the next along the pitch circle [m]."""
    return math.pi / geometry.balls * geometry.pitch_diameter
