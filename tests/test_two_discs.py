"""Two discs in line contact: contact times of paper 3, eq. (14), both laws, both methods, and where no solution is."""

import math

import numpy as np
import pytest
from reference.impact import equation_14, strike
from scipy.integrate import quad
from solved_impact import SolvedImpact

from bearing_twin.contact import line
from bearing_twin.contact.laws import line_law
from bearing_twin.contact.names import law_names
from bearing_twin.errors import SceneError
from bearing_twin.kinds.impact import disc_closed_form as disc_impact
from bearing_twin.kinds.impact.discs import solve
from bearing_twin.run.scene import load_scene

REDUCED = 7853.981634
LAW = line_law("line", 1.0, 2.0, 5e9, 0.3)


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


@pytest.mark.parametrize(("speed", "ratio"), [(10.0, 1.138), (100.0, 1.213)])
def test_equation_14_is_softer_than_plane_strain_for_thick_discs(speed, ratio):
    laws = (line_law(name, 1.0, 2.0, 5e9, 0.3) for name in ("line", "johnson"))
    paper, johnson = (disc_impact.contact_time(law, REDUCED, speed) for law in laws)
    assert paper / johnson == pytest.approx(ratio, abs=1e-3)


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
