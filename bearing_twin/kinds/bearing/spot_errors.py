"""What friction over a spot errs by, whatever its slip: a table by the spot's shape and spin, as measured.

`bearing_twin chart friction` makes it, by a search over all motions. Between the spins that it holds errors follow
powers of the spin; of the two shapes next to a spot's the one with more counts.
"""

import functools
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.charted import measured_rows

SMOOTHED = ", smoothed"  # ends the names of the table's problems that tell the greatest errors


class RuleError(NamedTuple):
    """Greatest errors of a friction model: `force` over mu N, and `torque` over that of pure spin, 3/8 mu N a E."""

    force: float
    torque: float


@functools.cache
def _measured() -> dict[str, dict[float, np.ndarray]]:
    """By model and b/a: spin times major semi-axis over regularisation, errors of force and torque; (3, n), rising."""
    found: dict[str, dict[float, list[tuple[float, ...]]]] = {}
    for row in measured_rows("friction.csv"):
        if row["problem"].endswith(SMOOTHED):
            shape = float(row["problem"].removesuffix(SMOOTHED).rpartition("=")[2])
            one = tuple(float(row[key]) for key in ("setting", "force_error", "torque_error"))
            found.setdefault(row["method"], {}).setdefault(shape, []).append(one)
    return {
        name: {shape: np.maximum.accumulate(np.array(sorted(rows)).T, axis=1) for shape, rows in shapes.items()}
        for name, shapes in found.items()
    }


def greatest_error(name: str, ratio: float, share: float) -> RuleError:
    """The greatest error of the friction model of that name whatever the slip, at b/a = `ratio`.

    `share`: spin times major semi-axis over the regularising speed. Narrower spots than were measured count as the
    narrowest, slower ones as the slowest.
    """
    shapes = _measured()[name]
    wider = [shape for shape in shapes if shape >= ratio]
    narrower = [shape for shape in shapes if shape <= ratio]
    near = {min(wider, default=max(shapes)), max(narrower, default=min(shapes))}
    found = np.max([_at(shapes[shape], share) for shape in near], axis=0)
    return RuleError(float(found[0]), float(found[1]))


def _at(measured: np.ndarray, share: float) -> np.ndarray:
    """Force and torque errors (2,) at a share: between two that were measured by powers, beyond the last as without."""
    shares, errors = measured[0], measured[1:]
    if share <= shares[0]:
        return errors[:, 0]
    at = int(np.searchsorted(shares, share))
    if not share < shares[-2]:
        return errors[:, -1]
    part = np.log(share / shares[at - 1]) / np.log(shares[at] / shares[at - 1])
    low, high = np.maximum(errors[:, at - 1], 1e-300), np.maximum(errors[:, at], 1e-300)
    return low * (high / low) ** part


def rule_error(contact, ratio: float, rim: float) -> float:
    """The greatest share of friction, and of pure spin's torque, that a scene's friction over spots may be off.

    `contact` is that of the scene, `ratio` b/a, `rim` the speed by spin of the spot's ends [m/s].
    """
    return max(greatest_error(contact.friction, ratio, rim / contact.friction_regularisation))
