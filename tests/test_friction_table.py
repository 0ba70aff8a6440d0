"""The table of friction models: words, one entry, a point whatever the axes."""

import math

import numpy as np
import pytest

from bearing_twin.contact.friction import FRICTIONS, friction_factor, friction_number, friction_of
from bearing_twin.contact.names import friction_names, words_of
from bearing_twin.reference.spot import spot_friction_exact

ARGUMENTS = 50.0, 3e-4, 1e-4, 0.02, -0.03, 90.0, 0.1, 1e-4


def test_the_words_read_off_the_text_are_those_of_the_rows():
    assert friction_names() == tuple(FRICTIONS)
    for name, words in words_of("FrictionModel").items():
        assert (words.name, words.help, words.needs) == (name, FRICTIONS[name].help, FRICTIONS[name].needs)


@pytest.mark.parametrize("name", FRICTIONS)
def test_one_entry_gives_each_models_own_answer(name):
    assert tuple(friction_of(friction_number(name), *ARGUMENTS)) == tuple(FRICTIONS[name].rubbing(*ARGUMENTS))


@pytest.mark.parametrize("name", FRICTIONS)
def test_without_load_and_size_there_is_nothing(name):
    """A ball out of contact stands in the lanes like any other."""
    found = friction_of(friction_number(name), 0.0, 0.0, 0.0, 0.02, -0.03, 90.0, 0.1, 1e-4)
    assert tuple(abs(part) for part in found) == (0.0, 0.0, 0.0)


def test_at_a_point_friction_opposes_the_slip_and_nothing_drills():
    found = friction_of(friction_number("point"), *ARGUMENTS)
    factor = friction_factor(50.0, 0.02, -0.03, 0.0, 0.1, 1e-4)
    assert tuple(found) == pytest.approx((-0.02 * factor, 0.03 * factor, 0.0), rel=1e-15)


@pytest.fixture(scope="module")
def exact():
    """(slip along both axes, spin), and the exact answer, on an ellipse of b/a = 0.1 for mu N = 1 N and a = 1 m."""
    motions = [
        (math.cos(angle), math.sin(angle), spin)
        for spin in np.geomspace(0.1, 40.0, 14)
        for angle in (0.0, 0.3, 0.8, 1.3, 0.5 * math.pi)
    ]
    return [(one, spot_friction_exact(1.0, 1.0, 0.1, *one, 1.0, rays=1000)) for one in motions]


@pytest.mark.parametrize("name", [name for name, row in FRICTIONS.items() if row.over_spot])
def test_the_error_a_row_tells_is_not_exceeded(name, exact):
    row, pure = FRICTIONS[name], -spot_friction_exact(1.0, 1.0, 0.1, 0.0, 0.0, 1.0, 1.0).torque
    worst = 0.0
    for motion, right in exact:
        off = np.subtract(row.rubbing(1.0, 1.0, 0.1, *motion, 1.0, 1e-12), right)
        worst = max(worst, math.hypot(*off[:2]), abs(off[2]) / pure)
    assert 0.1 * row.error < worst <= row.error
