"""Bearings by designation: dimensions, ball sets, ratings against published ones, scenes, rows of the user's own."""

import itertools
import math
import os
from statistics import median

import numpy as np
import pytest
from published_ratings import ANGULAR, F0, FACTORS

from bearing_twin.base.errors import SceneError
from bearing_twin.kinds.bearing.catalogue import ANGULAR_CONTACT, DEEP_GROOVE, Entry, by_rule, entries, row_of
from bearing_twin.kinds.bearing.parameters import Geometry
from bearing_twin.kinds.bearing.ratings import basic_dynamic_rating, basic_static_rating, catalogue_sheet
from bearing_twin.run.scene import choose, load_scene, parse_scene, read_logged_scene
from bearing_twin.vibration import rolling_frequencies

SCATTER = 0.014  # by which a rating may leave the range that makers publish; most in the 6208, sold with two sets
ENTRIES = entries()
# Timken, housed unit catalogue, table A-9: FTF, BSF, BPFO of the rows that name their set "frequencies".
COEFFICIENTS = {
    "6004": (0.398, 2.339, 3.578),
    "6203": (0.382, 1.994, 3.053),
    "6204": (0.382, 1.992, 3.052),
    "6205": (0.397, 2.328, 3.574),
    "6206": (0.396, 2.311, 3.568),
    "6207": (0.396, 2.303, 3.565),
    "6209": (0.402, 2.461, 3.621),
    "6210": (0.409, 2.665, 4.093),
    "6211": (0.408, 2.620, 4.078),
    "6212": (0.407, 2.584, 4.066),
    "6213": (0.410, 2.685, 4.099),
    "6214": (0.410, 2.702, 4.104),
    "6303": (0.364, 1.696, 2.545),
    "6304": (0.368, 1.757, 2.574),
    "6306": (0.368, 1.757, 2.574),
    "6309": (0.380, 1.955, 3.037),
    "6310": (0.381, 1.981, 3.047),
    "6311": (0.382, 2.002, 3.057),
    "6312": (0.383, 2.020, 3.064),
    "6314": (0.385, 2.050, 3.076),
    "6315": (0.385, 2.062, 3.081),
    "6316": (0.386, 2.073, 3.086),
    "6318": (0.387, 2.091, 3.093),
}
OUTSIDE = {  # ISO 15, dimension series 10, 02, 03: outside diameter and width [mm] by bore [mm]
    "60": {10: (26, 8), 17: (35, 10), 25: (47, 12), 40: (68, 15), 60: (95, 18), 80: (125, 22), 100: (150, 24)},
    "62": {10: (30, 9), 17: (40, 12), 25: (52, 15), 40: (80, 18), 60: (110, 22), 80: (140, 26), 100: (180, 34)},
    "63": {10: (35, 11), 17: (47, 14), 25: (62, 17), 40: (90, 23), 60: (130, 31), 80: (170, 39), 100: (215, 47)},
}
BORES = {"00": 10, "01": 12, "02": 15, "03": 17}


def parameters(name):
    return load_scene(name).parameters


def test_every_bore_of_the_three_series_is_there_with_the_dimensions_of_iso_15():
    codes = [f"{code:02d}" for code in range(21)]
    assert {f"{series}{code}" for series in OUTSIDE for code in codes} <= set(ENTRIES)
    for name, entry in ENTRIES.items():
        code = name[2:4]
        assert 1e3 * entry.bore == pytest.approx(BORES.get(code, 5 * int(code)))
    for series, sizes in OUTSIDE.items():
        for bore, size in sizes.items():
            code = next((code for code, small_bore in BORES.items() if small_bore == bore), f"{bore // 5:02d}")
            entry = ENTRIES[f"{series}{code}"]
            assert (1e3 * entry.outside_diameter, 1e3 * entry.width) == pytest.approx(size)
    for lower, higher in itertools.pairwise(codes):
        for series in OUTSIDE:
            assert ENTRIES[series + lower].outside_diameter < ENTRIES[series + higher].outside_diameter


def test_ratings_lie_within_the_scatter_of_those_published():
    misses = []
    for name, entry in ENTRIES.items():
        if entry.found in ("literature", "published"):  # today's 7218 holds larger balls; SKF rates by its own factor
            continue
        sheet = catalogue_sheet(parameters(name))
        for kind in ("dynamic", "static"):
            value, (low, high) = sheet[f"basic_{kind}_rating_n"], getattr(entry, kind)
            scatter = SCATTER if not entry.contact_angle else 0.02
            assert (1.0 - scatter) * low <= value <= (1.0 + scatter) * high, (name, kind, value, low, high)
            misses.append(value / (0.5 * (low + high)) - 1.0)
    assert len(misses) == 2 * 71
    assert abs(median(misses)) < 0.01


