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
    first, second = parameters.names
    return {first: f"by the {second}, about its centre; gravity is not in it", second: f"by the {first}, about {about}"}


sphere_topics = functools.partial(impact_topics, "two_spheres_link")
disc_topics = functools.partial(impact_topics, "two_discs_link")
ellipsoid_topics = functools.partial(bouncing_topics, "ellipsoid_on_plane_link")
body_topics = functools.partial(bouncing_topics, "two_bodies_link")


def pair_of(parameters, sample: Sample) -> ContactPair:
    """The contact of the bodies."""
    if "displacement" not in sample.values:
        channels = {name: sample.values[name] for name in OF_PAIR if name in sample.values}
        if PLANE in parameters.names:
            turned = {"drilling_torque": -sample["drilling_torque"], "spin_rate": -sample["angular_velocity"][..., 2]}
            channels |= {"second_position": np.zeros(3), "normal": DOWN, **turned}
        return ContactPair(**channels)
    (first, second), (first_body, second_body), load = (
        np.moveaxis(sample["displacement"], -1, 0),
        parameters.bodies,
        sample["normal_load"],
    )
    second = first_body.radius + second_body.radius + parameters.motion.gap + second
    positions = first, second, 0.5 * (first + first_body.radius + second - second_body.radius)
    patch = patch_of(parameters, load)
    points = (times(position, X) for position in positions)
    return ContactPair(*points, X, sample["approach"], load, *patch, major_axis=Z)


def solids(parameters) -> dict[str, list[dict]]:
    """The bodies as markers in their frames, without a plane that may be tilted."""
    markers_by_name = dict(zip(parameters.names, shapes_of(parameters), strict=True))
    return {name: [shape] for name, shape in markers_by_name.items() if shape["type"] != CUBE or name == PLANE}


def shapes_of(parameters) -> list[dict]:
    """Markers of the bodies in their frames: solids where markers have one, else lines on the surface."""
    longest, shapes = _longest(parameters), []
    for name, body, colour in zip(parameters.names, parameters.bodies, COLOURS, strict=True):
        kind, size, points, middle = SPHERE, tuple(2.0 * axis for axis in 3 * ROWS[body.shape].sizes(body))[:3], (), 0.0
        colour = markers.STEEL if parameters.names in POSES else colour
        if body.shape == "disc":
            kind, size = CYLINDER, (*size[:2], body.thickness)
        elif body.shape == "plane":
            kind, size, colour = CUBE, (8.0 * longest, 8.0 * longest, 0.02 * longest), markers.GLASS
            middle = -0.5 * size[2]
        elif body.shape not in ("sphere", "ellipsoid"):
            kind, size, points = LINE_LIST, (0.01 * longest, 0.0, 0.0), lines_of(body)
        shapes.append(marker(name, 0, kind, size, colour, (0.0, 0.0, middle), points=points))
    return shapes


