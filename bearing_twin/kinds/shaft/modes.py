"""Small motion of the shaft about its balance: natural frequencies, how they whirl, critical speeds, response.

    M q'' + (T K + w G) q' + K q = f,   q = Re(u exp(i v t))

with K the bearings' condensed stiffness there, T the relaxation time and G the gyroscopic matrix of 1 rad/s. A motion
whirls forward where its centre goes round as the shaft turns: u_y = -i u_x, and so with both tilts.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.shaft.course import speeds_of
from bearing_twin.kinds.shaft.equilibrium import Rotor, balance_of, lever_of, rotor_of
from bearing_twin.kinds.shaft.parameters import ShaftScene

STILL = 1e-6  # of the motion's square: a mode with less of it across the axis does not whirl
REAL = 1e-6  # of a root: an imaginary part that is less is none


class Matrices(NamedTuple):
    """M (5,), G and K (5, 5), damping (5, 5) and the arm [m] that makes displacements of tilts."""

    inertia: np.ndarray
    gyroscopic: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    lever: float


class WhirlModes(NamedTuple):
    """Natural frequencies [Hz] in rising order, and what share of each whirls forward.

    That is 1 forward, 0 backward, 1/2 in a line or along the axis.
    """

    frequencies: np.ndarray
    forward: np.ndarray


def matrices_of(rotor: Rotor, stiffness: np.ndarray) -> Matrices:
    """The matrices of a rotor with this stiffness of its bearings."""
    gyroscopic = np.zeros((5, 5))
    gyroscopic[3, 4], gyroscopic[4, 3] = rotor.polar, -rotor.polar
    inertia = np.array([rotor.mass] * 3 + [rotor.transverse] * 2)
    return Matrices(inertia, gyroscopic, stiffness, rotor.relaxation_time * stiffness, lever_of(rotor))


def stiffest_mode(matrices: Matrices) -> float:
    """The greatest natural angular frequency [rad/s] at rest."""
    root = np.sqrt(matrices.inertia)
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T) / np.outer(root, root)
    return math.sqrt(float(np.linalg.eigvalsh(symmetric).max()))


def _forward_share(shape: np.ndarray, lever: float) -> float | None:
    """The share of a motion u (5,) across the axis that whirls forward; None of one along it."""
    across = shape * np.array([1.0, 1.0, 0.0, lever, lever])
    ahead = (abs(across[0] + 1j * across[1]) ** 2 + abs(across[3] + 1j * across[4]) ** 2) / 2.0
    whole = float(np.sum(np.abs(across) ** 2))
    return float(ahead) / whole if whole > STILL * (whole + abs(shape[2]) ** 2) else None


def modes_at(matrices: Matrices, speed: float) -> WhirlModes:
    """The modes of small motion with the shaft turning at `speed` [rad/s]; those that do not swing are left out."""
    inverse = 1.0 / matrices.inertia[:, None]
    damping = matrices.damping + speed * matrices.gyroscopic
    first = np.block([[np.zeros((5, 5)), np.eye(5)], [-inverse * matrices.stiffness, -inverse * damping]])
    roots, shapes = np.linalg.eig(first)
    swings = roots.imag > REAL * np.abs(roots)
    roots, shapes = roots[swings], shapes[:, swings]
    order = np.argsort(roots.imag)
    shares = [_forward_share(shapes[:5, k], matrices.lever) for k in order]
    forward = np.array([0.5 if share is None else share for share in shares])
    # exp(i v t) with v > 0; a shaft that turns backward is seen from its other side
    return WhirlModes(roots.imag[order] / (2.0 * math.pi), forward if speed >= 0.0 else 1.0 - forward)


def critical_speeds(matrices: Matrices) -> list[float]:
    """Speeds [rad/s] at which a motion that whirls forward, or in a line, goes round as the shaft turns, rising.

    (K - w^2 (M - i G)) u = 0 without damping: a forward tilt has the inertia I_t - I_p and none above I_t = I_p.
    """
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    inertia = np.diag(matrices.inertia).astype(complex) - 1j * matrices.gyroscopic
    # by 1 / w^2, which is 0 along what nothing holds
    inverse, shapes = np.linalg.eig(np.linalg.pinv(symmetric, rcond=REAL**2, hermitian=True) @ inertia)
    found = []
    for k, value in enumerate(inverse):
        held = value.real > REAL**2 * np.abs(inverse).max() and abs(value.imag) <= REAL * abs(value)
        share = _forward_share(shapes[:, k], matrices.lever)
        if held and share is not None and share >= 0.5 - REAL:
            found.append(1.0 / math.sqrt(value.real))
    found.sort()
    return [one for k, one in enumerate(found) if k == 0 or one > (1.0 + REAL) * found[k - 1]]


def unbalance_response(rotor: Rotor, matrices: Matrices, speed: float) -> np.ndarray:
    """The linear response u (5,) to the unbalances at an even speed: q = Re(u exp(i w t))."""
    damping = matrices.damping + speed * matrices.gyroscopic
    system = matrices.stiffness + 1j * speed * damping - speed**2 * np.diag(matrices.inertia)
    return np.linalg.solve(system, speed**2 * rotor.unbalance)


def last_matrices(parameters: ShaftScene, law: str) -> tuple[Matrices, float]:
    """The matrices of a scene in balance at the speed [rad/s], which follows, and the loads that its run ends with."""
    speed = float(speeds_of(parameters)[-1])
    stiffness = balance_of(parameters, law, speed, float(parameters.run.duration)).stiffness
    return matrices_of(rotor_of(parameters, law), stiffness), speed


@functools.lru_cache(maxsize=8)
def modes_of(parameters: ShaftScene, law: str) -> tuple[WhirlModes, list[float]]:
    """The modes and the critical speeds of a scene, in balance at the speed and the loads that its run ends with."""
    matrices, speed = last_matrices(parameters, law)
    return modes_at(matrices, speed), critical_speeds(matrices)
