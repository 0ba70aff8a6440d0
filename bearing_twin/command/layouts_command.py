"""`bearing_twin layouts`: a scene or a log laid out for RViz, Foxglove, PlotJuggler and Rerun."""

from pathlib import Path

from bearing_twin.command.outcome import Outcome
from bearing_twin.errors import BearingTwinError
from bearing_twin.parameters import echo, unknown
from bearing_twin.paths import file_name

HELP = "write layouts of a scene, or of the log of a run or a study, for RViz, Foxglove, PlotJuggler and Rerun"
EXAMPLES = ("bearing_twin layouts bearing_6203 --out layouts",)
RERUN = "rerun"


def add_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("source", metavar="SCENE|LOG", help="name of a scene, path of a YAML file, or an MCAP log")
    parser.add_argument("--out", metavar="FOLDER", default=".", help="where the files go; made where it is not there")
    parser.add_argument(
        "--for",
        dest="programs",
        action="append",
        default=[],
        metavar="PROGRAM",
        help="rviz, foxglove, plotjuggler, or rerun (of a log alone: one file with its messages, by rerun-sdk); may be "
        "repeated; without, the first three",
    )
    parser.add_argument("--namespace", default="", help="of the node, such as /left; of a log it is known")
    parser.add_argument("--frame-prefix", default="", help="as the node has it, such as left/; of a log it is known")
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")


def run(arguments) -> Outcome:
    """The files; raises BearingTwinError, SceneError or LogError."""
    from bearing_twin.log.layouts import LAYOUTS, write_layout

    programs = arguments.programs or list(LAYOUTS)
    for program in programs:
        if program not in (*LAYOUTS, RERUN):
            raise BearingTwinError(f"--for {echo(program)} is no program; {unknown(program, [*LAYOUTS, RERUN])}")
    source = Path(arguments.source)
    is_log = source.suffix == ".mcap" or source.is_dir()
    if RERUN in programs and not is_log:
        raise BearingTwinError("the layout for Rerun is in one file with a log: give a log, not a scene")
    panels = _panels_of_log(source, arguments.topic) if is_log else _panels_of_scene(arguments)
    if not panels.plots:
        raise BearingTwinError(
            f"{panels.name} has neither wrenches nor contacts nor state among its topics, which layouts show; "
            "bearing_twin view shows its channels"
        )
    if not panels.frame:
        if "rviz" in arguments.programs:
            raise BearingTwinError("a study has nothing that RViz draws; give --for foxglove, plotjuggler or rerun")
        programs = [one for one in programs if one != "rviz"]
    folder = _made(Path(arguments.out))
    name = file_name(source.stem if is_log else panels.name)
    files, opened = {}, {}
    for program in programs:
        if program == RERUN:
            from bearing_twin.log.rerun_file import write_rerun

            path = write_rerun(source, panels, folder / f"{name}.rrd")
            opened[program] = f"rerun {path}"
        else:
            layout = LAYOUTS[program]
            path = write_layout(program, panels, folder / f"{name}{layout.suffix}")
            opened[program] = layout.opening(path, source if is_log else None)
        files[program] = str(path)
    return Outcome({"files": files, "open_with": opened}, [])


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise BearingTwinError(
            f"--out {folder} is, or leads through, a file, and layouts go into a folder: name one, or leave --out away"
        ) from error
    except OSError as error:
        raise BearingTwinError(f"--out {folder} cannot be made ({error.strerror}); give another folder") from error
    return folder


def _panels_of_scene(arguments):
    from bearing_twin.log.panels import panels
    from bearing_twin.run.scene import load_scene

    return panels(load_scene(arguments.source), arguments.namespace, arguments.frame_prefix)


def _panels_of_log(path: Path, topic: str | None):
    from bearing_twin.log.mcap_log import read_log
    from bearing_twin.log.panels import panels_of_log, panels_of_study
    from bearing_twin.log.study_log import is_study

    if is_study(path):
        return panels_of_study(path)
    return panels_of_log(read_log(path, topic=topic))
