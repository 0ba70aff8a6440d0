"""Topics of bodies that collide, and their views in the browser.

The frame of two spheres or discs has x along the line of impact, forward, and its origin where the centre of the first
body starts; the axes of discs lie along z. That of an ellipsoid on a plane lies in the plane, z up.

The view of an impact of spheres or discs has x along the line of impact and the first contact in the origin, and draws
displacements enlarged. That of bodies that bounce is true to scale.
"""

import functools
import math

import numpy as np

from bearing_twin.base.sample import Channel, Sample
from bearing_twin.kinds import topics as markers
from bearing_twin.kinds.bodies.derived import ROWS, patch_of, reach_of, surface_of
from bearing_twin.kinds.bodies.parameters import BODY, FIRST, PLANE, EllipsoidOnPlaneScene, Shaped
from bearing_twin.kinds.contract import MARKERS, PUBLISH, Output, Topic
from bearing_twin.kinds.topics import (
    CUBE,
    CYLINDER,
    LINE_LIST,
    MARKER_ARRAY,
    SPHERE,
    ContactPair,
    load_marker,
    marker,
    own_axes,
    pair_topics,
    placed,
    pose_topic,
    times,
)
from bearing_twin.kinds.views import (
    BLUE,
    GLASS,
    ORANGE,
    STEEL,
    Arrows,
    ContactEllipses,
    Enlarged,
    Look,
    Solid,
    Trail,
    View,
    along_axes,
    curves,
    energies,
    grooved_ring,
    view_of,
)
from bearing_twin.shapes import TORUS, Surface, support

ROUND, RINGS = 48, 7  # sides of a ring; rings each way
X, DOWN, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0])
COLOURS = markers.ORANGE, markers.BLUE  # of two spheres or discs
OF_PAIR = (
    *("position", "second_position", "contact_point", "normal", "approach", "normal_load", "semi_major", "semi_minor"),
    *("peak_pressure", "major_axis", "friction_force", "slip", "drilling_torque", "spin_rate"),
)
POSES = {(BODY, PLANE): {"pose": ""}, (FIRST, "second"): {"first/pose": "", "second/pose": "second_"}}


def impact_topics(link: str, parameters) -> tuple[Topic, ...]:
    """The topics of two spheres or two discs."""
    return (
        *pair_topics(link, pair_of, _texts(parameters, "its centre"), solids),
        Topic("markers", MARKER_ARRAY, PUBLISH, marker_fields, "both bodies and the force between them", link),
    )


def bouncing_topics(link: str, parameters) -> tuple[Topic, ...]:
    """The topics of an ellipsoid on a plane, and of two bodies."""
    about = "its centre" if PLANE not in parameters.names else f"the origin of {link}"
    poses = POSES[parameters.names].items()
    return (
        *pair_topics(link, pair_of, _texts(parameters, about), solids),
        *(pose_topic(name, link, "centre and orientation of the body", prefix) for name, prefix in poses),
        Topic("markers", MARKER_ARRAY, MARKERS, marker_fields, "bodies, their axes, contact ellipse, load", link),
    )


def _texts(parameters, about: str) -> dict[str, str]:
    one, other = parameters.names
    return {one: f"by the {other}, about its centre; gravity is not in it", other: f"by the {one}, about {about}"}


sphere_topics = functools.partial(impact_topics, "two_spheres_link")
disc_topics = functools.partial(impact_topics, "two_discs_link")
ellipsoid_topics = functools.partial(bouncing_topics, "ellipsoid_on_plane_link")
body_topics = functools.partial(bouncing_topics, "two_bodies_link")


def pair_of(parameters, sample: Sample) -> ContactPair:
    """The contact of the bodies."""
    if "displacement" not in sample.values:
        known = {name: sample.values[name] for name in OF_PAIR if name in sample.values}
        if PLANE in parameters.names:
            turned = {"drilling_torque": -sample["drilling_torque"], "spin_rate": -sample["angular_velocity"][..., 2]}
            known |= {"second_position": np.zeros(3), "normal": DOWN, **turned}
        return ContactPair(**known)
    (first, second), (one, other), load = (
        np.moveaxis(sample["displacement"], -1, 0),
        parameters.bodies,
        sample["normal_load"],
    )
    second = one.radius + other.radius + parameters.motion.gap + second
    places = first, second, 0.5 * (first + one.radius + second - other.radius)
    patch = patch_of(parameters, load)
    return ContactPair(*(times(place, X) for place in places), X, sample["approach"], load, *patch, major_axis=Z)


