"""Every distribution of an input against SciPy or its closed form, and what makes none; hostile study files."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import cumulative_trapezoid

from bearing_twin import load_study, parse_study, read_study, run_study, write_study
from bearing_twin.base.errors import BearingTwinError, StudyError
from bearing_twin.uq.distributions import DISTRIBUTIONS
from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.propagation import derive

CASES = {  # how a study gives a distribution, and the same by SciPy
    "normal": ({"mean": -3.0, "std": 2.0}, stats.norm(-3.0, 2.0)),
    "uniform": ({"low": 0.1, "high": 0.4}, stats.uniform(0.1, 0.3)),
    "exponential": ({"mean": 7.0}, stats.expon(scale=7.0)),
    "weibull": ({"shape": 1.7, "scale": 3.0}, stats.weibull_min(1.7, scale=3.0)),
    "triangular": ({"low": 1.0, "mode": 1.5, "high": 4.0}, stats.triang(1.0 / 6.0, loc=1.0, scale=3.0)),
    "gamma": ({"mean": "2.0", "std": 1.0}, stats.gamma(4.0, scale=0.5)),
    "gamma by shape": ({"shape": 4.0, "scale": 0.5}, stats.gamma(4.0, scale=0.5)),
    "lognormal": ({"mean_log": 0.5, "std_log": 0.3}, stats.lognorm(0.3, scale=math.exp(0.5))),
    "lognormal by mean": (
        {"mean": 1.0, "std": 0.5}, stats.lognorm(math.log(1.25) ** 0.5, scale=math.exp(-0.5 * math.log(1.25)))),
    "beta": ({"low": 1.0, "high": 3.0, "a": 2.0, "b": 5.0}, stats.beta(2.0, 5.0, loc=1.0, scale=2.0)),
    "beta by mean": (
        {"low": 1.0, "high": 3.0, "mean": 2.0, "std": math.sqrt(0.2)}, stats.beta(2.0, 2.0, loc=1.0, scale=2.0)),
    "truncated_normal": ({"mean": 1.0, "std": 2.0, "low": 0.0}, stats.truncnorm(-0.5, np.inf, loc=1.0, scale=2.0)),
    "truncated_exponential": (
        {"low": 0.0, "high": 3.0, "mean": 3.0 / math.expm1(3.0) * (math.exp(3.0) - 4.0) / 3.0},
        stats.truncexpon(3.0),
    ),
    "scipy.genextreme": ({"c": -0.1, "loc": 1.0, "scale": 2.0}, stats.genextreme(-0.1, loc=1.0, scale=2.0)),
    "scipy.pareto": ({"b": 3.5}, stats.pareto(3.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_distribution_is_that_of_scipy(name):
    parameters, reference = CASES[name]
    source = read_input("x", {"distribution": name.partition(" ")[0], **parameters})
    u = np.array([1e-9, 1e-4, 0.02, 0.3, 0.5, 0.77, 0.999])
    x = source.ppf(u)
    assert source.cdf(x) == pytest.approx(u, rel=1e-8)
    assert source.at_score(stats.norm.ppf(u)) == pytest.approx(x, rel=1e-7)
    assert x == pytest.approx(reference.ppf(u), rel=1e-9)
    assert source.isf(u[2:]) == pytest.approx(reference.isf(u[2:]), rel=1e-9)
    assert source.pdf(x) == pytest.approx(reference.pdf(x), rel=1e-9)
    assert (source.mean, source.std) == pytest.approx((reference.mean(), reference.std()), rel=1e-9)


@pytest.mark.parametrize(
    "values",
    [
        {"distribution": "empirical", "values": [3.0, 1.0, 2.0, 2.0]},
        {"distribution": "discrete", "values": [3.0, 1.0, 2.0], "weights": [1, 1, 2]},
    ],
)
def test_values_are_taken_as_often_as_they_are_given(values):
    source = read_input("x", values)
    assert (source.mean, source.std) == (2.0, math.sqrt(0.5))
    assert source.cdf([0.9, 1.0, 2.0, 3.0]).tolist() == [0.0, 0.25, 0.75, 1.0]
    assert source.ppf([1e-9, 0.25, 0.2501, 0.75, 0.7501, 1.0]).tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]


def test_a_table_is_a_density_of_straight_lines():
    table = {"x": [0.0, 1.0, 1.5, 4.0], "density": [0.5, 2.0, 1.0, 0.5]}
    source, x = read_input("x", {"distribution": "table", **table}), np.linspace(0.0, 4.0, 4001)
    density = np.interp(x, *table.values())
    density /= np.trapezoid(density, x)
    assert source.pdf(x[1:-1]) == pytest.approx(density[1:-1], rel=1e-3)
    assert source.cdf(x) == pytest.approx(cumulative_trapezoid(density, x, initial=0.0), abs=1e-6)
    mean = np.trapezoid(x * density, x)
    assert (source.mean, source.std**2) == pytest.approx((mean, np.trapezoid((x - mean) ** 2 * density, x)), rel=1e-5)


def test_a_truncated_gamma_is_a_gamma_between_its_bounds():
    source = read_input("x", {"distribution": "truncated_gamma", "mean": 2.0, "std": 1.0, "low": 0.5, "high": 4.0})
    x, gamma = source.ppf(np.linspace(0.01, 0.99, 9)), stats.gamma(4.0, scale=0.5)
    assert source.pdf(x) == pytest.approx(gamma.pdf(x) / (gamma.cdf(4.0) - gamma.cdf(0.5)), rel=1e-12)
    assert 0.5 < x[0] < x[-1] < 4.0


BALLS = {"scene": "two_spheres", "quantities": ["contact_duration", "peak_force"], "samples": 64, "checks": 0}
RADIUS = "first.radius"


@pytest.mark.parametrize(
    "frozen",
    [stats.weibull_min(40.0, scale=0.019), stats.gamma(a=900.0, scale=2e-5), stats.norm(0.019, 1e-4)],
)
def test_a_frozen_distribution_of_scipy_is_an_input_and_is_read_again(frozen, tmp_path):
    result = run_study({**BALLS, "inputs": {RADIUS: frozen, "second.radius": {"distribution": frozen}}})
    assert stats.kstest(result.values[:, 0], frozen.cdf).pvalue > 1e-4
    json.dumps(result.study.resolved())
    again = read_study(write_study(result, tmp_path / "study.mcap"))
    assert np.array_equal(again.values, result.values)
    assert run_study(again.study).summary["quantities"] == result.summary["quantities"]


def test_whole_numbers_take_a_discrete_distribution_of_scipy():
    study = load_study(
        {"scene": "bearing_6203", "quantities": ["cage_speed"], "inputs": {"geometry.balls": stats.randint(7, 9)}}
    )
    assert set(study.joint.values(np.linspace(0.01, 0.99, 30)[:, None])[:, 0]) == {7.0, 8.0}


def test_a_table_of_realisations_is_written_once(tmp_path):
    uniform = {RADIUS: {"distribution": "uniform", "low": 0.01, "high": 0.02}}
    result = run_study({**BALLS, "method": "ensemble", "inputs": uniform})
    assert (result.values.shape, result.quantities.shape) == ((64, 1), (64, 2))
    lines = result.to_csv(tmp_path / "all.csv").read_text().splitlines()
    assert lines[0] == "first.radius [m],contact_duration [s],peak_force [N],failed"
    read = np.array([line.split(",")[:3] for line in lines[1:]], float)
    assert np.array_equal(read, np.hstack((result.values, result.quantities)))
    assert result.columns()["peak_force"].tolist() == result.quantities[:, 1].tolist()
    with pytest.raises(StudyError, match="not overwritten"):
        result.to_csv(tmp_path / "all.csv")


def test_a_normal_is_taken_where_next_to_nothing_lies_outside():
    """190 deviations above 0 were refused."""
    for share, taken in ((1.0 / 190.0, True), (1.0 / 8.0, True), (1.0 / 6.5, False)):
        study = {**BALLS, "inputs": {RADIUS: {"distribution": "normal", "mean": 0.019, "std": 0.019 * share}}}
        if taken:
            assert run_study({**study, "samples": 32}).as_dict()["failed"] == {}
        else:
            with pytest.raises(StudyError, match="lies outside"):
                load_study(study)


CORRELATED = {RADIUS: {"distribution": "uniform", "low": 0.01, "high": 0.02},
              "second.radius": {"distribution": "uniform", "low": 0.01, "high": 0.02}}  # fmt: skip
BAD = {
    "correlation given twice": (
        {"correlation": [[RADIUS, "second.radius", 0.5], ["second.radius", RADIUS, -0.5]]}, "twice"),
    "a key twice in set": ({"set": ["motion.first_velocity=1", "motion.first_velocity=2"]}, "twice"),
    "weights that lack one": (
        {RADIUS: {"distribution": "discrete", "values": [0.01, 0.02], "weights": [1]}}, "one each"),
    "weights of nothing": ({RADIUS: {"distribution": "discrete", "values": [0.01], "weights": [0]}}, "above 0"),
    "a density below 0": ({RADIUS: {"distribution": "table", "x": [0.01, 0.02], "density": [1, -1]}}, "0 or above"),
    "places that fall": ({RADIUS: {"distribution": "table", "x": [0.02, 0.01], "density": [1, 1]}}, "must rise"),
    "one point": ({RADIUS: {"distribution": "table", "x": [0.02], "density": [1]}}, "two points"),
    "a mode outside": ({RADIUS: {"distribution": "triangular", "low": 1, "mode": 3, "high": 2}}, "mode between"),
    "a gamma cut to nothing": (
        {RADIUS: {"distribution": "truncated_gamma", "mean": 1, "std": 0.01, "low": 3}}, "between the bounds"),
    "no distribution of SciPy": ({RADIUS: {"distribution": "scipy.system", "loc": 1}}, "has no distribution"),
    "a parameter SciPy lacks": ({RADIUS: {"distribution": "scipy.norm", "mean": 1}}, "legal: loc, scale"),
    "a shape that lacks": ({RADIUS: {"distribution": "scipy.gamma", "scale": 1}}, "needs a"),
    "a shape out of range": ({RADIUS: {"distribution": "scipy.gamma", "a": -1, "scale": 1}}, "input first.radius"),
    "no mean at all": ({RADIUS: {"distribution": "scipy.cauchy"}}, "no finite mean"),
    "a frozen table": ({RADIUS: stats.rv_histogram(([1.0, 2.0], [0.1, 0.2, 0.3])).freeze()}, "give others as a table"),
    "parameters in lists": ({RADIUS: stats.gamma([1.0, 2.0])}, "single numbers"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_study_that_cannot_be_is_refused_in_a_sentence(name):
    changes, message = BAD[name]
    inputs = {key: value for key, value in changes.items() if key == RADIUS}
    others = {key: value for key, value in changes.items() if key != RADIUS}
    with pytest.raises(StudyError) as caught:
        load_study({**BALLS, "inputs": CORRELATED | inputs, **others})
    assert message in str(caught.value)
    assert "Traceback" not in str(caught.value)


NUMBERS = st.one_of(st.floats(), st.integers(-3, 3), st.sampled_from(["1e-2", "nan", "", None, True, [], {}, "0.019"]))
WORDS = st.sampled_from([
    "distribution", "mean", "std", "low", "high", "shape", "scale", "values", "weights", "x", "density", "know", "also",
    "positive", "a", "b", "mode", "loc", "c",
])  # fmt: skip
NAMES = st.sampled_from([*DISTRIBUTIONS, "scipy.pareto", "scipy.", "scipy.norm", "scipy.rv_histogram", "", 3])
INPUTS = st.one_of(
    NUMBERS,
    st.builds(
        lambda name, more: {"distribution": name, **more},
        NAMES,
        st.dictionaries(WORDS, st.one_of(NUMBERS, st.lists(NUMBERS, max_size=3)), max_size=4),
    ),
    st.dictionaries(WORDS, st.one_of(NUMBERS, st.dictionaries(WORDS, NUMBERS, max_size=3)), max_size=3),
)
KEYS = st.sampled_from(["correlation", "samples", "sampler", "sweep", "stop", "histories", "set", "seed"])
REST = st.dictionaries(
    KEYS, st.one_of(NUMBERS, st.lists(st.one_of(NUMBERS, st.lists(NUMBERS, max_size=3)), max_size=3)), max_size=2
)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=100, deadline=None)
@given(INPUTS, REST)
def test_whatever_a_study_file_holds_it_is_a_study_or_refused_in_a_sentence(specification, further_keys):
    """One that is taken says the same of itself when it is read again."""
    try:
        study = load_study({**BALLS, "inputs": {RADIUS: specification}, **further_keys})
    except BearingTwinError:
        return
    assert parse_study(study.resolved(), "again").resolved() == study.resolved()
    values = study.joint.values(np.linspace(0.01, 0.99, 5)[:, None] * np.ones((1, study.joint.dimension)))
    assert np.isfinite(values).all()


@pytest.mark.parametrize("std", [1e-3, 1e-5, 1e-7])
def test_a_narrow_gamma_input_has_moments(std):
    """SciPy's lower tail is wrong beyond 4.5 deviations where the shape is above 1e7."""
    source = read_input("x", {"distribution": "gamma", "mean": 1.0, "std": std})
    square = derive(source, lambda x: x**2)
    assert (square.mean, square.std) == pytest.approx((1.0 + std**2, 2.0 * std), rel=1e-5)


