"""One HTML file with libraries, licences, the code and style of the page and a document in it; films of the page.

The policy of the page forbids every request to a network. Texts of a document are shown as text, never as markup. Films
need the extra `view` (playwright, and imageio-ffmpeg for MP4) and Chromium, which draws the page image after image.

Outputs are thinned on their way to a page and packed as text: whole numbers of two bytes stand between the least and
the greatest value of a column, as differences from one output to the next, low bytes apart from high ones, so that what
moves evenly takes little room. `data.js` reads this back.
"""

import base64
import contextlib
import io
import math
import os
import shutil
import subprocess
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.errors import BearingTwinError, wanted
from bearing_twin.base.paths import write_whole, written_whole
from bearing_twin.base.report import json_text
from bearing_twin.base.sample import Block, Channel, Sample, Thinned
from bearing_twin.base.units import PREFIXES, UNITS
from bearing_twin.kinds.views import View

SCRIPTS = (
    *("libraries/three.min.js", "libraries/uPlot.iife.min.js", "elements.js", "data.js", "stage.js"),
    *("charts.js", "tables.js", "player.js", "page.js"),
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
    """Writes the page; returns the path. Raises BearingTwinError where there is no place for it."""
    return write_whole(path, html(document).encode())


WIDTH, HEIGHT = 832, 624  # films want multiples of 16
SECONDS, RATE = 6.0, 12.5  # of a film at most, and its images a second
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")
SOFTWARE = ("--enable-unsafe-swiftshader",)  # where there is no graphics processor
READY = 60_000  # ms for a page to draw itself

DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))"
_GO_TO = "([time]) => { bearingView.player.seek(time); }"
_SPAN = "() => [bearingView.store.first, bearingView.store.last, bearingView.player.speed]"


@contextlib.contextmanager
def browser_page(width: int = WIDTH, height: int = HEIGHT, dark: bool = False) -> Iterator:
    """A page of playwright in a Chromium without a window; raises BearingTwinError where one is missing."""
    playwright_api = wanted("playwright.sync_api", "view")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    with playwright_api.sync_playwright() as playwright:
        arguments = [*SOFTWARE, *_sandbox()]
        try:
            browser = playwright.chromium.launch(executable_path=found, args=arguments)
        except playwright_api.Error as error:
            raise BearingTwinError(
                "films need a Chromium on this machine; install one (Debian: apt install chromium; else: playwright "
                "install chromium)"
            ) from error
        try:
            scheme = "dark" if dark else "light"
            yield browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        finally:
            browser.close()