def test_the_factors_of_static_ratings_are_those_of_the_standard():
    for ratio, published in zip(0.1 + 0.01 * np.arange(len(F0)), F0, strict=True):
        geometry = Geometry(balls=5, ball_diameter=10e-3, pitch_diameter=10e-3 / ratio)
        assert basic_static_rating(geometry) / (5 * 10.0**2) == pytest.approx(published, abs=0.06), ratio


def test_sets_meet_factor_and_ratings_of_makers_that_stand_in_no_row():
    """The number of balls by C0/(f0 D^2); makers fill the 6305 and the 6306 with other balls than the rows hold."""
    differ = set()
    for series, rows in FACTORS.items():
        for code, (factor, dynamic, static) in enumerate(rows):
            name = f"{series}{code:02d}"
            entry, geometry = ENTRIES[name], parameters(name).geometry
            ratio = np.interp(entry.ball_diameter / entry.pitch_diameter, 0.1 + 0.01 * np.arange(len(F0)), F0)
            balls = 1e-3 * entry.balls * factor * (1e3 * entry.ball_diameter) ** 2
            misses = ratio - factor, balls / static - 1.0, 1e-3 * basic_dynamic_rating(geometry) / dynamic - 1.0
            if np.any(np.abs(misses) > (0.2, 0.015, 0.008)):  # a pitch circle 1.5 % off the middle changes f0 by 0.1
                differ.add(name)
    assert differ == {"6305", "6306"}
    for name, ranges in ANGULAR.items():
        for rating, (low, high) in zip((basic_dynamic_rating, basic_static_rating), ranges, strict=True):
            assert 0.96 * low <= 1e-3 * rating(parameters(name).geometry) <= 1.04 * high, name


def test_published_sets_give_published_frequencies_and_the_ratings_of_skf():
    """Case Western Reserve University, Bearing Data Center: BPFI, BPFO, FTF in turns of the shaft."""
    for name, published in {"6205SKF": (5.4152, 3.5848, 0.39828), "6203SKF": (4.9469, 3.0530, 0.3817)}.items():
        sheet = catalogue_sheet(load_scene(name, [f"drive.speed={2.0 * math.pi!r}"]).parameters)
        for line, value in zip(("bpfi", "bpfo", "ftf"), published, strict=True):
            error = sheet["fault_frequencies_hz_error"][line]
            assert abs(sheet["fault_frequencies_hz"][line] - value) < error + 5e-5, (name, line)
            assert error < 4e-4 * value
        assert 1.04 < sheet["published_dynamic_rating_n"][0] / sheet["basic_dynamic_rating_n"] < 1.06
        assert sheet["published_static_rating_n"][0] == pytest.approx(sheet["basic_static_rating_n"], rel=0.01)


def test_ball_sets_give_the_frequency_coefficients_of_their_maker():
    assert {name for name, entry in ENTRIES.items() if entry.found == "frequencies"} == set(COEFFICIENTS)
    for name, (cage, spin, outer) in COEFFICIENTS.items():
        frequencies = rolling_frequencies(parameters(name).geometry, 2.0 * math.pi)
        assert frequencies["ftf"] == pytest.approx(cage, abs=1.1e-3), name
        assert frequencies["ball_spin"] == pytest.approx(spin, rel=5e-3), name
        assert frequencies["bpfo"] == pytest.approx(outer, abs=5e-3), name
        assert ENTRIES[name].balls == round(outer / cage)


def test_the_rule_meets_its_errors_but_for_one_bearing():
    beyond = set()
    for name, entry in ENTRIES.items():
        rule = ANGULAR_CONTACT if entry.contact_angle else DEEP_GROOVE
        bare = Entry(bore=entry.bore, outside_diameter=entry.outside_diameter, contact_angle=entry.contact_angle)
        balls, ball = by_rule(bare)
        if abs(balls - entry.balls) > rule.balls_error or abs(entry.ball_diameter / ball - 1.0) > rule.diameter_error:
            beyond.add(name)
    assert beyond == {"6200"}


