"""A rigid shaft on two bearings: YAML keys, units, defaults and limits."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

from bearing_twin.base.parameters import choice, number_table, quantity, section
from bearing_twin.kinds.bearing.catalogue import completed
from bearing_twin.kinds.bearing.geometry import Fits, Temperatures
from bearing_twin.kinds.bearing.parameters import (
    LAW_NEEDS,
    RELAXATION_TIME,
    BearingContact,
    BearingScene,
    Geometry,
    GivenRatings,
    Materials,
)
from bearing_twin.kinds.bearing.rings import (
    EVEN,
    QUASI_STATIC,
    Cage,
    Drive,
    LoadChange,
    Model,
    SpeedChange,
    load_table,
    steady_load,
    steady_moment,
)
from bearing_twin.kinds.contract import SceneParameters
from bearing_twin.kinds.sections import (
    LOOSEST,
    UNVERIFIED,
    Checked,
    PointElastic,
    RunSettings,
    Wanted,
    free_fall,
    point_laws,
    resolved_run,
)

SAME_PLACE = 1e-9  # m
SIDES = ("left", "right")
SETTLED, EQUILIBRIUM = "settled", "equilibrium"
LOADS = (("place", "m"), ("x", "N"), ("y", "N"), ("z", "N"), ("about x", "N m"), ("about y", "N m"))
UNBALANCES = (("place", "m"), ("mass times radius", "kg m"), ("angle", "rad"))


@dataclass(frozen=True)
class RigidShaft:
    """The shaft and all that turns with it; positions along z are from its centre of mass."""

    mass: float = quantity(0.5, "kg", "of the shaft and what turns with it", above=0.0)
    inertia: tuple[float, float] = quantity(
        (1e-3, 2e-4), "kg m^2", "about a diameter through the centre of mass, and about the axis", above=0.0
    )
    load: tuple[float, float, float] = steady_load("on the shaft at load_place on its axis")
    moment: tuple[float, float] = steady_moment("the shaft")
    load_place: float = quantity(0.0, "m", "along z: where load, change, table and a commanded load act")
    change: LoadChange = section(LoadChange)
    table: tuple = load_table()
    loads: tuple = number_table(LOADS, "further, constant loads: where, force and moment", over_time=False)
    unbalances: tuple = number_table(
        UNBALANCES, "where, mass times its distance from the axis, its azimuth when the run starts", over_time=False
    )
    start: str = choice(
        SETTLED,
        (SETTLED, EQUILIBRIUM),
        "equilibrium = at rest under the first loads; settled = there, with the linear response to the unbalances",
    )


@dataclass(frozen=True)
class Mounted:
    """One bearing, its inner ring on the shaft, its outer ring in a housing at rest."""

    place: float = quantity(0.0, "m", "of the inner ring's centre along z, from the shaft's centre of mass")
    facing: int = quantity(
        1, "1", "1 or -1: the ring is loaded by a push of the shaft along +z, or turned round", at_least=-1, at_most=1
    )
    offset: float = quantity(
        0.0,
        "m",
        "of the outer ring along +z; from the middle, of an angular contact bearing from where the balls just touch",
    )
    ball_angle: float = quantity(0.0, "rad", "azimuth of ball 0 from +x when the run starts")
    geometry: Geometry = section(Geometry)
    fits: Fits = section(Fits)
    temperatures: Temperatures = section(Temperatures)
    ratings: GivenRatings = section(GivenRatings)
    materials: Materials = section(Materials)


@dataclass(frozen=True)
class ShaftContact(PointElastic):
    """The laws of all contacts of balls and raceways."""

    normal: str = choice("auto", point_laws(*LAW_NEEDS), "elastic law; auto = hertz, exact where it reaches")
    relaxation_time: float = quantity(
        RELAXATION_TIME,
        "s",
        "viscous part: a bearing's load is that of where its ring would be so much later; "
        "no source: 1 us damps a radial mode of 2 kHz by 0.7 % of critical",
        at_least=0.0,
        at_most=1e-4,
    )


@dataclass(frozen=True)
class ShaftDrive:
    """Drive of the shaft about its axis."""

    speed: float = quantity(183.26, "rad/s", "speed of the shaft about +z")
    acceleration: float = quantity(2000.0, "rad/s^2", "rate at which a changed speed is approached", above=0.0)
    change: SpeedChange = section(SpeedChange)


@dataclass(frozen=True)
class WantedOfShaft(Wanted):
    """Requested outputs and tolerance of a shaft."""

    tolerance: float = quantity(
        1e-3,
        "1",
        "requested error of every ball's load, over the greatest",
        at_least=1e-9,
        at_most=LOOSEST,
        less=UNVERIFIED,
    )


@dataclass(frozen=True)
class ShaftScene(SceneParameters):
    """A rigid shaft on two ball bearings whose balls are in balance at every instant."""

    shaft: RigidShaft = section(RigidShaft)
    left: Mounted = section(Mounted, default=Mounted(place=-0.05, facing=1, offset=-10e-6))
    right: Mounted = section(Mounted, default=Mounted(place=0.05, facing=-1, offset=10e-6))
    contact: ShaftContact = section(ShaftContact)
    drive: ShaftDrive = section(ShaftDrive)
    gravity: tuple[float, float, float] = free_fall(0.0, -1.0, 0.0)
    solver: Checked = section(Checked)
    wanted: WantedOfShaft = section(WantedOfShaft)
    run: RunSettings = section(RunSettings, default=RunSettings(0.5, 2000.0, 100.0))

    @staticmethod
    def completed(scene: dict) -> tuple[dict, list[str]]:
        """The plain data of a scene with the rows of the catalogue filled in for both bearings, and its problems."""
        problems = []
        for side in SIDES:
            if isinstance(scene.get(side), Mapping):
                filled, side_problems = completed(scene[side])
                scene = {**scene, side: filled}
                problems += [f"{side}.{problem}" for problem in side_problems]
        return scene, problems

    def check(self) -> list[str]:
        """Contradictions between keys, those of each bearing once."""
        problems, seen = [], []
        for side in SIDES:
            mounted = getattr(self, side)
            if mounted.facing == 0:
                problems.append(f"{side}.facing = 0 must be 1 or -1: a bearing has two faces")
            for problem in bearing_scene(self, side).check():
                if problem not in seen:
                    is_of_side = problem.startswith(("geometry", "fits", "temperatures", "ratings", "materials"))
                    problems.append(f"{side}.{problem}" if is_of_side else problem)
                    seen += [] if is_of_side else [problem]
        left, right = self.left.place, self.right.place
        if right - left <= SAME_PLACE:
            problems.append(
                f"left.place = {left:g} m and right.place = {right:g} m leave no distance between the bearings, which "
                "holds the shaft upright; the left one must stand at the smaller place"
            )
        across, polar = self.shaft.inertia
        if polar > 2.0 * across:
            problems.append(
                f"shaft.inertia = [{across:g}, {polar:g}] kg m^2 belongs to no body: about the axis at most twice that "
                "about a diameter"
            )
        return problems

    def resolve(self) -> "ShaftScene":
        """The parameters of a checked scene."""
        return dataclasses.replace(self, run=resolved_run(self.run))


def bearing_scene(parameters: ShaftScene, side: str) -> BearingScene:
    """One bearing as a scene of its own: equilibria in its own frame."""
    mounted, drive = getattr(parameters, side), parameters.drive
    x, y, z = parameters.gravity
    contact = parameters.contact
    contact_keys = {
        "normal": contact.normal,
        "stiffness": contact.stiffness,
        "relaxation_time": contact.relaxation_time,
    }
    return BearingScene(
        **{name: getattr(mounted, name) for name in ("geometry", "fits", "temperatures", "ratings", "materials")},
        model=Model(QUASI_STATIC),
        contact=BearingContact(**contact_keys),
        drive=Drive(speed=drive.speed),
        cage=Cage(EVEN),
        gravity=(x, y, mounted.facing * z),
        wanted=dataclasses.replace(BearingScene().wanted, tolerance=parameters.wanted.tolerance),
        run=parameters.run,
    )


def middle_of(mounted: Mounted) -> float:
    """Place of the inner ring of a bearing along its own axis [m] with the shaft's centre of mass at 0."""
    geometry = mounted.geometry
    between = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    return between * math.sin(geometry.contact_angle) - mounted.facing * mounted.offset
