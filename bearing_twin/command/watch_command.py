"""`bearing_twin watch`: this process becomes watch_node, which shows a running node in a browser."""

from bearing_twin.command.node_start import replace_by_node
from bearing_twin.command.outcome import Outcome
from bearing_twin.errors import BearingTwinError
from bearing_twin.parameters import echo

HELP = "show a running node in a browser, with speed, load, pause and reset to set"
EXAMPLES = ("bearing_twin watch", "bearing_twin watch --port 8080")


def add_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("--node", default="", help="full name of the node; without, the only one with samples")
    parser.add_argument("--port", default="8080", help="port to listen on; 0 = any that is free (default: 8080)")
    parser.add_argument(
        "--host",
        default="localhost",
        help="address to listen on; any but localhost lets other machines look and command",
    )


def run(arguments) -> Outcome:
    """Never returns but for bad input; raises BearingTwinError."""
    if not (arguments.port.isdecimal() and int(arguments.port) < 65536):
        raise BearingTwinError(f"--port {echo(arguments.port)} must be a whole number from 0 to 65535")
    for name in ("node", "host"):
        if set(getattr(arguments, name)) & set("'\"\n\\"):
            raise BearingTwinError(f"--{name} {echo(getattr(arguments, name))} is no name")
    given = {"port": arguments.port, "host": f"'{arguments.host}'", "node": f"'{arguments.node}'"}
    replace_by_node("watch_node", [word for key, text in given.items() for word in ("-p", f"{key}:={text}")])
