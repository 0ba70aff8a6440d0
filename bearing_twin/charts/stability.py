"""Maps of where methods fail: error as colour over step and stiffness, tolerance and regularisation.

One ball of a 6203, which rolls in balance or, on the maps `sliding` and `tolerance`, starts at rest. A step is judged
after SPAN: what grows has grown by then. A step fails where load or friction errs by more than FAILS of the greatest
load, or of mu N; the limit found is the longest step up to which none that was tried does. The predicted limit is
`step_limits.stability_limits` of the state at the start; the software refuses steps beyond what the same function says
of a contact at least 1 micrometre deep.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from bearing_twin.charts.bearing_cells import Case, bearing_row, found_errors, ready, to_start, truth
from bearing_twin.charts.contest import LIMIT, Asked, Job, answers_of, rows_of
from bearing_twin.charts.limits import Limit, command_of, longest, spread
from bearing_twin.charts.model_limits import LIMITED, limit_cell
from bearing_twin.charts.model_maps import MODELS, model_cell, model_tasks
from bearing_twin.charts.table import MapRow
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP, fastest_rates, stability_limits
from bearing_twin.numerics.steppers import STEPPER_FACTS
from bearing_twin.parameters import echo, unknown

SCENE, SPAN = "bearing_6203", 2e-3
BODIES = ("ball", "inner_ring", "outer_ring")


class MapAxis(NamedTuple):
    """The second number of a map: what it is, its unit, its values, and the keys of a scene that it sets."""

    title: str
    unit: str
    values: tuple[float, ...]
    keys: Callable[[float], tuple[str, ...]]
    always: tuple[str, ...] = ()


def _regularised(value: float) -> tuple[str, ...]:
    return (f"contact.friction_regularisation={value}",)


FROM_REST = ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]")
AXES = {
    "stiffness": MapAxis(
        "Young's modulus",
        "Pa",
        spread(2e10, 2e12, 9),
        lambda value: tuple(f"materials.{body}.young_modulus={value}" for body in BODIES),
    ),
    "regularisation": MapAxis(
        "friction regularisation",
        "m/s",
        spread(1e-3, 1e-1, 9),
        _regularised,
    ),
    "sliding": MapAxis("friction regularisation", "m/s", spread(1e-3, 1e-1, 9), _regularised, FROM_REST),
    "damping": MapAxis(
        "relaxation time",
        "s",
        spread(1e-7, 1e-5, 9),
        lambda value: (f"contact.relaxation_time={value}",),
        ("contact.friction_coefficient=0.01",),
    ),
}
STEPS = spread(5e-8, 5e-5, 22)
TOLERANCES = spread(1e-1, 1e-7, 7)
REGULARISATIONS = spread(1e-4, 1e-1, 7)
FIXED = tuple(name for name in FIXED_STEP if name in STEPPER_FACTS)
ADAPTIVE = ("rodas4", "rodas4_landing", "rodas3", "dopri5")
TOLERANCE = "tolerance"
MAPS = (*AXES, TOLERANCE, *MODELS, *LIMITED)


def case_of(name: str, across: float) -> Case:
    """The small bearing of a map at its second number."""
    if name == TOLERANCE:
        keys = (*FROM_REST, *_regularised(across))
        return Case(SCENE, ("geometry.balls=1", *keys), 0.05 * SPAN, 10)
    axis = AXES[name]
    return Case(SCENE, ("geometry.balls=1", *axis.always, *axis.keys(across)), 0.05 * SPAN, 20)


def cell(name: str, method: str, setting: float, across: float, limit: float = LIMIT) -> MapRow:
    """One cell of a map."""
    row = MapRow(name, method, setting, across=across, command=command_of(name, method, setting, across))
    return bearing_row(row, case_of(name, across), limit, enough=0.0)


def limit(name: str, method: str, across: float) -> Limit:
    """The limits of a fixed-step method at one place of a map."""
    case = case_of(name, across)
    motion = ready(case, method, 1e-8)
    slides = motion.parameters.initial.motion == "rest"
    predicted = min(stability_limits(fastest_rates(motion.bearing, motion.state, 0.0), method, slides))
    refused = min(stability_limits(motion.rates, method, slides))

    def error(step):
        to_start(motion, step)
        return max(found_errors(motion, case, truth(case)))

    return Limit(method, name, across, predicted, refused, longest(predicted, error))


def tasks_of(names=MAPS, every: int = 1, steps=STEPS, limit: float = LIMIT) -> tuple[list[Job], list[Job]]:
    """The cells and the limits of these maps; with `every` above 1 only every so many-th of the second numbers."""
    cells, limits = [], []
    for name in names:
        if name in MODELS:
            cells += model_tasks(name, limit)
            continue
        if name in LIMITED:
            facts = LIMITED[name]
            places = ((name, method, across) for method in facts.methods for across in facts.across[::every])
            limits += [Job("model_limits:limit", one) for one in places]
            continue
        for method in ADAPTIVE if name == TOLERANCE else FIXED:
            for across in REGULARISATIONS[::every] if name == TOLERANCE else AXES[name].values[::every]:
                settings = TOLERANCES if name == TOLERANCE else steps
                cells += [Job("stability:cell", (name, method, one, across, limit)) for one in settings]
                if name != TOLERANCE:
                    limits.append(Job("stability:limit", (name, method, across)))
    return cells, limits


def blank(task: Job) -> MapRow:
    """The row of a cell before it has run."""
    words = task.arguments[:4]
    return MapRow(*words[:3], across=words[3], command=command_of(*words))


def measure(wanted: Asked, every: int = 1, steps=STEPS) -> tuple[list[MapRow], list[Limit]]:
    """All cells and all limits of the maps that are wanted."""
    cells, limits = tasks_of(wanted.problems, every, steps, wanted.limit)
    answers = answers_of([*limits, *cells], wanted.kept, wanted.update, wanted.workers)
    rows = rows_of(cells, answers[len(limits) :], blank, wanted.limit)
    return rows, [Limit(*one) for one in answers[: len(limits)] if one is not None]


def one_cell(words: str, limit: float = LIMIT) -> MapRow:
    """The cell named as in `Row.command`; raises BearingTwinError with what is legal."""
    parts = words.split()
    if len(parts) != 4:
        raise BearingTwinError(f"{echo(words)} is no cell; give four words: map, method, setting, second number")
    name, method = parts[:2]
    if name not in MAPS:
        raise BearingTwinError(f"{echo(name)} is not a map; {unknown(name, MAPS)}")
    others = {**MODELS, **LIMITED}
    legal = others[name].methods if name in others else ADAPTIVE if name == TOLERANCE else FIXED
    if method not in legal:
        raise BearingTwinError(f"{echo(method)} is not on the map {name}; {unknown(method, legal)}")
    try:
        numbers = [float(part) for part in parts[2:]]
    except ValueError:
        numbers = [math.nan]
    if not all(0.0 < number < math.inf for number in numbers):
        raise BearingTwinError(f"{echo(words)} ends with two numbers above zero: setting and second number")
    one = model_cell if name in MODELS else limit_cell if name in LIMITED else cell
    return one(name, method, *numbers, limit)
