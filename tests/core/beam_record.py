"""Contacts, extremes and histories of spheres on beams: `python tests/core/beam_record.py` writes beam_record.json.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import rounded, write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("beam_record.json")
TOLERANCES = (1e-3, 1e-6, 1e-8)
INSTANTS = (13, 101)  # outputs that are kept
SCENES = {  # with the duration of a run [s]
    "sphere_on_beam": 1e-3,
    "sphere_on_beam_long": 4e-3,
    "sphere_on_beam_drop_50mm": 1.5e-3,
    "sphere_on_beam_drop_50mm_shear": 1.5e-3,
    "sphere_on_beam_drop_600mm": 1.5e-3,
    "sphere_on_beam_drop_600mm_shear": 1.5e-3,
}
VARIANTS = {
    "euler": ("beam.theory=euler",),
    "timoshenko": ("beam.theory=timoshenko",),
    "off centre": ("blow.point=0.3",),
    "damped": ("beam.damping_ratio=0.02",),
    "gravity": ("blow.gravity=9.80665",),
    "volterra": ("solver.stepper=volterra",),
    "sinusoidal": ("solver.stepper=sinusoidal",),
    "no tail": ("solver.static_tail=outputs", "wanted.tolerance=1e-3"),
    "few modes and steps": ("solver.modes=21", "solver.steps=16"),
}
KEPT = ("normal_load", "sphere_position", "deflection", "bending_stress", "beam_energy")


def cases():
    """Name, scene and overrides of every case."""
    for scene, duration in SCENES.items():
        short = (f"run.duration={duration}", f"run.output_rate={102.0 / duration}", "solver.check=none")
        for tolerance in TOLERANCES:
            yield f"{scene}, {tolerance:g}", scene, (*short, f"wanted.tolerance={tolerance}")
        for name, more in VARIANTS.items():
            yield f"{scene}, {name}", scene, (*short, "wanted.tolerance=1e-4", *more)


def result(scene: str, overrides) -> dict:
    """Costs, records, and channels at the kept instants, of a case."""
    run = simulate(load_scene(scene, list(overrides)))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([np.asarray(block[name]) for block in blocks]) for name in KEPT}
    rows = {name: np.concatenate([block.records[name] for block in blocks]) for name in ("contact", "extremes")}
    return {
        "costs": {name: int(run.report.costs[name]) for name in ("steps", "modes")},
        **{name: rounded(values.tolist(), 11) for name, values in rows.items()},
        **{name: rounded(values[list(INSTANTS)].tolist(), 11) for name, values in channels.items()},
    }


if __name__ == "__main__":
    write(RECORD, cases(), result)
