"""Limits of the step of an ellipsoid on a plane by `rk4`, and of a sphere on a beam by Volterra's equation.

A ball strikes the plane: its steps begin at the touch, the error is that of its speed and peak load. Nothing grows
within one contact; a step is too long where one kick turns the speed round by too much: above 1/TOUCH of the contact.

A ball lies on the plane and creeps until it rolls: the error is that of friction over mu m g, after slip ought to have
died out; the prediction is `derived.longest_creep_step`.

A beam is struck: Volterra's equation is solved for the force of each step, so nothing grows there, but a force that
goes straight between steps errs by more than FAILS of the greatest where HATS or fewer make a contact.
"""

import math

import numpy as np

from bearing_twin.charts.limits import MapPlace
from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.beam.derived import beam_of, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.impact import hertz_contact_time, throw
from bearing_twin.kinds.beam.modes import modes_of
from bearing_twin.kinds.beam.motion import throw_scene
from bearing_twin.kinds.beam.theory import theory_of
from bearing_twin.kinds.ellipsoid import chunk
from bearing_twin.kinds.ellipsoid.derived import ellipsoid_mass, longest_creep_step, shortest_contact
from bearing_twin.kinds.ellipsoid.motion import EllipsoidMotion
from bearing_twin.kinds.impact.collision import FEWEST_STEPS
from bearing_twin.report import Choice
from bearing_twin.run.scene import load_scene

TOUCH, HATS = 2.4, 4.8  # steps a contact, found once: of rk4 from the touch on, and of hats
EXACT = 1e-12  # tolerance of what is taken as true
STRIKES = ("start.height=0", "start.velocity=[0,0,-1]", "gravity=[0,0,0]", "contact.restitution=1")
DIED, JUDGED, LOOKS = 60.0, 40.0, 200  # over the rate of slip: time for it to die out, time judged, instants looked at
PERCENT = 1e-2  # of a slip on v_s, at the start
MARGIN, SPAN = 1.05, 3.0  # over the first contact: what is compared; over Hertz's contact time: what is computed
MODES = 301  # as on the chart of beams


def motion_of(stepper: str, *keys: str) -> EllipsoidMotion:
    """The shipped ball on its plane with these keys, by `rk4` or exactly, past what is refused."""
    scene = load_scene("ellipsoid_on_plane", keys)
    motion = EllipsoidMotion(scene.parameters, Choice("hertz", stepper, 0.0, "", ()))
    if stepper != "rk4":
        motion.plan = motion.plan._replace(tolerance=EXACT)
    return motion


def _bounce(motion: EllipsoidMotion, span: float) -> np.ndarray:
    """Speed after the contact and peak load of the first contact; infinite where none ends within `span` [s]."""
    motion.reset()
    motion.advance(np.array([]), span)
    ended = motion.take_records()["contact"]
    places = [chunk.RECORDED.index(one) for one in (chunk.SPEED_OUT, chunk.PEAK_LOAD)]
    return ended[0, places] if len(ended) else np.full(2, np.inf)


def striking(*keys: str) -> MapPlace:
    """A ball that strikes the plane with 1 m/s."""
    coarse, exact = (motion_of(stepper, *STRIKES, *keys) for stepper in ("rk4", "dop853"))
    contact = shortest_contact(coarse.parameters)
    true = _bounce(exact, SPAN * contact)

    def error(_, step):
        coarse.plan = coarse.plan._replace(fixed=step)
        try:
            return float(np.abs(_bounce(coarse, SPAN * contact) / true - 1.0).max())
        except IntegrationError:
            return math.inf

    return MapPlace(error, lambda _: contact / TOUCH, contact / FEWEST_STEPS)


def creeping(regularisation: float) -> MapPlace:
    """A ball that lies on the plane and slips by a hundredth of the regularisation [m/s] at the start."""
    rubs = ("contact.friction_coefficient=0.1", f"contact.friction_regularisation={regularisation!r}")
    still = ("contact.restitution=1", f"start.velocity=[{PERCENT * regularisation!r},0,0]", *rubs)
    first = motion_of("rk4", *still, "start.height=0")
    weight = -float(first.parameters.gravity[2]) * ellipsoid_mass(first.parameters.body)
    sunk = f"start.height={-((weight / first.body.law.given) ** (1.0 / first.body.law.power))!r}"
    coarse, exact = (motion_of(stepper, *still, sunk) for stepper in ("rk4", "dop853"))
    limit = longest_creep_step(coarse.parameters)
    times = limit * (DIED + JUDGED * np.linspace(0.0, 1.0, LOOKS))
    true, contact = exact.advance(times, times[-1])["friction_force"], shortest_contact(coarse.parameters)

    def error(_, step):
        coarse.plan = coarse.plan._replace(fixed=step)
        coarse.reset()
        try:
            found = coarse.advance(times, times[-1])["friction_force"]
        except IntegrationError:
            return math.inf
        return float(np.abs(found - true).max() / (PERCENT * 0.1 * weight))

    return MapPlace(error, lambda _: limit, min(limit, contact / FEWEST_STEPS))


def struck(*keys: str) -> MapPlace:
    """The sphere of the shipped scene on its beam, the first contact."""
    parameters = load_scene("sphere_on_beam", ("wanted.tolerance=1e-6", *keys)).parameters
    beam, sphere = beam_of(parameters, theory_of(parameters)), thrown_sphere(parameters)
    speed = touch_speed(parameters.blow)
    modes, contact = modes_of(beam, parameters.blow.point * beam.span, MODES), hertz_contact_time(sphere, speed)
    exact = throw_scene(parameters)
    times = np.linspace(0.0, MARGIN * exact.contacts[0].duration, LOOKS)
    true = exact.at(times)[1]

    def error(_, step):
        found = throw(beam, modes, sphere, speed, SPAN * contact, contact / step, "volterra")
        return float(np.abs(found.at(times)[1] - true).max() / true.max())

    return MapPlace(error, lambda _: contact / HATS, contact / FEWEST_STEPS)
