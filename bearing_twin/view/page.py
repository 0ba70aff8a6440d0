"""One HTML file with everything in it: libraries with their licences, the page's own code and style, and a document.

The page's policy forbids every request to a network. What a document says is shown as text, never as markup.
"""

from collections.abc import Mapping
from functools import lru_cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from bearing_twin import __version__
from bearing_twin.base.paths import write_whole
from bearing_twin.base.report import json_text

SCRIPTS = (
    *("libraries/three.min.js", "libraries/uPlot.iife.min.js"),
    *(
        "elements.js",
        "data.js",
        "colours.js",
        "shapes.js",
        "solids.js",
        "marks.js",
        "stage.js",
        "charts.js",
        "tables.js",
    ),
    *("details.js", "player.js", "studies.js", "start.js"),
)
"""In the order in which they are read; the page's own share one scope with the libraries' global names."""

STYLES = ("libraries/uPlot.min.css", "page.css")
LICENCES = "libraries/LICENSES.txt"
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


@lru_cache
def _text(name: str) -> str:
    return files("bearing_twin.view").joinpath(name).read_text(encoding="utf-8")


def html(document: Mapping[str, Any]) -> str:
    """The page of a document of `run_page` or `study_page`, as text."""
    parts = {
        "title": escape(str(document["title"])),
        "policy": POLICY,
        "licences": _text(LICENCES).replace("--", "- -"),
        "styles": "\n".join(map(_text, STYLES)),
        "scripts": "\n".join(f"<script>\n{_safe(_text(name))}\n</script>" for name in SCRIPTS),
        # no text in it can end the element it stands in
        "document": json_text({**document, "version": __version__}).replace("<", "\\u003c"),
    }
    page = _text("page.html")
    for name, part in parts.items():
        page = page.replace(f"@@{name}@@", part, 1)
    return page


def _safe(script: str) -> str:
    return script.replace("</script", "<\\/script")


def write_page(document: Mapping[str, Any], path) -> Path:
    """Writes the page; returns the path. Raises BearingTwinError where there is no place for it."""
    return write_whole(path, html(document).encode())
