"""`bearing_twin topics`: the table as it is in docs/topics.md, and of one scene."""

import json
from pathlib import Path

import pytest

from bearing_twin.command.cli import main
from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "topics.md"


def test_the_document_is_what_the_command_writes(capsys, monkeypatch):
    for name in [name for name in KINDS if name not in SHIPPED]:
        monkeypatch.delitem(KINDS, name)  # those of other tests
    assert main(["topics", "--markdown"]) == 0
    assert capsys.readouterr().out in DOCUMENT.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["bearing_6203", "two_spheres", "sphere_on_beam", "ellipsoid_on_plane"])
def test_every_topic_of_a_scene_is_listed_once(name, capsys):
    assert main(["topics", name, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["topics"]
    scene = load_scene(name)
    assert [row["topic"] for row in rows] == [topic.full_name for topic in topics(scene)]
    rates = {row["topic"]: row["rate"] for row in rows}
    assert rates["/tf"] == f"{scene.parameters.run.publish_rate:g} Hz"
    assert {row["qos"] for row in rows if row["rate"] == "once, latched"} == {"reliable, transient local, depth 1"}


def test_the_kinds_list_every_ball_in_one_row(capsys):
    assert main(["topics", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["topics"]
    assert {row["kind"] for row in rows} == set(KINDS)
    balls = [row for row in rows if row["topic"].startswith("ball_")]
    assert [(row["topic"], row["frame"]) for row in balls] == [("ball_<k>/wrench", "ball_<k>")]
    assert main(["topics", "bearing_6203"]) == 0
    assert "/bearing/ball_7/wrench" in capsys.readouterr().out


def test_a_mistake_is_said(capsys):
    assert main(["topics", "bearing_6203", "--markdown"]) == 2
    assert "leave out the scene" in capsys.readouterr().err
