"""From uncertain inputs to quantities: change of variable, moments that exist, polynomial chaos, Sobol indices."""

import math

import numpy as np
import pytest
from scipy import special, stats
from scipy.special import gammaln

from bearing_twin import run_study
from bearing_twin.base.errors import StatisticError, StudyError
from bearing_twin.contact import line as disc_impact
from bearing_twin.contact.line import line_law
from bearing_twin.uq.inputs import Joint, read_input
from bearing_twin.uq.propagation import derive, expand, tails_of
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import sensitivity_points, sobol_indices

STEEL_BALL = 0.2258  # kg, paper 3


def alpha_of(std):
    return read_input("alpha", {"distribution": "gamma", "mean": 1.138e-4, "std": std})


def duration_of_alpha(alpha, speed=20.0):
    """Paper 3, eq. (1), as it stands."""
    return alpha * speed**-0.2


def peak_of_alpha(alpha):
    """By the published invariant: peak force x contact time = 3.67909398 mu v."""
    return 3.67909398 * 0.5 * STEEL_BALL * 20.0 / duration_of_alpha(alpha)


def disc_duration(young_modulus, speed=10.0):
    return disc_impact.contact_time(line_law("line", 1.0, 2.0, young_modulus, 0.3), 2500.0 * math.pi, speed)


def a_modulus(variation, name="E"):
    return read_input(name, {"distribution": "gamma", "mean": 2.1e11, "std": variation * 2.1e11})


def test_density_and_distribution_are_those_of_equations_10_and_11_and_mirrored_where_it_falls():
    """Of F = K/alpha: P(F < m) = P(alpha > K/m), and the density is f(K/m) K/m^2."""
    source = alpha_of(4e-5)
    tau, force = derive(source, duration_of_alpha), derive(source, peak_of_alpha)
    scale, constant = 20.0**-0.2, peak_of_alpha(1.0)
    y, m = np.linspace(1e-5, 2.5e-4, 300), np.linspace(5e4, 5e5, 200)
    assert tau.pdf(y) == pytest.approx(source.pdf(y / scale) / scale, rel=1e-9)
    assert tau.cdf(y) == pytest.approx(source.cdf(y / scale), abs=1e-13)
    assert force.pdf(m) == pytest.approx(source.pdf(constant / m) * constant / m**2, rel=1e-9)
    assert force.cdf(m) == pytest.approx(source.distribution.sf(constant / m), abs=1e-12)
    for derived in (tau, force):
        assert derived.cdf(derived.quantile([0.05, 0.3, 0.95])) == pytest.approx([0.05, 0.3, 0.95], abs=1e-12)
    assert np.shape(tau.pdf(5e-5)) == np.shape(tau.cdf(5e-5)) == np.shape(tau.quantile(0.5)) == ()
    assert (tau.pdf(-1.0), tau.cdf(-1.0), tau.cdf(1.0)) == (0.0, 0.0, 1.0)


def test_discs_of_section_5_1():
    source = read_input("E", {"distribution": "gamma", "mean": 5e9, "std": 1e9})
    tau = derive(source, disc_duration)
    assert tau.mean == pytest.approx(6.5773670e-3, rel=1e-7)
    assert tau.std == pytest.approx(6.3424330e-4, rel=1e-7)
    assert not tau.rising


@pytest.mark.parametrize("variation", [0.2, 1.0, 1.11, 1.117])
def test_moments_of_the_contact_time_by_gamma_modulus(variation):
    """E[E^(-2k/5)] = scale^(-2k/5) Gamma(a - 2k/5)/Gamma(a); close to the edge of existence digits are lost."""
    tau = derive(a_modulus(variation), lambda modulus: modulus**-0.4)
    shape, scale = variation**-2, 2.1e11 * variation**2
    first, second = (
        math.exp(-0.4 * k * math.log(scale) + gammaln(shape - 0.4 * k) - gammaln(shape)) for k in (1.0, 2.0)
    )
    assert tau.mean == pytest.approx(first, rel=1e-10)
    assert tau.std == pytest.approx(math.sqrt(second - first**2), rel={1.11: 1e-7, 1.117: 1e-4}.get(variation, 1e-9))
    assert tau.tails.lower == pytest.approx(0.4 / shape, rel=1e-6)


