"""Layouts for RViz, Foxglove and PlotJuggler: every topic and field in them is one that the scene publishes."""

import json
import math
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import toy_kind  # noqa: F401 - a kind without topics of its own
import yaml
from runs import made_up_block, made_up_run, made_up_scene

from bearing_twin.base.errors import LogError
from bearing_twin.base.paths import share_path
from bearing_twin.base.yaml_files import SCENES
from bearing_twin.command.cli import main
from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.log import cdr
from bearing_twin.log.layouts import LAYOUTS, panels, panels_of_log, rviz
from bearing_twin.log.raw_log import RawLogWriter
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.log.stream import MessageStream, samples_message, topics
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation, simulate

SCENE = load_scene("bearing_6203")


def shipped(kind):
    """The first shipped scene of a kind."""
    return load_scene(next(head["name"] for head in SCENES.headers() if head["kind"] == kind))


@pytest.mark.parametrize("kind", SHIPPED)
def test_every_curve_is_a_number_in_the_messages_of_the_kind(kind):
    scene = shipped(kind)
    shown, table = panels(scene), {topic.full_name: topic for topic in topics(scene)}
    messages = {
        topic.full_name: cdr.deserialise(topic.ros_type, data)
        for topic, _, data in MessageStream(scene).messages(Simulation(scene).advance(1))
    }
    assert shown.frame == KINDS[kind].frame
    assert table[shown.markers].ros_type == "visualization_msgs/msg/MarkerArray"
    assert table[shown.description].ros_type == "std_msgs/msg/String"
    assert shown.plots
    for plot in shown.plots:
        assert re.search(r"\[.+\]", plot.title), plot.title
        for curve in plot.curves:
            assert table[curve.topic].ros_type == curve.ros_type
            value = messages[curve.topic]
            for part in curve.path:
                value = value[part] if isinstance(part, int) else getattr(value, part)
            assert isinstance(value, float)


@pytest.mark.parametrize("program", LAYOUTS)
def test_the_layouts_in_the_package_are_what_the_command_writes(program, tmp_path, run_json):
    """`bearing_twin layouts bearing_6203 --out config/layouts` writes them again."""
    [path] = run_json("layouts", "bearing_6203", "--for", program, "--out", tmp_path)["files"].values()
    name = f"bearing_6203{LAYOUTS[program].suffix}"
    with open(path, "rb") as file:
        assert file.read() == share_path("config", "layouts", name).read_bytes()


def names_in(program, content):
    """(topics, paths of curves as the program writes them) in a layout."""
    if program == "rviz":
        displays = yaml.safe_load(content)["Visualization Manager"]["Displays"]
        named = [name.get("Topic") or name.get("Description Topic") for name in displays]
        return {topic["Value"] for topic in named if topic}, set()
    if program == "foxglove":
        configs = json.loads(content)["configById"]
        paths = {path["value"] for name in configs.values() for path in name.get("paths", ())}
        return set(configs["3D!scene"]["topics"]), paths
    return set(), {curve.get("name") for curve in ElementTree.fromstring(content).iter("curve")}


@pytest.mark.parametrize("kind", SHIPPED)
def test_programs_are_told_of_all_panels_and_of_nothing_else(kind):
    shown = panels(shipped(kind), "/left", "left/")
    dotted = {curve.full_path(".") for plot in shown.plots for curve in plot.curves}
    assert names_in("rviz", rviz(shown)) == ({"/left/markers", "/left/robot_description"}, set())
    assert names_in("foxglove", LAYOUTS["foxglove"].render(shown)) == ({"/left/markers"}, dotted)
    slashed = {curve.full_path("/") for plot in shown.plots for curve in plot.curves}
    assert names_in("plotjuggler", LAYOUTS["plotjuggler"].render(shown)) == (set(), slashed)


@pytest.mark.parametrize(
    ("scene", "overrides", "middle", "radius"),
    [
        ("bearing_6203", [], (0.0, 0.0, 0.0), 0.0205),
        ("sphere_on_beam", ["beam.span=0.5"], (0.25, 0.0, 0.006), 0.25),
    ],
)
def test_the_camera_stands_where_all_of_the_scene_is_seen(scene, overrides, middle, radius):
    """In Foxglove a sphere of that radius about the middle is within the 45 degrees that the camera sees."""
    shown = panels(load_scene(scene, overrides))
    assert shown.middle == pytest.approx(middle, abs=1e-3)
    assert shown.radius == pytest.approx(radius, rel=0.01)
    camera = json.loads(LAYOUTS["foxglove"].render(shown))["configById"]["3D!scene"]["cameraState"]
    assert camera["targetOffset"] == list(shown.middle)
    assert radius < camera["distance"] * math.sin(math.radians(camera["fovy"] / 2.0)) < 1.5 * radius
    assert camera["near"] < camera["distance"] - radius < camera["distance"] + radius < camera["far"]
    view = yaml.safe_load(rviz(shown))["Visualization Manager"]["Views"]["Current"]
    assert view["Distance"] == camera["distance"]
    assert list(view["Focal Point"].values()) == list(shown.middle)


