"""Packages that only some users need: imported when they are wanted, and one sentence where they are missing."""

import importlib
from types import ModuleType

from bearing_twin.errors import BearingTwinError

EXTRAS = {  # extra of the package: what it is for
    "chaos": "polynomial chaos expansions",
    "completion": "completions of commands by the shell",
    "dask": "studies on a cluster",
    "export": "tables and data sets for pandas, xarray and what reads CSV, Parquet and NetCDF",
    "view": "films",
}


def install(extra: str) -> str:
    """What installs an extra: the package is on no index, where its name alone would bring nothing, or another's."""
    return f"pip install '.[{extra}]' (in the checkout)"


def wanted(module: str, extra: str) -> ModuleType:
    """The module of an optional package; raises BearingTwinError that says which extra brings it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0].replace("_", "-")
        raise BearingTwinError(
            f"{EXTRAS[extra]} need the package {package}; install it with: {install(extra)}"
        ) from error
