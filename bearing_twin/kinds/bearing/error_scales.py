"""What a step may err by: in load and in friction, which is what the wanted tolerance speaks of.

A load errs with its approach. Friction errs, over mu N, with the slip over the speed of its regularisation, and with
the load N. A ball that rings between its contacts at the rate w with an amplitude v of its radial velocity errs by
m w v in load; nothing stops it, so that the errors of many steps add up, and a contact that carries little feels them
most: without a share of its own, lift-off missed its tolerance in friction 4 to 19 times, and with it 0.4 to 0.7 times.
The lightest contact that errors of friction are judged by carries LIGHT of the greatest load. What a ball that carries
less slips is felt as much less (`light_approach`). Every bump into a pocket changes a ball's speed along its way: there
such errors count by the load (`step_ends.weigh_light`), else balls that carry next to nothing rule all steps.
"""

import math

import numpy as np

from bearing_twin.contact.elasticity import elastic
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.system import AXIS_DISTANCE, HEIGHT, RADIAL_VELOCITY, Bearing

APPROACH_SCALE = 1e-6  # m, the size of an elastic approach: errors of position count against it
STEP_SHARE = 0.2  # of the wanted accuracy, that one adaptive step may spend: `chart steppers`, docs/accuracy.md
LIGHT = 0.01  # of the greatest load
# With these two, balls that ring and loaded rings keep their tolerance: `tests/test_error_scales.py`.
RINGING_SHARE = 0.08  # of what a ball that rings may err by: one step of a ball that has steps of its own
COMMON_SHARE = 4.0  # the same where balls step together; one ball rules their steps, and soon stops ringing
STRICTEST, LOOSEST = 0.1, 16.0  # of an error of radial velocity, over one of slip


def _loosest(bearing: Bearing, start: np.ndarray) -> float:
    """How much greater than one of slip an error of radial velocity may be, which by the contact angle is slip, too."""
    outwards = start[:, AXIS_DISTANCE] - bearing.outer.locus_radius
    sine = np.abs(start[:, HEIGHT] / np.hypot(outwards, start[:, HEIGHT])).max()
    return min(LOOSEST, 0.5 / max(float(sine), 1e-3))


def _ringing_speed(bearing: Bearing, start: np.ndarray) -> float:
    """Amplitude of the radial velocity [m/s] with which the lightest contact of a start errs by all its load."""
    outer, law = bearing.outer, bearing.outer.law
    outwards = start[:, AXIS_DISTANCE] - outer.locus_radius
    approaches = np.hypot(outwards, start[:, HEIGHT]) + bearing.ball_radius - outer.groove_radius
    least, greatest = max(float(approaches.min()), 0.0), max(float(approaches.max()), APPROACH_SCALE)
    load = max(LIGHT * elastic(law.given, law.power, greatest).load, elastic(law.given, law.power, least).load)
    stiffness = elastic(law.given, law.power, (load / law.given) ** (1.0 / law.power)).stiffness
    return load / math.sqrt(stiffness * bearing.ball_mass)


def light_approach(bearing: Bearing, start: np.ndarray) -> float:
    """The approach [m] at the outer raceway of a contact that bears LIGHT of the greatest load of a start."""
    outer = bearing.outer
    outwards = start[:, AXIS_DISTANCE] - outer.locus_radius
    approaches = np.hypot(outwards, start[:, HEIGHT]) + bearing.ball_radius - outer.groove_radius
    return max(float(approaches.max()), APPROACH_SCALE) * LIGHT ** (1.0 / outer.law.power)


def error_scales(parameters: BearingScene, bearing: Bearing, start: np.ndarray, together: bool) -> np.ndarray:
    """Errors (MOTION,) that a step of a ball may make at a tolerance of 1, for balls at `start` (N, COLUMNS).

    Where balls step `together`, at the pace of the one with the shortest steps, errors of the others hardly add up.
    """
    speed = parameters.contact.friction_regularisation
    radius, pitch = bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
    unit = np.array([APPROACH_SCALE, APPROACH_SCALE / pitch, APPROACH_SCALE, *(speed,) * 3, *(speed / radius,) * 3])
    share = COMMON_SHARE if together else RINGING_SHARE
    ringing = share * _ringing_speed(bearing, start) / speed
    unit[RADIAL_VELOCITY] *= min(max(ringing, STRICTEST), _loosest(bearing, start) if together else 1.0)
    return STEP_SHARE * unit
