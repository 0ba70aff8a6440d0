"""Reading parameters: every mistake is told, with its key and what is legal; nothing wrong passes."""

import math
import re
from dataclasses import FrozenInstanceError, make_dataclass

import pytest

from bearing_twin.errors import SceneError
from bearing_twin.parameters import choice, describe, plain, quantity, read_strict, section

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


def test_an_empty_mapping_gives_the_defaults():
    cart = read_strict(Cart, {}, "here")
    assert cart == Cart()
    assert cart.front is WHEELS["small"]
    with pytest.raises(FrozenInstanceError):
        cart.slope = 0.5


@pytest.mark.parametrize(
    ("given", "value"), [(0.5, 0.5), ("1e-6", 1e-6), ("2.1e-1", 0.21), ("-.5", -0.5), (0, 0.0), ("+5.e-1", 0.5)]
)
def test_numbers_and_text_that_is_a_number_are_numbers(given, value):
    slope = read_strict(Cart, {"slope": given}, "here").slope
    assert slope == value
    assert type(slope) is float


NO_SLOPE = [True, False, "1:30", "0x1", "1_0", "one", "", "1e", "nan", [], {}, [1.0], b"1", 1.0, -1.0]
NOT_FINITE = [float("nan"), float("inf"), "1e999", 10**400, "9" * 65]


@pytest.mark.parametrize("given", NO_SLOPE + NOT_FINITE)
def test_what_is_no_finite_number_within_limits_is_refused(given):
    text = problems_of({"slope": given})
    assert text.startswith("cart.yaml: slope")
    assert "a number, above -1 and below 1" in text
    assert len(text) < 250


@pytest.mark.parametrize(("given", "value"), [(4, 4), (4.0, 4), ("40", 40)])
def test_whole_numbers(given, value):
    spokes = read_strict(Cart, {"axle": {"spokes": given}}, "here").axle.spokes
    assert spokes == value
    assert type(spokes) is int


@pytest.mark.parametrize("given", [4.5, True, 2, 101, "4.5"])
def test_what_is_no_legal_whole_number_is_refused(given):
    assert "axle.spokes" in problems_of({"axle": {"spokes": given}})
    assert "a whole number, at least 3 and at most 100" in problems_of({"axle": {"spokes": given}})


def test_a_missing_value_is_told():
    assert "slope has no value" in problems_of({"slope": None})


def test_tuples_have_a_length_and_each_number_is_checked():
    assert read_strict(Cart, {"speed": ["1e0", 3]}, "here").speed == (1.0, 3.0)
    for wrong in ([1.0], [1.0, 2.0, 3.0], 1.0, "1 2", {"x": 1}):
        assert "speed" in problems_of({"speed": wrong})
        assert "a list of 2 numbers in m/s" in problems_of({"speed": wrong})
    text = problems_of({"speed": [True, "x"]})
    assert "speed[0] = True" in text
    assert "speed[1] = 'x'" in text


def test_an_unknown_key_names_the_nearest_and_all_legal_ones():
    text = problems_of({"axle": {"radios": 1.0}})
    assert "axle.radios is not a key; did you mean radius? legal: radius, spokes" in text
    assert "did you mean" not in problems_of({"xyz": 1})


def test_an_unknown_choice_names_the_nearest_and_all_legal_ones():
    assert "load = 'cole' is not known; did you mean coal? legal: hay, coal" in problems_of({"load": "cole"})
    for other in (["hay"], {"hay": 1}):
        assert f"load = {other} is not known; legal: hay, coal" in problems_of({"load": other})
    assert "load = 3" in problems_of({"load": 3})


def test_a_section_may_be_named_where_it_has_names():
    assert read_strict(Cart, {"front": "large"}, "here").front == WHEELS["large"]
    assert read_strict(Cart, {"front": {"spokes": 9}}, "here").front == Wheel(0.1, 9)
    assert "did you mean large? legal: small, large" in problems_of({"front": "larg"})
    assert "axle must hold keys and values, not 'large'" in problems_of({"axle": "large"})


def test_all_problems_are_reported_together():
    text = problems_of({"slope": 7, "bad": 1, "front": {"radius": -1, "spokes": "x"}, "load": "gold", "axle": 5})
    lines = text.splitlines()
    assert lines[0] == "cart.yaml has 6 problems:"
    assert len(lines) == 7
    for key in ("slope", "bad", "front.radius", "front.spokes", "load", "axle"):
        assert sum(line.strip().startswith(key + " ") for line in lines[1:]) == 1


def test_plain_reads_back():
    cart = read_strict(Cart, {"front": "large", "speed": [3, 4], "load": "coal"}, "here")
    assert read_strict(Cart, plain(cart), "again") == cart


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


def test_sizes_of_the_unit_do_not_forbid_what_physics_allows():
    assert read_strict(Sized, {"gap": 0.0, "offset": -1e-15}, "it") == Sized(offset=-1e-15)
    rows = {row.key: row.bounds for row in describe(Sized)}
    assert rows["radius"].of_physics.allow(math.inf)
    assert not rows["radius"].of_physics.allow(0.0)
