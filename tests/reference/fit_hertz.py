"""Fits the rational form of the law `hertz`; run as `python tests/reference/fit_hertz.py`.

With g = sqrt(PQ) and u = (P + Q - 2g)/(P + Q + 2g) in [0, 1) the exact load is E* h^(3/2) g^(-1/2) R(u), where R is
smooth and slowly varying because the load is even in ln(P/Q). It is fitted over b/a in
[0.01, 1] by a quotient of two polynomials in u, with the relative error made as even as a few re-weighted least squares
can.
"""

import math

import numpy as np

from bearing_twin.contact.elasticity import curvature_ratio, hertz_coefficient

AXIS_RATIO_RANGE = (0.01, 1.0)


def gap_at(u: float) -> tuple[float, float]:
    """P and Q of the gap with this u, at P Q = 1."""
    w = math.sqrt(u)
    return (1.0 - w) / (1.0 + w), (1.0 + w) / (1.0 - w)


def load(u: float) -> float:
    """The exact R(u)."""
    return hertz_coefficient(*gap_at(u), 1.0)


DEGREE = 7  # of numerator and denominator


def greatest_u() -> float:
    """u at the narrowest ellipse of the range."""
    ratio = curvature_ratio(AXIS_RATIO_RANGE[0])
    return (ratio**-0.5 + ratio**0.5 - 2.0) / (ratio**-0.5 + ratio**0.5 + 2.0)


def fit(nodes: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Numerator and denominator in ascending powers of u (denominator starts with 1), greatest relative error."""
    degree = DEGREE
    u_end = greatest_u()
    u = 0.5 * u_end * (1.0 - np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes))
    exact = np.array([load(one) for one in u])
    powers = np.vander(u / u_end, degree + 1, increasing=True)
    weight, denominator, best = np.ones(nodes), np.ones(nodes), None
    for _ in range(60):
        row = (weight / (denominator * exact))[:, None]
        matrix = np.hstack([powers, -exact[:, None] * powers[:, 1:]]) * row
        scale = np.linalg.norm(matrix, axis=0)
        solution = np.linalg.lstsq(matrix / scale, exact * row[:, 0], rcond=None)[0] / scale
        p, q = solution[: degree + 1], np.concatenate([[1.0], solution[degree + 1 :]])
        denominator = powers @ q
        error = np.abs(powers @ p / denominator / exact - 1.0)
        if best is None or error.max() < best[2]:
            best = p / u_end ** np.arange(degree + 1), q / u_end ** np.arange(degree + 1), error.max()
        weight = weight * (0.2 + error / error.max()) ** 0.5
        weight /= weight.max()
    return best


if __name__ == "__main__":
    numerator, denominator, error = fit()
    print(f"greatest relative error over b/a in {AXIS_RATIO_RANGE}: {error:.2e}")
    for name, values in (("OVER", numerator), ("UNDER", denominator)):
        print(f"{name} = (" + ", ".join(f"{v:.17g}" for v in values) + ")")
    print(f"LAST = {greatest_u()!r}")
