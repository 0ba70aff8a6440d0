"""Impacts of two spheres and of two discs: closed forms, published numbers, balances, records, bodies that fail."""

import dataclasses
import json
import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.impact import equation_14, power_load, strike
from scipy.integrate import solve_ivp
from solved_impact import SolvedImpact

from bearing_twin import simulate
from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.base.sample import join_blocks
from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.command.log_commands import DrawnStream
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact import line as disc_impact
from bearing_twin.contact.laws import damping_for_restitution, law_names
from bearing_twin.contact.line import line_law
from bearing_twin.kinds.bodies import impact as impacts
from bearing_twin.kinds.bodies.derived import JOHNSON_ERROR, SPEED_ERROR
from bearing_twin.kinds.bodies.figures import CONTACT
from bearing_twin.kinds.bodies.impact import NO_LINE, Spring, collide
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.run.scene import load_scene
from bearing_twin.run.verify import verify

MASS = 0.1129  # reduced, of the two spheres of paper 3
STEEL = 4.0 / 3.0 * 2.1e11 / (2.0 * 0.91) * math.sqrt(0.01905 / 2.0)


def solved(*overrides, stepper="closed_form"):
    return SolvedImpact("two_spheres", f"solver.stepper={stepper}", *overrides)


def test_the_spheres_of_paper_3():
    """Eqs. (1) and (2) with the printed steel data."""
    assert impact.alpha(STEEL, MASS) == pytest.approx(1.143048864e-4, rel=1e-9)
    collision = solved()
    assert collision.contacts[0].duration == pytest.approx(6.278541908e-5, rel=1e-9)
    assert collision.peak_force == pytest.approx(132314.068, rel=1e-8)
    assert collision.greatest_approach == pytest.approx(4.26636418e-4, rel=1e-8)
    assert solved("motion.first_velocity=0.1").peak_force == pytest.approx(229.28, rel=1e-4)


def strikes(collision, truth, rel=1e-8):
    """Whether a solved impact is one that was followed by another program: figures and history."""
    assert collision.contacts[0].duration == pytest.approx(truth.duration, rel=rel)
    assert collision.peak_force == pytest.approx(truth.peak_force, rel=rel)
    assert collision.greatest_approach == pytest.approx(truth.greatest_approach, rel=rel)
    assert collision.restitution == pytest.approx(truth.restitution, rel=rel)
    inside = collision.time < truth.duration
    exact = truth.approach(collision.time[inside])
    assert inside.sum() > 100
    assert collision.values["approach"][inside] == pytest.approx(exact, abs=3e-7 * truth.greatest_approach)
    assert np.all(collision.force[~inside] == 0.0)


@pytest.mark.parametrize(("speed", "restitution"), [(0.01, 1.0), (1.0, 1.0), (20.0, 1.0), (3.0, 0.9), (3.0, 0.5)])
def test_closed_forms_and_histories_against_the_motion_followed(speed, restitution):
    """Elastic by the incomplete beta function; damped by the quadrature over the rates, both halves of its history."""
    collision = solved(f"motion.first_velocity={speed}", f"contact.restitution={restitution}")
    damping = damping_for_restitution(restitution, speed) if restitution < 1.0 else 0.0
    strikes(collision, strike(power_load(STEEL, damping), MASS, speed, 4.3e-4 * (speed / 20.0) ** 0.8))


@pytest.mark.parametrize("law", ["spheres", *law_names("line", ())])
def test_the_differential_equation_gives_the_closed_form(law):
    for_it = partial(solved_discs, law=law) if law in law_names("line", ()) else solved
    exact, collision = for_it(), for_it("wanted.tolerance=1e-12", stepper="dop853")
    assert collision.contacts[0].duration == pytest.approx(exact.contacts[0].duration, rel=1e-9)
    for name in ("peak_force", "greatest_approach", "restitution"):
        assert getattr(collision, name) == pytest.approx(getattr(exact, name), rel=1e-10 if law == "spheres" else 1e-9)
    assert collision.force == pytest.approx(exact.force, abs=(1e-9 if law == "spheres" else 1e-7) * exact.peak_force)
    if law == "spheres":
        assert collision.values["velocity"] == pytest.approx(exact.values["velocity"], abs=1e-8)
    total = collision.values["kinetic_energy"] + collision.values["elastic_energy"]
    assert total == pytest.approx(total[0], rel=1e-8)
    assert abs(collision.energy_closure) < 1e-10