def test_weights_and_densities_need_no_size():
    for size in (1e-320, 1e308):
        source = read_input("x", {"distribution": "discrete", "values": [1.0, 2.0], "weights": [size, size]})
        assert source.mean == 1.5
        source = read_input("x", {"distribution": "table", "x": [1.0, 2.0], "density": [size, size]})
        assert source.mean == pytest.approx(1.5)


@pytest.mark.parametrize(
    "specification", [{"name": "kstwo", "n": 10.0}, {"name": "studentized_range", "k": 3.0, "df": 10.0}]
)
def test_distributions_that_take_minutes_are_refused_at_once(specification):
    with pytest.raises(StudyError, match="takes minutes"):
        read_input("x", {"distribution": f"scipy.{specification.pop('name')}", **specification})


@pytest.mark.parametrize(
    ("specification", "modes"),
    [
        ({"distribution": "beta", "low": 0.019, "high": 0.0191, "mean": 0.01905, "std": 1e-9}, 1),
        ({"distribution": "uniform", "low": 0.019, "high": 0.0190001}, 1),
        ({"distribution": "table", "x": [0.019, 0.01901, 0.01902, 0.01903], "density": [0, 3, 1, 2]}, 2),
    ],
)
def test_rounding_makes_no_modes_of_the_density_of_a_narrow_input(specification, modes):
    duration = run_study(load_study({**BALLS, "inputs": {RADIUS: specification}})).as_dict()["quantities"][
        "contact_duration"
    ]
    assert duration["modality"] == {"modes": modes, "p_value": None}
