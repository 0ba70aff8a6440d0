"""Two bodies by the compiled core against the record of the engine before it: the same steps, contacts and states."""

import json
import os

import numpy as np
import pytest
from two_bodies_record import CONTACTS, RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())
CASES = [case for case in cases() if case[0] in KNOWN]
# Where a contact begins in a step decides of the steps behind it, rounding of where: their number is not sharper.
# A library compiled by other flags, as with a sanitizer, rounds otherwise.
STEPS, FEW = 0.08 if "BEARING_TWIN_CORE" in os.environ else 0.04, 20
LOAD, IMPULSE, SPEED_OUT, PEAK_APPROACH = 2, 12, 11, 3  # columns of a contact


@pytest.mark.parametrize(("name", "scene", "overrides"), CASES, ids=[case[0] for case in CASES])
def test_steps_contacts_and_states_are_those_of_the_record(name, scene, overrides):
    known, found = KNOWN[name], result(scene, overrides)
    assert found["costs"]["steps"] == pytest.approx(known["costs"]["steps"], rel=STEPS, abs=FEW)
    before, now = np.array(known["contacts"]), np.array(found["contacts"])
    assert now.shape == before.shape
    assert len(now) <= CONTACTS
    assert now[0, [LOAD, IMPULSE]] == pytest.approx(before[0, [LOAD, IMPULSE]], rel=1e-7)
    off = np.abs(now - before).max(axis=0) / (np.abs(before).max(axis=0) + 1e-300)
    # Flat about the greatest load, and at the end of whatever step a load ended in.
    assert np.delete(off, [SPEED_OUT, PEAK_APPROACH]).max() < (1e-4 if "overlap" in name else 2e-5)
    assert off[[SPEED_OUT, PEAK_APPROACH]].max() < 1e-3
    for channel in known.keys() - {"costs", "contacts", "normal_load"}:
        before, now = np.array(known[channel]), np.array(found[channel])
        assert np.abs(now - before).max() <= 5e-7 * np.abs(before).max(), channel
