"""The subcommand `chart`: pictures that compare methods, or repeat a paper's. Imports are late, so --help is quick."""

import argparse
import dataclasses
import importlib
from pathlib import Path

from bearing_twin.command.chart_table import ALL, CHARTS, made_by
from bearing_twin.command.outcome import Outcome, quantity
from bearing_twin.errors import BearingTwinError

HELP = "accuracy against speed of every choice, maps of where methods fail, the figures of papers"
EXAMPLES = ("bearing_twin chart --list", "bearing_twin chart laws --out charts", "bearing_twin chart steppers")

OPTIONS = {  # option: the charts it goes with
    "problem": made_by("contest"),
    "only": made_by("sheets"),
    "limit": (*made_by("contest"), ALL),
    "cell": ("stability",),
    "read": made_by("contest", "told", "points"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `chart` to its parser."""
    text = f"its name; --list tells what each shows and how long it takes; {ALL}: every one of them"
    parser.add_argument("chart", nargs="?", choices=(*CHARTS, ALL), metavar="CHART", help=text)
    parser.add_argument("--list", action="store_true", help="what each chart compares, and about how long it takes")
    parser.add_argument("--out", default=".", metavar="FOLDER", help="where the pictures and the tables go")
    which = f"of {', '.join(OPTIONS['problem'])}: only this problem, or map; may be repeated"
    parser.add_argument("--problem", action="append", metavar="NAME", help=which)
    which = "only the sheet of this name, or the one with this figure of the paper; may be repeated"
    parser.add_argument("--only", action="append", metavar="SHEET", help=f"of {' and '.join(OPTIONS['only'])}: {which}")
    text = "say what the table in the folder says; nothing is run"
    parser.add_argument("--read", action="store_true", default=None, help=text)
    parser.add_argument("--cell", metavar="CELL", help="of stability: one cell of a map, as its table names it")
    which = "CPU seconds after which a contestant is stopped"
    parser.add_argument("--limit", type=quantity("s"), metavar="SECONDS", help=f"of contests: {which}; 20 unless given")
    parser.add_argument("--workers", type=int, metavar="NUMBER", help="of contests: processes side by side; 2 at most")


def run(arguments: argparse.Namespace) -> Outcome:
    """Makes one chart; raises BearingTwinError with a sentence for a folder or a word that does not fit."""
    if arguments.list:
        return _list()
    if arguments.chart is None:
        raise BearingTwinError(f"name a chart, or {ALL}; bearing_twin chart --list says which there are")
    folder = Path(arguments.out)
    if not folder.is_dir():
        raise BearingTwinError(f"{folder} is not a folder; make it first, or give another one")
    for option, names in OPTIONS.items():
        if getattr(arguments, option) is not None and arguments.chart not in names:
            raise BearingTwinError(f"--{option} goes with the chart {' or '.join(names)}; leave it out")
    if arguments.limit is not None and not 0.0 < arguments.limit < float("inf"):
        raise BearingTwinError(f"--limit = {arguments.limit:g} s is no limit; give CPU seconds above zero")
    if arguments.chart == ALL:
        from bearing_twin.command.all_charts import make_all

        return make_all(folder, arguments.limit)
    if arguments.read:
        return _read(arguments.chart, folder)
    row = CHARTS[arguments.chart]
    chart = importlib.import_module(f"bearing_twin.charts.{row.module}")
    if row.made == "sheets":
        return _sheets(chart, arguments, folder)
    if row.made == "contest":
        return _contest(chart, arguments, folder)
    return _chart(chart, row.made, arguments, folder)


def _list() -> Outcome:
    """What charts there are, with the time that they take."""
    from bearing_twin.command.terminal import show_rows

    rows = [(name, chart.shows, chart.seconds) for name, chart in CHARTS.items()]
    keys = "chart", "shows", "about_s"

    def show():
        show_rows(("chart", "shows", "about"), ((*row[:2], f"{row[2]:.0f} s") for row in rows))

    return Outcome({"charts": [dict(zip(keys, row, strict=True)) for row in rows]}, [], show)


def _chart(chart, made, arguments, folder) -> Outcome:
    """One picture with its table, of points that are measured."""
    from bearing_twin.charts.table import columns_of, write_table
    from bearing_twin.command.terminal import say, show_text

    points = list(chart.measure(say=say) if made == "told" else chart.measure())
    picture, table = folder / f"{arguments.chart}.png", folder / f"{arguments.chart}.csv"
    chart.draw(points, picture)
    write_table(points, table)
    sentences = list(chart.reading(points))

    def show():
        pictures = [one for one in (picture, picture.with_suffix(".gif")) if one.is_file()]
        show_text("\n".join([*sentences, *(f"picture: {one}" for one in pictures), f"table:   {table}"]))

    names = columns_of(type(points[0]))
    rows = [{name: getattr(point, name) for name in names} for point in points]
    return Outcome({"points": rows, "reading": sentences, "picture": str(picture), "table": str(table)}, [], show)


def _contest(chart, arguments, folder) -> Outcome:
    """A contest: its rows, pictures, tables, and the sentences that read them; or one cell of a map."""
    from bearing_twin.charts.contest import LIMIT, Asked, processors
    from bearing_twin.command.terminal import progress, show_result, show_text

    chart = getattr(chart, "CONTESTS", {}).get(arguments.chart, chart)
    limit = arguments.limit or LIMIT
    if arguments.cell is not None:
        row = dataclasses.asdict(chart.one_cell(arguments.cell, limit))
        return Outcome(row, [], lambda: show_result(row))
    problems = _problems(arguments.problem, chart.problems)
    kept = _kept(arguments.chart, folder)
    with progress(f"chart {arguments.chart}") as update:
        workers = min(arguments.workers or processors(), processors())
        made = chart.make(folder, arguments.chart, Asked(tuple(problems), update, workers, limit, kept))
    kept.drop()

    def show():
        show_text("\n".join([*made.reading, *(f"picture: {one}" for one in made.pictures)]))
        show_text("\n".join(f"table:   {one}" for one in made.tables))

    return Outcome(made._asdict() | {"rows": [dataclasses.asdict(row) for row in made.rows]}, [], show)


def sentences_in(folder: Path, name: str) -> list[str]:
    """What the tables of a chart say that are in the folder.

    Raises OSError where there are none, LookupError, TypeError or ValueError where they are not whole.
    """
    from bearing_twin.charts.table import read_table

    chart = importlib.import_module(f"bearing_twin.charts.{CHARTS[name].module}")
    if CHARTS[name].made == "contest":
        return getattr(chart, "CONTESTS", {}).get(name, chart).read(folder, name)
    return list(chart.reading(read_table(folder / f"{name}.csv", chart.POINT)))


def _read(name, folder) -> Outcome:
    """The sentences of a chart from tables that are there."""
    from bearing_twin.command.terminal import show_text

    try:
        sentences = sentences_in(folder, name)
    except (OSError, ValueError, TypeError, LookupError) as error:
        raise BearingTwinError(
            f"{folder} has no whole tables of the chart {name} ({error}); make them without --read"
        ) from error
    return Outcome({"reading": sentences}, [], lambda: show_text("\n".join(sentences)))


def _kept(name, folder):
    """What an interrupted chart had finished, from beside its pictures."""
    from bearing_twin.charts.contest import Kept
    from bearing_twin.command.terminal import say

    kept = Kept(folder / f"{name}.unfinished")
    if kept.answers:
        say(f"{len(kept.answers)} runs were finished before and are not repeated")
    return kept


def _sheets(chart, arguments, folder) -> Outcome:
    """Every sheet that is wanted as a picture and a table, with what it says."""
    from bearing_twin.charts.sheets import Written
    from bearing_twin.command.terminal import progress, show_text

    sheets, written = chart.SHEETS, []
    names, kept = sheets.wanted(arguments.only or ()), _kept(arguments.chart, folder)
    for name in names:
        before = kept.answers.get(name)
        if before is None or not all(Path(one).is_file() for one in before[1:3]):
            with progress(f"sheet {name}") as update:
                kept.put(name, list(sheets.write(name, folder, update)))
        written.append(Written(*kept.answers[name]))
    kept.drop()

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
