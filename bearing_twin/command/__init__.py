"""The command line `bearing_twin`; nothing heavy is imported before a command runs.

* `cli`: `program`, the executable, and `main(words)`, which returns the exit code (`DONE`, `BAD_INPUT`, `DOUBTFUL`).
* `commands`: `COMMANDS`, the table of commands; `outcome`: what a command hands back, and paths it may write to.
* `terminal`: results as tables, and progress.

Inside the room: a module a command, or for a few that belong together.
"""