@pytest.mark.parametrize("restitution", [0.9, 0.5])
def test_steady_damping_keeps_its_restitution_at_every_speed(restitution):
    """Which the other law does only at one; energy closes with what is left in the contact when the bodies part."""
    steady = f"contact.restitution={restitution}", "contact.damping_law=steady"
    for speed in (0.02, 20.0):
        collision = solved(*steady, f"motion.first_velocity={speed}", stepper="dop853")
        assert collision.restitution == pytest.approx(restitution, rel=1e-6)
        assert abs(collision.energy_closure) < 1e-6
    values = collision.values
    assert values["velocity"][-1, 1] - values["velocity"][-1, 0] == pytest.approx(restitution * 20.0, rel=1e-6)
    after = collision.time > collision.contacts[0].duration
    assert np.all(values["normal_load"][after] == 0.0)
    assert np.abs(np.diff(values["approach"])).max() < 1.1 * 20.0 * (collision.time[1] - collision.time[0])  # no jump
    assert collision.force.min() >= 0.0
    impulse = np.trapezoid(collision.force, collision.time)
    assert impulse == pytest.approx(collision.contacts[0].impulse, rel=1e-3)


@settings(max_examples=12, deadline=None)
@given(st.floats(0.1, 5.0), st.floats(-3.0, 3.0), st.floats(0.1, 10.0), st.sampled_from([1.0, 0.8]))
def test_momentum_is_kept_and_velocities_part_as_restitution_says(heavier, second, speed, restitution):
    overrides = (
        f"second.mass={heavier}", f"motion.first_velocity={second + speed}", f"motion.second_velocity={second}",
        f"contact.restitution={restitution}",
    )  # fmt: skip
    collision = solved(*overrides)
    velocity, masses = collision.values["velocity"], np.array([0.2258, heavier])
    momentum = velocity @ masses
    assert momentum == pytest.approx(momentum[0], abs=1e-9 * np.abs(masses * velocity[0]).sum())
    assert velocity[-1, 1] - velocity[-1, 0] == pytest.approx(restitution * speed, rel=1e-8)


def test_spheres_a_metre_apart_do_not_pass_through_each_other():
    """As they do where an adaptive integrator steps over the contact."""
    collision = solved("motion.gap=1.0")
    assert collision.contacts[0].start == pytest.approx(0.05, rel=1e-12)
    assert collision.contacts[0].duration == pytest.approx(6.278541908e-5, rel=1e-9)


def test_a_step_beyond_an_eighth_of_the_contact_is_refused_and_a_coarse_one_is_warned_of():
    from bearing_twin.run.scene import choose

    with pytest.raises(SceneError, match="at least 8 steps; use"):
        load_scene("two_spheres", ["solver.stepper=rk4", "solver.step=1.0e-5"])
    with pytest.raises(SceneError, match="at most 100000 steps; use"):  # which would be terabytes
        load_scene("two_discs", ["solver.stepper=rk4", "solver.step=1.0e-13"])
    coarse = load_scene("two_spheres", ["solver.stepper=symplectic_euler", "solver.step=6.0e-6"])
    assert "16 steps a contact" in choose(coarse).warnings[0]
    assert choose(load_scene("two_spheres", ["solver.stepper=rk4"])).warnings == ()


@pytest.mark.parametrize(("stepper", "order"), [("rk4", 2.0), ("symplectic_euler", 1.0)])
def test_fixed_steps_converge(stepper, order):
    exact, errors = solved().contacts[0].duration, []
    for count in (50, 800):
        step = exact / count
        errors.append(abs(solved(f"solver.step={step!r}", stepper=stepper).contacts[0].duration / exact - 1.0))
    assert math.log(errors[0] / errors[1]) / math.log(16.0) > order - 0.1


def test_numbers_that_are_not_finite_stop_the_run():
    for method in ("dop853", "rk4"):
        with pytest.raises(IntegrationError, match="not finite"):
            collide(Spring(math.nan, NO_LINE, 0.0), MASS, 20.0, method, 1e-9, 1e-6, 6e-5)