def _sandbox() -> tuple[str, ...]:
    """Chromium refuses its sandbox to the superuser, as whom programs run in containers; the page is our own file."""
    return ("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()


def write_films(
    page_path: Path, paths: list[Path], progress: Callable[[float], None] = lambda share: None
) -> list[Path]:
    """Films of the page at `page_path`, one for each of `paths` (.gif or .mp4); returns them.

    A film shows at most SECONDS of looking at the page's own pace. Raises BearingTwinError for a page without motion
    and where something it needs is missing.
    """
    if any(path.suffix.lower() == ".mp4" for path in paths):
        wanted("imageio_ffmpeg", "view")
    images = []
    with browser_page() as page:
        page.goto(Path(page_path).resolve().as_uri())
        page.wait_for_selector("body[data-ready]", timeout=READY)
        if not page.evaluate("() => Boolean(bearingView.stage && bearingView.store.count > 1)"):
            raise BearingTwinError("nothing moves on this page, so there is no film of it; leave out --gif and --mp4")
        page.evaluate("() => { document.body.classList.add('film'); bearingView.filmed(); }")
        first, last, pace = page.evaluate(_SPAN)
        # a little more than fits is shown a little faster, so that a film of an impact has its end
        shown = last - first if last - first < 2.0 * SECONDS * pace else SECONDS * pace
        count = max(2, math.ceil(min(SECONDS, shown / pace) * RATE))
        for number in range(count):
            page.evaluate(_GO_TO, [first + shown * number / (count - 1)])
            page.evaluate(DRAWN)
            images.append(page.screenshot(type="png"))
            progress((number + 1) / count)
    for path in paths:
        with written_whole(path) as draft:
            WRITERS[path.suffix.lower()](images, draft)
    return paths


def _write_gif(images: list[bytes], path: Path) -> None:
    """Images in one palette each, at the film's rate, for ever."""
    from PIL import Image

    first, *others = (
        Image.open(io.BytesIO(one)).convert("RGB").quantize(256, dither=Image.Dither.NONE) for one in images
    )
    first.save(path, save_all=True, append_images=others, duration=round(1000 / RATE), loop=0, optimize=True)


def _write_mp4(images: list[bytes], path: Path) -> None:
    """H.264 by the ffmpeg that comes with imageio-ffmpeg; raises OSError with its last words."""
    words = [wanted("imageio_ffmpeg", "view").get_ffmpeg_exe(), "-y", "-v", "error"]
    words += ["-f", "image2pipe", "-c:v", "png", "-framerate", str(RATE), "-i", "-"]
    words += ["-c:v", "libx264", "-crf", "10", "-pix_fmt", "yuv420p", str(path)]
    made = subprocess.run(words, input=b"".join(images), capture_output=True)
    if made.returncode:
        last = made.stderr.decode(errors="replace").partition("\n")[0].rpartition("] ")[2]
        raise OSError(last or f"ffmpeg ended with {made.returncode}")


WRITERS = {".gif": _write_gif, ".mp4": _write_mp4}


GREATEST_NUMBERS = 2_600_000  # of all series together: 5.2 MB as whole numbers of two bytes, 7 MB as text
LEAST_FRAMES = 100


class Frames(Thinned):
    """Outputs on the page of a run: every `stride`-th, as many as fit; `values` are the series of its view."""

    def __init__(self, view: View):
        width = max(1, sum(channel.width for channel in view.series))
        super().__init__(max(LEAST_FRAMES, GREATEST_NUMBERS // width), self._series)
        self._view = view

    def _series(self, sample: Sample) -> dict[str, np.ndarray]:
        found, count = self._view.rows(sample), len(sample.time_ns)
        return {one.name: np.asarray(found[one.name], np.float32).reshape(count, -1) for one in self._view.series}

    def note(self) -> str:
        """A note on outputs that are not on the page; empty where it holds all."""
        if self.stride == 1:
            return ""
        return (
            f"The run has {self.outputs} outputs, too many for a browser: one in {self.stride} is shown. Figures are "
            "those of all of them; peaks between the outputs shown are missing from the curves."
        )


def passed_on(blocks: Iterable[Block], frames: Frames) -> Iterator[Block]:
    """The same blocks, each shown to `frames` on its way."""
    for block in blocks:
        frames.add(block)
        yield block


STEPS = 65534  # between the least and the greatest value; 65535 stands for no number
MISSING = 65535
SHARED_RANGE = 64  # columns: wider series have one range for all


def packed(time: np.ndarray, values: Mapping[str, np.ndarray], series: Sequence[Channel]) -> dict[str, Any]:
    """Times [s] (frames,) and series (frames, width) as plain data: what each is, and all numbers as one text."""
    blocks, described = [np.ascontiguousarray(time, "<f8").tobytes()], []
    for channel in series:
        array = np.asarray(values[channel.name], float)
        low, high = _range(array)
        blocks.append(_coded(array, low, high))
        described.append(described_series(channel) | {"low": low.tolist(), "high": high.tolist()})
    content = zlib.compress(b"".join(blocks), 6)
    return {"frames": len(time), "series": described, "data": base64.b64encode(content).decode("ascii")}


def described_series(channel: Channel) -> dict[str, Any]:
    """Description of a series for a page: name, unit, prefixes it may take, shape, meaning."""
    return {
        "name": channel.name,
        "unit": "" if channel.unit == "1" else UNITS[channel.unit].shown if channel.unit in UNITS else channel.unit,
        "prefixes": prefixes(channel.unit),
        "shape": list(channel.shape),
        "meaning": channel.meaning,
    }


def prefixes(unit: str) -> list[tuple[str, float]]:
    """(prefix, factor) that values in this unit may take, the greatest first."""
    known = UNITS.get(unit) or UNITS.get(unit.partition("/")[0])
    return [(prefix, scale) for prefix, scale in PREFIXES.items() if not prefix or (known and prefix in known.prefixes)]


def _range(array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest finite value of each column, or (1,) of all of them together."""
    finite = np.where(np.isfinite(array), array, np.nan)
    if array.shape[1] > SHARED_RANGE:
        finite = finite.reshape(-1, 1)
    empty = np.isnan(finite).all(axis=0)
    finite = np.where(empty, 0.0, finite)
    return np.nanmin(finite, axis=0), np.nanmax(finite, axis=0)


def _coded(array: np.ndarray, low: np.ndarray, high: np.ndarray) -> bytes:
    span = np.where(high > low, high - low, 1.0)
    scaled = np.rint((array - low) / span * STEPS)
    whole = np.where(np.isfinite(scaled), scaled, MISSING).astype(np.uint16).T
    steps = np.diff(whole, axis=1, prepend=np.zeros((len(whole), 1), np.uint16))
    return np.ascontiguousarray(steps.astype("<u2")).view(np.uint8).reshape(-1, 2).T.tobytes()
