"""Beams of Euler and of Timoshenko: modes, statics, impacts, against published numbers and an independent program."""

import functools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runs import reported
from solved_impact import SolvedImpact

from bearing_twin.base.errors import IntegrationError, SceneError, Stopped
from bearing_twin.base.stopping import Halt
from bearing_twin.charts.reference import strike
from bearing_twin.kinds.beam.motion import (
    beam_of,
    deflection_shapes,
    impact_speed,
    modes_of,
    rectangular_beam,
    solve_impact,
    sphere_of,
    static_deflection,
    static_stress,
    stress_shapes,
)
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.simulation import Simulation, simulate

CLASSICAL = rectangular_beam(0.1535, 0.01, 0.01, 2.158e11, 7960.0)


STEEL = 2.158e11, 7960.0, 0.0, 0.3
CLASSICAL_BLOW = rectangular_beam(0.1535, 0.01, 0.01, *STEEL)
SHEAR = "beam.theory=timoshenko"
DROP = "sphere_on_beam_drop_50mm_shear"


@functools.cache
def solved(scene="sphere_on_beam", *overrides):
    return SolvedImpact(scene, *overrides)


def parts(scene="sphere_on_beam", count=61, overrides=(), theory="euler"):
    """Beam, modes, sphere, speed and duration of a scene, for calls below the scene."""
    parameters = load_scene(scene, overrides).parameters
    beam = beam_of(parameters, theory)
    modes = modes_of(beam, parameters.blow.point * beam.span, count)
    return beam, modes, sphere_of(parameters), impact_speed(parameters.blow), parameters.run.duration


@functools.cache
def thrown(scene="sphere_on_beam", steps=200, method="modes", count=61, overrides=(), theory="euler"):
    """The motion of a scene with that many modes and steps."""
    return solve_impact(*parts(scene, count, overrides, theory), steps, method)


def numbers(motion):
    """Durations, peaks, impulses and leaving speed."""
    return np.array([number for contact in motion.contacts for number in contact[1:]] + [motion.pieces.motions[-1, 1]])


@pytest.mark.parametrize(
    ("scene", "peaks", "restitution"),
    [
        (DROP, (1029.92, 1043.85), 0.91630),
        ("sphere_on_beam_drop_600mm_shear", (4304.22, 2133.8, 2695.1), 0.74663),
        ("sphere_on_beam_long", (8.8877, 11.578, 6.810), 0.94585),
        ("sphere_on_beam", (4.9341,), 0.29854),
    ],
)
def test_shear_and_rotary_inertia_change_what_follows_a_blow(scene, peaks, restitution):
    impact = solved(scene, "solver.steps=150", *(() if "shear" in scene else (SHEAR,)))
    assert [contact.peak_force for contact in impact.contacts] == pytest.approx(peaks, rel=4e-5)
    assert impact.restitution == pytest.approx(restitution, rel=3e-5)
    assert abs(impact.energy_closure) < 1e-9
    total = sum(impact.values[name] for name in ("kinetic_energy", "beam_energy", "elastic_energy"))
    assert total == pytest.approx(total[0], rel=1e-6)
    if scene == DROP:
        times = [time for contact in impact.contacts for time in (contact.start, contact.start + contact.duration)]
        assert times == pytest.approx([0.0, 64.34e-6, 539.63e-6, 592.10e-6], abs=1e-8)
    if scene == "sphere_on_beam":
        assert impact.contacts[0].duration == pytest.approx(158.48e-6, abs=5e-9)


def test_a_program_without_modes_finds_the_same():
    """Staggered differences of the equations themselves, with Richardson's extrapolation; forces, times and stress."""
    point = 0.3
    impact = thrown(DROP, overrides=(f"blow.point={point}",), count=301, theory="timoshenko")
    speed, pieces = impact.pieces.motions[0, 1], []
    for cells in (150, 300):
        blow = strike(impact.beam, impact.sphere.mass, impact.sphere.coefficient, speed, point, impact.end, cells)
        early = np.array([30e-6, 60e-6])  # within the first contact
        moving = [np.interp(early, blow.time, column) for column in (blow.deflection, blow.stress)]
        pieces.append(np.concatenate([blow.contacts[:, 1] - blow.contacts[:, 0], blow.contacts[:, 2], *moving]))
    limit = (4.0 * pieces[1] - pieces[0]) / 3.0
    states, force, _, _ = impact.at(early)
    q, points = impact.coordinates(states), [point * impact.beam.span]
    exact = [contact[column] for column in (1, 2) for contact in impact.contacts]
    for shapes in (
        deflection_shapes(impact.beam, impact.modes, points),
        stress_shapes(impact.beam, impact.modes, points),
    ):
        exact += list(q @ shapes[0][0] + force * shapes[1][0])
    assert len(impact.contacts) >= 2
    assert limit == pytest.approx(np.array(exact), rel=3e-4)
    assert limit[:1] == pytest.approx(exact[:1], rel=2e-6)


