"""Whole runs of every kind against records of another engine: loads, places, contacts, and no more steps.

The records were made by the engine before the compiled core, by Numba: made anew they would only hold what the core
itself computes. Each row has a scene, its overrides, the greatest costs, and numbers with the distances that are
allowed: of channels at some outputs (and of a part of their columns), and of the first rows of tables. Rounding, which
differs with the processor, decides where in a step a contact begins, so that later ones may be further off; and where
balls hardly touch the inner raceway, that engine took orbits that are of contact angles beyond the load, and of several
equilibria the one next to the last, where the core takes that of the opening alone.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from bearing_twin import load_scene, simulate

CASES = [
    pytest.param(known, id=name)
    for path in sorted(Path(__file__).parent.glob("*_record.json"))
    for name, known in json.loads(path.read_text(encoding="utf-8")).items()
]


@pytest.mark.parametrize("known", CASES)
def test_a_run_has_the_loads_places_and_contacts_of_its_record(known):
    run = simulate(load_scene(known["scene"], known["set"]))
    blocks = list(run.blocks())
    assert {
        cost: run.report.costs[cost] for cost, limit in known["costs"].items() if run.report.costs[cost] > limit
    } == {}
    for name, record in known["channels"].items():
        result = np.concatenate([block[name] for block in blocks])[tuple(np.transpose(record["at"]))]
        difference = np.abs(result - record["values"]).reshape(len(result), -1)
        assert (difference <= np.array(record["within"])[:, None]).all(), name
    for name, record in known["tables"].items():
        rows = np.concatenate([block.records[name] for block in blocks])[: len(record["values"])]
        assert (np.abs(rows - record["values"]) <= record["within"]).all(), name
