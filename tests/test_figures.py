"""Figures are a function of outputs and records: the same from a run and its log, however the stream is cut."""

import dataclasses
import json
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from runs import a_choice, made_up_block, made_up_run, made_up_scene

from bearing_twin.base.sample import Block, join_blocks
from bearing_twin.base.units import key_suffix
from bearing_twin.command.cli import DOUBTFUL
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.kinds import KINDS
from bearing_twin.log.run_log import write_log
from bearing_twin.run.report import ReportBuilder
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

pytestmark = pytest.mark.usefixtures("pictures_once")

SHORTER = {"bearing_6203_start": 0.01, "ellipsoid_rocking": 0.2}  # s: until something has happened
ONE_EACH = (
    "bearing_6203_start", "shaft_angular_pair", "ellipsoid_rocking", "two_spheres", "two_discs",
    "sphere_on_beam_drop_50mm", "soft_discs_mean",
)  # fmt: skip


@cache
def blocks_of(name) -> tuple:
    """(scene, choice, all outputs as one block) of a short run."""
    run = simulate(load_scene(name, [f"run.duration={SHORTER[name]}"] if name in SHORTER else []))
    block = join_blocks(list(run.blocks()))
    return run.scene, run.choice, block


def report_builder(scene, choice, blocks):
    """What is made of these blocks."""
    kind, made_of = KINDS[scene.kind], (scene.parameters, choice)
    gathering = ReportBuilder(kind.figures_of(*made_of), choice, kind.model_errors(*made_of))
    for block in blocks:
        gathering.add(block)
    return gathering


@pytest.mark.parametrize("name", ONE_EACH)
def test_how_a_stream_is_cut_changes_no_figure(name):
    scene, choice, block = blocks_of(name)
    expected = report_builder(scene, choice, [block]).report(scene.name)
    random = np.random.default_rng(7)
    for cuts in (1, 60):
        edges = [0, *sorted(random.choice(np.arange(1, len(block)), cuts, replace=False)), len(block)]
        builder = report_builder(scene, choice, [block.part(*pair) for pair in pairwise(edges)])
        assert builder.missing == 0
        assert repr(builder.report(scene.name)) == repr(expected)


def test_the_figures_of_every_kind_are_listed_with_units(run_json, run_cli):
    rows = run_json("scenes", "--figures")
    listed = {(row["kind"], row["figure"]): row for row in rows["figures"]}
    for name, kind in KINDS.items():
        for key, meaning in kind.meanings_of().items():
            row = listed.pop((name, key))
            assert row["meaning"] == meaning
            assert key.endswith(key_suffix(row["unit"]))
    assert not listed
    assert "mean over the second half of the run" in " ".join("".join(run_cli("scenes", "--figures")).split())


def test_missing_outputs_are_counted(tmp_path, run_cli):
    scene = made_up_scene(balls=2)
    block = made_up_block(scene, 400)
    parts = [block.part(0, 130), block.part(137, 300), block.part(301, 400)]
    builder = report_builder(scene, a_choice(), parts)
    assert builder.missing == 8
    assert builder.report(scene.name).samples == 392
    log = tmp_path / "gaps.mcap"
    write_log(made_up_run(scene, parts), log)
    out, err = run_cli("report", log, "--strict", "--json", code=DOUBTFUL)
    result = json.loads(out)
    assert (result["missing_outputs"], result["samples"]) == (8, 392)
    assert "8 outputs are missing" in err


