"""The one table of units: what declarations may use, what keys end with, what people see."""

import math

import pytest

from bearing_twin.kinds import KINDS
from bearing_twin.parameters import describe
from bearing_twin.pictures.style import scaled
from bearing_twin.run.scene import load_scene, scene_names
from bearing_twin.units import (
    PREFIXES,
    UNITS,
    Limits,
    inverse,
    labelled,
    named,
    prefixed,
    sentence_for_people,
    suffix_of,
    with_unit,
)
from bearing_twin.uq.study import Settings


def test_keys_tell_their_units():
    assert named("normal_load_inner_n") == ("normal load inner", "N")
    assert named("friction_torque_nm") == ("dry-contact friction torque", "N m")
    assert named("cage_speed_rad_s") == ("cage speed", "rad/s")
    assert named("semi_major_inner_m") == ("semi major inner", "m")
    assert named("stiffness_n_per_m") == ("stiffness", "N/m")
    assert named("damping_s_per_m") == ("damping", "s/m")
    assert named("gravity_m_s2") == ("gravity", "m/s²")
    assert named("axis_ratio") == ("axis ratio", "")
    assert named("energy_closure") == ("energy closure", "")
    assert named("n") == ("n", "")


@pytest.mark.parametrize("unit", [one for one in UNITS.values() if one.suffix], ids=lambda unit: unit.suffix)
def test_every_suffix_leads_to_its_own_unit(unit):
    assert named(f"thing_{unit.suffix}") == ("thing", unit.shown)
    assert suffix_of(next(symbol for symbol, row in UNITS.items() if row == unit)) == f"_{unit.suffix}"


@pytest.mark.parametrize("unit", ["1", "", "furlong", "N s/m^1.25"])
def test_plain_numbers_and_rare_units_have_no_suffix(unit):
    assert suffix_of(unit) == ""


def test_suffixes_and_prefixes_are_unambiguous():
    suffixes = [one.suffix for one in UNITS.values() if one.suffix]
    assert len(set(suffixes)) == len(suffixes)
    assert all(set(one.prefixes) <= set(PREFIXES) for one in UNITS.values())


def test_every_declared_unit_is_in_the_table():
    """Parameters of every shipped kind and of studies, quantities, and channels; a section and a word have none.

    Other tests put a kind of their own into the table, for which no scene is shipped.
    """
    shipped = {name: kind for name, kind in KINDS.items() if kind.home.startswith("bearing_twin.")}
    declared = {row.unit for kind in shipped.values() for row in describe(kind.parameters)}
    declared |= {row.unit for row in describe(Settings)} - {"its unit"}  # the tolerance of a stop: the quantity's
    declared |= {row.unit for kind in shipped.values() for row in kind.quantities_of().values()}
    scenes = {load_scene(name).kind: name for name in scene_names()}
    assert set(scenes) == set(shipped)
    declared |= {channel.unit for name in scenes.values() for channel in load_scene(name).channels}
    assert declared - {""} <= set(UNITS)


@pytest.mark.parametrize(
    ("size", "unit", "factor", "text"),
    [
        (2.5e-5, "m", 1e6, "µm"),
        (2.0e9, "Pa", 1e-9, "GPa"),
        (1500.0, "N", 1e-3, "kN"),
        (0.5, "N m", 1e3, "mN m"),
        (1e-12, "J", 1e9, "nJ"),
        (0.9999, "s", 1e3, "ms"),
        (1e-3, "s", 1e3, "ms"),
        (5000.0, "s", 1.0, "s"),
        (5000.0, "rad/s", 1.0, "rad/s"),
        (0.0, "m", 1.0, "m"),
        (math.inf, "m", 1.0, "m"),
        (1e-5, "furlong", 1.0, "furlong"),
    ],
)
def test_prefixes_make_numbers_readable(size, unit, factor, text):
    assert prefixed(size, unit) == (pytest.approx(factor), text)
    assert scaled([0.1 * size, -size], unit) == (pytest.approx(factor), text)


def test_labels_and_densities():
    assert (labelled("load", "N"), labelled("ratio", "1"), labelled("ratio", "")) == ("load [N]", "ratio", "ratio")
    assert (with_unit("N m"), with_unit("1")) == (" N m", "")
    assert (inverse("µs"), inverse("N s"), inverse("1")) == ("1/µs", "1/(N s)", "")


@pytest.mark.parametrize(
    ("si", "people"),
    [
        ("friction torque 1.5e-05 ± 0.0012 N m, mostly", "friction torque 0.015 ± 1.2 N mm, mostly"),
        ("a spot reaches 0.00105 m along its groove", "a spot reaches 1.05 mm along its groove"),
        ("peak pressure 4.89e+09 Pa is beyond 1.6e+09 Pa: the", "peak pressure 4890 MPa is beyond 1600 MPa: the"),
        ("told to go from 100 to 250.5 rad/s", "told to go from 955 to 2392 rpm"),
        ("even by 0.297 rad", "even by 17 °"),
        ("ball 7, 0 s to 0.002 s", "ball 7, 0 s to 2 ms"),
        ("sunk by -0.0003 m.", "sunk by -300 µm."),
        ("2e8 N/m against 3 N", "200 N/µm against 3 N"),
    ],
)
def test_sentences_beside_tables_have_the_units_of_these(si, people):
    assert sentence_for_people(si) == people
    assert sentence_for_people(people) == people


@pytest.mark.parametrize(
    "text",
    [
        "solver.step = 0.001 s is long; use 1e-05 s or less",  # what one writes into a scene
        "100 m/s, 1 m/s^2, 5 N m/rad, 3 N m s, 2 m^2, 4 kg",
        "/data/my run 5 s.mcap and 5 m/run.mcap",
        "rodas4 at a tolerance of 0.001, 45 modes, mu N R, 16.4 crossings",
    ],
)
def test_what_is_no_si_number_of_people_stays_in_a_sentence(text):
    assert sentence_for_people(text) == text


def test_a_limit_that_is_a_whole_number_is_written_out():
    assert Limits(at_least=1, at_most=2**30).text() == "at least 1 and at most 1073741824"
    assert Limits(above=0.0, at_most=1e9).text() == "above 0 and at most 1e+09"
