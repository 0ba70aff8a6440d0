"""Independent solutions that charts and tests compare with: a bounce, friction over a contact ellipse, a struck beam.

`patch_friction_exact`: Coulomb's law on a body in plane motion. The slip at every point is spin x (r - pole), so its
direction is the same along each ray from the pole (the instantaneous centre of rotation). In polar coordinates about
the pole, the ellipse scaled to a unit disc, what is left of the integrals over Hertz's pressure is smooth.

`strike`: a mass that strikes a simply supported Timoshenko beam, by staggered differences in space and time, written
from the equations alone and not from modes:

    rho A w'' = dQ/dx + f delta(x - x_c),   Q = K G A (dw/dx - psi),   rho I psi'' = dM/dx + Q,   M = E I dpsi/dx,

w and M at nodes, psi and Q between them; errors fall as the square of the cells. The mass has a Hertz spring, or none:
then it sticks to its node while it presses on it, takes over the node's speed at a touch and leaves where it would
have to pull.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import beta

from bearing_twin.contact.friction import FrictionLoads


def steady_contact(coefficient: float, mass: float, speed: float, ratio: float, gravity: float = 0.0):
    """Contact time [s] and restitution with steady damping at a damping ratio in [0, 0.5).

    With s = (2/sqrt 5) h^(5/4) and d theta = k h^(1/4) dt, k^2 = 5c/(4m):  s'' + 2 z s' + s = 0, s(0) = 0. The load
    ends where s + 2 z s' = 0; the bodies then part freely at the speed e v until h = 0. Gravity enters to first order
    in g tau/v, by the oscillator's response to a push; it takes a little speed away unless there is no loss.
    """
    if ratio == 0.0:
        # Twice the way in: the integral of dh/sqrt(v^2 - 4 c h^2.5/(5 m)), by Euler's beta function.
        return (1.25 * mass / coefficient) ** 0.4 * 0.8 * float(beta(0.4, 0.5)) * speed**-0.2, 1.0
    k, damped = math.sqrt(1.25 * coefficient / mass), math.sqrt(1.0 - ratio * ratio)

    def depth(theta):  # h^(5/4)
        return 1.25 * speed / (k * damped) * math.exp(-ratio * theta) * math.sin(damped * theta)

    def pull(theta):
        return (1.0 - 2.0 * ratio * ratio) * math.sin(damped * theta) + 2.0 * ratio * damped * math.cos(damped * theta)

    def response(theta):  # of the speed to a unit of speed before
        return math.exp(-ratio * theta) * (math.cos(damped * theta) - ratio / damped * math.sin(damped * theta))

    def in_time(weight):
        # theta = x^(5/4) takes the root out of dt = d theta / (k h^(1/4)) at the touch
        value, _ = quad(
            lambda x: 1.25 * x**0.25 / (k * depth(x**1.25) ** 0.2) * weight(x**1.25), 0.0, end**0.8, epsrel=1e-12
        )
        return value

    end = brentq(pull, 0.5 * math.pi / damped, math.pi / damped, xtol=1e-15)
    # Half a period of the oscillator, cut where it would begin to pull.
    e = math.exp(-ratio * end)
    remaining_depth = depth(end) ** 0.8
    fallen = gravity * in_time(lambda theta: response(end - theta)) + gravity * remaining_depth / (e * speed)
    return in_time(lambda theta: 1.0) + remaining_depth / (e * speed), e - fallen / speed


def impact_instants(count: int, fall: float, gravity: float, coefficient: float, mass: float, ratio: float):
    """Instants [s] (count,) of the touches of a body that falls `fall` [m] and bounces with steady damping.

    `ratio` is d/sqrt(5 m c) of the law's viscosity d: a given d means another ratio, and so another restitution e, for
    another coefficient c. Flights last 2 e v/g. First order in g tau/v of each contact.
    """
    speed = math.sqrt(2.0 * gravity * fall)
    instants = [speed / gravity]
    while len(instants) < count:
        duration, restitution = steady_contact(coefficient, mass, speed, ratio, gravity)
        speed *= restitution
        instants.append(instants[-1] + duration + 2.0 * speed / gravity)
    return np.array(instants)


ALONG_RAY = np.polynomial.legendre.leggauss(40)
ACROSS_RAYS = np.polynomial.legendre.leggauss(400)


def patch_friction_exact(
    normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, rays: int = 4000
) -> FrictionLoads:
    """Friction over the patch (`contact.friction`) in the limit of no smoothing; `spin` [rad/s] must not be zero.

    Relative error below 1e-9 for b/a >= 0.03 with the pole anywhere: twice and four times the rays change less.
    """
    axes = np.array([semi_major, semi_minor])
    pole = np.array([-slip_minor, slip_major]) / (spin * axes)
    distance = math.hypot(*pole)
    if distance < 1.0:
        angle = 2.0 * math.pi * (np.arange(rays) + 0.5) / rays
        weight = np.full(rays, 2.0 * math.pi / rays)
    else:
        # Rays that meet the disc, spread so that the tangent ones at both ends do no harm.
        nodes, shares = ACROSS_RAYS
        turn = 0.5 * math.pi * nodes
        opening = np.arcsin(np.sin(turn) / distance)
        angle = math.atan2(pole[1], pole[0]) + math.pi + opening
        weight = 0.5 * math.pi * shares * np.cos(turn) / (distance * np.cos(opening))
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    # Along a ray: the pressure is sqrt(half^2 - (rho - middle)^2), rho = middle + half sin(t).
    middle = -ray @ pole
    half = np.sqrt(np.maximum(1.0 - (pole @ pole - middle**2), 0.0))
    start = np.arcsin(np.clip(-middle / np.maximum(half, 1e-300), -1.0, 1.0))
    nodes, shares = ALONG_RAY
    t = start[:, None] + 0.5 * (nodes + 1.0) * (0.5 * math.pi - start[:, None])
    rho = middle[:, None] + half[:, None] * np.sin(t)
    share = 0.5 * shares * (0.5 * math.pi - start[:, None]) * (half[:, None] * np.cos(t)) ** 2
    first, second = (share * rho).sum(axis=1) * weight, (share * rho**2).sum(axis=1) * weight

    along = ray * axes
    length = np.hypot(*along.T)
    direction = math.copysign(1.0, spin) * np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]
    x, y = pole * axes
    moment = (x * direction[:, 1] - y * direction[:, 0]) @ first + math.copysign(1.0, spin) * length @ second
    limit = -coefficient * normal_load * 1.5 / math.pi
    force = limit * direction.T @ first
    return FrictionLoads(float(force[0]), float(force[1]), float(limit * moment))


COURANT = 0.9  # of the longest stable step


class BeamResponse(NamedTuple):
    """The point of impact over `time` [s]: `force` [N], `deflection` [m] and bending `stress` [Pa] of the fibre away.

    `contacts` as rows of (start [s], end [s], peak [N]); `leaving` [m/s], the mass's speed at the end.
    """

    time: np.ndarray
    force: np.ndarray
    deflection: np.ndarray
    stress: np.ndarray
    contacts: np.ndarray
    leaving: float


def strike(beam, mass: float, coefficient: float, speed: float, point: float, until: float, cells: int) -> BeamResponse:
    """The motion of `beam` (`kinds.beam.motion.Beam` with shear) and a mass [kg] that touches it at time 0.

    `coefficient` [N/m^1.5] of the Hertz spring, infinite for a rigid contact; `point`, a share of the span, on a node.
    """
    length = beam.span / cells
    fastest = 4.0 * beam.rigidity / beam.rotary_inertia / length**2
    fastest += beam.shear_rigidity * (1.0 / beam.rotary_inertia + 4.0 * beam.span / beam.mass / length**2)
    step = COURANT * 2.0 / math.sqrt(fastest)
    rows = np.zeros((int(until / step) + 1, 4))
    numbers = beam.rigidity, beam.rotary_inertia, beam.shear_rigidity, beam.mass / beam.span, length
    node = round(point * cells)
    leaving = _march(numbers, node, cells, mass, coefficient, speed, step, rows)
    time, (gap, force, deflection, moment) = step * np.arange(len(rows)), rows.T
    return BeamResponse(
        time, force, deflection, -moment * beam.half_height / beam.area_moment, _contacts(time, gap, force), leaving
    )


def _march(numbers, node, cells, mass, coefficient, speed, step, rows):
    """Fills rows of (approach, force, deflection, moment at the node); returns the mass's speed at the end."""
    rigidity, rotary, shear, inertia, length = numbers
    w, wt = np.zeros(cells + 1), np.zeros(cells + 1)
    psi, psit = np.zeros(cells), np.zeros(cells)
    moment, force_across = np.zeros(cells + 1), np.zeros(cells)
    bend, slide = rigidity / length, shear / length
    push, turn = step / (length * inertia), step / rotary
    travel, velocity = 0.0, speed
    rigid, touching = not math.isfinite(coefficient), False
    for row in range(len(rows)):
        force_across[:] = slide * (w[1:] - w[:-1]) - shear * psi
        moment[1:-1] = bend * (psi[1:] - psi[:-1])
        approach, force = travel - w[node], 0.0
        across = force_across[node] - force_across[node - 1]
        if rigid:
            if not touching and approach >= 0.0 and velocity > wt[node]:
                touching = True
                wt[node] = velocity = (mass * velocity + inertia * length * wt[node]) / (mass + inertia * length)
            if touching:
                force = -mass * across / (mass + inertia * length)
                touching = force >= 0.0
                force = max(force, 0.0)
        elif approach > 0.0:
            force = coefficient * approach**1.5
        rows[row] = approach, force, w[node], moment[node]
        velocity -= step * force / mass
        travel += step * velocity
        wt[1:-1] += push * (force_across[1:] - force_across[:-1])
        wt[node] += push * force
        psit += turn * ((moment[1:] - moment[:-1]) / length + force_across)
        w += step * wt
        psi += step * psit
    return velocity


def _contacts(time, gap, force):
    """Rows of (start, end, peak) of the stretches under load, ends where the line through the gap's values is zero."""
    pressed = np.concatenate([[False], force > 0.0, [False]])
    starts, ends = np.flatnonzero(pressed[1:] & ~pressed[:-1]), np.flatnonzero(pressed[:-1] & ~pressed[1:])
    rows = []
    for first, last in zip(starts, ends, strict=True):
        edges = [
            time[row] if not 0 < row < len(time) or gap[row] == gap[row - 1]
            else time[row] - (time[row] - time[row - 1]) * gap[row] / (gap[row] - gap[row - 1])
            for row in (first, min(last, len(time) - 1))
        ]  # fmt: skip
        top = min(max(first + int(np.argmax(force[first:last])), 1), len(force) - 2)
        before, middle, after = force[top - 1 : top + 2]
        bend = before - 2.0 * middle + after
        rows.append((*edges, middle if bend >= 0.0 else middle - 0.125 * (after - before) ** 2 / bend))
    return np.array(rows).reshape(-1, 3)
