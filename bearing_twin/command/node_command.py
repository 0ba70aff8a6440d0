"""`bearing_twin node` and `watch`: nodes from the shell for those who have ROS 2 from PyPI, without `ros2`.

The words are those of `ros2`, whose other verbs are not repeated here. ROS is imported only when a verb runs.
"""

import argparse
import importlib
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

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.messages import ROS_ARGS, unknown
from bearing_twin.base.parameters import echo
from bearing_twin.base.report import json_text
from bearing_twin.base.units import Limits
from bearing_twin.command.outcome import ALLOW_INVALID, Outcome, Subcommand, listed, number, overrides_of

NODES = ("sim_node", "recorder_node", "replay_node", "uq_node", "watch_node")
SHORT_LIST = 128  # numbers of an array that are shown
SAID_EVERY = 1.0  # s


class Verb(NamedTuple):
    """One command below `node`: its words, what it does, arguments (name, help), options, and who runs it."""

    words: str
    help: str
    run: Callable[[argparse.Namespace], Outcome]
    arguments: tuple[tuple[str, str], ...] = ()
    options: tuple[tuple[str, dict], ...] = ()
    example: str = ""

    @property
    def line(self) -> str:
        """The verb as it would be typed."""
        return f"bearing_twin node {self.words} {self.example}".rstrip()


# A node as this process


def words_of(node: str, words: Sequence[str]) -> list[str]:
    """The words after the name of Python; `--ros-args` is added where it is missing. Raises BearingTwinError."""
    if node not in NODES:
        raise BearingTwinError(f"{echo(node)} is no node of this package; {unknown(node, NODES)}")
    rest = list(words)
    if rest and rest[0] != ROS_ARGS and not {"-h", "--help"} & set(rest):
        rest.insert(0, ROS_ARGS)
    return ["-m", "bearing_twin.nodes.entry", node, *rest]


def replace_by_node(node: str, words: Sequence[str]):
    """Never returns: signals, exit code and output are the node's own."""
    command = [sys.executable, *words_of(node, words)]
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(command[0], command)


def _start(arguments) -> Outcome:
    replace_by_node(arguments.executable, arguments.words)


def _watch_arguments(parser) -> None:
    parser.add_argument("--node", default="", help="full name of the node; without, the only one with samples")
    parser.add_argument("--port", default="8080", help="port to listen on; 0 = any that is free (default: 8080)")
    parser.add_argument(
        "--host",
        default="localhost",
        help="address to listen on; any but localhost lets other machines look and command",
    )


def _watch(arguments) -> Outcome:
    if not (arguments.port.isdecimal() and int(arguments.port) < 65536):
        raise BearingTwinError(f"--port {echo(arguments.port)} must be a whole number from 0 to 65535")
    for name in ("node", "host"):
        if set(getattr(arguments, name)) & set("'\"\n\\"):
            raise BearingTwinError(f"--{name} {echo(getattr(arguments, name))} is no name")
    given = {"port": arguments.port, "host": f"'{arguments.host}'", "node": f"'{arguments.node}'"}
    replace_by_node("watch_node", [word for key, text in given.items() for word in ("-p", f"{key}:={text}")])


# Other nodes


def _graph(arguments):
    """The graph of nodes, for a `with` statement; raises MissingInterfacesError where ROS is missing."""
    importlib.import_module("bearing_twin.nodes.messages")  # says in one sentence what is missing, if anything is
    from bearing_twin.nodes.graph import Graph

    return Graph(number("--wait", arguments.wait, limits=Limits(at_least=0.0, at_most=3600.0)))


def _count(arguments) -> int:
    value = number("--count", arguments.count, limits=Limits(at_least=0), integer=True)
    return 1 if getattr(arguments, "once", False) else value


def _yaml(text: str | None):
    import yaml

    try:
        return yaml.safe_load(text or "")
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # an impossible date is a ValueError
        raise BearingTwinError(f"{echo(text)} is no YAML: write it in quotes, as '{{data: 250.0}}'") from error


def _shown(data) -> str:
    """A message as YAML; what could steer a terminal is escaped."""
    import yaml

    text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100, allow_unicode=False)
    return text.removesuffix("...\n")  # the end of a document that is one word or number


def _list(arguments) -> Outcome:
    with _graph(arguments) as graph:
        found = graph.nodes()
    several = [f"{found.count(name)} nodes are named {name}" for name in sorted({*found}) if found.count(name) > 1]
    return listed("nodes", ("name",), ({"name": name} for name in found))._replace(doubts=several)


