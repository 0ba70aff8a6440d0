"""Points of the unit cube to sample at: the same whatever the chunks and the process.

| method | error of a mean after n points | interval from |
|---|---|---|
| random | n^-1/2 | the sample itself |
| latin_hypercube | n^-1/2, less the part that is a sum over the inputs | REPLICATES independent hypercubes |
| sobol | near n^-1 to n^-3/2 for smooth functions of few inputs | REPLICATES independent randomisations |

Points of one Sobol sequence or one hypercube depend on each other, so their own scatter says nothing about the error.
Therefore REPLICATES independent ones are interleaved: point i belongs to replicate i % REPLICATES, and `statistics`
takes the scatter between the replicates. Sizes are REPLICATES times a power of two for `sobol`, times any number for
`latin_hypercube`. With twice as many replicates of half the size errors of a mean are 1.4 times as large.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from bearing_twin.base.stopping import stop_if_requested
from bearing_twin.uq.inputs import GREATEST_UNIT, LEAST_UNIT

BLOCK = 1024  # points of `random` that share a seed
REPLICATES = 8  # independent randomisations of points that depend on each other
GREATEST_SAMPLES = 2**30
GREATEST_SEED = 2**53 - 1  # what JSON and doubles hold


class Sampler(NamedTuple):
    """A row of SAMPLERS.

    `chunk(points, start, count)` -> (count, dimension); `replicates` of the design; `size(samples)`, the least legal
    number of samples that is not below `samples`, and `legal`, in words; `grows`: a smaller design is
    the beginning of a larger one, so that a study may be checked there and continued.
    """

    chunk: Callable
    replicates: int
    help: str
    size: Callable = int
    legal: str = "any number"
    grows: bool = True


def _random(points, start, count):
    """Blocks of BLOCK points, each with a generator of its own, spawned from the seed by the block's number."""
    first, last = start // BLOCK, (start + count - 1) // BLOCK
    blocks = [_generator(points.seed, block).random((BLOCK, points.dimension)) for block in range(first, last + 1)]
    return np.concatenate(blocks)[start - first * BLOCK :][:count]


def _latin_hypercube(points, start, count):
    return _hypercubes(points.dimension, points.seed, points.samples)[start : start + count]


@lru_cache(maxsize=2)
def _hypercubes(dimension, seed, samples):
    """All points (samples, dimension), interleaved; cached, as chunks are drawn one after the other."""
    size = samples // REPLICATES
    cubes = []
    for part in range(REPLICATES):
        stop_if_requested()
        cubes.append(qmc.LatinHypercube(dimension, seed=_generator(seed, part)).random(size))
    return np.stack(cubes, axis=1).reshape(-1, dimension)


def _sobol(points, start, count):
    """Interleaved replicates; each is moved on to its first point of the chunk."""
    replicates = points.replicates
    first, last = start // replicates, (start + count - 1) // replicates
    rows = np.empty((last - first + 1, replicates, points.dimension))
    for replicate in range(replicates):
        sequence = qmc.Sobol(points.dimension, scramble=True, seed=_generator(points.seed, replicate))
        if first:
            sequence.fast_forward(first)
        # a whole power of two: SciPy warns of anything else at the start of a sequence
        drawn = sequence.random(1 << (last - first).bit_length())
        rows[:, replicate] = drawn[: last - first + 1]
        rows[:, replicate] += 2.0 ** -(sequence.bits + 1)  # the middle of the cell, never 0
    return rows.reshape(-1, points.dimension)[start - first * replicates :][:count]


SAMPLERS = {
    "random": Sampler(_random, 1, "independent points"),
    "latin_hypercube": Sampler(
        _latin_hypercube,
        REPLICATES,
        f"{REPLICATES} hypercubes, each with one point in each of n/{REPLICATES} slices of every input",
        lambda samples: -(-samples // REPLICATES) * REPLICATES,
        f"a multiple of {REPLICATES}",
        grows=False,
    ),
    "sobol": Sampler(
        _sobol,
        REPLICATES,
        f"scrambled Sobol sequences, {REPLICATES} of them interleaved",
        lambda samples: REPLICATES * 2 ** (-(-samples // REPLICATES) - 1).bit_length(),
        f"{REPLICATES} times a power of two",
    ),
}


@dataclass(frozen=True)
class UnitPoints:
    """The points of one study in the open unit cube, `chunk` by chunk.

    `samples` is the number in all, rounded up to a legal one (then `note` says so). A latin hypercube exists
    only as a whole: with another `samples` all its points change. The first points of the other two stay the same, so
    these studies can be continued.
    """

    method: str
    dimension: int
    seed: int
    samples: int
    requested: int = field(init=False, default=0)

    def __post_init__(self):
        object.__setattr__(self, "requested", self.samples)
        object.__setattr__(self, "samples", rounded(self.method, self.samples))

    @property
    def replicates(self) -> int:
        """Independent randomisations in the design, interleaved; 1 = the points are one sample."""
        return SAMPLERS[self.method].replicates

    @property
    def note(self) -> str:
        """A sentence when the number of samples was rounded, else nothing."""
        if self.samples == self.requested:
            return ""
        return f"{self.requested} samples became {self.samples}: {self.method} needs {SAMPLERS[self.method].legal}"

    def chunk(self, start: int, count: int):
        """Points (count, dimension) from number `start` on, all inside (0, 1)."""
        return np.clip(SAMPLERS[self.method].chunk(self, start, count), LEAST_UNIT, GREATEST_UNIT)


def rounded(method: str, samples: int) -> int:
    """The least legal number of samples that is not below `samples`."""
    return SAMPLERS[method].size(samples)


def _generator(seed, part):
    """The generator of one part of a design; parts and seeds are independent of each other."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(part,))))
