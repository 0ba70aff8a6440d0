"""The outputs of a bearing: channels, contact ellipses, and wrenches, contacts and frames as others take them.

A sample may hold many outputs: one row each in front of all its arrays, and of those given.
"""

import functools

import numpy as np

from bearing_twin.base.sample import Block, Channel, Columns, Layout, Sample, Wrench, layout_of
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.core import INTEGER, INTEGERS, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.geometry import moduli
from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.system import numbers_of, numbers_of_bodies
from bearing_twin.kinds.topics import NUMBERS

IN_PLANE = ("in_plane",)  # axes: x and y
SAME_ANGLE = 1e-3  # greatest difference of sines of equal angles
BALL_CHANNELS, FILM_CHANNELS = 19, 2  # channels with a ball's own numbers, and those of films that follow them


def channels(parameters: BearingScene) -> tuple[Channel, ...]:
    """The channels of a bearing with N balls; vectors in `bearing_link`, contact rows ball x (inner, outer)."""
    return _channels(parameters.geometry.balls, is_lubricated(parameters))


# Tables by the number of balls: by a scene, all of it would be hashed for every chunk.
@functools.cache
def _channels(n: int, films: bool = False) -> tuple[Channel, ...]:
    film = (
        Channel("film_thickness", "m", (n, 2), "of the lubricant, at the centre of the contact; 0 without load"),
        Channel("film_ratio", "1", (n, 2), "Lambda, the same over the roughness of both surfaces"),
    )
    return (
        Channel("orbit_angle", "rad", (n,), "position of each ball around the axis, not wrapped"),
        Channel("position", "m", (n, 3), "ball centres"),
        Channel("velocity", "m/s", (n, 3), "of the ball centres"),
        Channel("orientation", "1", (n, 4), "quaternion x, y, z, w of the ball's axes"),
        Channel("angular_velocity", "rad/s", (n, 3), "of the balls"),
        Channel("roll_rate", "rad/s", (n,), "ball about its centre, relative to its orbit, about -z"),
        Channel("raceway_force", "N", (n, 3), "on the ball by both raceways"),
        Channel("raceway_torque", "N m", (n, 3), "on the ball by both raceways, about its centre"),
        Channel("approach", "m", (n, 2), "mutual approach, > 0 in contact"),
        Channel("normal_load", "N", (n, 2), "elastic and viscous part together, >= 0"),
        Channel("contact_angle", "rad", (n, 2), "against the radial plane, > 0 if the inner ring is pushed along +z"),
        Channel("spin_rate", "rad/s", (n, 2), "ball minus ring, about the line from the ball's centre to the contact"),
        Channel("curvature_small", "1/m", (n, 2), "of the gap, P in z = P x^2 + Q y^2"),
        Channel("curvature_large", "1/m", (n, 2), "of the gap, Q in z = P x^2 + Q y^2"),
        Channel("point", "m", (n, 2, 3), "contact point"),
        Channel("normal", "1", (n, 2, 3), "direction of the normal load on the ball"),
        Channel("friction_force", "N", (n, 2, 3), "on the ball"),
        Channel("slip", "m/s", (n, 2, 3), "ball's surface relative to the raceway"),
        Channel("drilling_torque", "N m", (n, 2), "friction on the ball about the line from its centre to the contact"),
        *(film if films else ()),
        Channel("inner_ring_angle", "rad", (), "not wrapped"),
        Channel("inner_ring_speed", "rad/s", (), "about +z"),
        Channel("inner_ring_offset", "m", (3,), "displacement of the inner ring's centre"),
        Channel("inner_ring_tilt", "rad", (2,), "of the inner ring about x and y", ("about",)),
        Channel("inner_ring_velocity", "m/s", (3,), "of the inner ring's centre"),
        Channel("inner_ring_tilt_rate", "rad/s", (2,), "of the inner ring about x and y, without its spin", ("about",)),
        Channel("inner_ring_load", "N", (3,), "on a ring with mass from outside, without its weight; 0 where held"),
        Channel("inner_ring_load_work", "J", (), "of that load since the start; 0 where held"),
        Channel(
            "drive_torque", "N m", (), "on the inner ring about +z: what keeps a prescribed speed, without its inertia"
        ),
        Channel("cage_angle", "rad", (), "of the cage, which is 0 where ball 0 is in the middle; 0 without a cage"),
        Channel("cage_speed", "rad/s", (), "of the cage about +z; 0 without one"),
        Channel("cage_slip", "1", (), "1 - cage speed / that of balls that roll at contact angle 0; 0 without a cage"),
        Channel("pocket_force", "N", (n,), "of the cage on each ball along its orbit"),
        Channel("cage_offset", "m", (2,), "of the cage's centre off the axis; 0 where it stays centred", IN_PLANE),
        Channel("cage_velocity", "m/s", (2,), "of the cage's centre; 0 where it stays centred", IN_PLANE),
        Channel("land_force", "N", (2,), "on the cage by the land that guides it; 0 without one", IN_PLANE),
        Channel("inner_ring_force", "N", (3,), "on the inner ring by the balls, and by a cage on its land"),
        Channel("inner_ring_torque", "N m", (3,), "on the inner ring by the balls, about its centre and its own axis"),
        Channel("outer_ring_force", "N", (3,), "on the outer ring by the balls"),
        Channel("outer_ring_torque", "N m", (3,), "on the outer ring by the balls, about its centre"),
        Channel("kinetic_energy", "J", (), "of balls, cage and a ring with mass; of its spin where a torque turns it"),
        Channel("elastic_energy", "J", (), "of all contacts, and the springs of the ring's support"),
        Channel("potential_energy", "J", (), "of gravity on balls and a ring with mass, zero at the bearing's centre"),
        Channel("drive_work", "J", (), "of the drive and of the loads on a ring with mass since the start"),
        Channel("dissipated", "J", (), "by friction and damping since the start"),
        Channel("gross_work", "J", (), "as drive_work, the power at each contact counted by its magnitude"),
        Channel("neighbour_approach", "m", (n,), "of each ball and the next ahead, > 0 in contact; 0 where none is"),
        Channel("neighbour_load", "N", (n,), "normal load between each ball and the next ahead, >= 0"),
        Channel("neighbour_point", "m", (n, 3), "contact point of each ball with the next ahead; zeros when apart"),
        Channel("neighbour_normal", "1", (n, 3), "direction of that load on the ball; zeros when apart"),
        Channel("neighbour_friction", "N", (n, 3), "friction on the ball by the next ahead"),
    )


