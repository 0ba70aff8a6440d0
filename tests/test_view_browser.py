"""Pages in a real browser: no error, no request, and what is clicked moves what is seen. `make test-environments`.

Needs playwright and a Chromium; where BEARING_TWIN_REQUIRE_BROWSER or CI is set they may not be missing. Screenshots of
every kind go to build/view/ to be looked at.
"""

import contextlib
import io
import time
from pathlib import Path

import numpy as np
import pytest
from browsers import browser_page
from PIL import Image
from test_view import HOSTILE, SHORT

from bearing_twin.log.run_log import write_log
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study
from bearing_twin.view.page import DRAWN, write_page
from bearing_twin.view.run_page import log_document, run_document
from bearing_twin.view.study_page import study_document

pytestmark = pytest.mark.environment

SCREENSHOTS = Path(__file__).resolve().parent.parent / "build" / "view"
DESKTOP, PHONE = (1280, 800), (390, 844)
NOISE = "GPU stall due to ReadPixels"  # what Chromium says of its own screenshots


@pytest.fixture(scope="module")
def browser():
    """One page for all tests, and what went wrong on it: errors, warnings, requests."""
    wrong = []
    with contextlib.ExitStack() as stack:
        page = stack.enter_context(browser_page(*DESKTOP))
        page.on("console", lambda message: NOISE in message.text or wrong.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda asked: asked.is_navigation_request() or wrong.append(asked.url[:100]))
        yield page, wrong


@pytest.fixture
def opened(browser, tmp_path):
    """A function that opens a document and gives the browser's page; nothing may have gone wrong by the end."""
    page, wrong = browser
    wrong.clear()

    def show(document, size=DESKTOP):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.goto(write_page(document, tmp_path / "page.html").as_uri())
        page.wait_for_selector("body[data-ready]", timeout=60_000)
        return page

    yield show
    assert wrong == []


def seen(page, part="#space"):
    """The pixels of a part of the page, as drawn after all that was asked for."""
    page.evaluate(DRAWN)
    return np.asarray(Image.open(io.BytesIO(page.locator(part).screenshot())).convert("RGB"), float)


def until(page, condition, patience=60.0):
    """Waits for a condition of the page, whose policy forbids playwright's own way of waiting."""
    end = time.monotonic() + patience
    while not page.evaluate(condition):
        page.evaluate(DRAWN)
        assert time.monotonic() < end, f"{condition} did not come true"


def differs(first, second):
    """Share of the pixels that differ."""
    return float((np.abs(first - second).max(axis=-1) > 12.0).mean())


def keep_screenshot(page, name):
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.evaluate(DRAWN)
    page.screenshot(path=SCREENSHOTS / f"{name}.png")


def go_to(page, share):
    """Moves the slider, as a finger does."""
    page.evaluate(
        "([share]) => { const slider = document.getElementById('time'); slider.value = 1000 * share;"
        " slider.dispatchEvent(new Event('input')); }",
        [share],
    )


@pytest.fixture(scope="module", params=SHORT)
def of_kind(request):
    source, *overrides = SHORT[request.param]
    scene = load_scene(source, overrides) if isinstance(source, str) else parse_scene(source, "a test")
    return request.param, run_document(simulate(scene)).document


def test_slider_and_play_move_the_picture_of_every_kind(of_kind, opened):
    kind, document = of_kind
    page = opened(document)
    part = "#panes" if kind == "toy" else "#space"
    go_to(page, 0.0)
    start = seen(page, part)
    assert len(np.unique(start.reshape(-1, 3), axis=0)) > 50  # something is drawn
    go_to(page, 0.4)
    later = seen(page, part)
    assert differs(start, later) > 2e-4
    keep_screenshot(page, kind)
    assert page.evaluate("bearingView.charts.every(({ plot }) => plot.scales.x.max > plot.scales.x.min)")
    page.click("#play")
    far = "bearingView.player.time > 0.6 * bearingView.store.last || !bearingView.player.playing"
    until(page, f"bearingView.player.images > 3 && ({far})")  # a few images alone may show nearly the same
    page.evaluate("bearingView.player.pause()")
    assert differs(later, seen(page, part)) > 2e-4
    assert float(page.evaluate("bearingView.player.time")) > 0.4 * float(page.evaluate("bearingView.store.last"))
    for tab in ("Figures", "Model", "Curves"):
        page.click(f"#tabs button:text-is('{tab}')")
    assert page.locator(".figures td").count() > 2


def test_curves_show_the_value_under_the_pointer_zoom_and_lead_the_time(opened):
    page = opened(run_document(simulate(load_scene("two_spheres"))).document)
    curve = page.locator(".chart .u-over").first
    box = curve.bounding_box()
    middle = box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(*middle)
    until(page, "document.querySelector('.readout').textContent.includes('kN')")
    page.mouse.click(*middle)
    now = float(page.evaluate("bearingView.player.time"))
    assert 0.3 < now / float(page.evaluate("bearingView.store.last")) < 0.5
    page.mouse.move(box["x"] + 0.2 * box["width"], middle[1])
    page.mouse.down()
    page.mouse.move(*middle, steps=5)
    page.mouse.up()
    spans = "bearingView.charts.map((one) => one.plot.scales.x.max - one.plot.scales.x.min)"
    until(page, f"{spans}.every((one) => one < 30)")  # of 78 microseconds, in all panels
    assert float(page.evaluate("bearingView.player.time")) == now  # dragging is no click
    page.mouse.dblclick(*middle)
    until(page, f"{spans}.every((one) => one > 70)")


