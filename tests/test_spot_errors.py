"""What friction over a spot errs by, as measured by shape and spin: no motion errs more, and some nearly as much."""

import math

import numpy as np
import pytest
from scipy.special import ellipe

from bearing_twin.charts.friction_smoothed import SHAPES, SHARES, greatest
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.spot_rules import over_spot, points
from bearing_twin.kinds.bearing.spot_errors import greatest_error
from bearing_twin.paths import share_path

OVER_SPOT = [name for name, row in FRICTIONS.items() if row.over_spot]
RULES = [name for name in OVER_SPOT if FRICTIONS[name].rule.end]
LEAST = 1e-9  # errors below this count as none


def test_the_tables_that_choices_read_are_those_of_the_documents():
    folder = share_path("config", "measured")
    names = {file.name for file in folder.glob("*.csv")}
    assert "friction.csv" in names
    for name in names:
        assert (folder / name).read_bytes() == (folder.parent.parent / "docs" / name).read_bytes(), name


@pytest.mark.parametrize("name", OVER_SPOT)
def test_errors_grow_with_the_spin_and_end_with_those_without_smoothing(name):
    for ratio in (1.0, 0.5, 0.08):
        found = np.array(
            [greatest_error(name, ratio, share) for share in (0.0, *np.geomspace(0.05, 1e4, 60), math.inf)]
        )
        assert np.all(np.diff(found, axis=0) >= 0.0)
        assert found[-1].max() <= (1.4 if ratio < 0.1 else 1.0) * FRICTIONS[name].error
    assert max(greatest_error(name, 0.1, math.inf)) > 0.8 * FRICTIONS[name].error


@pytest.mark.parametrize("name", RULES)
def test_no_motion_errs_more_than_the_table_tells(name):
    """Shapes, spins, and slips by chance, between those of the table; against sums over 96 x 384 points."""
    random, finer = np.random.default_rng(7), points(96, 384)
    for _ in range(300):
        ratio, share = random.uniform(0.05, 1.0), 10.0 ** random.uniform(-1.0, 1.3)
        distance, angle = random.uniform(0.0, 1.2 + 2.0 / share), random.uniform(0.0, 0.5 * math.pi)
        motion = ratio * distance * math.sin(angle), -distance * math.cos(angle), 1.0
        off = np.array(FRICTIONS[name].rubbing(1.0, 1.0, ratio, *motion, 1.0, 1.0 / share))
        off += over_spot(finer, 1.0, ratio, *motion, 1.0 / share)
        told, pure = greatest_error(name, ratio, share), 0.375 * ellipe(1.0 - ratio**2)
        assert math.hypot(off[0], off[1]) <= 1.1 * told.force + LEAST
        assert abs(off[2]) / pure <= 1.1 * told.torque + LEAST


@pytest.mark.parametrize(("name", "share"), [("spot", 3.0), ("spot", 30.0), ("spot_medium", 9.0), ("spot_fine", 30.0)])
@pytest.mark.parametrize("ratio", [0.3, 0.1])
def test_what_the_table_tells_is_found_again_by_a_search(name, share, ratio):
    """Between spins and at a shape of the table, on another grid of poles."""
    found = greatest(FRICTIONS[name].rubbing, ratio, share, 0.375 * ellipe(1.0 - ratio**2), np.linspace(0.05, 1.1, 30))
    told = greatest_error(name, ratio, share)
    assert found == pytest.approx((told.force, told.torque), rel=0.15)


def test_the_table_holds_the_shapes_that_bearings_have():
    """Of the narrowest that the models are offered for, and circles."""
    assert (max(SHAPES), min(SHAPES)) == (1.0, 0.03)
    assert SHARES[-1] == math.inf
    assert greatest_error("spot", 0.01, 1.0) == greatest_error("spot", 0.03, 1.0)
