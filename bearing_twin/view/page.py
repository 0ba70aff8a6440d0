"""One HTML file with libraries, licences, the code and style of the page and a document in it; films of the page.

The policy of the page forbids every request to a network. Texts of a document are shown as text, never as markup. Films
need the extra `view` (playwright, and imageio-ffmpeg for MP4) and Chromium, which draws the page image after image.
"""

import contextlib
import io
import math
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from bearing_twin import __version__
from bearing_twin.base.errors import BearingTwinError, wanted
from bearing_twin.base.paths import write_whole, written_whole
from bearing_twin.base.report import json_text

SCRIPTS = (
    *("libraries/three.min.js", "libraries/uPlot.iife.min.js", "elements.js", "data.js", "solids.js", "marks.js"),
    *("stage.js", "charts.js", "tables.js", "player.js", "page.js"),
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
