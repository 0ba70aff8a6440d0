"""How fast a bearing is on its way to the user's hand: `python bench/speed.py [scene] [seconds]`.

CPU time of one core against simulated time, set-up included: the motion alone, iterating blocks, iterating samples,
a log in memory and one in the folder for temporary files; and the set-up by itself. Each line also says how fast
it would be where the raceway kernel takes YARDSTICK (`measured`): its time is taken before and after, so that a busy
machine does not pass for a slow program.
"""

import platform
import sys
import tempfile
import time
from datetime import date

import numpy as np
from measured import YARDSTICK
from numba import njit

from bearing_twin import load_scene, simulate, write_log
from bearing_twin.kinds.bearing.forces.equations import raceway_rates
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, LANE_ROWS
from bearing_twin.kinds.bearing.forces.rates import put_ring_speed
from bearing_twin.numerics.lanes import LANES, into_blocks, new_blocks

REPEATS = 5
SET_UPS = 50


@njit
def _many(bearing, lanes, count):
    for _ in range(count):
        raceway_rates(bearing, lanes)


def kernel_time(motion, count=20_000):
    """Nanoseconds of CPU time a contact."""
    blocks = new_blocks(len(motion.state), LANE_ROWS)
    into_blocks(motion.state, blocks, AXIS_DISTANCE)
    lanes = blocks[0]
    put_ring_speed(motion.drive, 0.0, lanes)
    _many(motion.bearing, lanes, 1)
    start = time.process_time()
    _many(motion.bearing, lanes, count)
    return 1e9 * (time.process_time() - start) / count / LANES / 2


def motion_alone(run):
    """The motion in pieces of a second."""
    rate = run.scene.parameters.run.output_rate
    motion, times = run.simulation._motion, np.arange(1, round(rate) + 1) / rate
    for _ in range(round(run.scene.parameters.run.duration)):
        yield motion.advance(times, 1.0)


def logged(run, place=None):
    """One log in the folder `place`."""
    with tempfile.TemporaryDirectory(dir=place) as folder:
        yield None
        yield write_log(run, f"{folder}/run.mcap")


def set_up(scene, yardstick):
    """Milliseconds from a scene to its first output, and those where the kernel takes YARDSTICK: medians."""
    rows = []
    for _ in range(SET_UPS):
        before, start = kernel_time(yardstick, 200), time.process_time()
        next(iter(simulate(scene).simulation.advance(1)))
        spent = 1e3 * (time.process_time() - start)
        rows.append((spent, spent * YARDSTICK / (0.5 * (before + kernel_time(yardstick, 200)))))
    return np.median(rows, axis=0)


STAGES = {
    "motion and outputs": motion_alone,
    "iterate blocks": lambda run: run.blocks(),
    "iterate samples": iter,
    "log in memory": lambda run: logged(run, "/dev/shm"),
    "log on disk": logged,
}


def times_real_time(begin, scene, yardstick):
    """Of a stage: times real time scaled to YARDSTICK and as it is, kernel [ns], medians; and their range over it."""
    rows, seconds = [], scene.parameters.run.duration
    for _ in range(REPEATS):
        before, start = kernel_time(yardstick), time.process_time()
        for _ in begin(simulate(scene)):
            pass
        spent = time.process_time() - start
        kernel = 0.5 * (before + kernel_time(yardstick))
        rows.append((seconds / spent * kernel / YARDSTICK, seconds / spent, kernel))
    rows.sort()
    return *rows[len(rows) // 2], (rows[-1][0] - rows[0][0]) / rows[len(rows) // 2][0]


def main(name="bearing_6203", seconds="20"):
    """Prints one line a stage."""
    scene = load_scene(name, [f"run.duration={seconds}"])
    yardstick = simulate(scene).simulation._motion
    rate = scene.parameters.run.output_rate
    print(f"{name}, {seconds} s at {rate:g} Hz, {platform.processor() or platform.machine()}, {date.today()}")
    print(f"{'':20}{'x real time':>12}{'at ' + str(YARDSTICK) + ' ns':>12}{'kernel ns':>12}{'spread':>9}")
    for stage, begin in STAGES.items():
        scaled, raw, kernel, spread = times_real_time(begin, scene, yardstick)
        print(f"{stage:20}{raw:12.0f}{scaled:12.0f}{kernel:12.1f}{100 * spread:8.0f}%", flush=True)
    spent, scaled = set_up(scene, yardstick)
    print(f"set-up, with its first output: {spent:.2f} ms, {scaled:.2f} ms at {YARDSTICK} ns")


if __name__ == "__main__":
    main(*sys.argv[1:])
