"""The subcommand `contact`: its options, its keys, its sentences."""

import argparse
import math

import numpy as np
import pytest

from bearing_twin.command.contact_command import add_arguments, run
from bearing_twin.contact.calculator import COMPARED
from bearing_twin.errors import BearingTwinError, SceneError

KEYS = {
    "approach_m", "normal_load_n", "semi_major_m", "semi_minor_m", "axis_ratio", "peak_pressure_pa",
    "stiffness_n_per_m", "laws", "flags",
}  # fmt: skip


def asked(line):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return run(parser.parse_args(line.split()))


def test_the_keys_are_those_promised():
    result = asked("--radii-1 0.01 --young 2.1e11 --poisson 0.3 --approach 1e-6").result
    assert set(result) >= KEYS
    assert set(result["laws"]) == set(COMPARED)
    assert all(set(law) == {"normal_load_n", "error"} for law in result["laws"].values())
    assert result["normal_load_n"] == pytest.approx(15.384615384615384, rel=1e-12)


def test_a_bearing_by_its_designation_and_by_its_curvatures_agree():
    bearing = asked("--bearing 6203 --race outer --load 100").result
    small, large = bearing["curvature_small_per_m"], bearing["curvature_large_per_m"]
    gap = asked(f"--curvature-small {small!r} --curvature-large {large!r} --young 2.075e11 --load 100").result
    assert gap["approach_m"] == pytest.approx(bearing["approach_m"], rel=1e-13)
    assert bearing["normal_load_n"] / bearing["approach_m"] ** 1.5 == pytest.approx(2.502e10, rel=2.5e-4)
    assert asked("--bearing 6203 --load 100").result["axis_ratio"] == pytest.approx(0.1043, abs=6e-5)


def test_materials_of_both_bodies():
    one = asked("--radii-1 0.01 --young 2e11 7e10 --poisson 0.3 0.33 --load 10").result["effective_modulus_pa"]
    assert one == pytest.approx(1.0 / (0.91 / 2e11 + (1.0 - 0.33**2) / 7e10), rel=1e-14)
    named = asked("--radii-1 0.01 --material steel aluminium --load 10").result["effective_modulus_pa"]
    assert named == pytest.approx(1.0 / (0.91 / 2.075e11 + (1.0 - 0.33**2) / 7e10), rel=1e-14)


def test_yield_is_judged_where_it_is_known():
    assert "yield" in asked("--radii-1 0.01 --peak-pressure 3.3e9").doubts[0]
    assert asked("--radii-1 0.01 --peak-pressure 3.1e9").doubts == []
    assert asked("--radii-1 0.01 --young 1e11 --poisson 0.2 --peak-pressure 1e9").doubts == []
    assert "yield" in asked("--radii-1 0.01 --young 1e11 --peak-pressure 1e9 --yield-strength 5e8").doubts[0]


def test_damping_for_a_restitution_by_the_exact_relation_and_by_the_usual_formulas(capsys):
    outcome = asked("--radii-1 0.01 --speed 2 --mass 0.1 --restitution 0.5")
    found = outcome.result["damping"]
    assert [one["restitution"] for one in found.values()] == pytest.approx([0.5, 0.663, 0.725, 0.470], abs=6e-4)
    chi = found["exact"]["damping_s_per_m"] * 2.0
    assert chi * 1.5 == pytest.approx(math.log((1.0 + chi) / (1.0 - 0.5 * chi)), rel=1e-12)
    assert found["flores"]["damping_s_per_m"] == pytest.approx(0.8, rel=1e-12)
    outcome.show()
    shown = "".join(capsys.readouterr())
    assert "damping [s/m]" in shown
    assert "lankarani_nikravesh" in shown


