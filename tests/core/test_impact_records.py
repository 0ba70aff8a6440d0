"""Impacts, beams, soft discs and bodies that bounce against records: the same steps, contacts, loads and states.

The records were made by the engine before the compiled core, by Numba. Made anew they would only hold what the core
itself computes.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from bearing_twin import load_scene, simulate

LOOKS = 120  # more evaluations for the end of a contact: the search for it goes on to the last bit
LOAD, APPROACH, SPEED_OUT, IMPULSE, GAINED = 2, 3, 11, 12, 7  # columns of contacts


def known_cases(name: str, cases):
    """(known, scene, overrides) of the cases that a record holds."""
    known = json.loads(Path(__file__).with_name(f"{name}_record.json").read_text())
    return [pytest.param(known[case], *rest, id=case) for case, *rest in cases if case in known]


def ran(scene: str, overrides, names):
    """Report, channels by name, and contacts that have ended; of two values of a key the last counts."""
    last = {one.partition("=")[0]: one for one in (*overrides, "solver.check=none")}
    run = simulate(load_scene(scene, [*last.values()]))
    blocks = list(run.blocks())
    channels = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    records = {name: np.concatenate([block.records[name] for block in blocks]) for name in blocks[0].records}
    return run.report, channels, records


def assert_near(now, before, near: float, what: str):
    """Within a share of the greatest."""
    assert np.abs(now - np.array(before)).max() <= near * np.abs(before).max(), what


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
FALLING = {"ellipsoid_on_plane": 1.2, "ellipsoid_rocking": 0.06, "ellipsoid_tumbling": 0.25}
ROCKING = {
    "rk4": ("solver.stepper=rk4",),
    "volumetric": ("contact.normal=volumetric",),
    "linear": ("contact.normal=linear", "contact.stiffness=1e8"),
    "constant": ("contact.normal=constant",),
    "projected": ("contact.normal=hertz_differential",),
    "hunt_crossley": ("contact.restitution=0.7", "contact.damping_law=hunt_crossley", "contact.restitution_speed=1"),
    "relaxation": ("contact.restitution=1", "contact.relaxation_time=1e-6"),
    **{name: (f"contact.friction={name}",) for name in ("spot", "spot_medium", "pade1", "pade2")},
}


def impacts():
    for scene in ("two_spheres", "two_discs"):
        for tolerance in (1e-4, 1e-7, 1e-9):
            yield f"{scene}, {tolerance:g}", scene, ("solver.stepper=dop853", f"wanted.tolerance={tolerance}")
    for stepper in STEPPERS:
        for name, loss in (LOSSES | STEADY if stepper == "dop853" else LOSSES).items():
            yield f"two_spheres, {stepper}, {name}", "two_spheres", (f"solver.stepper={stepper}", *loss)
        for law in ("line", "johnson"):
            way = (f"solver.stepper={stepper}", f"contact.normal={law}", "motion.gap=0.01")
            yield f"two_discs, {stepper}, {law}", "two_discs", way
    for scene, duration in FALLING.items():
        short = (f"run.duration={duration}", "run.output_rate=2e3")
        for tolerance in (1e-4, 1e-6):
            yield f"{scene}, {tolerance:g}", scene, (*short, f"wanted.tolerance={tolerance}")
    short = ("run.duration=1e-3", "run.output_rate=1e5", "start.height=1e-4", "start.velocity=[0.5, 0, -0.3]")
    for name, more in ROCKING.items():
        yield f"ellipsoid_rocking, {name}", "ellipsoid_rocking", (*short, *more)


@pytest.mark.parametrize(("known", "scene", "overrides"), known_cases("impact", impacts()))
def test_impacts_and_ellipsoids(known, scene, overrides):
    """Where bodies bounce on, the last bits of a landing grow: within the tolerance of these runs."""
    names = known.keys() - {"costs", "contacts"}
    report, channels, records = ran(scene, (*overrides, "solver.allow_invalid=true"), names)
    assert report.costs["steps"] == pytest.approx(known["costs"]["steps"], rel=0.02, abs=2)
    assert report.costs["evaluations"] <= 1.02 * known["costs"]["evaluations"] + LOOKS
    near = 2e-5 if len(known["contacts"]) > 1 else 1e-7
    for name in names:
        (*before, most), values = known[name], channels[name]
        kept = np.linspace(0, len(values) - 1, 9).astype(int)[1:-1:2]
        assert np.abs(values[kept] - before).max() <= near * most, name
        assert abs(np.abs(values).max() - most) <= near * most, name
    before, now = (np.array(one)[:1] for one in (known["contacts"], records["contact"]))
    near = np.full(before.shape[1], 1e-7)
    if scene.startswith("ellipsoid"):  # the approach at the greatest load varies most, as the load is flat there
        near[:], near[APPROACH] = 2e-6, 1e-4
    else:  # what the numbers alone gain is of the last bits
        near[GAINED] = np.inf
    assert (np.abs(now - before) <= near * (np.abs(before) + 1e-300)).all()


ELLIPSOIDS = (
    "second.shape=ellipsoid", "second.semi_axes=[0.05,0.04,0.03]", "second.motion=free",
    "second.position=[0.004,0.002,-0.031]", "second.turn=[0.1,-0.2,0.3]", "second.velocity=[0.5,0,0.4]",
)  # fmt: skip
BODIES = {  # scene: duration [s], variants
    "two_bodies_groove": (0.03, {
        "sticking": ("contact.friction_coefficient=0.5",),
        "algebraic": ("contact.tracking=algebraic",),
        "differential": ("contact.tracking=differential",),
        "hertz_exact": ("contact.normal=hertz_exact",),
        "patch": ("contact.friction=spot",),
        "pade1": ("contact.friction=pade1",),
        "pade2": ("contact.friction=pade2",),
        "Hunt and Crossley": ("contact.damping_law=hunt_crossley", "contact.restitution_speed=0.3"),
        "turning groove": ("second.angular_velocity=[20,5,-3]",),
    }),
    "two_bodies_ellipsoid": (0.06, {
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
    }),
    "two_bodies_superellipsoid": (0.06, {"algebraic": ("contact.tracking=algebraic",)}),
}  # fmt: skip


def bodies():
    for scene, (duration, variants) in BODIES.items():
        short = (f"run.duration={duration}", f"run.output_rate={20.0 / duration}")
        for tolerance in ("1e-4", "1e-6"):
            yield f"{scene}, {tolerance}", scene, (*short, f"wanted.tolerance={tolerance}")
        for name, more in variants.items():
            yield f"{scene}, {name}", scene, (*short, "wanted.tolerance=1e-6", *more)


@pytest.mark.parametrize(("known", "scene", "overrides"), known_cases("two_bodies", bodies()))
def test_two_bodies(known, scene, overrides):
    """Rounding, which differs with the processor, decides where in a step a contact begins: other steps follow it."""
    report, channels, records = ran(scene, overrides, known.keys() - {"costs", "contacts"})
    assert report.costs["steps"] == pytest.approx(known["costs"]["steps"], rel=0.08, abs=20)
    before, now = np.array(known["contacts"]), records["contact"][: len(known["contacts"])]
    assert now.shape == before.shape
    assert now[0, [LOAD, IMPULSE]] == pytest.approx(before[0, [LOAD, IMPULSE]], rel=1e-7)
    off = np.abs(now - before).max(axis=0) / (np.abs(before).max(axis=0) + 1e-300)
    # Flat about the greatest load, and at the end of whatever step a load ended in.
    assert np.delete(off, [SPEED_OUT, APPROACH]).max() < (3e-4 if "contact.normal=overlap" in overrides else 2e-5)
    assert off[[SPEED_OUT, APPROACH]].max() < 1e-3
    for name in channels.keys() - {"normal_load"}:
        assert_near(channels[name][[7, 15]], known[name][:2], 5e-7, name)
        assert_near(channels[name][20], known[name][2], 2e-5, name)  # after up to four contacts


BEAMS = {  # with the duration of a run [s]
    "sphere_on_beam": 1e-3,
    "sphere_on_beam_long": 4e-3,
    "sphere_on_beam_drop_50mm": 1.5e-3,
    "sphere_on_beam_drop_600mm_shear": 1.5e-3,
}
BLOWS = {
    "timoshenko": ("beam.theory=timoshenko",),
    "off centre": ("blow.point=0.3",),
    "damped": ("beam.damping_ratio=0.02",),
    "gravity": ("blow.gravity=9.80665",),
    "volterra": ("solver.stepper=volterra", "solver.steps=500"),
    "sinusoidal": ("solver.stepper=sinusoidal",),
    "no tail": ("solver.static_tail=outputs", "solver.steps=15"),
    "few modes and steps": ("solver.modes=21", "solver.steps=16"),
}
FORCES = "normal_load", "bending_stress"
STEPS = {1e-3: 15, 1e-4: 26, 1e-6: 150}  # a contact, by tolerance, in the record


def beams():
    for scene, duration in BEAMS.items():
        short = (f"run.duration={duration}", f"run.output_rate={102.0 / duration}")
        for tolerance in (1e-3, 1e-6):
            yield f"{scene}, {tolerance:g}", scene, (*short, f"solver.steps={STEPS[tolerance]}")
        for name, more in BLOWS.items() if scene in ("sphere_on_beam", "sphere_on_beam_drop_50mm") else ():
            yield f"{scene}, {name}", scene, (*short, f"solver.steps={STEPS[1e-4]}", *more)


@pytest.mark.parametrize(("known", "scene", "overrides"), known_cases("beam", beams()))
def test_spheres_on_beams(known, scene, overrides):
    """Forces and stresses, which the record reads off polynomials in time, within the error of so many steps."""
    overrides = f"solver.modes={known['extremes'][0][-1]:.0f}", *overrides
    steps = int(next(word for word in reversed(overrides) if "steps" in word).partition("=")[2])
    of_force = max(1e-7, 7.0 / steps**2 if "solver.stepper=volterra" in overrides else 40.0 / steps**4)
    tables = {"contact": [3, 5], "extremes": [2]}  # columns of forces and stresses
    report, channels, records = ran(scene, overrides, known.keys() - {*tables, "costs"})
    for cost, before in known["costs"].items():
        assert abs(report.costs[cost] - before) <= 0.02 * before, cost
    for name, columns in tables.items():
        before, now = np.array(known[name]), records[name].copy()
        assert now[:, columns] == pytest.approx(before[:, columns], rel=of_force), name
        now[:, columns] = before[:, columns]
        if name == "extremes":  # the energy that rounding alone made
            now[:, 3] = before[:, 3]
        assert now == pytest.approx(before, rel=1e-7), name
    for name, values in channels.items():
        assert_near(values[[13, 101]], known[name], of_force if name in FORCES else 1e-7, name)


SOFT = {
    "linear": ("formulation=linear", "solver.allow_invalid=on"),
    "neo-Hookean": ("formulation=neo_hookean",),
    "neo-Hookean, plane stress": ("formulation=neo_hookean", "plane=stress", "solver.allow_invalid=on"),
    "plane stress": ("plane=stress", "solver.allow_invalid=on"),
    "against a disc": ("against=disc",),
    "full": ("mesh.integration=full",),
    "exponent 1.5": ("contact.exponent=1.5",),
    **{f"order {order}": (f"mesh.order={order}", "mesh.divisions=16") for order in (1, 2, 4)},
}


def discs():
    for scene in ("soft_discs_mean", "soft_discs_fast", "soft_discs_unequal"):
        for divisions in (6, 12, 24):
            yield f"{scene}, {divisions} divisions", scene, (f"mesh.divisions={divisions}",)
        for name, more in SOFT.items():
            yield f"{scene}, {name}", scene, ("mesh.divisions=12", *more)


@pytest.mark.parametrize(("known", "scene", "overrides"), known_cases("discs", discs()))
def test_soft_discs(known, scene, overrides):
    report, channels, _ = ran(scene, overrides, known.keys() - {"costs"})
    assert {name: report.costs[name] for name in known["costs"]} == known["costs"]
    shape = channels.pop("shape")[40]
    assert_near(shape[:: len(shape) // 5], known["shape"], 1e-7, "shape")
    for name, values in channels.items():
        assert_near(values[[10, 40, 100, 160]], known[name], 1e-7, name)