@pytest.mark.parametrize(
    ("variation", "exist"),
    [(0.85, ("mean", "std", "skewness")), (1.1, ("mean", "std")), (1.13, ("mean",)), (1.57, ("mean",)), (1.59, ())],
)
def test_moments_that_do_not_exist_are_refused_with_the_reason(variation, exist):
    tau = derive(a_modulus(variation), lambda modulus: modulus**-0.4)
    for statistic in ("mean", "std", "skewness"):
        if statistic in exist:
            assert math.isfinite(getattr(tau, statistic))
        else:
            with pytest.raises(StatisticError, match=f"the {statistic} does not exist: towards small E"):
                getattr(tau, statistic)
    assert tau.quantile(0.5) == pytest.approx(tau.source.ppf(0.5) ** -0.4)


@pytest.mark.parametrize("power", [-3.0, -1.0, -0.4, -0.2, 0.5, 2.0])
@pytest.mark.parametrize("shape", [0.05, 1.0 / 9.0, 0.5, 1.5, 4.0])
def test_a_power_of_a_gamma_variable_has_the_moments_that_it_has(shape, power):
    """E[X^(k p)] exists where k p > -a, also where X itself underflows."""
    tails = tails_of(
        read_input("x", {"distribution": "gamma", "shape": shape, "scale": 1.0}), lambda x: x**power, strict=False
    )
    for order in (1, 2, 3):
        if abs(order * power + shape) > 1e-6:
            assert tails.has_moment(order) == (order * power > -shape), (order, tails)


BALLS = {"scene": "two_spheres", "quantities": ["contact_duration"], "samples": 64, "checks": 0, "modality": "no"}
WIDE = {"motion.first_velocity": {"distribution": "gamma", "mean": 20.0, "std": 60.0}}


@pytest.mark.parametrize("method", ["auto", "ensemble", "change_of_variable"])
@pytest.mark.parametrize("loss", [(), ("contact.restitution=0.9",)])
def test_a_mean_that_does_not_exist_is_refused_by_every_method(method, loss, quick_workers):
    """The contact time is v^-0.2 and the probability of a speed below v is v^(1/9); lognormal speeds have all means."""
    if method != "ensemble" and loss:
        return  # there is no closed form
    few = {**BALLS, "samples": 16, "set": list(loss), "method": method}
    quantities = run_study({**few, "inputs": WIDE}).as_dict()["quantities"]
    assert quantities["contact_duration"]["mean"] is None
    assert {"mean", "std", "skewness"} <= quantities["contact_duration"]["refused"].keys()
    spread = {"motion.first_velocity": {"distribution": "lognormal", "mean": 20.0, "std": 60.0}}
    quantities = run_study({**few, "inputs": spread}).as_dict()["quantities"]
    assert quantities["contact_duration"]["refused"] == {}


def test_truncated_normal_moments_reach_into_the_tail():
    tau = derive(read_input("x", {"know": {"positive": True, "mean": 1.0, "std": 0.9}}), np.exp)
    center, scale = (tau.source.parameters[name] for name in ("mean", "std"))
    truth = stats.truncnorm(-center / scale, math.inf, center, scale)
    first, second = (truth.expect(lambda x, k=k: np.exp(k * x), ub=80.0) for k in (1, 2))
    assert tau.mean == pytest.approx(first, rel=1e-9)
    assert tau.std == pytest.approx(math.sqrt(second - first**2), rel=1e-8)


