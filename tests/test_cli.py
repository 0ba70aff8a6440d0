"""The command line from outside: exit codes, one JSON object, one sentence for each mistake, nothing overwritten."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest

from bearing_twin.base.parameters import describe
from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, INTERRUPTED, main
from bearing_twin.command.commands import COMMANDS
from bearing_twin.command.outcome import Outcome
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import load_scene, scene_names

COMMAND = [sys.executable, "-m", "bearing_twin"]
SHORT = ["bearing_6203", "--duration", "0.02"]


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "run.mcap"
    assert main(["simulate", *SHORT, "--out", str(path)]) == DONE
    return path


def test_simulate_prints_one_json_object_with_what_was_requested(run_json):
    result = run_json("simulate", *SHORT, "--set", "geometry.balls=3", "--set", "contact.normal=volumetric")
    assert result["law"] == "volumetric"
    assert result["scene"] == "bearing_6203"
    assert result["simulated_s"] == pytest.approx(0.02)
    assert result["cage_speed_rad_s"] == pytest.approx(result["cage_speed_theory_rad_s"], rel=0.01)
    assert abs(result["energy_closure"]) < 1e-3
    assert result["real_time_factor"] > 0.0
    assert result["compute_s"] > 0.0
    for key in ("normal_load_inner_n", "normal_load_outer_n", "friction_torque_nm", "semi_major_inner_m",
                "semi_minor_outer_m"):  # fmt: skip
        assert len(result[key]) == 3
    assert result["stepper"] in ("rk4", "rodas4", "dop853", "radau")


def test_without_json_the_result_is_a_table_on_standard_output(run_cli):
    short, err = run_cli("simulate", *SHORT)
    labels = ("normal", "ball", "cage speed", "status", "times real time")
    assert sorted(labels, key=short.index) == [*labels]  # loads first, then figures, then how it went
    assert " rpm" in short
    assert not any(label in err for label in labels)
    full = run_cli("simulate", *SHORT, "--verbose").out
    for label in ("cage speed", "choice reason", "ball steps", "model errors", "not included", "pressure"):
        assert label in full
        assert label not in short.replace("with --verbose", "") or label == "cage speed"


def test_a_run_is_logged_reported_and_verified(log, run_json):
    verification = run_json("verify", log)
    assert verification["greatest_deviation"] == 0.0
    assert verification["samples"] == 21
    # Friction at a point has no moment of spin, so that its torque is exactly 0, which needs no warning.
    report = run_json("report", log, "--strict")
    assert report["model_errors"]["friction_model"]["drive_torque_nm"] > 100.0 * abs(report["drive_torque_nm"])
    assert report["flags"] == []
    assert report["status"] == "done"
    assert report["samples"] == 21
    assert report["missing_outputs"] == 0
    assert report["scene"] == "bearing_6203"
    assert len(report["greatest_normal_load_inner_n"]) == 8


def test_pictures_are_drawn_while_simulating_and_from_a_log(log, tmp_path, pictures_once, run_json):
    for arguments in (["simulate", *SHORT], ["report", log]):
        picture = tmp_path / f"{arguments[0]}.png"
        assert run_json(*arguments, "--plot", picture)["plot"] == str(picture)
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_strict_turns_doubt_into_exit_code_3(run_json):
    # far too much interference for the half-space: the ellipse is as wide as the ball's cap
    arguments = ["simulate", *SHORT, "--set", "geometry.radial_clearance=-1.3e-4"]
    assert run_json(*arguments)["flags"]
    assert run_json(*arguments, "--strict", code=DOUBTFUL)["flags"]


def test_scenes_and_keys_are_listed(run_json, run_cli):
    loaded = [load_scene(name) for name in scene_names()]
    listed = [{"name": scene.name, "kind": scene.kind, "description": scene.description} for scene in loaded]
    assert run_json("scenes")["scenes"] == listed
    shown = run_cli("scenes").out.split()
    assert set(shown) >= {word for row in listed for word in row["description"].split()}, "words are cut"
    keys = run_json("scenes", "--keys")["keys"]
    assert [key["key"] for key in keys] == [row.key for kind in KINDS.values() for row in describe(kind.parameters)]
    out, err = run_cli("scenes", "--keys")
    assert "contact.friction_coefficient" in out
    assert err == ""


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["simulat", "x"], "did you mean simulate?"),
        (["simulate"], "required: scene"),
        (["simulate", "bearing_6203", "--jsn"], "did you mean --json?"),
        (["simulate", "6308", "--speed", "3000rpm"], "--set drive.speed=3000rpm"),
        (["simulate", "bearing_6203", "--plot", "run.mcap"], "ends in .png"),
        (["simulate", "soft_discs_mean", "--plot", "run.gif"], "bearing_twin view RUN --gif FILE"),
        (["simulate", "bearing_6203", "--plot", "none/run.png"], "none is not a folder"),
        (["simulate", "bearing_6203", "--out", "none/run.mcap"], "does not exist"),
        (["simulate", "two_spheres", "--max-loss", "0.1"], "was removed: use bearing_twin.write_log"),
        (["scenes", "--schema"], "was removed: bearing_twin scenes --keys"),
        (["completion", "bash"], "register-python-argcomplete"),
        (["report", "none.mcap"], "there is no log"),
        (["--json", "scenes"], "options go behind the command: bearing_twin scenes ... --json"),
        (
            ["contact", "--radii-1", "0.01", "--speed", "1", "--mass", "nan"],
            "--mass: 'nan' must be a number",
        ),
    ],
)
def test_each_mistake_gets_one_sentence_and_exit_code_2(arguments, sentence, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    assert sentence in refused(*arguments)
    assert list(tmp_path.iterdir()) == []


def test_help_is_a_word_too(capsys):
    texts = []
    for arguments in (["help", "simulate"], ["simulate", "--help"]):
        with pytest.raises(SystemExit) as caught:
            main(arguments)
        assert caught.value.code == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1]


def test_no_subcommand_shows_the_help(run_cli):
    err = run_cli(code=BAD_INPUT).err
    assert all(name in err for name in COMMANDS)


@pytest.mark.parametrize(
    ("commands", "further"),
    [
        ([["--help"]], ("rich", "yaml", "mcap", "rosbags")),
        ([["scenes"], ["scenes", "--keys"], ["study", "--list"]], ()),
    ],
    ids=["help", "lists"],
)
def test_help_and_lists_import_nothing_heavy(commands, further):
    heavy = ("numpy", "scipy", "matplotlib", *further)
    code = (
        f"import sys\nfrom bearing_twin.command.cli import BAD_INPUT, main\nfor words in {commands}:\n"
        f"    try:\n        code = main(words)\n    except SystemExit as end:\n        code = end.code\n"
        f"    assert code == 0\n    print([name for name in {heavy} if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.stderr.splitlines() == ["[]"] * len(commands)
    assert all(word in done.stdout for word in (["simulate"] if further else ["two_spheres", "drive.speed"]))


def test_ctrl_c_while_modules_load_is_one_line(tmp_path):
    (tmp_path / "argparse.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "bearing_twin", "scenes"],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "bearing_twin: interrupted\n")


@pytest.mark.parametrize(
    ("number", "code"),
    [
        pytest.param(signal.SIGINT, INTERRUPTED, marks=pytest.mark.environment),
        (signal.SIGTERM, 128 + signal.SIGTERM),
    ],
)
def test_an_interrupted_run_leaves_a_log_that_opens(number, code, tmp_path, run_json):
    path = tmp_path / "run.mcap"
    long = ["bearing_6203", "--duration", "86400", "--set", "run.output_rate=100"]
    arguments = [*COMMAND, "simulate", *long, "--out", str(path)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(arguments, **pipes) as process:
        while not (path.exists() and path.stat().st_size > 100_000):
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        process.send_signal(number)
        out, err = process.communicate(timeout=600)
    assert process.returncode == code
    assert out == ""
    assert "Traceback" not in err
    report = run_json("report", path)
    assert report["samples"] > 20
    assert report["missing_outputs"] == 0


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM])
def test_a_closed_terminal_ends_a_command_but_not_under_nohup(number, monkeypatch):
    def run(arguments):
        signal.raise_signal(number)
        return Outcome({}, [])

    def outside(*_):
        pytest.fail("the signal went past the command line")

    monkeypatch.setitem(COMMANDS, "scenes", COMMANDS["scenes"]._replace(run=run))
    before = signal.signal(number, signal.SIG_IGN)
    try:
        assert main(["scenes"]) == DONE
        signal.signal(number, outside)
        with pytest.raises(SystemExit) as ended:
            main(["scenes"])
        assert signal.getsignal(number) is outside
    finally:
        signal.signal(number, before)
    assert ended.value.code == 128 + number


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["simulate", "two_spheres", "--duration", "2e-4", "--set", "run.duration=1e-4"], "run.duration"),
        (["simulate", "bearing_6203", "--set", "solver.allow_invalid=off", "--allow-invalid"], "allow_invalid"),
        (["study", "spheres_alpha_4e-5", "--samples", "20", "--set", "samples=30"], "samples"),
        (["node", "study", "spheres_alpha_4e-5", "--samples", "20", "--set", "samples=30"], "samples"),
        (["simulate", "6203", "--set", "solver.companion=on", "--set", "solver.check=none"], "solver.check"),
    ],
)
def test_a_key_that_is_given_two_values_is_refused(arguments, key, refused):
    assert re.search(rf"{key} is given as '?\S+'? and as '?\S+'?; keep one of them", refused(*arguments))


def test_nothing_that_exists_is_replaced_without_force(log, tmp_path, monkeypatch, pictures_once, run_json, refused):
    """One rule for pictures, sheets, logs and tables; a pipe is never written to."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.png")
    commands = {
        "run.png": ["simulate", *SHORT, "--plot", "run.png"],
        "log.png": ["report", log, "--plot", "log.png"],
        "contact.png": ["contact", "--radii-1", "0.01", "--load", "100", "--plot", "contact.png"],
        "bearing.png": ["bearing", "6203", "--load", "0,-500,0", "--plot", "bearing.png"],
        "sheet.html": ["bearing", "6203", "--load", "0,-500,0", "--out", "sheet.html"],
        "run.mcap": ["simulate", *SHORT, "--out", "run.mcap"],
        "saved.mcap": ["recover", log, "saved.mcap"],
    }
    for name, arguments in commands.items():
        (tmp_path / name).write_text("precious")
        assert "exists and is not overwritten; give another name, or --force" in refused(*arguments)
        assert (tmp_path / name).read_text() == "precious"
        run_json(*arguments, "--force")
        assert (tmp_path / name).stat().st_size > 100
    assert "pipe.png exists" in refused("simulate", *SHORT, "--plot", "pipe.png", "--force")
    assert "the file that is read" in refused("recover", "run.mcap", "run.mcap", "--force")


def test_a_pipe_in_the_place_of_a_failure_is_not_waited_for(tmp_path, refused):
    os.mkfifo(tmp_path / "failure.json")
    assert "is no file" in refused("explain", tmp_path / "failure.json")
