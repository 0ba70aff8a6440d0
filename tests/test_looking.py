"""Where a companion looks: jumps of a ring that is shifted, calm parts now and then, and what was spent before."""

from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.kinds.bearing.companion import looking
from bearing_twin.kinds.bearing.companion.looking import EVENTFUL, LOOKING, Looking
from bearing_twin.kinds.bearing.companion.pointers import POINTERS
from bearing_twin.kinds.bearing.companion.windows import ALL, Window
from bearing_twin.run.scene import load_scene

OUTPUTS, BALLS = 30, 3


def watching_over(*overrides):
    found = Looking()
    found.parameters = load_scene("bearing_6203", overrides).parameters
    found.reset()
    return found


def part_of(elapsed=0.0, coupled=False, all_bear=True, load=20.0, taken=1000.0):
    out = np.full((OUTPUTS, BALLS, 2), load)
    return SimpleNamespace(
        elapsed=elapsed, load=out, taken=taken, all_bear=all_bear, times=1e-3 * np.arange(1, OUTPUTS + 1),
        pointer=np.ones((BALLS, OUTPUTS, 9)), partners=SimpleNamespace(active=coupled),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("words", "jumps"),
    [
        (("drive.change.time=0.02", "drive.change.offset=[0,-1e-6,0]"), True),
        (("drive.change.time=0.02", "drive.change.speed=10"), False),
        ((), False),
    ],
)
def test_a_part_jumps_where_a_ring_is_shifted_and_then_alone(words, jumps):
    watching = watching_over(*words)
    assert watching._jumped(part_of(elapsed=0.02)) is jumps
    assert not watching._jumped(part_of(elapsed=0.021))


@pytest.mark.parametrize(("elapsed", "begin", "ball", "kept"), [
    (0.02, -1, ALL, False), (0.02, 3, ALL, True), (0.02, -1, 1, True), (0.03, -1, ALL, True),
])  # fmt: skip
def test_what_points_to_a_jump_of_all_balls_is_not_kept(elapsed, begin, ball, kept):
    """So that balls which roll on, which it outdoes a thousand times, are looked at as well."""
    watching = watching_over("drive.change.time=0.02", "drive.change.offset=[0,-1e-6,0]")
    grids = np.full((POINTERS, BALLS, OUTPUTS), 7.0)
    window = Window(ball, begin, 5)
    took = watching._see(part_of(elapsed=elapsed), window, max(ball, 0), grids, np.ones((BALLS, OUTPUTS)))
    assert took > 0.0
    assert (watching.best == 7.0).any() is np.bool_(kept)


@pytest.mark.parametrize(
    ("more", "share"),
    [
        ({}, LOOKING),
        ({"all_bear": False}, EVENTFUL),
        ({"all_bear": False, "coupled": True}, LOOKING),
        ({"all_bear": False, "load": 0.0}, LOOKING),
    ],
)
def test_more_is_looked_at_where_balls_roll_in_and_out_of_the_load(more, share):
    assert watching_over()._much(part_of(**more)) == share * 1000.0


def test_a_calm_part_is_looked_at_more_and_more_seldom(monkeypatch):
    """At its last outputs, in parts 2, 4, 8 and so on of a run, whatever points to nothing there."""
    nothing, steps = np.zeros((POINTERS, BALLS, OUTPUTS)), np.full((BALLS, OUTPUTS), 4.0)
    steps[1] = 2.0
    monkeypatch.setattr(looking, "pointers", lambda *_: (nothing, steps))
    monkeypatch.setattr(looking, "meetings", lambda part: np.zeros((BALLS, OUTPUTS), bool))
    monkeypatch.setattr(looking, "copied_from", lambda *_: None)
    monkeypatch.setattr(looking, "as_met", lambda window, met: window)
    watching, looked = watching_over(), {}
    for number in range(1, 18):
        found = watching.windows(part_of())
        if found:
            looked[number] = found
    assert list(looked) == [1, 2, 4, 8, 16]
    for (window,) in looked.values():
        assert window.ball == 1
        assert window.begin + 1 + window.length == OUTPUTS


@pytest.mark.parametrize(
    ("share", "taken", "length"),
    [(2.0, 1000.0, 5), (0.5, 1000.0, None), (2.0, 250.0, None), (2.0, 1e6, "all")],
)
def test_a_ball_that_slides_at_first_is_looked_at_for_a_share_of_the_steps(share, taken, length):
    """Where friction is a hundredth of mu N or more, and the window has ten steps; not one that slides later on."""
    watching = watching_over()
    sliding, steps = np.zeros((BALLS, OUTPUTS)), np.full((BALLS, OUTPUTS), 4.0)
    sliding[2, 0] = share * looking.SLIDES * watching.parameters.contact.friction_coefficient
    sliding[1, 6] = 0.5 * sliding[2, 0]
    found = watching._sliding_at_first(part_of(taken=taken), sliding, steps, np.zeros((OUTPUTS, BALLS), bool))
    expected = {None: [], "all": [Window(2, -1, OUTPUTS)]}.get(length, [Window(2, -1, length)])
    assert found == expected


@pytest.mark.parametrize(("each", "cut"), [(20.0, False), (40.0, True)])
def test_a_window_is_cut_to_its_end_where_a_part_done_again_has_many_more_steps_in_it(each, cut, monkeypatch):
    """As where a ball rings that a rough setting damped at once; windows of all balls, or of one that slides, stay."""
    grids = np.full((POINTERS, BALLS, OUTPUTS), 7.0)
    monkeypatch.setattr(looking, "pointers", lambda *_: (grids, np.full((BALLS, OUTPUTS), each)))
    monkeypatch.setattr(looking, "meetings", lambda part: np.zeros((OUTPUTS, BALLS), bool))
    watching, windows = watching_over(), [Window(1, 2, 10), Window(ALL, 2, 10), Window(0, -1, 10)]
    again = watching.windows_again(part_of(), windows)
    assert again[0] == (Window(1, 10, 2) if cut else windows[0])
    assert again[1:] == windows[1:]
    assert (watching.best == 7.0).all()
