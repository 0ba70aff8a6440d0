"""Whole logs with checksums that fit, whose contents mean ill: read, or refused; nothing moves the cursor."""

import copy
import dataclasses
import functools
import json
import math
import operator
import os
import random
import struct

import pytest
from foreign_writers import serialise
from mcap.reader import make_reader
from mcap.writer import Writer

from bearing_twin.base.errors import LogError
from bearing_twin.command.cli import main
from bearing_twin.log import cdr
from bearing_twin.log.run_log import write_log
from bearing_twin.log.study_log import read_study, write_study
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study

ESCAPE = "\x1b[2J\u202e"
HALF = "half \ud800"  # a character that UTF-8 cannot hold, but JSON
DEEP = "[" * 100_000
RUN, SCENE, RECORDING, STUDY = "bearing_twin_run", "bearing_twin", "bearing_twin_recording", "bearing_twin_study"
METADATA = [  # record, key, text
    *((RUN, "report", text) for text in (DEEP, "[]", '{"compute_s": "x"}', '{"costs": {"a": 1e999}}')),
    (RUN, "report", json.dumps({"costs": {"steps": 10**400}})),
    (RUN, "report", json.dumps({"costs": {ESCAPE: 1}})),
    (SCENE, "warnings", DEEP),
    *((SCENE, "warnings", json.dumps([one])) for one in (ESCAPE, HALF)),
    (RUN, "report", json.dumps({"status": HALF, "costs": {HALF: 1}, "failure": HALF})),
    (RUN, "report", json.dumps({"failure_at_s": 1.0, "status": "failed: x", "failure": HALF, "failure_reason": HALF})),
    *((STUDY, key, json.dumps([HALF])) for key in ("reasons", "doubts")),
    *((RECORDING, "messages_lost", text) for text in ("9" * 5000, "\u00b2", ESCAPE)),
    (RECORDING, "uncounted", ESCAPE),
    *((STUDY, key, text) for key, text in (("study", DEEP), ("study", "{}"), ("reasons", "3"), ("doubts", "x"))),
    (STUDY, "samples", ESCAPE),
    (RUN, "work", DEEP),
]
SUMMARIES = (
    DEEP,
    "[]",
    json.dumps({"quantities": {ESCAPE: None}}),
    json.dumps({HALF: HALF}),
    "\x00",
)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """A log of a run and one of a study, short ones: each test writes one again and reads it four times."""
    folder = tmp_path_factory.mktemp("logs")
    few = ["run.output_rate=5e5", "run.publish_rate=5e5"]
    write_log(simulate(load_scene("two_spheres", few)), folder / "run.mcap")
    few = ["sweep=", "histories=[]", "samples=250"]
    write_study(run_study(load_study("spheres_alpha_4e-5", few)), folder / "study.mcap")
    return folder


def rewritten(source, out, metadata=None, topic=str, data=lambda name, content: content):
    """The log again, with other metadata records, names of topics and messages."""
    with source.open("rb") as file, out.open("wb") as written:
        reader, writer, numbers = make_reader(file), Writer(written), {}
        writer.start("ros2")
        for schema, channel, message in reader.iter_messages():
            if channel.topic not in numbers:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                fields = topic(channel.topic), channel.message_encoding, number, channel.metadata
                numbers[channel.topic] = writer.register_channel(*fields)
            content = data(channel.topic, message.data)
            writer.add_message(numbers[channel.topic], message.log_time, content, message.publish_time)
        records = {one.name: dict(one.metadata) for one in reader.iter_metadata()}
        for name, one in (metadata or (lambda records: records))(records).items():
            writer.add_metadata(name, one)
        writer.finish()
    return out


def reported(path, tmp_path, capsys):
    """Reads it with every command that can; what they say holds nothing that a terminal obeys."""
    for arguments in (["report"], ["report", "--json"], ["verify"], ["view", "--out", str(tmp_path / "page.html")]):
        code = main([arguments[0], str(path), *arguments[1:]])
        out, err = capsys.readouterr()
        assert code in (0, 2)
        assert code == 0 or err.startswith("bearing_twin: ")
        assert not {"\x1b", "\u202e"} & {*out, *err}


