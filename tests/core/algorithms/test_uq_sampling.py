"""Sample points: the same however they are cut, inside the cube, with the error each method promises."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.sampling import BLOCK, GREATEST_SEED, REPLICATES, SAMPLERS, UnitPoints, rounded

METHODS = sorted(SAMPLERS)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(METHODS), st.integers(1, 3), st.integers(0, GREATEST_SEED), st.data())
def test_points_do_not_depend_on_how_they_are_cut(method, dimension, seed, data):
    points = UnitPoints(method, dimension, seed, 3 * BLOCK)
    every_point = points.chunk(0, points.samples)
    start = data.draw(st.integers(0, points.samples - 1))
    count = data.draw(st.integers(1, points.samples - start))
    fresh = UnitPoints(method, dimension, seed, 3 * BLOCK)
    assert np.array_equal(fresh.chunk(start, count), every_point[start : start + count])
    assert every_point.shape == (points.samples, dimension)
    assert np.all((every_point > 0.0) & (every_point < 1.0))


@pytest.mark.parametrize("method", METHODS)
def test_seeds_differ_and_repeat(method):
    points, repeated, other_seed = (UnitPoints(method, 2, seed, 256).chunk(0, 256) for seed in (1, 1, 2))
    assert np.array_equal(points, repeated)
    assert abs(np.corrcoef(points[:, 0], other_seed[:, 0])[0, 1]) < 0.2
    assert not np.any(points == other_seed)


def test_every_replicate_of_a_latin_hypercube_has_one_point_in_each_slice():
    points = UnitPoints("latin_hypercube", 3, 4, 1000)
    every = points.chunk(0, 1000)
    for replicate in range(REPLICATES):
        for column in every[replicate::REPLICATES].T:
            assert np.array_equal(np.sort(np.floor(1000 / REPLICATES * column)), np.arange(1000 // REPLICATES))
    assert not np.any(every[0::REPLICATES] == every[1::REPLICATES])
    assert UnitPoints("latin_hypercube", 3, 4, 1001).note == (
        "1001 samples became 1008: latin_hypercube needs a multiple of 8"
    )


def test_every_replicate_of_sobol_is_a_sobol_sequence_of_its_own():
    points = UnitPoints("sobol", 2, 4, REPLICATES * 64)
    every = points.chunk(0, points.samples)
    for replicate in range(REPLICATES):
        cells = np.floor(8.0 * every[replicate::REPLICATES]).astype(int)
        # a (0, 6, 2)-net: one point in each of 64 boxes, whatever their shape
        assert len({tuple(cell) for cell in cells}) == 64
    first, second = every[0::REPLICATES], every[1::REPLICATES]
    assert not np.any(first == second)


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 10**6))
def test_sobol_rounds_up_to_a_power_of_two_and_says_so(samples):
    points = UnitPoints("sobol", 1, 0, samples)
    share = points.samples // REPLICATES
    assert points.samples == rounded("sobol", samples) == REPLICATES * share
    assert share & (share - 1) == 0
    assert samples <= points.samples < max(2 * samples, REPLICATES + 1)
    change = f"{samples} samples became {points.samples}"
    assert points.note.startswith(change) if samples != points.samples else points.note == ""
    assert UnitPoints("random", 1, 0, samples).samples == samples


def test_sobol_needs_far_fewer_points_than_random_for_the_mean_contact_time():
    """Mean of tau ~ alpha to 1e-4 of itself, alpha gamma distributed (paper 3, section 4), over 20 seeds each."""
    alpha = read_input("alpha", {"distribution": "gamma", "mean": 1.138e-4, "std": 2e-5})

    def errors(method, samples):
        means = [np.mean(alpha.ppf(UnitPoints(method, 1, seed, samples).chunk(0, samples)[:, 0])) for seed in range(20)]
        return math.sqrt(np.mean((np.array(means) / alpha.mean - 1.0) ** 2))

    sobol = errors("sobol", 4096)
    assert sobol < 1e-4
    random = errors("random", 16 * 4096)
    assert random > 3.5 * sobol
    # rates: n^-1 or better against n^-1/2
    assert errors("sobol", 256) / sobol > 10.0
    assert 1.5 < errors("random", 4096) / random < 8.0
    assert errors("latin_hypercube", 4096) < 1e-4
