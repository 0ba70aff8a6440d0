"""Values, limits, units and words of parameters."""

import math
import re
from dataclasses import make_dataclass

import pytest

from bearing_twin.base.errors import SceneError
from bearing_twin.base.parameters import choice, describe, quantity, read_strict, section
from bearing_twin.base.units import (
    UNITS,
    key_suffix,
    label_and_unit,
    prefixed_unit,
    readable_sentence,
)
from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.pictures import readable_scale
from bearing_twin.run.scene import load_scene, scene_names
from bearing_twin.uq.study import Settings

Wheel = make_dataclass(
    "Wheel",
    [
        ("radius", float, quantity(0.3, "m", "radius", above=0.0)),
        ("spokes", int, quantity(12, "1", "number of spokes", at_least=3, at_most=100)),
    ],
    frozen=True,
)

WHEELS = {"small": Wheel(0.1, 8), "large": Wheel(0.5, 24)}

# one field of each sort
Cart = make_dataclass(
    "Cart",
    [
        ("front", Wheel, section(Wheel, "small", WHEELS)),
        ("axle", Wheel, section(Wheel)),
        ("speed", tuple[float, float], quantity((1.0, 2.0), "m/s", "speed")),
        ("slope", float, quantity(0.0, "1", "slope", above=-1.0, below=1.0)),
        ("load", str, choice("hay", ("hay", "coal"), "what is carried")),
    ],
    frozen=True,
)


def problems_of(mapping):
    with pytest.raises(SceneError) as caught:
        read_strict(Cart, mapping, "cart.yaml")
    return str(caught.value)


@pytest.mark.parametrize(
    ("entry", "value"), [(0.5, 0.5), ("1e-6", 1e-6), ("2.1e-1", 0.21), ("-.5", -0.5), (0, 0.0), ("+5.e-1", 0.5)]
)
def test_numbers_and_text_that_is_a_number_are_numbers(entry, value):
    slope = read_strict(Cart, {"slope": entry}, "here").slope
    assert slope == value
    assert type(slope) is float


NO_SLOPE = [True, False, "1:30", "0x1", "1_0", "one", "", "1e", "nan", [], {}, [1.0], b"1", 1.0, -1.0]
NOT_FINITE = [float("nan"), float("inf"), "1e999", 10**400, "9" * 65]


@pytest.mark.parametrize("entry", NO_SLOPE + NOT_FINITE)
def test_what_is_no_finite_number_within_limits_is_refused(entry):
    text = problems_of({"slope": entry})
    assert text.startswith("cart.yaml: slope")
    assert "a number, above -1 and below 1" in text
    assert len(text) < 250


@pytest.mark.parametrize(("entry", "value"), [(4, 4), (4.0, 4), ("40", 40)])
def test_whole_numbers(entry, value):
    spokes = read_strict(Cart, {"axle": {"spokes": entry}}, "here").axle.spokes
    assert spokes == value
    assert type(spokes) is int


@pytest.mark.parametrize("entry", [4.5, True, 2, 101, "4.5"])
def test_what_is_no_legal_whole_number_is_refused(entry):
    assert "axle.spokes" in problems_of({"axle": {"spokes": entry}})
    assert "a whole number, at least 3 and at most 100" in problems_of({"axle": {"spokes": entry}})


def test_tuples_have_a_length_and_each_number_is_checked():
    assert read_strict(Cart, {"speed": ["1e0", 3]}, "here").speed == (1.0, 3.0)
    for wrong in ([1.0], [1.0, 2.0, 3.0], 1.0, "1 2", {"x": 1}):
        assert "speed" in problems_of({"speed": wrong})
        assert "a list of 2 numbers in m/s" in problems_of({"speed": wrong})
    text = problems_of({"speed": [True, "x"]})
    assert "speed[0] = True" in text
    assert "speed[1] = 'x'" in text


def test_a_section_may_be_named_where_it_has_names():
    assert read_strict(Cart, {"front": "large"}, "here").front == WHEELS["large"]
    assert read_strict(Cart, {"front": {"spokes": 9}}, "here").front == Wheel(0.1, 9)
    assert "did you mean large? legal: small, large" in problems_of({"front": "larg"})
    assert "axle must hold keys and values, not 'large'" in problems_of({"axle": "large"})


