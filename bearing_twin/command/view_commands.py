"""The subcommands `view`, `watch` and `layouts`: pages for the browser, files for other viewers. Imports are late."""

import argparse
import json
from pathlib import Path
from typing import Any

from bearing_twin.base.errors import BearingTwinError, IntegrationError, import_optional
from bearing_twin.base.paths import file_name
from bearing_twin.command.bearing_command import note_bare_speed
from bearing_twin.command.node_command import replace_by_node
from bearing_twin.command.outcome import (
    RUN,
    Outcome,
    Subcommand,
    add_changes,
    new_file,
    new_path,
    overrides_of,
)
from bearing_twin.command.terminal import in_shown_units, progress, say

LONGEST_RUN = 10.0  # simulated seconds of a scene that is run for its page


def _view_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `view` to its parser."""
    text = "an MCAP log or a bag folder; or the name or file of a scene or a study, which is run first"
    parser.add_argument("source", metavar="LOG|SCENE|STUDY", help=text)
    parser.add_argument("--out", metavar="HTML", help="the page (default: NAME.html here); an earlier one is replaced")
    parser.add_argument(
        "--study", action="store_true", help="the name is that of a study, if a scene has the same name"
    )
    add_changes(parser, "change a key of the scene or the study")
    parser.add_argument(
        "--duration", metavar="S", help=f"simulated time of a scene [s] (default: its own, at most {LONGEST_RUN:g})"
    )
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")
    parser.add_argument("--run", **RUN)
    parser.add_argument("--gif", metavar="GIF", help="also write the animation as a GIF; needs the extra `view`")


def _view(arguments: argparse.Namespace) -> Outcome:
    """Make the page; raises BearingTwinError where it is not possible."""
    out = new_path(arguments.out, (".html", ".htm"), "page", replaced=True)
    gif = new_path(arguments.gif, (".gif",), "animation")
    if gif:
        import_optional("playwright.sync_api", "view")  # said before a scene is run
    kind = _source_kind(arguments)
    if kind == "log" and (arguments.set or arguments.duration):
        raise BearingTwinError("a log cannot be changed; give --set and --duration with a scene")
    if kind != "log" and (arguments.topic or arguments.run is not None):
        raise BearingTwinError(f"a {kind} has one view; give --topic and --run with a log")
    document, problem = {"log": _log_document, "study": _study_document, "scene": _run_document}[kind](arguments)
    from bearing_twin.view.page import write_page

    name = Path(arguments.source).resolve().stem if kind == "log" else file_name(document["title"])
    page = write_page(document, out or Path(f"{name}.html"))
    if gif:
        from bearing_twin.view.page import write_gif

        with progress("drawing the animation") as update:
            write_gif(page, gif, update)
    frames = document.get("packed", {}).get("frames")
    result = {
        "view": str(page),
        "shows": document["title"],
        "bytes": page.stat().st_size,
        **({"gif": str(gif)} if gif else {}),
        **({"outputs_shown": frames} if frames is not None else {}),
    }
    notes = [] if problem else document["notes"]  # the problem is what they say
    return Outcome(result, [*notes, *document["flags"]], problem=problem)


def _source_kind(arguments) -> str:
    """`log`, `scene` or `study`, by the suffix, the name, or the content of the file."""
    from bearing_twin.base.yaml_files import SCENES, STUDIES, SUFFIXES

    text = arguments.source
    path = Path(text)
    if arguments.study:
        return "study"
    if path.suffix == ".mcap" or path.is_dir():
        return "log"
    if text in SCENES.names():
        if text in STUDIES.names():
            say(f"{text} is the name of a study too; give --study for that")
        return "scene"
    if text in STUDIES.names():
        return "study"
    if path.suffix in SUFFIXES and path.is_file():
        data = STUDIES.load(STUDIES.read_text(path), path.name)
        return "study" if isinstance(data, dict) and "scene" in data and "kind" not in data else "scene"
    return "scene"


def _log_document(arguments) -> tuple[dict[str, Any], str]:
    from bearing_twin.view.run_page import log_document

    with progress(f"reading {arguments.source}"):
        return log_document(arguments.source, arguments.topic, arguments.run), ""


def _run_document(arguments) -> tuple[dict[str, Any], str]:
    """The page of a run, as far as it came, and why it came no further."""
    from bearing_twin.run.scene import has_override, load_scene

    overrides = overrides_of(arguments, duration="run.duration")
    scene = load_scene(arguments.source, overrides)
    note_bare_speed(scene, overrides)
    duration = scene.parameters.run.duration
    from bearing_twin.run.failure import failure_sentence
    from bearing_twin.run.scene import unreached_keys
    from bearing_twin.run.simulation import simulate
    from bearing_twin.view.run_page import run_document

    if duration > LONGEST_RUN and not has_override(overrides, "run.duration"):
        say(
            in_shown_units(f"{scene.name} is run for {LONGEST_RUN:g} s of its {duration:g} s; give --duration for more")
        )
        scene = load_scene(arguments.source, [*overrides, f"run.duration={LONGEST_RUN}"])
    else:
        say(in_shown_units(f"{scene.name} is run for {duration:g} s"))
    for warning in unreached_keys(scene, scene.parameters.run.duration):
        say(in_shown_units(f"{scene.name}: {warning}"))
    with progress(f"simulating {scene.name}") as update:
        run = simulate(scene, update)
        try:
            document = run_document(run).document
        except IntegrationError as error:
            raise BearingTwinError(failure_sentence(error, Path())) from error
    return document, failure_sentence(run.failure, Path()) if run.failure else ""


def _study_document(arguments) -> tuple[dict[str, Any], str]:
    from bearing_twin.uq.run import run_study
    from bearing_twin.uq.study import load_study
    from bearing_twin.view.study_page import study_document

    if arguments.duration is not None:
        raise BearingTwinError("a study has no --duration; give --set run.duration=... for that of its scene")
    study = load_study(arguments.source, overrides_of(arguments))
    with progress(f"study {study.name}") as update:
        result = run_study(study, lambda state: update(state.done / state.total))
    return study_document(result), ""


VIEW = Subcommand(
    "write a page for the browser, in one file: animation, curves and figures of a run, or the results of a study",
    _view_arguments,
    _view,
    ("bearing_twin view run.mcap", "bearing_twin view bearing_6203_loose --duration 0.5 --out loose.html"),
)


def _watch_arguments(parser) -> None:
    parser.add_argument("--node", default="", help="full name of the node; without, the only one with samples")
    parser.add_argument("--port", default="8080", help="port to listen on; 0 = any that is free (default: 8080)")
    host = "address to listen on; any but localhost lets other machines look and command"
    parser.add_argument("--host", default="localhost", help=host)


def _watch(arguments) -> Outcome:
    """Replaces this process by a watch_node, which checks the values."""
    parameters = (
        f"port:={arguments.port}",
        *(f"{key}:={json.dumps(getattr(arguments, key))}" for key in ("host", "node")),
    )
    replace_by_node("watch_node", [part for parameter in parameters for part in ("-p", parameter)])


WATCH = Subcommand(
    "show a running node in a browser, with controls for speed, load, pause and reset",
    _watch_arguments,
    _watch,
    ("bearing_twin watch", "bearing_twin watch --port 8080"),
)


def _layouts_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("source", metavar="SCENE|LOG", help="name of a scene, path of a YAML file, or an MCAP log")
    parser.add_argument("--out", metavar="FOLDER", default=".", help="folder of the files; it is created if need be")
    parser.add_argument(
        "--for",
        dest="programs",
        action="append",
        choices=("rviz", "foxglove", "plotjuggler"),
        help="may be repeated; without, all of them",
    )
    parser.add_argument("--namespace", default="", help="of the node, such as /left; not needed for a log")
    parser.add_argument(
        "--frame-prefix", default="", help="frame_prefix of the node, such as left/; not needed for a log"
    )
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")


def _layouts(arguments) -> Outcome:
    """The files; raises BearingTwinError, SceneError or LogError."""
    from bearing_twin.base.paths import write_atomic
    from bearing_twin.log.layouts import LAYOUTS

    source = Path(arguments.source)
    is_log = source.suffix == ".mcap" or source.is_dir()
    panels = _panels_of_log(source, arguments.topic) if is_log else _panels_of_scene(arguments)
    if not panels.plots:
        raise BearingTwinError(
            f"{panels.name} has neither wrenches nor contacts nor state among its topics, which layouts show; "
            "bearing_twin view shows its channels"
        )
    folder = Path(arguments.out)
    folder.mkdir(parents=True, exist_ok=True)
    name = file_name(source.stem if is_log else panels.name)
    files, opened = {}, {}
    for program in arguments.programs or LAYOUTS:
        layout = LAYOUTS[program]
        path = write_atomic(new_file(folder / f"{name}{layout.suffix}"), layout.render(panels))
        opened[program] = layout.open_command(path, source if is_log else None)
        files[program] = str(path)
    return Outcome({"files": files, "open_with": opened}, [])


def _panels_of_scene(arguments):
    from bearing_twin.log.layouts import panels
    from bearing_twin.run.scene import load_scene

    return panels(load_scene(arguments.source), arguments.namespace, arguments.frame_prefix)


def _panels_of_log(path: Path, topic: str | None):
    from bearing_twin.log.layouts import panels_of_log
    from bearing_twin.log.run_log import read_log
    from bearing_twin.log.study_log import STUDY_RECORD

    log = read_log(path, topic=topic)
    if STUDY_RECORD in log.metadata:
        raise BearingTwinError(f"{path} is the log of a study, which has no layout; bearing_twin view {path} shows it")
    return panels_of_log(log)


LAYOUTS = Subcommand(
    "write layouts of a scene, or of the log of a run, for RViz, Foxglove and PlotJuggler",
    _layouts_arguments,
    _layouts,
    ("bearing_twin layouts bearing_6203 --out layouts",),
)
