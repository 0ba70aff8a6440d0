"""Films of a page: a browser on this machine draws it, image after image, and they become a GIF or an MP4.

Needs the extra `view` (playwright, and imageio-ffmpeg for MP4) and Chromium; both are imported late.
"""

import contextlib
import io
import math
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from bearing_twin.errors import BearingTwinError
from bearing_twin.extras import wanted

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
    writers = {path: WRITERS[path.suffix.lower()](path) for path in paths}
    with browser_page() as page:
        page.goto(Path(page_path).resolve().as_uri())
        page.wait_for_selector("body[data-ready]", timeout=READY)
        if not page.evaluate("() => Boolean(bearingView.stage && bearingView.store.count > 1)"):
            raise BearingTwinError("nothing moves on this page, so there is no film of it; leave out --gif and --mp4")
        page.evaluate("() => { document.body.classList.add('film'); bearingView.filmed(); }")
        first, last, pace = page.evaluate(_SPAN)
        # a little more than fits is shown a little faster, so that a film of an impact has its end
        shown = last - first if last - first < 2.0 * SECONDS * pace else SECONDS * pace
        images = max(2, math.ceil(min(SECONDS, shown / pace) * RATE))
        for number in range(images):
            page.evaluate(_GO_TO, [first + shown * number / (images - 1)])
            page.evaluate(DRAWN)
            content = page.screenshot(type="png")
            for writer in writers.values():
                writer.add(content)
            progress((number + 1) / images)
    for writer in writers.values():
        writer.finish()
    return paths


class _Gif:
    """Images in one palette each, at the film's rate, for ever."""

    def __init__(self, path: Path):
        self._path, self._images = path, []

    def add(self, content: bytes) -> None:
        from PIL import Image

        self._images.append(Image.open(io.BytesIO(content)).convert("RGB").quantize(256, dither=Image.Dither.NONE))

    def finish(self) -> None:
        first, *others = self._images
        try:
            first.save(
                self._path, save_all=True, append_images=others, duration=round(1000 / RATE), loop=0, optimize=True
            )
        except OSError as error:
            raise BearingTwinError(f"{self._path} cannot be written ({error.strerror}); give another path") from error


class _Mp4:
    """H.264 by the ffmpeg that comes with imageio-ffmpeg."""

    def __init__(self, path: Path):
        ffmpeg = wanted("imageio_ffmpeg", "view")
        self._path, self._stream = path, ffmpeg.write_frames(str(path), (WIDTH, HEIGHT), fps=RATE, quality=8)
        self._stream.send(None)

    def add(self, content: bytes) -> None:
        from PIL import Image

        self._stream.send(Image.open(io.BytesIO(content)).convert("RGB").tobytes())

    def finish(self) -> None:
        self._stream.close()
        if not self._path.is_file():
            raise BearingTwinError(f"{self._path} cannot be written; give another path")


WRITERS = {".gif": _Gif, ".mp4": _Mp4}
