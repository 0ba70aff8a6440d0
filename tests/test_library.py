"""The library in the hands of whoever writes Python: wrong types, names in place of objects, two passes, threads."""

import math
import threading
from pathlib import Path

import numpy as np
import pytest

from bearing_twin import (
    export_log,
    load_scene,
    load_study,
    run_study,
    simulate,
    write_log,
)
from bearing_twin.base.errors import BearingTwinError

SCENE = ("bearing_6203", ["run.duration=0.9"])  # three chunks


def loads(run) -> list[bytes]:
    return [sample["normal_load"].tobytes() for sample in run]


@pytest.mark.parametrize(
    "overrides", [None, 5, [5], [None], [b"run.duration=1"], "run.duration=1", {"run.duration": 1}]
)
@pytest.mark.parametrize("load", [load_scene, load_study])
def test_overrides_that_are_no_texts_are_refused_in_a_sentence(load, overrides):
    name = {load_scene: "two_spheres", load_study: "spheres_alpha_4e-5"}[load]
    with pytest.raises(BearingTwinError, match="must be a list of texts such as"):
        load(name, overrides)
    assert load(name, iter(())) == load(name)


def test_a_scene_is_simulated_by_name_path_or_plain_data_and_a_study_run_by_its_name(tmp_path):
    scene = load_scene("two_spheres")
    path = tmp_path / "own.yaml"
    path.write_text(scene.text)
    for source in ("two_spheres", path, scene.resolved()):
        assert loads(simulate(source)) == loads(simulate(scene))
    with pytest.raises(BearingTwinError, match="there is no scene 'None'"):
        simulate(None)
    study = Path(tmp_path / "study.yaml")
    study.write_text(
        "scene: two_spheres\nquantities: [peak_force]\nsamples: 20\n"
        "inputs: {motion.first_velocity: {distribution: uniform, low: 1.0, high: 2.0}}\n"
    )
    assert run_study(study).as_dict()["quantities"] == run_study(load_study(study)).as_dict()["quantities"]
    with pytest.raises(BearingTwinError, match="there is no study 'None'"):
        run_study(None)


def test_a_form_that_no_log_is_written_in_is_refused_with_the_nearest(tmp_path):
    with pytest.raises(BearingTwinError, match="cannot be written as 'cvs'; did you mean csv"):
        export_log("no.mcap", "cvs", tmp_path / "out")


def test_a_pass_is_not_gone_on_with_after_another_has_begun():
    """It would go on with outputs of the other, without a word; a pass that was broken off disturbs nobody."""
    whole, run = loads(simulate(load_scene(*SCENE))), simulate(load_scene(*SCENE))
    first = iter(run)
    next(first)
    assert loads(run) == whole
    with pytest.raises(BearingTwinError, match="begun anew meanwhile; make a run for each pass"):
        list(first)


def test_runs_in_threads_are_those_of_one_thread():
    names, found = ["bearing_6203", "bearing_6203_loose", "bearing_6203"], {}

    def work(place: int) -> None:
        found[place] = loads(simulate(load_scene(names[place], ["run.duration=0.05"])))

    threads = [threading.Thread(target=work, args=(place,)) for place in range(len(names))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for place, name in enumerate(names):
        assert found[place] == loads(simulate(load_scene(name, ["run.duration=0.05"])))


@pytest.mark.parametrize(("begin", "loader"), [(simulate, "load_scene"), (run_study, "load_study")])
def test_changes_that_are_handed_to_the_wrong_function_are_sent_to_the_right_one(begin, loader):
    with pytest.raises(BearingTwinError, match=rf"changes are handed to {loader}\(name, changes\)"):
        begin("two_spheres" if begin is simulate else "spheres_alpha_4e-5", ["samples=5"])


def test_a_study_is_loaded_and_run_from_plain_data():
    speed = {"motion.first_velocity": {"distribution": "uniform", "low": 1.0, "high": 2.0}}
    reported = {"scene": "two_spheres", "quantities": ["peak_force"], "samples": 20, "inputs": speed}
    assert run_study(reported).as_dict()["quantities"] == run_study(load_study(reported)).as_dict()["quantities"]
    assert load_study(reported, ["samples=30"]).settings.samples == 30
    assert reported["samples"] == 20
    with pytest.raises(BearingTwinError, match="study mine: samples = 0 is out of range"):
        load_study(reported | {"name": "mine", "samples": 0})


def test_numbers_of_numpy_are_numbers_of_a_scene():
    for balls, offset in ((np.int64(9), np.array([0.0, 0.0, 1e-5])), (np.float32(9.0), [np.float64(0.0), 0.0, 1e-5])):
        scene = load_scene({"kind": "bearing", "geometry": {"balls": balls}, "drive": {"offset": offset}})
        assert scene == load_scene({"kind": "bearing", "geometry": {"balls": 9}, "drive": {"offset": [0, 0, 1e-5]}})
        assert type(scene.parameters.geometry.balls) is int
    with pytest.raises(BearingTwinError, match="must be a list of 3 numbers"):
        load_scene({"kind": "bearing", "drive": {"offset": np.zeros((2, 3))}})


def test_a_block_gives_rows_by_number_and_channels_by_name():
    block = next(simulate("two_spheres").blocks())
    assert np.array_equal(block["normal_load"], [sample["normal_load"] for sample in block])
    assert block[-1].sequence == len(block) - 1
    for holder in (block, block[0]):
        with pytest.raises(KeyError, match=r"^there is no channel 'normal_lod'; did you mean normal_load") as refused:
            holder["normal_lod"]
        assert isinstance(refused.value, BearingTwinError)  # the command line tells it in a sentence
    with pytest.raises(TypeError, match=r"take block.part\(low, high\)"):
        block[1:3]


def test_the_report_of_a_run_that_has_not_begun_says_so():
    run = simulate("two_spheres")
    with pytest.raises(BearingTwinError, match="nothing has been computed yet: iterate the run"):
        run.report  # noqa: B018 - a property that raises
    next(iter(run))
    assert run.report.scene == "two_spheres"


@pytest.mark.parametrize("max_loss", ["a", -1.0, math.nan, math.inf, None, True])
def test_a_loss_that_is_no_time_is_refused_before_anything_is_written(max_loss, tmp_path):
    with pytest.raises(BearingTwinError, match=r"max_loss = .* must be a number in s, at least 0"):
        write_log(simulate("two_spheres"), tmp_path / "x.mcap", max_loss=max_loss)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("source", ["two_spheres", load_scene("two_spheres"), None])
def test_a_log_of_what_is_no_run_is_refused_in_a_sentence(source, tmp_path):
    with pytest.raises(BearingTwinError, match=r"is none; hand over simulate\(scene\)"):
        write_log(source, tmp_path / "x.mcap")
