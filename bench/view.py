"""Cost of a page for the browser: `python bench/view.py [scene] [seconds]`.

A log of 10 s at 1 kHz becomes a page: CPU seconds of the whole command, bytes.
"""

import platform
import resource
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path

COMMAND = [sys.executable, "-m", "bearing_twin"]


def spent() -> float:
    """CPU seconds of all child processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(scene: str = "bearing_6203", seconds: str = "10") -> None:
    with tempfile.TemporaryDirectory() as folder:
        log, page = Path(folder) / "run.mcap", Path(folder) / "page.html"
        words = ["simulate", scene, "--duration", seconds, "--out", str(log)]
        subprocess.run([*COMMAND, *words], check=True, capture_output=True)
        before, began = spent(), time.monotonic()
        subprocess.run([*COMMAND, "view", str(log), "--out", str(page)], check=True, capture_output=True)
        made = f"{spent() - before:.2f} s of CPU, {time.monotonic() - began:.2f} s, {page.stat().st_size / 1e6:.2f} MB"
        print(f"{date.today()}, {platform.machine()}, Python {platform.python_version()}: {scene}, {seconds} s")
        print(f"page of the log: {made}")


if __name__ == "__main__":
    main(*sys.argv[1:])
