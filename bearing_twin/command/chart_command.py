"""The subcommand `chart`: pictures that compare methods, or repeat a paper's. Imports are late, so --help is quick."""

import argparse
import dataclasses
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.units import Limits
from bearing_twin.command.outcome import Outcome, Subcommand, quantity, refuse_existing
from bearing_twin.command.terminal import progress, say, show_rows, show_text

ALL = "all"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `chart` to its parser."""
    text = f"its name; --list says what each shows and how long it takes; {ALL}: every one of them"
    parser.add_argument("chart", nargs="?", metavar="CHART", help=text)
    parser.add_argument("--list", action="store_true", help="what each chart compares, and about how long it takes")
    parser.add_argument("--out", default=".", metavar="FOLDER", help="where the pictures and the tables go")
    text = "only this problem, or this sheet or figure of a paper; may be repeated"
    parser.add_argument("--problem", "--only", action="append", metavar="NAME", help=text)
    parser.add_argument("--quick", action="store_true", help="a small part of each problem, as a trial")
    text = "CPU seconds after which a run is stopped; 60 unless given"
    parser.add_argument("--limit", type=quantity("s", Limits(above=0.0)), metavar="SECONDS", help=text)


def _run(arguments: argparse.Namespace) -> Outcome:
    """Make one chart, or all; raises BearingTwinError for a folder or a name that cannot be used."""
    from bearing_twin.charts import CHARTS, chart_of
    from bearing_twin.charts.contest import LIMIT, Options

    if arguments.list:
        return _list()
    if arguments.chart is None:
        raise BearingTwinError(f"name a chart, or {ALL}; bearing_twin chart --list says which there are")
    if arguments.chart not in (*CHARTS, ALL):
        _refuse(arguments.chart)
    folder = Path(arguments.out)
    if not folder.is_dir():
        raise BearingTwinError(f"{folder} is not a folder; make it first, or give another one")
    if arguments.chart == ALL and arguments.problem:
        raise BearingTwinError("--problem goes with one chart; name it in the place of all")
    options = Options(tuple(arguments.problem or ()), limit=arguments.limit or LIMIT, quick=arguments.quick)
    names = CHARTS if arguments.chart == ALL else (arguments.chart,)
    for name in names:
        for path in chart_of(name).files(folder, name, options):
            refuse_existing(path)
    return _make_all(folder, options) if arguments.chart == ALL else _make(arguments.chart, folder, options)


CHART = Subcommand(
    "charts of accuracy against cost of models and methods, of where they fail, and of the three papers",
    _add_arguments,
    _run,
    ("bearing_twin chart --list", "bearing_twin chart laws --out charts", "bearing_twin chart steppers --quick"),
)


def _refuse(name: str) -> None:
    from bearing_twin.base.errors import echo, legal_hint
    from bearing_twin.charts import CHARTS, RENAMED

    if name in RENAMED:
        raise BearingTwinError(f"the chart {name} was removed: use chart {RENAMED[name]}")
    raise BearingTwinError(f"{echo(name)} is not a chart; {legal_hint(name, [*CHARTS, ALL])}")


def _list() -> Outcome:
    from bearing_twin.charts import CHARTS

    rows = [(name, chart.shows, chart.seconds) for name, chart in CHARTS.items()]
    keys = "chart", "shows", "about_s"

    def show():
        show_rows(("chart", "shows", "about"), ((*row[:2], f"{row[2]:.0f} s") for row in rows))

    return Outcome({"charts": [dict(zip(keys, row, strict=True)) for row in rows]}, [], show)


def _make(name: str, folder: Path, options) -> Outcome:
    """One chart: rows, pictures, tables, and the sentences that read it."""
    from bearing_twin.charts import chart_of

    with progress(f"chart {name}") as update:
        files = chart_of(name).make(folder, name, options._replace(update=update))

    def show():
        show_text("\n".join([*files.reading, *(f"picture: {path}" for path in files.pictures)]))
        show_text("\n".join(f"table:   {path}" for path in files.tables))

    return Outcome(files._asdict() | {"rows": [dataclasses.asdict(row) for row in files.rows]}, [], show)


def _make_all(folder: Path, options) -> Outcome:
    """Every chart, one after the other."""
    from bearing_twin.charts import CHARTS

    for name, chart in CHARTS.items():
        say(f"chart {name}, about {chart.seconds:.0f} s")
        _make(name, folder, options)
    return Outcome({"charts": [*CHARTS]}, [], lambda: show_text("\n".join(CHARTS)))
