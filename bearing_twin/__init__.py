"""The digital twin of a ball bearing: simulate, publish, log, replay and verify.

The public names below are imported on first use, so that `import bearing_twin` costs nothing.
"""

import importlib

__version__ = "0.1.0"

_HOMES = {
    "load_scene": "bearing_twin.run.scene",
    "parse_scene": "bearing_twin.run.scene",
    "scene_names": "bearing_twin.run.scene",
    "equilibrium": "bearing_twin.run.equilibrium",
    "simulate": "bearing_twin.run.simulation",
    "load_study": "bearing_twin.uq.study",
    "parse_study": "bearing_twin.uq.study",
    "study_names": "bearing_twin.uq.study",
    "run_study": "bearing_twin.uq.run",
    "read_study": "bearing_twin.log.study_log",
    "write_study": "bearing_twin.log.study_log",
    "read_log": "bearing_twin.log.run_log",
    "write_log": "bearing_twin.log.run_log",
    "export_log": "bearing_twin.log.export",
    "recover": "bearing_twin.log.raw_log",
    "BearingTwinError": "bearing_twin.base.errors",
    "SceneError": "bearing_twin.base.errors",
    "StudyError": "bearing_twin.base.errors",
    "StatisticError": "bearing_twin.base.errors",
    "LogError": "bearing_twin.base.errors",
    "IntegrationError": "bearing_twin.base.errors",
    "MissingInterfacesError": "bearing_twin.base.errors",
}

__all__ = [*_HOMES]


def __dir__():
    return ["__version__", *_HOMES]


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)
