"""`bearing_twin node`: nodes from the shell for those who have ROS 2 from PyPI, without `ros2`.

The words are those of `ros2`, whose other verbs are not repeated here. ROS is imported only when a verb runs.
"""

import argparse
import importlib
import json
import math
import os
import statistics
import sys
import textwrap
import time
from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

from bearing_twin.base.errors import ROS_ARGS, BearingTwinError, echo, legal_hint
from bearing_twin.base.process import AT_END
from bearing_twin.base.report import json_text
from bearing_twin.base.units import Limits
from bearing_twin.command.outcome import ALLOW_INVALID, Outcome, Subcommand, listed, overrides_of, quantity
from bearing_twin.command.terminal import progress, say, show_text

NODES = ("sim_node", "recorder_node", "replay_node", "uq_node", "watch_node")
SHOWN_NUMBERS = 128  # numbers of an array that are shown
REPORT_PERIOD = 1.0  # s


# A node as this process


def node_arguments(node: str, arguments: Sequence[str]) -> list[str]:
    """The arguments of Python that start a node; a missing `--ros-args` is added. Raises BearingTwinError."""
    if node not in NODES:
        raise BearingTwinError(f"{echo(node)} is no node of this package; {legal_hint(node, NODES)}")
    arguments_of_node = list(arguments)
    if arguments_of_node and arguments_of_node[0] != ROS_ARGS and not {"-h", "--help"} & set(arguments_of_node):
        arguments_of_node.insert(0, ROS_ARGS)
    return ["-m", "bearing_twin.nodes.entry", node, *arguments_of_node]


def replace_by_node(node: str, arguments: Sequence[str]):
    """Never returns: signals, exit code and output are the node's own."""
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(sys.executable, [sys.executable, *node_arguments(node, arguments)])


# Other nodes


def _yaml(text: str | None):
    import yaml

    try:
        return yaml.safe_load(text or "")
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # an impossible date is a ValueError
        raise BearingTwinError(f"{echo(text)} is no YAML: write it in quotes, as '{{data: 250.0}}'") from error


def _message_text(data) -> str:
    """A message as YAML, with control characters escaped."""
    import yaml

    text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100, allow_unicode=False)
    return text.removesuffix("...\n")  # the end of a document that is one word or number


def _list(graph, arguments) -> Outcome:
    names = graph.nodes()
    warnings = [f"{names.count(name)} nodes are named {name}" for name in sorted({*names}) if names.count(name) > 1]
    if not names:
        warnings = ["no node was discovered: start one on this machine with the same ROS_DOMAIN_ID"]
    return listed("nodes", ("name",), ({"name": name} for name in names))._replace(warnings=warnings)


def _topics(graph, arguments) -> Outcome:
    return listed("topics", ("name", "type"), ({"name": name, "type": type} for name, type in graph.topics().items()))


def _endpoints(graph, arguments) -> Outcome:
    return listed("ends", ("end", "node", "reliability", "durability"), graph.ends(arguments.topic))


def _parameters(graph, arguments) -> Outcome:
    values = graph.parameters(arguments.node).items()
    return listed("parameters", ("name", "value"), ({"name": name, "value": value} for name, value in values))


def _parameter(graph, arguments) -> Outcome:
    return Outcome({arguments.name: graph.parameter(arguments.node, arguments.name)}, [])


def _set_parameter(graph, arguments) -> Outcome:
    value = graph.set_parameter(arguments.node, arguments.name, _yaml(arguments.value))
    return Outcome({arguments.name: value}, [])


def _receive(graph, arguments, handle: Callable, raw: bool = False) -> None:
    """Pass messages to `handle` up to --count or Ctrl-C, which is an interruption before the first message."""
    reasons = "nobody publishes it, or its node is paused or still preparing"
    silence = f"no message on {arguments.topic} for {arguments.wait:g} s: {reasons}"
    received = 0
    try:
        for received, message in enumerate(graph.messages(arguments.topic, lambda: say(silence), raw), start=1):
            handle(message)
            if received == arguments.count:
                return
    except KeyboardInterrupt:
        if not received:
            raise


