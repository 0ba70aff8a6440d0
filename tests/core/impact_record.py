"""Steps, loads and states of impacts, for impact_record.json: `python tests/core/impact_record.py` writes it.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("impact_record.json")
TOLERANCES = {"two_spheres": (1e-4, 1e-7, 1e-9), "two_discs": (1e-4, 1e-7, 1e-9)}
FALLING = (1e-4, 1e-6, 1e-8)
STEPPERS = ("closed_form", "dop853", "rk4", "symplectic_euler")
LOSSES = {
    "elastic": (),
    "hunt_crossley": ("contact.restitution=0.7",),
    "linear": ("contact.normal=linear", "contact.stiffness=1e8", "contact.damping=0.01"),
}
STEADY = {
    "steady": ("contact.restitution=0.6", "contact.damping_law=steady"),
    "viscosity": ("contact.viscosity=3e4",),
    "steady linear": ("contact.normal=linear", "contact.stiffness=1e8", "contact.viscosity=1e3"),
}
DURATIONS = {"ellipsoid_on_plane": 1.2, "ellipsoid_rocking": 0.06, "ellipsoid_tumbling": 0.25}
VARIANTS = {
    "rk4": ("solver.stepper=rk4",),
    "volumetric": ("contact.normal=volumetric",),
    "linear": ("contact.normal=linear", "contact.stiffness=1e8"),
    "constant": ("contact.normal=constant",),
    "projected": ("contact.normal=hertz_differential",),
    "hunt_crossley": ("contact.restitution=0.7", "contact.damping_law=hunt_crossley", "contact.restitution_speed=1"),
    "relaxation": ("contact.restitution=1", "contact.relaxation_time=1e-6"),
    **{name: (f"contact.friction={name}",) for name in ("spot", "spot_medium", "pade1", "pade2")},
}
CHANNELS = {
    "impact": ("normal_load", "approach", "velocity", "elastic_energy"),
    "ellipsoid": ("normal_load", "friction_force", "position", "angular_velocity"),
}


def cases():
    """Name, scene, overrides and channels of every case."""
    for scene, tolerances in TOLERANCES.items():
        for tolerance in tolerances:
            yield f"{scene}, {tolerance:g}", scene, ("solver.stepper=dop853", f"wanted.tolerance={tolerance}"), "impact"
    for stepper in STEPPERS:
        for name, loss in (LOSSES | STEADY if stepper == "dop853" else LOSSES).items():
            yield f"two_spheres, {stepper}, {name}", "two_spheres", (f"solver.stepper={stepper}", *loss), "impact"
        for law in ("line", "johnson"):
            way = (f"solver.stepper={stepper}", f"contact.normal={law}", "motion.gap=0.01")
            yield f"two_discs, {stepper}, {law}", "two_discs", way, "impact"
    for scene, duration in DURATIONS.items():
        short = (f"run.duration={duration}", "run.output_rate=2e3")
        for tolerance in FALLING:
            yield f"{scene}, {tolerance:g}", scene, (*short, f"wanted.tolerance={tolerance}"), "ellipsoid"
    short = ("run.duration=1e-3", "run.output_rate=1e5", "start.height=1e-4", "start.velocity=[0.5, 0, -0.3]")
    for name, more in VARIANTS.items():
        yield f"ellipsoid_rocking, {name}", "ellipsoid_rocking", (*short, *more), "ellipsoid"


def result(scene: str, overrides, family: str) -> dict:
    """Costs, ends of contacts, and channels at some instants, of a case."""
    run = simulate(load_scene(scene, [*overrides, "solver.check=none", "solver.allow_invalid=true"]))
    blocks = list(run.blocks())
    contacts = [row for block in blocks for row in np.asarray(block.records["contact"])]
    found = {"costs": {name: int(cost) for name, cost in run.report.costs.items()}, "contacts": contacts[:3]}
    for name in CHANNELS[family]:
        values = np.concatenate([np.asarray(block[name]) for block in blocks])
        kept = np.linspace(0, len(values) - 1, 9).astype(int)[1:-1]
        found[name] = [*values[kept[::2]], np.abs(values).max()]
    return _rounded(found)


def _rounded(values):
    if isinstance(values, dict):
        return {name: _rounded(one) for name, one in values.items()}
    if isinstance(values, int):
        return values
    return [_rounded(one) for one in values] if isinstance(values, (list, np.ndarray)) else float(f"{values:.12g}")


if __name__ == "__main__":
    write(RECORD, cases(), result)
