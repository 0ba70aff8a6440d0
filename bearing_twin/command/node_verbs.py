"""What each verb of `bearing_twin node` does: it looks at the graph of nodes and hands back what it found.

Only this module of the command line reaches ROS, and only when one of its functions runs.
"""

import argparse
import importlib
import sys
from collections import Counter
from collections.abc import Callable

from bearing_twin.command.node_start import replace_by_node
from bearing_twin.command.outcome import Outcome, listed, number, overrides_of
from bearing_twin.command.pace import MessagePace
from bearing_twin.errors import BearingTwinError
from bearing_twin.parameters import echo
from bearing_twin.report import json_text
from bearing_twin.units import Limits

SHORT_LIST = 128  # numbers of an array that are shown


class _WordsError(BearingTwinError):
    """A message on the command line is no YAML."""


def _graph(arguments):
    """The graph of nodes, for a `with` statement; raises MissingInterfacesError where ROS is missing."""
    importlib.import_module("bearing_twin.nodes.messages")  # says in one sentence what is missing, if anything is
    from bearing_twin.nodes.graph import Graph

    return Graph(number("--wait", arguments.wait, limits=Limits(at_least=0.0, at_most=3600.0)))


def _count(arguments) -> int:
    value = number("--count", arguments.count, limits=Limits(at_least=0), integer=True)
    return 1 if getattr(arguments, "once", False) else value


def _yaml(text: str | None):
    """What a word of the command line says in YAML."""
    import yaml

    try:
        return yaml.safe_load(text or "")
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a date that there is not is a ValueError
        raise _WordsError(f"{echo(text)} is no YAML: write it in quotes, as '{{data: 250.0}}'") from error


def _shown(data) -> str:
    """A message as YAML; what could steer a terminal is escaped."""
    import yaml

    text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100, allow_unicode=False)
    return text.removesuffix("...\n")  # the end of a document that is one word or number


# Lists


def names(what: str) -> Callable[[argparse.Namespace], Outcome]:
    """The nodes, topics, services or actions, as `what` says."""

    def run(arguments) -> Outcome:
        with _graph(arguments) as graph:
            found = getattr(graph, f"{what}s")()
        if isinstance(found, dict):
            return listed(f"{what}s", ("name", "type"), ({"name": name, "type": kind} for name, kind in found.items()))
        table = listed(f"{what}s", ("name",), ({"name": name} for name in found))
        several = [f"{count} nodes are named {name}" for name, count in Counter(found).items() if count > 1]
        return table._replace(doubts=several)

    return run


# Topics


def echo_topic(arguments) -> Outcome:
    """Prints messages as they come."""
    from bearing_twin.command.terminal import show_text

    most, left, shown = None if arguments.full_length or arguments.json else SHORT_LIST, _count(arguments), False
    with _graph(arguments) as graph:
        from bearing_twin.nodes.reflection import plain

        try:
            for message in graph.messages(arguments.topic, _silent(arguments)):
                data = _field(plain(message, most), arguments.field)
                show_text(json_text(data) if arguments.json else f"{_shown(data)}---")
                sys.stdout.flush()
                shown = True
                left -= 1
                if left == 0:
                    break
        except KeyboardInterrupt:
            if not shown:
                raise
    return Outcome(None, [])


def _silent(arguments) -> Callable[[], None]:
    from bearing_twin.command.terminal import say

    return lambda: say(
        f"nothing has come on {arguments.topic} for {arguments.wait} s: is its node paused, or still compiling?"
    )


def _field(data, path: str | None):
    """The part of a message that `path`, such as wrench.force, leads to."""
    from bearing_twin.parameters import unknown

    for name in path.split(".") if path else ():
        if not isinstance(data, dict) or name not in data:
            legal = unknown(name, data) if isinstance(data, dict) else "there are no fields below"
            raise BearingTwinError(f"--field {echo(path)}: there is no {echo(name)}; {legal}")
        data = data[name]
    return data


def hz(arguments) -> Outcome:
    """Counts messages and times them."""
    from bearing_twin.command.terminal import say

    pace, count = MessagePace(), _count(arguments)
    with _graph(arguments) as graph:
        try:
            for _ in graph.messages(arguments.topic, _silent(arguments), raw=True):
                if pace.message():
                    say(f"{pace.figures()['rate_hz']:.3f} messages a second")
                if count and pace.count >= count:
                    break
        except KeyboardInterrupt:
            if not pace.count:
                raise
    return Outcome(pace.figures(), [])


