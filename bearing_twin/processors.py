"""How many processors the libraries below may use."""

import os


def one_processor() -> None:
    """Lets linear algebra use one thread, unless the environment says otherwise; call it before NumPy is imported.

    Matrices are small here: a second thread of BLAS waits actively and costs 0.2 s of processor time a command.
    """
    for library in ("OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
