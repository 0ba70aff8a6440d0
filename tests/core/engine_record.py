"""Steps, loads and states of moving bearings: `python tests/core/engine_record.py` writes them to engine_record.json.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import rounded, write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("engine_record.json")
TOLERANCES = (1e-3, 1e-6)
BALLS = (7, 11, 13)  # fit into a 6203 with smaller balls
INSTANTS = (3, 20)  # outputs that are kept
SCENES = {  # with the rate of outputs [Hz], 20 of which are computed
    "bearing_6203": 1000.0,
    "bearing_6203_fast": 5000.0,
    "bearing_6203_start": 10_000.0,
    "bearing_6203_sticking": 1000.0,
    "bearing_6203_sudden": 10_000.0,
    "bearing_6205": 1000.0,
    "bearing_6203_loose": 2000.0,
    "bearing_6203_tilted": 1000.0,
    "bearing_6203_rig_400N": 1000.0,
    "bearing_6203_load_and_speed": 1000.0,
    "bearing_6203_step_load": 1000.0,
    "bearing_6203_unbalance": 1000.0,
    "bearing_6203_run_up": 1000.0,
    "bearing_6203_guided_cage": 2000.0,
}
VARIANTS = {
    **{f"{balls} balls": (f"geometry.balls={balls}", "geometry.ball_diameter=5e-3") for balls in BALLS},
    "linear": ("contact.normal=linear", "contact.stiffness=2e7"),
    "volumetric": ("contact.normal=volumetric",),
    "patch": ("contact.friction=spot",),
    "pade1": ("contact.friction=pade1",),
    "pade2": ("contact.friction=pade2",),
    "rodas3": ("solver.stepper=rodas3",),
    "landing": ("solver.stepper=rodas4_landing",),
}
KEPT = ("normal_load", "position", "inner_ring_offset")


def cases():
    """Name, scene and overrides of every case."""
    for scene, rate in SCENES.items():
        short = (f"run.duration={20.0 / rate}", f"run.output_rate={rate}", "solver.check=none")
        for tolerance in TOLERANCES:
            yield f"{scene}, {tolerance:g}", scene, (*short, f"wanted.tolerance={tolerance}")
        if scene in ("bearing_6203_fast", "bearing_6203_start", "bearing_6203_loose", "bearing_6203_rig_400N"):
            for name, more in VARIANTS.items():
                yield f"{scene}, {name}", scene, (*short, *more)


def result(scene: str, overrides) -> dict:
    """Costs, and channels at the kept instants, of a case."""
    run = simulate(load_scene(scene, list(overrides)))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([np.asarray(block[name]) for block in blocks]) for name in KEPT}
    return {
        "costs": {name: int(cost) for name, cost in run.report.costs.items() if name.startswith("ball_")},
        **{name: rounded(values[list(INSTANTS)].tolist()) for name, values in channels.items()},
    }


if __name__ == "__main__":
    write(RECORD, cases(), result)
