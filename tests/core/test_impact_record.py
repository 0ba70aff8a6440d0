"""Impacts and a falling ellipsoid by the compiled core against the record of the engine before it."""

import json

import numpy as np
import pytest
from impact_record import CHANNELS, RECORD, cases, result

from bearing_twin.kinds.impact.figures import GAINED

KNOWN, CASES = json.loads(RECORD.read_text()), list(cases())
LOOKS = 120  # more evaluations for the end of a contact: the search for it goes on to the last bit


@pytest.mark.parametrize(("name", "scene", "overrides", "family"), CASES, ids=[case[0] for case in CASES])
def test_steps_loads_and_contacts_are_those_of_the_record(name, scene, overrides, family):
    known, found = KNOWN[name], result(scene, overrides, family)
    for cost, before in known["costs"].items():
        now = found["costs"][cost]
        assert now <= 1.02 * before + (LOOKS if cost == "evaluations" else 2), cost
        assert cost == "evaluations" or now >= 0.98 * before - 2, cost
    for channel in CHANNELS[family]:
        (*before, most), (*now, greatest) = known[channel], found[channel]
        assert abs(greatest - most) <= 1e-7 * most, channel
        assert np.abs(np.array(now) - before).max() <= 1e-7 * most, channel
    columns = GAINED if family == "impact" else None  # what the numbers alone gain is of the last bits
    before, now = (np.array(one["contacts"])[:, :columns] for one in (known, found))
    assert (np.abs(now - before) <= 1e-7 * np.abs(before).max(axis=0)).all()
