"""What people expect of a command line: units, tables that fit, examples that work, completion, near names."""

import json
import math
import os
import re
import shlex
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearing_twin.command import cli, commands, layout
from bearing_twin.command.commands import COMMANDS
from bearing_twin.command.completion_command import SHELLS
from bearing_twin.command.terminal import show_result
from bearing_twin.spelling import LONGEST_ECHO, name_of_peer, nearest, slips
from bearing_twin.units import UNITS, for_people, known_digits, readable, two_digits

RESULT = {
    "cage_speed_rad_s": 69.9611,
    "drive_torque_nm": 1.5e-3,
    "ring_displacement_m": [0.0, -2.5e-6, 1e-5],
    "misalignment_rad": [1e-3, 0.0],
    "peak_pressure_pa": [1.066e9, -1.23456e-5, 2.0e9, 3.0e9],
    "simulated_s": 0.02,
    "force_n": 12345.6,
}


def shown(capsys, result):
    show_result(result)
    return capsys.readouterr().out


def test_people_read_engineering_units_and_si_where_they_ask(capsys, monkeypatch):
    out = shown(capsys, RESULT)
    for words in ("668.079 rpm", "1.5 N mm", "0, -2.5, 10 µm", "0.0572958, 0 °", "20 ms", "12.3456 kN", "1066"):
        assert words in out, out
    assert "MPa" in out
    monkeypatch.setattr(commands, "COMMANDS", {"scenes": COMMANDS["scenes"]._replace(run=lambda _: cli_outcome())})
    assert cli.main(["scenes", "--si"]) == cli.DONE
    out = capsys.readouterr().out
    for words in ("69.9611 rad/s", "0.0015 N m", "0, -2.5e-06, 1e-05 m", "1.066e+09"):
        assert words in out, out
    assert cli.main(["scenes", "--json", "--si"]) == cli.DONE
    assert json.loads(capsys.readouterr().out) == RESULT


@pytest.mark.parametrize("words", [[], ["--si"], ["--json"]])
def test_a_doubt_is_told_in_the_units_of_the_table(words, capsys):
    """An ellipse that is wide along the groove: a sentence with lengths, on both streams."""
    scene = ["simulate", "two_spheres", "--set", "run.duration=1e-4"]
    assert cli.main([*scene, *words]) == cli.DONE
    captured = capsys.readouterr()
    for text in (captured.err, " ".join(captured.out.split())):
        assert ("the yield pressure 3200 MPa" in text) is not bool(words), text
        assert ("the yield pressure 3.2e+09 Pa" in text) is bool(words), text


def test_what_a_choice_predicted_is_a_sentence_in_the_table_and_numbers_for_programs(capsys):
    result = {"choice_reason": "off by 2.6e-05", "predicted": {"motion": "settled", "cost": 0.0024}}
    assert shown(capsys, result).split() == ["choice", "reason", "off", "by", "2.6e-05"]
    assert cli.main(["simulate", "bearing_6203", "--duration", "0.001", "--json"]) == cli.DONE
    assert json.loads(capsys.readouterr().out)["predicted"]["motion"]


def test_zeros_have_the_unit_of_their_neighbours_and_no_error_beside_them(capsys):
    result = {
        "greatest_approach_m": 0.0,
        "greatest_approach_m_error": 0.0,
        "semi_major_inner_m": [0.0] * 4,
        "semi_major_outer_m": [2e-3] * 4,
        "cage_speed_rad_s": 1.0,
        "roll_rate_rad_s": 1.0,
        "spin_rad_s": 1.0,
        "height_m": 1.1,
        "work_j": 3e-6,
        "dissipated_j": 0.0,
    }
    lines = shown(capsys, result).splitlines()
    assert [line.split()[-2:] for line in lines if line.startswith(("greatest", "dissipated"))] == [
        ["0", "mm"],
        ["0", "µJ"],
    ]
    assert next(line for line in lines if line.startswith("ball")).split() == ["ball", "mm", "mm"]
    assert shown(capsys, {"greatest_approach_m": 0.0, "count": 1}).split("\n")[0] == "greatest approach  0 µm"


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (48.4967, 0.89, "48.50"),
        (794.102, 3.6e7, "0"),
        (151367.0, 2800.0, "151400"),
        (-0.002, 0.3, "0.00"),
        (12.0, 1.0, "12.0"),
        (668.0801, 1e-9, "668.08"),
        (1234567.0, 1.0, "1.23457e+06"),
        (1.5, math.inf, "1.5"),
        (2.5, 0.0, "2.5"),
        (2.5, None, "2.5"),
        (0.0, 2e-12, "0"),
    ],
)
def test_a_number_is_shown_to_the_second_digit_of_its_error(value, error, shown):
    assert known_digits(value, error) == shown


