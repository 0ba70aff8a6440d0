"""Where a ball sees the centre of the inner groove: the one place of what the ring's coordinates do to a ball.

The ring's centre lies at d = x cos(psi) + y sin(psi) outwards and s = y cos(psi) - x sin(psi) ahead of a ball at the
azimuth psi, which meets it beside the middle: its groove, a circle round the ring's own axis, has gone back by
s^2/(2 r) there, r = d_m/2 being the ball's distance from that axis, and a ring tilted by theta, of which
b = theta_x sin(psi) - theta_y cos(psi) acts in the ball's plane and l = theta_x cos(psi) + theta_y sin(psi) across it,
is lower by s l:

    A_r = A_0 + d - s^2/(2 r),   A_z = z + R b - s l.

Against the true circle, at which balls that move are, A_r is off by s^2/(2 r) times what r differs by, some 1e-3. Tilts
are of first order, as there.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined


class Opening(NamedTuple):
    """The inner groove's centre against the outer one's [m], and `outwards` d, `aside` s [m], `along` b, `across` l.

    `side` is s/r.
    """

    radial: float
    axial: float
    outwards: float
    aside: float
    along: float
    across: float
    side: float


@inlined
def opening_of(setting, cosine, sine, q):
    """The `Opening` of a ball at the azimuth of that cosine and sine, the ring at `q` (5,) [m, rad]."""
    outwards, aside = q[0] * cosine + q[1] * sine, q[1] * cosine - q[0] * sine
    along, across = q[3] * sine - q[4] * cosine, q[3] * cosine + q[4] * sine
    side = 2.0 / setting.pitch_diameter * aside
    radial = (setting.inner.locus_radius - setting.outer.locus_radius) + outwards - 0.5 * side * aside
    axial = q[2] + setting.arm * along - aside * across
    return Opening(radial, axial, outwards, aside, along, across, side)


@inlined
def slopes_of(setting, cosine, sine, opening):
    """Derivatives of the opening, radial (x, y) and axial (x, y, theta_x, theta_y); by z they are 0 and 1."""
    side, across, aside = opening.side, opening.across, opening.aside
    radial = (cosine + side * sine, sine - side * cosine)
    axial = (across * sine, -across * cosine, setting.arm * sine - aside * cosine, -setting.arm * cosine - aside * sine)
    return radial, axial


@inlined
def leaning(opening, angle):
    """How far the inner groove's pull of 1 on a ball at this contact angle [rad] points along the orbit."""
    return -(math.cos(angle) * opening.side + math.sin(angle) * opening.across)
