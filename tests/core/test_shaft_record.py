"""Shafts on two bearings by the compiled core against the record of the engine before it: the same steps and loads."""

import json

import numpy as np
import pytest
from shaft_record import RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())
WORKS = ("load_work", "bearing_work", "cage_work", "dissipated", "gross_work")
CASES = [case for case in cases() if case[0] in KNOWN]


@pytest.mark.parametrize(("name", "scene", "overrides"), CASES, ids=[case[0] for case in CASES])
def test_steps_and_loads_are_those_of_the_record(name, scene, overrides):
    known, found = KNOWN[name], result(scene, overrides)
    for cost, before in known["costs"].items():
        assert found["costs"][cost] == pytest.approx(before, rel=0.02, abs=2), cost
    gross = max(*known["gross_work"], 1e-11)  # J: shafts at rest do none but what rounding leaves
    for channel in known.keys() - {"costs"}:
        before, now = np.array(known[channel]), np.array(found[channel])
        # over whole turns next to nothing may be left of what loads and bearings did either way
        # works hold the friction over contact patches, whose semi-axes the record has within 1e-5
        off = 2e-5 * gross if channel in WORKS else 1e-7 * np.abs(before).max()
        assert np.abs(now - before).max() <= off, channel
