"""All that could be taken for one bearing scene, each tried once: laws, dimensions, cages, steppers, settings.

Truth is the scene as it is given, by `rodas4` ten times tighter than the tightest setting. A contestant is first run
for its errors; of those that are good enough, the ones that may be cheapest are timed, each alone and with the
companion that a user's run has. Where a ring that is free in the scene is held, or one that is held is freed, it is
placed or loaded as the truth says on average. Where balls hop, runs as chosen name a horizon beyond which nobody knows
their motion: outputs up to the earliest are compared.
"""

import contextlib
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.timing import timed
from bearing_twin.contact.laws import LAWS
from bearing_twin.errors import IntegrationError, SceneError
from bearing_twin.kinds.bearing.measured import steppers_of
from bearing_twin.kinds.bearing.models import law_error
from bearing_twin.kinds.bearing.motion import BearingMotion, bearing_motion
from bearing_twin.kinds.bearing.motions import motions_of
from bearing_twin.kinds.bearing.moving import moving_by
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, PRESCRIBED, QUASI_STATIC, dimension_of
from bearing_twin.report import Choice
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene

SPAN, OUTPUTS = 0.02, 40  # s and outputs of a run
NOTHING = 1e-9  # relative: rounding of an instant
SETTINGS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7)
FINEST = 3e-8
LEAST_WANTED = 1e-6  # nobody asks for less
HERTZ, STEPPER, EXPLICIT = "hertz", "rodas4", "dopri5"
TRIED_LAWS = tuple(name for name, law in LAWS.items() if law.fits == "point" and not law.measured)
DIMENSIONS = QUASI_STATIC, PRESCRIBED, FREE_RING
CAGES = "none", EVEN, POCKETS
RATES = f"run.output_rate={OUTPUTS / SPAN}", "run.publish_rate=100", f"run.duration={SPAN}"
ENOUGH = 0.02  # CPU seconds of a timing
NEAR, FEW = 2.0, 4  # of the least seconds of first runs: what is timed, and how many at most
SLOW = 20.0  # times the seconds of the tightest run of STEPPER: what goes on for longer is never the cheapest


class Combination(NamedTuple):
    """A combination: law, dimension, cage, stepper (that of equilibria is their dimension) and its tolerance."""

    law: str
    dimension: str
    cage: str
    stepper: str
    setting: float

    @property
    def choice(self) -> Choice:
        """What moves a bearing so."""
        return Choice(self.law, self.stepper, 0.0, "", ())


class Trial(NamedTuple):
    """Errors of load and of friction of a model, infinite where it broke, and CPU seconds of its quickest run."""

    load_error: float
    friction_error: float
    seconds: float

    def error(self, outputs: str) -> float:
        """What counts for the outputs that are wanted."""
        return of_wanted(outputs, self.load_error, self.friction_error)


LOST = Trial(math.inf, math.inf, math.inf)


def of_wanted(outputs: str, load_error: float, friction_error: float) -> float:
    """The error that counts for the outputs that are wanted."""
    return load_error if outputs == LOADS else max(load_error, friction_error)


def advanced(motion):
    """The outputs of a motion over SPAN, from its start."""
    motion.reset()
    return motion.advance(SPAN / OUTPUTS * np.arange(1, OUTPUTS + 1), SPAN)


def first_of(out, count: int):
    """The first so many outputs of a motion."""
    numbers = getattr(out, "numbers", None)
    return type(out)(*(one[:count] for one in out)) if numbers is None else Rows(out.layout, numbers[:count])


