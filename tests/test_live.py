"""A run while it goes on: what of it reaches a page, and what a hostile publisher cannot do to it."""

import json
import re

import numpy as np
import pytest
from foreign_writers import message_class, serialise
from runs import a_choice, made_up_block, made_up_scene
from test_view import unpack

from bearing_twin.base.errors import BearingTwinError, LogError, SceneError
from bearing_twin.log import cdr
from bearing_twin.log.stream import samples_message, scene_text
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.view.live_page import PERIOD, ROWS, LiveRun, RunRestarted, live_page
from bearing_twin.view.page import STEPS

SCENE = made_up_scene()
BLOCK = made_up_block(SCENE, 200)


def said(scene=SCENE):
    return scene_text(scene, a_choice())


def samples(low, high, block=BLOCK):
    part = block.part(low, high)
    return samples_message(part.channels, part.first_sequence, part.time_ns, part.matrix())


def decoded(run, event):
    """(times, series) of an event."""
    described = [{"name": array.name, "shape": array.shape} for array in run.view.series]
    return unpack({"series": described, "data": event})


def test_an_event_has_few_outputs_the_last_among_them_and_their_own_numbers():
    run = LiveRun(said())
    event = run.frames(samples(0, 50), 0.0)
    times, series = decoded(run, event)
    assert len(times) == ROWS
    assert times[-1] == 1e-9 * BLOCK.time_ns[49]
    assert (np.diff(times) > 0.0).all()
    expected = BLOCK.sample_rows(range(9, 50, 10))
    shown = run.view.rows(expected)
    for row in run.view.series:
        values = shown[row.name].reshape(5, -1)
        assert (np.abs(series[row.name] - values) <= np.ptp(values, axis=0) / STEPS + 1e-12 * np.abs(values)).all()


def test_events_come_no_faster_than_their_period():
    run = LiveRun(said())
    events = [run.frames(samples(k, k + 1), 0.001 * k) for k in range(200)]
    sent = [k for k, event in enumerate(events) if event]
    assert len(sent) <= 0.2 / PERIOD + 1
    assert np.diff(sent).min() >= 1000 * PERIOD - 1e-6
    assert run.frames(samples(0, 3, made_up_block(SCENE, 3, first=500)), 1.0)


def test_a_run_that_begins_again_is_told_and_goes_on():
    run = LiveRun(said())
    run.frames(samples(0, 100), 0.0)
    with pytest.raises(RunRestarted):
        run.frames(samples(0, 50), 1.0)
    assert run.frames(samples(0, 50), 2.0)
    changed = made_up_scene(balls=5)
    with pytest.raises(RunRestarted):
        run.frames(samples(0, 10, made_up_block(changed, 10, first=900)), 3.0)


def test_a_text_that_is_no_scene_is_refused_in_one_sentence():
    nonsense = json.dumps({"scene": "kind: bearing\nnonsense: 1"})
    for text in ("", "[]", "7", '{"scene": 7}', "[" * 100_000, nonsense):
        with pytest.raises(BearingTwinError) as caught:
            LiveRun(text)
        assert "\n" not in str(caught.value)
    with pytest.raises(SceneError, match="characters"):
        LiveRun(json.dumps({"scene": "x" * (1 << 21)}))


def test_bytes_that_are_no_samples_or_contradict_themselves_are_refused():
    block = cdr.deserialise(cdr.SAMPLE_BLOCK, samples(0, 10))
    fields = {name: getattr(block, name) for name in block.__dataclass_fields__ if name != "__msgtype__"}
    fields["channel_width"] = fields["channel_width"] + np.uint32(1)
    contradicts = serialise(cdr.SAMPLE_BLOCK, message_class(cdr.SAMPLE_BLOCK)(**fields))
    for data in (b"", b"\x00\x01\x00\x00", samples(0, 10)[:-80], b"\xff" * 400, contradicts):
        with pytest.raises(LogError):
            LiveRun(said()).frames(data, 0.0)


def test_the_page_shows_texts_as_text():
    run = LiveRun(said())
    run.frames(samples(0, 10), 0.0)
    page = live_page(run, "/bearing/</script><script>alert(1)</script>").decode()
    assert "<script>alert(1)" not in page
    assert "@@" not in page
    assert "default-src 'none'" in page
    assert "http://" not in page.replace("http://www.w3.org/", "")


def test_the_controls_of_a_shaft_begin_with_its_speed_and_the_load_that_a_command_replaces():
    """Constant loads of the scene, here a push of 60 N along the axis, stay whatever is commanded."""
    scene = load_scene("shaft_step_load")
    run = LiveRun(scene_text(scene, a_choice()))
    first = Simulation(scene).advance(1)
    run.frames(samples_message(scene.channels, 0, first.time_ns, first.matrix()), 0.0)
    [live] = re.findall(r'"live": ?(\{[^}]*\})', live_page(run, "/node").decode())
    assert json.loads(live) == {
        "commands": ["command/speed", "command/speed_stamped", "command/load"],
        "speed": 60.0,
        "load": pytest.approx([0.0, -100.0, 0.0]),
    }
