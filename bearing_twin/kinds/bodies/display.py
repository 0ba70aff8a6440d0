"""How bodies that collide are shown: their topics, and their views in the browser.

The frame of two spheres or discs has x along the line of impact, forward, and its origin where the centre of the first
body starts; the axes of discs lie along z. That of an ellipsoid on a plane lies in the plane, z up.

The view of an impact of spheres or discs has x along the line of impact and the first contact in the origin, and draws
displacements enlarged. That of bodies that bounce is true to scale.
"""

import functools
import math
from collections import ChainMap
from collections.abc import Mapping

import numpy as np

from bearing_twin.base.sample import Channel, Sample, Wrench
from bearing_twin.kinds import markers
from bearing_twin.kinds.bodies.derived import ROWS, bodies_of, names_of, patch_of, reach_of, surface_of
from bearing_twin.kinds.bodies.parameters import (
    BODY,
    FIRST,
    PLANE,
    SECOND,
    Disc,
    EllipsoidOnPlaneScene,
    Shaped,
    Sphere,
    TwoBodiesScene,
)
from bearing_twin.kinds.contract import MARKERS, PUBLISH, Output, Topic
from bearing_twin.kinds.markers import (
    CUBE,
    CYLINDER,
    LINE_LIST,
    SPHERE,
    TEXT,
    LinkShape,
    box,
    contact_markers,
    crossed,
    cylinder,
    marker,
    sphere,
)
from bearing_twin.kinds.topics import MARKER_ARRAY, body_topics, contacts_topic, one_contact, opposed, pose_topic
from bearing_twin.kinds.views import (
    BLUE,
    GLASS,
    ORANGE,
    STEEL,
    Arrows,
    Enlarged,
    Look,
    Solid,
    Spots,
    Trail,
    View,
    along_axes,
    curves,
    picked,
)
from bearing_twin.numerics.rotation import rotation_matrix
from bearing_twin.shapes.implicit import PLANE as FLAT
from bearing_twin.shapes.implicit import TORUS, Surface, support

ROUND, RINGS = 48, 7  # sides of a ring; rings each way
X, DOWN, Z, ZERO = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0]), np.zeros(3)
COLOURS = markers.ORANGE, markers.BLUE  # of two spheres or discs
NUMBERS = ("approach", "normal_load", "semi_major", "semi_minor", "peak_pressure", "drilling_torque", "spin_rate")
VECTORS = ("friction_force", "slip", "major_axis")


def impact_topics(link: str, parameters) -> tuple[Topic, ...]:
    """The topics of two spheres or two discs."""
    texts = {body: f"on the {body} body, by the other, about its centre" for body in (FIRST, SECOND)}
    return (
        *_body_topics(link, texts),
        Topic("markers", MARKER_ARRAY, PUBLISH, impact_markers, "both bodies", link),
    )


sphere_topics = functools.partial(impact_topics, "two_spheres_link")
disc_topics = functools.partial(impact_topics, "two_discs_link")


def ellipsoid_topics(parameters: EllipsoidOnPlaneScene) -> tuple[Topic, ...]:
    """The topics of an ellipsoid on a plane."""
    link = "ellipsoid_on_plane_link"
    texts = {
        BODY: "on the body, by the plane, about its centre; gravity is not in it",
        PLANE: f"on the plane, by the body, about the origin of {link}",
    }
    return (
        *_body_topics(link, texts),
        pose_topic("pose", link, "centre and orientation of the body"),
        Topic("markers", MARKER_ARRAY, MARKERS, bouncing_markers, "body, contact ellipse, load", link),
    )


def pair_topics(parameters: TwoBodiesScene) -> tuple[Topic, ...]:
    """The topics of two bodies."""
    link = "two_bodies_link"
    texts = {
        FIRST: "on the first body, by the second, about its centre; gravity is not in it",
        SECOND: "on the second body, by the first, about its centre",
    }
    poses = (
        pose_topic(f"{body}/pose", link, f"centre and orientation of the {body} body", prefix)
        for body, prefix in ((FIRST, ""), (SECOND, "second_"))
    )
    return (
        *_body_topics(link, texts),
        *poses,
        Topic("markers", MARKER_ARRAY, MARKERS, bouncing_markers, "bodies, contact ellipse, load to look at", link),
    )


