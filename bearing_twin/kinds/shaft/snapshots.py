"""The state of a shaft's motion as plain data, and the motion put back to it."""

import math

import numpy as np

from bearing_twin.kinds.bearing.loading import Loading
from bearing_twin.kinds.shaft import march
from bearing_twin.kinds.shaft.course import ShaftCourse

ARRAYS = ("clock", "kept")


def snapshot_of(motion) -> dict:
    """The state of a `ShaftMotion` as plain data; see `put_back`."""
    arrays = {name: getattr(motion, name).tolist() for name in ARRAYS}
    balls = [one.tolist() if np.isfinite(one).all() else [] for one in motion.places]
    course, loading = motion.course, motion.course.loading
    told = {"told": course.now, "turned": course.turned(course.now)[:2], "goal": course.goal}
    commanded = loading.load.tolist() if loading.commanded else []
    return arrays | told | {"balls": balls, "commanded": commanded, "now": motion.seconds}


def put_back(motion, kept: dict) -> None:
    """Puts a motion that was reset to what `snapshot_of` gave.

    Raises KeyError, TypeError or ValueError for the state of another shaft.
    """
    balls = zip(motion.places, kept["balls"], strict=True)
    pairs = [(getattr(motion, name), kept[name]) for name in ARRAYS] + [pair for pair in balls if len(pair[1])]
    for array, numbers in pairs:
        given = np.array(numbers, float)
        if given.shape != array.shape or not np.isfinite(given).all():
            raise ValueError(numbers)
        array[...] = given
    now, told, goal, angle, speed = map(float, (kept["now"], kept["told"], kept["goal"], *kept["turned"]))
    began, time, step = motion.clock[[march.BEGAN, march.TIME, march.STEP]]
    if not (np.isfinite([angle, speed, goal]).all() and told <= now and began <= now <= time and step > 0.0):
        raise ValueError("clock")
    loading = Loading(motion.parameters.shaft)
    if commanded := list(map(float, kept["commanded"])):
        if len(commanded) != len(loading.load) or not all(map(math.isfinite, commanded)):
            raise ValueError(commanded)
        loading.set(commanded[:3], commanded[3:])
    motion.follow(ShaftCourse(motion.parameters, loading, told, angle, speed, goal), now)