@given(st.floats(-1e12, 1e12), st.floats(1e-12, 1e12))
def test_what_is_shown_is_off_by_less_than_a_tenth_of_the_error_or_in_the_sixth_digit(value, error):
    assert abs(float(known_digits(value, error)) - value) <= max(0.0501 * error, 5.01e-6 * abs(value))
    assert float(two_digits(error)) == pytest.approx(error, rel=0.051)


def cli_outcome():
    from bearing_twin.command.outcome import Outcome

    return Outcome(RESULT, [], lambda: pytest.fail("shown in engineering units"), True)


def test_every_unit_that_people_read_is_the_same_quantity():
    """Factors against the definitions of degree, revolution and prefixes."""
    exact = {"°": ("rad", 57.29577951308232), "rpm": ("rad/s", 9.549296585513721), "MPa": ("Pa", 1e-6)}
    exact |= {"N mm": ("N m", 1e3), "N/µm": ("N/m", 1e-6), "mm²": ("m^2", 1e6), "mm³": ("m^3", 1e9)}
    of_people = {row.people[0]: (symbol, row.people[1]) for symbol, row in UNITS.items() if row.people}
    assert set(of_people) == set(exact)
    for name, (symbol, factor) in of_people.items():
        assert (symbol, factor) == (exact[name][0], pytest.approx(exact[name][1], rel=1e-15))
    assert for_people(2e-5, UNITS["m"]) == ("µm", pytest.approx(1e6))
    forces = {3.96e7: ("MN", 1e-6), 1500.0: ("kN", 1e-3), 999.0: ("N", 1.0), 0.0: ("N", 1.0), 7e-3: ("mN", 1e3)}
    assert {size: for_people(size, UNITS["N"]) for size in forces} == forces
    assert readable("peak_pressure_inner_pa", 1e9) == ("peak pressure inner", "MPa", 1e-6)
    assert readable("energy_closure", 1.0) == ("energy closure", "", 1.0)


@pytest.mark.parametrize("width", ["40", "80", "132"])
def test_tables_fit_and_cut_no_number(width, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", width)
    for words in (
        ["scenes"],
        ["scenes", "--keys"],
        ["scenes", "--figures"],
        ["study", "--list"],
        ["topics", "two_discs"],
    ):
        assert cli.main([*words, "--json"]) == cli.DONE
        result = json.loads(capsys.readouterr().out)
        assert cli.main(words) == cli.DONE
        out = capsys.readouterr().out
        told = set(out.split())
        assert "…" not in out
        for line in out.splitlines():
            assert len(line) <= int(width) or len(line.split()) <= 2, line
        for rows in result.values():
            assert {word for row in rows for word in str(row.get("description", row.get("help", ""))).split()} <= told


cells = st.floats(allow_nan=False).map(lambda value: f"{value:.6g}")


@given(st.lists(st.tuples(cells, cells, cells), min_size=1, max_size=5), st.integers(20, 100))
def test_a_table_of_numbers_holds_each_of_them_whole(rows, width):
    for lines in (
        layout.table(("first one", "second", "a third name"), rows, width),
        [line for one in layout.columns_apart(("a", "b c", "d"), list(zip(*rows, strict=True)), width) for line in one],
    ):
        words = " ".join(lines).replace(";", " ").split()
        for row in rows:
            assert all(cell in words for cell in row)


def test_lists_of_balls_are_cut_into_tables_and_not_into_numbers(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "50")
    columns = {f"channel_number_{k}_kg": [-1.234567e-12 * 10.0**k, 1e5, 0.5, 12.0] for k in range(9)}
    out = shown(capsys, columns)
    assert max(map(len, out.splitlines())) <= 50
    words = out.split()
    for values in columns.values():
        assert all(f"{value:.6g}" in words for value in values)


def parsers_below(parser):
    """This parser and all below it."""
    yield parser
    for action in parser._actions:
        for below in dict.fromkeys(action.choices.values()) if isinstance(action.choices, dict) else ():
            yield from parsers_below(below)


def test_every_help_has_an_example_and_fits_eighty_columns(monkeypatch):
    """An example of `node` that names a type of ROS may be longer: broken, it could not be copied."""
    monkeypatch.setenv("COLUMNS", "80")
    for parser in list(parsers_below(cli._parsers()[0]))[1:]:
        text = parser.format_help()
        assert re.search(r"^examples?:\n  bearing_twin ", text, flags=re.MULTILINE), text
        long = [one for one in text.splitlines() if len(one) > 80]
        assert all(re.search("/(msg|srv|action)/", one) for one in long), long


def test_every_command_has_examples_and_each_of_them_parses(capsys):
    parser, _ = cli._parsers()
    for name, command in COMMANDS.items():
        assert command.examples, f"{name} has no example in its --help"
        for line in command.examples:
            program, *words = shlex.split(line)
            assert (program, words[0]) == ("bearing_twin", name)
            arguments, rest = parser.parse_known_args(words)
            assert (arguments.command, rest) == (name, []), line
        with pytest.raises(SystemExit) as ended:
            cli.main([name, "--help"])
        assert ended.value.code == 0
        out = capsys.readouterr().out
        assert all(line in out for line in command.examples)
        assert all(len(line) <= 80 or line.strip() in command.examples for line in out.splitlines())


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_is_told_how_to_complete(shell, capsys):
    assert cli.main(["completion", shell]) == cli.DONE
    assert "bearing_twin" in capsys.readouterr().out


def completions(line, tmp_path):
    """What bash would be offered behind this line."""
    told = tmp_path / "told"
    environment = os.environ | {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_COMP_WORDBREAKS": " \t\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(told),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
        "IFS": "\v",
    }
    program = "import sys; sys.argv[0] = 'bearing_twin'; from bearing_twin.command.cli import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=300)
    assert told.exists(), done.stderr
    return [word.strip() for word in re.split("[\v\x0b]", told.read_text(encoding="utf-8")) if word.strip()]


def test_commands_options_names_and_keys_are_completed(tmp_path, quick_starts):
    assert completions("bearing_twin sim", tmp_path) == ["simulate"]
    assert "--load" in completions("bearing_twin bearing 6308 --lo", tmp_path)
    assert completions("bearing_twin bearing 630", tmp_path) == [f"630{k}" for k in range(10)]
    assert completions("bearing_twin node start s", tmp_path) == ["sim_node"]
    assert completions("bearing_twin node study spheres_alpha_4", tmp_path) == ["spheres_alpha_4e-5"]
    assert completions("bearing_twin node start sim_node -p ove", tmp_path) == ["overrides:="]
    assert completions("bearing_twin view bearing_6203_l", tmp_path) == [
        "bearing_6203_load_and_speed",
        "bearing_6203_loose",
    ]
    assert completions("bearing_twin contact --material sili", tmp_path) == ["silicon_nitride"]
    found = completions("bearing_twin simulate bearing_6203 --set contact.normal=vol", tmp_path)
    assert found in (["contact.normal=volumetric"], ["volumetric"])


def test_a_missing_package_for_completion_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "argcomplete", None)
    assert cli.main(["completion", "bash"]) == cli.BAD_INPUT
    assert "pip install '.[completion]'" in capsys.readouterr().err


