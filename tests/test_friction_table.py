"""The table of friction models: words, one entry, a point whatever the axes."""

import numpy as np
import pytest

from bearing_twin.contact.friction import FRICTIONS, friction_factor, friction_number, friction_of
from bearing_twin.contact.names import friction_names, words_of
from bearing_twin.reference.spot import spot_friction_exact

ARGUMENTS = 50.0, 3e-4, 1e-4, 0.02, -0.03, 90.0, 0.1, 1e-4


def test_the_words_read_off_the_text_are_those_of_the_rows():
    assert friction_names() == tuple(FRICTIONS)
    for name, words in words_of("Friction").items():
        assert (words.name, words.help, words.needs) == (name, FRICTIONS[name].help, FRICTIONS[name].needs)


@pytest.mark.parametrize("name", FRICTIONS)
def test_one_entry_gives_each_models_own_answer(name):
    assert tuple(friction_of(friction_number(name), *ARGUMENTS)) == tuple(FRICTIONS[name].rubbing(*ARGUMENTS))


def test_at_a_point_friction_opposes_the_slip_and_nothing_drills():
    found = friction_of(friction_number("point"), *ARGUMENTS)
    factor = friction_factor(50.0, 0.02, -0.03, 0.0, 0.1, 1e-4)
    assert tuple(found) == pytest.approx((-0.02 * factor, 0.03 * factor, 0.0), rel=1e-15)


@pytest.mark.parametrize("name", [name for name, row in FRICTIONS.items() if row.over_spot])
def test_the_error_a_row_tells_is_not_exceeded(name):
    row, pure = FRICTIONS[name], -spot_friction_exact(1.0, 1.0, 0.1, 0.0, 0.0, 1.0, 1.0).torque
    worst = 0.0
    for spin in np.geomspace(0.05, 50.0, 25):
        for angle in np.linspace(0.0, 0.5 * np.pi, 5):
            slip = np.cos(angle), np.sin(angle)
            off = np.subtract(
                row.rubbing(1.0, 1.0, 0.1, *slip, spin, 1.0, 1e-12),
                spot_friction_exact(1.0, 1.0, 0.1, *slip, spin, 1.0),
            )
            worst = max(worst, np.hypot(*off[:2]), abs(off[2]) / pure)
    assert 0.1 * row.error < worst <= row.error
