"""Soft discs by the compiled core against the record of the engine before it: the same steps, loads and shapes."""

import json

import numpy as np
import pytest
from discs_record import RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())
CASES = [case for case in cases() if case[0] in KNOWN]


@pytest.mark.parametrize(("name", "scene", "overrides"), CASES, ids=[case[0] for case in CASES])
def test_steps_loads_and_shapes_are_those_of_the_record(name, scene, overrides):
    known, found = KNOWN[name], result(scene, overrides)
    assert found["costs"] == known["costs"]
    for channel in known.keys() - {"costs"}:
        before, now = np.array(known[channel]), np.array(found[channel])
        assert np.abs(now - before).max() <= 1e-7 * np.abs(before).max(), channel
