"""The subcommand `bearing`: keys, the meaning of its options, tables, sweeps, pictures, bad input."""

import csv
import math
import re

import numpy as np
import pytest

DOWN = ("bearing", "bearing_6203", "--load", "0,-1000,0")


def test_the_answer_is_in_si_units_with_one_entry_a_ball(run_json):
    answer = run_json(*DOWN)
    for key in (
        "normal_load_{}_n",
        "contact_angle_{}_rad",
        "peak_pressure_{}_pa",
        "semi_major_{}_m",
        "semi_minor_{}_m",
    ):
        assert [len(answer[key.format(race)]) for race in ("inner", "outer")] == [8, 8]
    assert np.shape(answer["stiffness"]) == (5, 5)
    assert answer["ring_force_n"] == pytest.approx([0.0, 1000.0, 0.0], abs=1e-6)
    assert answer["ring_displacement_m"][1] < -1e-5
    assert answer["static_safety"] == pytest.approx(answer["basic_static_rating_n"] / 1000.0, rel=1e-9)
    assert answer["equivalent_dynamic_load_n"] == answer["equivalent_static_load_n"] == pytest.approx(1000.0, rel=1e-9)
    thrust = run_json("bearing", "bearing_6203", "--load", "0,0,1000")
    life = (thrust["basic_dynamic_rating_n"] / thrust["equivalent_dynamic_load_n"]) ** 3
    assert thrust["basic_life_mrev"] == pytest.approx(life, rel=1e-9)
    assert thrust["equivalent_static_load_n"] == pytest.approx(500.0, rel=1e-9)  # Y_0 of ISO 76, X_0 F_r being nothing
    assert answer["normal_load_inner_n"][0] == max(answer["normal_load_inner_n"])  # ball 0 lies on the load line
    assert answer == run_json(*DOWN, "--set", "gravity=[0,0,0]")


def test_numbers_of_options_may_have_units(run_json):
    plain = run_json("bearing", "6308", "--load", "0,-2000,0", "--moment", "0.5,0")
    assert plain == run_json("bearing", "6308", "--load", "0, -2kN, 0", "--moment", "500 N mm,0")
    held = run_json("bearing", "6308", "--displacement", "0,-10um,0", "--misalignment", "0.1°,-")
    assert held["ring_displacement_m"][1] == pytest.approx(-1e-5, rel=1e-12)
    assert held["misalignment_rad"][0] == pytest.approx(math.radians(0.1), rel=1e-12)
    keys = "--set", "drive.speed=314.15926535897933", "--set", "geometry.radial_clearance=2e-5"
    plain, by_options = run_json(*DOWN, *keys), run_json(*DOWN, "--speed", "3000rpm", "--clearance", "20um")
    assert by_options["speed_rad_s"] == pytest.approx(100.0 * math.pi, rel=1e-12)
    assert by_options["ring_displacement_m"] == pytest.approx(plain["ring_displacement_m"], rel=1e-9, abs=1e-15)


def test_no_friction_is_computed_and_what_symmetry_makes_nothing_is_nothing(run_json):
    answer = run_json("bearing", "6308", "--load", "0,-2kN,0")
    assert answer["drive_torque_nm"] is None
    assert "no friction" in answer["not_computed"]["drive_torque_nm"]
    assert answer["ring_displacement_m"][0] == answer["ring_displacement_m"][2] == answer["ring_force_n"][0] == 0.0
    assert answer["ring_moment_nm"] == [0.0, 0.0]
    stiffness = answer["stiffness"]
    assert stiffness[3][4] == stiffness[0][1] == 0.0
    assert stiffness[2][3] != 0.0 < stiffness[0][0]


def test_fault_frequencies_of_a_shaft_turn(run_json):
    """Of balls that roll at the contact angle of a preload; for those of level contacts see the catalogue."""
    frequencies = run_json("bearing", "bearing_6203", "--set", f"drive.speed={2.0 * math.pi!r}")["fault_frequencies_hz"]
    assert (frequencies["bpfi"], frequencies["ftf"]) == pytest.approx((4.9462, 0.38173), abs=5e-5)