@pytest.mark.parametrize(("record", "key", "text"), METADATA)
def test_records_of_a_log_are_anybodys(record, key, text, logs, tmp_path, capsys):
    source = logs / ("study.mcap" if record == STUDY or key == "work" else "run.mcap")
    changed = lambda records: records | {record: records.get(record, {}) | {key: text}}  # noqa: E731
    path = rewritten(source, tmp_path / "x.mcap", changed)
    reported(path, tmp_path, capsys)


SWAPPED = {"normal_load": "displacement", "displacement": "normal_load"}


@pytest.mark.parametrize("change", [SWAPPED, *({name: "x"} for name in ("approach", *SWAPPED, "velocity"))])
def test_samples_that_are_none_of_the_scene_beside_them_are_anybodys(change, logs, tmp_path, capsys):
    """A recording may hold the scene of one node and the samples of another, with more balls or other channels."""

    def renamed(topic, data):
        if not topic.endswith("/samples"):
            return data
        block = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        names = [change.get(name, name) for name in block.channel_name]
        return serialise(cdr.SAMPLE_BLOCK, dataclasses.replace(block, channel_name=names))

    reported(rewritten(logs / "run.mcap", tmp_path / "x.mcap", data=renamed), tmp_path, capsys)


def with_summary(source, out, text):
    """The log of a study again, with this text as its summary."""
    content = b"\0\1\0\0" + struct.pack("<I", len(text.encode()) + 1) + text.encode() + b"\0"
    return rewritten(source, out, data=lambda name, original: content if name.endswith("summary") else original)


@pytest.mark.parametrize("text", SUMMARIES)
def test_the_summary_of_a_study_is_anybodys(text, logs, tmp_path, capsys):
    reported(with_summary(logs / "study.mcap", tmp_path / "x.mcap", text), tmp_path, capsys)


def paths_in(data, path=()):
    """The keys that lead to each part of plain data."""
    yield path
    if isinstance(data, (dict, list)):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from paths_in(value, (*path, key))


OTHERS = (None, [], {}, ESCAPE, "</script>", -1, 0, 1e308, math.nan, True, [1.0], {"a": 1})


def test_a_summary_that_is_wrong_anywhere_is_refused_or_shown_to_the_end(logs, tmp_path, capsys):
    summary, chance = read_study(logs / "study.mcap").as_dict(), random.Random(46)
    for number, keys in enumerate(chance.sample([*paths_in(summary)][1:], 8)):
        changed = copy.deepcopy(summary)
        functools.reduce(operator.getitem, keys[:-1], changed)[keys[-1]] = chance.choice(OTHERS)
        path = with_summary(logs / "study.mcap", tmp_path / f"{number}.mcap", json.dumps(changed))
        reported(path, tmp_path, capsys)
        if not number % 6:  # which takes a second
            assert main(["report", str(path), "--plot", str(tmp_path / f"{number}.png")]) in (0, 2)


@pytest.mark.parametrize("change", [{"samples": 1}, {"quantities": {}}])
def test_the_summary_of_another_study_is_refused(change, logs, tmp_path):
    summary = read_study(logs / "study.mcap").as_dict() | change
    path = with_summary(logs / "study.mcap", tmp_path / "x.mcap", json.dumps(summary))
    with pytest.raises(LogError, match="its summary is that of another study"):
        read_study(path)


def test_names_of_topics_are_anybodys(logs, tmp_path, capsys):
    reported(rewritten(logs / "run.mcap", tmp_path / "x.mcap", topic=lambda name: name + ESCAPE), tmp_path, capsys)
    several = rewritten(logs / "run.mcap", tmp_path / "y.mcap", topic=lambda name: name.replace("records/", ESCAPE))
    reported(several, tmp_path, capsys)


def test_a_log_whose_name_is_no_utf_8_is_told_of_recovered_and_shown(logs, tmp_path, capsys, run_cli):
    """File systems take any bytes as a name; Python shows those that are no text as half characters."""
    source = tmp_path / os.fsdecode(b"half \xff.mcap")
    source.write_bytes((logs / "run.mcap").read_bytes()[:-200])
    complete = tmp_path / os.fsdecode(b"whole \xff.mcap")
    assert main(["recover", str(source), str(complete)]) == 0
    source.write_bytes(source.read_bytes()[:2000])
    assert "half \\udcff.mcap at byte" in " ".join(
        run_cli("recover", source, tmp_path / "nothing.mcap", code=2).err.split()
    )
    reported(complete, tmp_path, capsys)
    reported(source, tmp_path, capsys)
