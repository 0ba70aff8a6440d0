"""Numbers that follow from the keys of a shaft on two bearings; what is impossible among them."""

import dataclasses
import math
from collections.abc import Mapping

from bearing_twin.kinds.bearing import catalogue
from bearing_twin.kinds.bearing.parameters import BearingContact, BearingScene
from bearing_twin.kinds.bearing.rings import EVEN, QUASI_STATIC, Cage, Drive, Model
from bearing_twin.kinds.sections import resolved_run
from bearing_twin.kinds.shaft.parameters import SIDES, Mounted, ShaftScene

SAME_PLACE = 1e-9  # m


def bearing_scene(parameters: ShaftScene, side: str) -> BearingScene:
    """One bearing as a scene of its own: equilibria in its own frame."""
    mounted, drive = getattr(parameters, side), parameters.drive
    x, y, z = parameters.gravity
    contact = parameters.contact
    words = {"normal": contact.normal, "stiffness": contact.stiffness, "relaxation_time": contact.relaxation_time}
    return BearingScene(
        **{name: getattr(mounted, name) for name in ("geometry", "fits", "temperatures", "ratings", "materials")},
        model=Model(QUASI_STATIC),
        contact=BearingContact(**words),
        drive=Drive(speed=drive.speed),
        cage=Cage(EVEN),
        gravity=(x, y, mounted.facing * z),
        wanted=dataclasses.replace(BearingScene().wanted, tolerance=parameters.wanted.tolerance),
        run=parameters.run,
    )


def middle_of(mounted: Mounted) -> float:
    """Where the inner ring of a bearing stands along its own axis [m] with the shaft's centre of mass at 0."""
    geometry = mounted.geometry
    between = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    return between * math.sin(geometry.contact_angle) - mounted.facing * mounted.offset


def check(parameters: ShaftScene) -> list[str]:
    """What is impossible although each number alone is legal; one line a problem, naming keys, values and limits."""
    problems, seen = [], []
    for side in SIDES:
        mounted = getattr(parameters, side)
        if mounted.facing == 0:
            problems.append(f"{side}.facing = 0 must be 1 or -1: a bearing has two faces")
        for problem in bearing_scene(parameters, side).check():
            if problem not in seen:
                own = problem.startswith(("geometry", "fits", "temperatures", "ratings", "materials"))
                problems.append(f"{side}.{problem}" if own else problem)
                seen += [] if own else [problem]
    left, right = parameters.left.place, parameters.right.place
    if right - left <= SAME_PLACE:
        problems.append(
            f"left.place = {left:g} m and right.place = {right:g} m leave no distance between the bearings, which "
            "holds the shaft upright; the left one must stand at the smaller place"
        )
    across, polar = parameters.shaft.inertia
    if polar > 2.0 * across:
        problems.append(
            f"shaft.inertia = [{across:g}, {polar:g}] kg m^2 belongs to no body: about the axis at most twice that "
            "about a diameter"
        )
    return problems


def resolve(parameters: ShaftScene) -> ShaftScene:
    """The parameters of a checked scene."""
    return dataclasses.replace(parameters, run=resolved_run(parameters.run))


def completed(scene: dict) -> tuple[dict, list[str]]:
    """The plain data of a scene with the rows of the catalogue filled in for both bearings, and what is wrong."""
    problems = []
    for side in SIDES:
        if isinstance(scene.get(side), Mapping):
            filled, wrong = catalogue.completed(scene[side])
            scene = {**scene, side: filled}
            problems += [f"{side}.{problem}" for problem in wrong]
    return scene, problems