def _body_topics(link: str, texts: Mapping[str, str]) -> tuple[Topic, ...]:
    contact = contacts_topic(link, contacts, "the contact, as arrays of one row")
    return *body_topics(link, wrenches, origins, texts, solids), contact


def as_pair(parameters, sample: Sample) -> Mapping[str, np.ndarray] | Sample:
    """The channels of a sample as those of two bodies (`motion.PAIR_CHANNELS`)."""
    if isinstance(parameters, TwoBodiesScene):
        return sample
    if isinstance(parameters, EllipsoidOnPlaneScene):
        turned = {"drilling_torque": -sample["drilling_torque"], "spin_rate": -sample["angular_velocity"][2]}
        return ChainMap({"second_position": ZERO, "normal": DOWN, **turned}, sample.values)
    (first, second), (one, other) = sample["displacement"], bodies_of(parameters)
    second = one.radius + other.radius + parameters.motion.gap + second
    middle = 0.5 * (first + one.radius + second - other.radius)
    patch = patch_of(parameters, float(sample["normal_load"]))
    return (
        {name: sample[name] for name in NUMBERS[:2]}
        | dict(zip(NUMBERS[2:], (*patch, 0.0, 0.0), strict=True))
        | dict.fromkeys(VECTORS[:2], ZERO)
        | {"major_axis": Z, "normal": X}
        | {"position": first * X, "second_position": second * X, "contact_point": middle * X}
    )


def origins(parameters, sample: Sample) -> dict[str, np.ndarray]:
    """Centres of the two bodies [m], and the origin for a plane."""
    pair = as_pair(parameters, sample)
    return dict(zip(names_of(parameters), (pair["position"], pair["second_position"]), strict=True))


def wrenches(parameters, sample: Sample) -> list[Wrench]:
    """On each body by the other, of load, friction and drilling."""
    pair = as_pair(parameters, sample)
    normal, point = pair["normal"], pair["contact_point"]
    force = pair["friction_force"] - float(pair["normal_load"]) * normal
    drilling = float(pair["drilling_torque"]) * normal
    torque = crossed(point - pair["position"], force) + drilling
    other = crossed(point - pair["second_position"], -force) - drilling
    return opposed(*names_of(parameters), "centre", force, torque, other)


def contacts(parameters, sample: Sample) -> dict:
    """The fields of Contacts: the second body acts on the first; normals and torques about them point into it."""
    pair = as_pair(parameters, sample)
    numbers = {name: float(pair[name]) for name in NUMBERS}
    for name in ("drilling_torque", "spin_rate"):
        numbers[name] = 0.0 - numbers[name]
    vectors = {name: pair[name] for name in VECTORS}
    return one_contact(
        *names_of(parameters), **numbers, **vectors, point=pair["contact_point"], normal=0.0 - pair["normal"]
    )