def test_outputs_that_come_later_are_shown(opened):
    """What a page of a running node does: it takes outputs as they come."""
    document = run_document(simulate(load_scene("bearing_6203_loose", ["run.duration=0.02"]))).document
    page = opened(document)
    count = page.evaluate(
        "() => { const store = bearingView.store, values = {}, last = store.count - 1;"
        " for (const [name, one] of store.series)"
        "   values[name] = one.values.slice(last * one.width, store.count * one.width);"
        " for (let k = 1; k <= 30; k++) bearingView.append({ time: [store.last + 0.001], values });"
        " return [store.count, bearingView.charts[0].plot.data[0].length, bearingView.player.time]; }"
    )
    assert count[:2] == [51, 51]
    assert np.isclose(count[2], 0.05)
    page.evaluate(
        "() => { const store = bearingView.store;"
        " const rows = (one) => new Float32Array(5000 * one.width).fill(0.5);"
        " const values = Object.fromEntries([...store.series].map(([name, one]) => [name, rows(one)]));"
        " bearingView.append({ time: Array.from({ length: 5000 }, (_, k) => 1 + 0.001 * k), values }); }"
    )
    assert page.evaluate("bearingView.store.count") <= 5000


def test_keys_move_the_time_but_not_those_of_the_browser_or_of_a_control(opened):
    page = opened(run_document(simulate(load_scene("bearing_6203_loose", ["run.duration=0.02"]))).document)
    now = "bearingView.player.time"
    page.keyboard.press("ArrowRight")
    moved = page.evaluate(now)
    assert moved > 0.0
    page.keyboard.press("Control+ArrowRight")  # Alt with an arrow leads back to the page before
    page.evaluate("document.querySelector('#details select').focus()")
    page.keyboard.press("ArrowRight")
    assert page.evaluate(now) == moved
    page.evaluate("document.getElementById('time').focus()")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate(now) == 0.0


def test_forces_that_no_output_has_are_said_to_be_none(opened):
    page = opened(run_document(simulate(load_scene("ellipsoid_tumbling", ["run.duration=0.05"]))).document)
    assert page.locator("#legend").inner_text().count("none at any output") == 2


def test_the_time_of_a_single_output_is_in_seconds(opened):
    page = opened(run_document(simulate(load_scene("bearing_6203", ["run.duration=1e-9"]))).document)
    assert page.evaluate("[bearingView.store.count, bearingView.timeUnit]") == [1, "s"]


WIDER = "document.documentElement.scrollWidth > innerWidth"


@pytest.mark.parametrize("size", [DESKTOP, PHONE])
def test_a_long_name_does_not_widen_the_page(opened, size):
    scene = load_scene({"kind": "two_spheres", "name": "x" * 100, "description": "y" * 400})
    assert not opened(run_document(simulate(scene)).document, size).evaluate(WIDER)


def test_a_study_is_drawn(opened):
    overrides = ["samples=600", "sensitivity=64", "workers=1"]
    document = study_document(run_study(load_study("discs_small_10", overrides)))
    assert not opened(document, PHONE).evaluate(WIDER)  # wide parts scroll by themselves
    page = opened(document)
    keep_screenshot(page, "study")
    assert page.evaluate("document.querySelector('img').naturalWidth") > 800
    page.click("#tabs button:text-is('Statistics')")
    assert "95 % interval" in page.locator("#panes").inner_text()


def test_a_hostile_log_is_shown_as_text(opened, tmp_path):
    scene = parse_scene({"kind": "two_spheres", "name": "quiet", "description": HOSTILE}, "a test")
    write_log(simulate(scene), tmp_path / "run.mcap")
    page = opened(log_document(tmp_path / "run.mcap"))
    assert page.locator("#subtitle").inner_text() == HOSTILE
    assert page.locator("img").count() == 0


NO_WEBGL = """
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest);
};
"""


def test_a_browser_without_webgl_shows_all_but_the_picture_and_says_so(browser, tmp_path, of_kind):
    name, document = of_kind
    page = browser[0].context.browser.new_page()
    try:
        page.add_init_script(NO_WEBGL)
        page.goto(write_page(document, tmp_path / "page.html").as_uri())
        page.wait_for_selector("body[data-ready]", timeout=60_000)
        assert page.locator(".pane.curves canvas").count() > 0
        drawn = document["view"]["solids"] or document["view"]["marks"]
        assert ("no WebGL 2" in page.locator("#space").text_content()) == bool(drawn), name
        page.locator("#player button").first.click()
        assert page.locator("#space canvas").count() == 0
    finally:
        page.close()
