"""The subcommand `export`: a log as CSV, Parquet or NetCDF. Imports are late, so that --help is quick."""

import argparse
import math

from bearing_twin.command.outcome import Outcome, cleared

HELP = "a log of a run or a study as tables (CSV, Parquet) or as a data set (NetCDF), units and axes named"
EXAMPLES = (
    "bearing_twin export run.mcap --to csv --out run_tables",
    "bearing_twin export run.mcap --to netcdf --out run.nc",
    "bearing_twin export study.mcap --to parquet --out study.parquet",
)
WORDS = ("csv", "parquet", "netcdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `export` to its parser."""
    parser.add_argument("log", metavar="LOG", help="an MCAP log of a run or a study")
    parser.add_argument("--to", required=True, choices=WORDS, help="csv needs nothing, the others the extra export")
    parser.add_argument(
        "--out",
        required=True,
        metavar="PATH",
        help="of netcdf a file; of csv and parquet a folder with a file for each group of channels, or, where there is "
        "but one group, a file with that ending",
    )
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")


def run(arguments: argparse.Namespace) -> Outcome:
    """Writes the files; what is missing from the log is a doubt. Raises BearingTwinError."""
    from bearing_twin.command.terminal import with_progress
    from bearing_twin.log.export import export_log

    def watch(blocks, stream):
        duration = stream.scene.parameters.run.duration if stream.scene else math.inf
        return with_progress(blocks, duration or math.inf, f"exporting {arguments.log}")

    cleared(arguments.out, arguments.log)
    exported = export_log(arguments.log, arguments.to, arguments.out, arguments.topic, watch)
    result = {"log": arguments.log, "to": arguments.to, "rows": exported.rows, "files": list(exported.files)}
    doubts = [*exported.notes, *([f"{exported.missing} outputs are missing from the log"] if exported.missing else [])]
    doubts += [exported.cut_short.told()] if exported.cut_short else []
    if exported.runs > 1:
        again = "time and sequence begin again within the files"
        doubts.append(f"the log holds {exported.runs} runs, as the node was reset or started again: {again}")
    return Outcome(result | {"missing_outputs": exported.missing}, doubts)
