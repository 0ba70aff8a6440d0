"""Pictures of runs: what goes in comes out, for few balls and many, short runs and long ones."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from runs import a_choice, made_up_block

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.sample import Block, Channel
from bearing_twin.command.cli import DONE, main
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.picture import RunPicture
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

BALLS = 2


def scene_of(balls):
    """A bearing whose balls are so small that many fit."""
    small = ("geometry.ball_diameter=0.4 mm", "geometry.radial_clearance=0", "drive.offset=[0,0,0]")
    return load_scene("bearing_6203", (f"geometry.balls={balls}", *small))


def outputs_of(balls, count):
    """Outputs of balls that stand on the pitch circle, between contact points in and outside of it."""
    block = made_up_block(scene_of(balls), count)
    angle = 2.0 * np.pi * np.arange(balls) / balls
    outward = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    block.values["position"][:] = outward
    block.values["point"][:] = np.stack([0.8 * outward, 1.2 * outward], axis=1)
    return block


def drawn(path, *blocks, balls=BALLS):
    """The picture of a bearing with these outputs."""
    picture = KINDS["bearing"].picture(scene_of(balls), a_choice())
    for block in blocks:
        picture.add(block)
    return picture.write(path)


def size_of(png):
    content = png.read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    return int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big")


@pytest.fixture
def figures(monkeypatch):
    """The figures that are drawn, none of which is saved."""
    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: figures.append(figure))
    return figures


@pytest.mark.usefixtures("quick_pictures")
@pytest.mark.parametrize(("balls", "outputs"), [(1, 1), (32, 300), (200, 2)])
def test_few_and_many_balls_short_and_long_runs_are_drawn(balls, outputs, tmp_path):
    block = outputs_of(balls, outputs)
    assert size_of(drawn(tmp_path / "run.png", block, balls=balls)) == (640, 400)
    block.values["normal_load"][:] = 0.0
    assert size_of(drawn(tmp_path / "without_load.png", block, balls=balls)) == (640, 400)


def test_the_same_run_gives_the_same_picture_which_says_nothing_of_folders(tmp_path):
    block = outputs_of(BALLS, 20)
    first, second = (drawn(tmp_path / name, block).read_bytes() for name in ("a.png", "b.png"))
    assert first == second
    assert str(tmp_path).encode() not in first


def test_a_log_of_an_earlier_version_that_lacks_channels_is_drawn(tmp_path):
    block = outputs_of(BALLS, 20)
    values = {
        channel.name: block.values[channel.name] for channel in block.channels if not channel.name.startswith("cage")
    }
    channels = tuple(channel for channel in block.channels if channel.name in values)
    assert size_of(drawn(tmp_path / "run.png", Block(channels, 0, block.time_ns, values)))[0] == 1600


def test_no_sample_and_no_place_to_write_are_refused(tmp_path):
    with pytest.raises(LogError, match="no sample"):
        drawn(tmp_path / "run.png")
    with pytest.raises(BearingTwinError, match="cannot be written"):
        drawn(tmp_path / "none" / "run.png", outputs_of(BALLS, 2))


def test_a_peak_of_a_long_run_that_is_thinned_is_named(tmp_path, figures):
    """Of 50 000 outputs, of which the last turns are drawn."""
    block = outputs_of(BALLS, 50_000)
    block.values["orbit_angle"][:] = 0.1 * np.arange(50_000)[:, None]
    block.values["normal_load"][12_345, 1, 0] = 12_340.0
    drawn(tmp_path / "run.png", block)
    titles = [axis.get_title(loc="left") for axis in figures[0].axes]
    assert sum("peak 1.234e+04 N" in title for title in titles) == 1
    (line, *_) = next(axis for axis, title in zip(figures[0].axes, titles, strict=True) if "peak" in title).lines
    assert len(line.get_xdata()) < 1000
    assert line.get_xdata()[-1] - line.get_xdata()[0] == pytest.approx(8 * 2 * np.pi / 0.1 * 1e-3, rel=0.02)


def test_rounding_is_not_enlarged_and_a_load_is_not_negative(tmp_path, figures):
    """Noise of 1e-9 filled its panel, with numbers of nine digits; without a load the axis went down to -0.05 N."""
    block = outputs_of(BALLS, 30)
    block.values["normal_load"][..., 0] = 0.0
    block.values["normal_load"][..., 1] = 48.5 * (1.0 + 1e-9 * np.sin(np.arange(30)))[:, None]
    drawn(tmp_path / "run.png", block)
    inner, outer = (axis.get_ylim() for axis in figures[0].axes if "Load on each ball" in axis.get_title(loc="left"))
    assert inner[0] == 0.0
    assert outer[1] - outer[0] > 1e-4


def extents(words):
    """Left, right, lower and upper edges of texts of a drawn figure, as rows."""
    boxes = [text.get_window_extent() for text in words]
    return np.array([(box.x0, box.x1, box.y0, box.y1) for box in boxes])


def test_titles_stay_inside_the_picture_and_apart(tmp_path, figures):
    """Titles ran into their neighbours or out of the picture.

    So did the heading of a round contact, a long description, and that of a channel.
    Maps were narrower than the curves below them, over whose times they stand.
    """
    contact = ["contact", "--radii-1", "10mm", "--load", "1000", "--plot", str(tmp_path / "contact.png"), "--json"]
    assert main(contact) == DONE
    words = "a rotor between two bearings that somebody describes at length " * 4
    scene = load_scene({"kind": "shaft", "name": "long", "description": words, "run": {"duration": 1e-3}})
    picture = KINDS["shaft"].picture(scene, simulate(scene).choice)
    for block in simulate(scene).blocks():
        picture.add(block)
    picture.write(tmp_path / "shaft.png")
    unknown = RunPicture(None, a_choice())
    unknown.add(made_up_block(scene_of(8), 30))
    unknown.write(tmp_path / "unknown.png")
    maps = [axis for axis in figures[-1].axes if axis.get_ylabel() == "number"]
    curves = [axis for axis in figures[-1].axes if axis.lines]
    assert {round(axis.get_position().width, 6) for axis in maps} == {round(curves[0].get_position().width, 6)}
    for figure in figures:
        figure.draw_without_rendering()
        titles = [axis.title if axis.title.get_text() else axis._left_title for axis in figure.axes]
        rows = extents([*filter(lambda title: title.get_text(), titles), *figure.texts])
        for k, (left, right, low, high) in enumerate(rows):
            assert right <= figure.bbox.width
            others = np.delete(rows, k, axis=0)
            apart = (others[:, 0] > right) | (others[:, 1] < left) | (others[:, 2] > high) | (others[:, 3] < low)
            assert apart.all()


def test_a_slender_contact_is_drawn_without_warnings(tmp_path, caplog):
    """Its panel is wider than high, so that limits give way to the aspect: matplotlib printed a warning of that."""
    slender = ["contact", "--bearing", "6203", "--race", "inner", "--load", "100"]
    assert main([*slender, "--plot", str(tmp_path / "contact.png"), "--json"]) == DONE
    assert not caplog.records


def test_a_ring_moves_from_where_it_starts_and_speeds_are_in_rpm(tmp_path, figures):
    """A load moves the ring of a 6203 by 15 um, and balls that pass by 0.1 um, which was a flat line."""
    command = ["simulate", "bearing_6203_run_up", "--duration", "0.02", "--plot", str(tmp_path / "run.png"), "--json"]
    assert main(command) == DONE
    axes = {axis.get_title(loc="left"): axis for axis in figures[0].axes}
    moved = axes["Inner ring's displacement since the start"]
    assert moved.get_ylabel() == "nm"
    assert [line.get_ydata()[0] for line in moved.lines] == [0.0, 0.0, 0.0]
    assert axes["Speed about the axis: inner ring"].get_ylabel() == "rpm"


def test_errors_of_figures_are_drawn_below_loads_and_motion(tmp_path):
    for name, options in (("plain", []), ("errors", ["--plot-errors"])):
        command = ["simulate", "bearing_6203_loose", "--duration", "2e-3", "--plot", str(tmp_path / f"{name}.png")]
        assert main([*command, *options, "--json"]) == DONE
    assert size_of(tmp_path / "errors.png")[1] > 1.2 * size_of(tmp_path / "plain.png")[1]


def test_the_time_stands_below_each_column(tmp_path, figures):
    """Of three panels in two columns one had no numbers of its time."""
    picture = RunPicture(None, a_choice())
    channels = tuple(Channel(name, "m", (), "") for name in ("first", "second", "third"))
    values = {channel.name: np.arange(30.0) for channel in channels}
    picture.add(Block(channels, 0, np.arange(30) * 10**6, values))
    picture.write(tmp_path / "run.png")
    assert [axis.get_xlabel() for axis in figures[0].axes if axis.lines] == ["", "time [ms]", "time [ms]"]