Sized = make_dataclass(
    "Sized",
    [
        ("radius", float, quantity(1e-2, "m", "has a least size and a greatest", above=0.0)),
        ("gap", float, quantity(0.0, "m", "0 or of such a size", at_least=0.0)),
        ("offset", float, quantity(0.0, "m", "as small as it likes")),
        ("share", float, quantity(1e-13, "m", "has its own", above=0.0, below=1e-12)),
    ],
    frozen=True,
)


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        (
            "radius",
            1e-10,
            "radius = 1e-10 is too small, below 1e-09; must be a number in m, above 0 and of a size up to",
        ),
        ("radius", 1e5, "radius = 100000.0 is out of range; must be a number in m, above 0 and of a size up to 10000"),
        ("gap", 1e-300, "gap = 1e-300 is too small"),
        ("offset", -1e5, "offset = -100000.0 is out of range"),
        ("share", 1e-9, "above 0 and below 1e-12"),
    ],
)
def test_sizes_that_no_machine_has_are_refused(key, value, sentence):
    with pytest.raises(SceneError, match=re.escape(sentence)):
        read_strict(Sized, {key: value}, "it")


@pytest.mark.parametrize("unit", [one for one in UNITS.values() if one.suffix], ids=lambda unit: unit.suffix)
def test_every_suffix_leads_to_its_own_unit(unit):
    assert label_and_unit(f"thing_{unit.suffix}") == ("thing", unit.shown)
    assert key_suffix(next(symbol for symbol, row in UNITS.items() if row == unit)) == f"_{unit.suffix}"


def test_every_declared_unit_is_in_the_table():
    """Parameters of every shipped kind and of studies, quantities, and channels; a section and a word have none.

    Other tests put a kind of their own into the table, for which no scene is shipped.
    """
    shipped = {name: KINDS[name] for name in SHIPPED}
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
        (0.5, "N m", 1e3, "mN m"),
        (0.9999, "s", 1e3, "ms"),
        (5000.0, "rad/s", 1.0, "rad/s"),
        (0.0, "m", 1.0, "m"),
        (math.inf, "m", 1.0, "m"),
    ],
)
def test_prefixes_make_numbers_readable(size, unit, factor, text):
    assert prefixed_unit(size, unit) == (pytest.approx(factor), text)
    assert readable_scale([0.1 * size, -size], unit) == (pytest.approx(factor), text)


@pytest.mark.parametrize(
    ("si", "people"),
    [
        ("friction torque 1.5e-05 ± 0.0012 N m, mostly", "friction torque 0.015 ± 1.2 N mm, mostly"),
        ("a contact patch reaches 0.00105 m along its groove", "a contact patch reaches 1.05 mm along its groove"),
        ("peak pressure 4.89e+09 Pa is beyond 1.6e+09 Pa: the", "peak pressure 4890 MPa is beyond 1600 MPa: the"),
        ("reported to go from 100 to 250.5 rad/s", "reported to go from 955 to 2392 rpm"),
        ("even by 0.297 rad", "even by 17 °"),
        ("ball 7, 0 s to 0.002 s", "ball 7, 0 s to 2 ms"),
        ("sunk by -0.0003 m.", "sunk by -300 µm."),
        ("2e8 N/m against 3 N", "200 N/µm against 3 N"),
    ],
)
def test_sentences_beside_tables_have_the_units_of_these(si, people):
    assert readable_sentence(si) == people
    assert readable_sentence(people) == people


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
    assert readable_sentence(text) == text


SOURCED = ("no source: ", "ISO", "paper")
OWN = ("contact.exponent", "contact.restitution")  # 1: as paper 3's bed of springs, and no loss


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_of_physics_that_are_there_by_default_say_where_they_come_from(kind):
    """Of contacts, cages, grooves and materials; sizes, speeds and loads are the user's scene."""
    for row in describe(KINDS[kind].parameters):
        about = row.key.startswith(("contact.", "cage.")) or row.key.endswith("conformity") or "material" in row.key
        if about and row.type == "number" and row.default and row.key not in OWN:
            assert any(word in row.help for word in SOURCED), row.key
