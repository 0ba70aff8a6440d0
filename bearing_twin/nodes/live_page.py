"""The page of a run that goes on: what it shows and its controls, in one answer; texts are shown as text."""

import json
from html import escape

from bearing_twin.nodes.live import LiveRun
from bearing_twin.paths import share_path


def page_of(run: LiveRun, node: str) -> bytes:
    """The page; the first outputs of `run` have come."""
    document = json.dumps(run.described() | {"node": node}).replace("<", "\\u003c")
    parts = {
        "title": escape(run.scene.name),
        "style": _text("live.css"),
        "live": _text("live.js"),
        "plots": _text("plots.js"),
        "document": document,
    }
    page = _text("page.html")
    for name, part in parts.items():
        page = page.replace(f"@@{name}@@", part, 1)
    return page.encode()


def _text(name: str) -> str:
    return share_path("config", "watch", name).read_text(encoding="utf-8")