@pytest.mark.parametrize("beam", [CLASSICAL, CLASSICAL_BLOW], ids=["euler", "timoshenko"])
def test_modes_with_their_tail_make_up_the_statics(beam):
    """F l^3 / 48 EI and stress (F l / 4) / (b h^2 / 6) at mid-span; Maxwell; shear adds near far / (l K G A)."""
    middle, load, point = 0.5 * beam.span, 0.37 * beam.span, 0.81 * beam.span
    bent = static_deflection(CLASSICAL, middle, middle)
    assert bent == pytest.approx(beam.span**3 / (48.0 * beam.rigidity), rel=1e-13)
    assert static_stress(beam, middle, middle) == pytest.approx(0.25 * beam.span / (0.01**3 / 6.0), rel=1e-13)
    exact = static_deflection(beam, point, load)
    assert static_deflection(beam, load, point) == pytest.approx(exact, rel=1e-12)
    added = load * (beam.span - point) / (beam.span * beam.shear_rigidity)
    assert exact == pytest.approx(static_deflection(CLASSICAL, point, load) + added, rel=1e-12)
    modes = modes_of(beam, load, 7)
    static = modes.shape / (modes.omega**2 * modes.modal_mass)
    for shapes, expected in (
        (deflection_shapes(beam, modes, [point]), exact),
        (stress_shapes(beam, modes, [point]), static_stress(beam, point, load)),
    ):
        assert (shapes[0] @ static + shapes[1])[0] == pytest.approx(expected, rel=1e-9, abs=1e-20)


SCENES = ("sphere_on_beam", "sphere_on_beam_long", "sphere_on_beam_drop_50mm", "sphere_on_beam_drop_600mm")


def test_the_classical_impact():
    impact = solved("sphere_on_beam", "run.output_rate=2.0e7")
    assert len(impact.contacts) == 1
    assert impact.contacts[0].duration == pytest.approx(1.563859640e-4, rel=1e-8)
    assert impact.peak_force == pytest.approx(4.977656515, rel=1e-8)
    assert impact.restitution == pytest.approx(0.302327320, rel=1e-8)
    assert impact.figures["peak_deflection_m"] == pytest.approx(1.12461867e-6, rel=1e-8)
    assert impact.figures["peak_stress_pa"] == pytest.approx(5.688573e5, rel=1e-6)
    assert impact.time[impact.force.argmax()] == pytest.approx(7.254815e-5, abs=1e-7)
    assert impact.time[impact.values["deflection"][:, 0].argmax()] == pytest.approx(3.2370e-4, abs=2e-7)


def test_the_greatest_stress_of_a_long_run_is_not_missed():
    """Waves meet for some 10 µs now and then."""
    impact = solved("sphere_on_beam_drop_50mm", "run.duration=0.3", "run.output_rate=5e5", "outputs.stations=3")
    for name, figure in (("deflection", "peak_deflection_m"), ("bending_stress", "peak_stress_pa")):
        outputs = np.abs(impact.values[name]).max()
        assert outputs <= impact.figures[figure] < 1.01 * outputs


def test_the_drop_of_50_mm_strikes_twice():
    impact = solved("sphere_on_beam_drop_50mm", "wanted.tolerance=1e-8")
    first, second = impact.contacts
    assert (first.peak_force, second.peak_force) == pytest.approx((1062.59264, 752.19563), rel=2e-8)
    assert (first.duration, second.duration) == pytest.approx((62.09069e-6, 47.73981e-6), rel=1e-7)
    assert second.start == pytest.approx(527.34e-6, abs=5e-9)
    assert impact.restitution == pytest.approx(0.66818008, rel=2e-8)
    report = reported("sphere_on_beam_drop_50mm", "wanted.tolerance=1e-8")
    assert report.figures["contact_duration_s"] == pytest.approx(first.duration + second.duration, rel=1e-12)
    assert any("is beyond the yield pressure" in flag for flag in report.flags)


