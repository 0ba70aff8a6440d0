"""The live page in a real browser, served without ROS: outputs arrive, controls command. `make test-environments`.

Needs playwright and a Chromium; where BEARING_TWIN_REQUIRE_BROWSER or CI is set they may not be missing.
"""

import math
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from browsers import browser_page
from PIL import Image

from bearing_twin.log.stream import samples_message, scene_text
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate
from bearing_twin.view import page as pages
from bearing_twin.view.live_page import PERIOD, LiveRun, live_page
from bearing_twin.view.page_server import Feed, PageServer
from bearing_twin.view.run_page import run_document

pytestmark = pytest.mark.environment

SCREENSHOTS = Path(__file__).resolve().parent.parent / "build" / "view"


@pytest.fixture
def served():
    """A live page of a simulation, its server, what was commanded, and a function that goes on by one event."""
    simulation, clock = Simulation(load_scene("bearing_6203_loose")), [0.0]
    obeyed, runs = [], []
    site = SimpleNamespace(feed=Feed(), page=lambda: live_page(runs[0], "/bearing/sim_node"))
    site.execute = lambda command: obeyed.append(command) or "done"

    def go_on(lost=0):
        for _ in range(lost):
            simulation.advance(50)
        block = simulation.advance(50)
        clock[0] += 2.0 * PERIOD
        data = samples_message(block.channels, block.first_sequence, block.time_ns, block.matrix())
        site.feed.send("frames", runs[0].frames(data, clock[0]))

    def begin():
        simulation.reset()
        runs[:] = [LiveRun(scene_text(simulation.scene, simulation.choice))]

    begin()
    go_on()
    server = PageServer(site, "localhost", 0)
    server.start()
    yield SimpleNamespace(server=server, feed=site.feed, obeyed=obeyed, go_on=go_on, begin=begin)
    server.close()


@pytest.fixture
def browser():
    with browser_page(1280, 800) as page:
        yield page


def until(done, patience=120.0):
    end = time.monotonic() + patience
    while not done():
        time.sleep(0.1)
        assert time.monotonic() < end


def test_outputs_arrive_and_controls_command(browser, served):
    wrong = []
    browser.on("pageerror", lambda error: wrong.append(str(error)))
    here = served.server.url.partition("#")[0]
    browser.on("request", lambda asked: asked.url.startswith(here) or wrong.append(asked.url))
    browser.goto(served.server.url)
    browser.wait_for_selector("#live", timeout=120_000)
    until(lambda: served.feed.viewers == 1)
    last = browser.evaluate("bearingView.store.last")

    def later():
        served.go_on()
        return browser.evaluate("bearingView.store.last") > last + 0.1

    until(later)
    for button, command in (
        ("pause", {"do": "pause", "on": True}),
        ("go on", {"do": "pause", "on": False}),
        ("reset", {"do": "reset"}),
    ):
        browser.click(f"#live button:text-is('{button}')")
        until(lambda command=command: command in served.obeyed)
    browser.click("#live button:text-is('set') >> nth=0")
    until(lambda: served.obeyed[-1]["do"] == "speed")
    assert served.obeyed[-1]["value"] == pytest.approx(
        load_scene("bearing_6203_loose").parameters.drive.speed, rel=1e-3
    )
    until(lambda: browser.inner_text("#live-answer") == "done")  # which would replace what comes next
    served.feed.send("refused", "command/speed refused: too fast")
    until(lambda: "too fast" in browser.inner_text("#live-answer.refused"))
    assert float(browser.locator("#live input[aria-label*='along y']").input_value()) != 0.0  # what acts, not nothing
    pace = browser.locator("#live input[aria-label^=pace]")
    served.feed.send("pace", "0.02")
    until(lambda: pace.input_value() == "0.02")
    pace.fill("0.5")
    served.feed.send("pace", "0.02")  # what somebody is about to set stays
    browser.wait_for_timeout(300)
    assert pace.input_value() == "0.5"
    browser.uncheck("#live-follow")
    browser.wait_for_timeout(500)
    count = browser.evaluate("bearingView.store.count")
    served.go_on()
    browser.wait_for_timeout(500)
    assert browser.evaluate("bearingView.store.count") == count
    assert wrong == []


