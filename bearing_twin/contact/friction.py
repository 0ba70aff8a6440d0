"""Friction in the contact plane."""

import math

from bearing_twin.compiled import inlined


@inlined
def friction_factor(normal_load, slip_x, slip_y, slip_z, coefficient, regularisation):
    """f [N s/m] of the regularised Coulomb friction force -f * slip on the slipping body.

    f = mu N / sqrt(|slip|^2 + regularisation^2): the force grows linearly with slip, reaches 71 % of mu N at
    slip = `regularisation` [m/s], and mu N far above it. Smooth everywhere; true sticking creeps.
    """
    speed = math.sqrt(slip_x * slip_x + slip_y * slip_y + slip_z * slip_z + regularisation * regularisation)
    return coefficient * normal_load / speed