@pytest.mark.parametrize(("scene", "contacts"), [("sphere_on_beam", 1), ("sphere_on_beam_long", 3)])
def test_the_integral_equation_agrees_with_the_modes_of_euler(scene, contacts):
    """Eq. (9) against modes and spring: hats in time, errors of step^2 removed by one extrapolation, to 1e-8."""
    exact = thrown(scene, 500)
    coarse, fine = (thrown(scene, steps, "volterra") for steps in (4000, 8000))
    assert len(exact.contacts) == len(fine.contacts) == contacts
    better = (4.0 * numbers(fine) - numbers(coarse)) / 3.0
    assert better == pytest.approx(numbers(exact), rel=1e-8)
    assert numbers(fine) == pytest.approx(numbers(exact), rel=2e-6)


@pytest.mark.parametrize(("method", "steps", "order"), [("volterra", (250, 1000), 2.0), ("modes", (8, 64), 2.8)])
def test_errors_fall_with_the_step(method, steps, order):
    exact = numbers(thrown(steps=500))
    errors = [np.abs(numbers(thrown(steps=count, method=method)) / exact - 1.0).max() for count in steps]
    assert math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0]) > order - 0.15


@pytest.mark.parametrize(("theory", "order"), [("euler", 6.0), ("timoshenko", 3.0)])
def test_errors_fall_with_the_cube_of_the_highest_frequency(theory, order):
    exact, *coarser = (
        numbers(thrown("sphere_on_beam_drop_50mm", 200, count=count, theory=theory)) for count in (501, 11, 41)
    )
    errors = [np.abs(numbers / exact - 1.0).max() for numbers in coarser]
    assert math.log(errors[0] / errors[1]) / math.log(41 / 11) > order


def test_the_sinusoidal_force_of_the_abstract_fails_its_energy_check():
    """Paper 2's abstract: the beam receives 2 to 11 times the energy the sphere has."""
    for scene in SCENES:
        impact = solved(scene, "solver.stepper=sinusoidal")
        assert 2.0 < impact.energy_closure < 11.5
        assert reported(scene, "solver.stepper=sinusoidal").status == "failed: energy"
    assert reported("sphere_on_beam", "beam.theory=auto", "wanted.tolerance=1e-3").status == "done"
    chosen = choose(load_scene("sphere_on_beam", ["solver.stepper=sinusoidal"]))
    assert "more energy than the sphere has" in chosen.warnings[0]


def test_no_touch_is_stepped_over_in_free_flight():
    """Against a fine scan of the gap after the first contact of the drop of 50 mm."""
    motion = thrown("sphere_on_beam_drop_50mm")
    first, second = motion.contacts
    flight = first.start + first.duration, second.start

    def gaps(times):
        states, force, position, _ = motion.at(times)
        assert not force.any()
        return position - motion.coordinates(states) @ motion.modes.shape

    length = flight[1] - flight[0]
    assert gaps(np.linspace(flight[0] + 1e-7, flight[1] - 1e-9 * length, 2000)).max() < 0.0
    # Gaps that close for less than 1e-9 of a contact are passed.
    assert abs(gaps([np.nextafter(flight[1], 0.0)])[0]) < 2e-9 * first.duration * motion.pieces.motions[0, 1]


@settings(max_examples=15, deadline=None)
@given(st.floats(0.1, 0.9), st.floats(0.005, 0.02), st.floats(0.01, 3.0))
def test_balances_hold_wherever_and_however_hard_it_strikes(point, radius, speed):
    overrides = (f"blow.point={point!r}", f"sphere.radius={radius!r}", f"blow.speed={speed!r}")
    motion = thrown(steps=100, count=41, overrides=overrides)
    kinetic, stored, _ = motion.energies()
    brought = 0.5 * motion.sphere.mass * speed**2
    contact = 0.4 * motion.at([motion.end])[1][0] ** (5.0 / 3.0) / motion.sphere.coefficient ** (2.0 / 3.0)
    assert kinetic + stored + contact == pytest.approx(brought, rel=1e-5)
    lost = motion.sphere.mass * (speed - motion.pieces.motions[-1, 1])
    assert sum(contact.impulse for contact in motion.contacts) == pytest.approx(lost, rel=1e-9)


