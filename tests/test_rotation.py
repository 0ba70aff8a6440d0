"""Quaternions against SciPy, and the order of the orientation step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bearing_twin.numerics.rotation import (
    about_z,
    cross,
    dot,
    quaternion_from_vector,
    quaternion_product,
    rotation_matrix,
    turned,
)

VECTOR = st.tuples(*[st.floats(-5.0, 5.0)] * 3)


@given(VECTOR, VECTOR)
def test_products_agree_with_scipy(a, b):
    p, q = Rotation.from_rotvec(a), Rotation.from_rotvec(b)
    mine = quaternion_product(quaternion_from_vector(a), quaternion_from_vector(b))
    assert rotation_matrix(mine) == pytest.approx((p * q).as_matrix(), abs=1e-12)
    assert np.allclose(cross(a, b), np.cross(a, b))
    assert dot(a, b) == pytest.approx(np.dot(a, b), abs=1e-12)


def test_small_angles_keep_their_precision():
    assert quaternion_from_vector((2e-9, 0.0, 0.0)) == pytest.approx((1e-9, 0.0, 0.0, 1.0), rel=1e-15)


def test_about_z_turns_counter_clockwise():
    assert about_z(0.0, 1.0, (1.0, 0.0, 3.0)) == (0.0, 1.0, 3.0)


def test_orientation_step_is_of_fourth_order_and_keeps_unit_norm():
    def omega(t):
        return (30.0 * np.cos(9.0 * t), 20.0 * np.sin(7.0 * t), 25.0 + 5.0 * t)

    def end(steps):
        q, h = (0.0, 0.0, 0.0, 1.0), 0.5 / steps
        for i in range(steps):
            q = turned(q, omega(i * h), omega((i + 0.5) * h), omega((i + 1) * h), h)
        assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
        return np.array(q)

    exact = end(4096)
    errors = [np.linalg.norm(end(n) - exact) for n in (64, 128, 256)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(4.0, abs=0.15)
