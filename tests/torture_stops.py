"""A torture of everything that computes for long: commands and nodes of every kind are ended by a signal."""

import contextlib
import itertools
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from domains import own_domain
from torture_rows import Found, Row, until

from bearing_twin.nodes.entry import node_command

ENDED = 0.5  # s
BEGUN = 60.0  # s after which what does not begin is given up
LONG = (
    ("bearing_6203", ["solver.stepper=rk4", "solver.step=1e-11"]),
    ("bearing_6203", ["solver.stepper=radau", "run.duration=1000"]),
    ("bearing_6203_load_and_speed", ["cage.kind=pockets", "run.duration=1000"]),
    ("bearing_6203", ["geometry.balls=4000", "geometry.pitch_diameter=12.0", "run.duration=1000"]),
    ("ellipsoid_tumbling", ["solver.stepper=rk4", "solver.step=1e-13"]),
    ("two_bodies_superellipsoid", ["run.duration=80000"]),
    ("soft_discs_mean", ["mesh.divisions=400"]),
    ("sphere_on_beam", ["solver.modes=4000", "run.duration=30", "run.output_rate=100000"]),
)
"""Scenes that take longer than the torture; spheres and discs that meet are solved in an instant.

The beam's impact itself takes a second or two, its 3 million outputs of 2000 modes minutes.
"""
STUDIES = (
    ("spheres_alpha_4e-5", ["sweep=", "histories=[]", "samples=12000000", "batch=1000000"]),
    ("bearing_6203_tolerances", ["run.duration=20000"]),
)


def commands() -> list[list[str]]:
    """Each of them as a command, and the scenes in a node."""
    program = [sys.executable, "-m", "bearing_twin"]
    found = [[*program, "simulate", name, *_set(changes)] for name, changes in LONG]
    found += [[*program, "study", name, *_set(changes)] for name, changes in STUDIES]
    found += [node_command("sim_node", {"scene": name, "overrides": changes}) for name, changes in LONG]
    return [*found, node_command("uq_node", {"log_folder": ""})]


def _set(changes: list[str]) -> list[str]:
    return [word for change in changes for word in ("--set", change)]


def stops(share: float, folder: Path, seed: int = 9) -> Found:
    """Each ended by SIGINT or SIGTERM some seconds after its start: gone within 500 ms, without a traceback."""
    chance, times, silent, slow = random.Random(seed), [], 0, []
    ended = zip(commands(), itertools.cycle((signal.SIGINT, signal.SIGTERM, signal.SIGINT)))
    for words, number in list(ended)[:: max(1, round(1.0 / share))]:
        said = folder / "said.txt"
        with own_domain() as domain, said.open("wb") as output:
            environment = os.environ | {"ROS_DOMAIN_ID": str(domain)}
            process = subprocess.Popen(words, stdout=output, stderr=output, env=environment)
            try:
                until(lambda said=said, process=process: said.stat().st_size > 0 or process.poll() is not None, BEGUN)
                time.sleep(chance.uniform(0.0, 3.0))
                if process.poll() is not None:
                    raise RuntimeError(f"{' '.join(words)} has ended by itself: {said.read_text()[-500:]}")
                began = time.monotonic()
                process.send_signal(number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(20.0)
            finally:
                process.kill()
                process.wait()
        times.append(time.monotonic() - began)
        what = f"{signal.Signals(number).name} to {' '.join(words[2:])}"
        if process.returncode not in (0, 130, 143) or "Traceback" in said.read_text():
            silent += 1
            slow.append(f"exit code {process.returncode} after {what}")
            print(f"torture: {slow[-1]}\n{said.read_text()[-3000:]}", file=sys.stderr)
        if times[-1] > ENDED:
            slow.append(f"{1e3 * times[-1]:.0f} ms after {what}")
    figures = f"ended {1e3 * np.median(times):.0f} ms (greatest {1e3 * max(times):.0f})"
    return Found(
        len(times), sum(one < ENDED for one in times), 0, silent, figures + "".join(f"; {one}" for one in slow)
    )


ROWS = (Row("stop", "long scenes of every kind, as a command, in a study and in sim_node, ended by a signal", stops),)
