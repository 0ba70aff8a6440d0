"""Two discs in line contact: contact times of paper 3, eq. (14), both laws, both methods, and where no solution is."""

import math

import numpy as np
import pytest
from reference.impact import equation_14, strike
from runs import reported
from scipy.integrate import quad
from scipy.special import lambertw
from solved_impact import SolvedImpact

from bearing_twin.contact import line
from bearing_twin.contact.laws import line_law
from bearing_twin.contact.names import law_names
from bearing_twin.errors import SceneError
from bearing_twin.kinds.impact import disc_closed_form as disc_impact
from bearing_twin.kinds.impact.discs import solve
from bearing_twin.kinds.impact.models import JOHNSON_ERROR, LARGE
from bearing_twin.run.scene import load_scene

REDUCED = 7853.981634
LAW = line_law("line", 1.0, 2.0, 5e9, 0.3)


SHARES = (0.01, 0.03, 0.06, 0.1, 0.14)  # of the speed of waves


def solved(*overrides, law="line", stepper="closed_form"):
    return SolvedImpact(solve, load_scene("two_discs", overrides), law, stepper)


@pytest.mark.parametrize(("speed", "time"), [(10.0, 6.4857259957e-3), (100.0, 5.5677528716e-3)])
def test_contact_times_of_equation_14(speed, time):
    assert disc_impact.contact_time(LAW, REDUCED, speed) == pytest.approx(time, rel=1e-9)
    found = solved(f"motion.first_velocity={speed}")
    assert found.contacts[0].duration == pytest.approx(time, rel=1e-9)


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


def test_peaks_of_equation_14():
    found = solved()
    assert found.peak_force == pytest.approx(39571863.7, rel=1e-8)
    assert found.greatest_approach == pytest.approx(2.0993635e-2, rel=1e-7)


@pytest.mark.parametrize("law", law_names("line", ()))
def test_quadrature_has_twelve_digits(law):
    """Against a finer rule, and against an adaptive one on the same integral in its plain form."""
    made = line_law(law, 1.0, 2.0, 5e9, 0.3)
    coarse, fine = (disc_impact.contact_time(made, REDUCED, 10.0, nodes) for nodes in (disc_impact.NODES, 400))
    assert coarse == pytest.approx(fine, rel=1e-12)
    energy = 0.5 * REDUCED * 100.0

    def integrand(angle):
        return 2.0 * REDUCED * 10.0 * math.sin(angle) / line.load_of_energy(made, energy * math.sin(angle) ** 2)

    adaptive, _ = quad(integrand, 0.0, 0.5 * math.pi, epsabs=0.0, epsrel=1e-12, limit=200)
    assert coarse == pytest.approx(adaptive, rel=1e-10)


@pytest.mark.parametrize("law", law_names("line", ()))
def test_the_differential_equation_gives_the_quadrature(law):
    exact = solved(law=law)
    found = solved("wanted.tolerance=1e-12", law=law, stepper="dop853")
    assert found.contacts[0].duration == pytest.approx(exact.contacts[0].duration, rel=1e-9)
    for name in ("peak_force", "greatest_approach", "restitution"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=1e-9)
    assert found.force == pytest.approx(exact.force, abs=1e-7 * exact.peak_force)
    assert abs(found.energy_closure) < 1e-10


def test_impulse_is_the_integral_of_the_force():
    found = solved("run.output_rate=1.0e7")
    inside = found.time <= found.contacts[0].duration
    assert np.trapezoid(found.force[inside], found.time[inside]) == pytest.approx(found.contacts[0].impulse, rel=1e-6)
    assert found.contacts[0].impulse == pytest.approx(2.0 * REDUCED * 10.0, rel=1e-8)


def test_many_discs_at_once_and_their_mean():
    """E ~ gamma(5e9, 1e9), by Gauss quadrature over its quantiles: mean and standard deviation of the contact time."""
    from scipy.stats import gamma

    points, weights = np.polynomial.legendre.leggauss(400)
    moduli = gamma(25.0, scale=2e8).ppf(0.5 * (points + 1.0))
    times = disc_impact.contact_time(line_law("line", 1.0, 2.0, moduli, 0.3), REDUCED, 10.0)
    mean = 0.5 * np.sum(weights * times)
    assert mean == pytest.approx(6.5773670e-3, rel=1e-5)
    assert math.sqrt(0.5 * np.sum(weights * (times - mean) ** 2)) == pytest.approx(6.3424330e-4, rel=2e-3)


def test_thick_discs_are_answered_by_johnson_unless_the_scene_pins_the_paper():
    from bearing_twin.run.fidelity import choose

    assert choose(load_scene("two_discs")).law == "line"
    assert "johnson costs no more" in choose(load_scene("two_discs")).warnings[0]
    free = choose(load_scene("two_discs", ["contact.normal=auto", "wanted.outputs=peaks"]))
    assert (free.law, free.stepper, free.warnings) == ("johnson", "closed_form", ())


def met_at(share, ratio=0.3, thickness=2.0):
    """Overrides for discs that come with that share of the speed of waves in them."""
    speed = 2.0 * share * math.sqrt(5e9 / 2500.0)
    return f"motion.first_velocity={speed}", f"disc.material.poisson_ratio={ratio}", f"disc.thickness={thickness}"


