"""Logs and studies out of the house: the same bits in CSV, Parquet and NetCDF, named axes, units, what is missing."""

import csv
import json
import shutil
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from runs import made_up_run

from bearing_twin import export_log, load_scene, read_log, read_study, simulate, write_log
from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.sample import join_blocks
from bearing_twin.command import cli
from bearing_twin.log.export import FORMATS, groups_of
from bearing_twin.run.dataset import axes_of

ENDINGS = {"csv": ".csv", "parquet": ".parquet"}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "run.mcap"
    write_log(simulate(load_scene("bearing_6203", ["run.duration=0.02"])), path)
    return path


@pytest.fixture(scope="module")
def impact(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "impact.mcap"
    write_log(simulate(load_scene("sphere_on_beam", ["run.duration=2e-4", "run.output_rate=1e6"])), path)
    return path


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "study.mcap"
    options = ["--samples", "64", "--set", "modality=no", "--set", "sweep="]
    assert cli.main(["study", "spheres_alpha_4e-5", *options, "--out", str(path)]) == cli.DONE
    return path


def test_outputs_that_are_missing_from_a_log_are_told(log, tmp_path, run_cli):
    block = join_blocks(list(read_log(log).blocks()))
    block.values["drive_torque"][-1] = np.nan
    write_log(made_up_run(load_scene("bearing_6203"), [block.part(0, 5), block.part(9, 21)]), tmp_path / "gap.mcap")
    arguments = ["export", str(tmp_path / "gap.mcap"), "--to", "csv", "--out", str(tmp_path / "out"), "--json"]
    reported = run_cli(*arguments, "--strict", code=cli.DOUBTFUL)
    assert (json.loads(reported.out)["rows"], json.loads(reported.out)["missing_outputs"]) == (17, 4)
    assert "4 outputs are missing from the log" in reported.err
    columns = columns_in(tmp_path / "out" / "outputs.csv", "csv")
    assert list(map(int, columns["sequence"])) == [*range(5), *range(9, 21)]
    assert [cell == "" for cell in columns["drive_torque"]] == [False] * 16 + [True]


def same_bits(values, expected):
    """Equal to the bit, signs of zeros too; any NaN is as good as another."""
    values, expected = (np.ascontiguousarray(array, float).ravel() for array in (values, expected))
    assert values.shape == expected.shape
    assert np.array_equal(np.isnan(values), np.isnan(expected))
    known = ~np.isnan(expected)
    assert np.array_equal(values[known].view(np.int64), expected[known].view(np.int64))


@cache
def blocks_of(path):
    """All blocks of a log, read once."""
    return tuple(read_log(path).blocks())


def channel(path, name):
    return np.concatenate([block.values[name] for block in blocks_of(path)])


def columns_in(path, to):
    """{column: values} of a file that was written."""
    if to == "parquet":
        return {name: column.to_pylist() for name, column in zip(*_arrow(path), strict=True)}
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: [row[index] for row in rows] for index, name in enumerate(header)}


def _arrow(path):
    import pyarrow.parquet  # here, as pandas and xarray below: all that collects tests would import it, 0.8 s

    table = pyarrow.parquet.read_table(path)
    return table.column_names, table.columns


def numbers(cells):
    return np.array([np.nan if cell == "" else float(cell) for cell in cells])


@pytest.mark.parametrize("to", ["csv", "parquet"])
@pytest.mark.parametrize("source", ["log", "impact"])
def test_tables_hold_every_number_to_the_bit(to, source, tmp_path, request):
    path = request.getfixturevalue(source)
    out = tmp_path / "tables"
    exported = export_log(path, to, out)
    stream, reported = read_log(path), set()
    times = np.concatenate([block.time_ns for block in stream.blocks()])
    assert exported.rows == len(times)
    for group in groups_of(stream):
        columns = columns_in(out / f"{group.stem}{ENDINGS[to]}", to)
        for name, _, _ in group.columns:
            reported.add(name)
            if group.stem.startswith("record_"):
                table = group.stem.removeprefix("record_")
                parts = [block.records.get(table, ()) for block in blocks_of(path)]
                rows = np.concatenate([np.empty((0, len(group.columns))), *filter(len, parts)])
                same_bits(numbers(columns[name]), rows[:, [heading for heading, _, _ in group.columns].index(name)])
            else:
                same_bits(numbers(columns[name]), channel(path, name))
        if group.axes:
            positions = int(np.prod([len(axis.labels) for axis in group.axes]))
            assert list(map(int, columns["time_ns"])) == np.repeat(times, positions).tolist()
            last = group.axes[-1]
            assert list(map(str, columns[last.name][: len(last.labels)])) == list(map(str, last.labels))
    assert reported >= {channel.name for channel in stream.channels}
    described = columns_in(out / "channels.csv", "csv")
    assert dict(zip(described["column"], described["unit"], strict=True))["normal_load"] == "N"
    assert sorted(map(str, out.iterdir())) == sorted(exported.files)


