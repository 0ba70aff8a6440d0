"""What two spheres and two discs share: two bodies on a line, one contact, by closed form or differential equation."""

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.impact.collision import ContactPeriod, collide
from bearing_twin.kinds.impact.derived import resolve
from bearing_twin.kinds.impact.figures import contact_rows
from bearing_twin.kinds.impact.impact import Impact
from bearing_twin.kinds.impact.spring import Spring, spring_energies, spring_loads

SETTING = 0.03  # tolerance of a step over that of forces and times (`tests/test_impact_doubt.py`)
CHANNELS = (
    Channel("approach", "m", (), "mutual approach of the two bodies; negative = gap"),
    Channel("normal_load", "N", (), "contact force, pushing the bodies apart"),
    Channel("displacement", "m", (2,), "of the two centres from the start, positive forward", ("body",)),
    Channel("velocity", "m/s", (2,), "of the two centres, positive forward", ("body",)),
    Channel("kinetic_energy", "J", (), "of the motion relative to the common centre of mass"),
    Channel("elastic_energy", "J", (), "stored in the contact"),
)


def channels(parameters) -> tuple[Channel, ...]:
    """What one sample of two bodies holds."""
    return CHANNELS


def pair_impact(parameters, spring: Spring, masses, stepper, expected, closed) -> Impact:
    """The impact of two bodies; `closed` = (ContactPeriod, greatest approach, restitution, closure, history) or None.

    `history(times)` from the first touch gives approach [m] and its rate [m/s].
    """
    parameters = resolve(parameters)
    motion = parameters.motion
    total = sum(masses)
    reduced = masses[0] * masses[1] / total
    drift = (masses[0] * motion.first_velocity + masses[1] * motion.second_velocity) / total
    touch = motion.gap / motion.speed
    setting = SETTING * parameters.wanted.tolerance
    costs = {"steps": 0, "evaluations": 1}
    if closed is None:
        closed, costs = _followed(parameters, spring, reduced, stepper, setting, expected, touch)
    contact, deepest, restitution, closure, history = closed
    leaving, duration = restitution * motion.speed, contact.duration
    dented = float(np.ravel(history(np.array([duration]))[0])[0])

    def at(times):
        since = np.asarray(times, float) - touch
        approach, rate = (np.array(part) for part in history(np.clip(since, 0.0, duration)))
        before, after = since < 0.0, since > duration
        freed = dented - leaving * (since - duration)
        approach = np.where(before, motion.speed * since, np.where(after, freed, approach))
        rate = np.where(before, motion.speed, np.where(after, -leaving, rate))
        inside = ~(before | after)
        load = np.where(inside, spring_loads(spring, approach, rate), 0.0)
        stored = np.where(inside, spring_energies(spring, approach), 0.0)
        moved, shares = approach + motion.gap, np.array([masses[1], -masses[0]]) / total
        return (
            approach,
            load,
            drift * np.asarray(times, float)[:, None] + shares * moved[:, None],
            drift + shares * rate[:, None],
            0.5 * reduced * rate**2,
            stored,
        )

    placed = ContactPeriod(touch, *contact[1:])
    gained = closure * 0.5 * reduced * motion.speed**2
    records = {"contact": contact_rows((placed,), (deepest,), leaving, gained)}
    return Impact(at, parameters.run, records, costs)


def _followed(parameters, spring, reduced, stepper, setting, expected, touch):
    """As `closed` of `pair_impact`, by the equation of motion, and what it cost."""
    speed, step = parameters.motion.speed, parameters.solver.step or expected / 500.0
    found = collide(spring, reduced, speed, stepper, setting, step, expected, touch)
    figures = found.contact, found.greatest_approach, found.leaving_speed / speed, found.energy_closure
    return (*figures, found.history), {"steps": found.steps, "evaluations": found.evaluations}