def _echo(graph, arguments) -> Outcome:
    from bearing_twin.nodes.messages import plain_data

    longest = None if arguments.full_length or arguments.json else SHOWN_NUMBERS

    def show(message) -> None:
        data = _field(plain_data(message, longest), arguments.field)
        show_text(json_text(data) if arguments.json else f"{_message_text(data)}---")
        sys.stdout.flush()

    _receive(graph, arguments, show)
    return Outcome(None, [])


def _field(data, path: str | None):
    """The part of a message at a `path`, such as wrench.force."""
    for name in path.split(".") if path else ():
        if not isinstance(data, dict) or name not in data:
            legal = legal_hint(name, data) if isinstance(data, dict) else "there are no fields below"
            raise BearingTwinError(f"--field {echo(path)}: there is no {echo(name)}; {legal}")
        data = data[name]
    return data


class Traffic:
    """Times of arrival [s] and sizes [B] of the last `window` messages and the one before, and their statistics."""

    def __init__(self, window: int):
        self._last, self.count = deque(maxlen=window + 1), 0

    def add(self, time_s: float, size: int) -> None:
        """Take a message."""
        self.count += 1
        self._last.append((time_s, size))

    def periods(self) -> dict[str, float]:
        """Rate [Hz], and mean, least, greatest and standard deviation of the periods [s]."""
        return self._statistics("rate_hz", 1, [b - a for (a, _), (b, _) in pairwise(self._last)], "{}_period_s")

    def sizes(self) -> dict[str, float]:
        """Rate [B/s], and mean, least, greatest and standard deviation of the sizes [B]."""
        lengths = [size for _, size in self._last][1:]
        return self._statistics("bytes_per_s", sum(lengths) / max(len(lengths), 1), lengths, "{}_bytes")

    def _statistics(self, rate: str, per_message: float, values: list, name: str) -> dict[str, float]:
        span = self._last[-1][0] - self._last[0][0] if values else 0.0
        numbers = {
            "messages": self.count,
            rate: per_message * len(values) / span if span else math.inf if values else math.nan,
        }
        if not values:
            return numbers
        functions = {"mean": statistics.fmean, "least": min, "greatest": max, "std_of": statistics.pstdev}
        return (
            numbers
            | {name.format(statistic): function(values) for statistic, function in functions.items()}
            | {"window": len(values)}
        )


def _measuring(figures: Callable[[Traffic], dict]) -> Callable:
    def run(graph, arguments) -> Outcome:
        traffic, reported = Traffic(arguments.window), time.monotonic()

        def handle(data: bytes) -> None:
            nonlocal reported
            now = time.monotonic()
            traffic.add(now, len(data))
            if now - reported >= REPORT_PERIOD:
                reported = now
                say(", ".join(f"{key} {value:.4g}" for key, value in figures(traffic).items()))

        _receive(graph, arguments, handle, raw=True)
        return Outcome(figures(traffic), [])

    return run


def _publish(graph, arguments) -> Outcome:
    """Publish, and print the warnings of subscribers meanwhile, as of a refused command."""
    message = _yaml(arguments.message)
    sent = graph.publish(arguments.topic, arguments.type, message, arguments.count, arguments.rate, say)
    return Outcome({"topic": arguments.topic, "published": sent}, [])


def _call(graph, arguments) -> Outcome:
    """The answer of a service; without success the exit code is that of bad input."""
    ros_type, fields = arguments.type, arguments.message
    if fields is None and (ros_type or "").startswith("{"):
        ros_type, fields = None, ros_type
    answer = graph.call(arguments.service, ros_type, _yaml(fields))
    refused = f"{arguments.service}: {answer.get('message')}" if answer.get("success") is False else ""
    return Outcome(answer, [], lambda: print(_message_text(answer), end=""), problem=refused)


