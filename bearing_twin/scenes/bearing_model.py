"""From a bearing scene to its equations, its start, and its motion chunk by chunk, by any of the steppers."""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq, root

from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.normal import LAWS
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.materials import effective_modulus
from bearing_twin.motion.steppers import RODAS4
from bearing_twin.rotation import turned
from bearing_twin.sample import Found
from bearing_twin.scenes.bearing import (
    AXIS_DISTANCE,
    COLUMNS,
    GROSS_WORK,
    HEIGHT,
    MOTION,
    ORBIT_ANGLE,
    SPIN,
    VELOCITY,
    Bearing,
    Drive,
    bearing_rates,
    mark_near,
    raceway_contact,
    raceway_of,
    static_force,
)
from bearing_twin.scenes.bearing_outputs import Outputs, empty_outputs, write_outputs
from bearing_twin.scenes.bearing_parameters import BearingScene
from bearing_twin.scenes.bearing_report import ENERGY_GAIN, Statistics
from bearing_twin.scenes.bearing_steps import (
    JACOBIANS,
    NOT_FINITE,
    OK,
    RATES,
    REJECTIONS,
    STALLED,
    STEPS,
    TOO_DEEP,
    relative_spin,
    rk4_chunk,
    rosenbrock_chunk,
)

APPROACH_SCALE = 1e-6  # m, the size of an elastic approach: errors of position count against it
STEP_SHARE = 0.1  # share of the wanted accuracy that one adaptive step may spend
REFERENCE_SHARE = 1e-4  # the same for SciPy's methods, whose only use here is to be right
SCIPY = {"dop853": DOP853, "radau": Radau}


class Rates(NamedTuple):
    """The fastest rates of a scene [1/s]: contact resonance, friction creep, and the shortest contact [s]."""

    contact: float
    friction: float
    shortest_contact: float


def bearing_of(parameters: BearingScene, law: str) -> Bearing:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    geometry, materials, contact = parameters.geometry, parameters.materials, parameters.contact
    radius = 0.5 * geometry.ball_diameter
    mass = materials.ball.density * 4.0 / 3.0 * math.pi * radius**3
    pair = effective_modulus(materials.ball, materials.ball)
    tag = LAWS[law]
    return Bearing(
        geometry.balls,
        radius,
        mass,
        0.4 * mass * radius**2,
        raceway_of(
            geometry, geometry.inner_conformity, -1.0, effective_modulus(materials.ball, materials.inner_ring), tag
        ),
        raceway_of(
            geometry, geometry.outer_conformity, 1.0, effective_modulus(materials.ball, materials.outer_ring), tag
        ),
        tuple(parameters.drive.offset),
        tuple(parameters.gravity),
        contact.damping,
        contact.friction_coefficient,
        contact.friction_regularisation,
        hertz_coefficient(1.0 / radius, 1.0 / radius, pair),
    )


def equilibrium(bearing: Bearing, orbit_rate: float, orbit_angle: float) -> tuple[float, float]:
    """Axis distance and height [m] where a ball rests between the raceways at that orbit rate, friction left out.

    With clearance a ball rests on the one raceway its own orbit presses it to. Raises SceneError when there is no
    rest between the raceways.
    """
    nominal = bearing.inner.locus_radius + (bearing.outer.locus_radius - bearing.inner.locus_radius) * (
        bearing.inner.groove_radius - bearing.ball_radius
    ) / (bearing.inner.groove_radius + bearing.outer.groove_radius - 2.0 * bearing.ball_radius)
    cosine, sine = math.cos(orbit_angle), math.sin(orbit_angle)
    nominal += 0.5 * (cosine * bearing.offset[0] + sine * bearing.offset[1])
    height = 0.5 * bearing.offset[2]
    reach = 0.02 * bearing.ball_radius

    def radial(distance):
        return static_force(bearing, orbit_rate, distance, orbit_angle, height)[0]

    low, high = nominal - reach, nominal + reach
    if not radial(low) >= 0.0 >= radial(high):
        raise SceneError(
            "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
        )
    distance = brentq(radial, low, high, xtol=1e-16, rtol=1e-15)
    if bearing.offset[2] != 0.0:
        scale = max(abs(radial(nominal - 1e-6)), 1e-9)
        found = root(
            lambda x: np.array(static_force(bearing, orbit_rate, 1e-6 * x[0], orbit_angle, 1e-6 * x[1])) / scale,
            np.array([distance, height]) * 1e6,
            tol=1e-13,
        )
        if np.all(np.abs(found.fun) < 1e-6):
            distance, height = 1e-6 * found.x
    return distance, height


