"""Statistics with intervals: coverage, published standard errors, quantiles, densities within their bounds."""

import functools
import itertools
import math

import numpy as np
import pytest
from scipy import stats

from bearing_twin.base.errors import StatisticError
from bearing_twin.uq.inputs import Joint, read_input
from bearing_twin.uq.propagation import derive
from bearing_twin.uq.sampling import REPLICATES, UnitPoints
from bearing_twin.uq.statistics import (
    estimate,
    histogram,
    kernel_density,
    sensitivity_points,
    sobol_indices,
)

ALPHA = read_input("alpha", {"distribution": "gamma", "mean": 1.138e-4, "std": 6e-5})
TAU = derive(ALPHA, lambda alpha: alpha * 20.0**-0.2)
TRUTH = {"mean": TAU.mean, "std": TAU.std, "skewness": TAU.skewness, **{p: TAU.quantile(p) for p in (0.05, 0.5, 0.95)}}


@functools.cache
def samples(method, seed, count):
    points = UnitPoints(method, 1, seed, count)
    return ALPHA.ppf(points.chunk(0, points.samples)[:, 0]) * 20.0**-0.2


def test_statistics_of_a_few_numbers():
    sample = [1.0, 2.0, 3.0, 4.0, 10.0, 2.0, 3.0, np.nan, 5.0]
    finite = np.array(sample)[[0, 1, 2, 3, 4, 5, 6, 8]]
    assert estimate(sample, "mean").value == np.mean(finite)
    assert estimate(sample, "std").value == pytest.approx(np.std(finite, ddof=1))
    assert estimate(sample, "skewness").value == pytest.approx(stats.skew(finite))
    assert estimate(sample, 0.5).value == pytest.approx(3.0)
    low, high = estimate(sample, "mean")[1:3]
    assert np.mean(finite) - low < high - np.mean(finite)  # the greatest of them may have greater companions
    even = np.array([1.0, 2.0, 3.0, 4.0])
    student = stats.t.interval(0.95, 3, 2.5, np.std(even, ddof=1) / 2.0)
    assert estimate(even, "mean")[1:3] == pytest.approx(student)
    assert estimate(even, "mean").half_width == pytest.approx(0.5 * (student[1] - student[0]))


def test_replicates_of_which_one_failed_whole_have_no_interval():
    values, keys = np.random.default_rng(1).normal(size=(64, 4)), ("a", "b")
    values[3::8] = np.nan
    with pytest.raises(StatisticError, match="each of the 8 replicates needs a sample at least"):
        sobol_indices(values, keys, replicates=8)
    values[3] = 0.0
    assert all(np.isfinite(orders["first"][:3]).all() for orders in sobol_indices(values, keys, replicates=8).values())


@pytest.mark.parametrize(("count", "share"), [(700, 0.0362), (2000, 0.0214)])
def test_the_deviation_has_the_published_standard_error(count, share):
    """sqrt((kurtosis - 1)/(4 n)) with kurtosis 4.668 at sigma = 6e-5: "matches after 700" is one lucky path."""
    kurtosis = 3.0 + 6.0 / (1.138 / 0.6) ** 2
    assert kurtosis == pytest.approx(4.668, abs=5e-4)
    assert math.sqrt((kurtosis - 1.0) / (4.0 * count)) == pytest.approx(share, abs=5e-5)
    deviations = [estimate(samples("random", seed, count), "std").value for seed in range(200)]
    assert np.std(deviations) / TAU.std == pytest.approx(share, rel=0.15)


def is_95_percent(covered):
    """Whether so many true ones of a list are those of 95 %, but for a chance of 1 in 1000."""
    return stats.binomtest(sum(covered), len(covered), 0.95).pvalue > 1e-3


@pytest.mark.parametrize("count", [64, 512])
@pytest.mark.parametrize(
    "truth", [stats.norm(), stats.expon(), stats.gamma(3.6), stats.lognorm(1.0)], ids=lambda truth: truth.dist.name
)
def test_intervals_of_moments_hold_the_truth(truth, count):
    """Of a deviation of lognormal points Hall's interval with n - 1 degrees of freedom holds it in 88 %."""
    every = truth.rvs(size=(400, count), random_state=count)
    for statistic, true in (("mean", truth.mean()), ("std", truth.std())):
        estimates = [estimate(sample, statistic) for sample in every]
        assert is_95_percent([interval.low <= true <= interval.high for interval in estimates]), statistic