def test_gravity_is_off_unless_asked_for_and_matters_at_a_centimetre_a_second():
    weightless, falling = solved(), solved("sphere_on_beam", "blow.gravity=9.80665")
    assert reported("sphere_on_beam").figures["gravity_m_s2"] == 0.0
    assert falling.contacts[0].peak_force / weightless.contacts[0].peak_force > 1.03
    assert falling.contacts[0].impulse / weightless.contacts[0].impulse > 1.05
    assert abs(falling.energy_closure) < 1e-8
    assert any("may touch the beam again" in flag for flag in reported("sphere_on_beam", "blow.gravity=9.80665").flags)


def test_a_sphere_that_comes_to_rest_on_the_beam_presses_it_by_its_weight():
    overrides = "blow.gravity=9.80665", "beam.damping_ratio=0.1", "run.duration=0.1", "wanted.tolerance=1e-3"
    impact = solved("sphere_on_beam", *overrides, "wanted.outputs=peaks", "run.output_rate=1e4")
    weight = thrown().sphere.mass * 9.80665
    assert impact.force[-100:] == pytest.approx(np.full(100, weight), rel=1e-2)


@pytest.mark.parametrize("stepper", ["modes", "volterra"])
def test_a_contact_that_the_end_of_the_run_cuts_ends_there_and_is_said_to_go_on(stepper):
    """Its duration was that of whole steps, whose error was 1.5 %, and it counted as ended."""
    report = reported("sphere_on_beam", "run.duration=1e-5", "wanted.tolerance=1e-4", f"solver.stepper={stepper}")
    assert report.figures["contact_duration_s"] == pytest.approx(1e-5, rel=1e-12)
    assert report.errors["wanted_errors"]["peaks"]["error"] < 1e-4
    assert sum("goes on at the end of the run" in flag for flag in report.flags) == 1
    assert not any(word in flag for flag in report.flags for word in ("possible", "before the contact", "wave takes"))


def test_damping_takes_energy_and_the_books_still_balance():
    free, damped = solved(), solved("sphere_on_beam", "beam.damping_ratio=0.02")
    motion = thrown(overrides=("beam.damping_ratio=0.02",))
    kinetic, stored, dissipated = motion.energies()
    assert dissipated > 0.0
    assert damped.values["beam_energy"][-1] < 0.5 * free.values["beam_energy"][-1]
    assert abs(damped.energy_closure) < 1e-9
    assert kinetic + stored + dissipated == pytest.approx(0.5 * motion.sphere.mass * 1e-4, rel=1e-9)


def test_numbers_that_are_not_finite_stop_the_run():
    beam, modes, sphere, speed, until = parts()
    for method in ("modes", "volterra"):
        with pytest.raises(IntegrationError, match="not finite"):
            solve_impact(beam, modes._replace(shape=math.nan * modes.shape), sphere, speed, until, 40, method)


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        (["blow.speed=0"], "never meet; give one"),
        (["blow.drop_height=0.05"], "keep one"),
        (["sphere.mass=50.0"], "heavier than the model allows.*at most 20 times"),
        (["blow.speed=500.0"], "too much of its span"),
        (["beam.height=0.1"], "makes a block"),
        (["solver.steps=1"], "at least 2 steps"),
        (["solver.stepper=volterra", "solver.steps=7"], "at least 8 steps"),
    ],
)
def test_bad_input_gets_a_sentence(overrides, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene("sphere_on_beam", overrides)


def test_a_run_that_is_stopped_while_it_solves_can_go_on():
    stop = np.ones(1, np.uint8)
    simulation = Simulation(load_scene("sphere_on_beam_drop_50mm"), Halt(stop))
    with pytest.raises(Stopped):
        simulation.advance(1)
    stop[0] = 0
    loads = simulation.advance(200).values["normal_load"]
    plain = next(iter(simulate(load_scene("sphere_on_beam_drop_50mm")).blocks())).values["normal_load"]
    assert np.array_equal(loads, plain[:200])
