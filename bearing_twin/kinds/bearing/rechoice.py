"""The model of a bearing looked at again while it runs: what a command makes of the scene, and going on with another.

The tables that chose at the start choose again, for the speeds and loads from now on. What the scene pins stays.
"""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing.acting import LoadChange
from bearing_twin.kinds.bearing.choices import CHOICE, Switch
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    CAGE,
    DISSIPATED,
    DRIVE_WORK,
    GROSS_WORK,
    HEIGHT,
    ORBIT_ANGLE,
)
from bearing_twin.kinds.bearing.friction_choice import as_chosen
from bearing_twin.kinds.bearing.models import choose
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.moving import moving_by
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.partners import caged_start
from bearing_twin.kinds.bearing.quasi_static.running import QuasiStaticMotion
from bearing_twin.kinds.bearing.rings import FREE, free_coordinates
from bearing_twin.kinds.bearing.start import SAME, least_drilling, let_roll
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.kinds.energy import STORED
from bearing_twin.report import Choice, Rechosen, never

COMING = 1.0  # s: any time above 0 says that a change is still to come


def scene_now(parameters: BearingScene, goal: float, changed: bool, speed: float, load: tuple) -> BearingScene:
    """The parameters of a scene that would begin now, its ring at `speed` and told to go to `goal` [rad/s].

    They are for the tables. `changed`: the change of the drive has come, or there is none. `load` (force, moment) is
    what is commanded, None for both: the scene's own. Of the speeds still to come the greatest stands for all; the
    least is reached by a change. Balls that started from rest count as doing so.
    """
    drive, ring, change = parameters.drive, parameters.rings.inner, parameters.drive.change
    speeds, shift, offset = [speed, goal], (0.0, 0.0, 0.0), drive.offset
    if not changed:
        speeds.append(goal + change.speed)
        shift = change.offset
    elif change.time:
        offset = drive.changed_offset
    fastest, slowest = max(speeds, key=abs), min(speeds, key=abs)
    coming = COMING if any(shift) or slowest != fastest else 0.0
    change = dataclasses.replace(change, time=coming, speed=slowest - fastest, offset=shift)
    if load[0] is not None:
        [free] = [name for name, one in FREE.items() if one == free_coordinates(parameters)]
        force, moment = (tuple(map(float, one)) for one in load)
        ring = dataclasses.replace(ring, free=free, load=force, moment=moment[:2], change=LoadChange(), table=())
    drive = dataclasses.replace(drive, speed=fastest, offset=offset, change=change)
    return dataclasses.replace(parameters, drive=drive, rings=dataclasses.replace(parameters.rings, inner=ring))


def rechosen(parameters: BearingScene, choice: Choice, motion, load: tuple) -> Rechosen:
    """The choice for what a motion is told to do, and the motion that goes on with it; see `Kind.rechosen`."""
    parameters, here, speed = as_chosen(parameters, choice), motion.first_outputs(), _speed(motion)
    try:
        chosen = choose(scene_now(parameters, motion.goal_speed, _changed(motion), speed, load))
        chosen = chosen._replace(friction=choice.friction)
        if (chosen.stepper, _setting(parameters, chosen)) == (choice.stepper, _setting(parameters, choice)):
            return Rechosen(chosen, motion, _waiting(motion))
        other = _going_on(parameters, chosen, motion, here)
    except (SceneError, IntegrationError) as error:  # as of a bearing that finds no balance: it was in one before
        told = f"at {motion.elapsed:.9g} s {choice.stepper} stayed, because no other model could be chosen: {error}"
        return Rechosen(choice, motion, _waiting(motion), told)
    jump = _jump(here.normal_load, other.first_outputs().normal_load)
    names = choice.stepper, chosen.stepper
    switch = Switch(motion.elapsed, speed, motion.goal_speed, *names, _setting(parameters, chosen), jump)
    records = {CHOICE.name: switch.row()}
    if switch.taken:
        if isinstance(motion, WatchedMotion) and isinstance(other, WatchedMotion):
            other.take_rows(motion)
        else:
            records |= motion.take_records()
        kept = isinstance(motion, BearingMotion) and isinstance(other, BearingMotion)
        return Rechosen(chosen, other, _waiting(other), switch.sentence(), records, {} if kept else motion.costs())
    return Rechosen(choice, motion, _waiting(motion), switch.sentence(), records)


