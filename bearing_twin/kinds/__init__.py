"""THE table of kinds of scenes: `KINDS`, one row a kind; see `contract`.

Reading the table imports parameter files alone: nothing here compiles, plots or reads files.
"""

import importlib

from bearing_twin.kinds.beam.row import SPHERE_ON_BEAM
from bearing_twin.kinds.bearing.row import BEARING
from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.ellipsoid.row import ELLIPSOID_ON_PLANE
from bearing_twin.kinds.impact.row import TWO_DISCS, TWO_SPHERES
from bearing_twin.kinds.shaft.row import SHAFT
from bearing_twin.kinds.soft_discs.row import SOFT_DISCS
from bearing_twin.kinds.two_bodies.row import TWO_BODIES

KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (BEARING, SHAFT, TWO_SPHERES, TWO_DISCS, SPHERE_ON_BEAM, ELLIPSOID_ON_PLANE, TWO_BODIES, SOFT_DISCS)
}


def register(kind: Kind) -> None:
    """Adds a kind, or replaces the one of its name; its `home` is the module that calls this when it is imported."""
    KINDS[kind.name] = kind


def kind_of(name: str, home: str = "") -> Kind:
    """The row of that name; `home` is imported first where the name is not known yet, as in a worker process."""
    if name not in KINDS and home:
        importlib.import_module(home)
    return KINDS[name]
