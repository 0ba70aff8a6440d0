"""Euler's beam or Timoshenko's: which one holds for a blow, found by trying both on it.

Euler's beam answers a blow at once everywhere across its height; a shear wave needs height / sqrt(G / rho) for that.
The shorter the contact against this time, and the heavier the sphere against the beam, the further Euler's first peak
is off; whatever follows a second touch depends on waves that Euler's beam has too fast.
"""

import functools
from typing import NamedTuple

from bearing_twin.base.stopping import heeding_signals
from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.beam.derived import beam_of, resolve, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.impact import MOST_MODES, BeamImpact, hertz_contact_time, highest_mode, throw
from bearing_twin.kinds.beam.modes import modes_of
from bearing_twin.kinds.beam.parameters import BEAM_THEORIES, EULER, TIMOSHENKO, SphereOnBeamScene

FINEST_TRIAL = 1e-4  # tolerance: what matters more is seen, and what matters less costs more than it tells
SHARE = 0.1  # of the tolerance, that a trial may be off
TRIAL_STEPS = 40  # a contact, good to 1e-5


class BothTheories(NamedTuple):
    """The blow by both theories.

    First contact [s], how often a shear wave crosses the height in it, how far off Euler's first peak is (relative,
    signed), the greater number of contacts, and how far off Euler's greatest force and time in contact are (relative).
    """

    duration: float
    crossings: float
    error: float
    contacts: int
    of_peak: float
    of_time: float

    def doubts(self, tolerance: float) -> list[str]:
        """What speaks against Euler's beam."""
        doubts = []
        if abs(self.error) > tolerance:
            doubts.append(
                f"the first contact of {self.duration:.3g} s is so short, {self.across}, that Euler's first peak is "
                f"{100.0 * abs(self.error):.2g} % too {'high' if self.error > 0.0 else 'low'}"
            )
        elif self.of_time > tolerance:
            doubts.append(f"Euler's beam has the sphere in contact for a time {100.0 * self.of_time:.2g} % off")
        if self.contacts > 1:
            doubts.append(f"the sphere touches {self.contacts} times, and what follows a second touch needs shear")
        return doubts

    @property
    def across(self) -> str:
        """The crossings in words."""
        return f"{self.crossings:.3g} crossings of the height by a shear wave"


@functools.lru_cache(maxsize=1)  # a motion may take megabytes
def thrown_by_both(parameters: SphereOnBeamScene) -> tuple[BeamImpact, ...]:
    """The blow of a checked scene by Euler's beam and by Timoshenko's, roughly."""
    sphere, speed, until = thrown_sphere(parameters), touch_speed(parameters.blow), resolve(parameters).run.duration
    tolerance, found = max(SHARE * parameters.wanted.tolerance, FINEST_TRIAL), []
    for theory in BEAM_THEORIES:
        line = beam_of(parameters, theory)
        count = min(highest_mode(line, hertz_contact_time(sphere, speed), tolerance), MOST_MODES)
        modes = modes_of(line, parameters.blow.point * line.span, count)
        with heeding_signals():
            found.append(throw(line, modes, sphere, speed, until, TRIAL_STEPS))
    return tuple(found)


@functools.lru_cache(maxsize=64)
def trial(parameters: SphereOnBeamScene) -> BothTheories:
    """The blow of a checked scene by both theories, roughly."""
    beam, material = parameters.beam, parameters.beam.material
    by_euler, by_timoshenko = thrown_by_both(parameters)
    shear_modulus = material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))
    first = by_timoshenko.contacts[0]
    return BothTheories(
        first.duration,
        first.duration / wave_transit(beam.height, shear_modulus, material.density),
        by_euler.contacts[0].peak_force / first.peak_force - 1.0,
        max(len(by_euler.contacts), len(by_timoshenko.contacts)),
        abs(by_euler.peak_force / by_timoshenko.peak_force - 1.0),
        abs(by_euler.contact_time / by_timoshenko.contact_time - 1.0),
    )


def needs_shear(parameters: SphereOnBeamScene) -> bool:
    """True if anything speaks against Euler's beam in a checked scene."""
    return bool(trial(parameters).doubts(parameters.wanted.tolerance))


def theory_of(parameters: SphereOnBeamScene) -> str:
    """The beam theory of a checked scene: the one it specifies, or Euler's where nothing speaks against it."""
    if parameters.beam.theory != "auto":
        return parameters.beam.theory
    return TIMOSHENKO if needs_shear(parameters) else EULER


def euler_doubt(parameters: SphereOnBeamScene, contacts: int) -> str | None:
    """What speaks against Euler's beam in a run that took it and had that many contacts."""
    if not contacts or theory_of(parameters) != EULER:
        return None
    found = trial(parameters)
    doubts = found._replace(contacts=max(contacts, found.contacts)).doubts(parameters.wanted.tolerance)
    return f"{'; '.join(doubts)}: give beam.theory: timoshenko" if doubts else None