@pytest.mark.parametrize(
    ("scene", "override", "sentence"),
    [
        ("two_spheres", "motion.first_velocity=0", "never meet"),
        ("two_spheres", "solver.stepper=euler", "did you mean symplectic_euler|legal"),
        ("two_discs", "motion.first_velocity=0", "never meet"),
        ("two_discs", "motion.first_velocity=1e5", "cannot store .* below 8386 m/s"),
        ("two_discs", "contact.normal=hertz", "legal: auto, line, johnson"),
        ("ellipsoid_on_plane", "body.semi_axes=[0.1,0.1]", "list of 3 numbers"),
        ("ellipsoid_on_plane", "body.semi_axes=[1.0,0.1,0.01]", "choose a rounder body"),
        ("ellipsoid_on_plane", "start.height=-0.02", "presses the body in"),
        ("ellipsoid_on_plane", "contact.damping=0.1", "keep one of them"),
        ("ellipsoid_on_plane", "gravity=[0,0,9.8]", "must point along -z"),
    ],
)
def test_bad_input_gets_a_sentence(scene, override, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene(scene, [override])


def solved_discs(*overrides, law="line", stepper="closed_form"):
    return SolvedImpact("two_discs", f"contact.normal={law}", f"solver.stepper={stepper}", *overrides)


@pytest.mark.parametrize(
    ("radius", "thickness", "modulus", "nu", "speed"), [(1.0, 2.0, 5e9, 0.3, 10.0), (0.2, 0.1, 1e11, 0.25, 1.0)]
)
def test_the_closed_form_against_the_motion_followed(radius, thickness, modulus, nu, speed):
    """Eq. (14) bisected at every step instead of Lambert's function, and no integral of the energy."""
    mass = 0.5 * 2500.0 * math.pi * radius**2 * thickness
    law = line_law("line", radius, thickness, modulus, nu)
    deepest = disc_impact.greatest_approach(law, mass, speed)
    truth = strike(equation_14(radius, thickness, modulus, nu), mass, speed, float(deepest))
    assert deepest == pytest.approx(truth.greatest_approach, rel=1e-8)
    assert disc_impact.contact_time(law, mass, speed) == pytest.approx(truth.duration, rel=1e-8)
    assert disc_impact.peak_force(law, mass, speed) == pytest.approx(truth.peak_force, rel=1e-8)


def test_a_run_that_ends_early_says_so():
    run = simulate(load_scene("two_spheres", ["run.duration=3.0e-5"]))
    list(run)
    assert any("before the contact does" in flag for flag in run.report.flags)


@pytest.mark.parametrize(
    "lossy",
    [
        ["contact.restitution=0.7", "contact.damping_law=hunt_crossley", "contact.restitution_speed=0.01"],
        ["contact.damping=30.0"],
        ["contact.restitution=0.08", "contact.damping_law=steady"],
    ],
)
def test_a_run_whose_duration_is_left_open_outlasts_a_contact_that_loses_most(lossy):
    """At 1 m/s; with no loss these spheres part after 0.114 ms."""
    run = simulate(load_scene("two_spheres", ["motion.first_velocity=1.0", "solver.companion=off", *lossy]))
    list(run)
    assert not any("before the contact does" in flag for flag in run.report.flags)
    assert run.report.figures["restitution"] < 0.1
    assert run.report.figures["contact_duration_s"] < run.report.simulated_seconds < 3.0e-3


def test_a_picture_that_cannot_be_written_takes_no_figure_along(tmp_path, monkeypatch, run_cli):
    def refuse(*_):
        raise BearingTwinError("the disk is full")

    monkeypatch.setattr(DrawnStream, "write", refuse)
    reported, error = run_cli("simulate", "two_spheres", "--plot", tmp_path / "a.png", "--json", code=BAD_INPUT)
    assert json.loads(reported)["peak_force_n"] > 0.0
    assert "plot" not in json.loads(reported)
    assert error.strip().endswith("bearing_twin: the disk is full")


def logged(run, block, path):
    """The log of a run that gave out this block."""
    made = SimpleNamespace(scene=run.scene, choice=run.choice, blocks=lambda: iter([block]), report=run.report)
    return read_log(write_log(made, path).path)


def test_verify_looks_at_what_happened_between_outputs_too(tmp_path, run_json):
    """A record that was altered by 1 uN, one that is NaN, and one that is not there."""
    run = simulate(load_scene("two_spheres", ["run.output_rate=5e5"]))
    outputs = join_blocks(list(run.blocks()))
    rows = outputs.records["contact"]
    altered = rows + 1e-6 * np.array([channel.name == "peak_force" for channel in CONTACT.columns])
    unknown = np.where([channel.name == "peak_force" for channel in CONTACT.columns], np.nan, rows)
    cases = {"same": (rows, 0.0), "altered": (altered, 1e-6), "nan": (unknown, np.inf), "none": (rows[:0], np.inf)}
    for name, (contacts, deviation) in cases.items():
        path = tmp_path / f"{name}.mcap"
        log = logged(run, dataclasses.replace(outputs, records=outputs.records | {"contact": contacts}), path)
        assert verify(log).greatest == pytest.approx(deviation, rel=1e-3)
        assert verify(log).recounted == (("contact",) if name == "none" else ())
        assert main(["verify", str(path), "--strict"]) == (DOUBTFUL if deviation else DONE)
    assert run_json("verify", path)["records_not_as_many"] == ["contact"]


def test_what_happens_at_an_output_is_read_with_that_output(tmp_path, monkeypatch):
    """Also with the last one of a message."""
    monkeypatch.setattr("bearing_twin.log.stream.LARGEST_BLOCK", 8000)
    run = simulate("two_spheres")
    outputs = join_blocks(list(run.blocks()))
    end = next(logged(run, outputs, tmp_path / "first.mcap").blocks()).time_ns[-1]
    rows = outputs.records["contact"].copy()
    rows[:, 0] = 1e-9 * end
    moved = dataclasses.replace(outputs, records={"contact": rows})
    first, *later = logged(run, moved, tmp_path / "second.mcap").blocks()
    assert first.time_ns[-1] == end
    assert np.array_equal(first.records["contact"], rows)
    assert later
    assert not any(len(block.records["contact"]) for block in later)


RADIUS, MODULUS, RATIO, DENSITY = 0.02, 2.0e11, 0.3, 7800.0
STEEL_BALLS = {"young_modulus": MODULUS, "poisson_ratio": RATIO, "density": DENSITY}
COEFFICIENT = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - RATIO**2)) * math.sqrt(RADIUS)
MASS_OF_A_BALL = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
SPEED = 0.5
DAMPED = {
    "damping": (1.0, lambda x, rate: COEFFICIENT * x**1.5 * (1.0 + rate)),
    "viscosity": (2e4, lambda x, rate: COEFFICIENT * x**1.5 + 2e4 * x**0.25 * rate),
}


