"""Processes forked by tests do not collect what is left of threads of nodes: a fork has none of them and would crash.

Importing this is enough, for every fork of the process that does.
"""

import gc
import os
import resource
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable

os.register_at_fork(after_in_child=gc.freeze)


def forked(call: Callable[[], int | None], largest_file: int | None = None) -> subprocess.CompletedProcess:
    """Code and output of `call` in a fork of this process, which has imported what it needs.

    Its files grow to `largest_file` [bytes] at most, as on a disk that becomes full. Not for what has threads that a
    fork lacks, as those of Arrow and Rerun.
    """
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as error:
        child = os.fork()
        if not child:
            code, (_, hard) = 1, resource.getrlimit(resource.RLIMIT_FSIZE)
            try:
                sys.stdout, sys.stderr = out, error
                for number, stream in ((1, out), (2, error)):
                    os.dup2(stream.fileno(), number)
                sys.dont_write_bytecode = True  # nothing notices where a file of it is cut off
                if largest_file is not None:
                    resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, hard))
                code = call() or 0
            except BaseException:
                traceback.print_exc()
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))  # for what is said of it
                out.flush()
                error.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        out.seek(0)
        error.seek(0)
        return subprocess.CompletedProcess((), code, out.read(), error.read())
