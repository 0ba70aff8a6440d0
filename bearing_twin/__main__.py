"""The executable `bearing_twin`, and `python -m bearing_twin`."""

import os


def program() -> None:
    """The command line; Ctrl-C while its modules load ends the process with one line, too."""
    try:
        from bearing_twin.command import cli

        cli.program()
    except KeyboardInterrupt:
        os.write(2, b"bearing_twin: interrupted\n")
        os._exit(130)


if __name__ == "__main__":
    program()
