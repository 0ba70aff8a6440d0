"""`bearing_twin node`: nodes, topics, parameters, services and actions from the shell, in the words of `ros2`.

It is for those who have ROS 2 from PyPI, where there is no `ros2`.
"""

import argparse
import textwrap
from collections.abc import Callable
from typing import NamedTuple

from bearing_twin.command import node_verbs
from bearing_twin.command.node_start import NODES
from bearing_twin.command.outcome import ALLOW_INVALID, Outcome

HELP = "nodes, topics, parameters, services and actions of ROS 2, in the words of ros2, without a ros2"
NODE_ARGUMENT = ("node", "full name of a node, such as /bearing/sim_node")
TOPIC_ARGUMENT = ("topic", "full name of a topic, such as /bearing/state")


class Verb(NamedTuple):
    """One command below `node`: its words, what it does, arguments (name, help), options, and who runs it."""

    words: tuple[str, ...]
    help: str
    run: Callable[[argparse.Namespace], Outcome]
    arguments: tuple[tuple[str, str], ...] = ()
    options: tuple[tuple[str, dict], ...] = ()
    example: str = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the verbs below `node` to its parser."""
    parser.epilog = "Graphs are seen in one ROS_DOMAIN_ID. Ctrl-C ends what runs on."
    groups = {(): parser.add_subparsers(dest="verb", metavar="VERB", required=True)}
    for words, verb in [(one.words, one) for one in VERBS] + [(words, _verb(full)) for words, full in SHORT.items()]:
        for length in range(1, len(words)):
            if words[:length] not in groups:
                said = [f"  {_line(one.words)}" for one in VERBS if one.words[:length] == words[:length]]
                group = groups[words[: length - 1]].add_parser(
                    words[length - 1],
                    help=GROUPS[words[length - 1]],
                    epilog="\n".join(["examples:", *said]),
                    formatter_class=argparse.RawDescriptionHelpFormatter,
                )
                groups[words[:length]] = group.add_subparsers(dest="what", metavar="VERB", required=True)
        short = "" if words == verb.words else f" (short for {' '.join(verb.words)})"
        leaf = groups[words[:-1]].add_parser(
            words[-1],
            help=verb.help + short,
            description=textwrap.fill(verb.help, 78),
            epilog=f"example:\n  {_line(words)}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        _fill(leaf, verb)


def _fill(leaf, verb: Verb) -> None:
    for name, text in verb.arguments:
        optional = {"nargs": "?"} if name.endswith("?") else {}
        leaf.add_argument(name.rstrip("?"), help=text, **optional)
    for name, settings in verb.options:
        leaf.add_argument(name, **settings)
    leaf.set_defaults(run_verb=verb.run)
    if verb.run is not node_verbs.start:
        text = "how long to wait for what is asked for, at most (default: 10)"
        leaf.add_argument("--wait", metavar="SECONDS", default="10", help=text)
        for name in ("--json", "--si", "--strict"):
            leaf.add_argument(name, action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace) -> Outcome:
    """Runs the verb; raises BearingTwinError in one sentence for what is not there or is refused."""
    return arguments.run_verb(arguments)


GROUPS = {
    "topic": "list, read, publish, time",
    "param": "list, get, describe, set",
    "service": "list, call",
    "action": "list, send a goal",
}
_COUNT = ("--count", {"metavar": "N", "default": "0", "help": "end after so many; 0 = not by itself (default)"})
_ONCE = ("--once", {"action": "store_true", "help": "the same as --count 1"})
VERBS = (
    Verb(("list",), "the nodes that are to be seen", node_verbs.names("node")),
    Verb(
        ("start",),
        "run a node of this package in this shell; --help after its name lists its parameters",
        node_verbs.start,
        (("executable", ", ".join(NODES)),),
        (
            (
                "words",
                {"nargs": argparse.REMAINDER, "metavar": "...", "help": "as after ros2 run: -p scene:=bearing_6205"},
            ),
        ),
        "sim_node -p scene:=bearing_6203_loose -p duration:=2.0",
    ),
    Verb(("topic", "list"), "the topics with their types", node_verbs.names("topic")),
    Verb(
        ("topic", "echo"),
        "print messages as they come; with --json one object a line",
        node_verbs.echo_topic,
        (TOPIC_ARGUMENT,),
        (
            ("--field", {"metavar": "PATH", "help": "only this part of it, such as wrench.force"}),
            ("--full-length", {"action": "store_true", "help": f"arrays beyond {node_verbs.SHORT_LIST} numbers too"}),
            _ONCE,
            _COUNT,
        ),
        "/bearing/ball_0/wrench --field wrench.force",
    ),
    Verb(
        ("topic", "hz"),
        "how many messages come a second",
        node_verbs.hz,
        (TOPIC_ARGUMENT,),
        (_COUNT,),
        "/bearing/state",
    ),
    Verb(
        ("topic", "info"), "who publishes a topic and who listens", node_verbs.topic_info, (TOPIC_ARGUMENT,), (), "/tf"
    ),
    Verb(
        ("topic", "pub"),
        "publish a message, as soon as somebody listens",
        node_verbs.publish,
        (TOPIC_ARGUMENT, ("type", "its type"), ("message?", "its fields in YAML; others keep their defaults")),
        (_ONCE, _COUNT, ("--rate", {"metavar": "HZ", "default": "1", "help": "messages a second (default: 1)"})),
        "--once /bearing/command/speed std_msgs/msg/Float64 '{data: 250.0}'",
    ),
    Verb(
        ("param", "list"),
        "the parameters of a node with their values",
        node_verbs.parameter_list,
        (NODE_ARGUMENT,),
        (),
        "/bearing/sim_node",
    ),
    Verb(
        ("param", "get"),
        "one parameter of a node",
        node_verbs.parameter_get,
        (NODE_ARGUMENT, ("name", "a parameter")),
        (),
        "/bearing/sim_node scene",
    ),
    Verb(
        ("param", "describe"),
        "meaning, type and range of a parameter",
        node_verbs.parameter_describe,
        (NODE_ARGUMENT, ("name", "a parameter")),
        (),
        "/bearing/sim_node real_time_factor",
    ),
    Verb(
        ("param", "set"),
        "set a parameter of a node",
        node_verbs.parameter_set,
        (NODE_ARGUMENT, ("name", "a parameter"), ("value", "its value in YAML")),
        (),
        "/bearing/sim_node real_time_factor 0.5",
    ),
    Verb(("service", "list"), "the services with their types", node_verbs.names("service")),
    Verb(
        ("service", "call"),
        "call a service and print its answer",
        node_verbs.call,
        (
            ("service", "full name of a service, such as /bearing/sim_node/pause"),
            ("type?", "its type; looked up where it is left out"),
            ("request?", "its fields in YAML"),
        ),
        (),
        "/bearing/sim_node/pause std_srvs/srv/SetBool '{data: true}'",
    ),
    Verb(("action", "list"), "the actions with their types", node_verbs.names("action")),
    Verb(
        ("action", "send_goal"),
        "send a goal, wait for its end and print the result; Ctrl-C cancels it",
        node_verbs.send_goal,
        (("action", "full name of an action"), ("type?", "its type"), ("goal?", "its fields in YAML")),
        (("--feedback", {"action": "store_true", "help": "print the feedback too, on standard error"}),),
        "/bearing/run_study bearing_twin_msgs/action/RunStudy '{study: spheres_alpha_4e-5, samples: 1000}'",
    ),
    Verb(
        ("study",),
        "run a study in a uq_node and show its result; Ctrl-C ends it with what is done",
        node_verbs.study,
        (("study", "name of a study, or path of a YAML file where the node runs"),),
        (
            (
                "--set",
                {"action": "append", "default": [], "metavar": "KEY=VALUE", "help": "change one key of the study"},
            ),
            ALLOW_INVALID,
            ("--samples", {"metavar": "N", "help": "realisations at most"}),
            ("--seed", {"metavar": "S", "help": "of every random choice"}),
            (
                "--action",
                {
                    "metavar": "ACTION",
                    "help": "full name of the action, if it is not that of a uq_node of no namespace",
                },
            ),
        ),
        "spheres_alpha_4e-5 --samples 1000",
    ),
)
SHORT = {("echo",): ("topic", "echo"), ("set",): ("param", "set"), ("call",): ("service", "call")}


def _verb(words: tuple[str, ...]) -> Verb:
    return next(one for one in VERBS if one.words == words)


def _line(words: tuple[str, ...]) -> str:
    """An example of the verb that these words call."""
    return f"bearing_twin node {' '.join(words)} {_verb(SHORT.get(words, words)).example}".rstrip()


EXAMPLES = tuple(_line(words) for words in (("start",), ("topic", "echo"), ("param", "set"), ("study",)))
