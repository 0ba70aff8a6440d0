"""Results in a Python session: a few lines with numbers and units, not all their fields."""

import pytest

import bearing_twin


@pytest.mark.parametrize(
    ("make", "reported"),
    [
        (lambda: bearing_twin.equilibrium("6308", [0.0, -2000.0, 0.0]), ("1 equilibria", "greatest ball load [N]")),
        (lambda: _reported("bearing_6203"), ("bearing_6203: done", "cage_speed_rad_s", "normal_load_inner_n")),
        (lambda: _reported("two_spheres"), ("two_spheres: done", "contacts", "1 rows")),
        (
            lambda: bearing_twin.run_study(bearing_twin.load_study("spheres_alpha_4e-5", ["samples=50"])),
            ("50 realisations, 0 of them failed", "peak_force"),
        ),
    ],
    ids=["equilibrium", "run", "impact", "study"],
)
def test_a_result_is_a_short_table(make, reported):
    text = repr(make())
    assert len(text) < 2500
    assert all(one in text for one in reported), text


def _reported(scene):
    run = bearing_twin.simulate(bearing_twin.load_scene(scene, ["run.duration=0.002"]))
    assert len({str(sample) for sample in run}) == run.report.samples
    return run.report
