"""The library in the hands of whoever writes Python: wrong types, names in place of objects, two passes, threads."""

import threading
from pathlib import Path

import pytest

from bearing_twin import export_log, load_scene, load_study, run_study, simulate
from bearing_twin.errors import BearingTwinError

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
