"""A browser for tests of pages: a Chromium without a window, driven by playwright (requirements/browser.txt)."""

import contextlib
import os
import shutil
from collections.abc import Iterator

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")
SOFTWARE = "--enable-unsafe-swiftshader"  # where there is no graphics processor
REQUIRED = bool(os.environ.get("BEARING_TWIN_REQUIRE_BROWSER") or os.environ.get("CI"))
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))"


@contextlib.contextmanager
def browser_page(width: int, height: int) -> Iterator:
    """A page of playwright in Chromium; the test is skipped without both, unless they are required."""
    if not REQUIRED:
        pytest.importorskip("playwright.sync_api")
    from playwright.sync_api import Error, sync_playwright

    # Chromium refuses its sandbox to the superuser, as whom programs run in containers; the page is our own file.
    sandbox = ("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=found, args=[SOFTWARE, *sandbox])
        except Error as error:
            if REQUIRED:
                raise
            pytest.skip(f"no Chromium: {error}")
        try:
            yield browser.new_page(viewport={"width": width, "height": height})
        finally:
            browser.close()