def solids(parameters) -> dict[str, list[dict]]:
    """The bodies as markers in their frames; a plane that may be tilted is none of them."""
    found = dict(zip(parameters.names, shapes_of(parameters), strict=True))
    return {name: [one] for name, one in found.items() if one["type"] != CUBE or name == PLANE}


def shapes_of(parameters) -> list[dict]:
    """Markers of the bodies in their frames: solids where markers have one, else lines on the surface."""
    longest, found = _longest(parameters), []
    for name, one, colour in zip(parameters.names, parameters.bodies, COLOURS, strict=True):
        kind, size, points, middle = SPHERE, tuple(2.0 * axis for axis in 3 * ROWS[one.shape].sizes(one))[:3], (), 0.0
        colour = markers.STEEL if parameters.names in POSES else colour
        if one.shape == "disc":
            kind, size = CYLINDER, (*size[:2], one.thickness)
        elif one.shape == "plane":
            kind, size, colour = CUBE, (8.0 * longest, 8.0 * longest, 0.02 * longest), markers.GLASS
            middle = -0.5 * size[2]
        elif one.shape not in ("sphere", "ellipsoid"):
            kind, size, points = LINE_LIST, (0.01 * longest, 0.0, 0.0), lines_of(one)
        found.append(marker(name, 0, kind, size, colour, (0.0, 0.0, middle), points=points))
    return found


