"""Export of logs to CSV, Parquet and NetCDF, with named axes and units, bit for bit.

CSV and Parquet have a file for each group of channels with the same axes, and a row for each output and position along
the axes; `channels.csv` describes the columns. NetCDF has everything in one file.
"""

import contextlib
import csv
import io
import itertools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import LogError, echo, import_optional, legal_hint
from bearing_twin.base.paths import file_name, replace_file
from bearing_twin.log.bag import path_of
from bearing_twin.log.run_log import LogStream, read_log
from bearing_twin.log.study_log import STUDY_RECORD, read_study
from bearing_twin.run.dataset import ChannelAxis, axes_of, dataset_of, source_of

OUTPUTS, SAMPLES, CHANNELS, RECORD = "outputs", "realisations", "channels.csv", "record_"
TIMES = ("sequence", "time_ns", "time")  # number of the output, exact time [ns], time [s]


class Group(NamedTuple):
    """A file to be: its stem, the axes that its columns share, its columns as (name, unit, meaning)."""

    stem: str
    axes: tuple[ChannelAxis, ...]
    columns: tuple[tuple[str, str, str], ...]


class Exported(NamedTuple):
    """Files written, the number of outputs or realisations in them, and missing parts of the log, a sentence each."""

    files: tuple[str, ...]
    rows: int
    missing: int = 0  # outputs
    warnings: tuple[str, ...] = ()


def export_log(
    log: Any, to: str, out: str | PathLike, topic: str | None = None, watch: Callable = lambda blocks, stream: blocks
) -> Exported:
    """Writes the log of a run or a study as tables or a data set.

    Parameters
    ----------
    log : str, path or LogStream
        The log, or what `read_log` gave of it: the same run, topic and samples; outputs may be missing in it.
    to : str
        "csv" or "parquet", a folder of tables, or "netcdf", one file; columns and attributes name the SI units.
    out : str or path
        The folder or the file, which must not exist.
    topic : str, optional
        The topic of the samples, where there are several.
    watch : function
        Called with (blocks, stream); gives the blocks that are written.

    Returns
    -------
    Exported
        The files that were written.

    Raises
    ------
    LogError
        For a damaged log, saying what `recover` would save, and a path that cannot be written. What was begun is
        removed.
    BearingTwinError
        Where a package of the extra `export` is missing.
    """
    if to not in FORMATS:
        raise LogError(f"a log cannot be written as {echo(to)}; {legal_hint(to, FORMATS)}")
    target = path_of(out, "what is exported")
    if target.exists():
        raise LogError(f"{target} exists and is not overwritten; give another path")
    if not target.absolute().parent.is_dir():
        raise LogError(f"{target.absolute().parent} is not a folder; make it first, or give another path")
    write = FORMATS[to]
    run = None
    if isinstance(log, LogStream):
        log, topic, run = log.path, topic or log.topic, log.run
    stream = read_log(log, allow_gaps=True, topic=topic, run=run)
    if STUDY_RECORD in stream.metadata:
        stream = read_study(log)
    created: list[Path] = []
    try:
        written = write(stream, target, created, watch)
        if isinstance(stream, LogStream):
            written = written._replace(missing=stream.missing, warnings=tuple(stream.warnings))
        return written
    except BaseException as error:
        for path in reversed(created):
            with contextlib.suppress(OSError):
                path.rmdir() if path.is_dir() else path.unlink()
        if isinstance(error, OSError):
            raise LogError(f"{target} cannot be written ({error.strerror or error}); give another path") from error
        raise


def groups_of(stream) -> list[Group]:
    """The groups of a run's channels, those of single numbers first, then the tables of its records."""
    kind = None if stream.scene is None else stream.scene.kind
    columns_by_axes: dict[tuple[ChannelAxis, ...], list] = {}
    for channel in stream.channels:
        columns_by_axes.setdefault(axes_of(channel, kind), []).append((channel.name, channel.unit, channel.meaning))
    groups = [
        Group(file_name("_".join(axis.name for axis in axes)) if axes else OUTPUTS, axes, tuple(columns))
        for axes, columns in columns_by_axes.items()
    ]
    tables = [
        Group(f"{RECORD}{table.name}", (), tuple((row.name, row.unit, row.meaning) for row in table.columns))
        for table in stream.tables
    ]
    return sorted(groups, key=lambda group: len(group.axes)) + tables


def _columns(group: Group, block) -> dict[str, np.ndarray]:
    """The columns that a block adds to the file of a group, by name: times, labels, values."""
    names = [name for name, _, _ in group.columns]
    if group.stem.startswith(RECORD):
        rows = block.records.get(group.stem.removeprefix(RECORD), np.zeros((0, len(names))))
        return dict(zip(names, np.asarray(rows).T, strict=True))
    sequence = np.arange(block.first_sequence, block.first_sequence + len(block))
    labels = list(zip(*itertools.product(*(axis.labels for axis in group.axes)), strict=True))
    repeats = len(labels[0]) if labels else 1
    columns = {
        name: np.repeat(column, repeats)
        for name, column in zip(TIMES, (sequence, block.time_ns, 1e-9 * block.time_ns), strict=True)
    }
    columns |= {axis.name: np.tile(column, len(block)) for axis, column in zip(group.axes, labels, strict=True)}
    return columns | {name: np.reshape(block.values[name], -1) for name in names}


