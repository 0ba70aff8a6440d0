"""The page of a run that goes on: that of a run, with controls, and with outputs as its own server sends them."""

from importlib.resources import files

import numpy as np

from bearing_twin.kinds import KINDS
from bearing_twin.view.live import Again, LiveRun
from bearing_twin.view.packing import packed
from bearing_twin.view.page import POLICY, html
from bearing_twin.view.run_page import badges, described_view

LIVE = {"sort": "good", "name": "", "text": "live"}


def live_page(run: LiveRun, node: str) -> bytes:
    """The page; the first outputs of `run` have come. It may ask its own server alone.

    Raises Again where the run begins again at this moment, in another thread.
    """
    (time, values), view = run.latest, run.view
    if view is None:
        raise Again("the run has just begun again; the page comes with its first outputs")
    document = {
        "kind": "run",
        "title": run.scene.name,
        "subtitle": f"{node}, live: {run.scene.description}",
        "notes": [
            "Of the outputs that come, some are shown, and the last few thousand kept: peaks between them are missing "
            "from the curves. A log has all of them."
        ],
        "badges": [LIVE, *badges("", run.choice.law, run.choice.stepper, 0)[1:]],
        "facts": [
            ("elastic law", run.choice.law or "-"),
            ("method", run.choice.stepper or "-"),
            ("kind of scene", run.scene.kind),
            ("node", node),
        ],
        "reason": run.choice.reason,
        "status": "live",
        **{key: [] for key in ("warnings", "flags", "figures", "tables", "errors")},
        "live": {
            "commands": [one.name for one in KINDS[run.scene.kind].commands()],
            "speed": _acting(values, ("inner_ring_speed", "shaft_speed"), 1)[0],
            "load": _acting(values, ("ring_load", "varying_load"), 3),
        },
        "view": described_view(view),
        "packed": packed(time, values, view.series),
    }
    page = html(document).replace(POLICY, f"{POLICY}; connect-src 'self'", 1)
    head, _, rest = page.partition("</head>")
    body, _, end = rest.rpartition("</body>")
    style, script = f"<style>\n{_text('live.css')}\n</style>\n", f"<script>\n{_text('live.js')}\n</script>\n"
    return "".join((head, style, "</head>", body, script, "</body>", end)).encode()


def _acting(values, series: tuple[str, ...], width: int) -> list[float]:
    """The last row of the first of these series that is there, to begin the controls with; else `width` zeros."""
    return next((np.ravel(values[one][-1]).tolist() for one in series if one in values), [0.0] * width)


def _text(name: str) -> str:
    return files("bearing_twin.view").joinpath(name).read_text(encoding="utf-8")
