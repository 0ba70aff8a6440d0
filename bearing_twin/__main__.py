"""`python -m bearing_twin` is the command line."""

from bearing_twin.command.cli import program

program()
