"""Elastic half-spaces pressed together across any gap, by boundary elements: no parabolas, no ellipse.

Pressures, constant on the cells of a grid, deflect by Love's solution (Phil. Trans. Roy. Soc. A 228 (1929) 377), summed
by Fourier transforms; that none pulls and none stands across a gap is found by conjugate gradients (Polonsky and Keer,
Wear 231 (1999) 206).
"""

import numpy as np
from scipy.fft import irfft2, rfft2

STEPS = 400
ENOUGH = 1e-7  # of the sum of pressures, that one more step changes


def load_across(gap: np.ndarray, sides: tuple[float, float], approach: float, modulus: float) -> float:
    """Load [N] at an approach [m] across `gap` [m] at the centres of cells with these `sides` [m], E* `modulus` [Pa].

    The grid must be wider than the contact. Raises ArithmeticError where no pressure is found.
    """
    answer = rfft2(_deflections(gap.shape, sides, modulus))

    def deflection(pressure):
        return irfft2(rfft2(pressure, s=(2 * len(gap), 2 * gap.shape[1])) * answer)[: len(gap), : gap.shape[1]]

    pressure = np.where(gap < approach, modulus * approach / max(sides), 0.0)
    along, before, going = np.zeros_like(gap), 1.0, 0.0
    for _ in range(STEPS):
        apart = deflection(pressure) + gap - approach
        touches = pressure > 0.0
        squares = float((apart[touches] ** 2).sum())
        along = np.where(touches, apart + going * squares / before * along, 0.0)
        length = float((apart[touches] * along[touches]).sum() / (deflection(along)[touches] * along[touches]).sum())
        last, before = pressure, squares
        pressure = np.maximum(pressure - length * along, 0.0)
        overlaps = (pressure == 0.0) & (apart < 0.0)
        pressure[overlaps] -= length * apart[overlaps]
        going = 0.0 if overlaps.any() else 1.0
        if np.abs(pressure - last).sum() < ENOUGH * pressure.sum():
            return float(pressure.sum()) * sides[0] * sides[1]
    raise ArithmeticError(f"no pressure was found in {STEPS} steps")


def _deflections(shape: tuple[int, int], sides: tuple[float, float], modulus: float) -> np.ndarray:
    """Deflection [m/Pa] of each cell by a pressure on the first, on a grid twice as wide, wrapped round."""
    x, y = np.meshgrid(*(np.arange(count) * side for count, side in zip(shape, sides, strict=True)), indexing="ij")

    def corner(x, y):
        return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

    a, b = 0.5 * sides[0], 0.5 * sides[1]
    quarter = corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b)
    whole = np.zeros((2 * shape[0], 2 * shape[1]))
    whole[: shape[0], : shape[1]] = quarter
    whole[shape[0] + 1 :, : shape[1]] = quarter[:0:-1]
    whole[:, shape[1] + 1 :] = whole[:, shape[1] - 1 : 0 : -1]
    return whole / (np.pi * modulus)
