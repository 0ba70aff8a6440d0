"""`chart all`: every chart in a process of its own, two at a time, those that are finished not again."""

import math
import subprocess
import sys
import time
from pathlib import Path

from bearing_twin.command.chart_table import CHARTS
from bearing_twin.command.outcome import Outcome
from bearing_twin.errors import BearingTwinError

LOOK = 0.2  # seconds between two looks at what runs


def make_all(folder: Path, limit: float | None) -> Outcome:
    """Makes every chart that is not finished yet; raises BearingTwinError with the last words of one that fails."""
    from bearing_twin.charts.contest import Kept, processors
    from bearing_twin.command.terminal import progress, say, show_rows

    kept = Kept(folder / "all.unfinished")
    if kept.answers:
        say(f"finished before, and not repeated: {', '.join(kept.answers)}")
    waiting = sorted(set(CHARTS) - set(kept.answers), key=lambda name: CHARTS[name].seconds)  # the longest first
    total, running = sum(chart.seconds for chart in CHARTS.values()), {}
    try:
        with progress("charts") as update:
            while waiting or running:
                while waiting and len(running) < processors():
                    name = waiting.pop()
                    running[name] = _started(name, folder, limit), time.monotonic()
                for name, (process, began) in list(running.items()):
                    if process.poll() is not None:
                        _look_at(name, process)
                        kept.put(name, round(time.monotonic() - began, 1))
                        del running[name]
                        say(f"{name}: finished in {kept.answers[name]:g} s")
                part = sum(_share(name, began) for name, (_, began) in running.items())
                update((sum(CHARTS[name].seconds for name in kept.answers if name in CHARTS) + part) / total)
                time.sleep(LOOK)
    finally:
        for process, _ in running.values():
            process.terminate()
    kept.drop()
    rows = [(name, kept.answers[name]) for name in CHARTS]
    return Outcome({"seconds": dict(rows)}, [], lambda: show_rows(("chart", "seconds"), rows))


def _share(name, began) -> float:
    """Seconds of a chart's usual time that are done, by the clock: it never quite comes to its end."""
    usual = CHARTS[name].seconds
    return usual * (1.0 - math.exp(-(time.monotonic() - began) / usual))


def _started(name, folder, limit):
    words = [sys.executable, "-m", "bearing_twin", "chart", name, "--out", str(folder), "--json"]
    if CHARTS[name].made == "contest":
        words += ["--workers", "1", *(["--limit", f"{limit:g}"] if limit else [])]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def _look_at(name, process):
    """Raises BearingTwinError where a chart could not be made."""
    words = process.stderr.read().strip()
    if process.returncode:
        last = words.splitlines()[-1] if words else f"it ended with {process.returncode}"
        raise BearingTwinError(f"chart {name} failed: {last}; what is finished is kept, so the same command goes on")
