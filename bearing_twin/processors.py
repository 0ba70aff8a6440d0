"""What the whole process may use: processors, and time to look for what nobody needs any more."""

import gc
import os


def usable() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def one_processor() -> None:
    """Lets linear algebra use one thread, unless the environment says otherwise; call it before NumPy is imported.

    Matrices are small here: a second thread of BLAS waits actively and costs 0.2 s of processor time a command.
    """
    for library in ("OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def seldom_collecting() -> None:
    """Lets Python look for circular garbage seldom: for an executable, whose process is its own.

    Libraries and compiled kernels are 130 000 objects that stay; to look through them took a tenth of the time of a
    compilation and of a start.
    """
    gc.set_threshold(20_000, 20, 20)
