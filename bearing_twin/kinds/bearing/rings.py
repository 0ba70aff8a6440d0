"""What acts on the inner ring, where it may go, and how much of the bearing moves by itself."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass

from bearing_twin.parameters import choice, quantity, section

COORDINATES = ("x", "y", "z", "theta_x", "theta_y")
FREE = {  # rings.inner.free: which of the coordinates follow the loads
    "none": (False, False, False, False, False),
    "radial": (True, True, False, False, False),
    "axial": (False, False, True, False, False),
    "displacement": (True, True, True, False, False),
    "all": (True, True, True, True, True),
}
QUASI_STATIC, PRESCRIBED = "quasi_static", "prescribed"


@dataclass(frozen=True)
class InnerRing:
    """What acts on the inner ring, and where it may go; a coordinate that is not free is held by the drive."""

    load: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "N", "force on the inner ring at its centre")
    moment: tuple[float, float] = quantity((0.0, 0.0), "N m", "on the inner ring about x and y")
    free: str = choice(
        "auto", ("auto", *FREE), "coordinates that follow the loads; auto = displacement with a load, all with a moment"
    )


@dataclass(frozen=True)
class Rings:
    """The rings; the outer one is at rest."""

    inner: InnerRing = section(InnerRing)


@dataclass(frozen=True)
class Model:
    """How much of the bearing moves by itself."""

    dimension: str = choice(
        "auto",
        ("auto", QUASI_STATIC, PRESCRIBED),
        "quasi_static = every output is an equilibrium at the balls' places; prescribed = balls move, the ring is held",
        {"free": "is not built: a ring with mass does not move yet; quasi_static takes loads on the inner ring"},
    )


def free_coordinates(parameters) -> tuple[bool, ...]:
    """Which of x, y, z, theta_x, theta_y of the inner ring follow their loads."""
    ring = parameters.rings.inner
    if ring.free != "auto":
        return FREE[ring.free]
    if any(ring.moment):
        return FREE["all"]
    return FREE["displacement" if any(ring.load) else "none"]


def dimension_of(parameters) -> str:
    """The dimension a scene asks for; `auto` is quasi_static where the ring is loaded, free or tilted."""
    asked = parameters.model.dimension
    if asked != "auto":
        return asked
    return QUASI_STATIC if any(free_coordinates(parameters)) or any(parameters.drive.tilt) else PRESCRIBED


def idle_loads(parameters, load, moment, *names: str) -> list[str]:
    """That parts of a load [N] (3,) or moment [N m] (2,) of these names act on held coordinates, if they do."""
    free = free_coordinates(parameters)
    idle = [
        f"{name}[{i}] = {value:g} {unit}"
        for name, unit, values, freedom in zip(names, ("N", "N m"), (load, moment), (free[:3], free[3:]), strict=True)
        for i, (value, one) in enumerate(zip(values, freedom, strict=True))
        if value != 0.0 and not one
    ]
    if not idle:
        return []
    return [
        f"{' and '.join(idle)} acts on a coordinate that rings.inner.free = {parameters.rings.inner.free} holds; leave "
        "the load out or free the coordinate"
    ]


def ring_problems(parameters) -> list[str]:
    """What contradicts itself about loads, freedom and dimension, one sentence each."""
    ring, free, problems = parameters.rings.inner, free_coordinates(parameters), []
    problems += idle_loads(parameters, ring.load, ring.moment, "rings.inner.load", "rings.inner.moment")
    if dimension_of(parameters) == PRESCRIBED and any(free):
        problems.append(
            "model.dimension = prescribed holds the inner ring, so that loads do not move it; use "
            "model.dimension: quasi_static, or rings.inner.free: none without loads"
        )
    if dimension_of(parameters) == PRESCRIBED and any(parameters.drive.tilt):
        problems.append("drive.tilt is taken by model.dimension: quasi_static alone; use it, or leave the tilt out")
    return problems
