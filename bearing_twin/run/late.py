"""Changes and rows of tables over time that come only when a run is over."""

import dataclasses
from collections.abc import Iterator

from bearing_twin.run.scene import Scene


def late_keys(scene: Scene, until: float) -> list[str]:
    """One sentence for each key of the scene with a time that a run of `until` [s] never comes to.

    Rows of a table count where the run ends before the row in front of them: between two it is straight.
    """
    return [
        f"{key} is beyond the end of the run at {until:g} s: nothing of that happens"
        for key in _beyond(scene.parameters, until, "")
    ]


def _beyond(section, until: float, path: str) -> Iterator[str]:
    for item in dataclasses.fields(section):
        value, key = getattr(section, item.name), f"{path}{item.name}"
        if dataclasses.is_dataclass(value):
            if item.name == "change" and value.time > until:
                yield f"{key}.time = {value.time:g} s"
            yield from _beyond(value, until, f"{key}.")
        elif item.metadata.get("columns", ())[:1] == (("time", "s"),):
            times = [row[0] for row in value]
            if late := sum(time >= until for time in times[:-1]):
                yield f"what {key} says after {times[-1 - late]:g} s"