@pytest.mark.parametrize("statistic", ["mean", "std"])
def test_intervals_of_moments_are_halls_with_the_degrees_of_freedom_that_the_skewness_leaves(statistic):
    """Of 40 independent points with failed ones among them, written out with SciPy's statistics."""
    sample, failed = np.random.default_rng(3).gamma(2.0, size=40), np.full(10, np.nan)
    deviation, z = np.std(sample, ddof=1), stats.zscore(sample)
    value, influence = {
        "mean": (np.mean(sample), sample - np.mean(sample)),
        "std": (deviation, 0.5 * deviation * (z**2 - 1.0)),
    }[statistic]
    skewness = stats.skew(influence, bias=False)
    score = stats.t.ppf(0.975, 2.0 / (2.0 / 39.0 + 1.5 * skewness**2 / 40.0)) / math.sqrt(40.0)
    ends = np.array([score, -score]) - skewness / (6.0 * 40.0)
    ends = (np.cbrt(1.0 + skewness * ends) - 1.0) / (skewness / 3.0)
    expected = [value, *(value - np.std(influence, ddof=1) * ends)]
    assert estimate(np.append(failed, sample), statistic)[:3] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_intervals_of_sobol_indices_hold_the_truth(method):
    """Of a sum of two gamma variables: 1/2 each."""
    joint = Joint([read_input(key, {"distribution": "gamma", "shape": 3.6, "scale": 1.0}) for key in "xy"])
    estimates = []
    for seed in range(200):
        design = UnitPoints(method, 4, seed, 1024)
        points = sensitivity_points(joint, design.chunk(0, 1024)).reshape(-1, 2)
        values = joint.values(points).sum(axis=1).reshape(-1, 4)
        estimates.append(sobol_indices(values, joint.keys, design.replicates)["x"])
    for order in ("first", "total"):
        assert is_95_percent([indices[order].low <= 0.5 <= indices[order].high for indices in estimates]), order


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
@pytest.mark.parametrize("count", [128, 512])
def test_intervals_from_replicates_hold_the_truth_and_are_narrow(method, count):
    """Of 16 points of a replicate less than one lies beyond a 5 % quantile, of 64 three do."""
    every = [samples(method, seed, count) for seed in range(80)]
    for statistic in ("mean", "std", 0.05, 0.5, 0.95):
        estimates = [estimate(sample, statistic, replicates=REPLICATES) for sample in every]
        assert is_95_percent([interval.low <= TRUTH[statistic] <= interval.high for interval in estimates]), statistic
        if statistic in ("mean", 0.5):
            independent = np.median([estimate(sample, statistic).half_width for sample in every])
            assert np.median([interval.half_width for interval in estimates]) < 0.5 * independent


SMALL_POWERS, HEAVY = np.array([0.08, 0.02, 0.08, 0.06]), stats.lognorm(math.sqrt(math.log1p(1.3**2)))


@pytest.mark.parametrize(
    ("method", "dimension", "count", "function", "statistic", "true"),
    [
        ("sobol", 1, 512, lambda unit: HEAVY.ppf(unit[:, 0]), "std", HEAVY.std()),
        ("latin_hypercube", 1, 512, lambda unit: unit[:, 0] ** 4, "mean", 0.2),
        (
            "latin_hypercube",
            4,
            128,
            lambda unit: np.exp(stats.norm.ppf(unit) @ SMALL_POWERS),
            "std",
            stats.lognorm(math.hypot(*SMALL_POWERS)).std(),
        ),
    ],
    ids=["few points decide", "bounded", "normal scatter"],
)
def test_intervals_from_replicates_are_neither_narrow_nor_wide(method, dimension, count, function, statistic, true):
    """They held it in 98 % of studies where replicates scatter normally and where a few points far out decide."""
    units = (UnitPoints(method, dimension, seed, count).chunk(0, count) for seed in range(800))
    estimates = [estimate(function(unit), statistic, replicates=REPLICATES) for unit in units]
    assert is_95_percent([interval.low <= true <= interval.high for interval in estimates])


