"""Limits of steps, predicted and found, over two decades of what they depend on: spheres, soft discs, `body_limits`.

Spheres: the error is that of the speed after the contact over the speed before, the worst of PHASES instants of the
touch within a step. Nothing grows within one contact; what fails is a step that goes so deep that one kick turns the
speed round by too much. For `symplectic_euler` that is a closed form: at the depth v h and the rate v its kick is
h c (v h)^1.5 (1 + chi v) / m, and e v is the speed that ought to come out, so that h is too long above
((1 + e + FAILS) m / (c v^0.5 (1 + chi v)))^0.4. `rk4` has no such form; it holds to RK4 of the same unit, whatever chi.

Soft disc: the error is the energy that the numbers gain or lose, over that brought; the prediction is the bound
`solve.stable_step`, from the greatest eigenvalues.
"""

import dataclasses
import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.charts import body_limits as bodies
from bearing_twin.charts.contest import judged
from bearing_twin.charts.limits import FAILS, Limit, MapPlace, command_of, longest, spread
from bearing_twin.charts.table import MapRow
from bearing_twin.contact.damping import restitution_of
from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.impact.collision import FEWEST_STEPS, FIXED_STEP, march_fixed
from bearing_twin.kinds.impact.derived import pair_contact_time, sphere_pair
from bearing_twin.kinds.impact.spring import NO_LINE, Spring
from bearing_twin.kinds.soft_discs.derived import time_unit
from bearing_twin.kinds.soft_discs.solve import solve, stable_step
from bearing_twin.run.scene import load_scene

PHASES, ROOM = 24, 4000  # instants of the touch within a step; nodes that a contact may take
RK4 = 1.34  # ((m / (c v^0.5))^0.4): found once, for elastic steel spheres
MESH = ("mesh.divisions=16", "mesh.order=2", "wanted.tolerance=0.01")
ENERGIES = ("kinetic", "elastic", "contact")


class Limited(NamedTuple):
    """Where limits are looked for: which bodies, what is varied and its unit, its values, methods, what a place is."""

    bodies: str
    title: str
    unit: str
    methods: tuple[str, ...]
    across: tuple[float, ...]
    place: Callable


def _spheres(modulus: float = 2.1e11, number: float = 0.0) -> MapPlace:
    """Two steel spheres of the shipped scene, with chi v = `number`."""
    moduli = (f"{body}.material.young_modulus={modulus!r}" for body in ("first", "second"))
    parameters = load_scene("two_spheres", moduli).parameters
    coefficient, first, second = map(float, sphere_pair(parameters))
    mass, speed = first * second / (first + second), float(parameters.motion.speed)
    spring, out = Spring(coefficient, NO_LINE, number / speed), restitution_of(number)
    unit = (mass / (coefficient * speed**0.5)) ** 0.4

    def error(method, step):
        worst, nodes = 0.0, np.empty((ROOM, 4))
        for phase in (np.arange(PHASES) + 0.5) / PHASES:
            last = march_fixed(FIXED_STEP.index(method), spring, mass, speed, step, phase, nodes)
            if last < 0:
                return np.inf
            worst = max(worst, abs(nodes[last - 1, 2] / speed + out))
        return worst

    def predicted(method):
        return unit * (RK4 if method == "rk4" else ((1.0 + out + FAILS) / (1.0 + number)) ** 0.4)

    return MapPlace(error, predicted, pair_contact_time(parameters) / FEWEST_STEPS)


def _disc(*keys: str) -> MapPlace:
    """The disc of the mean problem on a coarse mesh."""
    parameters = load_scene("soft_discs_mean", (*MESH, *keys)).parameters
    bound = stable_step(parameters) * time_unit(parameters)

    def error(_, step):
        solver = dataclasses.replace(parameters.solver, step_share=step / bound)
        try:
            found = solve(dataclasses.replace(parameters, solver=solver), frames=2)
        except IntegrationError:
            return np.inf
        energy = sum(found.column(name) for name in ENERGIES)
        return float(np.abs(energy / energy[0] - 1.0).max())

    return MapPlace(error, lambda _: bound, bound)


DISC, BALL, HATS = ("central_differences",), ("rk4",), ("volterra",)
LIMITED = {
    "impact_stiffness": Limited(
        "two spheres", "Young's modulus", "Pa", FIXED_STEP, spread(2e10, 2e12, 9), lambda value: _spheres(value)
    ),
    "impact_damping": Limited(
        "two spheres", "damping times speed", "1", FIXED_STEP, spread(1e-2, 1.0, 9),
        lambda value: _spheres(number=value),
    ),
    "disc_stiffness": Limited(
        "soft disc", "Young's modulus", "Pa", DISC, spread(1e5, 1e7, 5),
        lambda value: _disc(f"disc.material.young_modulus={value!r}"),
    ),
    "disc_penalty": Limited(
        "soft disc", "stiffness ratio k r / E of the contact", "1", DISC, spread(1.0, 1e2, 5),
        lambda value: _disc(f"contact.stiffness_ratio={value!r}"),
    ),
    "disc_poisson": Limited(
        "soft disc", "1 - 2 (Poisson's ratio)", "1", DISC, spread(4e-3, 4e-1, 5),
        lambda value: _disc(f"disc.material.poisson_ratio={0.5 - 0.5 * value!r}"),
    ),
    "ellipsoid_stiffness": Limited(
        "ellipsoid strikes", "Young's modulus", "Pa", BALL, spread(2e10, 2e12, 9),
        lambda value: bodies.striking(*(f"{body}.material.young_modulus={value!r}" for body in ("body", "plane"))),
    ),
    "ellipsoid_damping": Limited(
        "ellipsoid strikes", "damping times speed", "1", BALL, spread(1e-2, 1.0, 9),
        lambda value: bodies.striking(f"contact.damping={value!r}"),
    ),
    "ellipsoid_creep": Limited(
        "ellipsoid creeps", "friction regularisation", "m/s", BALL, spread(1e-5, 1e-3, 9), bodies.creeping
    ),
    "beam_stiffness": Limited(
        "sphere on a beam", "Young's modulus of the sphere", "Pa", HATS, spread(2e10, 2e12, 9),
        lambda value: bodies.struck(f"sphere.material.young_modulus={value!r}"),
    ),
    "beam_damping": Limited(
        "sphere on a beam", "damping ratio of the modes", "1", HATS, spread(5e-3, 5e-1, 9),
        lambda value: bodies.struck(f"beam.damping_ratio={value!r}"),
    ),
}  # fmt: skip
_place = functools.lru_cache(maxsize=8)(lambda name, across: LIMITED[name].place(across))


def limit(name: str, method: str, across: float) -> Limit:
    """The limits of a method at one place."""
    place = _place(name, across)
    predicted = place.predicted(method)
    found = longest(predicted, lambda step: place.error(method, step))
    return Limit(method, name, across, predicted, place.refused, found)


def limit_cell(name: str, method: str, step: float, across: float, most: float) -> MapRow:
    """One step [s] at one place, past what is refused; `most` CPU seconds."""
    place = _place(name, across)
    row = MapRow(name, method, step, across=across, command=command_of(name, method, step, across))
    return judged(row, lambda: {"load_error": place.error(method, step)}, most)
