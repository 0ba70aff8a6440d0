"""Polynomials of laws and contact ellipses along a groove, which the compiled core is given."""

import numpy as np
import pytest
from contact_reference import along_groove

from bearing_twin.contact.elasticity import (
    elasticity,
    fresh_coefficient,
    semi_axes,
)
from bearing_twin.contact.laws import LAWS, law_names
from bearing_twin.kinds.bearing.parameters import LAW_NEEDS
from bearing_twin.kinds.bearing.system import TERMS, axes_along, terms_along
from bearing_twin.shapes import ball_in_groove

PITCH = 28.5e-3


COSINES = np.linspace(0.0, 1.0, 101)


MODULUS = 1.14e11


def groove(share, conformity, side):
    """Ball radius, radius of the centre circle and of the groove [m] where balls are so large a share of the pitch."""
    radius = 0.5 * share * PITCH
    across = 2.0 * conformity * radius
    return radius, 0.5 * PITCH + side * (radius - across), across


def gap_there(ball, circle, across, side, cosine):
    """The gap where the contact's normal leans from the radius by this cosine."""
    away = across - 0.999 * ball  # of the centres, in contact
    sine = np.sqrt(1.0 - cosine**2)
    gap = ball_in_groove(circle + side * away * cosine, away * sine, ball, circle, across)
    assert side * gap.normal_radial == pytest.approx(cosine, abs=1e-12)
    return gap


def exact(law, *contact):
    """c of the law there, by the gap itself."""
    gap = gap_there(*contact)
    return fresh_coefficient(law, gap.curvature_small, gap.curvature_large)


@pytest.mark.parametrize("name", law_names("point", LAW_NEEDS))
@pytest.mark.parametrize(
    ("share", "conformity", "error"),
    [(0.236, 0.52, 6e-14), (0.236, 0.5003, 4e-14), (0.1, 0.515, 2e-15), (0.4, 0.52, 4e-11), (0.5, 0.52, 4e-11)],
)
def test_a_law_along_a_groove_is_the_law_at_every_contact_angle(name, share, conformity, error):
    """Near b/a = 0.01 `hertz` goes over to the exact solution, from which its rational form is 1e-10 off."""
    law, floor = elasticity(name, MODULUS, 1e9), 1e-13 if LAWS[name].carries else 3e-15
    if name == "hertz" and conformity < 0.501:
        floor = 2e-10
    for side in (-1.0, 1.0):
        shape = groove(share, conformity, side)
        terms = terms_along(law, *shape, side)
        cosines = 1.0 + terms[TERMS] * COSINES
        assert cosines.min() < 0.4 or not LAWS[name].follows
        result = np.array([along_groove(terms, side * cosine) for cosine in cosines])
        expected = np.array([exact(law, *shape, side, cosine) for cosine in cosines])
        assert np.abs(result / expected - 1.0).max() < error + floor
        if LAWS[name].follows and cosines.min() > 0.01:
            beyond = side * (cosines.min() - 0.01)
            assert along_groove(terms, beyond) == pytest.approx(result[-1], rel=1e-12)


@pytest.mark.parametrize(
    ("share", "conformity", "error"),
    [
        (0.236, 0.52, 7e-14),
        (0.236, 0.501, 7e-14),
        (0.1, 0.52, 1e-14),
        (0.4, 0.52, 4e-11),
        (0.5, 0.52, 4e-11),
        (0.236, 0.5003, 1e-12),
    ],
)
def test_the_semi_axes_along_a_groove_are_those_of_every_contact_angle(share, conformity, error):
    for side in (-1.0, 1.0):
        shape = groove(share, conformity, side)
        axes = axes_along(*shape, side)
        cosines = 1.0 + axes[0][TERMS] * COSINES
        assert cosines.min() < 0.4
        for axis, terms in enumerate(axes):
            result = np.array([along_groove(terms, side * cosine) for cosine in cosines])
            gaps = [gap_there(*shape, side, cosine) for cosine in cosines]
            expected = [semi_axes(gap.curvature_small, gap.curvature_large, 4e-6)[axis] for gap in gaps]
            assert np.abs(2e-3 * result / expected - 1.0).max() < error