def deepest(load):
    """Greatest approach [m] of the sphere, and that at its greatest load."""

    def turns(_, y):
        return y[1]

    turns.terminal = True
    collision = solve_ivp(
        lambda _, y: [y[1], -load(max(y[0], 0.0), y[1]) / MASS_OF_A_BALL],
        (0.0, 1.0),
        [0.0, SPEED],
        "DOP853",
        events=turns,
        rtol=1e-12,
        atol=[1e-18, 1e-12],
        max_step=1e-7,
    )
    hardest = max(range(len(collision.t)), key=lambda k: load(max(collision.y[0, k], 0.0), collision.y[1, k]))
    return collision.y[0, -1], collision.y[0, hardest]


@pytest.mark.parametrize("key", DAMPED)
def test_damping_puts_the_greatest_approach_after_the_greatest_load(key):
    value, load = DAMPED[key]
    scene = {
        "kind": "ellipsoid_on_plane",
        "body": {"semi_axes": [RADIUS] * 3, "material": STEEL_BALLS},
        "plane": {"material": STEEL_BALLS},
        "start": {"height": 1e-4, "velocity": [0.0, 0.0, -SPEED]},
        "gravity": [0.0, 0.0, 0.0],
        "contact": {key: value, "friction_coefficient": 0.0},
        "run": {"duration": 1e-3},
    }
    run = simulate(scene)
    blocks = list(run.blocks())
    exact, at_load = deepest(load)
    assert at_load < 0.99 * exact
    collision = run.report.as_dict()
    assert collision["greatest_approach_m"] == pytest.approx(exact, rel=1e-8)
    assert abs(collision["greatest_approach_m"] - exact) < 3.0 * collision["greatest_approach_m_error"] + 1e-10 * exact
    assert max(block.values["approach"].max() for block in blocks) <= exact * (1.0 + 1e-8)