def _longest(parameters) -> float:
    """Greatest size [m] of the smaller body."""
    return min(max(ROWS[one.shape].sizes(one)) for one in parameters.bodies if one.shape != "plane")


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the bodies and the load; of bodies that turn also pins along their axes.

    A plane is drawn under the contact. Contact ellipses are those of bodies that bounce.
    """
    sample, parameters, pair = output.sample, output.parameters, output.once(pair_of)
    longest, turning, found = _longest(parameters), "orientation" in sample.values, []
    outwards = (pair.normal, pair.position, ""), (-pair.normal, pair.second_position, "second_")
    for (outward, centre, prefix), one, shape in zip(outwards, parameters.bodies, shapes_of(parameters), strict=True):
        turn = sample.values.get(f"{prefix}orientation", markers.UNTURNED)
        if one.shape == "plane":
            deep = ((pair.contact_point - centre) * outward).sum(axis=-1) + 0.01 * longest
            centre = pair.contact_point - times(deep, outward)
        found.append(placed(shape, centre, turn))
        if turning and one.shape not in ("plane", "groove"):
            sizes = (3 * ROWS[one.shape].sizes(one))[:3]
            reach = [1.05 * size * axis for size, axis in zip(sizes, own_axes(turn), strict=True)]
            ends = np.stack([centre + side * way for way in reach for side in (-1.0, 1.0)], axis=-2)
            thin = (0.04 * longest, 0.0, 0.0)
            found.append(marker(f"{shape['ns']}_pins", 0, LINE_LIST, thin, markers.BLUE, points=ends))
    if turning:
        return {"markers": found + pair.markers(longest, pair.contact_point - 0.5 * longest * X)}
    beside = pair.contact_point + np.array([0.0, 1.3 * reach_of(max(parameters.bodies, key=reach_of)), 0.0])
    return {"markers": [*found, load_marker(pair.normal_load, longest, beside)]}


@functools.lru_cache(maxsize=16)
def lines_of(one: Shaped) -> list[list[float]]:
    """Ends (n, 3) [m] of lines on the surface of a body: its parallels and meridians.

    Of a convex body sections through its centre, of a groove circles both ways.
    """
    surface, turn = surface_of(one), np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    parallels, meridians = (0.0,), np.linspace(0.0, math.pi, RINGS)[:-1]
    if surface.kind == TORUS:
        parallels, meridians = (np.linspace(0.0, 2.0 * math.pi, count + 1)[:-1] for count in (RINGS, 2 * RINGS))
    rings = [surface_points(surface, turn, across) for across in parallels]
    rings += [surface_points(surface, around, turn) for around in meridians]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1).reshape(-1, 3) for ring in rings]).tolist()


# Views

REACH, ABOVE = 0.3, 1.25  # radii of the smaller body: displacement, height of the arrows of an impact
ARROW, SPOT = 1.6, 0.35  # longest arrow, greatest drawn semi-axis of a contact; in sizes of the body
ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "in the contact"))
STORED = (ENERGIES[0], ("potential_energy", "of height"), ENERGIES[1])
LOST = (("dissipated_viscous", "lost to viscosity"), ("dissipated_friction", "lost to friction"))
"""Channels and words of the energies, in the order in which they are shown."""
AROUND, ACROSS = 64, 32  # directions of a mesh round its axis and from pole to pole
EDGE = math.radians(78.0)  # how far up a groove is drawn
BEHIND = 0.5  # radii of the tube: the ring behind a groove


def impact_view(parameters, channels) -> View:
    """Of two spheres or two discs."""
    bodies, gap = parameters.bodies, parameters.motion.gap
    first, second = (one.radius for one in bodies)
    least, high = min(first, second), ABOVE * max(first, second)
    apart = 0.04 * least
    drawn = (
        Channel("middles", "m", (2, 3), "centres at the first contact"),
        Channel("ways", "m", (2, 3), "from there"),
        Channel("forces", "N", (2, 3), "on each body by the other"),
        Channel("tails", "m", (2, 3), "where the arrows begin"),
    )
    fixed = {
        "middles": ((-first, 0.0, 0.0), (second, 0.0, 0.0)),
        "tails": ((-apart, high, 0.0), (apart, high, 0.0)),
    }

    def rows(sample):
        load, moved = sample["normal_load"], sample["displacement"] - (gap, 0.0)
        still = {name: np.tile(one, (len(load), 1, 1)) for name, one in fixed.items()}
        return still | {"ways": moved[..., None] * X, "forces": np.multiply.outer(load, (-X, X))}

    return view_of(
        channels,
        drawn,
        rows,
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            curves("Approach, negative while there is a gap", "m", ("approach", "approach")),
            curves("Velocities", "m/s", ("velocity", "first", 0), ("velocity", "second", 1)),
            energies(*ENERGIES),
        ),
        solids=tuple(
            Solid(
                name, f"{name} body", SHAPES[one.shape](one, place), (BLUE, ORANGE)[place],
                place=place, position="middles", deviation="ways", opacity=0.62,
            )
            for place, (name, one) in enumerate(zip(parameters.names, bodies, strict=True))
        ),
        marks=(
            Arrows(
                "forces", "force on each body", "N", "forces", 0.9 * least, (BLUE, ORANGE), point="tails",
                from_point=True,
            ),
        ),
        look=Look(
            first + second,
            (0.25, 0.28, 0.93),
            middle=(second - first, 0.1 * least, 0.0),
            at_start=((second, 0.0, 0.0), first + second),  # the origin is the first body's centre
        ),
        enlarged=Enlarged("displacements", ("ways",), REACH * least),
        words="Where the bodies overlap they are pressed flat: the overlap is the approach, as much enlarged.",
    )  # fmt: skip


def bouncing_view(parameters, channels) -> View:
    """Of an ellipsoid on a plane and of two bodies: up is against gravity; a groove is cut through its middle."""
    (first, second), fall = parameters.bodies, np.array(parameters.gravity)
    upward = -fall / np.linalg.norm(fall) if fall.any() else Z
    tilted = abs(upward[2]) < 0.9
    direction = np.array(Z if tilted else (0.35, -1.0, 0.0)) + (0.42 if tilted else 0.3) * upward
    known, same = {one.name for one in channels}, second.shape == first.shape
    groove, seen = second.shape == "groove", [one for one in (first, second) if math.isfinite(reach_of(one))]
    if isinstance(parameters, EllipsoidOnPlaneScene):
        start, longest = parameters.start, reach_of(first)
        amid, far = (0.0, 0.0, 0.5 * max(start.height, 0.0) + longest), 0.5 * max(start.height, 0.0) + 1.15 * longest
        travels = min(first.semi_axes) != longest or any(start.velocity[:2]) or any(start.angular_velocity)
    else:
        places, travels = np.array([one.position for one in seen]), second.shape == "plane"
        amid = tuple((0.5 * (places.min(axis=0) + places.max(axis=0))).tolist())
        far = max(math.dist(one.position, amid) + reach_of(one) for one in seen)
    look = Look(
        (1.5 if groove else 1.1) * max(map(reach_of, seen)),
        tuple(direction.tolist()),
        tuple(upward.tolist()),
        around=("second_position",) if groove else ("position",),
        at_start=(amid, far),
        follows=parameters.names[0] if travels else "",
    )
    size = reach_of(first) if first in seen else look.radius

    def solid(name: str, one, prefix: str, colour: str) -> Solid:
        ground = one.shape == "plane"
        poses = {word: f"{prefix}{word}" for word in ("position", "orientation") if f"{prefix}{word}" in known}
        look = {"marked": not ground, "opacity": 0.5 if ground else 1.0}
        return Solid(name, f"{name} body, {one.shape}", SHAPES[one.shape](one, 0), colour, **poses, **look)

    def rows(sample):
        push = -sample["normal"] if "normal" in sample.values else np.tile(Z, (len(sample["position"]), 1))
        return {"push": push}

    return view_of(
        channels,
        (Channel("push", "1", (3,), "direction of the normal load on the first body"),),
        rows,
        panels=(
            curves("Normal load", "N", ("normal_load", "normal load")),
            curves("Position of the centre", "m", *along_axes("position")),
            curves("Peak pressure", "Pa", ("peak_pressure", "peak pressure")),
            curves("Slip at the contact", "m/s", *along_axes("slip")),
            energies(*STORED, *LOST),
        ),
        solids=(
            solid(parameters.names[0], first, "", BLUE if same else STEEL),
            solid(parameters.names[1], second, "second_", STEEL if same else GLASS),
        ),
        marks=(
            Trail("way", "way of the centre", "position"),
            Arrows(
                "load", "normal load on the body", "N", "push", ARROW * size, (ORANGE,), "normal_load",
                point="contact_point",
            ),
            ContactEllipses(
                "contact", "contact", "push", "semi_major", "semi_minor", "peak_pressure", SPOT * size,
                major_axis="major_axis", point="contact_point",
            ),
        ),
        look=look,
        words="Bodies and places are true to scale.",
    )  # fmt: skip


def directions(around, across) -> np.ndarray:
    """Unit vectors (..., 3) at angles [rad] round z and up from the plane z = 0; arrays broadcast."""
    flat = np.cos(across)
    return np.stack(np.broadcast_arrays(flat * np.cos(around), flat * np.sin(around), np.sin(across)), axis=-1)


def surface_points(surface: Surface, around, across) -> np.ndarray:
    """Points (..., 3) [m] of a surface.

    Of a torus those at angles [rad] round its axis and its tube, of a convex body the farthest along `directions`.
    """
    ways = directions(around, across)
    if surface.kind != TORUS:
        return support(surface, ways)
    locus, tube = surface.sizes[:2]
    return locus * directions(around, np.zeros_like(across)) + tube * ways


def _mesh(one: Shaped) -> dict:
    """A convex body from its support: the farthest point along each of many directions, whose normal it is."""
    tilts, turns = np.linspace(0.5 * math.pi, -0.5 * math.pi, ACROSS + 1), np.linspace(0.0, 2.0 * math.pi, AROUND + 1)
    angles = turns, tilts[:, None]
    corner = (np.arange(ACROSS)[:, None] * (AROUND + 1) + np.arange(AROUND)).ravel()
    below = corner + AROUND + 1
    triangles = np.concatenate(
        [np.stack([corner, below, corner + 1], axis=1), np.stack([corner + 1, below, below + 1], axis=1)]
    )
    both = surface_points(surface_of(one), *angles), directions(*angles)
    points, normals = (some.reshape(-1, 3).tolist() for some in both)
    return {"mesh": {"vertices": points, "normals": normals, "triangles": triangles.tolist()}}


def _groove(one: Shaped) -> dict:
    """The half z < 0 of a ring with a groove of the tube's radius inside."""
    bottom = one.ring_radius + one.radius
    strokes = grooved_ring(bottom, one.radius, EDGE, bottom + BEHIND * one.radius, -1.25 * one.radius)
    return {"turned": {"strokes": strokes}}


SHAPES = {
    "plane": lambda one, place: {"ground": {}},
    "sphere": lambda one, place: {"ellipsoid": (one.radius,) * 3},
    "ellipsoid": lambda one, place: {"ellipsoid": one.semi_axes},
    "superellipsoid": lambda one, place: _mesh(one),
    "groove": lambda one, place: _groove(one),
    # faces in one plane would flicker: the second disc is drawn a little thinner
    "disc": lambda one, place: {"cylinder": {"radius": one.radius, "length": one.thickness * (1.0 - 0.002 * place)}},
}
"""How each shape of `derived.ROWS` is drawn, the first or the second body in its place."""
