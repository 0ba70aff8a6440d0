"""The library in the hands of whoever writes Python: types, names, wrong arguments, passes, threads, what is shown."""

import ast
import copy
import inspect
import math
import pickle
import pydoc
import re
import threading
from pathlib import Path

import numpy as np
import pytest

import bearing_twin
from bearing_twin import (
    export_log,
    load_scene,
    load_study,
    read_log,
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
    expected, run = loads(simulate(load_scene(*SCENE))), simulate(load_scene(*SCENE))
    first = iter(run)
    next(first)
    assert loads(run) == expected
    with pytest.raises(BearingTwinError, match="begun anew meanwhile; make a run for each pass"):
        list(first)


def test_runs_in_threads_are_those_of_one_thread():
    names, results = ["bearing_6203", "bearing_6203_loose", "bearing_6203"], {}

    def work(index: int) -> None:
        results[index] = loads(simulate(load_scene(names[index], ["run.duration=0.05"])))

    threads = [threading.Thread(target=work, args=(index,)) for index in range(len(names))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for index, name in enumerate(names):
        assert results[index] == loads(simulate(load_scene(name, ["run.duration=0.05"])))


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


def test_a_designation_may_be_a_number_of_numpy():
    assert load_scene(np.int64(6308)) == load_scene("6308")


@pytest.mark.parametrize(
    ("begin", "sentence"),
    [
        (lambda path: simulate("two_spheres", failure=path), "failure = .* must be a Failure"),
        (lambda path: run_study("discs_small_10", cancelled=3), "cancelled = 3 must be a function"),
        (lambda path: run_study("discs_small_10", start=3), "start = 3 must be the result of a study"),
        (lambda path: bearing_twin.write_study(simulate("two_spheres"), path), r"hand over run_study\(study\)"),
    ],
)
def test_arguments_of_another_type_are_refused_in_a_sentence(begin, sentence, tmp_path):
    with pytest.raises(BearingTwinError, match=sentence):
        begin(tmp_path / "x.mcap")


def test_a_block_gives_rows_by_number_and_channels_by_name():
    block = next(simulate("two_spheres").blocks())
    assert np.array_equal(block["normal_load"], [sample["normal_load"] for sample in block])
    assert block[-1].sequence == len(block) - 1
    assert "normal_load" in block[0]
    assert "normal_lod" not in block[0]
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


PACKAGE = Path(bearing_twin.__file__).parent
PUBLIC = [name for name in dir(bearing_twin) if not name.startswith("_")]
FUNCTIONS = [one for one in map(bearing_twin.__getattr__, PUBLIC) if inspect.isfunction(one)]


def test_checkers_of_types_are_told_every_public_name_and_its_home():
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
    reported = {
        alias.asname: node.module for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert sorted(reported) == sorted(PUBLIC)
    for name, home in reported.items():
        assert getattr(bearing_twin, name).__module__ == home
    assert (PACKAGE / "py.typed").is_file()


def test_help_shows_the_public_names_and_an_import_of_all_has_them():
    shown, namespace = pydoc.plain(pydoc.render_doc(bearing_twin)), {}
    exec("from bearing_twin import *", namespace)
    for name in PUBLIC:
        assert namespace[name] is getattr(bearing_twin, name)
        assert re.search(rf"^ {{4}}(class )?{name}\(", shown, re.MULTILINE)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda parameter: parameter.__name__)
def test_docstrings_of_public_functions_have_every_parameter_and_the_errors(function):
    """In the style of NumPy."""
    text, signature = inspect.getdoc(function), inspect.signature(function)
    assert signature.return_annotation is not inspect.Signature.empty
    for name, parameter in signature.parameters.items():
        assert parameter.annotation is not inspect.Parameter.empty, name
        stars = {inspect.Parameter.VAR_KEYWORD: r"\*\*"}.get(parameter.kind, "")
        assert re.search(rf"^{stars}{name} : ", text, re.MULTILINE), name
    taken = {"Parameters", "Raises"} if signature.parameters else set()
    assert taken | {"Returns"} <= set(re.findall(r"^(\w+)\n-+$", text, re.MULTILINE)) or not taken


def test_a_run_says_why_it_is_not_copied_and_what_can_be(tmp_path):
    run = simulate("two_spheres")
    blocks = list(run.blocks())
    for copied in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(BearingTwinError, match=r"take its scene"):
            copied(run)
    report, scene, copies = pickle.loads(pickle.dumps((run.report, run.scene, blocks)))
    assert report.as_dict() == run.report.as_dict()
    first = next(iter(simulate(scene).blocks()))
    assert all((first[channel.name] == copies[0][channel.name]).all() for channel in run.channels)
    write_log(run, tmp_path / "run.mcap")
    assert len(pickle.loads(pickle.dumps(list(read_log(tmp_path / "run.mcap"))))) == run.outputs


@pytest.mark.parametrize(
    ("make", "texts"),
    [
        (lambda: bearing_twin.equilibrium("6308", [0.0, -2000.0, 0.0]), ("1 equilibria", "greatest ball load [N]")),
        (lambda: _reported("bearing_6203"), ("bearing_6203: done", "cage_speed_rad_s", "normal_load_inner_n")),
        (lambda: _reported("two_spheres"), ("two_spheres: done", "contacts", "1 rows")),
        (
            lambda: bearing_twin.run_study(bearing_twin.load_study("spheres_alpha_4e-5", ["samples=50"])),
            ("50 realisations, 0 of them failed", "peak_force"),
        ),
    ],
    ids=["equilibrium", "run", "impact", "study"],
)
def test_a_result_is_a_short_table(make, texts):
    text = repr(make())
    assert len(text) < 2500
    assert all(expected in text for expected in texts), text


def test_what_is_iterated_says_what_it_holds(tmp_path):
    run = simulate("two_spheres")
    write_log(run, tmp_path / "run.mcap", max_loss=np.float32(0.0))
    shown = [repr(item) for item in (run, read_log(tmp_path / "run.mcap"), next(run.blocks()))]
    for text, expected in zip(shown, ("two_spheres: 401 outputs", "two_spheres", "400 outputs from 0"), strict=True):
        assert expected in text
        assert len(text) < 500


def _reported(scene):
    run = bearing_twin.simulate(bearing_twin.load_scene(scene, ["run.duration=0.002"]))
    assert len({str(sample) for sample in run}) == run.report.samples
    return run.report
