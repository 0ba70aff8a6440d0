"""Studies on request without ROS: their answers, what they may use, their logs."""

import json
import math
import os
import re
import threading
from itertools import pairwise

import pytest

from bearing_twin.base.errors import BearingTwinError, LogError, StudyError
from bearing_twin.log.study_log import StudyLog, read_study
from bearing_twin.nodes.studies import (
    ABORTED,
    CANCELLED,
    FEEDBACK_PERIOD,
    LONGEST_OVERRIDE,
    LONGEST_TEXT,
    SUCCEEDED,
    Goal,
    Studies,
    StudyLimits,
    aborted,
    feedback_of,
    free_path,
    study_of,
)
from bearing_twin.uq.run import Progress, run_study

QUICK = Goal("spheres_alpha_4e-5", ("sweep=", "histories=[]", "modality=no"), 500, 7)
YAML = """
scene: two_spheres
inputs: {motion.first_velocity: {distribution: uniform, low: 10.0, high: 30.0}}
quantities: [peak_force]
method: change_of_variable
"""


def answered(studies, goal=QUICK, **options):
    """The answer to a goal, as uq_node gives it."""
    try:
        answer = studies.run(goal, studies.read(goal), **options)
    except BearingTwinError as error:
        answer = aborted(error)
    studies.note(answer)
    return answer


def figures(studies):
    return studies.status()[2]


def test_an_answer_is_what_the_command_prints(tmp_path, run_json):
    answer = answered(Studies(str(tmp_path / "logs")))
    options = [option for override in QUICK.overrides for option in ("--set", override)]
    printed = run_json("study", QUICK.study, *options, "--samples", "500", "--seed", "7")
    summary = json.loads(answer.summary)
    assert summary.pop("log") == answer.log
    assert summary.pop("seconds") > 0.0
    del printed["seconds"]
    assert summary == printed
    assert (answer.state, answer.problem) == (SUCCEEDED, "")
    assert answer.stopped_because == "all 500 samples are done"
    assert answer.message.startswith("500 samples, 0 failed, ")
    stored = read_study(answer.log)
    assert stored.summary["quantities"] == printed["quantities"]
    assert len(stored.values) == 500


def test_a_goal_names_a_study_or_a_file_or_is_one(tmp_path):
    path = tmp_path / "speeds.yaml"
    path.write_text(YAML)
    assert study_of(Goal(str(path)), [tmp_path]).name == "speeds"
    assert study_of(Goal("speeds.yaml"), [tmp_path / "other", tmp_path]).name == "speeds"
    assert study_of(Goal(YAML)).quantities == ("peak_force",)
    line = "{scene: two_spheres, inputs: {motion.first_velocity: {distribution: uniform, low: 1, high: 3}}, "
    assert study_of(Goal(line + "quantities: [impulse]}", ("",), 30, 5)).settings.samples == 30
    assert study_of(Goal(" spheres_alpha_4e-5 ")).settings.seed == 1
    assert study_of(Goal("spheres_alpha_4e-5", ("seed=0",))).settings.seed == 0
    answer = answered(Studies(), Goal(YAML))
    assert json.loads(answer.summary)["quantities"]["peak_force"]["method"] == "change_of_variable"


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        (Goal(""), "which study? give a name"),
        (Goal("spheres_alfa"), "did you mean spheres_alpha"),
        (Goal("no/such/file.yaml"), "is no study file that may be read for this; give the study itself"),
        (QUICK._replace(overrides=("executor=dask://localhost:8786",)), "not among the node's parameter executors"),
        (Goal("{scene: two_spheres}"), "inputs must map keys"),
        (Goal("scene: a\0b\nx: 1"), "is not the YAML of a study"),
        (Goal("x" * (LONGEST_TEXT + 1)), "put it into a file"),
        (QUICK._replace(overrides=("samples=0",), samples=0), "samples = 0 is out of range"),
        (QUICK._replace(overrides=("x" * (LONGEST_OVERRIDE + 1),)), "characters at most"),
        (QUICK._replace(overrides=("samples=30",), samples=20), "samples is given as '30' and as '20'"),
        (QUICK._replace(samples=10**12), "is out of range"),
        (QUICK._replace(overrides=("memory=1e3",)), "more than its memory"),
        (QUICK._replace(overrides=("memory=1e15",), samples=5_000_000), "more than the node's parameter memory"),
    ],
)
def test_what_makes_no_study_is_refused_when_it_is_read(goal, sentence):
    answer = answered(Studies(limits=StudyLimits(memory=1e8), run_study=lambda *_: pytest.fail("it ran")), goal)
    assert (answer.state, answer.summary) == (ABORTED, "")
    assert sentence in answer.message == answer.problem


