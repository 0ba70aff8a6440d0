"""Nodes on a machine that holds them up: what a recorder could not take is sent again."""

import os
import signal
import time
from collections import Counter

import pytest
from ros import DiagnosticArray, SetBool, call, executable, plain_node, ros_executor, spin_for, spin_until

from bearing_twin.base.paths import share_path
from bearing_twin.log.bag import raw_messages
from bearing_twin.nodes.entry import OF_THE_FOLDER, PROFILES, frequent_heartbeats

RATE, DURATION = 1000, 4.0  # messages of a topic a second, s
HELD_UP = (0.5, *[0.1] * 10)  # s, each after as long at work; a publisher keeps four seconds of messages


@pytest.fixture
def surroundings(monkeypatch, tmp_path):
    monkeypatch.delenv(PROFILES, raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_node_asks_fast_dds_to_send_again_soon(surroundings):
    frequent_heartbeats()
    assert os.environ.pop(PROFILES) == str(share_path("config", "fastdds.xml"))


def test_profiles_of_the_user_are_left_as_they_are(surroundings):
    os.environ[PROFILES] = ""
    frequent_heartbeats()
    assert os.environ.pop(PROFILES) == ""
    (surroundings / OF_THE_FOLDER).write_text("<dds/>")
    frequent_heartbeats()
    assert PROFILES not in os.environ


def words_of(parameters):
    return [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]


@pytest.mark.environment
def test_a_recorder_that_is_held_up_again_and_again_loses_nothing(tmp_path):
    log = tmp_path / "run.mcap"
    simulating = {
        "scene": "bearing_6203", "overrides": f"[run.output_rate={RATE}, run.publish_rate={RATE}]",
        "duration": DURATION, "repeat": -1.0, "start_paused": True,
    }  # fmt: skip
    reported = {"sim_node": {}, "recorder_node": {}}

    def heard(array):
        for status in array.status:
            for node, values in reported.items():
                if node in status.name:
                    values.update({"says": status.message} | {pair.key: pair.value for pair in status.values})

    def count(node, *names):
        return sum(int(reported[node].get(name, 0)) for name in names)

    with (
        ros_executor() as executor,
        executable(executor, "sim_node", *words_of(simulating)) as sim_node,
        executable(executor, "recorder_node", *words_of({"log": log})) as recorder,
    ):
        watcher = plain_node(executor)
        watcher.create_subscription(DiagnosticArray, "/diagnostics", heard, 100)
        spin_until(
            executor,
            lambda: count("sim_node", "least_subscribers") and count("recorder_node", "least_publishers"),
            "the nodes know each other",
        )
        assert call(executor, watcher, SetBool, "/bearing/sim_node/pause", SetBool.Request(data=False)).success
        for seconds in HELD_UP:
            spin_for(executor, seconds)
            recorder.send_signal(signal.SIGSTOP)
            time.sleep(seconds)
            recorder.send_signal(signal.SIGCONT)
        spin_until(executor, lambda: "waiting" in reported["sim_node"].get("says", ""), "the end of the run")
        known = lambda: count("recorder_node", "messages", "messages_lost", "messages_before")  # noqa: E731
        spin_until(executor, lambda: known() >= count("sim_node", "messages"), "the recorder has or misses all")
        for process in (recorder, sim_node):
            process.send_signal(signal.SIGINT)
        said = [process.communicate(timeout=60)[1] for process in (recorder, sim_node)]
    assert "XMLPARSER" not in "".join(said)
    logged = Counter(message.topic.name for message in raw_messages(log))
    missed = count("recorder_node", "messages_lost", "messages_before")
    assert sum(logged.values()) == count("sim_node", "messages") - missed
    values = reported["recorder_node"]
    assert (values["messages_lost"], values["lost_on"], values["uncounted"]) == ("0", "", ""), values
    assert logged["/bearing/state"] == RATE * DURATION + 1
