"""Moving bearings by the compiled core against the record of the engine before it: the same steps, loads and places."""

import json

import numpy as np
import pytest
from engine_record import RECORD, cases, result

KNOWN = json.loads(RECORD.read_text())
CASES = [case for case in cases() if case[0] in KNOWN]
# Closed forms of friction had Jacobians by differences: there are fewer steps now, and other errors within tolerance.
OTHER_STEPS = ("pade1", "pade2")
# Shares by which steps may be more and fewer where balls bounce; elsewhere 2 %.
STEP_SHARES = {"bearing_6203_rig_400N, linear": (0.03, 0.02), "bearing_6203_run_up, 0.001": (0.02, 0.06)}


@pytest.mark.parametrize(("name", "scene", "overrides"), CASES, ids=[case[0] for case in CASES])
def test_steps_loads_and_places_are_those_of_the_record(name, scene, overrides):
    known, found = KNOWN[name], result(scene, overrides)
    other = name.endswith(OTHER_STEPS)
    near = 1e-6 if name.endswith("landing") else 1e-7  # what a landing's instant differs by
    for cost in ("ball_steps", "ball_rates"):
        before, now = known["costs"][cost], found["costs"][cost]
        more, fewer = STEP_SHARES.get(name, (0.02, 0.02))
        assert now <= (1.0 + more) * before + 2
        assert other or now >= (1.0 - fewer) * before - 2
    for channel in known.keys() - {"costs"}:
        before, now = np.array(known[channel]), np.array(found[channel])
        assert np.abs(now - before).max() <= (1e-3 if other else near) * np.abs(before).max(), channel