def _topic_list(arguments) -> Outcome:
    with _graph(arguments) as graph:
        found = graph.topics()
    return listed("topics", ("name", "type"), ({"name": name, "type": kind} for name, kind in found.items()))


def _topic_info(arguments) -> Outcome:
    with _graph(arguments) as graph:
        return listed("ends", ("end", "node", "type", "reliability", "durability"), graph.ends(arguments.topic))


def _each(arguments, take: Callable, raw: bool = False) -> None:
    """Hands messages to `take` until --count of them or Ctrl-C, which interrupts who waits for the first."""
    from bearing_twin.command.terminal import say

    silent = f"nothing has come on {arguments.topic} for {arguments.wait} s: is its node paused, or still preparing?"
    left, came = _count(arguments), False
    with _graph(arguments) as graph:
        try:
            for message in graph.messages(arguments.topic, lambda: say(silent), raw):
                take(message)
                came, left = True, left - 1
                if left == 0:
                    break
        except KeyboardInterrupt:
            if not came:
                raise


def _echo(arguments) -> Outcome:
    from bearing_twin.command.terminal import show_text

    most = None if arguments.full_length or arguments.json else SHORT_LIST

    def show(message) -> None:
        from bearing_twin.nodes.messages import plain

        data = _field(plain(message, most), arguments.field)
        show_text(json_text(data) if arguments.json else f"{_shown(data)}---")
        sys.stdout.flush()

    _each(arguments, show)
    return Outcome(None, [])


def _field(data, path: str | None):
    """The part of a message that `path`, such as wrench.force, leads to."""
    for name in path.split(".") if path else ():
        if not isinstance(data, dict) or name not in data:
            legal = unknown(name, data) if isinstance(data, dict) else "there are no fields below"
            raise BearingTwinError(f"--field {echo(path)}: there is no {echo(name)}; {legal}")
        data = data[name]
    return data


class Traffic:
    """Times of arrival [s] and sizes [B] of the last `window` messages and the one before, and their statistics."""

    def __init__(self, window: int):
        self._last, self.count = deque(maxlen=window + 1), 0

    def add(self, time_s: float, size: int) -> None:
        """Takes a message."""
        self.count += 1
        self._last.append((time_s, size))

    def periods(self) -> dict[str, float]:
        """Rate [Hz], and mean, least, greatest and standard deviation of the periods [s]."""
        periods = [later[0] - earlier[0] for earlier, later in pairwise(self._last)]
        if not periods:
            return {"messages": self.count, "rate_hz": math.nan}
        mean = statistics.fmean(periods)
        return {
            "messages": self.count,
            "rate_hz": 1.0 / mean if mean else math.inf,
            "mean_period_s": mean,
            "least_period_s": min(periods),
            "greatest_period_s": max(periods),
            "std_of_period_s": statistics.pstdev(periods, mean),
            "window": len(periods),
        }

    def sizes(self) -> dict[str, float]:
        """Rate [B/s], and mean, least and greatest size [B]."""
        sizes = [size for _, size in self._last][1:]
        span = self._last[-1][0] - self._last[0][0] if sizes else 0.0
        if not span:
            return {"messages": self.count, "bytes_per_s": math.nan}
        return {
            "messages": self.count,
            "bytes_per_s": sum(sizes) / span,
            "mean_bytes": statistics.fmean(sizes),
            "least_bytes": min(sizes),
            "greatest_bytes": max(sizes),
            "window": len(sizes),
        }


def _measured(figures: Callable[[Traffic], dict]) -> Callable[[argparse.Namespace], Outcome]:
    def run(arguments) -> Outcome:
        from bearing_twin.command.terminal import say

        window = number("--window", arguments.window, limits=Limits(at_least=1, at_most=1_000_000), integer=True)
        traffic, said = Traffic(window), time.monotonic()

        def take(data: bytes) -> None:
            nonlocal said
            now = time.monotonic()
            traffic.add(now, len(data))
            if now - said >= SAID_EVERY:
                said = now
                say(", ".join(f"{key} {value:.4g}" for key, value in figures(traffic).items()))

        _each(arguments, take, raw=True)
        return Outcome(figures(traffic), [])

    return run


