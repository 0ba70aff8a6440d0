"""The beam's modes: statics, exact propagation of forces in time, energies, damping."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from bearing_twin.kinds.beam import modes as beams
from bearing_twin.kinds.beam.modes import (
    beam_energy,
    deflection_shapes,
    first_frequency,
    modes_of,
    propagate,
    rectangular_beam,
    static_deflection,
    static_stress,
    stress_shapes,
)

CLASSICAL = rectangular_beam(0.1535, 0.01, 0.01, 2.158e11, 7960.0)


def test_frequencies_are_squares_of_the_first():
    """omega_n = n^2 omega_1 (paper 2, below eq. 7), omega_1 = (pi/l)^2 sqrt(EI / (mass per length))."""
    omega = (math.pi / 0.1535) ** 2 * math.sqrt(2.158e11 * 0.01**4 / 12.0 / (7960.0 * 0.01**2))
    assert first_frequency(CLASSICAL) == pytest.approx(omega, rel=1e-14)
    modes = modes_of(CLASSICAL, 0.3 * CLASSICAL.span, 5)
    assert modes.omega == pytest.approx(omega * np.array([1.0, 4.0, 9.0, 16.0, 25.0]), rel=1e-13)
    assert modes.modal_mass == pytest.approx(0.5 * CLASSICAL.mass, rel=1e-15)


def test_a_blow_at_mid_span_moves_odd_modes_only():
    assert list(modes_of(CLASSICAL, 0.5 * CLASSICAL.span, 8).index) == [1, 3, 5, 7]
    assert list(modes_of(CLASSICAL, CLASSICAL.span / 3.0, 8).index) == [1, 2, 4, 5, 7, 8]


def test_statics_at_mid_span():
    """F l^3 / 48 EI and stress (F l / 4) / (b h^2 / 6)."""
    middle = 0.5 * CLASSICAL.span
    expected = CLASSICAL.span**3 / (48.0 * CLASSICAL.rigidity)
    assert static_deflection(CLASSICAL, middle, middle) == pytest.approx(expected, rel=1e-13)
    expected = 0.25 * CLASSICAL.span / (0.01**3 / 6.0)
    assert static_stress(CLASSICAL, middle, middle) == pytest.approx(expected, rel=1e-13)


@settings(deadline=None)
@given(st.floats(0.05, 0.95), st.floats(0.0, 1.0))
def test_statics_are_reciprocal_and_modes_with_their_tail_make_them_up(load, point):
    """Maxwell; and the modal sum of any length plus its tail is the static influence function."""
    load, point = load * CLASSICAL.span, point * CLASSICAL.span
    exact = static_deflection(CLASSICAL, point, load)
    assert static_deflection(CLASSICAL, load, point) == pytest.approx(exact, rel=1e-9, abs=1e-22)
    modes = modes_of(CLASSICAL, load, 7)
    still = modes.shape / (modes.omega**2 * modes.modal_mass)
    for shapes, whole in (
        (deflection_shapes(CLASSICAL, modes, [point]), exact),
        (stress_shapes(CLASSICAL, modes, [point]), static_stress(CLASSICAL, point, load)),
    ):
        assert (shapes[0] @ still + shapes[1])[0] == pytest.approx(whole, rel=1e-9, abs=1e-20)


@pytest.mark.parametrize(("quantity", "power"), [("deflection", 3.0), ("stress", 1.0)])
def test_what_the_modes_leave_out_falls_as_their_number_says(quantity, power):
    """The deflection's tail as modes^-3; the stress's only as modes^-1, which is why it is added."""
    middle, tails = 0.5 * CLASSICAL.span, []
    for count in (51, 201):
        shapes = getattr(beams, f"{quantity}_shapes")(CLASSICAL, modes_of(CLASSICAL, middle, count), [middle])
        tails.append(abs(float(shapes[1][0])))
    assert math.log(tails[0] / tails[1]) / math.log(201 / 51) == pytest.approx(power, abs=0.08)


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_a_cubic_force_is_propagated_exactly(damping):
    """q'' + 2 zeta omega q' + omega^2 q = f phi / M, against a tight adaptive integration of two modes."""
    beam = CLASSICAL._replace(damping_ratio=damping)
    modes = modes_of(beam, 0.3 * beam.span, 3)
    force, step = np.array([1.0, -2.0, 3.0, 5.0]), 4e-4
    start = np.array([0.01 + 0.02j, -0.03j, 0.02 + 0.0j])
    end = np.empty(3, np.complex128)
    propagate(modes.rate, modes.shape, modes.modal_mass, step, 0.75, force, start, end)
    for n in range(3):
        omega, push = modes.omega[n], modes.shape[n] / modes.modal_mass
        q = start[n].imag / modes.rate[n].imag

        def right_hand_side(t, y, omega=omega, push=push):
            return [y[1], push * np.polyval(force[::-1], t / step) - 2.0 * damping * omega * y[1] - omega**2 * y[0]]

        first = [q, start[n].real + modes.rate[n].real * q]
        exact = solve_ivp(right_hand_side, (0.0, 0.75 * step), first, "DOP853", rtol=1e-12, atol=1e-18).y[:, -1]
        found = end[n].imag / modes.rate[n].imag
        assert found == pytest.approx(exact[0], rel=1e-9)
        assert end[n].real + modes.rate[n].real * found == pytest.approx(exact[1], rel=1e-8)


def test_energy_is_that_of_the_oscillators_and_damping_takes_it():
    modes = modes_of(CLASSICAL, 0.5 * CLASSICAL.span, 5)
    state = np.array([0.01 + 0.02j, -0.03j, 0.02 + 0.0j])
    energy = beam_energy(modes, state)
    assert energy == pytest.approx(0.5 * modes.modal_mass * np.sum(np.abs(state) ** 2), rel=1e-14)
    later = state * np.exp(modes.rate * 1e-3)
    assert beam_energy(modes, later) == pytest.approx(energy, rel=1e-12)
    damped = modes_of(CLASSICAL._replace(damping_ratio=0.02), 0.5 * CLASSICAL.span, 5)
    assert beam_energy(damped, state * np.exp(damped.rate * 1e-3)) < 0.8 * beam_energy(damped, state)


def test_modal_energy_is_the_energy_of_the_deflected_line():
    """Half the integral of E I w''^2, by quadrature over the span."""
    modes = modes_of(CLASSICAL, 0.3 * CLASSICAL.span, 3)
    q = np.array([1e-6, -2e-7, 5e-8])

    def bending(x):
        wave = modes.index * math.pi / CLASSICAL.span
        return 0.5 * CLASSICAL.rigidity * float(np.sum(-(wave**2) * np.sin(wave * x) * q)) ** 2

    expected, _ = quad(bending, 0.0, CLASSICAL.span, epsabs=0.0, epsrel=1e-10)
    assert beam_energy(modes, 1j * modes.rate.imag * q) == pytest.approx(expected, rel=1e-9)
