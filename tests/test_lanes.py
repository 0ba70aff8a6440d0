"""How many bodies stand side by side in lanes changes no bit of what a bearing does."""

import hashlib
import os
import platform
import subprocess
import sys

import numba
import numpy as np
import pytest

from bearing_twin.numerics import lanes

FROM_REST = ("initial.motion=rest", "drive.offset=[0.0, -1.0e-6, 5.0e-6]")
SCENES = {
    "settled": ("bearing_6203",),
    "lift-off": ("bearing_6203_loose",),
    "sudden": ("bearing_6203_sudden", "drive.change.time=2e-4", "drive.acceleration=1e6"),
    "spots, from rest": ("bearing_6203", *FROM_REST, "contact.friction=spot"),
    "balls that touch": (
        "bearing_6203",
        "geometry.balls=13",
        "geometry.pitch_diameter=28.1888e-3",
        "initial.motion=rest",
    ),
    "free ring, even cage": ("bearing_6203_rig_1000N",),
    "free ring, nine balls": ("bearing_6203_rig_1000N", "geometry.balls=9", "geometry.pitch_diameter=30e-3"),
}
OUTPUTS, PERIOD = 20, 1e-4  # s
# Before any other module takes what is set: rows, spans and kernels follow from it.
SET = """
from bearing_twin.numerics import lanes
lanes.LANES = {width}
lanes.STATE_SPAN = lanes.COLUMNS * lanes.LANES
from test_lanes import bits_of_all
bits_of_all()
"""


def bits_of_all():
    """Prints for each scene a hash of all outputs and of the state at their end."""
    from bearings import flat, run

    print("lanes:", lanes.LANES)
    for name, (scene, *words) in SCENES.items():
        moving, out = run(*words, scene=scene, count=OUTPUTS, period=PERIOD)
        print(name, hashlib.sha256(flat(out).tobytes() + moving.state.tobytes()).hexdigest())


def said_by(width, **changes):
    """What the hashes are in a process of its own whose lanes are so wide."""
    there = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)} | changes
    program = [sys.executable, "-c", SET.format(width=width)]
    done = subprocess.run(program, env=there, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, *found = done.stdout.splitlines()
    assert first == f"lanes: {width}"
    assert len(found) == len(SCENES)
    return found


@pytest.mark.environment
def test_bits_are_the_same_whatever_the_lanes(tmp_path):
    """The width in use by the kernels that are kept; what the other compiles stands in a cache of its own."""
    other = 12 - lanes.LANES
    assert said_by(other, XDG_CACHE_HOME=str(tmp_path)) == said_by(lanes.LANES)


@pytest.mark.parametrize(
    ("processor", "features", "width"),
    [("znver4", "+avx2,+avx512f", 8), ("znver3", "+avx2", 4), ("sapphirerapids", "+avx512f", 4), ("apple-m1", "", 4)],
)
def test_lanes_are_as_wide_as_vector_instructions(processor, features, width):
    """LLVM takes 256 bits on processors that have 512 but are not called znver."""
    assert lanes.width_for(processor, features) == width


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names of registers are those of x86")
def test_lanes_here_are_as_wide_as_the_compiler_takes_them():
    """Registers zmm of 512 bits are asked for in machine code of a plain loop."""

    @numba.njit
    def squares(of, into):
        for k in range(64):
            into[k] = of[k] * of[k]

    squares(np.ones(64), np.ones(64))
    (code,) = squares.inspect_asm().values()
    assert (8 if "zmm" in code else 4) == lanes.LANES
