"""The table of friction models: words, one entry, a point whatever the axes."""

import numpy as np
import pytest

from bearing_twin.charts.laws import POLES, hardest
from bearing_twin.contact.friction import FRICTIONS, friction_factor, friction_number, friction_of

ARGUMENTS = 50.0, 3e-4, 1e-4, 0.02, -0.03, 90.0, 0.1, 1e-4


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


@pytest.mark.parametrize("name", [name for name, row in FRICTIONS.items() if row.over_spot])
def test_the_error_a_row_tells_is_the_greatest_there_is(name):
    """Looked for among all motions, without smoothing, at b/a = 0.1: not too low, and not much too high."""
    row = FRICTIONS[name]
    worst = max(error for _, error in hardest(row.rubbing, 0.1, (np.linspace(0.1, 1.0, 10), POLES[1][::3])))
    assert 0.85 * row.error < worst <= row.error