def solids(parameters) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`: of those that URDF has, spheres, discs and the plane under an ellipsoid."""
    found = {}
    for name, one, colour in zip(names_of(parameters), bodies_of(parameters), COLOURS, strict=True):
        if isinstance(one, Disc):
            found[name] = [cylinder(one.radius, one.thickness, colour)]
        elif isinstance(one, Sphere):
            found[name] = [sphere(one.radius, colour)]
        elif name == PLANE:
            longest = max(parameters.body.semi_axes)
            size = 8.0 * longest, 8.0 * longest, 0.02 * longest
            found[name] = [box(size, markers.GLASS, (0.0, 0.0, -0.5 * size[2]))]
        elif one.shape in ("sphere", "ellipsoid") and len({*ROWS[one.shape].sizes(one)}) == 1:
            found[name] = [sphere(ROWS[one.shape].sizes(one)[0], markers.STEEL)]
    return found


def impact_markers(output: Output) -> dict:
    """visualization_msgs/MarkerArray: both bodies and, as text, the force between them."""
    bodies, placed = bodies_of(output.parameters), output.once(origins).values()
    rows = zip(range(2), bodies, placed, COLOURS, strict=True)
    largest = max(one.radius for one in bodies)
    place, text = (bodies[0].radius, 1.3 * largest, 0.0), f"{float(output.sample['normal_load']):.4g} N"
    return {
        "markers": [
            *(_body_marker("bodies", number, one, (place,), largest, color) for number, one, place, color in rows),
            marker("force", 0, TEXT, (0.0, 0.0, 0.3 * largest), markers.GREEN, place, text=text),
        ]
    }


def bouncing_markers(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the bodies, the contact ellipse, the load.

    Of an ellipsoid on a plane also pins along its axes, of two bodies a line from the first to the contact.
    """
    sample, parameters = output.sample, output.parameters
    bodies, pair = bodies_of(parameters), as_pair(parameters, sample)
    centre, point, pose = pair["position"], pair["contact_point"], (sample["position"], sample["orientation"])
    longest = min(max(ROWS[one.shape].sizes(one)) for one in bodies if one.shape != "plane")
    if isinstance(parameters, EllipsoidOnPlaneScene):
        reach = 1.05 * np.array(bodies[0].semi_axes) * np.array(rotation_matrix(tuple(map(float, pose[1]))))
        name, ends, width = "pins", np.stack([centre - reach.T, centre + reach.T], axis=1), 0.04 * longest
        second, beside = ((*point[:2], -0.01 * longest),), (*point[:2], -0.5 * longest)
    else:
        name, ends, width = "arm", np.stack([centre, point]), 0.02 * longest
        second, beside = (sample["second_position"], sample["second_orientation"]), centre
    placed = zip(names_of(parameters), bodies, (pose, second), strict=True)
    return {
        "markers": [
            *(_body_marker(name, 0, one, where, longest) for name, one, where in placed),
            marker(name, 0, LINE_LIST, (width, 0.0, 0.0), markers.BLUE, points=ends),
            *contact_markers(pair, 0.0 - pair["normal"], longest, beside),
        ]
    }


def _body_marker(namespace: str, number: int, one, pose, longest: float, colour=markers.STEEL) -> dict:
    """A solid where markers have one, else lines on the surface."""
    shape, size, points = SPHERE, (2.0 * one.radius,) * 3, None
    if isinstance(one, Disc):
        shape, size = CYLINDER, (*size[:2], one.thickness)
    elif isinstance(one, Shaped) and one.shape != "sphere":
        if one.shape == "plane":
            shape, size, colour = CUBE, (8.0 * longest, 8.0 * longest, 0.02 * longest), markers.GLASS
        elif one.shape == "ellipsoid":
            size = tuple(2.0 * axis for axis in one.semi_axes)
        else:
            shape, size, points = LINE_LIST, (0.01 * longest, 0.0, 0.0), lines_of(one)
    return marker(namespace, number, shape, size, colour, *pose, points=points)


@functools.lru_cache(maxsize=16)
def lines_of(one: Shaped) -> np.ndarray:
    """Ends (n, 2, 3) [m] of lines on the surface of a body, none of a plane: its parallels and meridians.

    Of a convex body sections through its centre, of a groove circles both ways.
    """
    surface, turn = surface_of(one), np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    if surface.kind == FLAT:
        return np.empty((0, 2, 3))
    if surface.kind == TORUS:
        parallels, meridians = (np.linspace(0.0, 2.0 * math.pi, count + 1)[:-1] for count in (RINGS, 2 * RINGS))
    else:
        parallels, meridians = (0.0,), np.linspace(0.0, math.pi, RINGS)[:-1]
    rings = [surface_points(surface, turn, across) for across in parallels]
    rings += [surface_points(surface, around, turn) for around in meridians]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])


# Views

REACH, ABOVE = 0.3, 1.25  # radii of the smaller body: displacement, height of the arrows of an impact
ARROW, SPOT = 1.6, 0.35  # longest arrow, greatest drawn semi-axis of a contact; in sizes of the body
OF_IMPACT = ("approach", "normal_load", "displacement", "velocity", "kinetic_energy", "elastic_energy")
ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "in the contact"))
TAKEN = (
    *("position", "orientation", "second_position", "second_orientation", "contact_point", "major_axis", "slip"),
    *("semi_major", "semi_minor", "peak_pressure", "normal_load", "kinetic_energy", "potential_energy"),
    *("elastic_energy", "dissipated_viscous", "dissipated_friction"),
)
STORED = (ENERGIES[0], ("potential_energy", "of height"), ENERGIES[1])
LOST = (("dissipated_viscous", "lost to viscosity"), ("dissipated_friction", "lost to friction"))
"""Channels and words of the energies, in the order in which they are shown."""
AROUND, ACROSS = 64, 32  # directions of a mesh round its axis and from pole to pole
EDGE = math.radians(78.0)  # how far up a groove is drawn
BEHIND = 0.5  # radii of the tube: the ring behind a groove
UPWARD = (0.0, 0.0, 1.0)


def impact_view(facts, channels) -> View:
    """Of two spheres or two discs."""
    parameters = facts.scene.parameters
    bodies = bodies_of(parameters)
    first, second = (one.radius for one in bodies)
    least, gap = min(first, second), parameters.motion.gap
    drawn = (
        Channel("middles", "m", (2, 3), "centres at the first contact"),
        Channel("ways", "m", (2, 3), "from there"),
        Channel("forces", "N", (2, 3), "on each body by the other"),
        Channel("tails", "m", (2, 3), "where the arrows begin"),
    )

    high, apart = ABOVE * max(first, second), 0.04 * least
    fixed = {
        "middles": ((-first, 0.0, 0.0), (second, 0.0, 0.0)),
        "tails": ((-apart, high, 0.0), (apart, high, 0.0)),
    }

    def rows(sample):
        load, moved = sample["normal_load"], sample["displacement"] - (gap, 0.0)
        return (
            {name: sample[name] for name in OF_IMPACT}
            | {name: np.tile(one, (len(load), 1, 1)) for name, one in fixed.items()}
            | {"ways": moved[..., None] * X, "forces": np.multiply.outer(load, (-X, X))}
        )

    def solid(place: int, one) -> Solid:
        shape = {"ellipsoid": (one.radius,) * 3}
        if isinstance(one, Disc):  # faces in one plane would flicker: the second disc is drawn a little thinner
            shape = {"cylinder": {"radius": one.radius, "length": one.thickness * (1.0 - 0.002 * place)}}
        name = ("first", "second")[place]
        return Solid(
            name, f"{name} body", shape, (BLUE, ORANGE)[place],
            place=place, position="middles", deviation="ways", opacity=0.62,
        )  # fmt: skip

    return View(
        series=(*picked(channels, OF_IMPACT), *drawn),
        rows=rows,
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            curves("Approach, negative while there is a gap", "m", ("approach", "approach")),
            curves("Velocities", "m/s", ("velocity", "first", 0), ("velocity", "second", 1)),
            curves("Energy", "J", *ENERGIES),
        ),
        solids=tuple(solid(*one) for one in enumerate(bodies)),
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


def ellipsoid_view(facts, channels) -> View:
    """The scene's axes, z up from the plane; the eye follows a body that moves along the plane."""
    axes, start = facts.scene.parameters.body.semi_axes, facts.scene.parameters.start
    longest = max(axes)
    solids = (
        Solid("plane", "plane", {"ground": {}}, GLASS, opacity=0.5),
        Solid("body", "ellipsoid", {"ellipsoid": axes}, position="position", orientation="orientation", marked=True),
    )
    amid = 0.5 * max(start.height, 0.0) + longest  # from the plane to the top of the body
    seen = (0.0, 0.0, amid), amid + 0.15 * longest
    travels = min(axes) != longest or any(start.velocity[:2]) or any(start.angular_velocity)
    follows = "body" if travels else ""
    look = Look(1.15 * longest, (0.35, -1.0, 0.3), UPWARD, around=("position",), at_start=seen, follows=follows)
    return _bouncing_view(
        channels, solids, longest, look, ("Height of the centre", ("position", "above the plane", 2)),
        lambda sample: np.full(sample["position"].shape, UPWARD),
    )  # fmt: skip


def pair_view(facts, channels) -> View:
    """Up is against gravity; a groove is cut through its middle."""
    parameters = facts.scene.parameters
    first, second = bodies_of(parameters)
    fall = np.array(parameters.gravity)
    upward = -fall / np.linalg.norm(fall) if fall.any() else np.array(UPWARD)
    tilted = abs(upward[2]) < 0.9
    direction = np.array(UPWARD if tilted else (0.35, -1.0, 0.0)) + (0.42 if tilted else 0.3) * upward
    same = second.shape == first.shape
    solids = (
        _solid("first", first, "", BLUE if same else STEEL),
        _solid("second", second, "second_", STEEL if same else GLASS),
    )
    seen = [one for one in (first, second) if math.isfinite(reach_of(one))]
    places, groove = np.array([one.position for one in seen]), second.shape == "groove"
    amid = 0.5 * (places.min(axis=0) + places.max(axis=0))
    far = max(float(np.linalg.norm(np.array(one.position) - amid)) + reach_of(one) for one in seen)
    look = Look(
        (1.5 if groove else 1.1) * max(map(reach_of, seen)),
        tuple(direction.tolist()),
        tuple(upward.tolist()),
        around=("second_position",) if groove else ("position",),
        at_start=(tuple(amid.tolist()), far),
        follows="first" if second.shape == "plane" else "",
    )
    return _bouncing_view(
        channels, solids, reach_of(first) if first in seen else look.radius, look,
        ("Position of the first body's centre", *along_axes("position")), lambda sample: -sample["normal"],
    )  # fmt: skip


def _bouncing_view(channels, solids: tuple[Solid, ...], size: float, look: Look, motion: tuple, push) -> View:
    """The view of a body of that `size` [m] on another, whose `motion` is a panel in metres.

    `push` gives the direction (count, 3) in which the normal load acts on the first body.
    """
    series = picked(channels, TAKEN)
    return View(
        series=(*series, Channel("push", "1", (3,), "direction of the normal load on the first body")),
        rows=lambda sample: {one.name: sample[one.name] for one in series} | {"push": push(sample)},
        panels=(
            curves("Normal load", "N", ("normal_load", "normal load")),
            curves(motion[0], "m", *motion[1:]),
            curves("Peak pressure", "Pa", ("peak_pressure", "peak pressure")),
            curves("Slip at the contact", "m/s", *along_axes("slip")),
            curves("Energy", "J", *STORED, *LOST),
        ),
        solids=solids,
        marks=(
            Trail("way", "way of the centre", "position"),
            Arrows(
                "load", "normal load on the body", "N", "push", ARROW * size, (ORANGE,), "normal_load",
                point="contact_point",
            ),
            Spots(
                "contact", "contact", "push", "semi_major", "semi_minor", "peak_pressure", SPOT * size,
                major_axis="major_axis", point="contact_point",
            ),
        ),
        look=look,
        words="Bodies and places are true to scale.",
    )  # fmt: skip


def _solid(name: str, one: Shaped, prefix: str, colour: str) -> Solid:
    ground = one.shape == "plane"
    return Solid(
        name,
        f"{name} body, {one.shape}",
        SHAPES[one.shape](one),
        colour,
        position=f"{prefix}position",
        orientation=f"{prefix}orientation",
        marked=not ground,
        opacity=0.5 if ground else 1.0,
    )


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
    tube, ring = one.radius, one.ring_radius
    arc = [(ring + tube * math.cos(angle), -tube * math.sin(angle)) for angle in np.linspace(0.0, EDGE, 16)]
    back, face = ring + (1.0 + BEHIND) * tube, -1.25 * tube
    rim = (arc[-1][0], face)
    return {
        "turned": {
            "strokes": [arc, [arc[-1], rim], [rim, (back, face)], [(back, face), (back, 0.0)], [(back, 0.0), arc[0]]]
        }
    }


SHAPES = {
    "plane": lambda one: {"ground": {}},
    "sphere": lambda one: {"ellipsoid": (one.radius,) * 3},
    "ellipsoid": lambda one: {"ellipsoid": one.semi_axes},
    "superellipsoid": _mesh,
    "groove": _groove,
}
"""How each shape of `derived.ROWS` is drawn."""