def test_a_designation_fills_in_the_geometry_and_other_keys_override_it():
    plain = parameters("6308").geometry
    assert (plain.balls, plain.ball_diameter, plain.pitch_diameter) == (8, 15.081e-3, 65e-3)
    assert plain.radial_clearance == pytest.approx(13e-6)  # the middle of group N
    for written in ("6308", '"6308"'):
        text = f"kind: bearing\ngeometry: {{designation: {written}, balls: 7}}"
        assert parse_scene(text, "a scene").parameters.geometry.balls == 7
    tight = load_scene("6308", ["geometry.radial_clearance=-5e-6"]).parameters.geometry
    assert (tight.radial_clearance, tight.balls) == (-5e-6, 8)
    angular = parameters("7205B").geometry
    assert math.degrees(angular.contact_angle) == pytest.approx(40.0)
    text = "kind: bearing\ngeometry: {designation: 7205B, radial_clearance: 1e-4}"
    assert parse_scene(text, "a scene").parameters.geometry.contact_angle == 0.0


def test_a_designation_as_override_takes_the_place_of_the_whole_geometry():
    swapped = load_scene("bearing_6203", ["geometry.designation=6308", "geometry.balls=7"]).parameters
    assert (swapped.geometry.ball_diameter, swapped.geometry.balls) == (15.081e-3, 7)
    assert swapped.drive == parameters("bearing_6203").drive
    scene = load_scene("6308")  # a resolved scene needs no catalogue
    text = scene.text.replace("designation: '6308'", "designation: NOWHERE1")
    logged = read_logged_scene(text, "a log").parameters.geometry
    assert (logged.designation, logged.ball_diameter) == ("NOWHERE1", scene.parameters.geometry.ball_diameter)


@pytest.mark.parametrize(
    ("designation", "near"),
    [
        ("6380", "did you mean 6308?"),
        ("7205", "did you mean 7205B?"),
        ("9999", ""),
    ],
)
def test_an_unknown_designation_is_a_bearing_and_no_scene_and_names_its_neighbours(designation, near):
    with pytest.raises(SceneError) as refused:
        load_scene(designation)
    hint = f"{near} ".lstrip()
    assert str(refused.value).startswith(
        f"there is no bearing or scene '{designation}'; {hint}`bearing_twin bearing --list`"
    )
    with pytest.raises(SceneError, match=f"geometry.designation = '{designation}' is not in the catalogue") as refused:
        parse_scene(f"kind: bearing\ngeometry: {{designation: {designation}}}", "a scene")
    assert near in str(refused.value)


@pytest.fixture
def own_rows():
    """The catalogue as it was, after the test."""
    yield
    entries.cache_clear()


def test_rows_of_the_users_own_come_from_a_file_or_a_folder(tmp_path, monkeypatch, own_rows, run_json):
    folder = tmp_path / "bearing_twin" / "bearings"
    folder.mkdir(parents=True)
    row = "{bore: 20e-3, outside_diameter: 47e-3, balls: 7, ball_diameter: 8.5e-3, source: measured}"
    (folder / "mine.yaml").write_text(f"MINE1: {row}\n", encoding="utf-8")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    entries.cache_clear()
    assert parameters("MINE1").geometry.balls == 7
    assert row_of("MINE1")["source"] == "measured"
    path = tmp_path / "other.yaml"
    path.write_text("6308: {bore: 40e-3, outside_diameter: 90e-3}\n", encoding="utf-8")
    answer = run_json("bearing", "6308", "--catalogue", path)
    assert answer["found"] == "rule"
    assert (answer["balls"], answer["balls_doubt"]) == (8, 2)
    assert answer["ball_diameter_m"] == pytest.approx(0.29 * 50e-3)
    assert answer["published_dynamic_rating_n"] is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("A: {bore: 40e-3, outside_diameter: 30e-3}", "A: bore = 0.04 m and outside_diameter = 0.03 m leave no room"),
        ("A: {bore: 40e-3, outside_diameter: 90e-3, bals: 3}", "did you mean balls?"),
        ("A: {bore: 40e-3, outside_diameter: 90e-3, dynamic: [2, 1]}", "least and the greatest, in this order"),
        ("A: {bore: 400e-3, outside_diameter: 900e-3}", "bores up to 200 mm"),
        ("A/B: {bore: 40e-3, outside_diameter: 90e-3}", "letters and digits"),
    ],
)
def test_a_file_that_is_no_catalogue_is_refused(text, sentence, tmp_path, own_rows, refused):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    assert sentence in refused("bearing", "6308", "--catalogue", path)