def _longest(parameters) -> float:
    """Greatest size [m] of the smaller body."""
    return min(max(ROWS[body.shape].sizes(body)) for body in parameters.bodies if body.shape != "plane")


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the bodies and the load; of bodies that turn also pins along their axes.

    A plane is drawn under the contact. Contact ellipses are those of bodies that bounce.
    """
    sample, parameters, pair = output.sample, output.parameters, output.once(pair_of)
    longest, turning, shapes = _longest(parameters), "orientation" in sample.values, []
    outwards = (pair.normal, pair.position, ""), (-pair.normal, pair.second_position, "second_")
    for (outward, centre, prefix), body, shape in zip(outwards, parameters.bodies, shapes_of(parameters), strict=True):
        orientation = sample.values.get(f"{prefix}orientation", markers.UNTURNED)
        if body.shape == "plane":
            depth = ((pair.contact_point - centre) * outward).sum(axis=-1) + 0.01 * longest
            centre = pair.contact_point - times(depth, outward)
        shapes.append(placed(shape, centre, orientation))
        if turning and body.shape not in ("plane", "groove"):
            sizes = (3 * ROWS[body.shape].sizes(body))[:3]
            arms = [1.05 * size * axis for size, axis in zip(sizes, own_axes(orientation), strict=True)]
            ends = np.stack([centre + side * arm for arm in arms for side in (-1.0, 1.0)], axis=-2)
            thin = (0.04 * longest, 0.0, 0.0)
            shapes.append(marker(f"{shape['ns']}_pins", 0, LINE_LIST, thin, markers.BLUE, points=ends))
    if turning:
        return {"markers": shapes + pair.markers(longest, pair.contact_point - 0.5 * longest * X)}
    arrow_foot = pair.contact_point + np.array([0.0, 1.3 * reach_of(max(parameters.bodies, key=reach_of)), 0.0])
    return {"markers": [*shapes, load_marker(pair.normal_load, longest, arrow_foot)]}


@functools.lru_cache(maxsize=16)
def lines_of(body: Shaped) -> list[list[float]]:
    """Ends (n, 3) [m] of lines on the surface of a body: its parallels and meridians.

    Of a convex body sections through its centre, of a groove circles both ways.
    """
    surface, angles = surface_of(body), np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    parallels, meridians = (0.0,), np.linspace(0.0, math.pi, RINGS)[:-1]
    if surface.kind == TORUS:
        parallels, meridians = (np.linspace(0.0, 2.0 * math.pi, count + 1)[:-1] for count in (RINGS, 2 * RINGS))
    rings = [surface_points(surface, angles, tilt) for tilt in parallels]
    rings += [surface_points(surface, angle, angles) for angle in meridians]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1).reshape(-1, 3) for ring in rings]).tolist()


# Views

DISPLACEMENT, ABOVE = 0.3, 1.25  # radii of the smaller body: displacement, height of the arrows of an impact
ARROW, PATCH = 1.6, 0.35  # longest arrow, greatest drawn semi-axis of a contact; in sizes of the body
ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "in the contact"))
STORED = (ENERGIES[0], ("potential_energy", "of height"), ENERGIES[1])
LOST = (("dissipated_viscous", "lost to viscosity"), ("dissipated_friction", "lost to friction"))
"""Channels and words of the energies, in the order in which they are shown."""
MERIDIANS, PARALLELS = 64, 32  # directions of a mesh about its axis and from pole to pole
EDGE = math.radians(78.0)  # greatest angle at which a groove is drawn
BEHIND = 0.5  # radii of the tube: thickness of the ring behind a groove


def impact_view(parameters, channels) -> View:
    """Of two spheres or two discs."""
    bodies, gap = parameters.bodies, parameters.motion.gap
    first, second = (body.radius for body in bodies)
    least, high = min(first, second), ABOVE * max(first, second)
    offset = 0.04 * least
    drawn = (
        Channel("middles", "m", (2, 3), "centres at the first contact"),
        Channel("ways", "m", (2, 3), "from there"),
        Channel("forces", "N", (2, 3), "on each body by the other"),
        Channel("tails", "m", (2, 3), "where the arrows begin"),
    )
    fixed = {
        "middles": ((-first, 0.0, 0.0), (second, 0.0, 0.0)),
        "tails": ((-offset, high, 0.0), (offset, high, 0.0)),
    }

    def rows(sample):
        load, displacements = sample["normal_load"], sample["displacement"] - (gap, 0.0)
        constant = {name: np.tile(vectors, (len(load), 1, 1)) for name, vectors in fixed.items()}
        return constant | {"ways": displacements[..., None] * X, "forces": np.multiply.outer(load, (-X, X))}

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
                name, f"{name} body", SHAPES[body.shape](body, index), (BLUE, ORANGE)[index],
                place=index, position="middles", deviation="ways", opacity=0.62,
            )
            for index, (name, body) in enumerate(zip(parameters.names, bodies, strict=True))
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
        enlarged=Enlarged("displacements", ("ways",), DISPLACEMENT * least),
        words="Where the bodies overlap they are pressed flat: the overlap is the approach, as much enlarged.",
    )  # fmt: skip


def bouncing_view(parameters, channels) -> View:
    """Of an ellipsoid on a plane and of two bodies: up is against gravity; a groove is cut through its middle."""
    (first, second), fall = parameters.bodies, np.array(parameters.gravity)
    upward = -fall / np.linalg.norm(fall) if fall.any() else Z
    tilted = abs(upward[2]) < 0.9
    direction = np.array(Z if tilted else (0.35, -1.0, 0.0)) + (0.42 if tilted else 0.3) * upward
    names, same = {channel.name for channel in channels}, second.shape == first.shape
    groove, bounded = second.shape == "groove", [body for body in (first, second) if math.isfinite(reach_of(body))]
    if isinstance(parameters, EllipsoidOnPlaneScene):
        start, longest = parameters.start, reach_of(first)
        middle = 0.5 * max(start.height, 0.0)
        centre, extent = (0.0, 0.0, middle + longest), middle + 1.15 * longest
        travels = min(first.semi_axes) != longest or any(start.velocity[:2]) or any(start.angular_velocity)
    else:
        positions, travels = np.array([body.position for body in bounded]), second.shape == "plane"
        centre = tuple((0.5 * (positions.min(axis=0) + positions.max(axis=0))).tolist())
        extent = max(math.dist(body.position, centre) + reach_of(body) for body in bounded)
    look = Look(
        (1.5 if groove else 1.1) * max(map(reach_of, bounded)),
        tuple(direction.tolist()),
        tuple(upward.tolist()),
        around=("second_position",) if groove else ("position",),
        at_start=(centre, extent),
        follows=parameters.names[0] if travels else "",
    )
    size = reach_of(first) if first in bounded else look.radius

    def solid(name: str, body, prefix: str, colour: str) -> Solid:
        ground = body.shape == "plane"
        poses = {word: f"{prefix}{word}" for word in ("position", "orientation") if f"{prefix}{word}" in names}
        appearance = {"marked": not ground, "opacity": 0.5 if ground else 1.0}
        return Solid(name, f"{name} body, {body.shape}", SHAPES[body.shape](body, 0), colour, **poses, **appearance)

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
                "contact", "contact", "push", "semi_major", "semi_minor", "peak_pressure", PATCH * size,
                major_axis="major_axis", point="contact_point",
            ),
        ),
        look=look,
        words="Bodies and places are true to scale.",
    )  # fmt: skip


def directions(angle, tilt) -> np.ndarray:
    """Unit vectors (..., 3) at angles [rad] round z and up from the plane z = 0; arrays broadcast."""
    flat = np.cos(tilt)
    return np.stack(np.broadcast_arrays(flat * np.cos(angle), flat * np.sin(angle), np.sin(tilt)), axis=-1)


def surface_points(surface: Surface, angle, tilt) -> np.ndarray:
    """Points (..., 3) [m] of a surface.

    Of a torus those at angles [rad] round its axis and its tube, of a convex body the farthest along `directions`.
    """
    outwards = directions(angle, tilt)
    if surface.kind != TORUS:
        return support(surface, outwards)
    locus, tube = surface.sizes[:2]
    return locus * directions(angle, np.zeros_like(tilt)) + tube * outwards


def _mesh(body: Shaped) -> dict:
    """A convex body by its support function: the farthest points along many directions, which are their normals."""
    tilts = np.linspace(0.5 * math.pi, -0.5 * math.pi, PARALLELS + 1)
    turns = np.linspace(0.0, 2.0 * math.pi, MERIDIANS + 1)
    angles = turns, tilts[:, None]
    corner = (np.arange(PARALLELS)[:, None] * (MERIDIANS + 1) + np.arange(MERIDIANS)).ravel()
    below = corner + MERIDIANS + 1
    triangles = np.concatenate(
        [np.stack([corner, below, corner + 1], axis=1), np.stack([corner + 1, below, below + 1], axis=1)]
    )
    arrays = surface_points(surface_of(body), *angles), directions(*angles)
    points, normals = (array.reshape(-1, 3).tolist() for array in arrays)
    return {"mesh": {"vertices": points, "normals": normals, "triangles": triangles.tolist()}}


def _groove(body: Shaped) -> dict:
    """The half z < 0 of a ring with a groove of the tube's radius inside."""
    bottom = body.ring_radius + body.radius
    strokes = grooved_ring(bottom, body.radius, EDGE, bottom + BEHIND * body.radius, -1.25 * body.radius)
    return {"turned": {"strokes": strokes}}


SHAPES = {
    "plane": lambda body, index: {"ground": {}},
    "sphere": lambda body, index: {"ellipsoid": (body.radius,) * 3},
    "ellipsoid": lambda body, index: {"ellipsoid": body.semi_axes},
    "superellipsoid": lambda body, index: _mesh(body),
    "groove": lambda body, index: _groove(body),
    # faces in one plane would flicker: the second disc is drawn a little thinner
    "disc": lambda body, index: {"cylinder": {"radius": body.radius, "length": body.thickness * (1.0 - 0.002 * index)}},
}
"""Drawing of each shape of `derived.ROWS`, by the index of the body."""