def _publish(arguments) -> Outcome:
    rate = number("--rate", arguments.rate, limits=Limits(above=0.0, at_most=1000.0))
    with _graph(arguments) as graph:
        sent = graph.publish(arguments.topic, arguments.type, _yaml(arguments.message), _count(arguments), rate)
    return Outcome({"topic": arguments.topic, "published": sent}, [])


def _parameter_list(arguments) -> Outcome:
    with _graph(arguments) as graph:
        found = graph.parameters(arguments.node)
    return listed("parameters", ("name", "value"), ({"name": name, "value": value} for name, value in found.items()))


def _parameter_get(arguments) -> Outcome:
    with _graph(arguments) as graph:
        return Outcome({arguments.name: graph.parameter(arguments.node, arguments.name)}, [])


def _parameter_set(arguments) -> Outcome:
    with _graph(arguments) as graph:
        value = graph.set_parameter(arguments.node, arguments.name, _yaml(arguments.value))
        return Outcome({arguments.name: value}, [])


def _call(arguments) -> Outcome:
    """The answer of a service; one that reports no success ends as bad input does."""
    with _graph(arguments) as graph:
        answer = graph.call(arguments.service, arguments.type, _yaml(arguments.request))
    refused = f"{arguments.service}: {answer.get('message')}" if answer.get("success") is False else ""
    return Outcome(answer, [], lambda: print(_shown(answer), end=""), problem=refused)


def _study(arguments) -> Outcome:
    """Sends a study to a uq_node and shows its result as `bearing_twin study` does."""
    import json

    from bearing_twin.command import study_command
    from bearing_twin.command.terminal import progress
    from bearing_twin.log.study_log import NAMESPACE
    from bearing_twin.uq.result import warnings_of

    overrides_of(arguments, samples="samples", seed="seed")
    goal = {"study": arguments.study, "overrides": arguments.set}
    for key in ("samples", "seed"):
        if (text := getattr(arguments, key)) is not None:
            goal[key] = _yaml(text)
    with _graph(arguments) as graph, progress(f"study {arguments.study}") as update:
        tell = lambda one: update(one["done"] / max(one["total"], 1))  # noqa: E731
        status, result = graph.run_study(arguments.action or f"{NAMESPACE}/run_study", goal, tell)
    if not result["summary"]:
        raise BearingTwinError(f"the study was {status}: {result['message']}")
    summary = json.loads(result["summary"]) | ({"log": result["log"]} if result["log"] else {})
    doubts = [] if status == "succeeded" else [f"the study was {status}: {result['message']}"]
    return Outcome(summary, doubts + warnings_of(summary), lambda: study_command.show(summary))


# The table of verbs

