"""Impacts and a falling ellipsoid by the compiled core against the record of the engine before it."""

import json

import numpy as np
import pytest
from impact_record import CHANNELS, RECORD, cases, result

from bearing_twin.kinds.bodies.figures import GAINED

KNOWN, CASES = json.loads(RECORD.read_text()), list(cases())
LOOKS = 120  # more evaluations for the end of a contact: the search for it goes on to the last bit


@pytest.mark.parametrize(("name", "scene", "overrides", "family"), CASES, ids=[case[0] for case in CASES])
def test_steps_loads_and_contacts_are_those_of_the_record(name, scene, overrides, family):
    """Where bodies bounce on, the last bits of a landing grow: within the tolerance of these runs."""
    known, found = KNOWN[name], result(scene, overrides, family)
    assert found["costs"]["steps"] == pytest.approx(known["costs"]["steps"], rel=0.02, abs=2)
    assert found["costs"]["evaluations"] <= 1.02 * known["costs"]["evaluations"] + LOOKS
    bounces = len(known["contacts"]) > 1
    near = 2e-5 if bounces else 1e-7
    for channel in CHANNELS[family]:
        (*before, most), (*now, greatest) = known[channel], found[channel]
        assert abs(greatest - most) <= near * most, channel
        assert np.abs(np.array(now) - before).max() <= near * most, channel
    columns = GAINED if family == "impact" else None  # what the numbers alone gain is of the last bits
    before, now = (np.array(one["contacts"])[:1, :columns] for one in (known, found))
    near = np.full(before.shape[1], 1e-7)
    if family == "ellipsoid":
        near[:], near[3] = 2e-6, 1e-4  # the approach at the greatest load varies most, as the load is flat there
    assert (np.abs(now - before) <= near * np.abs(before) + 1e-300).all()