def test_the_ring_is_where_loads_and_options_put_it(run_json):
    held = run_json("bearing", "bearing_6203")  # where the scene holds it
    assert held["ring_displacement_m"] == [0.0, 0.0, 1e-5]
    assert held["normal_load_inner_n"] == pytest.approx([48.497] * 8, rel=1e-4)
    rig = run_json("bearing", "bearing_6203_rig_400N")  # by the scene's loads
    assert rig["ring_force_n"] == pytest.approx([0.0, 400.0, 0.0], abs=1e-6)
    mixed = run_json("bearing", "bearing_6203", "--load", "-,-300,-", "--displacement", "1e-6,-,-")
    assert mixed["ring_displacement_m"][0] == 1e-6
    assert mixed["ring_displacement_m"][2] == 0.0  # the scene's offset of 10 micrometres is not in it
    assert mixed["ring_force_n"][1:] == pytest.approx([300.0, 0.0], abs=1e-6)
    assert mixed["misalignment_rad"] == [0.0, 0.0]
    free = run_json("bearing", "bearing_6203", "--load", "0,-300,50", "--moment", "0.5,0")
    assert free["ring_moment_nm"] == pytest.approx([-0.5, 0.0], abs=1e-8)
    tilted = run_json("bearing", "bearing_6203", "--load", "0,-300,50", "--misalignment", "1e-4,-")
    assert tilted["misalignment_rad"][0] == 1e-4
    assert tilted["ring_moment_nm"][1] == pytest.approx(0.0, abs=1e-8)
    displaced = run_json("bearing", "bearing_6203", "--displacement", "0,-1e-5,0")
    loaded = run_json("bearing", "bearing_6203", "--load", f"0,{-displaced['ring_force_n'][1]!r},0")
    assert loaded["ring_displacement_m"][1] == pytest.approx(-1e-5, rel=1e-8)


def test_the_arm_of_a_tilt_and_the_place_of_ball_0(run_json):
    pitch = run_json("bearing", "bearing_6203", "--moment", "0.5,0", "--arm", "pitch")
    groove = run_json("bearing", "bearing_6203", "--moment", "0.5,0")
    assert 1.005 < pitch["misalignment_rad"][0] / groove["misalignment_rad"][0] < 1.03
    between = run_json(*DOWN, "--ball-angle", "-67.5")
    assert run_json(*DOWN, "--ball-angle", "-72067.5")["ring_displacement_m"] == between["ring_displacement_m"]
    assert between["normal_load_inner_n"][0] == pytest.approx(between["normal_load_inner_n"][7], rel=1e-6)
    assert between["ball_azimuth_rad"][0] == pytest.approx(math.radians(-67.5))
    # Without an angle ball 0 stands on the line of the load, also along +x, else on that of what is held.
    for options, azimuth in (
        (("--load", "1000,0,0", "--misalignment", "0,1e-4"), 0.0),
        (("--load", "0,1000,0", "--misalignment", "1e-4,0"), 90.0),
        (("--load", "0,0,1000", "--misalignment", "0,1e-4"), 90.0),
        (("--load", "-,-,500", "--displacement", "-1e-5,0,-", "--misalignment", "0,1e-4"), 180.0),
    ):
        assert math.degrees(run_json("bearing", "bearing_6203", *options)["ball_azimuth_rad"][0]) == azimuth
    assert run_json(*DOWN, "--ball-angle", "-67.5deg") == between


def printed(run_cli, *arguments):
    """What a command prints; never wider than a terminal."""
    out = run_cli(*arguments).out
    assert max(map(len, out.splitlines())) <= 80
    return out


def cells_below(out, begin, count):
    """The numbers in so many lines below the first one that begins so."""
    lines = out.splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith(begin)) + 1
    return [line[22:].split() if line.startswith(" ") else line.split() for line in lines[first : first + count]]


def test_tables_have_columns_that_stay_apart_and_say_what_they_rest_on(run_cli):
    """Negative cells of five digits and an exponent are the longest; light balls stand beside heavy ones."""
    arguments = "--load", "-,-300,-", "--displacement", "1e-6,-,-", "--misalignment", "2e-4,0"
    rows = cells_below(printed(run_cli, "bearing", "bearing_6203", *arguments), "stiffness", 5)
    assert [len([float(cell) for cell in row]) for row in rows] == [5] * 5
    cells = cells_below(printed(run_cli, "bearing", "bearing_218_thrust", "--load", "0,-100000,170000"), "ball  ", 16)
    assert [len(row) for row in cells] == [10] * 16
    for law, has_error in (("hertz", False), ("volumetric", True)):
        out = printed(run_cli, "bearing", "6308", "--load", "0,-2kN,0", "--set", f"contact.normal={law}")
        assert ("elastic law:" in out, "half-space assumption:" in out, "57 ± 28 N mm" in out) == (
            has_error,
            True,
            True,
        ), law
    arguments = "bearing", "6308", "--speed", "3000rpm", "--load", "0,-3kN,500", "--set", "lubricant.kind=grease"
    held = printed(run_cli, *arguments)
    for phrase in ("tilts are held", "90 % of bearings", "grease, VG100, 40 °C, 101 mm²/s"):
        assert phrase in " ".join(held.split())
    assert "tilts are held" not in printed(run_cli, *arguments, "--moment", "0,0")
    for sweep, title in (("load=100:1000:4", "1750 rpm, law"), ("speed=0:100:2", "load (0, -1000, 0) N, law")):
        swept = printed(run_cli, "bearing", "6308", "--load", "0,-1kN,0", "--sweep", sweep)
        assert "90 % of bearings" in swept
        assert title in swept.splitlines()[0]
    out = printed(run_cli, "bearing", "6308", "--load", "0,-3000,0", "--si")
    assert re.search(r"^stiffness +7.8788e\+07, 0, 0, 0, 0$", out, flags=re.MULTILINE)


