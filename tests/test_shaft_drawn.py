"""What is drawn of a shaft on two bearings, markers, view and picture, against its motion, loads and geometry."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from bearing_twin.kinds.contract import Output
from bearing_twin.kinds.shaft import picture
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.kinds.shaft.topics import longest_arrow, ring_centres, topics
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


def test_orbits_are_of_the_second_half_about_their_means(drawn):
    _, block = drawn
    axis, offset = Figure().add_subplot(), block.values["ring_offset"]
    picture._draw_orbits(axis, {"time": 1e-9 * block.time_ns, "ring_offset": offset})
    late = offset[30:, :, :2]
    factor = np.ptp(axis.lines[0].get_xdata()) / np.ptp(late[:, 0, 0])
    for k in range(2):
        shown = np.stack(axis.lines[k].get_data(), axis=-1)
        assert shown == pytest.approx(factor * (late[:, k] - late[:, k].mean(axis=0)), abs=1e-6 * np.ptp(shown))
