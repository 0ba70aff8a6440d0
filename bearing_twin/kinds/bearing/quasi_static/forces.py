"""What acts on one ball: the push of a groove on it, and what its orbit and its turning do; with all derivatives.

Vectors lie in the ball's meridian plane, (radial, axial); t = (-n_z, n_r) is across a direction n.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.contact.elastic import elastic
from bearing_twin.kinds.bearing.forces.along_groove import coefficient_along, slope_along
from bearing_twin.kinds.bearing.forces.equations import Raceway

TINY = 1e-300  # keeps a direction defined where its length is zero
LEVEL = 0.5  # cosine of an angle beyond which no contact is legal
ACROSS = math.sqrt(1.0 - LEVEL * LEVEL)


class Setting(NamedTuple):
    """The numbers of the balance (SI): grooves, ball, `arm` of a tilt, speed [rad/s], shares of the gyroscopic moment.

    `arm` [m] turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the
    friction that carries the gyroscopic moment, about the point at the end of `arm`. A ball's last step may leave
    `unseen` of the loads, for which stiffness is to the root of that; 0 where it is to be exact.
    """

    inner: Raceway
    outer: Raceway
    ball_radius: float
    ball_mass: float
    pitch_diameter: float
    arm: float
    lever: float
    speed: float
    share_inner: float
    share_outer: float
    unseen: float


class Push(NamedTuple):
    """One contact: approach [m], load [N], direction, distance of the centres [m], and derivatives of its force.

    `stiffness` is d(load)/d(approach), `turning` the derivative of the load along t.
    """

    approach: float
    load: float
    n_r: float
    n_z: float
    distance: float
    stiffness: float
    turning: float


class Speeds(NamedTuple):
    """Centrifugal load [N] and gyroscopic moment over D [N], and their derivatives by both contact angles [N/rad]."""

    centrifugal: float
    centrifugal_by_outer: float
    centrifugal_by_inner: float
    gyroscopic: float
    gyroscopic_by_outer: float
    gyroscopic_by_inner: float


@inlined
def push_of(setting, raceway, v_r, v_z):
    """The contact where `v` [m] points from the ball's centre to the inner groove's, or from the outer one's to it."""
    distance = math.sqrt(v_r * v_r + v_z * v_z + TINY)
    n_r, n_z = v_r / distance, v_z / distance
    approach = distance + setting.ball_radius - raceway.groove_radius
    if approach <= 0.0:
        return Push(approach, 0.0, n_r, n_z, distance, 0.0, 0.0)
    coefficient = coefficient_along(raceway.terms, n_r)
    answer = elastic(coefficient, raceway.law.power, approach)
    by_radial = slope_along(raceway.terms, n_r) * answer.load / coefficient
    return Push(approach, answer.load, n_r, n_z, distance, answer.stiffness, -by_radial * n_z / distance)


@inlined
def gradient_of(push):
    """The 2 x 2 derivative of the force load * n by the vector between the centres, rows first."""
    n_r, n_z, across = push.n_r, push.n_z, push.load / push.distance
    t_r, t_z = -n_z, n_r
    return (
        push.stiffness * n_r * n_r + push.turning * n_r * t_r + across * t_r * t_r,
        push.stiffness * n_r * n_z + push.turning * n_r * t_z + across * t_r * t_z,
        push.stiffness * n_z * n_r + push.turning * n_z * t_r + across * t_z * t_r,
        push.stiffness * n_z * n_z + push.turning * n_z * t_z + across * t_z * t_z,
    )


@inlined
def orbit_and_roll(setting, inner, outer):
    """Orbit speed [rad/s], roll speed times the sine and times the cosine of its axis's pitch [rad/s].

    Harris, Rolling Bearing Analysis (speeds and inertial loads of balls): inner ring turning, pitch of the ball's axis
    by tan(beta) = sin(alpha_o)/(cos(alpha_o) + gamma), gamma = D/d_m.
    """
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
    pitch = outer.n_z / (outer.n_r + gamma)
    p_o = (outer.n_r + pitch * outer.n_z) / (1.0 + gamma * outer.n_r)
    p_i = (inner.n_r + pitch * inner.n_z) / (1.0 - gamma * inner.n_r)
    roll = setting.speed / ((p_o + p_i) * gamma)
    return setting.speed * p_o / (p_o + p_i), roll * pitch, roll


@inlined
def level_load(setting):
    """The centrifugal load [N] at contact angle zero, where the orbit speed is (1 - gamma)/2 of the ring's."""
    orbit = 0.5 * setting.speed * (1.0 - 2.0 * setting.ball_radius / setting.pitch_diameter)
    return 0.5 * setting.ball_mass * setting.pitch_diameter * orbit * orbit


@inlined
def _turned_back(push):
    """Cosine and sine of a contact angle a, beyond 60 degrees those of 120 - |a| degrees, at least 0; and the slope."""
    if push.n_r >= LEVEL:
        return push.n_r, push.n_z, 1.0
    if push.n_r <= -LEVEL:
        return 1.0, 0.0, 0.0
    cosine = ACROSS * abs(push.n_z) - LEVEL * push.n_r
    return cosine, math.copysign(ACROSS * push.n_r + LEVEL * abs(push.n_z), push.n_z), -1.0


@inlined
def speeds_of(setting, inner, outer):
    """Centrifugal load F_c = m d_m omega_m^2 / 2 and M_g / D, M_g = J omega_R omega_m sin(beta), J = m D^2/10.

    Beyond 60 degrees, where only a ball that bears next to nothing has its centre, they go back to those of level
    contacts, without a jump, at which a ball would find no balance.
    """
    if setting.speed == 0.0:
        return Speeds(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    diameter = 2.0 * setting.ball_radius
    gamma = diameter / setting.pitch_diameter
    c_o, s_o, by_o = _turned_back(outer)
    c_i, s_i, by_i = _turned_back(inner)
    centrifugal = 0.5 * setting.ball_mass * setting.pitch_diameter * setting.speed * setting.speed
    lean, over_o, over_i = 1.0 / (c_o + gamma), 1.0 / (1.0 + gamma * c_o), 1.0 / (1.0 - gamma * c_i)
    pitch = s_o * lean
    pitch_by = by_o * (1.0 + gamma * c_o) * lean * lean
    p_o, p_i = (c_o + pitch * s_o) * over_o, (c_i + pitch * s_i) * over_i
    p_o_by = (pitch_by * s_o + by_o * (-s_o + pitch * c_o + p_o * gamma * s_o)) * over_o
    p_i_by_outer = pitch_by * s_i * over_i
    p_i_by_inner = by_i * (-s_i + pitch * c_i - p_i * gamma * s_i) * over_i
    whole = 1.0 / (p_o + p_i)
    share = p_o * whole
    share_by_outer = (p_o_by * p_i - p_o * p_i_by_outer) * whole * whole
    share_by_inner = -p_o * p_i_by_inner * whole * whole
    gyroscopic = 0.1 * setting.ball_mass * setting.pitch_diameter * setting.speed * setting.speed
    roll = pitch * whole
    roll_by_outer = (pitch_by - roll * (p_o_by + p_i_by_outer)) * whole
    roll_by_inner = -roll * p_i_by_inner * whole
    return Speeds(
        centrifugal * share * share,
        2.0 * centrifugal * share * share_by_outer,
        2.0 * centrifugal * share * share_by_inner,
        gyroscopic * roll * share,
        gyroscopic * (roll_by_outer * share + roll * share_by_outer),
        gyroscopic * (roll_by_inner * share + roll * share_by_inner),
    )
