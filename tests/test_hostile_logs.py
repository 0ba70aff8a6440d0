"""Whole logs with checksums that fit, whose contents mean ill: read, or refused; nothing moves the cursor."""

import json
import struct

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from bearing_twin.command.cli import main
from bearing_twin.log.mcap_log import write_log
from bearing_twin.log.study_log import write_study
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study_file import load_study

ESCAPE = "\x1b[2J\u202e"
DEEP = "[" * 100_000
RUN, SCENE, RECORDING, STUDY = "bearing_twin_run", "bearing_twin", "bearing_twin_recording", "bearing_twin_study"
METADATA = [  # record, key, text
    *((RUN, "report", text) for text in (DEEP, "[]", '{"compute_s": "x"}', '{"costs": []}', '{"costs": {"a": 1e999}}')),
    (RUN, "report", json.dumps({"costs": {"steps": 10**400}})),
    (RUN, "report", json.dumps({"costs": {ESCAPE: 1}})),
    *((SCENE, key, DEEP) for key in ("predicted", "warnings")),
    (SCENE, "warnings", json.dumps([ESCAPE])),
    (SCENE, "predicted", json.dumps({"load_error": 10**400})),
    *((RECORDING, "messages_lost", text) for text in ("9" * 5000, "\u00b2", "-1", ESCAPE)),
    (RECORDING, "uncounted", ESCAPE),
    *((STUDY, key, text) for key in ("study", "reasons", "doubts") for text in (DEEP, "3", "{}", "x")),
    (STUDY, "samples", ESCAPE),
    (RUN, "work", DEEP),
]
SUMMARIES = (DEEP, "[]", "{}", '{"samples": {}}', json.dumps({"quantities": {ESCAPE: None}}), "\x00")


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """A log of a run and one of a study."""
    folder = tmp_path_factory.mktemp("logs")
    write_log(simulate(load_scene("two_spheres")), folder / "run.mcap")
    write_study(run_study(load_study("spheres_alpha_4e-5", ["sweep=", "histories=[]"])), folder / "study.mcap")
    return folder


def rewritten(source, out, metadata=None, topic=str, data=lambda name, one: one):
    """The log again, with other metadata records, names of topics and messages."""
    with source.open("rb") as file, out.open("wb") as written:
        reader, writer, numbers = make_reader(file), Writer(written), {}
        writer.start("ros2")
        for schema, channel, message in reader.iter_messages():
            if channel.topic not in numbers:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                given = topic(channel.topic), channel.message_encoding, number, channel.metadata
                numbers[channel.topic] = writer.register_channel(*given)
            content = data(channel.topic, message.data)
            writer.add_message(numbers[channel.topic], message.log_time, content, message.publish_time)
        kept = {one.name: dict(one.metadata) for one in reader.iter_metadata()}
        for name, one in (metadata or (lambda kept: kept))(kept).items():
            writer.add_metadata(name, one)
        writer.finish()
    return out


def told(path, tmp_path, capsys):
    """Reads it with every command that can; what they say holds nothing that a terminal obeys."""
    for words in (["report"], ["report", "--json"], ["verify"], ["view", "--out", str(tmp_path / "page.html")]):
        code = main([words[0], str(path), *words[1:]])
        out, err = capsys.readouterr()
        assert code in (0, 2)
        assert code == 0 or err.startswith("bearing_twin: ")
        assert not {"\x1b", "\u202e"} & {*out, *err}


@pytest.mark.parametrize(("record", "key", "text"), METADATA)
def test_records_of_a_log_are_anybodys(record, key, text, logs, tmp_path, capsys):
    source = logs / ("study.mcap" if record == STUDY or key == "work" else "run.mcap")
    path = rewritten(source, tmp_path / "x.mcap", lambda kept: kept | {record: kept.get(record, {}) | {key: text}})
    told(path, tmp_path, capsys)


@pytest.mark.parametrize("text", SUMMARIES)
def test_the_summary_of_a_study_is_anybodys(text, logs, tmp_path, capsys):
    content = b"\0\1\0\0" + struct.pack("<I", len(text.encode()) + 1) + text.encode() + b"\0"
    path = rewritten(
        logs / "study.mcap", tmp_path / "x.mcap", data=lambda name, one: content if name.endswith("summary") else one
    )
    told(path, tmp_path, capsys)


def test_names_of_topics_are_anybodys(logs, tmp_path, capsys):
    told(rewritten(logs / "run.mcap", tmp_path / "x.mcap", topic=lambda name: name + ESCAPE), tmp_path, capsys)
    several = rewritten(logs / "run.mcap", tmp_path / "y.mcap", topic=lambda name: name.replace("records/", ESCAPE))
    told(several, tmp_path, capsys)
