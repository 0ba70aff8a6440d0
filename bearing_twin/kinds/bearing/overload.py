"""Why a run broke off, where a load is the reason: one that the bearing does not carry in balance."""

from bearing_twin.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds.bearing.border import outside_load
from bearing_twin.kinds.bearing.integrate import Chunk
from bearing_twin.kinds.bearing.layout import CAGE, TILT_X
from bearing_twin.kinds.bearing.quasi_static.operating import check_load

OVERLOAD = "overload"  # the reason of such an error


def explained(error: IntegrationError, parameters, law: str, chunk: Chunk, begin: float) -> IntegrationError:
    """`error` of a chunk that began at `begin` [s], or one that names the load on a ring with mass, time and limit.

    The load counts with the ring's weight and its unbalance, at the beginning of the chunk, else at the error.
    """
    if not len(chunk.partners.ring) or not error.seconds >= begin:
        return error
    for into in (0.0, error.seconds - begin):
        load, seconds = _load(chunk, into), begin + into
        try:
            check_load(parameters, law, chunk.drive.speed + chunk.drive.acceleration * into, load[:3], load[3:])
        except BearingTwinError as limit:
            return IntegrationError(f"at {seconds:.9g} s {limit}", OVERLOAD, seconds, "inner ring")
    return error


def _load(chunk: Chunk, into: float) -> list[float]:
    """What acts on the free coordinates of the ring [N, N m] (5,) `into` [s] the chunk."""
    partners = chunk.partners
    weights = (partners.free * partners.weight)[:CAGE].tolist()
    weights[TILT_X:CAGE] = 0.0, 0.0  # there a cage whose centre moves has its weight
    return [outside_load(partners, chunk.drive, into, i) + weight for i, weight in enumerate(weights)]
