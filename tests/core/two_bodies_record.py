"""Steps, contacts and states of two bodies: `python tests/core/two_bodies_record.py` writes two_bodies_record.json.

The record was made by the engine before the compiled core, by Numba: it is the truth of the port. Made anew, it would
only hold what the core itself computes.
"""

from pathlib import Path

import numpy as np
from records import rounded, write

from bearing_twin import load_scene, simulate

RECORD = Path(__file__).with_name("two_bodies_record.json")
INSTANTS = (7, 15, 20)  # outputs that are kept, of 20 after the first
CONTACTS = 4  # that are kept
KEPT = ("normal_load", "position", "velocity", "angular_velocity", "contact_point", "dissipated_friction")
SCENES = {  # with the duration [s]
    "two_bodies_groove": 0.03,
    "two_bodies_ellipsoid": 0.06,
    "two_bodies_superellipsoid": 0.06,
}
TOLERANCES = ("1e-4", "1e-6", "1e-9")
ELLIPSOIDS = (
    "second.shape=ellipsoid",
    "second.semi_axes=[0.05,0.04,0.03]",
    "second.motion=free",
    "second.position=[0.004,0.002,-0.031]",
    "second.turn=[0.1,-0.2,0.3]",
    "second.velocity=[0.5,0,0.4]",
)
VARIANTS = {  # by scene
    "two_bodies_groove": {
        "sticking": ("contact.friction_coefficient=0.5",),
        "algebraic": ("contact.tracking=algebraic",),
        "differential": ("contact.tracking=differential",),
        "hertz_exact": ("contact.normal=hertz_exact",),
        "patch": ("contact.friction=spot",),
        "pade1": ("contact.friction=pade1",),
        "pade2": ("contact.friction=pade2",),
        "Hunt and Crossley": ("contact.damping_law=hunt_crossley", "contact.restitution_speed=0.3"),
        "turning groove": ("second.angular_velocity=[20,5,-3]",),
    },
    "two_bodies_ellipsoid": {
        "volumetric": ("contact.normal=volumetric",),
        "constant": ("contact.normal=constant",),
        "linear": ("contact.normal=linear", "contact.stiffness=2e7"),
        "states": ("contact.normal=hertz_differential",),
        "states left": ("contact.normal=hertz_unprojected",),
        "fine patch": ("contact.friction=spot_fine",),
        "relaxation": ("contact.restitution=1", "contact.relaxation_time=1e-6"),
        "differential": ("contact.tracking=differential",),
        "overlap": ("contact.normal=overlap",),
        "on an ellipsoid": ELLIPSOIDS,
        "on an ellipsoid, differential": (*ELLIPSOIDS, "contact.tracking=differential"),
    },
    "two_bodies_superellipsoid": {"algebraic": ("contact.tracking=algebraic",)},
}


def cases():
    """Name, scene and overrides of every case."""
    for scene, duration in SCENES.items():
        short = (f"run.duration={duration}", f"run.output_rate={20.0 / duration}", "solver.check=none")
        for tolerance in TOLERANCES:
            yield f"{scene}, {tolerance}", scene, (*short, f"wanted.tolerance={tolerance}")
        for name, more in VARIANTS[scene].items():
            yield f"{scene}, {name}", scene, (*short, "wanted.tolerance=1e-6", *more)


def result(scene: str, overrides) -> dict:
    """Costs, the contacts that ended, and channels at the kept instants, of a case."""
    run = simulate(load_scene(scene, list(overrides)))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([np.asarray(block[name]) for block in blocks]) for name in KEPT}
    contacts = np.concatenate([block.records["contact"] for block in blocks])
    return {
        "costs": {name: int(cost) for name, cost in run.report.costs.items() if name not in ("wall", "touches")},
        "contacts": rounded(contacts[:CONTACTS].tolist(), 11),
        **{name: rounded(values[list(INSTANTS)].tolist(), 11) for name, values in channels.items()},
    }


if __name__ == "__main__":
    write(RECORD, cases(), result)
