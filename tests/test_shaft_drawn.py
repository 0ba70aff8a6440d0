"""What is drawn of a shaft on two bearings, markers, view and picture, against its motion, loads and geometry."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from bearing_twin.kinds.contract import Facts, Output
from bearing_twin.kinds.shaft import picture
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.kinds.shaft.topics import longest_arrow, ring_centres, solids, topics
from bearing_twin.kinds.shaft.view import view
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

LOADED = (
    *("shaft.unbalances=[]", "shaft.load=[50,-400,30]", "shaft.moment=[3,4]", "shaft.loads=[[0.02,0,-20,7,0,0]]"),
    *("left.ball_angle=0.3", "drive.speed=100", "solver.companion=off"),
)


@pytest.fixture(scope="module")
def drawn():
    """A tilted shaft whose bearings push unlike each other: its scene, and its outputs."""
    scene = load_scene("shaft_two_6203", LOADED)
    return scene, Simulation(scene).advance(60)


def test_markers_stand_on_the_axis_and_forces_come_out_at_the_rings(drawn):
    scene, block = drawn
    parameters, sample = scene.parameters, block[59]
    [row] = [one for one in topics(parameters) if one.name == "markers"]
    markers = {(one["ns"], one["id"]): one for one in row.fields(Output(parameters, "hertz", sample))["markers"]}
    centres, force = ring_centres(parameters, sample), sample["bearing_force"]
    body = markers["shaft", 0]["pose"]
    axis = Rotation.from_quat(body["orientation"]).apply([0.0, 0.0, 1.0])
    assert np.abs(sample["tilt"]).min() > 1e-5
    for there in (body["position"], *centres):  # to first order in the tilt
        off = there - sample["position"]
        assert np.abs(np.cross(off, axis)).max() < 1e-3 * np.abs(sample["tilt"]).min() * abs(off[2])
    begins, ends = np.moveaxis(np.reshape(markers["forces", 0]["points"], (2, 2, 3)), 1, 0)
    assert ends == pytest.approx(centres, abs=1e-12)
    longest = np.linalg.norm(force, axis=1).max()
    assert ends - begins == pytest.approx(longest_arrow(parameters) * force / longest, rel=1e-9)
    for k, side in enumerate(SIDES):
        geometry, ring = getattr(parameters, side).geometry, markers["bearings", k]
        bore, groove = (geometry.pitch_diameter + sign * geometry.ball_diameter for sign in (-1.0, 1.0))
        assert groove < ring["scale"][0] == ring["scale"][1] < 1.3 * groove
        assert markers["shaft", 0]["scale"][0] < bore


def test_the_view_turns_as_the_shaft_does_and_its_curves_are_those_they_are_named_after(drawn):
    scene, block = drawn
    found = view(Facts(scene, "hertz", "rodas4"), scene.channels)
    rows = found.rows(block.sampled(range(60)))
    turned = Rotation.from_euler("z", block.values["shaft_angle"]).apply([1.0, 0.0, 0.0])
    assert rows["turn"] == pytest.approx(turned[:, :2], abs=1e-9)
    assert rows["varying_load"] == pytest.approx(np.tile([50.0, -400.0, 30.0], (60, 1)), rel=1e-9)
    for k, side in enumerate(SIDES):
        [panel] = [one for one in found.panels if one.title == f"Force of the {side} bearing on the shaft"]
        for axis, line in enumerate(panel.lines):
            flat = rows[line.series].reshape(60, -1)
            assert line.label == "xyz"[axis]
            assert np.array_equal(flat[:, line.column], block.values["bearing_force"][:, k, axis])


def test_solids_of_description_and_view_stand_where_their_bearings_do(drawn):
    scene, _ = drawn
    parameters = scene.parameters
    places = [getattr(parameters, side).place for side in SIDES]
    [rod] = solids(parameters)["shaft"]
    low, high = (rod.center[2] + sign * 0.5 * rod.sizes["length"] for sign in (-1.0, 1.0))
    assert low < min(places) < max(places) < high
    assert low + high == pytest.approx(sum(places), abs=1e-12)  # as far beyond either
    shown = {one.name: one for one in view(Facts(scene, "hertz", "rodas4"), scene.channels).solids}
    for side, place in zip(SIDES, places, strict=True):
        corners = np.reshape(shown[f"{side}_bearing"].shape["turned"]["strokes"], (-1, 2))
        assert 0.5 * (corners[:, 1].min() + corners[:, 1].max()) == pytest.approx(place)


def test_orbits_are_of_the_second_half_about_their_means(drawn):
    _, block = drawn
    axis, offset = Figure().add_subplot(), block.values["ring_offset"]
    picture._draw_orbits(axis, {"time": 1e-9 * block.time_ns, "ring_offset": offset})
    late = offset[30:, :, :2]
    factor = np.ptp(axis.lines[0].get_xdata()) / np.ptp(late[:, 0, 0])
    for k in range(2):
        shown = np.stack(axis.lines[k].get_data(), axis=-1)
        assert shown == pytest.approx(factor * (late[:, k] - late[:, k].mean(axis=0)), abs=1e-6 * np.ptp(shown))


def test_the_arrow_in_the_picture_points_to_the_balls_that_bear_most(drawn):
    _, block = drawn
    figure = Figure()
    for k, side in enumerate(SIDES):
        axis = figure.add_subplot(1, 2, k + 1, projection="polar")
        picture._draw_loads(axis, block.values, side, k)
        [arrow] = [one for one in axis.texts if hasattr(one, "arrow_patch")]
        load = block.values[f"{side}_normal_load"][-1, :, 0]
        azimuth = block.values["orbit_angle"][-1, k] + 2.0 * math.pi * np.arange(len(load)) / len(load)
        most = np.angle(load @ np.exp(1j * azimuth))
        assert math.cos(arrow.xy[0] - most) > 0.99


def test_one_swing_a_turn_is_sixty_turns_a_minute_and_critical_speeds_lie_on_that_line(drawn):
    scene, _ = drawn
    axis = Figure().add_subplot()
    picture._draw_frequencies(axis, scene.parameters, "hertz")
    [line] = [one for one in axis.lines if one.get_label() == "one swing a turn"]
    assert line.get_ydata() == pytest.approx(line.get_xdata() / 60.0)
    dots = [one for one in axis.lines if one.get_marker() == "o"]
    assert dots
    for dot in dots:
        assert dot.get_ydata()[0] == pytest.approx(dot.get_xdata()[0] / 60.0)
    [mark] = [one for one in axis.lines if len(set(one.get_xdata())) == 1 and one.get_marker() != "o"]
    assert mark.get_xdata()[0] == pytest.approx(100.0 * 60.0 / (2.0 * math.pi))
    assert mark.get_label() in [one.get_text() for one in axis.get_legend().get_texts()]
