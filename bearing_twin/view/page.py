"""One HTML file with libraries, licences, the code and style of the page and a document in it; its animation as a GIF.

The policy of the page forbids every request to a network. Texts of a document are shown as text, never as markup. A GIF
needs the extra `view` (playwright) and Chromium, which draws image after image.

Outputs are thinned on their way to a page and packed as text, compressed and in base64, which `data.js` reads back: how
many, their times [s], then each series with the least and the greatest value of its columns, all as float64, and its
numbers. These are whole numbers of two bytes between the least and the greatest value, column after column, as
differences from one output to the next, low bytes apart from high ones, so that what moves evenly takes little room.
"""

import base64
import contextlib
import io
import math
import os
import shutil
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.errors import BearingTwinError, import_optional
from bearing_twin.base.paths import write_atomic
from bearing_twin.base.report import json_text
from bearing_twin.base.sample import Block, Channel, Sample, ThinnedOutputs
from bearing_twin.base.units import PREFIXES, UNITS
from bearing_twin.kinds.views import View

SCRIPTS = (
    *("libraries/three.min.js", "libraries/uPlot.iife.min.js"),
    *("tables.js", "data.js", "stage.js", "charts.js", "page.js"),
)
"""In the order in which they are read; the page's own share one scope with the libraries' global names."""

STYLES = ("libraries/uPlot.min.css", "page.css")
LICENCES = "libraries/LICENSES.txt"
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


@lru_cache
def file_text(name: str) -> str:
    """The text of a file of this room."""
    return files("bearing_twin.view").joinpath(name).read_text(encoding="utf-8")


def html(document: Mapping[str, Any]) -> str:
    """The page of a document of `run_page` or `study_page`, as text."""
    parts = {
        "title": escape(str(document["title"])),
        "policy": POLICY,
        "licences": file_text(LICENCES).replace("--", "- -"),
        "styles": "\n".join(map(file_text, STYLES)),
        "scripts": "\n".join(f"<script>\n{_safe(file_text(name))}\n</script>" for name in SCRIPTS),
        # no text in it can end the element it stands in
        "document": json_text({**document, "version": __version__}).replace("<", "\\u003c"),
    }
    page = file_text("page.html")
    for name, part in parts.items():
        page = page.replace(f"@@{name}@@", part, 1)
    return page


def _safe(script: str) -> str:
    return script.replace("</script", "<\\/script")


def write_page(document: Mapping[str, Any], path) -> Path:
    """Write the page; returns the path. Raises BearingTwinError where it cannot be written."""
    return write_atomic(path, html(document).encode())


BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")
SOFTWARE = "--enable-unsafe-swiftshader"  # where there is no graphics processor
READY = 60_000  # ms for a page to draw itself
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))"


@contextlib.contextmanager
def browser_page(width: int, height: int) -> Iterator:
    """A page of playwright in a Chromium without a window; raises BearingTwinError where one is missing."""
    playwright_api = import_optional("playwright.sync_api", "view")
    executable = next(filter(None, map(shutil.which, BROWSERS)), None)
    # Chromium refuses its sandbox to the superuser, as whom programs run in containers; the page is our own file.
    sandbox = ("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()
    with playwright_api.sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=executable, args=[SOFTWARE, *sandbox])
        except playwright_api.Error as error:
            raise BearingTwinError(
                "an animation needs a Chromium on this machine; install one (Debian: apt install chromium; else: "
                "playwright install chromium)"
            ) from error
        try:
            yield browser.new_page(viewport={"width": width, "height": height})
        finally:
            browser.close()


SECONDS, RATE = 6.0, 12.5  # of a GIF at most, and its images a second


