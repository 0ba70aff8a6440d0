"""The page of a run that goes on: made of the messages of its topics, with controls that command its node.

Outputs come as events `frames`, packed as those of a document.
"""

import numpy as np

from bearing_twin.base.errors import LogError, SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel, Sample
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.views import View
from bearing_twin.log.run_log import choice_in, scene_record
from bearing_twin.log.stream import block_of, channels_of, checked_block
from bearing_twin.run.scene import Scene, read_logged_scene
from bearing_twin.view.page import POLICY, file_text, html, pack_series
from bearing_twin.view.run_page import badges, pack_outputs, view_data, view_of
from bearing_twin.view.tables import badge

LARGEST_SCENE = 1 << 20  # characters
LARGEST_BLOCK = 1 << 24  # B
PERIOD = 0.05  # s between events, at least
ROWS = 5  # outputs for every PERIOD since the last event, at most: as many as a page can draw
MOST_ROWS = 100  # outputs in one event, at most


class LiveRun:
    """The run of a scene as its topics describe it; `scene_text` is the text of the topic `scene`.

    `latest` are times [s] and the series of the last event. Raises BearingTwinError for a text that is no scene.
    """

    def __init__(self, scene_text: str):
        self.scene_text = scene_text
        self.scene, self.choice = _read(scene_text)
        self.channels: tuple[Channel, ...] = ()
        self.view: View | None = None
        self.latest: tuple[np.ndarray, dict[str, np.ndarray]] = np.empty(0), {}
        self._next: int | None = None
        self._due = 0.0

    def frames(self, data: bytes, now: float) -> str:
        """The event `frames` of a SampleBlock that came at `now` [s]; empty where none is due.

        Raises LogError for bytes that are no block of this scene, and Again where the run has begun again.
        """
        if self._next is not None and now < self._due:
            return ""
        if len(data) > LARGEST_BLOCK:
            raise LogError(f"samples of {len(data)} bytes are too long for a page")
        message = checked_block("samples", data)
        channels = channels_of(self.scene, message)
        if self.view is None:
            self.channels = channels
            self.view = view_of(self)
        first, expected = int(message.first_sequence), self._next
        passed = PERIOD + (0.0 if self._next is None else now - self._due)
        self._next, self._due = first + int(message.count), now + PERIOD
        if channels != self.channels or (expected is not None and first < expected):
            self.view = self._next = None
            raise RunRestarted("the run has begun again")
        block = block_of(channels, message)
        step = -(-len(block) // int(min(MOST_ROWS, ROWS * passed / PERIOD)))
        rows = range((len(block) - 1) % step, len(block), step)
        return self._encoded(block.sample_rows(rows))

    def _encoded(self, sample: Sample) -> str:
        self.latest = 1e-9 * np.asarray(sample.time_ns), self.view.rows(sample)
        return pack_series(*self.latest, self.view.series)


class RunRestarted(LogError):
    """The run has begun again, or another one: what a page shows so far is over."""


def _read(topic_text: str) -> tuple[Scene, Choice]:
    """Scene and model in the text of the topic `scene`."""
    if len(topic_text) > LARGEST_SCENE:
        raise SceneError(f"a scene of {len(topic_text)} characters is none; restart the node that publishes it")
    try:
        record = scene_record(topic_text)
        text = record["scene"]
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise SceneError("what the topic scene says is no scene of a bearing_twin; look at the node's name") from error
    return read_logged_scene(text, "the topic scene"), choice_in(record)


def live_page(run: LiveRun, node: str) -> bytes:
    """The page; the first outputs of `run` have come. It may ask its own server alone.

    Raises Again where the run begins again at this moment, in another thread.
    """
    (time, values), view = run.latest, run.view
    if view is None:
        raise RunRestarted("the run has just begun again; the page comes with its first outputs")
    document = {
        "kind": "run",
        "title": run.scene.name,
        "subtitle": f"{node}, live: {run.scene.description}",
        "notes": [
            "Of the outputs that come, some are shown, and the last few thousand kept: peaks between them are missing "
            "from the curves. A log has all of them."
        ],
        "badges": [badge("live", sort="good"), *badges("", run.choice.law, run.choice.stepper, 0)[1:]],
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
            "commands": [command.name for command in KINDS[run.scene.kind].commands()],
            "speed": _last_row(values, ("inner_ring_speed", "shaft_speed"), 1)[0],
            "load": _last_row(values, ("ring_load", "varying_load"), 3),
        },
        "view": view_data(view),
        "packed": pack_outputs(time, values, view),
    }
    page = html(document).replace(POLICY, f"{POLICY}; connect-src 'self'", 1)
    head, _, remainder = page.partition("</head>")
    body, _, end = remainder.rpartition("</body>")
    style, script = f"<style>\n{file_text('live.css')}\n</style>\n", f"<script>\n{file_text('live.js')}\n</script>\n"
    return "".join((head, style, "</head>", body, script, "</body>", end)).encode()


def _last_row(values, series: tuple[str, ...], width: int) -> list[float]:
    """The last row of the first of these series that is there, to begin the controls with; else `width` zeros."""
    return next((np.ravel(values[name][-1]).tolist() for name in series if name in values), [0.0] * width)
