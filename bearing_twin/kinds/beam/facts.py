"""Numbers of a sphere on a beam that ranges of models are about, known before the blow."""

from bearing_twin.kinds.beam.theory import trial


def shear_share(parameters) -> float:
    """Deflection by shear over that by bending, of a load in the middle: 2.4 (1 + nu) (height / span)^2.

    12 E I / (k G A L^2) with k = 5/6 of a rectangle and I / A = height^2 / 12 (Timoshenko, Strength of Materials).
    """
    beam = parameters.beam
    return 2.4 * (1.0 + beam.material.poisson_ratio) * (beam.height / beam.span) ** 2


def first_peak_error(parameters) -> float:
    """Relative error of the first peak of force by Euler's beam against Timoshenko's."""
    return abs(trial(parameters).error)