def test_the_command_answers_by_designation(run_json):
    row = run_json("bearing", "6308")
    assert (row["bore_m"], row["outside_diameter_m"], row["width_m"], row["balls"]) == (0.04, 0.09, 0.023, 8)
    assert row["basic_dynamic_rating_n"] == pytest.approx(40.8e3, rel=0.01)
    answer = run_json("bearing", "6308", "--load", "0,-3000,0")
    assert answer["catalogue"]["found"] == "factors"
    assert answer["basic_life_mrev"] == pytest.approx((row["basic_dynamic_rating_n"] / 3000.0) ** 3, rel=1e-9)
    assert answer["ring_force_n"][1] == pytest.approx(3000.0)
    listed = run_json("bearing", "--list")
    assert len(listed["bearings"]) == len(ENTRIES)
    assert listed["own_folder"].endswith(os.path.join("bearing_twin", "bearings"))


def test_a_designation_is_found_as_a_number_and_where_it_is_taken_for_a_scene():
    assert load_scene(6308).parameters == load_scene("6308").parameters
    with pytest.raises(SceneError, match="did you mean 6308, by its designation"):
        load_scene("bearing_6308")


def test_temperatures_that_may_have_been_meant_in_degrees_are_named():
    choice = choose(load_scene("6308", ["temperatures.inner_ring=60", "rings.inner.load=[0,-1000,0]"]))
    assert "temperatures.inner_ring = 60 K is -213.15 °C: if °C was meant, give 60°C" in choice.warnings


@pytest.mark.parametrize(
    ("designation", "name", "clearance"),
    [
        ("6205/C3", "6205", (13e-6, 28e-6)),
        ("6205-2RSH/C4", "6205", (23e-6, 41e-6)),
        ("6308-2RS", "6308", (6e-6, 20e-6)),
        ("6005 C2", "6005", (1e-6, 11e-6)),
        ("6320/C5", "6320", (75e-6, 120e-6)),
    ],
)
def test_suffixes_are_read_and_groups_of_clearance_are_those_of_iso_5753(designation, name, clearance):
    geometry, plain = load_scene(designation).parameters.geometry, load_scene(name).parameters.geometry
    assert geometry.radial_clearance == pytest.approx(0.5 * sum(clearance), rel=1e-12)
    assert (geometry.balls, geometry.ball_diameter, geometry.designation) == (plain.balls, plain.ball_diameter, name)
    written = parse_scene(f"kind: bearing\ngeometry: {{designation: {designation}}}", "a scene").parameters.geometry
    assert written == geometry


@pytest.mark.parametrize(
    ("designation", "kind"),
    [("22210", "spherical roller"), ("HK1612", "needle"), ("NU2205ECP", "cylindrical")],
)  # fmt: skip
def test_bearings_of_other_types_are_refused_as_what_they_are(designation, kind):
    with pytest.raises(SceneError, match=f"{kind}.*no deep-groove or angular-contact ball bearing"):
        load_scene(designation)


def test_fault_frequencies_have_the_error_of_pitch_circle_and_balls():
    """The set of the bearing of a known data set, 9 balls of 7.94 mm on 39.04 mm, lies within it."""
    sheet = catalogue_sheet(load_scene("6205", ["drive.speed=6.283185307179586"]).parameters)
    ratio = 7.94 / 39.04
    expected = {"bpfo": 4.5 * (1.0 - ratio), "bpfi": 4.5 * (1.0 + ratio), "ftf": 0.5 * (1.0 - ratio)}
    for name, value in expected.items():
        deviation, reported = (
            abs(sheet["fault_frequencies_hz"][name] - value),
            sheet["fault_frequencies_hz_error"][name],
        )
        assert deviation < reported < 0.02 * value
    many, counted = (catalogue_sheet(load_scene("7208B", given).parameters) for given in ([], ["geometry.balls=12"]))
    deviation = many["fault_frequencies_hz"]["bpfo"] - counted["fault_frequencies_hz"]["bpfo"]
    assert 0.0 < deviation < many["fault_frequencies_hz_error"]["bpfo"]  # 14 balls, give or take 2
    assert (counted["balls"], counted["balls_doubt"], counted["source"]) == (12, 0, "given by the scene: balls")
    assert counted["fault_frequencies_hz_error"]["bpfo"] < 0.2 * deviation
    tilted = catalogue_sheet(load_scene("6308", ["geometry.contact_angle=15deg"]).parameters)
    assert tilted["radial_clearance_m"] is None
