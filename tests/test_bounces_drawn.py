"""The picture of bodies that bounce: loads at outputs, and the peaks of contacts that outputs pass by."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from bearing_twin.pictures.peaks import LABEL
from bearing_twin.run.passes import simulate
from bearing_twin.run.picture import picture_of
from bearing_twin.run.scene import load_scene

ALONE = "solver.companion=off"


def panel_of_load(name, *changed):
    """The panel of the load of a run, and the run's figures."""
    run = simulate(load_scene(name, (ALONE, *changed)))
    drawn = picture_of(run)
    for block in run.blocks():
        drawn.add(block)
    figure = Figure(figsize=(16.0, 10.0))
    drawn.draw(figure, drawn._values.arrays())
    [axis] = [one for one in figure.axes if one.get_title(loc="left").startswith("Normal load")]
    return axis, run.report.figures


def points(axis, label):
    """What is drawn under this label, (x, y)."""
    lines = [one for one in axis.get_lines() if one.get_label() == label]
    return np.concatenate([one.get_xydata() for one in lines]) if lines else np.empty((0, 2))


@pytest.mark.parametrize("name", ["ellipsoid_rocking", "two_bodies_ellipsoid"])
def test_peaks_between_outputs_are_drawn_and_told(name):
    axis, figures = panel_of_load(name, "run.duration=0.05", "run.output_rate=100", "run.publish_rate=100")
    contacts = figures["contacts"]
    assert len(contacts) > 1
    peaks = points(axis, LABEL)
    assert peaks[:, 1] == pytest.approx([one["peak_force_n"] for one in contacts])
    assert peaks[:, 0] == pytest.approx([one["start_s"] + 0.5 * one["duration_s"] for one in contacts])
    assert not len(points(axis, "at the outputs"))
    assert axis.get_title(loc="left") == f"Normal load, peak {figures['peak_force_n']:.4g} N"
    low, high = axis.get_ylim()
    assert low < peaks[:, 1].min() < peaks[:, 1].max() < high


def test_a_long_contact_is_a_line_as_long():
    """Its record does not say when its peak was."""
    changed = ("start.height=0.001", "contact.restitution=1", "run.duration=0.16")
    axis, figures = panel_of_load("ellipsoid_on_plane", *changed, "plane.material.young_modulus=1e6")
    [contact] = figures["contacts"]
    [bar] = [segment for one in axis.collections for segment in one.get_segments()]
    assert bar[:, 0] == pytest.approx([contact["start_s"], contact["start_s"] + contact["duration_s"]])
    assert not len(points(axis, LABEL))
    assert len(points(axis, "at the outputs"))


def test_where_nothing_touches_no_scale_is_made_up():
    axis, figures = panel_of_load("ellipsoid_rocking", "run.duration=0.01")
    assert figures["contact_count"] == 0
    assert axis.get_yscale() == "linear"
    assert not len(axis.get_yticks())
    assert "no contact" in axis.texts[0].get_text()
