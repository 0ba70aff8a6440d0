"""Closed forms of an ellipsoid on a plane: contact times, restitution, and instants of bounces."""

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import beta


def steady_contact(coefficient: float, mass: float, speed: float, ratio: float, gravity: float = 0.0):
    """Contact time [s] and restitution with `steady_damped_load` at a damping ratio in [0, 0.5).

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
    rest = depth(end) ** 0.8
    fallen = gravity * in_time(lambda theta: response(end - theta)) + gravity * rest / (e * speed)
    return in_time(lambda theta: 1.0) + rest / (e * speed), e - fallen / speed


def impact_instants(count: int, fall: float, gravity: float, coefficient: float, mass: float, ratio: float):
    """Instants [s] (count,) of the touches of a body that falls `fall` [m] and bounces with `steady_damped_load`.

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
