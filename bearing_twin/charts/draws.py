"""Bearing scenes drawn by chance: by each number the same scene, on every machine.

A draw is a shipped scene in which some of clearance, ball, speed, ring's place, friction, law, load, mass, gravity,
start and cage are drawn anew, most evenly within a range (or its logarithm), with what is wanted and a tolerance.
"""

import math
from random import Random
from typing import Any

from bearing_twin.kinds.bearing.parameters import LOADS

HELD = ("bearing_6203", "bearing_6203_loose", "bearing_6203_start", "bearing_6203_tilted", "bearing_6203_fast")
HELD += ("bearing_6205", "bearing_6203_sudden")
LOADED = ("bearing_6203_rig_400N", "bearing_6203_rig_1000N", "bearing_6203_step_load", "bearing_6203_unbalance")
LOADED += ("bearing_6203_load_and_speed", "bearing_6203_guided_cage")
TOLERANCES = (1e-1, 1e-2, 1e-2, 1e-3, 1e-3, 1e-4, 1e-5)  # as often as users ask for them
SECONDS, RATES = (4e-3, 1e-2, 2e-2, 4e-2), (1000, 2000)


class _Chance:
    """What is drawn of a scene: `words` that override it, in the order in which they are asked for."""

    def __init__(self, number: int):
        self.random, self.words = Random(number), []

    def one_of(self, choices: tuple) -> Any:
        """One of the `choices`, all alike."""
        return choices[int(self.random.random() * len(choices))]

    def between(self, low: float, high: float) -> float:
        """A number within this range."""
        return low + (high - low) * self.random.random()

    def about(self, low: float, high: float) -> float:
        """A number within this range, of any size alike."""
        return math.exp(self.between(math.log(low), math.log(high)))

    def sometimes(self, share: float, key: str, *values: Any) -> None:
        """Sets a key to these values, in a `share` of all draws."""
        shown = [f"{one:.4g}" if isinstance(one, float) else str(one) for one in values]
        if self.random.random() < share:
            self.words.append(f"{key}={shown[0] if len(shown) == 1 else '[' + ', '.join(shown) + ']'}")


def draw_of(number: int) -> tuple[str, tuple[str, ...], tuple[str, ...], float]:
    """A draw: the scene, what differs, what is wanted, and the tolerance."""
    chance = _Chance(number)
    loaded = chance.random.random() < 0.45
    scene = chance.one_of(LOADED if loaded else HELD)
    chance.sometimes(0.3, "geometry.radial_clearance", chance.between(-12e-6, 25e-6))
    chance.sometimes(0.2, "geometry.ball_diameter", chance.between(6.2e-3, 7e-3))
    chance.sometimes(0.1, "materials.ball", "silicon_nitride")
    chance.sometimes(0.4, "drive.speed", chance.one_of((-1.0, 1.0)) * chance.about(20.0, 1500.0))
    chance.sometimes(1.0, "contact.friction_coefficient", chance.about(5e-3, 0.3))
    chance.sometimes(0.15, "contact.friction_regularisation", chance.about(2e-3, 0.1))
    chance.sometimes(0.1, "contact.normal", "volumetric")
    chance.sometimes(0.2, "gravity", 0, -9.81, 0)
    chance.sometimes(0.1, "initial.motion", "rest")
    if loaded:
        chance.sometimes(0.4, "rings.inner.load", chance.between(-300, 300), chance.between(-1500, 200), 0)
        chance.sometimes(0.3, "rings.inner.mass", chance.about(0.05, 5.0))
    else:
        place = (chance.between(low, high) for low, high in ((-6e-6, 6e-6), (-9e-6, 6e-6), (-1.5e-5, 1.5e-5)))
        chance.sometimes(0.4, "drive.offset", *place)
        chance.sometimes(0.2, "drive.tilt", *(chance.between(-6e-4, 6e-4) for _ in range(2)))
        chance.sometimes(0.2, "cage.kind", "even")
    chance.sometimes(1.0, "model.dimension", "free" if loaded else "prescribed")
    chance.sometimes(1.0, "run.duration", chance.one_of(SECONDS))
    chance.sometimes(1.0, "run.output_rate", chance.one_of(RATES))
    chance.sometimes(1.0, "run.publish_rate", RATES[0])
    wanted = (f"wanted.outputs={LOADS}",) if chance.random.random() < 0.3 else ()
    return scene, tuple(chance.words), wanted, chance.one_of(TOLERANCES)
