"""The subcommand `chart`: pictures that compare methods, or repeat a paper's. Imports are late, so --help is quick."""

import argparse
import importlib
from pathlib import Path

from bearing_twin.command.outcome import Outcome
from bearing_twin.errors import BearingTwinError

HELP = "accuracy against speed of steppers, laws, friction and samplers; the figures of papers on bounces and impacts"

CHARTS = {  # name: module in charts/, what it shows
    "steppers": ("work_precision", "error in load and friction against cost"),
    "cost": ("cost", "where the time of a run goes, from the contacts to a log"),
    "laws": ("laws", "error and cost of the elastic laws"),
    "friction": ("friction", "error and cost of friction over a spot that slides and spins"),
    "bounces": ("bounces", "a ball by the Hertz and by the volumetric law, and which comes late"),
    "samplers": ("samplers", "error of mean and deviation of a contact time against realisations and cost"),
    "discs": ("soft_discs", "error of a soft disc's force against seconds, over meshes, formulations and steps"),
    "studies": ("studies", "densities, forces and convergence of impacts with uncertain inputs"),
}
OPTIONS = {"problem": "steppers", "only": "studies"}  # option: the chart it goes with


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `chart` to its parser."""
    parser.add_argument(
        "chart", choices=tuple(CHARTS), help="; ".join(f"{name}: {text}" for name, (_, text) in CHARTS.items())
    )
    parser.add_argument("--out", default=".", metavar="FOLDER", help="where the pictures and the tables go")
    parser.add_argument(
        "--problem", action="append", metavar="NAME", help="of steppers: only this one; may be repeated"
    )
    which = "of studies: only the sheet of this name, or the one with this figure of the paper; may be repeated"
    parser.add_argument("--only", action="append", metavar="SHEET", help=which)


def run(arguments: argparse.Namespace) -> Outcome:
    """Makes one chart; raises BearingTwinError with a sentence for a folder or a word that does not fit."""
    folder = Path(arguments.out)
    if not folder.is_dir():
        raise BearingTwinError(f"{folder} is not a folder; make it first, or give another one")
    for option, name in OPTIONS.items():
        if getattr(arguments, option) and arguments.chart != name:
            raise BearingTwinError(f"--{option} goes with the chart {name}; leave it out")
    chart = importlib.import_module(f"bearing_twin.charts.{CHARTS[arguments.chart][0]}")
    if arguments.chart == "studies":
        return _sheets(chart, chart.wanted_sheets(arguments.only or ()), folder)
    return _chart(chart, arguments, folder)


def _chart(chart, arguments, folder) -> Outcome:
    """One picture with its table, of points that are measured."""
    from bearing_twin.command.terminal import progress, say, show_text

    if arguments.chart == "steppers":
        points = list(chart.measure(_problems(arguments.problem, chart.PROBLEMS), say))
    elif arguments.chart == "cost":
        points = list(chart.measure(progress=say))
    elif arguments.chart == "samplers":
        with progress("sampling") as update:
            points = chart.measure(update)
    else:
        points = list(chart.measure())
    picture, table = folder / f"{arguments.chart}.png", folder / f"{arguments.chart}.csv"
    chart.draw(points, picture)
    chart.write_table(points, table)
    sentences = list(chart.reading(points))

    def show():
        show_text("\n".join(sentences) + f"\npicture: {picture}\ntable:   {table}")

    rows = [vars(point) if hasattr(point, "__dict__") else point._asdict() for point in points]
    return Outcome({"points": rows, "reading": sentences, "picture": str(picture), "table": str(table)}, [], show)


def _sheets(chart, names, folder) -> Outcome:
    """Every sheet of studies as a picture and a table, with what it says."""
    from bearing_twin.command.terminal import progress, show_text

    written = []
    for name in names:
        with progress(f"sheet {name}") as update:
            written.append(chart.write(name, folder, update))

    def show():
        for one in written:
            show_text("\n".join([*one.reading, f"picture: {one.picture}", f"table:   {one.table}", ""]))

    return Outcome({"sheets": [one._asdict() for one in written]}, [], show)


def _problems(wanted, known) -> list[str]:
    from bearing_twin.parameters import echo, unknown

    for name in wanted or ():
        if name not in known:
            raise BearingTwinError(f"{echo(name)} is not a problem; {unknown(name, known)}")
    return list(wanted or known)
