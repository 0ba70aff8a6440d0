"""Fits the rational form of the law `hertz`; run it as `python -m bearing_twin.reference.fit_hertz`.

With g = sqrt(PQ) and u = (P + Q - 2g)/(P + Q + 2g) in [0, 1) the exact load is E* h^(3/2) g^(-1/2) R(u), where R is
smooth and slowly varying because the load is even in ln(P/Q). R is fitted over b/a in [0.01, 1] by a quotient of two
polynomials of degree 7 in u, with the relative error made as even as a few re-weighted least squares can.
"""

import numpy as np

from bearing_twin.contact.ellipse import curvature_ratio, hertz_coefficient

DEGREE = 7
AXIS_RATIO_RANGE = (0.01, 1.0)


def shape(ratio: float) -> tuple[float, float]:
    """u and the exact R(u) for the gap with Q/P = `ratio`, taken at P Q = 1 and E* = 1."""
    small, large = ratio**-0.5, ratio**0.5
    return (small + large - 2.0) / (small + large + 2.0), hertz_coefficient(small, large, 1.0)


def fit(nodes: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Numerator and denominator in ascending powers of u (denominator starts with 1), greatest relative error."""
    u_end = shape(curvature_ratio(AXIS_RATIO_RANGE[0]))[0]
    u = 0.5 * u_end * (1.0 - np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes))
    ratio = ((1.0 + np.sqrt(u)) / (1.0 - np.sqrt(u))) ** 2
    exact = np.array([shape(q)[1] for q in ratio])
    powers = np.vander(u / u_end, DEGREE + 1, increasing=True)
    weight, denominator, best = np.ones(nodes), np.ones(nodes), None
    for _ in range(60):
        row = (weight / (denominator * exact))[:, None]
        matrix = np.hstack([powers, -exact[:, None] * powers[:, 1:]]) * row
        scale = np.linalg.norm(matrix, axis=0)
        solution = np.linalg.lstsq(matrix / scale, exact * row[:, 0], rcond=None)[0] / scale
        p, q = solution[: DEGREE + 1], np.concatenate([[1.0], solution[DEGREE + 1 :]])
        denominator = powers @ q
        error = np.abs(powers @ p / denominator / exact - 1.0)
        if best is None or error.max() < best[2]:
            best = p / u_end ** np.arange(DEGREE + 1), q / u_end ** np.arange(DEGREE + 1), error.max()
        weight = weight * (0.2 + error / error.max()) ** 0.5
        weight /= weight.max()
    return best


if __name__ == "__main__":
    numerator, denominator, error = fit()
    print(f"greatest relative error over b/a in {AXIS_RATIO_RANGE}: {error:.2e}")
    for name, values in (("HERTZ_NUMERATOR", numerator), ("HERTZ_DENOMINATOR", denominator)):
        print(f"{name} = (" + ", ".join(repr(float(v)) for v in values) + ")")
    print(f"HERTZ_U_MAX = {shape(curvature_ratio(AXIS_RATIO_RANGE[0]))[0]!r}")