def test_limits_of_the_node_hold_whatever_a_study_asks_for(tmp_path):
    used = []
    run = lambda study, *_: used.append((study.settings.workers, study.executor)) or 1 / 0  # noqa: E731
    studies = Studies(limits=StudyLimits(workers=3, executors=["processes", "dask://here:1"]), run_study=run)
    for override in ("workers=0", "workers=2", "workers=512", "executor=dask://here:1"):
        answered(studies, QUICK._replace(overrides=(override,)))
    assert used == [(3, "processes"), (2, "processes"), (3, "processes"), (3, "dask://here:1")]
    assert "samples = 499" in answered(Studies(limits=StudyLimits(samples=499)), QUICK).message
    studies = Studies(str(tmp_path), StudyLimits(log_quota=1000.0))
    first, second = answered(studies), answered(studies, QUICK._replace(samples=1000))
    assert os.path.getsize(first.log) > 1000
    assert (first.state, second.state, second.log) == (SUCCEEDED, SUCCEEDED, "")
    assert "log_quota" in second.message


LARGE = QUICK._replace(samples=12_000_000, overrides=(*QUICK.overrides, "batch=500", "stop.minimum=500"))


@pytest.mark.parametrize(
    ("by", "state", "because"),
    [
        ("a cancel", CANCELLED, "cancelled"),
        ("the end of the node", ABORTED, "the node was ended"),
        ("the node's time_limit", ABORTED, "the node's parameter time_limit = 5 s was reached"),
    ],
)
def test_a_study_that_is_ended_keeps_what_is_done_and_the_next_is_served(by, state, because, tmp_path):
    now, cancelled = [0.0], threading.Event()
    studies = Studies(str(tmp_path), StudyLimits(time_limit=5.0), clock=lambda: now[0])

    def tell(feedback):
        if by == "a cancel":
            cancelled.set()
        studies.closing = by == "the end of the node"
        now[0] += 6.0 * (by == "the node's time_limit")

    answer = answered(studies, LARGE, cancelled=cancelled.is_set, tell=tell)
    assert (answer.state, answer.stopped_because) == (state, because)
    assert len(read_study(answer.log).status) == json.loads(answer.summary)["samples"] < LARGE.samples
    studies.closing = False
    assert answered(studies).state == SUCCEEDED


@pytest.mark.parametrize(
    ("error", "sentence"),
    [(StudyError("a worker died"), "a worker died"), (MemoryError("too much"), "MemoryError: too much")],
)
def test_whatever_happens_in_a_study_the_next_is_served(error, sentence):
    def run(study, progress, cancelled):
        if study.settings.seed == 13:
            raise error
        return run_study(study, progress, cancelled)

    studies = Studies(run_study=run)
    answer = answered(studies, QUICK._replace(seed=13))
    assert (answer.state, answer.message, answer.stopped_because) == (ABORTED, sentence, f"failed: {sentence}")
    assert studies.status()[1] == sentence
    assert answered(studies).state == SUCCEEDED
    assert studies.status()[1] == ""
    assert (figures(studies)[ABORTED], figures(studies)[SUCCEEDED]) == (1, 1)
    assert sentence in figures(studies)["last_error"]


@pytest.mark.parametrize(("broken_off", "logs"), [(True, 1), (False, 0)])
def test_what_is_done_of_a_study_outlives_what_ends_it(tmp_path, broken_off, logs):
    def run(study, tell, cancelled, keep):
        if broken_off:
            run_study(study, tell, cancelled, keep=keep)
        raise RuntimeError("the worker is gone")

    answer = answered(Studies(str(tmp_path), run_study=run))
    assert (answer.state, "the worker is gone" in answer.message) == (ABORTED, True)
    paths = list(tmp_path.iterdir())
    assert [len(read_study(path, unfinished=True).status) for path in paths] == [QUICK.samples] * logs


def test_a_result_whose_log_cannot_be_written_says_so(tmp_path):
    class Full(StudyLog):
        def finish(self, result):
            raise LogError("the disk is full")

    blocked = tmp_path / "file"
    studies = Studies(str(blocked / "logs"), open_log=Full)
    blocked.write_text("")
    for sentence in ("Not a directory", "the disk is full"):
        answer = answered(studies)
        assert (answer.state, answer.log) == (SUCCEEDED, "")
        assert sentence in answer.message
        assert sentence in answer.problem
        assert "Errno" not in answer.message
        (note,) = (sentence_ for sentence_ in json.loads(answer.summary)["notes"] if "its log" in sentence_)
        assert note == answer.problem == f"its log was not written: {note.partition('written: ')[2]}"
        assert "log" not in json.loads(answer.summary)
        assert studies.status()[1] == answer.problem
        if blocked.is_file():
            blocked.unlink()


