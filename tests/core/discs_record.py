"""Histories of soft discs: `python tests/core/discs_record.py` writes them to discs_record.json.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import rounded, write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("discs_record.json")
SCENES = ("soft_discs_mean", "soft_discs_fast", "soft_discs_unequal")
DIVISIONS = (6, 12, 24)
VARIANTS = {
    "linear": ("formulation=linear", "solver.allow_invalid=on"),
    "neo-Hookean": ("formulation=neo_hookean",),
    "neo-Hookean, plane stress": ("formulation=neo_hookean", "plane=stress", "solver.allow_invalid=on"),
    "plane stress": ("plane=stress", "solver.allow_invalid=on"),
    "against a disc": ("against=disc",),
    "full": ("mesh.integration=full",),
    "exponent 1.5": ("contact.exponent=1.5",),
    **{f"order {order}": (f"mesh.order={order}", "mesh.divisions=16") for order in (1, 2, 4)},
}
INSTANTS = (10, 40, 100, 160)  # outputs that are kept, of 200
KEPT = (
    *("normal_load", "position", "velocity", "penetration", "least_stretch"),
    *("kinetic_energy", "elastic_energy", "contact_energy"),
)


def cases():
    """Name, scene and overrides of every case."""
    for scene in SCENES:
        for divisions in DIVISIONS:
            yield f"{scene}, {divisions} divisions", scene, (f"mesh.divisions={divisions}", "solver.check=none")
        for name, more in VARIANTS.items():
            yield f"{scene}, {name}", scene, ("mesh.divisions=12", "solver.check=none", *more)


def result(scene: str, overrides) -> dict:
    """Costs, channels at the kept instants, and a node of the shape at the second of them, of a case."""
    run = simulate(load_scene(scene, list(overrides)))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([np.asarray(block[name]) for block in blocks]) for name in (*KEPT, "shape")}
    shape = channels.pop("shape")[INSTANTS[1]]
    return {
        "costs": {name: int(run.report.costs[name]) for name in ("steps", "nodes", "elements")},
        **{name: rounded(values[list(INSTANTS)].tolist()) for name, values in channels.items()},
        "shape": rounded(shape[:: len(shape) // 5].tolist()),
    }


if __name__ == "__main__":
    write(RECORD, cases(), result)