@pytest.mark.parametrize(
    ("specification", "function", "message"),
    [
        ({"distribution": "normal", "mean": 0.0, "std": 1.0}, lambda x: x**2, "not a monotone function of x"),
        ({"distribution": "normal", "mean": 0.0, "std": 1.0}, lambda x: np.maximum(x, 0.0), "does not change over"),
        ({"distribution": "normal", "mean": 0.0, "std": 1.0}, lambda x: 0.0 * x, "not a monotone"),
        ({"distribution": "normal", "mean": 0.0, "std": 1.0}, lambda x: x**0.5, "not finite at x = -4"),
        ({"distribution": "empirical", "values": [1.0, 2.0]}, lambda x: x, "has no density; choose"),
    ],
)
def test_change_of_variable_says_when_it_does_not_apply(specification, function, message):
    with pytest.raises(StudyError, match=message):
        derive(read_input("x", specification), function)


def test_a_quantity_that_turns_where_no_probability_is_left_ends_there():
    """The force by eq. (14) rises again for rubber that is some thousand times softer than its mean."""

    def peak(young_modulus, speed=100.0):
        return disc_impact.peak_force(line_law("line", 1.0, 2.0, young_modulus, 0.3), 2500.0 * math.pi, speed)

    source = read_input("E", {"distribution": "gamma", "mean": 5e9, "std": 1e9})
    force = derive(source, peak)
    moduli, weights = special.roots_genlaguerre(40, 24.0)
    forces, shares = peak(2e8 * moduli), weights / weights.sum()
    assert force.mean == pytest.approx(shares @ forces, rel=1e-10)
    assert force.std == pytest.approx(math.sqrt(shares @ (forces - shares @ forces) ** 2), rel=1e-8)
    assert force.cdf(peak(source.ppf(0.05))) == pytest.approx(0.05, rel=1e-10)
    with pytest.raises(StudyError, match="not a monotone"):
        derive(read_input("x", {"distribution": "normal", "mean": 7.0, "std": 1.0}), np.square)


@pytest.mark.parametrize(
    "specification",
    [
        {"distribution": "gamma", "mean": 2.1e11, "std": 2.1e10},
        {"distribution": "uniform", "low": 1.5e11, "high": 2.5e11},
        {"distribution": "beta", "low": 1.5e11, "high": 2.5e11, "mean": 2.1e11, "std": 1e10},
    ],
)
def test_polynomial_chaos_converges_to_the_closed_form(specification):
    source = read_input("E", specification)
    exact = derive(source, lambda modulus: modulus**-0.4)
    expansions = [expand(Joint([source]), lambda values: values[:, 0] ** -0.4, degree) for degree in (1, 2, 4, 6)]
    errors = np.array([expansion.error for expansion in expansions])
    assert np.all(errors[1:] < 0.5 * errors[:-1])
    assert errors[-1] < 1e-4
    assert expansions[-1].mean == pytest.approx(exact.mean, rel=1e-9)
    assert expansions[-1].std == pytest.approx(exact.std, rel=1e-6)
    assert expansions[-1].runs == 7 + 6
    assert (expansions[-1].first, expansions[-1].total) == (pytest.approx([1.0]), pytest.approx([1.0]))


def test_polynomial_chaos_with_a_copula():
    """E[x y] of two normals with rank-bound scores, rho = 0.6: mean 1 x 2 + rho."""
    inputs = [
        read_input(key, {"distribution": "normal", "mean": mean, "std": 1.0}) for key, mean in (("x", 1.0), ("y", 2.0))
    ]
    expansion = expand(Joint(inputs, [("x", "y", 0.6)]), lambda values: values[:, 0] * values[:, 1], 2)
    assert expansion.mean == pytest.approx(2.6, rel=1e-12)
    assert expansion.std == pytest.approx(math.sqrt(1.0 + 4.0 + 4.0 * 0.6 + 1.0 + 0.36), rel=1e-9)
    assert expansion.error < 1e-10


