"""How a bearing in balance answers an error of its contact law: against equilibria of other moduli, and as told."""

import json

import numpy as np
import pytest
from runs import reported

from bearing_twin.command import cli
from bearing_twin.kinds.bearing.quasi_static.response import response_of
from bearing_twin.kinds.bearing.quasi_static.statics import Support, solver_of
from bearing_twin.run.scene import load_scene

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
    solver, found = balanced(name, support)
    less, more = (balanced(name, support, parts, 1.0 + sign * SMALL)[1] for sign in (-1.0, 1.0))
    shares = np.ones((len(found.azimuths), 2))
    if parts is INNER:  # half of a contact's compliance is the ring's, as all are of one steel
        shares *= (0.5, 0.0)
    response = response_of(solver, support, found, shares)
    touching = found.contacts.load > 0.0
    for changed, told in (
        (lambda one: one.contacts.load, response.loads),
        (lambda one: np.where(touching, one.contacts.angle, 0.0), response.angles),
        (lambda one: one.coordinates, response.coordinates),
        (lambda one: one.loads, response.ring_loads),
    ):
        slope = (changed(more) - changed(less)) / (2.0 * SMALL)
        assert np.abs(told - slope).max() <= 0.02 * np.abs(slope).max() + 1e-4


def answered(capsys, *words):
    assert cli.main(["bearing", *words, "--json"]) == cli.DONE
    return json.loads(capsys.readouterr().out)


def test_given_loads_stay_and_what_all_contacts_share_moves_the_ring(capsys):
    loaded = answered(capsys, "bearing_6203", "--load", "0,-1000,0")
    wide = (max(loaded["semi_major_inner_m"]) / (0.5 * 6.75e-3)) ** 2
    assert max(loaded["normal_load_inner_n_error"]) < 0.2 * wide * max(loaded["normal_load_inner_n"])
    assert loaded["ring_force_n_error"] == [0.0, 0.0, 0.0]
    assert 0.3 * wide < loaded["ring_displacement_m_error"][1] / 12.35e-6 < wide
    assert loaded["ring_displacement_m_error"][::2] == [0.0, 0.0]  # where symmetry holds it, without what is rounding
    assert loaded["basic_life_mrev_error"] == 0.0 < loaded["reference_life_mrev_error"]
    y = f"0,{loaded['ring_displacement_m'][1]!r},0"
    held = answered(capsys, "bearing_6203", "--displacement", y)
    assert held["normal_load_inner_n"] == pytest.approx(loaded["normal_load_inner_n"], rel=1e-6)
    assert max(held["normal_load_inner_n_error"]) > 0.5 * wide * max(held["normal_load_inner_n"])
    assert held["ring_displacement_m_error"] == [0.0, 0.0, 0.0]
    assert 0.3 * wide < held["ring_force_n_error"][1] / 1000.0 < wide
    assert held["basic_life_mrev_error"] > 0.0
    # a spot goes with the cube root of its load, and of what the shape of the bodies changes at the same load
    for told in (loaded, held):
        load, load_error, spot = (
            np.array(told[f"{key}_inner_{end}"])
            for key, end in (
                ("normal_load", "n"),
                ("normal_load", "n_error"),
                ("semi_major", "m"),
            )
        )
        bears = load > 0.0
        share = (load_error[bears] / load[bears] + (spot[bears] / (0.5 * 6.75e-3)) ** 2) / 3.0
        for key in ("semi_major_inner_m", "semi_minor_inner_m", "peak_pressure_inner_pa"):
            found = np.array(told[f"{key}_error"])[bears] / np.array(told[key])[bears]
            assert found == pytest.approx(share, rel=5e-3)


def test_what_a_law_is_off_by_is_told_as_the_other_law_finds_it(capsys):
    words = ("bearing_6203", "--displacement", "0,-12e-6,0")
    exact, rough = answered(capsys, *words), answered(capsys, *words, "--set", "contact.normal=volumetric")
    off = abs(rough["ring_force_n"][1] - exact["ring_force_n"][1])
    told = rough["ring_force_n_error"][1] - exact["ring_force_n_error"][1]
    assert off > 1.0
    assert told == pytest.approx(off, rel=0.2)


def test_a_run_under_given_loads_tells_the_errors_of_its_equilibrium():
    figures = reported("bearing_6203_rig_1000N", "run.duration=0.05")
    wide = (max(figures.figures["semi_major_inner_m"]) / (0.5 * 6.75e-3)) ** 2
    heaviest = max(figures.figures["greatest_normal_load_inner_n"])
    told = figures.errors["errors_by_source"]
    assert 0.05 * wide < max(told["greatest_normal_load_inner_n"]["left_out"]) / heaviest < 0.3 * wide
    assert max(told["ring_force_n"]["left_out"]) == 0.0
    assert 1e-7 < max(told["ring_displacement_m"]["left_out"]) < 2e-6


def test_a_run_whose_load_rises_tells_the_errors_of_the_equilibrium_it_ends_in():
    """From 100 N to 1300 N, by a table and by a change: as under 1300 N all the time, not as of a ring that is held."""
    rig = "run.duration=0.03", "wanted.tolerance=1e-2"
    ways = (
        ("rings.inner.load=[0,-1300,0]",),
        ("rings.inner.load=[0,0,0]", "rings.inner.table=[[0,0,-100,0,0,0],[0.02,0,-1300,0,0,0]]"),
        ("rings.inner.load=[0,-1000,0]", "rings.inner.change={time: 0.01, load: [0,-300,0]}"),
    )
    found = [reported("bearing_6203_rig_400N", *rig, *way) for way in ways]
    told = [max(one.errors["errors_by_source"]["greatest_normal_load_inner_n"]["left_out"]) for one in found]
    assert told[0] < 0.025 * max(found[0].figures["greatest_normal_load_inner_n"])
    assert told[1:] == pytest.approx([told[0]] * 2, rel=0.2)
