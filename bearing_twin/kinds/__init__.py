"""THE table of kinds of scenes: `KINDS`, one row a kind.

A row is imported when it is wanted. That imports parameter files alone: it plots and reads no files.

* `contract`: what a kind can give: the row Kind and its parts.
* `sections`: sections of scenes that kinds share.
* `rules`: rules by which models are chosen, and the ranges in which they are valid.
* `error_estimates`: errors of figures, by a second run and by the model.
* `topics`: types of messages, markers and frames.
* `views`: what the browser shows of a kind.
* `picture`: the picture of a run, `RunPicture`.
"""

import importlib
from collections import UserDict

from bearing_twin.kinds.contract import Kind

SHIPPED = {  # name of a kind: its row, in its module below this package
    "bearing": "bearing:BEARING",
    "shaft": "shaft:SHAFT",
    "two_spheres": "bodies:TWO_SPHERES",
    "two_discs": "bodies:TWO_DISCS",
    "sphere_on_beam": "beam:SPHERE_ON_BEAM",
    "ellipsoid_on_plane": "bodies:ELLIPSOID_ON_PLANE",
    "two_bodies": "bodies:TWO_BODIES",
    "soft_discs": "soft_discs:SOFT_DISCS",
}


class Kinds(UserDict):
    """Rows by the name of the kind, or the places at which they are found."""

    def __getitem__(self, name: str) -> Kind:
        row = self.data[name]
        if isinstance(row, str):
            module, _, constant = row.partition(":")
            row = self.data[name] = getattr(importlib.import_module(f"{__name__}.{module}"), constant)
        return row


KINDS = Kinds(SHIPPED)
HOMES: dict[str, str] = {}
"""Modules whose import registers the kinds that do not come with the package, by the name of the kind."""


def register(kind: Kind, home: str) -> None:
    """Adds a kind, or replaces the one of its name; `home` is the `__name__` of the module that calls this."""
    KINDS[kind.name], HOMES[kind.name] = kind, home


def kind_of(name: str, home: str = "") -> Kind:
    """The row of that name; `home` is imported first where the name is not known yet, as in a worker process."""
    if name not in KINDS and home:
        importlib.import_module(home)
    return KINDS[name]
