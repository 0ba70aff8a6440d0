"""Fits the rational forms of the law `hertz` and of its ellipse; run as `python tests/reference/fit_hertz.py`.

With g = sqrt(PQ) and u = (P + Q - 2g)/(P + Q + 2g) in [0, 1) the exact load is E* h^(3/2) g^(-1/2) R(u), where R is
smooth and slowly varying because the load is even in ln(P/Q). So is a b g/h, and (a - b)/(a + b) is odd, sqrt(u) times
such a function. Each is fitted over b/a in [0.01, 1] by a quotient of two polynomials in u, with the relative error
made as even as a few re-weighted least squares can.
"""

import math

import numpy as np

from bearing_twin.contact.ellipse import curvature_ratio, ellipse, hertz_coefficient

AXIS_RATIO_RANGE = (0.01, 1.0)


def gap_at(u: float) -> tuple[float, float]:
    """P and Q of the gap with this u, at P Q = 1."""
    w = math.sqrt(u)
    return (1.0 - w) / (1.0 + w), (1.0 + w) / (1.0 - w)


def load(u: float) -> float:
    """The exact R(u)."""
    return hertz_coefficient(*gap_at(u), 1.0)


def area(u: float) -> float:
    """The exact a b g/h."""
    spot = ellipse(*gap_at(u), 1.0, load(u))
    return spot.semi_major * spot.semi_minor


def shape(u: float) -> float:
    """The exact (a - b)/(a + b)/sqrt(u)."""
    spot = ellipse(*gap_at(u), 1.0, load(u))
    return (spot.semi_major - spot.semi_minor) / (spot.semi_major + spot.semi_minor) / math.sqrt(u)


FORMS = {"HERTZ": (load, 7), "AREA": (area, 4), "SHAPE": (shape, 4)}
"""What is fitted: the exact function of u and the degree of numerator and denominator."""


def greatest_u() -> float:
    """u at the narrowest ellipse of the range."""
    ratio = curvature_ratio(AXIS_RATIO_RANGE[0])
    return (ratio**-0.5 + ratio**0.5 - 2.0) / (ratio**-0.5 + ratio**0.5 + 2.0)


def fit(form: str, nodes: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Numerator and denominator in ascending powers of u (denominator starts with 1), greatest relative error."""
    function, degree = FORMS[form]
    u_end = greatest_u()
    u = 0.5 * u_end * (1.0 - np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes))
    exact = np.array([function(one) for one in u])
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
    for form in FORMS:
        numerator, denominator, error = fit(form)
        digits = 17 if form == "HERTZ" else 11
        print(f"{form}: greatest relative error over b/a in {AXIS_RATIO_RANGE}: {error:.2e}")
        for name, values in (("NUMERATOR", numerator), ("DENOMINATOR", denominator)):
            print(f"{form}_{name} = (" + ", ".join(f"{v:.{digits}g}" for v in values) + ")")
    print(f"HERTZ_U_MAX = {greatest_u()!r}, W_MAX = {math.sqrt(greatest_u())!r}")
