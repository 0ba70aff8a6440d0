"""The command line `bearing_twin`; nothing heavy is imported before a command runs.

* `cli`: the program, the main function, its parsers and its exit codes.
* `commands`: the table of commands, `COMMANDS`.
* `outcome`: what a command hands back, its `Outcome`.
* `node_command`: the names of `NODES`, `VERBS` of other nodes, and the `node_arguments` with which one starts.
"""
