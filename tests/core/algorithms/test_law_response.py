"""How a bearing in balance answers an error of its contact law: against equilibria of other moduli, and as reported."""

import numpy as np
import pytest

from bearing_twin.contact.validity import FELT, gap_error
from bearing_twin.kinds.bearing.equilibrium import Support, solver_of
from bearing_twin.kinds.bearing.model_error import response_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

SMALL = 1e-5
PUSHED = Support((True, True, True, False, False), (30.0, -1000.0, 100.0, 0.0, 0.0), (0.0,) * 5)
TURNED = Support((True,) * 5, (3000.0, 0.0, 17800.0, 0.0, 0.0), (0.0,) * 5)
HELD = Support((False, True, True, False, True), (0.0, 0.0, 17800.0, 0.0, 0.0), (1e-5, 0.0, 0.0, 1e-4, 0.0))
EVERYWHERE, INNER = ("ball", "inner_ring", "outer_ring"), ("inner_ring",)


def balanced(name, support, parts=(), factor=1.0):
    materials = load_scene(name).parameters.materials
    moduli = [f"materials.{part}.young_modulus={factor * getattr(materials, part).young_modulus!r}" for part in parts]
    solver = solver_of(load_scene(name, moduli).parameters, "hertz", 0.3)
    return solver, solver.solve(support)


@pytest.mark.parametrize("parts", [EVERYWHERE, INNER])
@pytest.mark.parametrize(
    ("name", "support"),
    [("bearing_6203_loose", PUSHED), ("bearing_218_thrust", TURNED), ("bearing_218_thrust", HELD)],
    ids=["loose", "thrust at 10 000 rpm", "partly held"],
)
def test_the_response_is_the_derivative_of_equilibria_by_the_moduli(name, support, parts):
    solver, equilibrium = balanced(name, support)
    softer, stiffer = (balanced(name, support, parts, 1.0 + sign * SMALL)[1] for sign in (-1.0, 1.0))
    shares = np.ones((len(equilibrium.azimuths), 2))
    if parts is INNER:  # half of a contact's compliance is the ring's, as all are of one steel
        shares *= (0.5, 0.0)
    response = response_of(solver, support, equilibrium, shares)
    touching = equilibrium.contacts.load > 0.0
    for changed, reported in (
        (lambda state: state.contacts.load, response.loads),
        (lambda state: np.where(touching, state.contacts.angle, 0.0), response.angles),
        (lambda state: state.coordinates, response.coordinates),
        (lambda state: state.loads, response.ring_loads),
    ):
        slope = (changed(stiffer) - changed(softer)) / (2.0 * SMALL)
        assert np.abs(reported - slope).max() <= 0.02 * np.abs(slope).max() + 1e-4


def test_what_a_law_is_off_by_is_told_as_the_other_law_finds_it(run_json):
    arguments = ("bearing_6203", "--displacement", "0,-12e-6,0")
    exact, approximate = (
        run_json("bearing", *arguments),
        run_json("bearing", *arguments, "--set", "contact.normal=volumetric"),
    )
    error = abs(approximate["ring_force_n"][1] - exact["ring_force_n"][1])
    assert error > 1.0
    assert approximate["model_errors"]["law"]["ring_force_n"][1] == pytest.approx(error, rel=0.2)


def half_space_errors(scene, *overrides):
    """Figures and azimuths of a run, its errors by half-spaces, and their shares of loads at the same approach."""
    run = simulate(load_scene(scene, (*overrides, "solver.check=none")))
    positions, *_ = [np.array(block.values["position"][0]) for block in run.blocks()]
    figures, errors = run.report.figures, run.report.errors["errors_by_source"]
    geometry = run.scene.parameters.geometry
    radius, groove = 0.5 * geometry.ball_diameter, geometry.inner_conformity * geometry.ball_diameter
    shares = FELT * gap_error(np.array(figures["semi_major_inner_m"]), radius, groove)
    by_figure = {key: np.array(errors[key]["left_out"]) for key in ("normal_load_inner_n", "ring_force_n")}
    return figures, np.arctan2(positions[:, 1], positions[:, 0]), by_figure, shares


def test_runs_tell_what_contacts_keep_of_their_errors_and_what_a_held_ring_bears():
    """A load that is given stays on the balls; a preload is wrong as a whole, unevenly where its contacts differ."""
    offset = "run.duration=0.001", "geometry.radial_clearance=-1e-5", "drive.offset=[0,-2e-6,0]"
    figures, azimuths, errors, shares = half_space_errors("bearing_6203", *offset)
    loads = np.array(figures["normal_load_inner_n"])
    assert errors["normal_load_inner_n"] == pytest.approx(shares * loads, rel=1e-9)
    resultant = abs((shares * loads) @ np.sin(azimuths))
    assert resultant > 1.1 * shares.max() * figures["ring_force_n"][1]  # more than any contact's share of the whole
    assert resultant < errors["ring_force_n"][1] < 5.0 * resultant
    figures, _, errors, shares = half_space_errors("bearing_6203_rig_400N", "run.duration=0.005")
    loads = np.array(figures["normal_load_inner_n"])
    assert np.all(errors["normal_load_inner_n"] <= 0.3 * shares * loads)
    assert errors["normal_load_inner_n"].max() > 0.1 * (shares * loads).max()
    assert errors["ring_force_n"].tolist() == [0.0, 0.0, 0.0]
