"""Runs that fail: what no motion can have is found in the outputs; the file that is left says where, and goes on."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from processes import forked

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bodies.motion import PairMotion
from bearing_twin.log.run_log import read_log
from bearing_twin.run.failure import read_failure, write_failure
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate

PINNED = ("run.duration=0.4", "solver.stepper=rodas4", "contact.normal=hertz")
BALLS = load_scene("bearing_6203", PINNED)
SPOILT_FROM = 0.25  # s, in the chunk that ends at 0.299 s; its state before is that of output 199
SPOILS = {
    "not finite": ("normal_load", (40, 3, 1), np.nan, "ball 3", "outer race"),
    "not a rotation": ("orientation", (40, 5, 0), 0.9, "ball 5", ""),
    "not a rotation, too short": ("orientation", (40, 5), 0.4, "ball 5", ""),
    "out of bounds": ("velocity", (40, 2, 1), 2e5, "ball 2", ""),
    "energy": ("kinetic_energy", (40,), 1e3, "", ""),
}


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch):
    """Several chunks in a short run."""
    monkeypatch.setattr("bearing_twin.kinds.bearing.motion.LONGEST_CHUNK", 0.1)


@pytest.fixture
def spoilt(monkeypatch):
    """A function that has one number of the outputs replaced, for scenes of the default tolerance or looser."""
    move = BearingMotion.advance

    def spoil(name, index, value):
        def advance(self, times, duration):
            out = move(self, times, duration)
            if self.elapsed > SPOILT_FROM and self.parameters.wanted.tolerance >= 1e-3:
                getattr(out, name)[index] = value
            return out

        monkeypatch.setattr(BearingMotion, "advance", advance)

    return spoil


def failed(scene):
    with pytest.raises(IntegrationError) as caught:
        for _ in simulate(scene).blocks():
            pass
    return caught.value


@pytest.mark.parametrize("reason", SPOILS)
def test_a_number_that_no_motion_has_stops_the_run_and_is_named(reason, spoilt, tmp_path):
    name, index, value, body, contact = SPOILS[reason]
    spoilt(name, index, value)
    error = failed(BALLS)
    reason = reason.partition(",")[0]
    assert (error.reason, error.body, error.seconds) == (reason, body, pytest.approx(0.24))
    assert error.contact == contact or not contact
    failure = read_failure(write_failure(error, tmp_path))
    assert (failure.sequence, failure.good_seconds, failure.reason) == (199, pytest.approx(0.239), reason)
    assert failure.scene == BALLS
    assert all(np.isfinite(value) for _, value, _ in failure.body_rows())


@pytest.mark.parametrize(
    "overrides",
    [
        PINNED,
        (
            *PINNED,
            "drive.acceleration=100",
            *(f"drive.change.{one}" for one in ("time=0.1", "speed=40", "offset=[1e-6,0,0]")),
        ),
    ],
    ids=["even", "changing"],
)
def test_a_run_goes_on_from_its_last_good_state_to_the_bit(overrides, spoilt, monkeypatch, tmp_path):
    scene = load_scene("bearing_6203", overrides)
    expected = np.concatenate([block.matrix() for block in simulate(scene).blocks()])
    spoilt("normal_load", (40, 3, 1), np.nan)
    failure = read_failure(write_failure(failed(scene), tmp_path))
    monkeypatch.undo()
    monkeypatch.setattr("bearing_twin.kinds.bearing.motion.LONGEST_CHUNK", 0.1)
    continued = list(simulate(scene, failure=failure).blocks())
    assert continued[0].first_sequence == 200
    assert np.concatenate([block.matrix() for block in continued]).tobytes() == expected[200:].tobytes()


@pytest.mark.parametrize("name", ["ellipsoid_rocking", "two_bodies_ellipsoid"])
def test_bodies_go_on_to_the_bit_in_the_middle_of_a_contact(name, monkeypatch, tmp_path):
    scene = load_scene(name, ["run.duration=0.3"])
    whole = list(simulate(scene).blocks())
    move = PairMotion.advance

    def advance(self, times, duration):
        out = move(self, times, duration)
        if self._now > 0.25:
            out["position"][-1] = np.nan
        return out

    monkeypatch.setattr(PairMotion, "advance", advance)
    failure = read_failure(write_failure(failed(scene), tmp_path))
    monkeypatch.undo()
    expected = np.concatenate([block.matrix() for block in whole])
    continued = list(simulate(scene, failure=failure).blocks())
    assert 0 < failure.sequence == continued[0].first_sequence - 1
    numbers = np.concatenate([block.matrix() for block in continued])
    assert numbers.tobytes() == expected[continued[0].first_sequence :].tobytes()
    records = [np.concatenate([block.records["contact"] for block in blocks]) for blocks in (whole, continued)]
    assert records[0][len(records[0]) - len(records[1]) :].tobytes() == records[1].tobytes()


def test_failures_of_the_core_leave_a_file_too(tmp_path):
    """A tolerance without any sense: ever shorter steps."""
    simulation = Simulation(BALLS)
    simulation.advance(50)
    simulation._motion._motion.scales = simulation._motion._motion.scales * 1e-30
    assert simulation.advance(100).first_sequence == 50  # what was computed ahead of that
    with pytest.raises(IntegrationError) as caught:
        simulation.advance(100)
    failure = read_failure(write_failure(caught.value, tmp_path))
    assert (failure.reason, failure.sequence) == ("stalled", 99)
    assert failure.body.startswith("ball ")
    assert failure.contact in ("inner race", "outer race")
    assert {unit for _, _, unit in failure.body_rows()} >= {"N", "m/s"}


def test_a_run_that_fails_in_its_first_step_gives_out_its_start():
    simulation = Simulation(BALLS)
    simulation._motion._motion.scales = simulation._motion._motion.scales * 1e-30
    assert len(simulation.advance(100)) == 1
    with pytest.raises(IntegrationError, match=r"^after 0 s: at ") as caught:
        simulation.advance(100)
    assert (caught.value.record["last_good_s"], caught.value.record["state_after_output"]) == (0.0, 0)


OVERLOADED = (
    "rings.inner.change.time=0.0105",
    "rings.inner.change.load=[0, -7e5, 0]",
    "cage.kind=none",
    "run.duration=0.1",
)


def overloaded_arguments() -> list[str]:
    return ["bearing_6203_rig_400N", *(argument for override in OVERLOADED for argument in ("--set", override))]


def test_a_run_that_breaks_off_within_a_chunk_leaves_all_before_in_log_and_figures(
    tmp_path, monkeypatch, run_json, run_cli
):
    monkeypatch.chdir(tmp_path)
    reported, error = run_cli("simulate", *overloaded_arguments(), "--out", "run.mcap", "--json", code=BAD_INPUT)
    ran = json.loads(reported)
    assert "bearing_twin: after 0.01 s: at 0.0105 s a load of" in error
    assert "bearing_twin explain failure_" in error
    assert (ran["status"], ran["samples"], ran["simulated_s"]) == ("failed: overload", 11, pytest.approx(0.01))
    assert (ran["failure_at_s"], ran["failure_body"]) == (pytest.approx(0.0105), "inner ring")

    reported, error = run_cli("report", "run.mcap", "--json", "--strict", code=DOUBTFUL)
    logged = json.loads(reported)
    assert {key: logged.get(key) for key in ran} == ran
    assert f"bearing_twin: warning: the run failed {ran['failure']}" in error
    assert run_json("verify", "run.mcap", "--strict")["samples"] == 11
    assert "The run failed after" in run_cli("view", "run.mcap", "--json").err

    short = load_scene("bearing_6203_rig_400N", [*OVERLOADED[:3], "run.duration=0.01"])
    loads = [sample["normal_load"] for sample in simulate(short)]
    np.testing.assert_allclose([sample["normal_load"] for sample in read_log("run.mcap")], loads, rtol=1e-3, atol=0.1)


def test_explain_says_what_happened_and_goes_on(spoilt, tmp_path, monkeypatch, capsys, run_json, refused, run_cli):
    monkeypatch.chdir(tmp_path)
    spoilt("normal_load", (40, 3, 1), np.nan)
    arguments = [argument for override in PINNED for argument in ("--set", override)]
    assert main(["simulate", "bearing_6203", *arguments]) == BAD_INPUT
    [file] = tmp_path.glob("failure_*.json")
    assert f"bearing_twin explain {file.name}" in capsys.readouterr().err
    reported = run_json("explain", file.name, "--out", "rest.mcap")
    assert (reported["body"], reported["contact"], reported["at_s"]) == ("ball 3", "outer race", pytest.approx(0.24))
    assert (reported["continued_from_s"], reported["continued_to_s"]) == (pytest.approx(0.199), pytest.approx(0.4))
    assert (reported["tolerance"], reported["status"]) == (pytest.approx(1e-4), "done")
    assert reported["last_good"]["normal_load outer race"] > 0.0
    assert run_json("report", "rest.mcap")["samples"] == 201
    done = forked(lambda: main(["explain", file.name, "--json", "--out", "full.mcap"]), largest_file=300_000)
    assert (done.returncode, json.loads(done.stdout)) == (BAD_INPUT, {k: v for k, v in reported.items() if k != "log"})
    assert "the log is incomplete: full.mcap cannot grow" in done.stderr
    # fails again where the tolerance is as loose as before, and says so
    printed = run_cli("explain", file.name, "--tolerance", "1e-3", "--strict", code=DOUBTFUL)
    assert "it fails again" in printed.err
    assert "normal_load outer race" in printed.out
    assert len(list(tmp_path.glob("failure_*.json"))) == 2
    assert main(["explain", file.name, "--until", "0.25"]) == DONE
    assert "continued_to_s" not in json.loads(run_cli("explain", file.name, "--stop", "--json").out.splitlines()[-1])
    # a node goes on beyond the end of its scene, and so does the report on its failure
    Path("node.json").write_text(file.read_text().replace("duration: 0.4", "duration: 0.1"))
    reported = run_json("explain", "node.json")
    assert (reported["continued_from_s"], reported["continued_to_s"]) == (pytest.approx(0.199), pytest.approx(0.299))
    assert "--until 0.15 must be later than 0.199 s" in refused("explain", "node.json", "--until", "0.15")


def test_a_file_that_is_no_failure_and_a_state_that_no_bearing_is_in_are_refused(spoilt, tmp_path, refused):
    spoilt("normal_load", (40, 3, 1), np.nan)
    path = write_failure(failed(BALLS), tmp_path)
    text = path.read_text(encoding="utf-8")
    for key, value, sentence in (
        ("format", "another", "not the file of a failed run"),
        ("scene", "kind: nothing", "nothing"),
        ("state", {"state": [[1.0]]}, "does not fit its scene"),
        ("last_good_output", {"normal_load": [1.0]}, "does not fit its scene"),
        ("last_good_output", {"normal_load": "x"}, "does not fit its scene"),
        ("seconds", "soon", "not the file of a failed run"),
    ):
        path.write_text(json.dumps(json.loads(text) | {key: value}), encoding="utf-8")
        assert sentence in refused("explain", path)
    path.write_text(text, encoding="utf-8")
    failure = read_failure(path)
    Simulation(failure.scene).resume(failure)
    for key, value in (
        ("commanded", [[1.0]]),
        ("commanded_torque", [1.0, 2.0]),
        ("offset", [0.0, 0.0]),
        ("drive", [0.0, math.nan, 0.0]),
    ):
        with pytest.raises(SceneError, match="does not fit its scene"):
            Simulation(failure.scene).resume(failure._replace(state=dict(failure.state) | {key: value}))


def test_what_has_no_end_is_not_read_to_its_end(monkeypatch):
    """Files of devices and of the system say that they are empty."""
    monkeypatch.setattr("bearing_twin.run.failure.LARGEST_FILE", 10)
    with pytest.raises(BearingTwinError, match="too large"):
        read_failure("/proc/self/status")
