"""A contest of methods: what comes out, what fails or takes too long, and how runs are timed."""

import ctypes
import math

import numpy as np
import pytest

from bearing_twin.base.errors import CoreError, IntegrationError, SceneError
from bearing_twin.charts.contest import DONE, FAILED, REFUSED, STOPPED, Contest, Options, Problem
from bearing_twin.charts.paper3 import sign_change


def contest(judge, count=3):
    """A contest of one problem and so many settings."""
    entries = [("m", float(setting), math.nan) for setting in range(count)]
    return Contest(title="made up", problems={"p": Problem("a problem", lambda quick: entries, judge)})


def test_what_does_not_come_out_is_a_row_with_its_reason():
    def judge(method, setting, across):
        if setting == 0.0:
            raise SceneError("too long")
        if setting == 1.0:
            raise IntegrationError("at 1 s")
        return {"error": math.nan if setting == 2.0 else 0.1, "seconds": 1.0, "of my own": 2.0}

    rows = contest(judge, 4).measure(Options())
    assert [row.status for row in rows] == [REFUSED, FAILED, FAILED, DONE]
    assert [row.reason for row in rows] == ["too long", "at 1 s", "not finite", ""]
    assert [row.error for row in rows] == [math.inf, math.inf, math.inf, 0.1]
    assert rows[3].more == {"of my own": 2.0}
    ((panel,),) = contest(judge).sheet(rows).rows
    (lost,) = [part for part in panel.parts if part.name == "m, no result"]
    assert len(lost.x) == 3
    assert np.isfinite([lost.x, lost.y]).all(), "a cross each in the picture"


def test_an_installation_that_cannot_run_makes_no_chart():
    def judge(*entry):
        raise CoreError("of other sources")

    with pytest.raises(CoreError, match="of other sources"):
        contest(judge).measure(Options())


def test_a_run_that_goes_on_is_stopped_and_the_others_go_on():
    def judge(method, setting, across):
        while setting == 1.0:
            pass
        return {"error": 0.5}

    rows = contest(judge).measure(Options(limit=0.2))
    assert [row.status for row in rows] == [DONE, STOPPED, DONE]
    assert "0.2 CPU seconds" in rows[1].reason


def test_a_run_is_stopped_where_arguments_of_the_core_are_converted():
    """`ctypes` makes an ArgumentError of whatever is raised there."""

    class Slow:
        @classmethod
        def from_param(cls, value):
            while True:
                pass

    function = ctypes.CDLL(None).abs
    function.argtypes = (Slow,)
    rows = contest(lambda *entry: function(1)).measure(Options(limit=0.02))
    assert {row.status for row in rows} == {STOPPED}


def test_a_change_of_sign_is_read_as_it_is():
    """A change before the instant was read as one a negative time later, and every one as from more to less."""
    t = np.linspace(0.0, 1.0, 11)
    (falls,), (rises,) = sign_change(t, 0.3 - t, 0.4), sign_change(t, t - 0.3, 0.2)
    assert "100.00 ms earlier: a stiffer disc pushes more before, and less after" in falls
    assert "100.00 ms later: a stiffer disc pushes less before, and more after" in rises
    assert not sign_change(t, 1.0 + t, 0.2)