def test_near_words_are_near():
    assert slips("6380", "6308") < slips("6380", "6300") == 1.0
    assert slips("kitten", "sitting") == 3.0
    assert slips("ca", "abc") == 3.0  # the optimal string alignment distance, which edits no letter twice
    assert nearest("baering_6203", ["bearing_6205", "bearing_6203"]) == ["bearing_6203"]
    assert nearest("bearing_6230", ["bearing_6205", "bearing_6203", "bearing_6231"]) == ["bearing_6203"]
    assert nearest("xyz", ["abc"]) == []


@given(st.text("abc", max_size=6), st.text("abc", max_size=6), st.text("abc", max_size=6))
def test_slips_are_a_distance_of_words(first, second, third):
    assert slips(first, second) == slips(second, first) >= 0.0
    assert (slips(first, second) == 0.0) == (first == second)
    assert slips(first + third, second + third) <= slips(first, second)
    assert slips(first, second) <= max(len(first), len(second))


def test_units_of_mappings_and_lists_of_events_are_shown(capsys):
    events = [{"start_s": 0.0, "peak_force_n": 1.5}, {"start_s": 2e-5, "peak_force_n": 2.5}]
    result = {"clearance_m": {"initial": 1.3e-5, "fit": -2e-6}, "frequencies_hz": {"ftf": 11.2}, "contacts": events}
    out = shown(capsys, result)
    for words in ("clearance initial  13 µm", "clearance fit      -2 µm", "frequencies ftf    11.2 Hz", "20"):
        assert words in out, out
    lines = out.splitlines()
    assert lines[lines.index("contacts") + 1].split() == ["start", "[µs]", "peak", "force", "[N]"]
    assert [line.split() for line in lines[-2:]] == [["0", "1.5"], ["20", "2.5"]]


def test_names_of_peers_bring_no_control_characters_to_a_terminal():
    assert name_of_peer("std_msgs/msg/Float64") == "std_msgs/msg/Float64"
    assert name_of_peer("a/msg/\x1b[2J") == "'a/msg/\\x1b[2J'"
    assert len(name_of_peer("x" * 100_000)) == LONGEST_ECHO