class Trials:
    """One scene with these overrides, and all that can be tried on it."""

    def __init__(self, scene: str, overrides: tuple[str, ...], wanted: tuple[tuple[str, float], ...] = ()):
        """`wanted`: outputs and tolerances of the runs whose horizons count, none where balls do not hop."""
        self._scene, self._overrides = scene, overrides
        self._compared = self._known(wanted)
        given = self.scene(FINEST).parameters
        self.own = dimension_of(given), given.cage.kind
        self._true = bearing_motion(given, Choice(HERTZ, STEPPER, 0.0, "", ()))
        self.exact = first_of(advanced(self._true), self._compared)
        self.found: dict[Combination, Trial] = {}
        self._costs: dict[Combination, tuple[float, float]] = {}
        self._watched: dict[tuple, Trial] = {}
        self._limit = SLOW * self.trial(self.as_given(HERTZ, STEPPER, SETTINGS[-1])).seconds

    def _known(self, wanted: tuple[tuple[str, float], ...]) -> int:
        """How many outputs are up to the earliest horizon that the runs name of which this is wanted."""
        earliest = SPAN
        for outputs, tolerance in wanted:
            run = Run(self.scene(tolerance, outputs))
            for _ in run.blocks():
                pass
            earliest = min(earliest, run.report.errors.get("horizon_s", SPAN))
        return int((1.0 + NOTHING) * earliest / SPAN * OUTPUTS)

    def as_given(self, law: str, stepper: str, setting: float) -> Combination:
        """A model in the dimension of the scene and with its cage."""
        return Combination(law, *self.own, stepper, setting)

    def keys(self, wanted: float, outputs: str = "history") -> tuple[str, ...]:
        """What differs from the shipped scene, with what is wanted of it."""
        return *self._overrides, f"wanted.tolerance={wanted}", f"wanted.outputs={outputs}", *RATES

    def scene(self, wanted: float, outputs: str = "history", *more: str):
        """The scene with that, and `more` overrides."""
        return load_scene(self._scene, (*self.keys(wanted, outputs), *more))

    def _differs(self, model: Combination) -> tuple[str, ...]:
        """Overrides that make the scene's dimension and cage those of a model."""
        differs = [f"model.dimension={model.dimension}"]
        differs += [f"cage.kind={model.cage}"] if model.cage != self.own[1] else []
        if self.own[0] == model.dimension:
            return tuple(differs)
        given = self.scene(FINEST).parameters
        if model.dimension == PRESCRIBED and self.own[0] == FREE_RING:
            place = np.asarray(self.exact.inner_ring_offset).mean(axis=0).tolist()
            return (*differs, f"drive.offset={place}", "rings.inner.load=[0,0,0]", "rings.inner.free=none")
        if model.dimension == FREE_RING:
            mass = given.rings.inner.mass or 0.5
            force = np.asarray(self.exact.inner_ring_force).mean(axis=0)
            load = (-force - mass * np.array(given.gravity)).tolist()
            return (*differs, f"rings.inner.load={load}", f"rings.inner.mass={mass}", "rings.inner.inertia=[1e-4,1e-4]")
        return tuple(differs)

    def _scene_of(self, model: Combination, wanted: float, outputs: str = "history", *more: str):
        return self.scene(wanted, outputs, *self._differs(model), *more)

    def trial(self, model: Combination) -> Trial:
        """How a model does: its errors, and the seconds of the quicker of two runs."""
        if model not in self.found:
            try:
                self.found[model] = self._tried(model)
            except (IntegrationError, SceneError, ArithmeticError):
                self.found[model] = LOST
        return self.found[model]

    def _tried(self, model: Combination) -> Trial:
        setting = FINEST if math.isnan(model.setting) else model.setting
        make = bearing_motion if model.dimension == QUASI_STATIC else BearingMotion
        motion = make(self._scene_of(model, setting).parameters, model.choice)
        out, cost = timed(lambda: advanced(motion), 0.0)
        again = timed(lambda: advanced(motion), 0.0)[1]
        return Trial(*self.errors_of(out), min(cost.seconds, again.seconds))

    def errors_of(self, out) -> tuple[float, float]:
        """Errors of load and of friction of outputs; infinite where something is not finite."""
        out = first_of(out, self._compared)
        load = float(np.abs(out.normal_load - self.exact.normal_load).max() / self.exact.normal_load.max())
        rubs = self._true.parameters.contact.friction_coefficient > 0.0
        friction = errors(self._true, out, self.exact)[1] if rubs else 0.0
        return load if math.isfinite(load) else math.inf, friction

    def all(self) -> dict[Combination, Trial]:
        """All that is to be tried, tried."""
        for ladder in self._ladders():
            for model in ladder:
                one = self.trial(model)
                if one.error("history") <= LEAST_WANTED or not one.seconds <= self._limit:
                    break  # tighter costs more, and nobody asks for it
        return self.found

    def _ladders(self) -> Iterator[list[Combination]]:
        """Models in the order of their settings, loose first."""
        parameters = self.scene(FINEST).parameters
        for law in TRIED_LAWS:
            least = 0.1 * law_error(law, parameters)
            settings = [one for one in SETTINGS if one >= least]
            yield from (
                [self.as_given(law, stepper, one) for one in settings]
                for stepper in steppers_of(motions_of(parameters))
            )
            yield [Combination(law, QUASI_STATIC, EVEN, QUASI_STATIC, math.nan)]
        if self.own == (PRESCRIBED, "none"):
            yield [self.as_given(HERTZ, EXPLICIT, one) for one in SETTINGS[::2]]
        for dimension in DIMENSIONS[1:]:
            for cage in CAGES:
                if (dimension, cage) != self.own:
                    yield [Combination(HERTZ, dimension, cage, STEPPER, one) for one in SETTINGS[::2]]

    def enough(self, outputs: str, wanted: float) -> list[Combination]:
        """Those that are good enough and may be cheapest, by their first runs; best first."""
        good = sorted((one.seconds, model) for model, one in self.all().items() if one.error(outputs) <= wanted)
        return [model for seconds, model in good[:FEW] if seconds <= NEAR * good[0][0]]

    def cost(self, model: Combination) -> tuple[float, float]:
        """CPU seconds of a run of the model alone, and their spread."""
        if model not in self._costs:
            setting = FINEST if math.isnan(model.setting) else model.setting
            make = bearing_motion if model.dimension == QUASI_STATIC else BearingMotion
            motion = make(self._scene_of(model, setting).parameters, model.choice)
            self._costs[model] = tuple(timed(lambda: advanced(motion), ENOUGH)[1])
        return self._costs[model]

    def watched(self, model: Combination, wanted: float, outputs: str) -> Trial:
        """The same with the companion of a run of which this is wanted, which does parts again; LOST if it fails."""
        key = model, wanted, outputs
        if key not in self._watched:
            self._watched[key] = LOST
            with contextlib.suppress(IntegrationError, ArithmeticError):
                parameters = self._scene_of(model, wanted, outputs).parameters
                motion = moving_by(parameters, model.choice._replace(setting=model.setting))
                out, cost = timed(lambda: advanced(motion), ENOUGH)
                self._watched[key] = Trial(*self.errors_of(out), cost.seconds)
        return self._watched[key]

    def told(self, wanted: float, outputs: str, *more: str) -> str:
        """The first word of what a user's run of the scene says of itself, with `more` overrides."""
        run = Run(self.scene(wanted, outputs, *more))
        with contextlib.suppress(IntegrationError):
            for _ in run.blocks():
                pass
        return run.report.status.partition(":")[0]
