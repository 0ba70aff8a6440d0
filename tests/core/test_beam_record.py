"""Spheres on beams by the compiled core against the record of the engine before it: contacts, extremes, histories."""

import json

import numpy as np
import pytest
from beam_record import RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())
NEAR = 1e-7  # of the greatest of a channel
GAINED = 3  # column of the extremes: the energy that rounding alone made


@pytest.mark.parametrize(("name", "scene", "overrides"), list(cases()), ids=[case[0] for case in cases()])
def test_impacts_on_beams_are_those_of_the_record(name, scene, overrides):
    known, found = KNOWN[name], result(scene, overrides)
    for cost, before in known["costs"].items():
        assert abs(found["costs"][cost] - before) <= 0.02 * before, cost
    for channel in known.keys() - {"costs"}:
        before, now = np.array(known[channel]), np.array(found[channel])
        if channel in ("contact", "extremes"):
            kept = [column for column in range(before.shape[1]) if channel == "contact" or column != GAINED]
            assert now[:, kept] == pytest.approx(before[:, kept], rel=NEAR), channel
        else:
            assert np.abs(now - before).max() <= NEAR * np.abs(before).max(), channel
