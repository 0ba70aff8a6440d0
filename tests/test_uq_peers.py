"""Studies against chaospy, a library written by others: moments, Sobol indices, correlated inputs.

chaospy draws and expands; the contact time of two spheres is Hertz' closed form, written out here once more.
"""

import math

import chaospy
import numpy as np
import pytest

from bearing_twin import parse_study, run_study
from bearing_twin.uq.inputs import Joint, read_input

MODULUS, SPEED, RADIUS = "first.material.young_modulus", "motion.first_velocity", "second.radius"
INPUTS = {
    MODULUS: {"distribution": "gamma", "mean": 2.1e11, "std": 4.2e10},
    SPEED: {"distribution": "lognormal", "mean": 20.0, "std": 5.0},
    RADIUS: {"distribution": "uniform", "low": 10e-3, "high": 30e-3},
}
THEIRS = {
    MODULUS: chaospy.Gamma(25.0, 2.1e11 / 25.0),
    SPEED: chaospy.LogNormal(math.log(20.0 / 1.0625**0.5), math.log(1.0625) ** 0.5),
    RADIUS: chaospy.Uniform(10e-3, 30e-3),
}
QUANTITIES = ("contact_duration", "peak_force")


def contact(modulus, speed, radius):
    """Contact time [s] and peak force [N] of two spheres by Hertz, the second one with the modulus of its scene."""
    stiffness = 4.0 / 3.0 / (0.91 / modulus + 0.91 / 2.1e11) * np.sqrt(1.0 / (1.0 / 19.05e-3 + 1.0 / radius))
    approach = (1.25 * 0.5 * 0.2258 * speed**2 / stiffness) ** 0.4
    shape = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
    return shape * approach / speed, stiffness * approach**1.5


def summary(**changes):
    mapping = {"scene": "two_spheres", "inputs": INPUTS, "quantities": list(QUANTITIES), "modality": "no", **changes}
    return run_study(parse_study(mapping, "peers")).summary["quantities"]


def test_correlated_inputs_follow_their_copula():
    correlation = np.array([[1.0, 0.6], [0.6, 1.0]])
    keys = (MODULUS, RADIUS)
    joint = Joint([read_input(key, INPUTS[key]) for key in keys], [(*keys, 0.6)])
    theirs = chaospy.Nataf(chaospy.J(*(THEIRS[key] for key in keys)), correlation)
    unit = np.random.default_rng(1).random((200, 2))
    assert joint.values(unit) == pytest.approx(np.asarray(theirs.inv(unit.T)).T, rel=1e-6)


SETTINGS = {"chaos": {}, "ensemble": {"sampler": "sobol", "samples": 2048, "sensitivity": 2048}}


@pytest.fixture(scope="module")
def expanded():
    """Mean, deviation, and first-order and total indices of each quantity, by their expansion."""
    joint, found = chaospy.J(*THEIRS.values()), {}
    nodes, weights = chaospy.generate_quadrature(6, joint, rule="gaussian")
    basis = chaospy.generate_expansion(4, joint, normed=True)
    for name, values in zip(QUANTITIES, contact(*nodes), strict=True):
        scale = float(np.mean(values))
        theirs, shares = chaospy.fit_quadrature(basis, nodes, weights, values / scale, retall=1)
        moments = scale * float(chaospy.E(theirs, joint)), scale * float(chaospy.Std(theirs, joint))
        found[name] = *moments, chaospy.FirstOrderSobol(basis, shares), chaospy.TotalOrderSobol(basis, shares)
    return found


@pytest.mark.parametrize("method", SETTINGS)
def test_moments_and_sobol_indices_are_those_of_their_expansion(method, expanded):
    found, near = summary(method=method, **SETTINGS[method]), 1e-4 if method == "chaos" else 0.02
    for name, (mean, std, first, total) in expanded.items():
        mine = found[name]
        assert mine["mean"] == pytest.approx(mean, rel=near)
        assert mine["std"] == pytest.approx(std, rel=near)
        for kind, indices in (("first", first), ("total", total)):
            got = [mine["sobol"][key][kind]["value"] for key in THEIRS]
            assert got == pytest.approx(list(indices), abs=near)