def write_gif(page_path: Path, path: Path, progress: Callable[[float], None] = lambda share: None) -> Path:
    """Writes at most SECONDS of the page's animation at its own pace; returns the path.

    Raises BearingTwinError for a page without motion and where something it needs is missing.
    """
    from PIL import Image

    images = []
    with browser_page(1440, 900) as page:
        page.goto(Path(page_path).resolve().as_uri())
        page.wait_for_selector("body[data-ready]", timeout=READY)
        if not page.evaluate("() => Boolean(bearingView.stage && bearingView.store.count > 1)"):
            raise BearingTwinError("nothing moves on this page; leave out --gif")
        page.evaluate("() => document.getElementById('home').remove()")
        first, last, pace = page.evaluate("[bearingView.store.first, bearingView.store.last, bearingView.player.speed]")
        # a little more than fits is shown a little faster, so that the animation of an impact has its end
        span = last - first if last - first < 2.0 * SECONDS * pace else SECONDS * pace
        count = max(2, math.ceil(min(SECONDS, span / pace) * RATE))
        for number in range(count):
            page.evaluate("([time]) => bearingView.seek(time)", [first + span * number / (count - 1)])
            page.evaluate(DRAWN)
            image = Image.open(io.BytesIO(page.locator("#stage").screenshot())).convert("RGB")
            images.append(image.quantize(256, dither=Image.Dither.NONE))
            progress((number + 1) / count)
    drawn = io.BytesIO()
    options = {"save_all": True, "append_images": images[1:], "duration": round(1000 / RATE), "loop": 0}
    images[0].save(drawn, format="gif", optimize=True, **options)
    return write_atomic(path, drawn.getvalue())


GREATEST_NUMBERS = 2_600_000  # of all series together: 5.2 MB as whole numbers of two bytes, 7 MB as text
LEAST_FRAMES = 100


class Frames(ThinnedOutputs):
    """Outputs on the page of a run: every `stride`-th, as many as fit; `values` are the series of its view."""

    def __init__(self, view: View):
        width = max(1, sum(channel.width for channel in view.series))
        super().__init__(max(LEAST_FRAMES, GREATEST_NUMBERS // width), self._series)
        self._view = view

    def _series(self, sample: Sample) -> dict[str, np.ndarray]:
        rows, count = self._view.rows(sample), len(sample.time_ns)
        return {
            channel.name: np.asarray(rows[channel.name], np.float32).reshape(count, -1) for channel in self._view.series
        }

    def note(self) -> str:
        """A note on outputs that are not on the page; empty where it holds all."""
        if self.stride == 1:
            return ""
        return (
            f"The run has {self.outputs} outputs, too many for a browser: one in {self.stride} is shown. Figures are "
            "those of all of them; peaks between the outputs shown are missing from the curves."
        )


def collect_frames(blocks: Iterable[Block], frames: Frames) -> Iterator[Block]:
    """The blocks, each added to `frames`."""
    for block in blocks:
        frames.add(block)
        yield block


STEPS = 65534  # between the least and the greatest value; 65535 stands for no number
MISSING = 65535


def pack_series(time: np.ndarray, values: Mapping[str, np.ndarray], series: Sequence[Channel]) -> str:
    """Times [s] (frames,) and series (frames, ...) as one text."""
    parts = [np.array([len(time)], float), np.asarray(time, float)]
    for channel in series:
        array = np.asarray(values[channel.name], float).reshape(len(time), -1)
        finite = np.where(np.isfinite(array), array, np.nan)
        finite[:, np.isnan(finite).all(axis=0)] = 0.0
        low, high = np.nanmin(finite, axis=0), np.nanmax(finite, axis=0)
        parts += [low, high, _coded(array, low, high)]
    content = b"".join(part.astype(part.dtype.newbyteorder("<")).tobytes() for part in parts)
    return base64.b64encode(zlib.compress(content, 6)).decode("ascii")


def series_data(channel: Channel) -> dict[str, Any]:
    """Description of a series for a page: name, unit, prefixes it may take, shape."""
    return {"name": channel.name, "shape": list(channel.shape), **unit_data(channel.unit)}


def unit_data(unit: str) -> dict[str, Any]:
    """A unit as it is shown, and the prefixes (prefix, factor) that it may take, the greatest first."""
    row = UNITS.get(unit) or UNITS.get(unit.partition("/")[0])
    prefixes = [(prefix, scale) for prefix, scale in PREFIXES.items() if not prefix or (row and prefix in row.prefixes)]
    return {"unit": "" if unit == "1" else UNITS[unit].shown if unit in UNITS else unit, "prefixes": prefixes}


def _coded(array: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    span = np.where(high > low, high - low, 1.0)
    scaled = np.rint((array - low) / span * STEPS)
    codes = np.where(np.isfinite(scaled), scaled, MISSING).astype(np.uint16).T
    steps = np.diff(codes, axis=1, prepend=np.zeros((len(codes), 1), np.uint16))
    return np.ascontiguousarray(steps.astype("<u2")).view(np.uint8).reshape(-1, 2).T