@pytest.mark.parametrize("source", ["log", "impact"])
def test_a_data_set_holds_every_number_with_units_and_named_axes(source, tmp_path, request):
    import xarray

    path = request.getfixturevalue(source)
    export_log(path, "netcdf", tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as stored:
        read = stored.load()
    computed = simulate(load_scene(read_log(path).scene.resolved())).to_xarray()
    for dataset in (read, computed):
        for name, unit, _, meaning, *_ in read_log(path).channels:
            same_bits(dataset[name], channel(path, name))
            assert dataset[name].attrs == {"units": unit, "long_name": meaning}
            assert dataset[name].dims[0] == "time"
    assert read.time.attrs["units"] == "s"
    assert json.loads(read.attrs["report"])["status"] == read_log(path).report["status"]


def test_axes_are_called_by_what_stands_along_them(log):
    dataset = read_log(log).to_xarray()
    assert dataset.point.dims == ("time", "ball", "contact", "axis")
    assert dataset.orientation.dims == ("time", "ball", "quaternion")
    assert dataset.inner_ring_tilt.dims == ("time", "about")
    loads = dataset.normal_load.sel(contact="outer race", ball=3)
    same_bits(loads, channel(log, "normal_load")[:, 3, 1])
    assert dataset.position.sel(axis="z").shape == (21, 8)


def test_three_balls_are_no_axes_of_space():
    scene = load_scene("bearing_6203", ["geometry.balls=3"])
    named = {row.name: tuple(axis.name for axis in axes_of(row, "bearing")) for row in scene.channels}
    assert named["normal_load"] == ("ball", "contact")
    assert named["roll_rate"] == ("ball",)
    assert named["position"] == ("ball", "axis")
    assert named["inner_ring_offset"] == ("axis",)


@pytest.mark.parametrize("to", ["csv", "parquet", "netcdf"])
def test_the_realisations_of_a_study_come_out_too(to, study, tmp_path):
    out = tmp_path / f"study{ENDINGS.get(to, '.nc')}"  # one file suffices
    result = read_study(study)
    assert export_log(study, to, out).rows == 64
    frame = result.to_dataframe()
    assert frame.index.name == "realisation"
    assert frame.attrs["units"]["contact_duration"] == "s"
    if to == "netcdf":
        import xarray

        with xarray.open_dataset(out, engine="h5netcdf") as stored:
            columns = {name: stored[name].to_numpy() for name in frame.columns}
            assert stored["peak_force"].attrs["units"] == "N"
            assert stored["peak_force"].attrs["long_name"].startswith("contact force")
    else:
        columns = columns_in(out, to)
    for name in (*(variable.key for variable in result.study.inputs), *result.study.quantities):
        same_bits(numbers(columns[name]), frame[name])
    same_bits(frame["peak_force"], result.sample("peak_force"))
    assert set(frame["failed"]) == {""}


def test_the_command_writes_and_refuses(log, tmp_path, run_json, refused):
    out = tmp_path / "run.nc"
    arguments = ["export", str(log), "--to", "netcdf", "--out", str(out)]
    assert run_json(*arguments)["rows"] == 21
    for further, sentence in (
        (arguments, "exists and is not overwritten"),
        (["export", str(log), "--to", "csv", "--out", str(tmp_path / "no" / "x")], "is not a folder"),
        (["export", str(log), "--to", "csv", "--out", str(tmp_path / "one.csv")], "give a folder"),
        (["export", "none.mcap", "--to", "csv", "--out", str(tmp_path / "x")], "there is no log"),
    ):
        assert sentence in refused(*further)
    assert sorted(tmp_path.iterdir()) == [out]
    assert all(name in refused("export", log, "--to", "nothing", "--out", out) for name in FORMATS)


def test_a_damaged_log_says_what_can_be_saved_and_leaves_nothing(log, tmp_path, refused, run_cli):
    path, data = tmp_path / "damaged.mcap", bytearray(log.read_bytes())
    path.write_bytes(data[: int(0.8 * len(data))])
    arguments = ["export", str(path), "--to", "csv", "--out", str(tmp_path / "x")]
    assert "has no end" in run_cli(*arguments, "--strict", code=cli.DOUBTFUL).err
    shutil.rmtree(tmp_path / "x")
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert "is damaged at byte" in refused(*arguments)
    assert list(tmp_path.iterdir()) == [path]


def test_what_breaks_in_the_middle_leaves_nothing(log, tmp_path):
    def breaks(blocks, stream):
        yield next(iter(blocks))
        raise LogError("the middle")

    for to, name in (("csv", "tables"), ("parquet", "tables"), ("netcdf", "run.nc")):
        with pytest.raises(LogError, match="the middle"):
            export_log(log, to, tmp_path / name, watch=breaks)
        assert list(tmp_path.iterdir()) == []


FULL = """
import resource, sys
from bearing_twin.command.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
log, out, *formats = sys.argv[1:]
print(*(main(["export", log, "--to", to, "--out", f"{out}_{to}"]) for to in formats))
"""


@pytest.mark.environment
def test_a_full_disk_is_told_in_a_sentence_and_leaves_nothing(log, tmp_path):
    """In a process of its own, which HDF5 would end."""
    command = [sys.executable, "-B", "-c", FULL, str(log), str(tmp_path / "out"), *FORMATS]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout.split() == [str(cli.BAD_INPUT)] * len(FORMATS)
    for to in FORMATS:
        assert f"bearing_twin: {tmp_path / 'out'}_{to} cannot be written (" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("to", "module"), [("parquet", "pyarrow"), ("netcdf", "xarray"), ("netcdf", "h5netcdf")])
def test_a_missing_package_is_named_with_the_extra_that_brings_it(to, module, log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BearingTwinError, match=rf"the package {module}; install it with: pip install '.\[exp"):
        export_log(log, to, tmp_path / "x")
    assert list(tmp_path.iterdir()) == []


def test_csv_needs_nothing(log, tmp_path, monkeypatch):
    for module in ("pandas", "pyarrow", "xarray", "h5netcdf"):
        monkeypatch.setitem(sys.modules, module, None)
    assert export_log(log, "csv", tmp_path / "tables").rows == 21
