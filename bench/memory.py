"""The most memory that a command has held, as the system counts it: `python bench/memory.py WORD ...`."""

import subprocess
import sys

# In a small process between: Linux counts what a process held before it became another program.
HELD = """import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"""


def most_held(*words: str) -> float:
    """The most memory [MB] that `bearing_twin WORD ...` has held."""
    command = [sys.executable, "-c", HELD, sys.executable, "-m", "bearing_twin", *words]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout) / 1024.0


if __name__ == "__main__":
    print(f"{most_held(*sys.argv[1:]):.4g} MB")
