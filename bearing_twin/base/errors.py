"""Errors a user can cause, one sentence each that says what to do; packages that only some users need."""

import importlib
import sys
from types import ModuleType


class BearingTwinError(Exception):
    """Base of every error raised for bad input or a failed run; the command line turns it into exit code 2."""


class SceneError(BearingTwinError):
    """A scene file, scene name or override cannot be used."""


class StudyError(BearingTwinError):
    """A study, one of its uncertain inputs or a way of sampling and propagating them cannot be used."""


class StatisticError(BearingTwinError):
    """A statistic that was asked for does not exist, or cannot be had from the samples there are."""


class LogError(BearingTwinError):
    """A log cannot be read, or may not be written."""


class ChannelError(BearingTwinError, KeyError):
    """There is no channel of that name."""

    __str__ = Exception.__str__  # that of KeyError puts a sentence into quotes


class IntegrationError(BearingTwinError):
    """The integration stopped: `reason` ("not finite", "too deep", ...), at `seconds`, for which `body` and `contact`.

    Where a method cannot tell, `reason`, `body` and `contact` are empty and `seconds` is NaN. `record` is plain data of
    the last good output and state, where there is one.
    """

    def __init__(
        self, sentence: str, reason: str = "", seconds: float = float("nan"), body: str = "", contact: str = ""
    ):
        super().__init__(sentence)
        self.reason, self.seconds, self.body, self.contact = reason, seconds, body, contact
        self.record: dict | None = None


class Stopped(BearingTwinError):
    """A computation ended because somebody wanted it to stop; what was given out before is whole."""


class Interrupted(Stopped):
    """A computation ended for a word in between, and begins again from where it had begun: nothing is lost but time."""


class CoreError(BearingTwinError):
    """The library of the compiled core is missing, not whole, of other sources or for another processor."""


class MissingInterfacesError(BearingTwinError):
    """ROS 2 or the interface package bearing_twin_msgs cannot be imported."""


def missing_package(error: ModuleNotFoundError) -> str:
    """The sentence for a Python package that is not installed; raises `error` again where it is a module of our own."""
    name = (error.name or "").partition(".")[0]
    if name in ("", "bearing_twin"):
        raise error
    return (
        f"the Python package {name} is not installed for {sys.executable}: "
        f"run `{sys.executable} -m pip install {name}`; "
        "in a ROS workspace `rosdep install --from-paths src` or requirements/workspace.txt bring all that is needed"
    )


EXTRAS = {  # extra of the package: what it is for
    "chaos": "polynomial chaos expansions",
    "completion": "completions of commands by the shell",
    "dask": "studies on a cluster",
    "export": "tables and data sets for pandas, xarray and what reads CSV, Parquet and NetCDF",
    "view": "films",
}


def install(extra: str) -> str:
    """The command that installs an extra: the package is on no index, where its name is free."""
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
