"""Model errors of a contact: its law against Hertz's, half-spaces against round bodies, sums over a contact patch."""

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bearing.drilling import SIDES
from bearing_twin.kinds.bearing.start import nominal_curvatures


def law_error(parameters, law: str, curvature_small, curvature_large, load) -> np.ndarray | None:
    """Relative error of each contact's load (N, 2) against exact Hertz at these curvatures [1/m]; above 0: too stiff.

    0 where there is no load; None for a law that is measured, of whose error nothing is known.
    """
    if law not in LAWS or LAWS[law].measured:
        return None
    found = np.zeros_like(load)
    for side, nominal in enumerate(nominal_curvatures(parameters.geometry)):
        frozen = hertz_coefficient(*nominal, 1.0)
        pairs = zip(curvature_small[:, side].tolist(), curvature_large[:, side].tolist(), strict=True)
        for ball, (at, bears) in enumerate(zip(pairs, (load[:, side] > 0.0).tolist(), strict=True)):
            if bears:
                found[ball, side] = _error_at(law, frozen, *at)
    return found


@functools.lru_cache(maxsize=1024)
def _error_at(law: str, frozen: float, curvature_small: float, curvature_large: float) -> float:
    """Kept, as figures and errors of a run ask for the same contacts."""
    at = curvature_small, curvature_large
    return coefficient_of(law, *at, 1.0, frozen) / hertz_coefficient(*at, 1.0) - 1.0


def half_space_error(parameters, semi_major):
    """Relative errors of loads where ellipses of these semi-axes [m] lie on bodies that Hertz takes for half-spaces.

    The square of semi-axis over ball radius: the next term of the shape of a sphere against its parabola.
    """
    return (np.asarray(semi_major) / (0.5 * parameters.geometry.ball_diameter)) ** 2


def spots_off(figures: Mapping[str, Any], share: np.ndarray) -> dict[str, list[float]]:
    """Errors of ellipses and pressures of contacts whose loads are off by these shares (N, 2): of its cube root."""
    return {
        f"{key}_{side}{unit}": [float(share[ball, place]) * value / 3.0 for ball, value in enumerate(values)]
        for key, unit in (("semi_major", "_m"), ("semi_minor", "_m"), ("peak_pressure", "_pa"))
        for place, side in enumerate(SIDES)
        for values in [figures[f"{key}_{side}{unit}"]]
    }


SMOOTHING = 2.5  # tuned: power by which the error of a sum over points falls as spin at the rim becomes slow


def rule_error(contact, ratio: float, rim: float) -> float:
    """Greatest error of friction over contact patches, over its limit, and over the torque of pure spin.

    Parameters
    ----------
    contact
        The section `contact` of a scene.
    ratio : float
        b/a of the contact ellipse; errors are those found for 0.1 and above.
    rim : float
        Speed by spin [m/s] at the ends of the ellipse: what is slow against the regularisation is smooth, and n points
        round a ring resolve it. Within a factor of 3 of `bearing_twin chart friction` where the error is above 1e-4.
    """
    model = FRICTIONS[contact.friction]
    share = rim / contact.friction_regularisation
    return model.error / (1.0 + (model.rule.spokes / share) ** SMOOTHING) if share > 0.0 else 0.0