@pytest.mark.parametrize("outputs", [400, 32, 4096])
def test_means_are_over_the_second_half(outputs):
    """Outputs 1 ms apart, the middle between two of them.

    Sums over 50 outputs took all of a short run; of a long one the first sum came to hold nearly all.
    """
    scene = made_up_scene(balls=2)
    block = made_up_block(scene, outputs)
    is_late, values = np.arange(outputs) >= outputs // 2, block.values
    load, torque = np.where(is_late, 30.0, 10.0), np.where(is_late, 0.3, 0.1)
    load[outputs // 4] = 100.0
    values["normal_load"][:] = load[:, None, None] * np.array([1.0, 2.0])[:, None]
    values["raceway_torque"][:] = np.where(is_late, 1.0, 9.0)[:, None, None] * np.array([3.0, 0.0, -4.0])
    values["roll_rate"][:] = np.where(is_late, -7.0, -5.0)[:, None]
    values["orbit_angle"][:] = np.cumsum(np.where(is_late, 0.07, 0.05))[:, None]
    values["inner_ring_angle"][:] = np.cumsum(np.full(outputs, 0.18))
    values["inner_ring_load_work"][:] = np.cumsum(np.full(outputs, -5.0))
    values["drive_work"][:] = np.cumsum(0.18 * torque - 5.0)
    figures = report_builder(scene, a_choice(), [block]).report(scene.name).figures
    assert figures["normal_load_inner_n"] == pytest.approx([30.0, 60.0], rel=1e-12)
    assert figures["greatest_normal_load_inner_n"] == [100.0, 200.0]
    assert figures["drive_torque_nm"] == pytest.approx(0.3, rel=1e-12)
    assert figures["friction_torque_nm"] == pytest.approx([5.0, 5.0], rel=1e-12)
    assert figures["roll_rate_rad_s"] == pytest.approx(-7.0, rel=1e-12)
    assert figures["cage_speed_rad_s"] == pytest.approx(70.0, rel=1e-9)


def test_shapes_are_those_at_the_greatest_load():
    scene = made_up_scene(balls=2)
    block = made_up_block(scene, 50, seed=6)
    figures = report_builder(scene, a_choice(), [block.part(0, 20), block.part(20, 50)]).report(scene.name).figures
    names = ("normal_load", "contact_angle", "curvature_small", "curvature_large")
    for ball, side in np.ndindex(2, 2):
        ring = ("inner", "outer")[side]
        load, angle, small, large = (block.values[name][:, ball, side] for name in names)
        row = int(load.argmax())
        assert figures[f"contact_angle_{ring}_rad"][ball] == angle[row]
        spot = ellipse(small[row], large[row], 1.0, load[row])
        ratio = figures[f"semi_minor_{ring}_m"][ball] / figures[f"semi_major_{ring}_m"][ball]
        assert ratio == pytest.approx(spot.semi_minor / spot.semi_major, rel=1e-9)


def with_energy(block: Block, scene, share: float) -> Block:
    """The same outputs and records, but `share` of the scale of energy made (+) or lost (-) by nobody."""
    kind = scene.kind
    values, records = dict(block.values), {name: rows.copy() for name, rows in block.records.items()}
    grows = np.linspace(0.0, 1.0, len(block))
    if kind in ("bearing", "shaft"):
        values["kinetic_energy"] = values["kinetic_energy"] + share * grows * values["gross_work"][-1]
    elif kind == "ellipsoid_on_plane":
        stored = sum(values[name] for name in ("kinetic_energy", "potential_energy", "elastic_energy"))
        values["potential_energy"] = values["potential_energy"] + share * grows * stored.max()
    else:
        last_table = KINDS[kind].records(scene.parameters)[-1]
        gained = [column.name for column in last_table.columns].index("energy_gained")
        records[last_table.name][:, gained] += share * values["kinetic_energy"][0]
    return dataclasses.replace(block, values=values, records=records)


@pytest.mark.parametrize("share", [0.02, -0.008])
@pytest.mark.parametrize("name", ONE_EACH)
def test_a_hundredth_of_the_energy_made_or_lost_is_a_failure_in_every_kind(name, share):
    scene, choice, block = blocks_of(name)
    report = report_builder(scene, choice, [with_energy(block, scene, share)]).report(scene.name)
    assert report.figures["energy_closure"] == pytest.approx(share, rel=0.05, abs=1e-4)
    assert (report.status == "failed: energy") == report.status.startswith("failed") == (abs(share) > 0.01)


@pytest.mark.parametrize("name", ["cage_offset", "land_force", "inner_ring_load_work", "inner_ring_tilt"])
def test_a_channel_that_logs_of_earlier_versions_have_not_changes_no_other_figure(name):
    scene, results = made_up_scene(balls=2), []
    block = made_up_block(scene, 10)
    for outputs in (block, without(block, name)):
        figures = KINDS["bearing"].figures_of(scene.parameters, a_choice())
        figures.add(outputs)
        results.append(figures.figures())
    changed = {key for key in results[0] if repr(results[0][key]) != repr(results[1].get(key))}
    assert changed <= ({"drive_torque_nm"} if name == "inner_ring_load_work" else set())


def without(block, name):
    """A block that lacks a channel."""
    channels = tuple(channel for channel in block.channels if channel.name != name)
    return Block(
        channels,
        block.first_sequence,
        block.time_ns,
        {channel.name: block.values[channel.name] for channel in channels},
    )
