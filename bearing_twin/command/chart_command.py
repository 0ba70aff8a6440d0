"""The subcommand `chart`: pictures that compare methods, or repeat a paper's. Imports are late, so --help is quick."""

import argparse
import importlib
from pathlib import Path

from bearing_twin.command.outcome import Outcome
from bearing_twin.errors import BearingTwinError

HELP = "accuracy against speed of steppers, laws, friction and samplers; the figures of papers on bounces and impacts"

CHARTS = {  # name: module in charts/, what it shows
    "steppers": ("work_precision", "error in load and friction against cost"),
    "tolerance": ("tolerance", "the error asked for against the error got, and what runs say of it"),
    "cost": ("cost", "where the time of a run goes, from the contacts to a log"),
    "laws": ("laws", "error and cost of the elastic laws"),
    "friction": ("friction", "error and cost of friction over a spot that slides and spins"),
    "bounces": ("bounces", "a ball by the Hertz and by the volumetric law, and which comes late"),
    "dimensions": ("dimensions", "equilibria against balls that move: error and cost over speed and load"),
    "samplers": ("samplers", "error of mean and deviation of a contact time against realisations and cost"),
    "coverage": ("coverage", "how often 95 % intervals hold the truth, by sampler, statistic and samples"),
    "discs": ("soft_discs", "error of a soft disc's force against seconds, over meshes, formulations and steps"),
    "paper1": ("paper1", "paper 1's bearing in space, contact point and normal of a ball by several laws, their cost"),
    "studies": ("studies", "densities, forces and convergence of impacts with uncertain inputs"),
    "paper2": ("paper2", "a sphere falls on a beam: both drops by both beam theories, and what a paper says of them"),
}
SAYING = ("coverage", "cost")  # charts that say what they measure
SHARES = {
    "samplers": "sampling",
    "dimensions": "running",
    "tolerance": "running",
}
"""Charts that tell the share done, and of what."""
SHEETS = ("studies", "paper2")
OPTIONS = {"problem": ("steppers",), "only": SHEETS}  # option: the charts it goes with


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `chart` to its parser."""
    parser.add_argument(
        "chart", choices=tuple(CHARTS), help="; ".join(f"{name}: {text}" for name, (_, text) in CHARTS.items())
    )
    parser.add_argument("--out", default=".", metavar="FOLDER", help="where the pictures and the tables go")
    parser.add_argument(
        "--problem", action="append", metavar="NAME", help="of steppers: only this one; may be repeated"
    )
    which = "only the sheet of this name, or the one with this figure of the paper; may be repeated"
    parser.add_argument("--only", action="append", metavar="SHEET", help=f"of {' and '.join(SHEETS)}: {which}")


def run(arguments: argparse.Namespace) -> Outcome:
    """Makes one chart; raises BearingTwinError with a sentence for a folder or a word that does not fit."""
    folder = Path(arguments.out)
    if not folder.is_dir():
        raise BearingTwinError(f"{folder} is not a folder; make it first, or give another one")
    for option, names in OPTIONS.items():
        if getattr(arguments, option) and arguments.chart not in names:
            raise BearingTwinError(f"--{option} goes with the chart {' or '.join(names)}; leave it out")
    chart = importlib.import_module(f"bearing_twin.charts.{CHARTS[arguments.chart][0]}")
    if arguments.chart in SHEETS:
        return _sheets(chart.SHEETS, arguments.only or (), folder)
    return _chart(chart, arguments, folder)


def _chart(chart, arguments, folder) -> Outcome:
    """One picture with its table, of points that are measured."""
    from bearing_twin.command.terminal import progress, say, show_text

    if arguments.chart == "steppers":
        points = list(chart.measure(_problems(arguments.problem, chart.PROBLEMS), say))
    elif arguments.chart in SAYING:
        points = list(chart.measure(say=say))
    elif arguments.chart in SHARES:
        with progress(SHARES[arguments.chart]) as update:
            points = chart.measure(update)
    else:
        points = list(chart.measure())
    picture, table = folder / f"{arguments.chart}.png", folder / f"{arguments.chart}.csv"
    chart.draw(points, picture)
    chart.write_table(points, table)
    sentences = list(chart.reading(points))

    def show():
        show_text("\n".join(sentences) + f"\npicture: {picture}\ntable:   {table}")

    plain = [vars(point) if hasattr(point, "__dict__") else point._asdict() for point in points]
    rows = [{key: value for key, value in row.items() if key != "histories"} for row in plain]
    return Outcome({"points": rows, "reading": sentences, "picture": str(picture), "table": str(table)}, [], show)


def _sheets(sheets, words, folder) -> Outcome:
    """Every sheet that is wanted as a picture and a table, with what it says."""
    from bearing_twin.command.terminal import progress, show_text

    written = []
    for name in sheets.wanted(words):
        with progress(f"sheet {name}") as update:
            written.append(sheets.write(name, folder, update))

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
