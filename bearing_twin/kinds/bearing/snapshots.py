"""The state of a bearing's motion as plain data, and the motion put back to it."""

import numpy as np

from bearing_twin.kinds.bearing.model import RingDrive
from bearing_twin.kinds.bearing.step_limits import FIXED_STEP

MOVING = ("state", "orientation", "steps", "carried", "border")  # arrays that a chunk moves on
ARRAYS = (*MOVING, "_load", "_load_rate")
LISTS = {"commanded": (0, 5), "commanded_torque": (0, 1), "drive": (3,), "offset": (3,)}  # how many numbers each may be


def snapshot_of(motion) -> dict:
    """The state of a `BearingMotion` as plain data; see `put_back`."""
    loading = motion.loading
    arrays = {name: getattr(motion, name).tolist() for name in (*ARRAYS, "counts")}
    arrays["commanded"] = loading.load.tolist() if loading.commanded else []
    arrays["commanded_torque"] = [loading.torque] if loading.torque_commanded else []
    rest = {"drive": list(motion.drive), "goal_speed": motion.goal_speed, "offset": list(motion.bearing.offset)}
    heard = {"heard": list(motion.heard)} if motion.accelerometer else {}
    fixed = {"fixed_step": motion.step} if motion.stepper in FIXED_STEP else {}
    moving = {"elapsed": motion.elapsed, "changed": motion._changed, "acceleration": motion._acceleration}
    return arrays | rest | fixed | moving | heard


def put_back(motion, kept: dict) -> None:
    """Puts a motion that was reset to what `snapshot_of` gave, but for the ring's offset.

    Raises KeyError, TypeError or ValueError for the state of another bearing.
    """
    for name, lengths in LISTS.items():
        numbers = np.array(kept[name], float)
        if numbers.ndim != 1 or len(numbers) not in lengths or not np.isfinite(numbers).all():
            raise ValueError(name)
    if kept["commanded"]:
        motion.loading.set(kept["commanded"][:3], kept["commanded"][3:])
    for torque in kept["commanded_torque"]:
        motion.loading.set_torque(torque)
    motion._load, motion._load_rate = motion._load.copy(), motion._load_rate.copy()
    for name in ARRAYS:
        array, given = getattr(motion, name), np.array(kept[name], float)
        if given.shape != array.shape or not np.isfinite(given).all():
            raise ValueError(name)
        array[...] = given
    if not (motion.steps > 0.0).all():
        raise ValueError("steps")
    motion.counts[:] = kept["counts"]
    if motion.accelerometer and kept.get("heard"):
        count, *filtered = map(float, kept["heard"])
        motion.heard = (int(count), *filtered[:2])
    motion.drive = RingDrive(*map(float, kept["drive"]))
    motion.goal_speed, motion.elapsed = float(kept["goal_speed"]), float(kept["elapsed"])
    motion._changed, motion._acceleration = kept["changed"], float(kept["acceleration"])
