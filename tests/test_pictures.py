"""Pictures and summaries: what goes in comes out, for few balls and many, short runs and long ones."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.sample import Block, Channel, cut, joined
from bearing_twin.command.cli import DONE, main
from bearing_twin.kinds import picture as pictures
from bearing_twin.kinds.bearing import BearingPicture
from bearing_twin.kinds.contract import Facts
from bearing_twin.run.report import plot
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

PNG = b"\x89PNG\r\n\x1a\n"
QUICK = (640, 400)  # pixels of a picture of 1600 x 1000 that is drawn quickly
PITCH, BALL = 28.5e-3, 6.746e-3


def made_up_block(balls, outputs, first=0, period=1e-3, mean=40.0, swing=60.0):
    """Loads that go round with the balls; below zero a ball is loose."""
    time = (first + np.arange(outputs)) * period
    angle = 2.0 * np.pi * np.arange(balls) / balls + 70.0 * time[:, None]
    outward = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    load = np.maximum(mean - swing * outward[..., 1:2] + np.array([0.0, 2.0]), 0.0)
    values = {
        "orbit_angle": angle,
        "position": 0.5 * PITCH * outward,
        "point": 0.5 * np.stack([(PITCH - BALL) * outward, (PITCH + BALL) * outward], axis=2),
        "normal_load": load,
        "contact_angle": 0.02 * np.ones((outputs, balls, 2)),
        "inner_ring_speed": np.full(outputs, 183.26),
        "inner_ring_torque": np.full((outputs, 3), 1e-3),
        "inner_ring_force": np.full((outputs, 3), 40.0),
        "drive_work": 5.0 * time,
        "kinetic_energy": 0.0 * time,
        "elastic_energy": 2.0 * time,
        "potential_energy": 0.0 * time,
        "dissipated": 3.0 * time,
    }
    channels = tuple(Channel(name, "", value.shape[1:], "") for name, value in values.items())
    return Block(channels, first, np.round(time * 1e9).astype(np.int64), values)


def drawn(path, *blocks):
    """The picture of a recording without a scene."""
    picture = BearingPicture(Facts(None, "hertz", ""))
    for block in blocks:
        picture.add(block)
    return picture.write(path)


def size_of(png):
    content = png.read_bytes()
    assert content.startswith(PNG)
    return int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big")


@pytest.fixture(scope="module")
def loose_run():
    scene = load_scene("bearing_6203_loose", ["run.duration=0.03"])
    run = simulate(scene)
    return run, list(run.blocks())


def test_a_simulated_run_is_drawn_with_its_scene(loose_run, tmp_path):
    run, blocks = loose_run
    source = SimpleNamespace(blocks=lambda: iter(blocks), scene=run.scene, choice=run.choice)
    path = plot(source, tmp_path / "run.png")
    assert size_of(path) == (1600, 1000)
    assert str(tmp_path).encode() not in path.read_bytes()


@pytest.mark.usefixtures("quick_pictures")
@pytest.mark.parametrize(("balls", "outputs"), [(1, 1), (32, 300), (200, 2)])
def test_few_and_many_balls_short_and_long_runs_are_drawn(balls, outputs, tmp_path):
    block = made_up_block(balls, outputs)
    assert size_of(drawn(tmp_path / "run.png", block)) == QUICK
    block.values["normal_load"][:] = 0.0
    assert size_of(drawn(tmp_path / "without_load.png", block)) == QUICK


def test_a_run_of_unknown_kind_is_drawn_channel_by_channel(tmp_path):
    picture = pictures.RunPicture(Facts(None, "", ""))
    picture.add(made_up_block(8, 1500))
    assert size_of(picture.write(tmp_path / "run.png"))[0] == 1600


def test_the_same_run_gives_the_same_picture(tmp_path):
    block = made_up_block(2, 20)
    first, second = (drawn(tmp_path / name, block).read_bytes() for name in ("a.png", "b.png"))
    assert first == second


def test_no_sample_and_no_place_to_write_are_refused(tmp_path):
    with pytest.raises(LogError, match="no sample"):
        drawn(tmp_path / "run.png")
    with pytest.raises(BearingTwinError, match="cannot be written"):
        drawn(tmp_path / "none" / "run.png", made_up_block(2, 2))


def test_a_peak_of_a_long_run_that_is_thinned_is_drawn_or_named(tmp_path, monkeypatch):
    """Of 250 000 outputs, of which the last turns are drawn."""
    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: figures.append(figure))
    block = made_up_block(2, 250_000)
    block.values["normal_load"][12_345, 1, 0] = 12_340.0
    drawn(tmp_path / "run.png", block)
    texts = [text.get_text() for axis in figures[0].axes for text in axis.texts]
    assert "greatest of the run 1.234e+04 N" in texts
    assert all(len(line.get_xdata()) < 20_000 for axis in figures[0].axes for line in axis.lines)


def test_a_long_run_of_an_ellipsoid_is_thinned_and_its_greatest_load_kept(monkeypatch):
    """Evenly, whatever the lengths of its blocks."""
    monkeypatch.setattr(pictures, "GREATEST_ROWS", 300)
    run, history = simulate(load_scene("ellipsoid_rocking", ["run.duration=0.3"])), pictures.ChannelValues()
    loads, times = [], []
    for block in cut(joined(list(run.blocks())), 99):
        history.add(block)
        loads.append(block.values["normal_load"])
        times.append(1e-9 * block.time_ns)
    values = history.arrays()
    assert len(values["time"]) <= 300
    assert history.stride == 8
    assert values["time"] == pytest.approx(np.concatenate(times)[::8], abs=1e-15)
    assert np.array_equal(values["normal_load"], np.concatenate(loads)[::8])
    assert history.greatest["normal_load"] == np.concatenate(loads).max()
    with pytest.raises(LogError, match="no sample"):
        pictures.ChannelValues().arrays()


def test_errors_of_figures_are_drawn_below_loads_and_motion(tmp_path):
    for name, more in (("plain", []), ("errors", ["--plot-errors"])):
        words = ["simulate", "bearing_6203_loose", "--duration", "2e-3", "--plot", str(tmp_path / f"{name}.png")]
        assert main([*words, *more, "--json"]) == DONE
    assert size_of(tmp_path / "errors.png")[1] > 1.2 * size_of(tmp_path / "plain.png")[1]
