"""Errors of a shaft's figures by half-spaces: the response of both bearings against balances of other materials."""

import dataclasses

import numpy as np
import pytest
from runs import reported

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.shaft.equilibrium import balance_of
from bearing_twin.kinds.shaft.figures import response_of
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.run.scene import load_scene


def of_material(parameters, factor):
    """The scene with every modulus times this."""
    for side in SIDES:
        mounted = getattr(parameters, side)
        parts = {
            material.name: getattr(mounted.materials, material.name)
            for material in dataclasses.fields(mounted.materials)
        }
        changed = {
            name: dataclasses.replace(material, young_modulus=factor * material.young_modulus)
            for name, material in parts.items()
        }
        materials = dataclasses.replace(mounted.materials, **changed)
        parameters = dataclasses.replace(parameters, **{side: dataclasses.replace(mounted, materials=materials)})
    return parameters


@pytest.mark.parametrize("scene", ["shaft_step_load", "shaft_angular_pair", "shaft_two_6203"])
def test_places_and_forces_of_stiffer_contacts_change_as_those_of_stiffer_materials_do(scene):
    """A bearing pushes the shaft along its axis by N sin(angle) of its inner contacts."""
    parameters, step = load_scene(scene).parameters, 1e-4
    speed = float(parameters.drive.speed)
    stiffer, compliant = (
        balance_of(of_material(parameters, factor), "hertz", speed, 1.0) for factor in (1.0 + step, 1.0 - step)
    )
    response = response_of(parameters, "hertz", speed, 1.0, (step, step), False)
    displacement, tilt = np.split(np.abs(response.coordinates) / step, [3])
    forces = {f"{side}_force_n": np.abs(bearing) / step for side, bearing in zip(SIDES, response.forces, strict=True)}
    reported = {"displacement_m": displacement, "tilt_rad": tilt, **forces}
    true = np.abs(stiffer.coordinates - compliant.coordinates) / (2.0 * step)
    for key, part in (("displacement_m", true[:3]), ("tilt_rad", true[3:])):
        assert reported[key] == pytest.approx(part, abs=5e-3 * part.max())
    for side, harder, softer in zip(SIDES, stiffer.contacts, compliant.contacts, strict=True):
        along = [float((bearing.load[:, 0] * np.sin(bearing.angle[:, 0])).sum()) for bearing in (harder, softer)]
        true = abs(along[0] - along[1]) / (2.0 * step)
        assert reported[f"{side}_force_n"][2] == pytest.approx(true, rel=5e-3)
        assert true > 1.0


def test_every_figure_of_a_shaft_says_what_it_is_off():
    """But those that the scene gives, the balance of energy, and works, of which a sentence tells."""
    keys = "shaft_step_load", "run.duration=0.06"
    report = reported(*keys, "wanted.tolerance=1e-2")
    exact = reported(*keys, "wanted.tolerance=1e-7", "solver.check=none")
    without_error = {"shaft_speed_at_end_rad_s", "energy_closure", "forward_shares"}
    assert {key for key in KINDS["shaft"].meanings_of() if f"{key}_error" not in report.errors} == without_error
    for key in ("displacement_m", "displacement_range_m", "tilt_rad", "tilt_range_rad"):
        error = np.abs(np.array(report.figures[key]) - exact.figures[key])
        method_error = report.errors["errors_by_source"][key]["method"]
        assert len(method_error) == len(error)
        assert error.max() / 3.0 < max(method_error) < 100.0 * error.max()


def _model(report, key):
    """The error of a figure by what the model leaves out."""
    return report.errors["errors_by_source"][key]["left_out"]


def test_a_preload_by_offsets_keeps_what_contacts_are_off_and_a_load_does_not():
    """A patch of 0.4 mm on a ball of 3.4 mm: 0.21 % of the load by FELT, of which a preload keeps nine tenths."""
    report = reported("shaft_two_6203", "run.duration=0.01")
    for side in SIDES:
        key = f"{side}_greatest_ball_load_n"
        assert 0.0017 < _model(report, key) / report.figures[key] < 0.0024
        life = f"{side}_reference_life_mrev"
        assert 0.0045 < _model(report, life) / report.figures[life] < 0.0075
        hours = f"{side}_reference_life_h"
        shares = [_model(report, key) / report.figures[key] for key in (life, hours)]
        assert shares[1] == pytest.approx(shares[0], rel=1e-12)
    parameters = load_scene("shaft_step_load").parameters
    assert response_of(parameters, "hertz", float(parameters.drive.speed), 1.0, (0.0, 0.0), True).retained["left"] < 0.1


@pytest.mark.parametrize("gravity", ["[0,0,0]", "[0,-9.80665,0]"])
def test_ranges_and_works_that_are_rounding_are_0_and_raise_no_warning(gravity):
    """A shaft without unbalance stands still: ranges were some 1e-17 m, with errors as large and a warning of them."""
    report = reported("shaft_two_6203", "run.duration=0.05", "shaft.unbalances=[]", f"gravity={gravity}")
    ranges = [f"{name}_range_{unit}" for name, unit in (("displacement", "m"), ("tilt", "rad"), ("left_force", "n"))]
    assert not np.any([part for key in ranges for part in report.figures[key]])
    assert all(report.figures[key] == 0.0 for key in ("load_work_j", "bearing_work_j", "dissipated_j"))
    assert report.figures["left_force_n"][2] < -10.0
    assert report.errors["large_errors"] == {}
    assert not report.flags


def test_forces_that_loads_within_their_tolerance_leave_raise_no_warning():
    """A shaft that stands still but for errors of its balance: 1e-6 N of 450 N, at a tolerance of 1e-3."""
    report = reported("shaft_step_load", "run.duration=0.005", "shaft.unbalances=[]")
    assert 0.0 < report.figures["left_force_range_n"][2] < 1e-3
    assert report.errors["large_errors"] == {}


def test_a_motion_that_nothing_holds_is_no_natural_frequency():
    """Along the axis this shaft is free: 4e-14 Hz were reported."""
    keys = "shaft.unbalances=[]", "gravity=[0,0,0]", "left.offset=1.2444982173156966e-05", "run.duration=0.005"
    assert min(reported("shaft_two_6203", *keys).figures["natural_frequencies_hz"]) > 0.1