@pytest.mark.parametrize(
    ("scene", "body"),
    [
        ("two_bodies_ellipsoid", "first"),
        ("two_bodies_groove", ""),
        ("ellipsoid_rocking", "body"),
        ("ellipsoid_on_plane", ""),  # it falls straight down
        ("sphere_on_beam", ""),
    ],
)
def test_the_eye_goes_with_a_body_that_travels_along_a_plane(scene, body):
    """By the source of Lichtblick 1.28: the eye goes with the frame of `followTf`, and grids lie in it by default."""
    shown = panels(load_scene(scene), "/left", "left/")
    frame = f"left/{body}" if body else shown.frame
    view = json.loads(LAYOUTS["foxglove"].render(shown))["configById"]["3D!scene"]
    assert (view["followTf"], view["followMode"]) == (frame, "follow-position" if body else "follow-none")
    assert view["layers"]["grid"]["frameId"] == shown.frame
    manager = yaml.safe_load(rviz(shown))["Visualization Manager"]
    assert manager["Views"]["Current"]["Target Frame"] == frame
    assert manager["Global Options"]["Fixed Frame"] == shown.frame
    if body:
        assert view["cameraState"]["targetOffset"] == [0.0, 0.0, 0.0]
        assert f"{body}/wrench" in {topic.name for topic in topics(load_scene(scene))}  # whose frames are on /tf


def test_two_bearings_share_one_picture():
    layout = [panels(SCENE, f"/{side}", f"{side}/")._replace(frame="world") for side in ("left", "right")]
    content = rviz(*layout)
    expected = {f"/{side}/{name}" for side in ("left", "right") for name in ("markers", "robot_description")}
    assert names_in("rviz", content) == (expected, set())
    assert yaml.safe_load(content)["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"


def test_a_log_is_laid_out_by_its_own_names(tmp_path, refused, run_json):
    scene, log = made_up_scene(), tmp_path / "run.mcap"
    write_log(made_up_run(scene, [made_up_block(scene, 50)]), log)
    arguments = ["layouts", log, "--out", tmp_path / "new", "--for", "plotjuggler"]
    reported = run_json(*arguments)
    [path] = map(Path, reported["files"].values())
    assert path.name == "run.plotjuggler.xml"
    assert reported["open_with"] == {"plotjuggler": f"plotjuggler --datafile {log} --layout {path}"}
    assert path.read_bytes() == LAYOUTS["plotjuggler"].render(panels(scene))
    assert "is not overwritten" in refused(*arguments)
    path.write_text("another")
    run_json(*arguments, "--force")
    assert path.read_bytes() == LAYOUTS["plotjuggler"].render(panels(scene))


def test_a_replay_in_a_namespace_is_laid_out_there_and_a_log_without_a_scene_is_refused(tmp_path):
    scene, block = SCENE, made_up_block(SCENE, 50)
    write_log(made_up_run(scene, [block]), tmp_path / "run.mcap")
    assert panels_of_log(read_log(tmp_path / "run.mcap"), "/left") == panels(scene, "/left")
    with RawLogWriter(tmp_path / "bare.mcap") as log:
        data = samples_message(scene.channels, 0, block.time_ns, block.matrix())
        log.write(log.add_topic("/bearing/samples", cdr.SAMPLE_BLOCK), 0, 0, data)
    with pytest.raises(LogError, match="holds no scene"):
        panels_of_log(read_log(tmp_path / "bare.mcap"), "/left")


def test_what_a_scene_is_called_leads_out_of_no_folder(tmp_path):
    (tmp_path / "scene.yaml").write_text("kind: bearing\nname: ../../escaped\n")
    (tmp_path / "deep").mkdir()
    arguments = ["--out", str(tmp_path / "deep" / "new"), "--for", "plotjuggler"]
    assert main(["layouts", str(tmp_path / "scene.yaml"), *arguments]) == 0
    assert [file.name for file in (tmp_path / "deep" / "new").iterdir()] == ["_.._escaped.plotjuggler.xml"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["bearing_6203", "--for", "rvis"], "--for 'rvis' is not known; did you mean rviz?"),
        (["bearing_6203", "--for", "rerun"], "open the log itself"),
        (["there_is_none.mcap"], "there is no log"),
    ],
)
def test_what_cannot_be_laid_out_is_refused(arguments, sentence, tmp_path, refused):
    assert sentence in refused("layouts", *arguments, "--out", tmp_path)


def test_a_kind_without_topics_of_its_own_is_refused(tmp_path, refused):
    path = tmp_path / "swing.yaml"
    path.write_text("kind: toy\n", encoding="utf-8")
    assert "swing has neither wrenches nor contacts nor state" in refused("layouts", path, "--out", tmp_path)
    assert not list(tmp_path.glob("swing.*.*"))


@pytest.mark.parametrize("out", ["run.mcap", "run.mcap/below"])
def test_layouts_that_are_to_go_into_a_file_are_refused(out, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    write_log(simulate(load_scene("two_spheres")), "run.mcap")
    sentence = refused("layouts", "run.mcap", "--out", out)
    assert f"{out} cannot be used (" in sentence
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]