class Rows(Columns):
    """Outputs side by side in one matrix (count, total width); each channel is also an attribute, computed when used.

    Raises AttributeError for what is no channel.
    """

    __slots__ = ()

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


def place_of(channel: Channel, index: tuple[int, ...]) -> tuple[str, str]:
    """The body and the contact that a number of a channel belongs to, such as "ball 3" and "outer race"."""
    if channel.name.startswith(("inner_ring", "outer_ring")):
        return channel.name[:10].replace("_", " "), ""
    if channel.axes == IN_PLANE:
        return "cage", ""
    if not channel.shape:
        return "", ""
    return f"ball {index[0]}", ("inner race", "outer race")[index[1]] if channel.shape[1:2] == (2,) else ""


@functools.cache
def _columns(n: int, films: bool) -> np.ndarray:
    """Columns of a row of all channels of a bearing with n balls, as RowLayout of the core."""
    rows, layout = _channels(n, films), _layout(n, films)
    edges = {name: columns.start for name, (columns, _) in layout.fields.items()}
    ball_rows = [(edges[channel.name], channel.width // n) for channel in rows[: BALL_CHANNELS + films * FILM_CHANNELS]]
    first, width = zip(*ball_rows, *((0, 0),) * (BALL_CHANNELS + FILM_CHANNELS - len(ball_rows)), strict=True)
    names = "inner_ring_angle", "inner_ring_force", "neighbour_approach", "position", "raceway_force"
    return np.array([*first, *width, *(edges[name] for name in names), layout.width])


@functools.cache
def _columns_of_sums(n: int) -> tuple[np.ndarray, int]:
    """As `_columns`, in rows without contacts; and the first number of the force on the outer ring."""
    first = {name: columns.start for name, (columns, _) in _layout(n, False).fields.items()}
    names = "inner_ring_angle", "inner_ring_force", "outer_ring_force", "neighbour_approach"
    ring, sums, force, end = (first[name] - first["inner_ring_angle"] for name in names)
    return np.array([*(0,) * 2 * (BALL_CHANNELS + FILM_CHANNELS), ring, sums, -1, 0, 0, end]), force


@functools.cache
def _layout(n: int, films: bool) -> Layout:
    """`layout_of` a bearing with n balls, computed once."""
    return layout_of(_channels(n, films))


def empty_outputs(parameters: BearingScene, count: int) -> Rows:
    """Uninitialised rows of all channels for `count` outputs."""
    layout = _layout(parameters.geometry.balls, is_lubricated(parameters))
    return Rows(layout, np.empty((count, layout.width)))


NO_BODIES = np.zeros(0)
_outputs = Function(
    "core_outputs",
    None,
    (*(REALS,) * 3, INTEGER, INTEGER, *(REALS,) * 3, INTEGER, *(REALS,) * 4, REAL, INTEGERS, REALS_OUT),
)


def write_outputs(parameters, bearing, bodies, drive, times, states, orientations, body_states, rows) -> None:
    """Fill `rows` of all channels with states (count, N, COLUMNS) and orientations (count, N, 4) of the balls.

    They are those at `times` [s], which count from the instant the drive's angle and speed belong to; `body_states`
    (count, BODY_COLUMNS) are those of ring, cage and shaft, the `bodies`. Every column of a row is written.
    """
    columns = _columns(parameters.geometry.balls, is_lubricated(parameters))
    _write(parameters, bearing, bodies, drive, times, (states, orientations, body_states), columns, rows)


def outer_ring_forces(parameters, bearing, bodies, drive, times, states, orientations, body_states) -> np.ndarray:
    """Forces (count, 3) [N] of the balls on the outer ring, a channel of `write_outputs`, without the others."""
    columns, first = _columns_of_sums(parameters.geometry.balls)
    rows = np.empty((len(times), columns[-1]))
    _write(parameters, bearing, bodies, drive, times, (states, orientations, body_states), columns, rows)
    return rows[:, first : first + 3]


def _write(parameters, bearing, bodies, drive, times, motion, columns, rows):
    geometry = parameters.geometry
    states, orientations, body_states = motion
    rolling = 0.5 * (1.0 - geometry.ball_diameter / geometry.pitch_diameter)
    coupled = bool(bodies.active or bearing.ring)
    numbers = numbers_of_bodies(bearing, bodies) if coupled else NO_BODIES
    _outputs(
        *(*numbers_of(bearing), np.array(drive, float), len(times), geometry.balls, times, states, orientations),
        *(coupled, numbers, bodies.load, bodies.load_rate, body_states, rolling, columns, rows),
    )


def contact_details(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """`in_contact` (N, 2), `semi_major`, `semi_minor` [m], `peak_pressure` [Pa] (N, 2) and `major_axis` (N, 2, 3).

    By Hertz from curvatures and normal load for all elastic laws. The major axis lies in the meridian plane, across
    the groove. A sample of many outputs gives arrays with as many rows.
    """
    load = sample["normal_load"]
    flat = load.reshape(-1, 2)
    small, large = (sample[name].reshape(-1, 2) for name in ("curvature_small", "curvature_large"))
    ellipses = np.array(ellipse(small, large, np.array(moduli(parameters.materials)), flat))
    semi_major, semi_minor, pressure = ellipses.reshape(3, *load.shape)
    normal = sample["normal"]
    axis = np.array([0.0, 0.0, 1.0]) - normal[..., 2:] * normal
    square = axis * axis
    return {
        "in_contact": sample["approach"] > 0.0,
        "semi_major": semi_major,
        "semi_minor": semi_minor,
        "peak_pressure": pressure,
        "major_axis": axis / np.sqrt(square[..., 0:1] + square[..., 1:2] + square[..., 2:3]),
    }


def update_contact_angles(block: Block) -> None:
    """Invert inner contact angles of old logs, which were positive towards +z as seen from the ball."""
    angle, normal = (block.values.get(name) for name in ("contact_angle", "normal"))
    if angle is None or normal is None or angle.shape != normal.shape[:-1] or angle.shape[-1:] != (2,):
        return
    inner, rises = angle[..., 0], normal[..., 0, 2]  # the load on a ball by the inner raceway points away from the axis
    np.negative(inner, out=inner, where=np.abs(np.sin(inner) + rises) < SAME_ANGLE * np.abs(rises))


RINGS = ("inner_ring", "outer_ring")


def bodies(parameters: BearingScene) -> list[str]:
    """Names of the bodies: the balls, then the rings."""
    return [*(f"ball_{k}" for k in range(parameters.geometry.balls)), *RINGS]


def origins(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """Origins of the bodies' frames [m]: centres of balls and rings, in `bearing_link`."""
    offset = sample["inner_ring_offset"]
    centres = [*np.moveaxis(sample["position"], -2, 0), offset, np.zeros(offset.shape)]
    return dict(zip(bodies(parameters), centres, strict=True))


def ring_attitude(tilt: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4) x, y, z, w of a ring turned by `angle` (...) [rad] about z, then tilted.

    `tilt` (..., 2) [rad] is a rotation vector about x and y.
    """
    half = 0.5 * np.asarray(tilt)
    size = np.sqrt(half[..., 0] ** 2 + half[..., 1] ** 2)
    x, y = np.moveaxis(half, -1, 0) * np.sinc(size / np.pi)
    w, cosine, sine = np.cos(size), np.cos(0.5 * np.asarray(angle)), np.sin(0.5 * np.asarray(angle))
    return np.stack([x * cosine + y * sine, y * cosine - x * sine, w * sine, w * cosine], axis=-1)


def wrenches(parameters: BearingScene, sample: Sample) -> list[Wrench]:
    """The wrench of all contacts on each ball about its centre, then those on the rings about theirs.

    The channel `inner_ring_torque` is what acts on the coordinates of the ring, which follow tilts to first order; the
    moment on a ring that is tilted is the reaction of what it does to balls and outer ring.
    """
    force, torque = sample["raceway_force"], sample["raceway_torque"]
    touching = sample["neighbour_load"].any(axis=-1)[..., None, None]
    if touching.any():
        position, point = sample["position"], sample["neighbour_point"]
        push = sample["neighbour_load"][..., None] * sample["neighbour_normal"] + sample["neighbour_friction"]
        ahead = np.cross(point - position, push)
        behind = np.cross(point - np.roll(position, -1, axis=-2), -push)  # on the next ball
        force = np.where(touching, force + push - np.roll(push, 1, axis=-2), force)
        torque = np.where(touching, torque + ahead + np.roll(behind, 1, axis=-2), torque)
    rows = [
        Wrench(f"ball_{k}", "raceways and balls", "ball centre", f"ball_{k}", force[..., k, :], torque[..., k, :])
        for k in range(parameters.geometry.balls)
    ]
    on_rings = {ring: (sample[f"{ring}_force"], sample[f"{ring}_torque"]) for ring in RINGS}
    if sample["inner_ring_tilt"].any():
        centre, (on_outer, moment) = sample["inner_ring_offset"], on_rings["outer_ring"]
        about_centre = torque + np.cross(sample["position"] - centre[..., None, :], force)
        reaction = -about_centre.sum(axis=-2) - moment + np.cross(centre, on_outer)
        on_rings["inner_ring"] = sample["inner_ring_force"], reaction
    return rows + [Wrench(ring, "balls", "ring centre", ring, *wrench) for ring, wrench in on_rings.items()]


def contacts(parameters: BearingScene, sample: Sample) -> dict:
    """The fields of Contacts: ball k with raceway r is row 2 k + r, then ball k with the next ball ahead."""
    balls = parameters.geometry.balls
    raceway = {
        **{name: sample[name] for name in ("approach", "normal_load", "contact_angle")},
        **{name: sample[name] for name in ("point", "normal", "friction_force", "slip")},
        **contact_details(parameters, sample),
        # The channels count both about the line from the ball to the raceway, against `normal`.
        "spin_rate": -sample["spin_rate"],
        "drilling_torque": -sample["drilling_torque"],
    }
    body, partner = [k // 2 for k in range(2 * balls)], [balls, balls + 1] * balls
    outer = sample["approach"].shape[:-2]
    rows = {name: array.reshape(*outer, 2 * balls, *array.shape[len(outer) + 2 :]) for name, array in raceway.items()}
    if balls > 1:
        for name, values in _neighbours(parameters, sample).items():
            rows[name] = np.concatenate([rows[name], values], axis=len(outer))
        body, partner = [*body, *range(balls)], [*partner, *((k + 1) % balls for k in range(balls))]
    return {"balls": balls, "bodies": bodies(parameters), "body": body, "by": partner, **rows}


def _neighbours(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """One row for each ball and the next ahead, of spheres that roll on each other."""
    load, normal, point = (sample[f"neighbour_{name}"] for name in ("load", "normal", "point"))
    touching = sample["neighbour_approach"] > 0.0
    rows = {
        "in_contact": touching,
        "approach": sample["neighbour_approach"],
        "normal_load": load,
        "point": point,
        "normal": normal,
        "friction_force": sample["neighbour_friction"],
        **{name: np.zeros(load.shape) for name in NUMBERS if name not in ("approach", "normal_load")},
        **{name: np.zeros(point.shape) for name in ("major_axis", "slip")},
    }
    curvature = 2.0 / parameters.geometry.ball_diameter  # of the gap between two balls, the same all round
    modulus = effective_modulus(parameters.materials.ball, parameters.materials.ball)
    position, velocity, spin = (sample[name] for name in ("position", "velocity", "angular_velocity"))
    for ball in zip(*np.nonzero(touching), strict=True):
        ahead = (*ball[:-1], (ball[-1] + 1) % load.shape[-1])
        n = normal[ball]
        surface = velocity[ball] + np.cross(spin[ball], point[ball] - position[ball])
        relative = surface - velocity[ahead] - np.cross(spin[ahead], point[ball] - position[ahead])
        axis = np.array([0.0, 0.0, 1.0]) - n[2] * n
        rows["slip"][ball] = relative - relative @ n * n
        rows["spin_rate"][ball] = (spin[ball] - spin[ahead]) @ n
        rows["major_axis"][ball] = axis / np.linalg.norm(axis)
        rows["contact_angle"][ball] = np.arctan2(-n[2], np.hypot(*n[:2]))
        patch = ellipse(curvature, curvature, modulus, load[ball])
        rows["semi_major"][ball], rows["semi_minor"][ball], rows["peak_pressure"][ball] = patch
    return rows
