"""The method of order 8 of Dormand and Prince (Hairer, Norsett and Wanner, section II.10), from SciPy's tables."""

import numpy as np
from scipy import integrate

from bearing_twin.numerics.steppers import RungeKutta

DOP853 = RungeKutta(
    a=np.ascontiguousarray(integrate.DOP853.A),
    nodes=integrate.DOP853.C,
    weights=integrate.DOP853.B,
    error=integrate.DOP853.E5,
    third=integrate.DOP853.E3,
    order=8,
)