def test_a_folder_for_logs_is_tried_at_the_start_and_made_when_there_is_a_log(tmp_path):
    for folder, sentence in ((__file__, "made or written (Not a directory"), ("/proc/none/logs", "(No such file")):
        with pytest.raises(LogError, match=re.escape(sentence)):
            Studies(folder)
    studies = Studies(str(tmp_path / "some" / "logs"))
    assert not list(tmp_path.iterdir()), "the trial at the start left something"
    assert answered(studies).log.startswith(str(tmp_path / "some" / "logs"))
    first = free_path(tmp_path, "../a study/of: mine", "20260101_000000")
    assert (first.name, first.parent) == ("_a_study_of_mine_20260101_000000.mcap", tmp_path)
    first.write_bytes(b"")
    assert free_path(tmp_path, "../a study/of: mine", "20260101_000000").name == first.stem + "_2.mcap"


def test_feedback_comes_ten_times_a_second_at_most():
    now, reported = [0.0], []

    def run(study, progress, cancelled):
        for done in range(100):
            progress(Progress(done, 500, 1.0, 0.1, 5.0))
            now[0] += 0.1 * FEEDBACK_PERIOD
        assert (figures(studies)["done"], figures(studies)["total"]) == (99, 500)
        return run_study(study)

    studies = Studies(run_study=run, clock=lambda: now[0])
    for _ in range(2):  # the second begins without the progress of the first
        answered(studies, tell=lambda feedback: reported.append((feedback["done"], feedback["quantity"])))
    assert len(reported) == 20
    assert reported[0] == reported[10] == (0, "std of contact_duration")
    assert all(later[0] - earlier[0] >= 10 for earlier, later in pairwise(reported[:10]))


@pytest.fixture
def traps(tmp_path):
    """Paths of what a goal must not have read, beside the one folder that is open to goals."""
    room, outside = tmp_path / "room", tmp_path / "outside"
    room.mkdir()
    outside.mkdir()
    (outside / "secret.yaml").write_text("password: 12345")
    (room / "link.yaml").symlink_to(outside / "secret.yaml")
    (room / "folder.yaml").mkdir()
    (room / "passwords.txt").write_text("password: 12345")
    os.mkfifo(room / "pipe.yaml")
    named = ("link.yaml", "folder.yaml", "pipe.yaml", "passwords.txt", "missing.yaml", "../outside/secret.yaml")
    absolute = ("/dev/ptmx", "/dev/zero", "/dev/stdin", "/proc/self/environ", "/etc/passwd", "/", str(tmp_path))
    return room, [*named, *(str(room / name) for name in named), *absolute, "a\0b.yaml", "x" * 5000 + ".yaml"]


def test_a_goal_reads_regular_files_of_the_folders_open_to_it_alone(traps):
    """A device or a pipe would hold the node for good; whether a file exists is nobody's business."""
    room, paths = traps
    for path in paths:
        goals = Goal(path), Goal(f"{{scene: {json.dumps(path)}, quantities: [peak_force], inputs: {{}}}}")
        for goal in goals:
            answer = answered(Studies(folders=[str(room)]), goal)
            assert answer.state == ABORTED
            assert "12345" not in answer.message
            known = "file that may be read for this" in answer.message, "legal: " in answer.message
            assert any(known) or "is not the YAML" in answer.message, (path, answer.message)
    sentences = {
        answered(Studies(folders=[str(room)]), Goal(path)).message.replace(repr(path), "")
        for path in paths
        if "/" in path and len(path) < 30
    }
    assert len(sentences) == 1
    studies = Studies(folders=[str(room)])
    assert answered(studies, Goal("/dev/ptmx")).state == ABORTED
    assert answered(studies).state == SUCCEEDED


def test_a_relative_name_is_not_looked_for_where_the_node_was_started(tmp_path, monkeypatch):
    (tmp_path / "speeds").write_text(YAML)
    monkeypatch.chdir(tmp_path)
    assert answered(Studies(), Goal("speeds")).state == ABORTED


def test_feedback_counts_samples_as_asked_for_names_its_estimate_and_is_never_nan():
    study = study_of(Goal("spheres_alpha_4e-5", ("stop.statistic=std",), samples=400))
    names = "done", "total", "estimate", "half_width", "seconds_left", "quantity"
    watched = f"std of {study.settings.stop.quantity}"
    for samples, progress, expected in (
        (400, Progress(3, 60, math.nan, math.nan, 1.0), (20, 400, 0.0, 0.0, 1.0, "")),
        (400, Progress(60, 60, 2e-5, math.nan, 0.0), (400, 400, 2e-5, math.inf, 0.0, watched)),
        (0, Progress(90, 300, 2e-5, 1e-6, 0.0, "x = 20"), (120, 400, 2e-5, 1e-6, 0.0, f"{watched} at x = 20")),
    ):
        fields = feedback_of(Goal("", samples=samples), study, progress)
        assert fields == dict(zip(names, expected, strict=True))