def _waiting(motion) -> Callable[[], bool]:
    """Whether the ring has come to the speed it goes to, asked later; `never` where it has that already."""

    def reached() -> bool:
        return _speed(motion) == motion.goal_speed

    return never if reached() else reached


def _speed(motion) -> float:
    return motion.speed if isinstance(motion, QuasiStaticMotion) else motion.drive.speed


def _changed(motion) -> bool:
    """Whether the scene's change of the drive has come, or there is none."""
    return motion.changed if isinstance(motion, QuasiStaticMotion) else bool(motion.snapshot()["changed"])


def _setting(parameters: BearingScene, choice: Choice) -> float:
    return parameters.wanted.tolerance if math.isnan(choice.setting) else choice.setting


def _jump(before: np.ndarray, after: np.ndarray) -> float:
    """The greatest change of a load over the greatest load; infinite where loads come from nothing."""
    greatest, change = float(before.max(initial=0.0)), float(np.abs(after - before).max(initial=0.0))
    return change / greatest if greatest > 0.0 else math.inf if change > 0.0 else 0.0


def _going_on(parameters: BearingScene, choice: Choice, motion, here):
    """A motion by the chosen model that goes on where another is, whose outputs are `here`."""
    other = moving_by(parameters, choice)
    if isinstance(motion, QuasiStaticMotion):
        _move_balls(other, motion, here)
    elif isinstance(other, QuasiStaticMotion):
        other.go_on_from(here, motion.goal_speed, motion.elapsed, _changed(motion))
    else:
        kept = motion.snapshot()
        if isinstance(motion, WatchedMotion):
            # What the companion tightened holds on for the same stepper; another has shown nothing yet.
            same = motion.setting < 1.0 and other.stepper == motion.stepper
            kept["setting"] = min(1.0, motion.tolerance / other.given) if same else 1.0
        other.resume(kept)
    other.stop = motion.stop
    return other


def _move_balls(other: BearingMotion, motion: QuasiStaticMotion, here) -> None:
    """Has balls go on by themselves from an equilibrium: in their places, rolling. Their energy is the drive's work."""
    kept, position = other.snapshot(), here.position[0]
    bearing = other.bearing._replace(offset=tuple(here.inner_ring_offset[0].tolist()))
    speed, state = float(here.inner_ring_speed[0]), np.zeros_like(other.state)
    state[:, AXIS_DISTANCE], state[:, HEIGHT] = np.hypot(position[:, 0], position[:, 1]), position[:, 2]
    state[:, ORBIT_ANGLE] = here.orbit_angle[0]
    for ball in state:
        let_roll(bearing, speed, SAME, ball)
    least_drilling(bearing, speed, state)
    state, border = caged_start(state, other.partners, speed)
    border[CAGE] = here.cage_angle[0] if other.partners.free[CAGE] else 0.0
    moved = {"state": state.tolist(), "orientation": here.orientation[0].tolist(), "border": border.tolist()}
    drive = {"drive": [float(here.inner_ring_angle[0]), speed, 0.0], "goal_speed": motion.goal_speed}
    since = {"offset": list(bearing.offset), "elapsed": motion.elapsed, "changed": motion.changed}
    other.resume(kept | moved | drive | since)
    there = other.first_outputs()
    gained = math.fsum(float(getattr(there, name)[0] - getattr(here, name)[0]) for name in STORED)
    other.state[0, DRIVE_WORK] = here.drive_work[0] + gained
    other.state[0, GROSS_WORK] = here.gross_work[0] + abs(gained)
    other.state[0, DISSIPATED] = here.dissipated[0]
    other.resume(other.snapshot())