def _study(graph, arguments) -> Outcome:
    """Send a study to a uq_node and show its result as `bearing_twin study` does."""
    from bearing_twin.command import study_command
    from bearing_twin.log.study_log import NAMESPACE
    from bearing_twin.uq.result import warnings_of

    goal = {"study": arguments.study, "overrides": overrides_of(arguments, samples="samples", seed="seed")}
    with progress(f"study {arguments.study}") as update:
        report = lambda feedback: update(feedback["done"] / max(feedback["total"], 1))  # noqa: E731
        status, result = graph.run_study(arguments.action or f"{NAMESPACE}/run_study", goal, report)
    sentence = f"the study was {status}: {result['message']}"
    if not result["summary"]:
        raise BearingTwinError(sentence)
    summary = json.loads(result["summary"]) | ({"log": result["log"]} if result["log"] else {})
    warnings = [] if status == "succeeded" else [sentence]
    return Outcome(summary, warnings + warnings_of(summary), lambda: study_command.show(summary))


# The table of verbs


class Verb(NamedTuple):
    """A command below `node`: its words, help, function, arguments and options, and an example."""

    words: str
    help: str
    run: Callable
    arguments: str = ""
    example: str = ""

    @property
    def line(self) -> str:
        """The verb as it would be typed."""
        return f"bearing_twin node {self.words} {self.example}".rstrip()


