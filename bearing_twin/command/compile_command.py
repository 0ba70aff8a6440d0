"""The subcommand `compile`: compiles what scenes need, before somebody waits for it. Imports are late."""

import argparse
import contextlib
import threading
import time
from collections.abc import Iterator

from bearing_twin.command.outcome import Outcome, add_changes, overrides_of

HELP = "compile what scenes need, so that their first run starts at once"
EXAMPLES = ("bearing_twin compile", "bearing_twin compile bearing_6203 --set contact.friction=spot")
QUICK = 1.0  # s: what compiles faster is not named


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `compile` to its parser."""
    which = "name of a scene or path of a YAML file; without one, all scenes of `bearing_twin scenes`"
    parser.add_argument("scene", nargs="*", help=which)
    add_changes(parser, "change one key of each scene; may be repeated")


def run(arguments: argparse.Namespace) -> Outcome:
    """Compiles scene by scene; raises SceneError for a scene that cannot be read.

    Ctrl-C loses only the function that is being compiled: Numba writes each to disk when it is done.
    """
    from bearing_twin.run.scene import load_scene, scene_names

    began = time.monotonic()
    scenes = [load_scene(name, overrides_of(arguments)) for name in arguments.scene or scene_names()]
    rows = [_compiled(scene) for scene in scenes]
    seconds = round(time.monotonic() - began, 3)
    return Outcome({"scenes": rows, "seconds": seconds}, [], lambda: _show(rows, seconds))


def _compiled(scene) -> dict:
    from bearing_twin.command.terminal import say

    with _told(scene.name) as done:
        from bearing_twin.run.simulation import Simulation

        began = time.monotonic()
        Simulation(scene).warm_up()
        seconds = time.monotonic() - began
    say(f"{scene.name}: ready after {seconds:.1f} s, {len(done)} functions compiled")
    return {"scene": scene.name, "seconds": round(seconds, 3), "functions": len(done)}


@contextlib.contextmanager
def _told(name: str) -> Iterator[list[str]]:
    """The functions compiled in the body, each said when it took long, and with the seconds so far while it does."""
    from numba.core import event

    from bearing_twin.command.terminal import PLAIN_PERIOD, say

    done, open_since, ended = [], [], threading.Event()

    class Listener(event.Listener):
        def on_start(self, one):
            open_since.append((one.data["dispatcher"].py_func.__name__, time.monotonic()))

        def on_end(self, one):
            function, since = open_since.pop()
            done.append(function)
            if not open_since and time.monotonic() - since > QUICK:  # the others are parts of the outermost
                say(f"{name}: {function} compiled in {time.monotonic() - since:.1f} s")

    def keep_saying():
        began = time.monotonic()
        while not ended.wait(PLAIN_PERIOD):
            function = next((function for function, _ in tuple(open_since)), "the rest")
            say(f"{name}: compiling {function}, {time.monotonic() - began:.0f} s so far")

    listener = Listener()
    speaker = threading.Thread(target=keep_saying, name="compile progress", daemon=True)
    event.register("numba:compile", listener)
    speaker.start()
    try:
        yield done
    finally:
        event.unregister("numba:compile", listener)
        ended.set()
        speaker.join()


def _show(rows, seconds) -> None:
    from bearing_twin.command.terminal import show_rows, show_text

    show_rows(("scene", "seconds", "functions compiled"), (row.values() for row in rows))
    show_text(f"all in {seconds:.1f} s; compiled code is kept for later runs")
