"""Topics: their tables in docs/topics.md and of a scene; robot_description, whose frames and shapes are the bodies'."""

import xml.etree.ElementTree as ElementTree

import pytest

from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.kinds.contract import ONCE, Output
from bearing_twin.kinds.topics import SPHERE, marker, urdf
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

PREFIX = "left/"
SCENES = {
    "bearing": "bearing_6203",
    "shaft": "shaft_two_6203",
    "two_spheres": "two_spheres",
    "two_discs": "two_discs",
    "sphere_on_beam": "sphere_on_beam",
    "ellipsoid_on_plane": "ellipsoid_on_plane",
    "two_bodies": "two_bodies_groove",
    "soft_discs": "soft_discs_mean",
}


def described(scene, prefix=""):
    """The URDF of a scene, parsed."""
    kind = KINDS[scene.kind]
    [row] = [topic for topic in kind.topics(scene.parameters) if topic.name == "robot_description"]
    assert row.rate == ONCE
    text = row.fields(Output(scene.parameters, "", None, prefix))["data"]
    return ElementTree.fromstring(text)


def test_every_kind_is_described_here():
    assert set(SCENES) == set(SHIPPED)


@pytest.mark.parametrize("kind", SCENES)
def test_every_body_is_a_link_below_the_frame_of_the_scene_and_is_placed_by_tf(kind):
    scene = load_scene(SCENES[kind])
    robot, root = described(scene, PREFIX), f"{PREFIX}{KINDS[kind].frame}"
    table = {topic.name: topic for topic in KINDS[kind].topics(scene.parameters)}
    bodies = [f"{PREFIX}{topic.frame}" for name, topic in table.items() if name.endswith("/wrench")]
    assert [link.get("name") for link in robot.findall("link")] == [root, *bodies]
    joints = robot.findall("joint")
    assert [joint.find("child").get("link") for joint in joints] == bodies
    assert {joint.find("parent").get("link") for joint in joints} == {root}
    assert {joint.get("type") for joint in joints} == {"floating"}
    assert len({joint.get("name") for joint in joints}) == len(joints)
    output = Output(scene.parameters, "", Simulation(scene).advance(1).sample_rows(range(1)), PREFIX)
    assert [one["child_frame_id"] for one in table["/tf"].fields(output)["transforms"]] == bodies


def test_numbers_colours_and_places_are_written_in_full():
    sphere = marker("", 0, SPHERE, (2.5e-7,) * 3, (0.1, 0.2, 0.3, 1.0))
    geometry = load_scene("bearing_6203").parameters.geometry
    balls = [float(one.get("radius")) for one in described(load_scene("bearing_6203")).iter("sphere")]
    assert balls == pytest.approx([0.5 * geometry.ball_diameter] * geometry.balls, rel=1e-8)
    visual = ElementTree.fromstring(urdf("base", ["one"], {"one": (sphere,)})).find("link[@name='one']/visual")
    assert float(visual.find("geometry/sphere").get("radius")) == 1.25e-7
    assert visual.find("material/color").get("rgba") == "0.1 0.2 0.3 1"


@pytest.mark.parametrize("name", ["bearing_6203", "ellipsoid_on_plane"])
def test_every_topic_of_a_scene_is_listed_once(name, run_json):
    rows = run_json("topics", name)["topics"]
    scene = load_scene(name)
    assert [row["topic"] for row in rows] == [topic.full_name for topic in topics(scene)]
    rates = {row["topic"]: row["rate"] for row in rows}
    assert rates["/tf"] == f"{scene.parameters.run.publish_rate:g} Hz"
    assert {row["qos"] for row in rows if row["rate"] == "once, latched"} == {"reliable, transient local, depth 1"}


def test_the_kinds_list_every_ball_in_one_row(run_json, run_cli):
    rows = run_json("topics")["topics"]
    assert {row["kind"] for row in rows} == set(KINDS)
    balls = [row for row in rows if row["topic"].startswith("ball_")]
    assert [(row["topic"], row["frame"]) for row in balls] == [("ball_<k>/wrench", "ball_<k>")]
    assert "/bearing/ball_7/wrench" in run_cli("topics", "bearing_6203").out
