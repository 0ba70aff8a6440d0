"""Expectations of people of a command line: units, tables that fit, examples that work, completion, near names."""

import math
import os
import re
import shlex
import subprocess
import sys

import pytest

from bearing_twin.base.errors import LONGEST_ECHO, peer_name
from bearing_twin.base.units import UNITS, readable_unit, rounded_to_error
from bearing_twin.command import cli
from bearing_twin.command.cli import BAD_INPUT
from bearing_twin.command.commands import COMMANDS
from bearing_twin.run.scene import load_scene

RESULT = {
    "cage_speed_rad_s": 69.9611,
    "drive_torque_nm": 1.5e-3,
    "ring_displacement_m": [0.0, -2.5e-6, 1e-5],
    "misalignment_rad": [1e-3, 0.0],
    "peak_pressure_pa": [1.066e9, -1.23456e-5, 2.0e9, 3.0e9],
    "simulated_s": 0.02,
    "force_n": 12345.6,
}


def test_people_read_engineering_units_and_si_where_they_ask(shown, monkeypatch, run_json, run_cli):
    out = shown(RESULT)
    for text in ("668.08 rpm", "1.5 N mm", "0, -2.5, 10 µm", "0.057296, 0 °", "20 ms", "12.346 kN", "1066"):
        assert text in out, out
    assert "MPa" in out
    monkeypatch.setitem(COMMANDS, "scenes", COMMANDS["scenes"]._replace(run=lambda _: cli_outcome()))
    out = run_cli("scenes", "--si").out
    for text in ("69.961 rad/s", "0.0015 N m", "0, -2.5e-06, 1e-05 m", "1.066e+09"):
        assert text in out, out
    assert run_json("scenes", "--si") == RESULT


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (48.4967, 0.89, "48.50"),
        (794.102, 3.6e7, "0"),
        (151367.0, 2800.0, "151400"),
        (-0.002, 0.3, "0"),
        (12.0, 1.0, "12.0"),
        (668.0801, 1e-9, "668.08"),
        (1234567.0, 1.0, "1234570"),
        (1.5, math.inf, "1.5"),
        (2.5, 0.0, "2.5"),
        (2.5, None, "2.5"),
        (0.0, 2e-12, "0"),
    ],
)
def test_a_number_is_shown_to_the_second_digit_of_its_error(value, error, shown):
    assert rounded_to_error(value, error) == shown


def cli_outcome():
    from bearing_twin.command.outcome import Outcome

    return Outcome(RESULT, [], lambda: pytest.fail("shown in engineering units"), True)


def test_every_unit_that_people_read_is_the_same_quantity():
    """Factors against the definitions of degree, revolution and prefixes."""
    exact = {"°": ("rad", 57.29577951308232), "rpm": ("rad/s", 9.549296585513721), "MPa": ("Pa", 1e-6)}
    exact |= {
        "N mm": ("N m", 1e3),
        "N/µm": ("N/m", 1e-6),
        "mm²": ("m^2", 1e6),
        "mm³": ("m^3", 1e9),
        "mm²/s": ("m^2/s", 1e6),
    }
    of_people = {row.engineering[0]: (symbol, row.engineering[1]) for symbol, row in UNITS.items() if row.engineering}
    assert set(of_people) == set(exact)
    for name, (symbol, factor) in of_people.items():
        assert (symbol, factor) == (exact[name][0], pytest.approx(exact[name][1], rel=1e-15))
    assert readable_unit("m", 2e-5) == ("µm", pytest.approx(1e6))
    forces = {3.96e7: ("MN", 1e-6), 15000.0: ("kN", 1e-3), 1500.0: ("N", 1.0), 0.0: ("N", 1.0), 7e-3: ("mN", 1e3)}
    assert {size: readable_unit("N", size) for size in forces} == forces


def parsers_below(parser):
    """This parser and all below it."""
    yield parser
    for action in parser._actions:
        for below in dict.fromkeys(action.choices.values()) if isinstance(action.choices, dict) else ():
            yield from parsers_below(below)


def test_every_help_has_examples_that_parse_and_fits_eighty_columns(monkeypatch):
    """An example of `node` that names a type of ROS may be longer: broken, it could not be copied."""
    monkeypatch.setenv("COLUMNS", "80")
    parser, _ = cli.parsers()
    for subparser in list(parsers_below(parser))[1:]:
        text = subparser.format_help()
        assert re.search(r"^examples?:\n  bearing_twin ", text, flags=re.MULTILINE), text
        long = [line for line in text.splitlines() if len(line) > 80]
        assert all(re.search("/(msg|srv|action)/", line) for line in long), long
    for name, command in COMMANDS.items():
        assert command.examples, f"{name} has no example in its --help"
        for line in command.examples:
            program, *words = shlex.split(line)
            arguments, unknown = parser.parse_known_args(words)
            assert (program, words[0], arguments.command, unknown) == ("bearing_twin", name, name, []), line


@pytest.mark.parametrize(
    ("key", "wrong", "right", "units"),
    [
        ("drive.speed", "3000rps", "3000rpm", ["rad/s"]),
        ("geometry.radial_clearance", "10mic", "10µm", ["m", "mm"]),
        ("drive.tilt", "[1gon, 0]", "[1°, 0]", ["rad"]),
        ("run.duration", "3weeks", "3ms", ["s", "µs"]),
    ],
)
def test_a_number_in_a_wrong_unit_is_refused_with_the_units_that_are_read(key, wrong, right, units, run_cli):
    assert load_scene("bearing_6203", [f"{key}={right}"]).kind == "bearing"
    named = run_cli("simulate", "bearing_6203", "--set", f"{key}={wrong}", code=BAD_INPUT).err.rpartition(
        "units that are read:"
    )[2]
    assert {re.sub(r"[\d\[\], ]", "", right), *units} <= {unit.strip() for unit in named.split(",")}


def completions(line, tmp_path):
    """Words that bash would offer behind this line."""
    reported = tmp_path / "completions"
    environment = os.environ | {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_COMP_WORDBREAKS": " \t\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(reported),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
        "IFS": "\v",
    }
    program = "import sys; sys.argv[0] = 'bearing_twin'; from bearing_twin.command.cli import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=300)
    assert reported.exists(), done.stderr
    return [word.strip() for word in re.split("[\v\x0b]", reported.read_text(encoding="utf-8")) if word.strip()]


def test_commands_options_and_words_are_completed(tmp_path):
    for line, offered in {
        "expor": ["export"],
        "bearing 6308 --lo": ["--load"],
        "contact --race in": ["inner"],
    }.items():
        assert completions(f"bearing_twin {line}", tmp_path) == offered


def test_a_missing_package_for_completion_is_named(monkeypatch, refused):
    monkeypatch.setitem(sys.modules, "argcomplete", None)
    monkeypatch.setenv("_ARGCOMPLETE", "1")
    assert "pip install '.[completion]'" in refused("scenes")


def test_names_of_peers_bring_no_control_characters_to_a_terminal():
    assert peer_name("std_msgs/msg/Float64") == "std_msgs/msg/Float64"
    assert peer_name("a/msg/\x1b[2J") == "'a/msg/\\x1b[2J'"
    assert len(peer_name("x" * 100_000)) == LONGEST_ECHO