# fmt: off
ARGUMENTS = {
    "executable": {"help": ", ".join(NODES)},
    "words": {"nargs": argparse.REMAINDER, "metavar": "...", "help": "as after ros2 run: -p scene:=bearing_6205"},
    "node": {"help": "full name of a node, such as /bearing/sim_node"},
    "topic": {"help": "full name of a topic, such as /bearing/state"},
    "service": {"help": "full name of a service, such as /bearing/sim_node/pause"},
    "name": {"help": "a parameter"},
    "value": {"help": "its value in YAML"},
    "type": {"help": "its type; that of a service may be omitted"},
    "message": {"nargs": "?", "help": "its fields in YAML; others keep their defaults"},
    "study": {"help": "name of a study, or path of a YAML file where the node runs"},
    "--field": {"metavar": "PATH", "help": "print this field alone, such as wrench.force"},
    "--full-length": {"action": "store_true", "help": f"arrays beyond {SHOWN_NUMBERS} numbers too"},
    "--once": {"action": "store_const", "dest": "count", "const": 1, "default": argparse.SUPPRESS,
               "help": "the same as --count 1"},
    "--count": {"metavar": "N", "type": quantity("", Limits(at_least=0), integer=True), "default": 0,
                "help": "end after N messages; 0 = on Ctrl-C (default)"},
    "--window": {"metavar": "N", "type": quantity("", Limits(at_least=1, at_most=1_000_000), integer=True),
                 "default": 10_000, "help": "of the last N messages (default: 10000)"},
    "--rate": {"metavar": "HZ", "type": quantity("", Limits(above=0.0, at_most=1000.0)), "default": 1.0,
               "help": "messages a second (default: 1)"},
    "--set": {"action": "append", "default": [], "metavar": "KEY=VALUE", "help": "change a key of the study"},
    ALLOW_INVALID[0]: ALLOW_INVALID[1],
    "--samples": {"metavar": "N", "help": "realisations at most"},
    "--seed": {"metavar": "S", "help": "of every random choice"},
    "--action": {"metavar": "ACTION", "help": "full name of the action (default: /bearing/run_study)"},
    "--wait": {"metavar": "SECONDS", "type": quantity("s", Limits(at_least=0.0, at_most=3600.0)), "default": 10.0,
               "help": "wait at most this long for nodes, topics and answers (default: 10)"},
}
VERBS = (
    Verb("list", "the running nodes", _list),
    Verb("start", "run a node of this package in this shell; --help after its name lists its parameters",
         lambda arguments: replace_by_node(arguments.executable, arguments.words), "executable words",
         "sim_node -p scene:=bearing_6203_loose -p duration:=2.0"),
    Verb("topic list", "the topics with their types", _topics),
    Verb("topic info", "publishers and subscriptions of a topic", _endpoints, "topic", "/tf"),
    Verb("topic echo", "print messages as they come; with --json one object a line", _echo,
         "topic --field --full-length --once --count", "/bearing/ball_0/wrench --field wrench.force"),
    Verb("topic hz", "rate, and least, greatest and deviation of the periods", _measuring(Traffic.periods),
         "topic --count --window", "/bearing/state"),
    Verb("topic bw", "bytes a second, and sizes", _measuring(Traffic.sizes), "topic --count --window",
         "/bearing/state"),
    Verb("topic pub", "publish a message as soon as somebody listens, and print what the listening node warns of",
         _publish, "topic type message --once --count --rate",
         "--once /bearing/command/speed std_msgs/msg/Float64 '{data: 250.0}'"),
    Verb("param list", "the parameters of a node with their values", _parameters, "node", "/bearing/sim_node"),
    Verb("param get", "one parameter of a node", _parameter, "node name", "/bearing/sim_node scene"),
    Verb("param set", "set a parameter of a node", _set_parameter, "node name value",
         "/bearing/sim_node real_time_factor 0.5"),
    Verb("service call", "call a service and print its answer", _call, "service type? message",
         "/bearing/sim_node/pause std_srvs/srv/SetBool '{data: true}'"),
    Verb("study", "run a study in a uq_node and show its result; Ctrl-C ends it with the realisations so far", _study,
         f"study --set {ALLOW_INVALID[0]} --samples --seed --action", "spheres_alpha_4e-5 --samples 1000"),
)
# fmt: on


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = "Nodes are seen within one ROS_DOMAIN_ID. Ctrl-C ends a command that runs on."
    form = {"formatter_class": argparse.RawDescriptionHelpFormatter}
    groups = {"": parser.add_subparsers(dest="verb", metavar="VERB", required=True)}
    for verb in VERBS:
        name, _, last = verb.words.rpartition(" ")
        if name not in groups:
            members = [member for member in VERBS if member.words.startswith(f"{name} ")]
            examples = "\n  ".join(["examples:", *(member.line for member in members)])
            names = ", ".join(member.words.removeprefix(f"{name} ") for member in members)
            group = groups[""].add_parser(name, help=names, epilog=examples, **form)
            groups[name] = group.add_subparsers(metavar="VERB", required=True)
        about = {"help": verb.help, "description": textwrap.fill(verb.help, 78), "epilog": f"example:\n  {verb.line}"}
        leaf = groups[name].add_parser(last, allow_abbrev=False, **about, **form)
        leaf.set_defaults(run_verb=verb.run)
        for argument in verb.arguments.split():
            optional = {"nargs": "?"} if argument.endswith("?") else {}
            leaf.add_argument(argument.rstrip("?"), **ARGUMENTS[argument.rstrip("?")] | optional)
        if verb.words != "start":
            leaf.add_argument("--wait", **ARGUMENTS["--wait"])
            for option in ("--json", "--si", "--strict", "--force"):
                leaf.add_argument(option, action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)


def _run(arguments) -> Outcome:
    """Run a verb, all but `start` with the graph of nodes; raises MissingInterfacesError without ROS."""
    if arguments.verb == "start":
        return arguments.run_verb(arguments)
    importlib.import_module("bearing_twin.nodes.messages")  # raises in one sentence where ROS is missing
    from bearing_twin.nodes.graph import Graph

    graph = Graph(arguments.wait)
    AT_END.append(graph.close)
    return arguments.run_verb(graph, arguments)


NODE = Subcommand(
    "nodes, topics, parameters and services of ROS 2, with the syntax of ros2, which need not be installed",
    _add_arguments,
    _run,
    tuple(verb.line for verb in VERBS if verb.words in ("start", "topic echo", "param set", "study")),
)