_NODE = ("node", "full name of a node, such as /bearing/sim_node")
_TOPIC = ("topic", "full name of a topic, such as /bearing/state")
_COUNT = ("--count", {"metavar": "N", "default": "0", "help": "end after so many; 0 = not by itself (default)"})
_ONCE = ("--once", {"action": "store_true", "help": "the same as --count 1"})
_WINDOW = ("--window", {"metavar": "N", "default": "10000", "help": "of the last N messages (default: 10000)"})
_REST = ("words", {"nargs": argparse.REMAINDER, "metavar": "...", "help": "as after ros2 run: -p scene:=bearing_6205"})
VERBS = (
    Verb("list", "the nodes that are to be seen", _list),
    Verb(
        "start",
        "run a node of this package in this shell; --help after its name lists its parameters",
        _start,
        (("executable", ", ".join(NODES)),),
        (_REST,),
        "sim_node -p scene:=bearing_6203_loose -p duration:=2.0",
    ),
    Verb("topic list", "the topics with their types", _topic_list),
    Verb("topic info", "publishers and subscriptions of a topic", _topic_info, (_TOPIC,), (), "/tf"),
    Verb(
        "topic echo",
        "print messages as they come; with --json one object a line",
        _echo,
        (_TOPIC,),
        (
            ("--field", {"metavar": "PATH", "help": "only this part of it, such as wrench.force"}),
            ("--full-length", {"action": "store_true", "help": f"arrays beyond {SHORT_LIST} numbers too"}),
            _ONCE,
            _COUNT,
        ),
        "/bearing/ball_0/wrench --field wrench.force",
    ),
    Verb(
        "topic hz",
        "rate, and least, greatest and deviation of the periods",
        _measured(Traffic.periods),
        (_TOPIC,),
        (_COUNT, _WINDOW),
        "/bearing/state",
    ),
    Verb(
        "topic bw",
        "bytes a second, and sizes",
        _measured(Traffic.sizes),
        (_TOPIC,),
        (_COUNT, _WINDOW),
        "/bearing/state",
    ),
    Verb(
        "topic pub",
        "publish a message, as soon as somebody listens",
        _publish,
        (_TOPIC, ("type", "its type"), ("message?", "its fields in YAML; others keep their defaults")),
        (_ONCE, _COUNT, ("--rate", {"metavar": "HZ", "default": "1", "help": "messages a second (default: 1)"})),
        "--once /bearing/command/speed std_msgs/msg/Float64 '{data: 250.0}'",
    ),
    Verb(
        "param list", "the parameters of a node with their values", _parameter_list, (_NODE,), (), "/bearing/sim_node"
    ),
    Verb(
        "param get",
        "one parameter of a node",
        _parameter_get,
        (_NODE, ("name", "a parameter")),
        (),
        "/bearing/sim_node scene",
    ),
    Verb(
        "param set",
        "set a parameter of a node",
        _parameter_set,
        (_NODE, ("name", "a parameter"), ("value", "its value in YAML")),
        (),
        "/bearing/sim_node real_time_factor 0.5",
    ),
    Verb(
        "service call",
        "call a service and print its answer",
        _call,
        (
            ("service", "full name of a service, such as /bearing/sim_node/pause"),
            ("type?", "its type; looked up if omitted"),
            ("request?", "its fields in YAML"),
        ),
        (),
        "/bearing/sim_node/pause std_srvs/srv/SetBool '{data: true}'",
    ),
    Verb(
        "study",
        "run a study in a uq_node and show its result; Ctrl-C ends it with the realisations so far",
        _study,
        (("study", "name of a study, or path of a YAML file where the node runs"),),
        (
            ("--set", {"action": "append", "default": [], "metavar": "KEY=VALUE", "help": "change a key of the study"}),
            ALLOW_INVALID,
            ("--samples", {"metavar": "N", "help": "realisations at most"}),
            ("--seed", {"metavar": "S", "help": "of every random choice"}),
            ("--action", {"metavar": "ACTION", "help": "full name of the action (default: /bearing/run_study)"}),
        ),
        "spheres_alpha_4e-5 --samples 1000",
    ),
)
GROUPS = {"topic": "list, info, echo, hz, bw, pub", "param": "list, get, set", "service": "call"}


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = "Nodes are seen within one ROS_DOMAIN_ID. Ctrl-C ends what runs on."
    form = {"formatter_class": argparse.RawDescriptionHelpFormatter}
    groups = {"": parser.add_subparsers(dest="verb", metavar="VERB", required=True)}
    for name, verbs in GROUPS.items():
        examples = "\n  ".join(["examples:", *(one.line for one in VERBS if one.words.startswith(f"{name} "))])
        group = groups[""].add_parser(name, help=verbs, epilog=examples, **form)
        groups[name] = group.add_subparsers(metavar="VERB", required=True)
    for verb in VERBS:
        group, _, last = verb.words.rpartition(" ")
        about = {"help": verb.help, "description": textwrap.fill(verb.help, 78), "epilog": f"example:\n  {verb.line}"}
        leaf = groups[group].add_parser(last, allow_abbrev=False, **about, **form)
        for name, text in verb.arguments:
            leaf.add_argument(name.rstrip("?"), help=text, **({"nargs": "?"} if name.endswith("?") else {}))
        for name, settings in verb.options:
            leaf.add_argument(name, **settings)
        leaf.set_defaults(run_verb=verb.run)
        if verb.run is not _start:
            text = "wait at most this long for nodes, topics and answers (default: 10)"
            leaf.add_argument("--wait", metavar="SECONDS", default="10", help=text)
            for name in ("--json", "--si", "--strict", "--force"):
                leaf.add_argument(name, action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)


NODE = Subcommand(
    "nodes, topics, parameters and services of ROS 2, in the words of ros2, without a ros2",
    _add_arguments,
    lambda arguments: arguments.run_verb(arguments),
    tuple(verb.line for verb in VERBS if verb.words in ("start", "topic echo", "param set", "study")),
)
WATCH = Subcommand(
    "show a running node in a browser, with speed, load, pause and reset to set",
    _watch_arguments,
    _watch,
    ("bearing_twin watch", "bearing_twin watch --port 8080"),
)