def test_polynomial_chaos_says_when_it_is_not_smooth_or_not_possible():
    x = read_input("x", {"distribution": "normal", "mean": 0.0, "std": 1.0})
    assert expand(Joint([x]), lambda values: np.sign(values[:, 0])).error > 0.05
    with pytest.raises(StudyError, match="not finite at x ="):
        expand(Joint([x]), lambda values: np.where(values[:, 0] > 0.0, 1.0, np.nan), 3)
    inputs = [read_input(f"x{index}", {"distribution": "normal", "mean": 0.0, "std": 1.0}) for index in range(5)]
    with pytest.raises(StudyError, match="1 to 4 uncertain inputs, not 5"):
        expand(Joint(inputs), lambda values: values[:, 0])


def ishigami(values):
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 over (-pi, pi)^3, whose indices are known."""
    return np.sin(values[:, 0]) + 7.0 * np.sin(values[:, 1]) ** 2 + 0.1 * values[:, 2] ** 4 * np.sin(values[:, 0])


def an_ishigami_joint():
    uniform = {"distribution": "uniform", "low": -math.pi, "high": math.pi}
    return Joint([read_input(key, uniform) for key in ("x1", "x2", "x3")])


def test_sobol_indices_are_those_of_scipy_and_leave_failures_out():
    joint = an_ishigami_joint()
    points = sensitivity_points(joint, UnitPoints("sobol", 6, 3, 1024).chunk(0, 1024))
    values = ishigami(joint.values(points.reshape(-1, 3))).reshape(-1, 5)

    def ours(values, replicates=1):
        result = sobol_indices(values, joint.keys, replicates)
        return np.array([[result[key][order].value for key in joint.keys] for order in ("first", "total")])

    def by_scipy(values):
        a, b, *moved = values.T
        functions = {"f_A": a[None], "f_B": b[None], "f_AB": np.array(moved)[:, None]}
        result = stats.sobol_indices(func=functions, n=len(values))
        return np.array([result.first_order.ravel(), result.total_order.ravel()])

    assert ours(values) == pytest.approx(by_scipy(values), abs=1e-12)
    failed = values.copy()
    failed[512:, 2] = np.nan
    assert ours(failed, replicates=8) == pytest.approx(by_scipy(values[:512]), abs=1e-12)
    for values_refused, message in ((values[:10], "16 complete rows"), (np.ones((64, 5)), "does not vary")):
        with pytest.raises(StatisticError, match=message):
            ours(values_refused)
    with pytest.raises(StudyError, match="independent inputs"):
        sensitivity_points(Joint(joint.inputs, [("x1", "x2", 0.3)]), np.full((4, 6), 0.5))


INPUTS = {
    "first.material.young_modulus": {"distribution": "gamma", "mean": 2.1e11, "std": 4.2e10},
    "motion.first_velocity": {"distribution": "lognormal", "mean": 20.0, "std": 5.0},
    "second.radius": {"distribution": "uniform", "low": 10e-3, "high": 30e-3},
}
SETTINGS = {"chaos": {}, "ensemble": {"sampler": "sobol", "samples": 2048, "sensitivity": 2048}}


def test_polynomial_chaos_and_sampling_give_the_same_moments_and_sobol_indices():
    study = {**BALLS, "quantities": ["contact_duration", "peak_force"], "inputs": INPUTS}
    chaos, sampled = (run_study({**study, "method": method, **options}).summary for method, options in SETTINGS.items())
    for name, by_chaos in chaos["quantities"].items():
        by_sampling = sampled["quantities"][name]
        assert (by_chaos["mean"], by_chaos["std"]) == pytest.approx((by_sampling["mean"], by_sampling["std"]), rel=0.02)
        for key in INPUTS:
            for order in ("first", "total"):
                assert by_chaos["sobol"][key][order]["value"] == pytest.approx(
                    by_sampling["sobol"][key][order]["value"], abs=0.02
                )
