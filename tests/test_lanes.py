"""How many bodies stand side by side in lanes changes no bit of what a bearing does."""

import hashlib
import os
import platform
import subprocess
import sys

import numba
import numpy as np
import pytest
from lanes import by_cheapest, held_lanes
from machine_code import machine_code

from bearing_twin import vectors
from bearing_twin.code_linking import dispatcher
from bearing_twin.compiled import OPTIONS
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


def test_narrower_lanes_are_reckoned_by_what_attempts_find():
    """`bench/lanes.py`: attempts and balls are none lost, and a width that needs several turns pays for each."""
    attempts = [5, 2, 9, 2]
    held = held_lanes(attempts)
    assert held == [4, 3, 0, 2]
    assert sum(held) == max(attempts)
    assert sum(balls * made for balls, made in enumerate(held, 1)) == sum(attempts)
    assert by_cheapest(held, {8: 3.0}) == 3.0 * sum(held)
    assert by_cheapest(held, {8: 3.0, 1: 1.0}) == 4 * 1.0 + 3 * 2.0 + 2 * 3.0
    assert by_cheapest(held, {2: 2.0}) == (4 + 3) * 2.0 + 2 * 4.0


HAS = "+avx2,+avx512f,+evex512"


@pytest.mark.parametrize(
    ("processor", "features", "bits"),
    [
        ("znver4", HAS, 512),
        ("znver3", "+avx2,-avx512f", 256),
        ("emeraldrapids", HAS, 512),
        ("icelake-server", "+avx512f", 512),
        ("skylake-avx512", HAS, 256),
        ("tigerlake", HAS, 256),
        ("skylake-avx512", HAS + ",-prefer-256-bit", 512),
        ("emeraldrapids", HAS + ",+prefer-256-bit", 256),
        ("graniterapids", "+avx512f,-evex512", 256),
        ("emeraldrapids", "", 256),
        ("apple-m1", "", 256),
    ],
)
def test_instructions_are_as_wide_as_a_processor_takes_them_at_full_speed(processor, features, bits):
    """512 bits where both units take them whole, unless the user says otherwise."""
    assert vectors.bits_for(processor, features) == bits


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names of registers are those of x86")
def test_lanes_here_are_as_wide_as_kernels_are_compiled():
    """Registers zmm of 512 bits are asked for in machine code of a plain loop."""

    def squares(of, into):
        for k in range(64):
            into[k] = of[k] * of[k]

    code = machine_code(squares, np.ones(64), np.ones(64))
    assert (8 if "zmm" in code else 4) == lanes.LANES


def test_what_others_compile_stays_as_it_is():
    """Functions of Numba's own do not say how wide they want to be, whatever ours say."""

    def squares(of, into):
        for k in range(64):
            into[k] = of[k] * of[k]

    says = []
    for compiled in (numba.njit(squares), dispatcher(squares, OPTIONS)):
        compiled(np.ones(64), np.ones(64))
        (code,) = compiled.inspect_llvm().values()
        says.append("prefer-vector-width" in code)
    assert says == [False, vectors.BITS > 256]


def test_lanes_begin_with_a_line_of_the_cache():
    """Blocks and lanes of odd sizes, kept together so that each has memory of its own."""
    made = [(lanes.new_lanes(rows), lanes.new_blocks(balls, rows)) for rows in (1, 2, 3, 7) for balls in (1, 5, 9, 17)]
    for alone, blocks in made:
        assert alone.ctypes.data % lanes.CACHE_LINE == blocks.ctypes.data % lanes.CACHE_LINE == 0
        assert len(alone) * len(blocks) == blocks.size
        assert not alone.any()
        assert not blocks.any()
