"""Outputs of a run for its page: thinned as they come, and packed."""

import math

import numpy as np
import pytest
from test_view import unpack

from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Block, Channel
from bearing_twin.kinds.views import View
from bearing_twin.view import page
from bearing_twin.view.page import STEPS, Frames, pack_series


def test_numbers_come_back_within_a_step():
    random = np.random.default_rng(1)
    series = (Channel("one", "m", (), ""), Channel("some", "N", (5,), ""), Channel("many", "Pa", (40, 2), ""))
    values = {channel.name: random.normal(size=(300, channel.width)).cumsum(axis=0) for channel in series}
    values["some"][:, 3] = 7.25  # does not move
    values["some"][17, 1] = np.nan
    values["some"][:, 4] = np.nan
    described = [{"name": channel.name, "shape": channel.shape} for channel in series]
    text = pack_series(np.arange(300) * 1e-3, values, series)
    time, restored = unpack({"frames": 300, "series": described, "data": text})
    assert (time == np.arange(300) * 1e-3).all()
    for channel in series:
        array = values[channel.name]
        span = np.nanmax(array) - np.nanmin(array) if channel.width > 64 else np.ptp(np.nan_to_num(array), axis=0)
        assert np.array_equal(np.isnan(restored[channel.name]), np.isnan(array))
        errors = np.abs(np.nan_to_num(restored[channel.name] - array))
        assert (errors <= 0.51 * span / STEPS + 1e-12).all()
    assert (restored["some"][:, 3] == 7.25).all()


@pytest.mark.parametrize("outputs", [1, 99, 100, 101, 1000, 4321])
@pytest.mark.parametrize("length", [1, 37, 400])
def test_a_run_of_any_length_fits_and_keeps_its_start(monkeypatch, outputs, length):
    """However the stream is cut, every 2^n-th output is kept, from the first on."""
    monkeypatch.setattr(page, "GREATEST_NUMBERS", 200)
    channel = Channel("number", "1", (2,), "")
    view = View((channel,), lambda sample: {"number": sample["number"]}, ())
    frames = Frames(view)
    for first in range(0, outputs, length):
        count = min(length, outputs - first)
        numbers = np.stack([np.arange(first, first + count, dtype=float)] * 2, axis=1)
        frames.add(Block((channel,), first, 1000 * np.arange(first, first + count), numbers))
    rows = np.arange(0, outputs, frames.stride)
    assert frames.stride == 2 ** max(0, math.ceil(math.log2(outputs / 100)))
    assert frames.values["number"][:, 0].tolist() == rows.tolist()
    assert np.allclose(frames.time, 1e-6 * rows)
    assert (f"{outputs} outputs" in frames.note()) == (frames.stride > 1)


def test_a_run_without_an_output_has_no_page():
    with pytest.raises(LogError, match="no sample"):
        Frames(View((), lambda sample: {}, ())).time  # noqa: B018
