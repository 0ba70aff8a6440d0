"""Loads over time on a shaft on two bearings: closed forms, linear theory, works, tables, what is refused."""

import math

import numpy as np
import pytest
from shafts import energy, motion_of, outputs_of

from bearing_twin.command.cli import BAD_INPUT, DONE, main
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.shaft.modes import modes_of
from bearing_twin.kinds.shaft.statics import balance_of
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

STILL = ("drive.speed=0", "shaft.unbalances=[]")


def coordinates(out):
    return np.concatenate([out["position"], out["tilt"]], axis=1)


def test_a_step_of_load_rings_at_the_natural_frequencies():
    """Undamped and small: q = sum of modes (1 - cos w t), by the bearings' stiffness and the shaft's inertia."""
    push = np.array([0.0, -0.04, 0.01, 4e-4, 0.0])
    step = f"shaft.change={{time: 0.01, load: {push[:3].tolist()}, moment: {push[3:].tolist()}}}"
    motion = motion_of(*STILL, step, "contact.relaxation_time=0", "wanted.tolerance=1e-7")
    found = balance_of(motion.parameters, "hertz", 0.0)
    times, out = outputs_of(motion, 0.06, 1200)
    moved = coordinates(out) - found.coordinates
    root = np.diag(np.array([motion.rotor.mass] * 3 + [motion.rotor.transverse] * 2) ** -0.5)
    squares, shapes = np.linalg.eigh(root @ found.stiffness @ root)
    amplitudes = shapes.T @ root @ push / squares
    since = np.maximum(times - 0.01, 0.0)[:, None]
    expected = (amplitudes * (1.0 - np.cos(since * np.sqrt(squares)))) @ shapes.T @ root
    for k in (1, 2, 3):
        assert np.abs(moved - expected)[:, k].max() < 0.01 * np.abs(expected[:, k]).max()
    # told of the scene's last loads, which this step changes by little
    told = modes_of(motion.parameters, "hertz")[0].frequencies
    assert told == pytest.approx(np.sqrt(squares) / (2.0 * math.pi), rel=1e-4)


def test_after_a_step_the_shaft_rests_in_balance_and_the_load_has_worked_along_its_way():
    step = "shaft.change={time: 0.01, load: [30, -200, 40], moment: [0.5, -1]}"
    motion = motion_of(*STILL, step, "contact.relaxation_time=1e-4", "shaft.load_place=0.02")
    before, after = (balance_of(motion.parameters, "hertz", 0.0, time).coordinates for time in (0.0, 1.0))
    _, out = outputs_of(motion, 0.3, 300)
    place = coordinates(out)
    assert np.abs(place[9] - before).max() < 1e-9 * np.abs(before).max()
    assert place[-1] == pytest.approx(after, rel=1e-6)
    push = np.array([30.0, -200.0, 40.0, 0.5 + 0.02 * 200.0, -1.0 + 0.02 * 30.0])
    assert np.concatenate([out["load"][11], out["load_moment"][11]]) == pytest.approx(push)
    assert not out["load"][10].any()  # that of the part which ends there
    assert out["load_work"][-1] == pytest.approx(push @ (after - before), rel=1e-5)
    books, gross = energy(out)
    assert np.abs(books - books[0]).max() < 1e-5 * gross


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("table=[[0,0,-1,0,0,0],[0,0,-2,0,0,0]]", "time must grow from row to row; 0 s follows 0 s"),
        ("table=[[0,0,-1,0,0,0],[1,0,null,0,0,0]]", r"table\[1\]: y = None must be a number"),
        ("table=[[0,0,-1,0,0,0],[1,0,.nan,0,0,0]]", r"table\[1\]: y = nan is not finite; must be a number"),
        ("table=[[0,0,-1]]", "6 numbers a row, none left out"),
        ("table=no_such_file.csv", "No such file"),
        ("load=[0,.nan,0]", r"shaft.load\[1\] = nan is not finite; must be a number"),
        ("change={time: 0.01, load: [0,-1e6,0]}", "pushes the shaft through the balls.*the greatest in this direction"),
        ("table=[[0,0,0,0,0,0],[1e-3,0,-1e6,0,0,0]]", "pushes the shaft through the balls.*the greatest in this"),
    ],
)
def test_loads_that_are_none_or_that_nothing_carries_are_refused_in_one_sentence(change, words, capsys):
    assert main(["simulate", "shaft_two_6203", "--set", f"shaft.{change}"]) == BAD_INPUT
    told = capsys.readouterr().err.strip().splitlines()  # on a busy machine also that it prepares
    assert [line.startswith("bearing_twin: ") for line in told if not line.startswith("preparing ")] == [True]
    with pytest.raises(SceneError, match=words):
        choose(load_scene("shaft_two_6203", [f"shaft.{change}"]))


def test_a_load_in_between_that_nothing_carries_ends_the_run_with_time_load_and_limit():
    motion = motion_of("shaft.table=[[0,0,0,0,0,0],[0.011,0,0,0,0,0],[0.0111,0,-1e9,0,0,0],[0.012,0,0,0,0,0]]")
    words = r"^at 0.0110\d* s a load of \(.*, -.*, 0\) N.* pushes the shaft through.*the greatest in this direction is"
    with pytest.raises(IntegrationError, match=words) as caught:
        motion.advance(np.arange(1, 30) * 1e-3, 0.029)
    assert (caught.value.reason, caught.value.body) == ("overload", "shaft")


def test_a_change_that_comes_too_late_is_said_once_on_standard_error(capsys):
    assert main(["simulate", "shaft_step_load", "--duration", "0.005", "--json"]) == DONE
    told = capsys.readouterr().err
    assert (
        told.count("shaft.change.time = 0.02 s is beyond the end of the run at 0.005 s: nothing of that happens") == 1
    )