def failed(name, *overrides) -> IntegrationError:
    with pytest.raises(IntegrationError) as caught:
        for _ in simulate(load_scene(name, overrides)).blocks():
            pass
    return caught.value


@pytest.mark.parametrize(
    ("name", "overrides", "reason", "body", "contact"),
    [
        ("ellipsoid_on_plane", ("start.velocity=[0, 0, -2000]",), "too deep", "body", "plane"),
        ("two_bodies_groove", ("first.velocity=[0, 0, -2000]",), "", "first", "second"),
    ],
)
def test_bodies_that_bounce_are_named(name, overrides, reason, body, contact):
    error = failed(name, *overrides)
    assert error.reason in ((reason,) if reason else ("too deep", "untracked"))
    assert (error.body, error.contact) == (body, contact)
    assert math.isfinite(error.seconds)


@pytest.mark.parametrize(("stepper", "limit"), [("dop853", "LONGEST"), ("rk4", "MAX_NODES"), ("dop853", "LEAST_STEP")])
def test_bodies_that_do_not_part_are_named(stepper, limit, monkeypatch):
    """Where a contact may take a tenth of its time, or ten steps, or where no step is long enough."""
    monkeypatch.setattr(impacts, limit, {"LONGEST": 0.1, "MAX_NODES": 10, "LEAST_STEP": 1e9}[limit])
    error = failed("two_spheres", "contact.restitution=0.8", f"solver.stepper={stepper}", "motion.gap=1e-3")
    reason = "not finite" if limit == "LEAST_STEP" else "no end"
    assert (error.reason, error.body, error.contact) == (reason, "first", "second")
    assert error.seconds > 0.0


def test_a_sphere_that_bounces_on_a_beam_for_ever_is_named(monkeypatch):
    monkeypatch.setattr("bearing_twin.kinds.beam.motion.MAX_CONTACTS", 1)
    error = failed("sphere_on_beam_drop_50mm")
    assert (error.reason, error.body, error.contact) == ("no end", "sphere", "beam")
    assert error.seconds > 0.0


SHARES = (0.01, 0.03, 0.06, 0.1, 0.14)  # of the speed of waves


def met_at(share, ratio=0.3, thickness=2.0):
    """Overrides for discs that come with that share of the speed of waves in them."""
    speed = 2.0 * share * math.sqrt(5e9 / 2500.0)
    return f"motion.first_velocity={speed}", f"disc.material.poisson_ratio={ratio}", f"disc.thickness={thickness}"


def off_elements(share, ratio, thickness, *mesh):
    """Relative errors of force and contact time by Johnson's law against finite elasticity with a stiff penalty.

    The force by elements is averaged over 2 % of the contact: single elements ring as they touch.
    """
    from bearing_twin.kinds.soft_discs.motion import solve as by_elements

    shared = met_at(share, ratio, thickness)
    collision = solved_discs(*shared, "wanted.outputs=peaks", law="johnson")
    finer = (*mesh, "contact.stiffness_ratio=300")
    elements = by_elements(load_scene("soft_discs_fast", [*shared, *finer]).parameters, frames=2)
    force = elements.column("normal_load")
    lasted = elements.step * np.flatnonzero(force)[-1]
    width = int(0.02 * lasted / elements.step)
    peak = np.convolve(force, np.full(width, 1.0 / width), "valid").max()
    return collision.peak_force / peak - 1.0, collision.contacts[0].duration / lasted - 1.0


def test_the_numbers_that_say_what_line_contact_errs_by_have_their_study():
    """JOHNSON_ERROR bounds both errors of slow discs; SPEED_ERROR is that of the force over the share of the speed."""
    mesh = "mesh.divisions=24", "mesh.order=3"
    slow = [abs(deviation) for share in (0.003, 0.01) for deviation in off_elements(share, 0.3, 2.0, *mesh)]
    assert 0.85 * JOHNSON_ERROR < max(slow) <= JOHNSON_ERROR
    forces, times = zip(*(off_elements(share, 0.3, 2.0, *mesh) for share in SHARES), strict=True)
    assert forces == pytest.approx((0.034, 0.097, 0.184, 0.296, 0.418), abs=0.005)
    assert times == pytest.approx((0.031, -0.002, -0.048, -0.094, -0.143), abs=0.005)
    assert np.median(np.divide(forces, SHARES)) == pytest.approx(SPEED_ERROR, rel=0.05)
