"""The greatest approach of damped bodies, which comes after the greatest load, against an impact solved by SciPy."""

import math

import pytest
from scipy.integrate import solve_ivp

from bearing_twin import simulate

RADIUS, MODULUS, RATIO, DENSITY = 0.02, 2.0e11, 0.3, 7800.0
STEEL = {"young_modulus": MODULUS, "poisson_ratio": RATIO, "density": DENSITY}
COEFFICIENT = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - RATIO**2)) * math.sqrt(RADIUS)
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
SPEED = 0.5
SCENES = {
    "ellipsoid_on_plane": {
        "body": {"semi_axes": [RADIUS] * 3, "material": STEEL},
        "plane": {"material": STEEL},
        "start": {"height": 1e-4, "velocity": [0.0, 0.0, -SPEED]},
    },
    "two_bodies": {
        "first": {
            "shape": "sphere",
            "radius": RADIUS,
            "position": [0.0, 0.0, RADIUS + 1e-4],
            "velocity": [0.0, 0.0, -SPEED],
            "material": STEEL,
        },
        "second": {"shape": "plane", "material": STEEL},
        "wanted": {"tolerance": 1e-8},
    },
}
DAMPED = {
    "damping": (1.0, lambda x, rate: COEFFICIENT * x**1.5 * (1.0 + rate)),
    "viscosity": (2e4, lambda x, rate: COEFFICIENT * x**1.5 + 2e4 * x**0.25 * rate),
}


def deepest(load):
    """Greatest approach [m] of the sphere, and that at its greatest load."""

    def turns(_, y):
        return y[1]

    turns.terminal = True
    found = solve_ivp(
        lambda _, y: [y[1], -load(max(y[0], 0.0), y[1]) / MASS],
        (0.0, 1.0),
        [0.0, SPEED],
        "DOP853",
        events=turns,
        rtol=1e-12,
        atol=[1e-18, 1e-12],
        max_step=1e-7,
    )
    hardest = max(range(len(found.t)), key=lambda k: load(max(found.y[0, k], 0.0), found.y[1, k]))
    return found.y[0, -1], found.y[0, hardest]


@pytest.mark.parametrize("key", DAMPED)
@pytest.mark.parametrize("kind", SCENES)
def test_damping_puts_the_greatest_approach_after_the_greatest_load(kind, key):
    value, load = DAMPED[key]
    scene = {
        "kind": kind,
        "gravity": [0.0, 0.0, 0.0],
        "contact": {key: value, "friction_coefficient": 0.0},
        "run": {"duration": 1e-3},
    }
    run = simulate(scene | SCENES[kind])
    blocks = list(run.blocks())
    exact, at_load = deepest(load)
    assert at_load < 0.99 * exact
    found = run.report.as_dict()
    assert found["greatest_approach_m"] == pytest.approx(exact, rel=1e-8)
    assert abs(found["greatest_approach_m"] - exact) < 3.0 * found["greatest_approach_m_error"] + 1e-10 * exact
    assert max(block.values["approach"].max() for block in blocks) <= exact * (1.0 + 1e-8)
