"""What turns the inner ring of a bearing: a prescribed speed, or a torque on a shaft with inertia."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

from dataclasses import dataclass, replace

from bearing_twin.base.parameters import choice, number_table, quantity, section

SPEED, TORQUE = "speed", "torque"  # drive.kind
TORQUE_COLUMNS = (("time", "s"), ("torque", "N m"))


@dataclass(frozen=True)
class SpeedChange:
    """One change of the drive's speed while it runs, added to what it was."""

    time: float = quantity(0.0, "s", "when the drive changes; 0 = never", at_least=0.0)
    speed: float = quantity(0.0, "rad/s", "added to the wanted speed, which is approached at drive.acceleration")


@dataclass(frozen=True)
class Change(SpeedChange):
    """One change of the drive while it runs, added to what it was."""

    offset: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "m", "added to the inner ring's offset, at once")


@dataclass(frozen=True)
class Drive:
    """What turns the inner ring, and where it is held; the outer ring is at rest."""

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
    damping: float = quantity(
        0.0, "N m s", "viscous, about the axis: it brakes with this times the speed", at_least=0.0
    )
    greatest_speed: float = quantity(1.0e4, "rad/s", "by drive.kind: torque, faster than which a run ends", above=0.0)

    @property
    def changed_speed(self) -> float:
        """The speed [rad/s] once the change has come."""
        return self.speed + self.change.speed

    @property
    def changed_offset(self) -> tuple[float, float, float]:
        """Displacement of the ring's centre [m] once the change has come."""
        x, y, z = (here + more for here, more in zip(self.offset, self.change.offset, strict=True))
        return x, y, z


def shaft_inertia(parameters) -> float:
    """Moment of inertia [kg m^2] about the axis of all that a torque turns."""
    return parameters.rings.inner.inertia[1] + parameters.drive.inertia


def cage_inertia(parameters) -> float:
    """The cage's moment of inertia about its axis [kg m^2]."""
    cage = parameters.cage
    return cage.inertia or cage.mass * (0.5 * parameters.geometry.pitch_diameter) ** 2


def torque_problems(parameters, still: bool) -> list[str]:
    """What contradicts itself about a drive that gives a torque, one sentence each; `still`: in equilibria."""
    drive, problems = parameters.drive, []
    if drive.kind == SPEED:
        keys = "torque", "torque_table", "inertia", "damping"
        given = [f"drive.{key}" for key in keys if getattr(drive, key)]
        if given:
            problems.append(f"{' and '.join(given)} act where drive.kind is torque; set it, or leave them out")
        return problems
    if still:
        problems.append(
            "drive.kind = torque has the speed follow from friction, which equilibria leave out; use model.dimension: "
            "prescribed, or free with rings.inner.mass"
        )
    if shaft_inertia(parameters) == 0.0:
        problems.append(
            "drive.kind = torque wants an inertia about the axis; give drive.inertia, or rings.inner.inertia[1], above "
            "0 kg m^2"
        )
    if drive.change.time:
        problems.append(
            "drive.change changes a prescribed speed or offset, but drive.kind = torque: give drive.torque_table, or a "
            "load on a ring with mass"
        )
    if abs(drive.speed) >= drive.greatest_speed:
        problems.append(
            f"drive.speed = {drive.speed:g} rad/s must be below drive.greatest_speed = {drive.greatest_speed:g} rad/s"
        )
    return problems


def with_speeds(parameters) -> list:
    """The scene, and with the speed at its end where that is another: equilibria differ in what they leave out."""
    drive = parameters.drive
    if not drive.change.speed:
        return [parameters]
    return [parameters, replace(parameters, drive=replace(drive, speed=drive.changed_speed))]
