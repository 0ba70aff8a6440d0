"""Why a run broke off, where what acts on the ring is the reason: a load that nothing carries, or a torque."""

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds.bearing.columns import CAGE, SHAFT_SPEED
from bearing_twin.kinds.bearing.coupled_bodies import Partners, outside_load
from bearing_twin.kinds.bearing.integrate import Chunk
from bearing_twin.kinds.bearing.quasi_static.operating import OVERLOAD, check_load

TOO_FAST = "too fast"  # reason of an error


def explained(error: IntegrationError, parameters, law: str, chunk: Chunk, begin: float) -> IntegrationError:
    """`error` of a chunk that began at `begin` [s], or one that names the load on a ring with mass, time and limit.

    The load counts with the ring's unbalance, at the beginning of the chunk, else at the error.
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
    return [outside_load(chunk.partners, chunk.drive, into, i) for i in range(CAGE)]


def check_speed(parameters, partners: Partners, begin, times, borders) -> None:
    """Raises IntegrationError at the first of the `times` (n,) [s] at which a shaft that a torque turns is too fast.

    They count from `begin` [s]; `borders` (n, BORDER) are those of the `partners` then.
    """
    if not partners.shaft:
        return
    limit, speeds = parameters.drive.greatest_speed, borders[:, SHAFT_SPEED]
    beyond = ~(np.abs(speeds) <= limit)
    if beyond.any():
        seconds, speed = begin + float(times[beyond.argmax()]), float(speeds[beyond.argmax()])
        sentence = (
            f"at {seconds:.9g} s the inner ring turns at {speed:.6g} rad/s, beyond drive.greatest_speed = {limit:g} "
            "rad/s: nothing holds the torque; lower it, or add drive.damping"
        )
        raise IntegrationError(sentence, TOO_FAST, seconds, "inner ring")
