"""Impacts and a falling ellipsoid by the compiled core against the record of the engine before it."""

import json

import numpy as np
import pytest
from impact_record import CHANNELS, RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())


@pytest.mark.parametrize(("name", "scene", "overrides", "family"), cases(), ids=[case[0] for case in cases()])
def test_steps_loads_and_contacts_are_those_of_the_record(name, scene, overrides, family):
    known, found = KNOWN[name], result(scene, overrides, family)
    for cost, before in known["costs"].items():
        assert abs(found["costs"][cost] - before) <= 0.02 * before + 2, cost
    for channel in CHANNELS[family]:
        (*before, most), (*now, greatest) = known[channel], found[channel]
        assert abs(greatest - most) <= 1e-7 * most, channel
        assert np.abs(np.array(now) - before).max() <= 1e-7 * most, channel
    before, now = np.array(known["contacts"]), np.array(found["contacts"])
    assert (np.abs(now - before) <= 1e-7 * np.abs(before).max(axis=0)).all()