def topic_info(arguments) -> Outcome:
    """Who publishes a topic and who listens."""
    with _graph(arguments) as graph:
        ends = graph.ends(arguments.topic)
    rows = [{"end": key[:-1], **one} for key, found in ends.items() for one in found]
    return listed("ends", ("end", "node", "type", "reliability", "durability"), rows)


def publish(arguments) -> Outcome:
    """Publishes a message."""
    rate = number("--rate", arguments.rate, limits=Limits(above=0.0, at_most=1000.0))
    with _graph(arguments) as graph:
        sent = graph.publish(arguments.topic, arguments.type, _yaml(arguments.message), _count(arguments), rate)
    return Outcome({"topic": arguments.topic, "published": sent}, [])


# Parameters


def parameter_list(arguments) -> Outcome:
    """The parameters of a node with their values."""
    with _graph(arguments) as graph:
        found = graph.parameter_values(arguments.node)
        doubts = graph.rivals(f"{arguments.node}/get_parameters")
    rows = ({"name": name, "value": value} for name, value in found.items())
    return listed("parameters", ("name", "value"), rows)._replace(doubts=doubts)


def parameter_get(arguments) -> Outcome:
    """One parameter."""
    with _graph(arguments) as graph:
        found = graph.parameter(arguments.node, [arguments.name])
        return Outcome(found, graph.rivals(f"{arguments.node}/get_parameters"))


def parameter_describe(arguments) -> Outcome:
    """What a node says of a parameter."""
    with _graph(arguments) as graph:
        said = graph.describe(arguments.node, arguments.name)
    return Outcome(said, [], lambda: print(_shown(said), end=""))


def parameter_set(arguments) -> Outcome:
    """Sets a parameter and reads it again."""
    with _graph(arguments) as graph:
        graph.set_parameter(arguments.node, arguments.name, _yaml(arguments.value))
        found = graph.parameter(arguments.node, [arguments.name])
        return Outcome(found, graph.rivals(f"{arguments.node}/set_parameters"))


# Services, actions, studies


def call(arguments) -> Outcome:
    """The answer of a service; one that reports no success ends as bad input does."""
    with _graph(arguments) as graph:
        answer = graph.call(arguments.service, arguments.type, _yaml(arguments.request))
        doubts = graph.rivals(arguments.service)
    refused = f"{arguments.service}: {answer.get('message')}" if answer.get("success") is False else ""
    return Outcome(answer, doubts, lambda: print(_shown(answer), end=""), problem=refused)


def send_goal(arguments) -> Outcome:
    """How a goal ended, and its result; aborted ones end as bad input does, canceled ones with a doubt."""
    from bearing_twin.command.terminal import say

    tell = (lambda one: say(_shown(one).rstrip())) if arguments.feedback else lambda one: None
    with _graph(arguments) as graph:
        status, result = graph.send_goal(arguments.action, arguments.type, _yaml(arguments.goal), tell)
        doubts = graph.rivals(arguments.action, action=True)
    answer = {"status": status, "result": result}
    doubts += ["the goal was canceled"] if status == "canceled" else []
    failed = "" if status in ("succeeded", "canceled") else f"the goal was {status}"
    return Outcome(answer, doubts, lambda: print(_shown(answer), end=""), problem=failed)


def study(arguments) -> Outcome:
    """Sends a study to a uq_node and shows its result as `bearing_twin study` does."""
    import json

    from bearing_twin.command import study_command
    from bearing_twin.command.terminal import progress
    from bearing_twin.log.study_log import NAMESPACE
    from bearing_twin.uq.result import doubts_told

    overrides_of(arguments, samples="samples", seed="seed")
    goal = {"study": arguments.study, "overrides": arguments.set}
    for key in ("samples", "seed"):
        if (text := getattr(arguments, key)) is not None:
            goal[key] = _yaml(text)
    with _graph(arguments) as graph, progress(f"study {arguments.study}") as update:
        tell = lambda one: update(one["done"] / max(one["total"], 1))  # noqa: E731
        action = arguments.action or f"{NAMESPACE}/run_study"
        status, result = graph.send_goal(action, None, goal, tell)
        rivals = graph.rivals(action, action=True)
    if not result["summary"]:
        raise BearingTwinError(f"the study was {status}: {result['message']}")
    summary = json.loads(result["summary"]) | ({"log": result["log"]} if result["log"] else {})
    doubts = rivals + ([] if status == "succeeded" else [f"the study was {status}: {result['message']}"])
    doubts += doubts_told(summary)
    return Outcome(summary, doubts, lambda: study_command.show(summary))


def start(arguments) -> Outcome:
    """Becomes a node of this package."""
    replace_by_node(arguments.executable, arguments.words)