def rolling(
    bearing: Bearing, inner_speed: float, orbit_angle: float, axis_distance: float, height: float
) -> np.ndarray:
    """Tangential velocity and angular velocity (4,) of a ball that slips on neither raceway, by least squares.

    Slip is linear in the four unknowns, so one solve gives the rolling motion; among several the one with least spin.
    """
    cosine, sine = math.cos(orbit_angle), math.sin(orbit_angle)
    x, y, z = bearing.offset
    centre = (cosine * x + sine * y, -sine * x + cosine * y, z)
    position = (axis_distance, 0.0, height)

    def slips(unknown):
        velocity, spin = (0.0, float(unknown[0]), 0.0), tuple(float(v) for v in unknown[1:])
        inner = raceway_contact(bearing, bearing.inner, centre, inner_speed, position, velocity, spin)
        outer = raceway_contact(bearing, bearing.outer, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        return np.array([*inner.slip, *outer.slip])

    none = slips(np.zeros(4))
    matrix = np.stack([slips(unit) - none for unit in np.eye(4)], axis=1)
    scale = np.array([1.0, *(1.0 / bearing.ball_radius,) * 3])
    return scale * np.linalg.lstsq(matrix * scale, -none, rcond=1e-9)[0]


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving."""
    state = np.zeros((bearing.balls, COLUMNS))
    for k in range(bearing.balls):
        angle = 2.0 * math.pi * k / bearing.balls
        distance, height = equilibrium(bearing, 0.0, angle)
        state[k, ORBIT_ANGLE] = angle
        if motion == "rolling":
            for _ in range(3):
                orbit_rate = rolling(bearing, inner_speed, angle, distance, height)[0] / distance
                distance, height = equilibrium(bearing, orbit_rate, angle)
            state[k, VELOCITY + 1], *state[k, SPIN : SPIN + 3] = rolling(bearing, inner_speed, angle, distance, height)
        state[k, AXIS_DISTANCE], state[k, HEIGHT] = distance, height
    return state


def fastest_rates(bearing: Bearing, state: np.ndarray, inner_speed: float) -> Rates:
    """Contact resonance [rad/s], friction creep rate [1/s] and shortest contact [s] to be expected from a state.

    Loads are those of the state, at least those of a 1 micrometre approach; a ball between two contacts has both
    stiffnesses. The shortest contact is half a period of the contact resonance.
    """
    approach = 1e-6
    still = (0.0, 0.0, 0.0)
    for k in range(bearing.balls):
        position = (state[k, AXIS_DISTANCE], 0.0, state[k, HEIGHT])
        outer = raceway_contact(bearing, bearing.outer, still, 0.0, position, still, still)
        approach = max(approach, outer.approach)
    stiffness = 1.5 * (bearing.inner.constant + bearing.outer.constant) * math.sqrt(approach)
    load = max(bearing.inner.constant, bearing.outer.constant) * approach**1.5
    creep = bearing.friction_coefficient * load / bearing.friction_regularisation
    # A tangential force at the surface moves it as if the mass were 2/7 of the ball's; two contacts act together.
    friction = 2.0 * 3.5 * creep / bearing.ball_mass
    contact = math.sqrt(stiffness / bearing.ball_mass)
    return Rates(contact, friction, math.pi / contact)


def stable_step(rates: Rates) -> float:
    """A step [s] for the classical Runge-Kutta method: 16 a contact and inside its stability limit of 2.78/rate."""
    return min(rates.shortest_contact / 16.0, 1.4 / max(rates.friction, 1.0))


class BearingMotion:
    """The bearing in motion: `advance` integrates one chunk and returns its outputs.

    `counts` holds steps, rejections, evaluations of a ball's rates and Jacobians so far.
    """

    def __init__(self, parameters: BearingScene, law: str, stepper: str):
        self.parameters = parameters
        self.bearing = bearing_of(parameters, law)
        self.stepper = stepper
        start = start_state(self.bearing, parameters.drive.speed, parameters.initial.motion)
        self.rates = fastest_rates(self.bearing, start, parameters.drive.speed)
        self.step = parameters.solver.step or stable_step(self.rates)
        if stepper == "rk4" and self.step > self.rates.shortest_contact / 8.0:
            raise SceneError(
                f"solver.step = {self.step:g} s is too long: a contact can be as short as "
                f"{self.rates.shortest_contact:.2g} s and needs at least 8 steps; "
                f"use {self.rates.shortest_contact / 16.0:.2g} s or less, or solver.stepper: rodas4"
            )
        if stepper == "rk4" and self.step * self.rates.friction > 2.78:
            raise SceneError(
                f"solver.step = {self.step:g} s is unstable: friction answers at {self.rates.friction:.2g} /s and the "
                f"classical Runge-Kutta method holds to {2.78 / self.rates.friction:.2g} s; use a shorter step, "
                f"or solver.stepper: rodas4"
            )
        self._start = start
        speed = parameters.contact.friction_regularisation
        radius, pitch = self.bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
        unit = [APPROACH_SCALE, APPROACH_SCALE / pitch, APPROACH_SCALE, *(speed,) * 3, *(speed / radius,) * 3]
        self.scales = parameters.solver.tolerance * STEP_SHARE * np.array(unit)
        self.nudges = np.array([3e-12, 1e-7, 3e-12, *(1e-6 * speed,) * 3, *(1e-6 * speed / radius,) * 3])
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self.state = self._start.copy()
        self.orientation = np.zeros((self.bearing.balls, 4))
        self.orientation[:, 3] = np.cos(-0.5 * self.state[:, ORBIT_ANGLE])
        self.orientation[:, 2] = np.sin(-0.5 * self.state[:, ORBIT_ANGLE])
        self.drive = Drive(0.0, float(self.parameters.drive.speed), 0.0)
        self.goal_speed = float(self.parameters.drive.speed)
        self.steps = np.full(self.bearing.balls, 1e-6)
        self.counts = np.zeros(4, np.int64)

    def statistics(self) -> Statistics:
        """An empty collection of the figures of a run."""
        return Statistics(self.parameters)

    def gross_work(self) -> float:
        """Work [J] moved through the inner contacts since the start, each contact's power counted by its magnitude."""
        return float(self.state[:, GROSS_WORK].sum())

    def found(self, statistics: Statistics) -> Found:
        """What the run found so far."""
        work = self.gross_work()
        figures = statistics.figures(work)
        status = "failed: energy" if figures["energy_closure"] > ENERGY_GAIN else "done"
        return Found(figures, statistics.flags(work), status)

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of one ball's rates, and Jacobians, summed over the balls."""
        return {
            "ball_steps": int(self.counts[STEPS]),
            "ball_rejections": int(self.counts[REJECTIONS]),
            "ball_rates": int(self.counts[RATES]),
            "ball_jacobians": int(self.counts[JACOBIANS]),
        }

    def first_outputs(self) -> Outputs:
        """The outputs at the present instant."""
        out = empty_outputs(self.parameters, 1)
        write_outputs(self.bearing, self.drive, np.zeros(1), self.state[None], self.orientation[None], out, 0)
        return out

    def advance(self, times: np.ndarray, duration: float) -> Outputs:
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError.

        A new goal speed is approached at the drive's acceleration, constant within the chunk.
        """
        limit = self.parameters.drive.acceleration * duration
        change = min(limit, max(-limit, self.goal_speed - self.drive.speed))
        drive = Drive(self.drive.angle, self.drive.speed, change / duration)
        states = np.empty((len(times), *self.state.shape))
        orientations = np.empty((len(times), *self.orientation.shape))
        before = self.state.copy(), self.orientation.copy(), self.steps.copy()
        near = np.zeros(self.bearing.balls, np.bool_)
        mark_near(self.bearing, self.state, self.bearing.ball_radius, near)
        self._integrate(drive, near, times, duration, states, orientations)
        after = np.zeros_like(near)
        mark_near(self.bearing, self.state, 0.5 * self.bearing.ball_radius, after)
        if np.any(after & ~near):
            # Balls came together that were integrated apart: once more, all together.
            self.state[:], self.orientation[:], self.steps[:] = before
            near[:] = True
            self._integrate(drive, near, times, duration, states, orientations)
        out = empty_outputs(self.parameters, len(times))
        write_outputs(self.bearing, drive, times, states, orientations, out, 0)
        angle = drive.angle + duration * (drive.speed + 0.5 * drive.acceleration * duration)
        # The goal itself once it is reached, so that no rounding keeps an acceleration alive.
        speed = self.goal_speed if abs(change) < limit else drive.speed + change
        self.drive = Drive(angle, speed, 0.0)
        return out

    def _integrate(self, drive, near, times, duration, states, orientations):
        failure = np.zeros(2)
        common = self.state, self.orientation
        if self.stepper == "rk4":
            status = rk4_chunk(
                self.bearing,
                drive,
                near,
                times,
                duration,
                self.step,
                *common,
                states,
                orientations,
                self.counts,
                failure,
            )
        elif self.stepper == "rodas4":
            status = rosenbrock_chunk(
                RODAS4, self.bearing, drive, near, times, duration, self.scales, self.nudges, *common,
                self.steps, states, orientations, self.counts, failure,
            )  # fmt: skip
        else:
            status = self._scipy(drive, near, times, duration, states, orientations)
        if status != OK:
            reasons = {
                NOT_FINITE: "is not finite any more; shorten solver.step or use solver.stepper: rodas4",
                TOO_DEEP: "has run through a raceway; check the loads, or shorten solver.step",
                STALLED: "needs ever shorter steps; loosen solver.tolerance or raise contact.friction_regularisation",
            }
            raise IntegrationError(
                f"{failure[0]:.6g} s into this chunk of {duration:.6g} s, ball {int(failure[1])} {reasons[status]}"
            )

    def _scipy(self, drive, near, times, duration, states, orientations):
        """One chunk by a SciPy method: the same equations, for reference."""
        shape = self.state.shape
        rates = np.zeros(shape)

        def right_hand_side(time, flat):
            bearing_rates(self.bearing, drive, near, time, flat.reshape(shape), rates)
            return rates.ravel().copy()

        scales = np.concatenate([REFERENCE_SHARE * self.scales, [1e-12] * (COLUMNS - MOTION)])
        method = SCIPY[self.stepper](
            right_hand_side,
            0.0,
            self.state.ravel().copy(),
            duration,
            rtol=2.3e-14,
            atol=np.tile(scales, self.bearing.balls),
            first_step=min(1e-7, duration),
        )
        cursor = 0
        while method.status == "running":
            # SciPy probes the integrals, on which nothing depends, with ever greater increments.
            with np.errstate(over="ignore"):
                message = method.step()
            if method.status == "failed" or not np.all(np.isfinite(method.y)):
                raise IntegrationError(f"SciPy's {self.stepper} stopped at {method.t:.6g} s: {message or 'not finite'}")
            dense = method.dense_output()
            start = dense(method.t_old).reshape(shape)
            while cursor < len(times) and times[cursor] <= method.t:
                self._turn_all(dense, method.t_old, times[cursor], start, orientations[cursor])
                states[cursor] = dense(times[cursor]).reshape(shape)
                cursor += 1
            self._turn_all(dense, method.t_old, method.t, start, self.orientation)
        self.state[:] = method.y.reshape(shape)
        self.counts[STEPS] += method.nfev // 12 * self.bearing.balls
        self.counts[RATES] += method.nfev * self.bearing.balls
        self.counts[JACOBIANS] += method.njev * self.bearing.balls
        return OK

    def _turn_all(self, dense, begin, end, start, out):
        middle, last = (dense(t).reshape(start.shape) for t in (0.5 * (begin + end), end))
        for k in range(self.bearing.balls):
            spins = relative_spin(start[k]), relative_spin(middle[k]), relative_spin(last[k])
            out[k] = turned(tuple(self.orientation[k]), *spins, end - begin)
