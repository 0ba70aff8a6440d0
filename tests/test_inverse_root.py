"""The inverse root of few multiplications, against NumPy's with more digits."""

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.numerics.inverse_root import inverse_root


@kernel
def fill(squares, found):
    for i in range(len(squares)):
        found[i] = inverse_root(squares[i])


def test_the_inverse_root_is_as_close_as_stated():
    """Over two octaves of the start, after which it repeats, and over all sizes."""
    rng = np.random.default_rng(1)
    squares = np.concatenate([np.linspace(1.0, 4.0, 200_001), 10.0 ** rng.uniform(-300.0, 300.0, 100_000)])
    found = np.empty_like(squares)
    fill(squares, found)
    off = found * np.sqrt(squares.astype(np.longdouble)) - 1.0
    assert 2e-13 < np.abs(off).max() < 3e-13
    assert abs(off.max() + off.min()) < 5e-15


def test_of_zero_it_is_large_and_finite():
    assert 1e150 < inverse_root(0.0) < 1e200