def off_elements(share, ratio, thickness, *mesh):
    """Relative errors of force and contact time by Johnson's law against finite elasticity with a stiff penalty.

    The force by elements is averaged over 2 % of the contact: single elements ring as they touch.
    """
    from bearing_twin.kinds.soft_discs.solve import solve as by_elements

    shared = met_at(share, ratio, thickness)
    line = load_scene("two_discs", [*shared, "contact.normal=auto", "wanted.outputs=peaks"])
    found = SolvedImpact(solve, line, "johnson", "closed_form")
    finer = (*mesh, "contact.stiffness_ratio=300")
    elements = by_elements(load_scene("soft_discs_fast", [*shared, *finer]).parameters, frames=2)
    force = elements.column("force")
    lasted = elements.step * np.flatnonzero(force)[-1]
    width = int(0.02 * lasted / elements.step)
    peak = np.convolve(force, np.full(width, 1.0 / width), "valid").max()
    return found.peak_force / peak - 1.0, found.contacts[0].duration / lasted - 1.0


def test_the_numbers_that_say_what_line_contact_errs_by_have_their_study():
    """JOHNSON_ERROR bounds both errors of slow discs; LARGE is the error of the force over the share of the speed."""
    mesh = "mesh.divisions=24", "mesh.order=3"
    slow = [abs(off) for share in (0.003, 0.01) for off in off_elements(share, 0.3, 2.0, *mesh)]
    assert 0.85 * JOHNSON_ERROR < max(slow) <= JOHNSON_ERROR
    forces, times = zip(*(off_elements(share, 0.3, 2.0, *mesh) for share in SHARES), strict=True)
    assert forces == pytest.approx((0.034, 0.097, 0.184, 0.296, 0.418), abs=0.005)
    assert times == pytest.approx((0.031, -0.002, -0.048, -0.094, -0.143), abs=0.005)
    assert np.median(np.divide(forces, SHARES)) == pytest.approx(LARGE, rel=0.05)


@pytest.mark.parametrize(
    ("share", "thickness", "ratio", "words"),
    [(0.01, 2.0, 0.3, ""), (0.06, 2.0, 0.3, "0.06 of the speed of waves"), (0.12, 2.0, 0.45, "0.12 of the speed"),
     (0.01, 0.1, 0.4, "plane: stress")],
)  # fmt: skip
def test_what_line_contact_errs_by_is_what_elements_say(share, thickness, ratio, words):
    """Strain and thickness: the error told is that of force and contact time by finite elasticity, within a factor."""
    from bearing_twin.run.fidelity import choose

    met = met_at(share, ratio, thickness)
    line = load_scene("two_discs", [*met, "contact.normal=auto", "wanted.outputs=peaks"])
    plane = "stress" if thickness < 1.0 else "strain"
    apart = off_elements(share, ratio, thickness, "mesh.divisions=16", "mesh.order=2", f"plane={plane}")
    told, off = choose(line), max(map(abs, apart))
    assert 0.4 * told.law_error < off < 1.25 * told.law_error
    assert [words in warning for warning in told.warnings] == ([True] if words else [])
    assert choose(load_scene("two_discs", [*met, "contact.normal=auto", "wanted.tolerance=0.1"])).warnings == (
        told.warnings if told.law_error > 0.1 else ()
    )


@pytest.mark.parametrize(("speed", "ratio"), [(10.0, 1.138), (100.0, 1.213)])
def test_equation_14_is_softer_than_plane_strain_for_thick_discs(speed, ratio):
    laws = (line_law(name, 1.0, 2.0, 5e9, 0.3) for name in ("line", "johnson"))
    paper, johnson = (disc_impact.contact_time(law, REDUCED, speed) for law in laws)
    assert paper / johnson == pytest.approx(ratio, abs=1e-3)


SOFT = (
    "disc.radius=0.1", "disc.thickness=0.01", "motion.first_velocity=1.0",
    "disc.material={young_modulus: 1.0e5, poisson_ratio: 0.25, density: 960.0}",
)  # fmt: skip


def test_a_soft_disc_has_no_solution_by_equation_14_and_the_sentence_names_what_has():
    """Paper 3's soft discs at 1 m/s: the energy is more than (14) can store; Lambert's argument leaves its domain."""
    law = line_law("line", 0.1, 0.01, 1e5, 0.25)
    energy = 0.25 * 960.0 * math.pi * 0.01 * 0.01
    assert energy > line.greatest_energy(law)
    ratio = 4.0 * law.half_thickness * law.compliance * energy / (law.scale**2 / math.e)
    assert lambertw(-ratio, -1).imag != 0.0
    assert math.isnan(disc_impact.contact_time(law, 0.5 * 960.0 * math.pi * 1e-4, 1.0))
    with pytest.raises(SceneError, match=r"no solution: eq. \(14\).*let the discs meet below 0\.\d+ m/s"):
        load_scene("two_discs", [*SOFT, "contact.normal=line"])


def test_the_sentence_offers_johnson_where_johnson_has_a_solution():
    stored = line.greatest_energy(line_law("johnson", 0.1, 0.01, 1e5, 0.25))
    assert 0.25 * 960.0 * math.pi * 1e-4 < stored
    with pytest.raises(SceneError, match=r"use contact\.normal: johnson, or let the discs"):
        load_scene("two_discs", [*SOFT, "contact.normal=line"])
    found = SolvedImpact(solve, load_scene("two_discs", [*SOFT, "contact.normal=auto"]), "johnson", "closed_form")
    assert math.isfinite(found.contacts[0].duration)
    assert any("half-space" in flag for flag in reported("two_discs", *SOFT, "contact.normal=auto").flags)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("motion.first_velocity=0", "never meet"),
        ("disc.thickness=0", "above 0"),
        ("disc.material.poisson_ratio=0.6", "below 0.5"),
        ("contact.normal=hertz", "legal: auto, line, johnson"),
    ],
)
def test_bad_input_gets_a_sentence(override, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene("two_discs", [override])