@pytest.mark.parametrize("line", ["--bearing 6203 --load 300", "--radii-1 0.01 --load 1", "--radii-1 0.1 1 --load 9"])
def test_the_picture_is_a_png(line, tmp_path, quick_pictures):
    path = tmp_path / "contact.png"
    assert asked(f"{line} --plot {path}").result["plot"] == str(path)
    content = path.read_bytes()
    assert content.startswith(b"\x89PNG")
    assert len(content) > 20_000


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("--load 1", "one way"),
        ("--radii-1 1 --bearing 6203 --load 1", "one way"),
        ("--radii-1 1", "exactly one of"),
        ("--radii-1 1 --load 1 --approach 1", "exactly one of"),
        ("--radii-1 1 --speed 1", "belong together"),
        ("--radii-1 1 --load 1 --mass 1", "belong together"),
        ("--radii-1 1 --load 1 --restitution 0.5", "goes with --speed"),
        ("--radii-1 1 --speed 1 --mass 1 --restitution 0", "above 0 and at most 1"),
        ("--radii-1 -1 --load 1", "above zero"),
        ("--radii-1 1 2 3 --load 1", "3 values"),
        ("--radii-1 1 --poisson 0.5 --load 1", "below 0.5"),
        ("--radii-1 1 --poisson -1 --load 1", "above -1"),
        ("--radii-1 1 --young nan --load 1", "not finite"),
        ("--radii-1 1 --material stel --load 1", "did you mean steel"),
        ("--radii-1 1 --race inner --load 1", "goes with --bearing"),
        ("--bearing 6203 --hollow x --load 1", "goes with --radii-1"),
        ("--bearing 9999 --load 1", "bearing_6203"),
        ("--curvature-small 1 --load 1", "both"),
        ("--curvature-small -1 --curvature-large 2 --load 1", "conform"),
        ("--radii-1 1 --load 1 --plot picture.jpg", "png"),
        ("--radii-1 1 --load 1 --yield-strength -1", "yield-strength"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_the_reason(line, reason):
    with pytest.raises(BearingTwinError, match=reason):
        asked(line)


def test_every_number_is_finite():
    result = asked("--bearing 6205 --load 1e-9").result
    assert all(math.isfinite(value) for value in result.values() if isinstance(value, float))


def test_the_law_constant_is_exact_where_it_is_frozen(capsys):
    line = "--bearing 6203 --load 50"
    circle, own = asked(line), asked(f"{line} --frozen-at 0.104322")
    assert circle.result["laws"]["constant"]["error"] == pytest.approx(-0.203, abs=1e-3)
    assert own.result["laws"]["constant"]["error"] == pytest.approx(0.0, abs=1e-5)
    own.show()
    assert "exact for b/a = 0.104322" in capsys.readouterr().out
    for ratio in ("0", "1.5", "nan"):
        with pytest.raises(SceneError, match="frozen_at"):
            asked(f"{line} --frozen-at {ratio}")


def test_two_bodies_of_a_scene_are_answered_as_they_stand_or_pressed():
    """The groove of the scene: P, Q, ellipse and loads as the calculator has them for these curvatures."""
    found = asked("--shapes two_bodies_groove --approach 1e-6").result
    assert found["approach_m"] == pytest.approx(1e-6, rel=1e-9)
    assert all(row["error_m"] < 1e-12 for row in found["tracking"].values())
    apart = np.subtract(found["point_first_m"], found["point_second_m"])
    assert apart == pytest.approx(1e-6 * np.array(found["normal"]), abs=1e-15)
    curvatures = found["curvature_small_per_m"], found["curvature_large_per_m"]
    known = asked(f"--curvature-small {curvatures[0]!r} --curvature-large {curvatures[1]!r} --approach 1e-6").result
    assert found["semi_major_m"] == pytest.approx(known["semi_major_m"], rel=1e-9)
    assert found["peak_pressure_pa"] == pytest.approx(known["peak_pressure_pa"], rel=1e-9)
    for law in ("hertz", "volumetric", "hertz_differential"):
        assert found["laws"][law]["normal_load_n"] == pytest.approx(known["laws"][law]["normal_load_n"], rel=1e-9)
    assert found["laws"]["overlap"]["normal_load_n"] == pytest.approx(
        found["laws"]["volumetric"]["normal_load_n"], 1e-3
    )
    volume = math.pi * 1e-12 / (2.0 * math.sqrt(curvatures[0] * curvatures[1]))
    assert found["overlap"]["volume_m3"] == pytest.approx(volume, rel=2e-2)
    apart = asked("--shapes two_bodies_superellipsoid").result
    assert apart["approach_m"] < 0.0
    assert apart["laws"] == {}
