"""Processes forked by tests do not collect what is left of threads of nodes: a fork has none of them and would crash.

Importing this is enough, for every fork of the process that does.
"""

import gc
import os

os.register_at_fork(after_in_child=gc.freeze)