def test_sweeps_are_curves(tmp_path, pictures_once, run_json, run_cli):
    picture = tmp_path / "curves.png"
    loads = run_json(*DOWN, "--sweep", "load=100:1000:4", "--plot", str(picture))
    assert loads["values"] == pytest.approx([100.0, 400.0, 700.0, 1000.0])
    assert [force[1] for force in loads["ring_force_n"]] == pytest.approx(loads["values"])
    assert (loads["refused"], loads["plot"]) == ([], str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    clearances = run_json(*DOWN, "--sweep", "clearance=-5um:20um:3")
    assert clearances["sweep"] == "geometry.radial_clearance"
    assert clearances["values"] == pytest.approx([-5e-6, 7.5e-6, 2e-5])
    displacements = [row[1] for row in clearances["ring_displacement_m"]]
    assert displacements == sorted(displacements, reverse=True)
    speeds = run_json("bearing", "bearing_218_thrust", "--sweep", "speed=0:1000:3")
    assert speeds["greatest_contact_angle_inner_rad"] == sorted(speeds["greatest_contact_angle_inner_rad"])
    overload = run_json(*DOWN, "--sweep", "load=10000:40000:4")
    assert [entry is None for entry in overload["stiffness"]] == [False, False, True, True]
    assert [entry["value"] for entry in overload["refused"]] == pytest.approx([30000.0, 40000.0])
    assert "the greatest in this direction" in overload["refused"][0]["reason"]
    assert "beyond the yield pressure" in " ".join(overload["flags"])
    assert speeds["axis"]["label"] == "speed [rpm]"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--load", "1,2"), "must be 3 numbers in N, as FX,FY,FZ"),
        (("--displacement", "1e300,0,0"), "--displacement '1e300' is out of range; must be a number in m, of a size"),
        (("--load", "1,2,x"), "--load 'x' must be a number"),
        (("--load", "1,2,nan"), "--load 'nan' must be a number"),
        (("--moment", "1"), "must be 2 numbers in N m, as MX,MY"),
        (("--load", "1,2,3", "--displacement", "0,-,-"), "FX of --load and X of --displacement are both given"),
        (("--load", "0,-1e5,0"), "pushes the ring through the balls.*the greatest in this direction is a load of"),
        (("--load", "0,0,0", "--set", "geometry.radial_clearance=1e-5"), "no ball touches both rings"),
        (("--ball-angle", "up"), "--ball-angle 'up' must be a number"),
        (("--load", "0,-1,0", "--csv", "--json"), "give one of them"),
        (("--sweep", "load=1:2"), "must look like load=100:2000:20"),
        (("--sweep", "load=1:2:3"), "give its direction by --load"),
        (("--sweep", "lod=1:2:3"), "is no number of a bearing"),
        (("--sweep", "hardness=1:2:3"), "legal: load, clearance, speed, geometry"),
        (("--sweep", "speed=0:100:1"), "must have 2 to 10000 values"),
        (("--load", "0,-1e9,0"), r"a load of \(0, -24680, 0\) N"),
        (("--load", "0,-1e9,0", "--sweep", "load=1e8:1e9:3"), "no value of this sweep has an equilibrium"),
        (("--load", "0,-2kg,0"), "must be a number in N"),
        (("--load", "0,-1,0", "--clearance", "20um", "--sweep", "clearance=0:40um:3"), "by another option"),
        (("--load", "0,-1,0", "--mass", "0"), "in kg, above 0"),
    ],
)
def test_bad_input_is_one_sentence(arguments, sentence, refused):
    message = refused("bearing", "bearing_6203", *arguments)
    assert re.search(sentence, message), message


def test_other_kinds_are_refused(refused):
    for arguments in (("--load", "0,0,1"), ("--sweep", "speed=0:100:3"), ("--sweep", "load=1:2:3")):
        assert "scene two_discs is no bearing" in refused("bearing", "two_discs", *arguments)


