"""Node parameters: what is taken, what is refused, and what the user reads."""

import math
from array import array

import pytest

from bearing_twin.nodes.node_parameters import (
    LOG_SAFETY,
    NodeParameter,
    ParameterError,
    checked,
    converted,
    help_of,
    safety_of,
)

TABLE = (
    NodeParameter("scene", "bearing_6203", "scene to run"),
    NodeParameter("overrides", [], "changes"),
    NodeParameter("rate", 1.0, "pace", "1", 1e-9, 10.0, words=("fastest",)),
    NodeParameter("depth", 5, "messages", "", 1, 100),
    NodeParameter("loop", False, "again"),
    NodeParameter("pause", 0.0, "wait", "s", 0.0, 60.0),
)


def test_defaults_and_given_values():
    assert checked(TABLE, {}) == {parameter.name: parameter.default for parameter in TABLE}
    values = checked(TABLE, {"rate": 5, "overrides": ["a=1"], "use_sim_time": True}, ["use_sim_time"])
    assert values["rate"] == 5.0
    assert isinstance(values["rate"], float)
    assert values["overrides"] == ["a=1"]
    assert checked(TABLE, {"rate": "fastest"})["rate"] == "fastest"


MISTAKES = (
    ({"scen": "x"}, "there is no parameter 'scen'; did you mean scene?"),
    ({"rate": math.nan}, "rate = nan must be finite"),
    ({"rate": -0.5}, "rate = -0.5 must lie between 1e-09 and 10, or fastest"),
    ({"rate": 0}, "rate = 0.0 must lie between 1e-09 and 10, or fastest"),
    ({"rate": "faster"}, "rate = 'faster' must be a number, or fastest"),
    ({"rate": array("q", [1, 2])}, "rate = [1, 2] must be a number"),  # as ROS hands it over
    ({"rate": "fast"}, "rate = 'fast' must be a number"),
    ({"depth": 0}, "depth = 0 must lie between 1 and 100"),
    ({"depth": 2.5}, "depth = 2.5 must be a whole number"),
    ({"depth": True}, "depth = True must be a whole number"),
    ({"loop": "yes"}, "loop = 'yes' must be true or false"),
    ({"scene": 3}, "scene = 3 must be text"),
    ({"overrides": "a=1"}, "overrides = 'a=1' must be a list of texts; write overrides:=\"['a=1']\""),
    ({"rate": "nan"}, "rate = 'nan' must be a number, or fastest"),
    ({"pause": "2 N"}, "pause = '2 N' must be a number in s"),
)


def test_mistakes_are_named_all_at_once():
    for given, words in MISTAKES:
        with pytest.raises(ParameterError) as refused:
            checked(TABLE, given)
        assert words in str(refused.value)
    with pytest.raises(ParameterError) as refused:
        checked(TABLE, {"rate": -1.0, "loop": 1, "sceen": ""})
    assert all(word in str(refused.value) for word in ("rate", "loop", "sceen"))


def test_to_keep_some_files_they_must_be_several():
    values = {parameter.name: parameter.default for parameter in LOG_SAFETY}
    with pytest.raises(ParameterError, match="needs split_size or split_duration"):
        safety_of(values | {"keep_files": 3})
    assert safety_of(values | {"keep_files": 3, "split_size": 1e6}).split_bytes == 1_000_000
    assert safety_of(values).patient


def test_a_whole_number_or_its_text_is_a_number_and_a_designation_but_no_other_text():
    number, text = NodeParameter("rate", 1.0, "pace"), NodeParameter("scene", "x", "scene", digits=True)
    assert type(converted(number, 5)) is float
    assert converted(number, "1e-5") == 1e-5  # a text to YAML
    assert converted(NodeParameter("pause", 0.0, "wait", "s", 0.0, 60.0), "20 ms") == 0.02
    assert converted(text, 6308) == "6308"
    assert converted(NodeParameter("overrides", [], "changes"), None) == []
    assert converted(NodeParameter("log", "", "log"), 3) == 3
    assert converted(NodeParameter("loop", False, "again"), True) is True


def test_help_tells_every_parameter_within_eighty_columns():
    reported = help_of("sim_node", "runs a scene", LOG_SAFETY)
    assert all(parameter.name in reported and parameter.help.split()[0] in reported for parameter in LOG_SAFETY)
    assert max(map(len, reported.splitlines())) <= 80