BREAKS = """bearingView.charts.map(({ plot: { data } }) => {
    const times = data[0].map((one) => one / bearingView.timeFactor);
    const broken = times.filter((_, k) => data.slice(1).every((y) => y[k] === null));
    return { broken, times: times.filter((one) => !broken.includes(one)) };
})"""


def test_what_is_missing_breaks_the_curves_and_a_reset_begins_anew(browser, served):
    """Twenty messages are lost; a pause loses none. Then the page has heard of no reset when the run begins again."""
    wrong = []
    browser.on("pageerror", lambda error: wrong.append(str(error)))
    browser.goto(served.server.url)
    browser.wait_for_selector("#live", timeout=120_000)
    until(lambda: served.feed.viewers == 1)

    def went_on(until_time, lost=0):
        served.go_on(lost)
        for _ in range(200):
            served.go_on()
            browser.wait_for_timeout(100)
            curves = browser.evaluate(BREAKS)
            if curves[0]["times"][-1] > until_time:
                return curves
        raise AssertionError("the curves do not go on")

    unbroken = went_on(0.6)
    assert [curve["broken"] for curve in unbroken] == [[]] * len(unbroken)
    last = browser.evaluate("bearingView.store.last")
    browser.wait_for_timeout(1000)
    parted = went_on(last + 1.6, 20)
    for curve in parted:
        (gap,) = curve["broken"]
        before = max(time for time in curve["times"] if time < gap)
        after = min(time for time in curve["times"] if time > gap)
        assert after - before == pytest.approx(20 * 0.05, abs=0.02)
    assert browser.inner_text("#now").endswith(" s")  # the first output came after 0.05 s, as 50 ms
    assert browser.evaluate("bearingView.charts.every((one) => one.spec.xUnit === 's')")
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    browser.screenshot(path=SCREENSHOTS / "watch_gap.png")
    served.begin()
    went_on(0.3)
    until(lambda: browser.evaluate("bearingView.store.last") < last)
    again = went_on(0.3)
    assert all(curve["broken"] == [] and max(curve["times"]) < last for curve in again)
    assert browser.evaluate("bearingView.store.first") < 0.06
    assert wrong == []


def test_curves_show_so_many_turns_and_balls_their_numbers(browser, served):
    browser.goto(served.server.url)
    browser.wait_for_selector("#live", timeout=120_000)
    until(lambda: served.feed.viewers == 1)
    spans = "bearingView.charts.map(({ plot }) => (plot.scales.x.max - plot.scales.x.min) / bearingView.timeFactor)"
    speed = load_scene("bearing_6203_loose").parameters.drive.speed

    def shown(seconds):
        served.go_on()
        browser.wait_for_timeout(100)
        return browser.evaluate(spans) == pytest.approx([seconds] * len(browser.evaluate(spans)), rel=0.01)

    until(lambda: shown(10.0 * 2.0 * math.pi / speed))
    browser.locator("#live input[aria-label*=turns]").fill("3")
    until(lambda: shown(3.0 * 2.0 * math.pi / speed))
    assert browser.locator("#space .number").all_inner_texts() == [str(ball) for ball in range(8)]
    assert browser.locator("#space .axis:not(.number)").all_inner_texts() == ["x", "y", "z"]
    browser.screenshot(path=SCREENSHOTS / "watch_turns.png")


def test_without_the_token_it_is_only_to_look_at(browser, served):
    browser.goto(served.server.url.partition("#")[0])
    browser.wait_for_selector("#live", timeout=120_000)
    assert browser.locator("#live button:enabled").count() == 0
    assert "commands need the whole address" in browser.inner_text("#live-answer")


def test_an_animation_of_a_page_moves(tmp_path, monkeypatch):
    with browser_page(400, 300):
        pass  # skips where there is no browser
    monkeypatch.setattr(pages, "SECONDS", 1.0)
    page = pages.write_page(run_document(simulate(load_scene("two_spheres"))).document, tmp_path / "run.html")
    with Image.open(pages.write_gif(page, tmp_path / "run.gif")) as film:
        assert film.n_frames > 10
        first = np.asarray(film.convert("RGB"), float)
        film.seek(film.n_frames - 1)
        last = np.asarray(film.convert("RGB"), float)
    assert (np.abs(last - first).max(axis=-1) > 12.0).mean() > 2e-4
