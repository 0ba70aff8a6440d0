"""Rolling of a ball between two raceways from velocities at its two contact points, without formulas for speeds."""

import numpy as np


def rolling_rates(inner_speed: float, ball_diameter: float, pitch_diameter: float, contact_angle: float = 0.0):
    """Orbital speed [rad/s] and spin against the orbit [rad/s] of a ball that slips on neither raceway.

    Plane motion seen from outside: the ball turns about an axis parallel to its contacts' tangent planes, tilted by
    `contact_angle` [rad]; its surface moves with either raceway where it touches it. The outer ring is at rest.
    """
    radius, tilt = 0.5 * ball_diameter, np.array([np.cos(contact_angle), 0.0, np.sin(contact_angle)])
    centre = np.array([0.5 * pitch_diameter, 0.0, 0.0])
    axis = np.cross([0.0, 1.0, 0.0], tilt)  # of the spin; -z at contact angle zero
    rows, right = [], []
    for arm, speed in ((-radius * tilt, inner_speed), (radius * tilt, 0.0)):
        of_orbit = np.cross([0.0, 0.0, 1.0], centre + arm)
        rows.append([of_orbit[1], np.cross(axis, arm)[1]])
        right.append(np.cross([0.0, 0.0, speed], centre + arm)[1])
    orbit, spin = np.linalg.solve(rows, right)
    return float(orbit), float(spin)
