"""Uncertain inputs: distributions by parameters and by knowledge, refusals, and the Gaussian copula."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import digamma

from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.uq.distributions import DISTRIBUTIONS, LEAST_SPREAD, PLENTY, greatest_entropy
from bearing_twin.uq.inputs import GREATEST_UNIT, LEAST_UNIT, Joint, read_input

SCORES, WEIGHTS = (8.0 * one for one in np.polynomial.legendre.leggauss(200))
WEIGHTS = WEIGHTS * stats.norm.pdf(SCORES)


def moments(source):
    """Mean and deviation of what is sampled, by quadrature in the normal score."""
    x = source.at_score(SCORES)
    mean = WEIGHTS @ x
    return mean, math.sqrt(WEIGHTS @ (x - mean) ** 2)


@settings(max_examples=30, deadline=None)
@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3), st.sampled_from(["uniform", "truncated_normal", "beta"]))
def test_no_value_steps_over_a_bound_by_rounding(low, width, name):
    parameters = {"uniform": {}, "truncated_normal": {"mean": low, "std": 0.1 * width}, "beta": {"a": 0.5, "b": 0.5}}[
        name
    ]
    source = read_input("x", {"distribution": name, "low": low, "high": low + width, **parameters})
    ends = source.ppf(np.array([LEAST_UNIT, GREATEST_UNIT]))
    assert (source.low, source.high) == (low, low + width)
    assert low <= ends[0] < ends[1] <= low + width


@settings(max_examples=10, deadline=None)
@given(st.floats(1e-3, 0.995), st.sampled_from([1.0, 1e-12, 3e11]))
def test_positive_with_mean_and_deviation_is_a_truncated_normal(variation, mean):
    source = read_input("x", {"know": {"positive": True, "mean": mean, "std": variation * mean}})
    assert source.distribution_name == "truncated_normal"
    assert source.low == 0.0
    assert moments(source) == pytest.approx((mean, variation * mean), rel=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.02, 0.98), st.floats(0.01, 0.95))
@example(0.98, 0.1171875)
def test_bounds_with_mean_and_deviation_are_a_truncated_normal(share, part):
    """Up to the deviation of the truncated exponential, beyond which the density would rise towards the bounds."""
    exponential = read_input("x", {"know": {"low": 0.0, "high": 0.5, "mean": 0.5 * share}})
    std = part * exponential.std
    if 0.5 * LEAST_SPREAD >= std >= 0.5 * min(share, 1.0 - share) / PLENTY:
        with pytest.raises(StudyError, match="one of them says nothing"):
            read_input("x", {"know": {"low": 0.0, "high": 0.5, "mean": 0.5 * share, "std": std}})
        return
    source = read_input("x", {"know": {"low": 0.0, "high": 0.5, "mean": 0.5 * share, "std": std}})
    assert source.distribution_name == "truncated_normal"
    assert (source.low, source.high) == (0.0, 0.5)
    assert moments(source) == pytest.approx((0.5 * share, std), rel=1e-8)
    with pytest.raises(StudyError, match=r"smaller std|so great a std"):
        read_input("x", {"know": {"low": 0.0, "high": 0.5, "mean": 0.5 * share, "std": 1.02 * exponential.std}})


@settings(max_examples=20, deadline=None)
@given(st.floats(1e-3, 1e5), st.sampled_from([1.0, 1e-4, 2.1e11]))
def test_positive_with_mean_and_mean_log_is_the_gamma_distribution(shape, mean):
    mean_log = digamma(shape) + math.log(mean / shape)
    name, parameters = greatest_entropy({"positive": True, "mean": mean, "mean_log": mean_log})
    assert name == "gamma"
    assert parameters["shape"] * parameters["scale"] == pytest.approx(mean, rel=1e-12)
    log_mean = digamma(parameters["shape"]) + math.log(parameters["scale"])
    assert log_mean == pytest.approx(mean_log, abs=1e-10)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.004, 0.996))
def test_bounds_with_a_mean_are_a_truncated_exponential(share):
    source = read_input("x", {"know": {"low": -2.0, "high": 3.0, "mean": -2.0 + 5.0 * share}})
    assert source.distribution_name == ("uniform" if share == 0.5 else "truncated_exponential")
    assert source.mean == pytest.approx(-2.0 + 5.0 * share, abs=1e-9)
    assert moments(source) == pytest.approx((source.mean, source.std), rel=1e-8, abs=1e-9)
    if source.distribution_name != "uniform":  # its density is exponential
        assert np.diff(np.log(source.pdf(np.linspace(-1.9, 2.9, 5))), 2) == pytest.approx(0.0, abs=1e-9)


def test_knowledge_is_named_rightly():
    for known, name in (
        ({"low": 0.0, "high": 0.5}, "uniform"),
        ({"low": 0.0, "high": 0.5, "mean": 0.25}, "uniform"),
        ({"mean": 1.0, "std": 0.1}, "normal"),
        ({"positive": False, "mean": 1.0, "std": 0.1}, "normal"),
        ({"positive": True, "mean": 3.0}, "exponential"),
        ({"positive": True, "mean": 3.0, "std": 3.0}, "exponential"),
        ({"positive": True, "mean_log": 0.0, "std_log": 0.2}, "lognormal"),
    ):
        source = read_input("x", {"know": known})
        assert (source.distribution_name, source.stated) == (name, "knowledge")
        assert "greatest entropy" in source.describe()


def test_greatest_entropy_beats_the_gamma_distribution_of_the_same_mean_and_deviation():
    """What paper 3 takes for the distribution of greatest entropy has less than the truncated normal."""
    for variation in (0.1, 0.5, 0.9):
        known = read_input("x", {"know": {"positive": True, "mean": 1.0, "std": variation}})
        gamma = read_input("x", {"distribution": "gamma", "mean": 1.0, "std": variation})
        entropy = [-WEIGHTS @ np.log(one.pdf(one.at_score(SCORES))) for one in (known, gamma)]
        assert entropy[0] > entropy[1] + 1e-4


@pytest.mark.parametrize(
    ("specification", "message"),
    [
        ({"distribution": "gama", "mean": 1.0, "std": 1.0}, "did you mean gamma?"),
        ({"distribution": "gamma", "mean": 1.0, "sdt": 1.0}, "did you mean std?"),
        ({"distribution": "gamma", "mean": 1.0, "std": 0.1, "shape": 3.0}, "takes mean, std or shape"),
        ({"distribution": "gamma", "mean": -1.0, "std": 0.1}, "mean of a gamma distribution is above 0"),
        ({"distribution": "normal", "mean": math.nan, "std": 0.1}, "mean = nan is not finite"),
        ({"distribution": "uniform", "low": 2.0, "high": 1.0}, "low must be below high"),
        ({"distribution": "beta", "low": 0.0, "high": 1.0, "mean": 0.5, "std": 0.6}, "so great a std"),
        ({"distribution": "truncated_normal", "mean": 0.0, "std": 1.0, "low": 50.0}, "nothing is left"),
        ({"distribution": "truncated_exponential", "low": 0.0, "high": 1.0, "mean": 2.0}, "between low and high"),
        ({"distribution": "empirical", "values": []}, "one number at least"),
        ({"distribution": "empirical", "values": [1.0, math.inf]}, "values = inf is not finite"),
        ({"mean": 1.0, "std": 1.0}, "give distribution"),
        ({"know": {"mean": 1.0, "deviation": 1.0}}, "'deviation' is no fact"),
        ({"know": {"positive": True}}, "state one of these"),
        ({"know": {"positive": "yes", "mean": 1.0}}, "true or false"),
        ({"know": {"positive": True, "mean": 1.0, "std": 1.5}}, "no distribution of greatest entropy exists"),
        ({"know": {"positive": True, "mean": 1.0, "std": 0.9995}}, "state the mean alone"),
        ({"know": {"positive": True, "mean": 1.0, "mean_log": 0.1}}, "must be below ln(mean)"),
        ({"know": {"positive": True, "mean": -1.0, "mean_log": 0.1}}, "is above 0"),
        ({"know": {"low": 0.0, "high": 1.0, "mean": 1.0}}, "must lie between"),
        ({"know": {"low": 0.0, "high": 1.0, "mean": 0.01, "std": 0.002}}, "one of them says nothing"),
        ({"know": {"mean": 1.0, "std": 0.0}}, "is fixed"),
        ({"know": {"mean": 1.0, "std": 1.0}, "std": 2.0}, "does not go with know"),
        ({"know": 3.0}, "must hold keys and values"),
    ],
)
def test_bad_inputs_are_refused_with_one_sentence(specification, message):
    with pytest.raises(StudyError) as caught:
        read_input("first.radius", specification)
    assert message in str(caught.value)
    assert str(caught.value).startswith("input first.radius: ")
    assert "\n" not in str(caught.value)


def test_a_number_is_a_fixed_input_and_has_no_density():
    source = read_input("first.radius", "1.5e-2")
    assert (source.distribution_name, source.mean, source.std, source.has_density) == ("fixed", 0.015, 0.0, False)
    with pytest.raises(StatisticError, match="no density"):
        source.pdf(0.015)


def a_normal(key):
    return read_input(key, {"distribution": "normal", "mean": -3.0, "std": 2.0})


@settings(max_examples=5, deadline=None)
@given(st.floats(-0.95, 0.95))
def test_the_copula_has_its_rank_correlation_and_leaves_the_inputs_alone(rho):
    gamma = read_input("first.radius", {"distribution": "gamma", "mean": 1.138e-4, "std": 2e-5})
    joint = Joint([gamma, a_normal("other")], [("first.radius", "other", rho)])
    unit = np.random.default_rng(5).random((20000, 2))
    values = joint.values(unit)
    ranks = stats.spearmanr(values).statistic
    assert ranks == pytest.approx(6.0 / math.pi * math.asin(0.5 * rho), abs=0.03)
    for source, column in zip(joint.inputs, values.T, strict=True):
        assert stats.kstest(column, source.cdf).pvalue > 1e-7
    assert np.array_equal(values[:100], joint.values(unit[:100]))


@pytest.mark.parametrize(
    ("correlation", "message"),
    [
        ([("a", "b", 0.9), ("b", "c", 0.9), ("a", "c", -0.9)], "not positive definite"),
        ([("a", "z", 0.9)], "'z' is no input; legal: a, b, c"),
        ([("a", "b", 1.0)], "out of range"),
        ([("a", "b", math.nan)], "not finite"),
        ([("a", "a", 0.5)], "two different inputs"),
        ([("a", "b", 0.5), ("b", "a", 0.5)], "given twice"),
    ],
)
def test_correlations_that_cannot_be_are_refused(correlation, message):
    with pytest.raises(StudyError, match=message):
        Joint([a_normal(key) for key in "abc"], correlation)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", sorted(set(DISTRIBUTIONS) - {"empirical", "discrete", "fixed", "table"}))
def test_numbers_that_no_double_holds_are_refused_in_a_sentence(name):
    extremes = (5e-324, 1.0, 3.0, 1e308)
    reported, means = [], []
    for form in DISTRIBUTIONS[name].forms:
        for values in itertools.product(extremes[:: max(1, len(form) - 2)], repeat=len(form)):
            try:
                source = read_input("run.duration", {"distribution": name, **dict(zip(form, values, strict=True))})
                means += [source.mean, source.std]
            except StudyError as error:
                reported.append(str(error))
    assert means
    assert np.isfinite(means).all()
    assert reported
    assert all(source.startswith("input run.duration: ") for source in reported)
