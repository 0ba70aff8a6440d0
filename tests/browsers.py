"""A browser for tests of pages: without one they are skipped, unless it is required."""

import contextlib
import os

import pytest

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.view import page as pages

REQUIRED = bool(os.environ.get("BEARING_TWIN_REQUIRE_BROWSER") or os.environ.get("CI"))


@contextlib.contextmanager
def browser_page(width: int, height: int):
    """The browser's page."""
    with contextlib.ExitStack() as stack:
        try:
            page = stack.enter_context(pages.browser_page(width, height))
        except BearingTwinError as error:
            if REQUIRED:
                raise
            pytest.skip(str(error))
        yield page