def _write_grouped(stream, target: Path, created: list[Path], watch, writer, suffix: str) -> Exported:
    """One file a group in a folder, or the only one at a path that ends with `suffix`."""
    if hasattr(stream, "study"):
        groups, source = [Group(SAMPLES, (), tuple(column[:3] for column in stream.table()))], {}
        pieces = iter([(len(stream.status), [stream.columns()])])
    else:
        groups, source = groups_of(stream), source_of(stream)
        blocks = watch(stream.blocks(), stream)
        pieces = ((len(block), [_columns(group, block) for group in groups]) for block in blocks)
    alone = target.suffix == suffix
    if alone and len(groups) > 1:
        stems = ", ".join(group.stem for group in groups)
        raise LogError(f"{target}: the log has channels of {len(groups)} kinds ({stems}), one file each; give a folder")
    if not alone:
        target.mkdir()
        created.append(target)
    paths = [target if alone else target / f"{group.stem}{suffix}" for group in groups]
    created += paths
    rows = 0
    with contextlib.ExitStack() as stack:
        adders = [
            stack.enter_context(writer(path, {name: unit for name, unit, _ in group.columns}, source))
            for path, group in zip(paths, groups, strict=True)
        ]
        for count, columns in pieces:
            rows += count
            for add, block_columns in zip(adders, columns, strict=True):
                add(block_columns)
    files = paths if alone else [*paths, _about(target / CHANNELS, groups, suffix, created)]
    return Exported(tuple(map(str, files)), rows)


def _about(path: Path, groups: Iterable[Group], suffix: str, created: list[Path]) -> Path:
    created.append(path)
    with open(path, "x", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("file", "column", "unit", "axes", "meaning"))
        for group in groups:
            axes = " ".join(axis.name for axis in group.axes)
            table.writerows(
                (f"{group.stem}{suffix}", name, unit, axes, meaning) for name, unit, meaning in group.columns
            )
    return path


@contextlib.contextmanager
def _csv_file(path: Path, units: Mapping, source: Mapping) -> Iterator[Callable]:
    """Numbers as the shortest text that reads back as the same double; NaN as an empty cell."""
    with open(path, "x", newline="", encoding="utf-8") as file:
        table = csv.writer(file)

        def add(columns: Mapping) -> None:
            if not file.tell():
                table.writerow(columns)
            lists = (np.asarray(column).tolist() for column in columns.values())
            cells = (["" if number != number else number for number in numbers] for numbers in lists)
            table.writerows(zip(*cells, strict=True))

        yield add


@contextlib.contextmanager
def _parquet_file(path: Path, units: Mapping, source: Mapping) -> Iterator[Callable]:
    """Units are in the metadata of each field, the source of the numbers in that of the file."""
    arrow, parquet = import_optional("pyarrow", "export"), import_optional("pyarrow.parquet", "export")
    with contextlib.ExitStack() as stack:
        file = None

        def add(columns: Mapping) -> None:
            nonlocal file
            table = arrow.table({name: np.asarray(column) for name, column in columns.items()})
            if file is None:
                fields = [field.with_metadata({"units": units.get(field.name, "")}) for field in table.schema]
                schema = arrow.schema(fields, metadata=dict(source))
                file = stack.enter_context(parquet.ParquetWriter(path, schema))
            file.write_table(table.cast(file.schema))

        yield add


def _netcdf(stream, target, created, watch) -> Exported:
    """One file of NetCDF 4 by h5netcdf; realisations of a study are its variables over `realisation`.

    Made in memory: where a disk is full HDF5 ends the process when it closes the file.
    """
    xarray, h5netcdf = import_optional("xarray", "export"), import_optional("h5netcdf", "export")
    if hasattr(stream, "study"):
        variables = {
            name: ("realisation", np.asarray(values), {"long_name": meaning} | ({"units": unit} if unit else {}))
            for name, unit, meaning, values in stream.table()
        }
        dataset, rows = xarray.Dataset(variables), len(stream.status)
    else:
        dataset = dataset_of(stream, watch(stream.blocks(), stream))
        rows = dataset.sizes["time"]
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        dataset.dump_to_store(xarray.backends.H5NetCDFStore(file))
    replace_file(target, buffer.getbuffer())
    return Exported((os.fspath(target),), rows)


FORMATS = {
    "csv": partial(_write_grouped, writer=_csv_file, suffix=".csv"),
    "parquet": partial(_write_grouped, writer=_parquet_file, suffix=".parquet"),
    "netcdf": _netcdf,
}
