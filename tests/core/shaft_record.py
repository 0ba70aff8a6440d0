"""Steps and loads of shafts on two bearings: `python tests/core/shaft_record.py` writes them to shaft_record.json.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import rounded, write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("shaft_record.json")
TOLERANCES = (1e-3, 1e-6)
INSTANTS = (20, 40)  # outputs that are kept
SCENES = {"shaft_two_6203": 2000.0, "shaft_angular_pair": 5000.0, "shaft_step_load": 1000.0}  # with their outputs [Hz]
VARIANTS = {
    "linear": ("contact.normal=linear", "contact.stiffness=2e7"),
    "volumetric": ("contact.normal=volumetric",),
    "changing speed": ("drive.change={time: 0.005, speed: 20.0}",),
    "at rest": ("drive.speed=0", "shaft.start=equilibrium"),
    "from equilibrium": ("shaft.start=equilibrium",),
    "table": ("shaft.table=[[0,0,0,0,0,0],[0.003,0,-30,5,0.1,0],[0.03,10,-30,0,0,0]]", "shaft.load_place=0.01"),
}
KEPT = (
    *("position", "tilt", "left_normal_load", "right_contact_angle", "load_work", "bearing_work", "dissipated"),
    *("elastic_energy", "cage_work", "gross_work", "bearing_force"),
)


def cases():
    """Name, scene and overrides of every case."""
    for scene, rate in SCENES.items():
        short = (f"run.duration={40.0 / rate}", f"run.output_rate={rate}", "solver.check=none")
        for tolerance in TOLERANCES:
            yield f"{scene}, {tolerance:g}", scene, (*short, f"wanted.tolerance={tolerance}")
        for name, more in VARIANTS.items():
            yield f"{scene}, {name}", scene, (*short, *more)


def result(scene: str, overrides) -> dict:
    """Costs, and channels at the kept instants, of a case."""
    run = simulate(load_scene(scene, list(overrides)))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([np.asarray(block[name]) for block in blocks]) for name in KEPT}
    costs = {name: int(run.report.costs[name]) for name in ("steps", "rejections", "evaluations")}
    return {"costs": costs, **{name: rounded(values[list(INSTANTS)].tolist()) for name, values in channels.items()}}


if __name__ == "__main__":
    write(RECORD, cases(), result)
