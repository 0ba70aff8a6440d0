"""Quantiles of a gamma variable from a table against those of SciPy, all the way out."""

import numpy as np
import pytest

from bearing_twin.uq.inputs import GREATEST_UNIT, LEAST_UNIT, Joint, read_input

TAILS = 2.0 ** -np.arange(1.0, 55.0)
UNIT = np.concatenate([TAILS, 1.0 - TAILS[:-1], [LEAST_UNIT, GREATEST_UNIT], np.random.default_rng(3).random(20_000)])


@pytest.mark.parametrize("shape", [8.1, 0.3, 300.0, 0.02, 1e6])  # the last two have no table
def test_samples_are_the_quantiles_to_ten_digits_and_rise(shape):
    joint = Joint([read_input("x", {"distribution": "gamma", "shape": shape, "scale": 1.4e-5})])
    values = joint.values(UNIT[:, None])[:, 0]
    np.testing.assert_allclose(values, joint.inputs[0].ppf(UNIT), rtol=2e-11)
    assert np.all(np.diff(values[np.argsort(UNIT)]) >= 0.0)
    assert joint.values(UNIT[7:8, None])[0, 0] == values[7]