def test_a_result_is_a_table_and_a_sheet(tmp_path, pictures_once, run_json, refused, run_cli):
    answer = run_json(*DOWN)
    rows = dict(csv.reader(run_cli(*DOWN, "--csv").out.splitlines()))
    assert float(rows["ring_displacement_m[1]"]) == answer["ring_displacement_m"][1]
    assert float(rows["fault_frequencies_hz.bpfo"]) == answer["fault_frequencies_hz"]["bpfo"]
    curves = list(csv.DictReader(run_cli(*DOWN, "--sweep", "load=100:300:3", "--csv").out.splitlines()))
    assert [float(row["load"]) for row in curves] == [100.0, 200.0, 300.0]
    assert [float(row["ring_force_n[1]"]) for row in curves] == pytest.approx([100.0, 200.0, 300.0])
    row = dict(csv.reader(run_cli("bearing", "6308", "--csv").out.splitlines()))
    assert (float(row["ball_diameter_m"]), row["balls"]) == (15.081e-3, "8")
    sheet = tmp_path / "sheet.html"
    run_cli(*DOWN, "--out", sheet)
    text = sheet.read_text(encoding="utf-8")
    assert "static safety" in text
    assert "data:image/png;base64," in text
    assert "exists" in refused(*DOWN, "--out", str(sheet))
    assert sheet.read_text(encoding="utf-8") == text


def test_a_speed_that_no_bearing_runs_at_is_doubtful(run_json):
    """15000 rad/s on a 6203: n d_m is 4.1e6 mm/min."""
    (flag,) = run_json("bearing", "6203", "--speed", "15000")["flags"]
    assert "143239 rpm" in flag
    loaded = run_json("bearing", "6308", "--speed", "3000", "--load", "0,-2kN,0")  # in rad/s, but meant in rpm
    assert any("28647.9 rpm" in warning for warning in loaded["flags"])
    assert not run_json("bearing", "6203", "--speed", "15000rpm")["flags"]


def test_a_mass_on_the_stiffness_has_natural_frequencies(run_json):
    """Held tilts: f = sqrt(k/m)/2 pi along the axes of a radial load; free tilts give way."""
    answer = run_json(*DOWN, "--mass", "20kg")
    stiffness = answer["stiffness"]
    expected = sorted(math.sqrt(stiffness[i][i] / 20.0) / (2.0 * math.pi) for i in range(3))
    assert answer["natural_frequencies_hz"] == pytest.approx(expected, rel=1e-9)
    assert [abs(value) for value in answer["natural_directions"][2]] == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)
    free = run_json("bearing", "bearing_6203", "--load", "0,-300,100", "--mass", "20000 g", "--moment", "0,0")
    # the matrix of the mass is condensed: det K = det K_tilts det K_condensed
    k = np.array(free["stiffness"])
    product = math.prod((2.0 * math.pi * value) ** 2 * 20.0 for value in free["natural_frequencies_hz"])
    assert product * np.linalg.det(k[3:, 3:]) == pytest.approx(np.linalg.det(k), rel=1e-5)


def test_a_sweep_is_a_file_and_given_once(tmp_path, run_json, refused, run_cli):
    path = tmp_path / "stiffness.csv"
    run_cli(*DOWN, "--sweep", "speed=0:3000rpm:3", "--out", path)
    rows = list(csv.DictReader(path.open(encoding="utf-8")))
    alone = run_json(*DOWN, "--speed", rows[2]["drive.speed"])
    assert float(rows[2]["stiffness[1][1]"]) == pytest.approx(alone["stiffness"][1][1], rel=1e-6)
    sweeps = "--sweep", "load=200:400:2", "--sweep", "speed=0:3000rpm:3"
    assert "equilibrium() in Python takes arrays" in refused(*DOWN, *sweeps)


def test_balls_that_the_rings_squeeze_are_warned_of(run_json):
    """Basic life and static safety count the load alone, and interference of 100 um presses each ball with 4 kN."""
    for clearance, squeezed in (("-100um", True), ("0", False), ("13um", False)):
        options = "--clearance", clearance, "--load", "0,-2kN,0", "--speed", "3000rpm"
        answer = run_json("bearing", "6308", *options)
        assert any("basic life assumes" in flag for flag in answer["flags"]) == squeezed
        assert (answer["reference_life_mrev"] < 0.1 * answer["basic_life_mrev"]) == squeezed


def test_numbers_that_want_a_unit_are_noted_and_rounding_is_0(refused, run_cli):
    for options, note in (
        (("--set", "temperatures.inner_ring=80"), "give 80°C"),
        (("--sweep", "speed=0:3000:3"), "give 3000rpm"),
    ):
        assert note in run_cli("bearing", "6308", "--clearance", "0", "--load", "0,-2kN,0", *options).err
    assert "legal: C2, CN, C3, C4, C5" in refused("bearing", "6308/C6")
    out = printed(run_cli, "simulate", "6308", "--duration", "10ms", "--set", "rings.inner.load=0,-2kN,500N")
    assert re.search(r"^ring force x, y, z +0, 2000, -500 N$", out, flags=re.MULTILINE)
