"""What a study may ask of two bodies; nothing here compiles."""

from bearing_twin.kinds.contract import Quantity, read_off
from bearing_twin.kinds.ellipsoid.quantities import quantities as of_ellipsoid


def quantities() -> dict[str, Quantity]:
    """What a study may ask of two bodies."""
    return of_ellipsoid() | {"held_work": Quantity("J", "done on held bodies", read_off("held_work_j"))}