def test_the_deviation_of_points_spread_evenly_has_n_in_its_denominator():
    """With n - 1 its error would be 1/(2 n) of itself, and its interval hold the truth in a quarter of all studies."""
    units = (UnitPoints("sobol", 1, seed, 1024).chunk(0, 1024)[:, 0] for seed in range(50))
    estimates = [estimate(unit, "std", replicates=REPLICATES) for unit in units]
    assert np.mean([interval.low <= 12.0**-0.5 <= interval.high for interval in estimates]) > 0.85


@pytest.mark.parametrize("probability", [0.02, 0.3, 0.95])
def test_intervals_of_quantiles_cover_and_are_open_where_samples_lack(probability):
    """Hold 95 %, whatever the number of samples: whole ranks held up to 99 %. One end alone is open at most."""
    random = np.random.default_rng(int(100 * probability))
    for count in (30, 80, 200):
        estimates = [estimate(sample, probability) for sample in random.random((1500, count))]
        covered = np.mean([interval.low <= probability <= interval.high for interval in estimates])
        assert 0.935 <= covered <= (0.965 if np.isfinite(estimates[0][1:3]).all() else 0.99)
        lacks = count * min(probability, 1.0 - probability) < 3.6  # (1 - p)^n = 2.5 %
        assert (estimates[0].half_width == math.inf) == lacks
    assert estimate(random.random(1), 0.5)[1:3] == (-math.inf, math.inf)
    assert estimate(np.arange(1.0, 101.0), 0.5)[:3] == pytest.approx((50.5, 40.72, 60.28), abs=5e-3)  # Hutson's ranks


@pytest.mark.parametrize(
    ("sample", "statistic", "replicates", "message"),
    [
        ([1.0], "mean", 1, "1 samples are too few"),
        ([np.nan] * 9, "std", 1, "0 samples are too few"),
        ([1.0] * 9, "mean", 8, "9 samples are too few"),
    ],
)
def test_statistics_of_too_few_samples_are_refused(sample, statistic, replicates, message):
    with pytest.raises(StatisticError, match=message):
        estimate(sample, statistic, replicates)


def test_the_histogram_is_a_density():
    sample = samples("random", 1, 2000)
    edges, height = histogram(sample)
    assert height @ np.diff(edges) == pytest.approx(1.0)
    assert 10 < len(height) < 100
    assert len(histogram([*range(1000), 1e9])[1]) == 400


@pytest.mark.parametrize("with_zero", [True, False])
def test_densities_keep_their_mass_inside_the_bounds(with_zero):
    """At a coefficient of variation of 1 a plain normal kernel puts 8 % of the mass below 0."""
    errors = {500: [], 8000: []}
    for count, seed in itertools.product(errors, range(5)):
        truth = stats.gamma(1.0 if with_zero else 3.0)
        sample = truth.rvs(count, random_state=seed)
        x, density = kernel_density(np.append(sample, 0.0) if with_zero else sample)
        assert x[0] > 0.0
        width = np.gradient(x)
        assert width @ density == pytest.approx(1.0, abs=1e-3)
        errors[count].append(width @ np.abs(density - truth.pdf(x)))
    assert np.mean(errors[8000]) < 0.5 * np.mean(errors[500]) < 0.07


def test_a_density_ends_at_0_where_its_sample_is_positive():
    """A positive sample has no density at 0; one that holds 0 has, and one with negative values has no bound."""
    _, density = kernel_density(samples("random", 3, 20000))
    assert density[0] < 5e-3 * density.max()
    assert kernel_density([0.0, 1.0, 2.0])[0][0] > 0.0
    assert kernel_density([-1.0, 1.0, 2.0])[0][0] < -1.0
    with pytest.raises(StatisticError, match="all samples are equal"):
        kernel_density([1.0] * 5)


@pytest.mark.parametrize("value", [0.1, -1.1e-7, 1.0 / 3.0, 1e12 + 0.3])
def test_a_sample_of_equal_values_has_no_shape_whatever_its_mean_rounds_to(value):
    """Also where the mean of equal values rounds to another in the last digit."""
    counts = [count for count in range(8, 400) if float(np.mean(np.full(count, value))) != value]
    for count in counts[:20]:
        with pytest.raises(StatisticError, match="all samples are equal"):
            estimate(np.full(count, value), "skewness")
        deviation = estimate(np.full(count, value), "std")
        assert (deviation.value, deviation.half_width, estimate(np.full(count, value), "mean").value) == (
            0.0,
            0.0,
            value,
        )
    assert len(counts) > 3
