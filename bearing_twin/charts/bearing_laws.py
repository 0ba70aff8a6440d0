"""Elastic laws and friction models inside the bearing's run, each at several tolerances.

Truth at a tolerance of 1e-8 is `hertz_exact`, and `spot_fine` of friction over the spot. Seconds are CPU seconds per
simulated second.
"""

from bearing_twin.charts.bearing_cells import Case, bearing_row, command_of
from bearing_twin.charts.contest_picture import Contest
from bearing_twin.charts.table import DONE, Row
from bearing_twin.contact.friction import FRICTIONS

CASES = {
    "settled": Case("bearing_6203", (), 1e-3, 20),
    "thrust": Case("bearing_6203", ("drive.offset=[0.0,0.0,3e-5]",), 1e-3, 20),
    "lift-off": Case("bearing_6203_loose", (), 1e-3, 20),
}
LAWS = ("hertz", "hertz_exact", "hertz_differential", "volumetric", "constant")
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
PROBLEMS = {"settled": "settled", "thrust": "under thrust", "lift-off": "lift-off"}
TRUE_FRICTION, FEW = "spot_fine", 5  # outputs of a run with friction over the spot
TRUE_LAW, STEPPER, FINE = "hertz_exact", "rodas4", 1e-5  # FINE: tolerance at which what is left is the law's


def judge(name: str, law: str, setting: float, limit: float) -> Row:
    """One run."""
    row = Row(name, STEPPER, setting, command=_command(name, law, setting))
    return bearing_row(row, CASES[name], limit, law, (CASES[name], TRUE_LAW)).but(method=law)


def _command(name, law, setting):
    return command_of(CASES[name], STEPPER, setting, f"contact.normal={law}")


def judge_friction(name: str, model: str, setting: float, limit: float) -> Row:
    """One run with a friction model."""
    row = Row(name, STEPPER, setting, command=_friction_command(name, model, setting))
    found = bearing_row(row, _rubbing(name, model), limit, true=(_rubbing(name, TRUE_FRICTION), "hertz"))
    return found.but(method=model)


def _rubbing(name, model):
    case = CASES[name]
    few = ("geometry.balls=2", *case.overrides, f"contact.friction={model}")
    return case._replace(overrides=few, count=FEW)


def _friction_command(name, model, setting):
    return command_of(_rubbing(name, model), STEPPER, setting)


def _floors(rows: list[Row]) -> list[str]:
    """The errors that stay at tight tolerances."""
    parts = []
    for law in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == law and row.setting <= FINE and row.status == DONE]
        if mine:
            worst = max(mine, key=lambda row: row.error)
            parts.append(f"{law} {worst.error:.1g} ({worst.problem})")
    return [f"What each errs by when the tolerance is {FINE:g} or tighter, at worst: {', '.join(parts)}."]


CONTEST = Contest(
    judge=judge,
    title="Elastic laws inside the run of a 6203",
    error="greatest error of load or friction, against exact Hertz",
    cost="CPU s a simulated s",
    wanted=1e-2,
    problems=PROBLEMS,
    entries=lambda name: ((law, tolerance) for law in LAWS for tolerance in TOLERANCES),
    command=_command,
    more=_floors,
    own=(TRUE_LAW,),
)
FRICTION = Contest(
    judge=judge_friction,
    title="Friction models inside the run of a 6203",
    error="greatest error of load or friction, against spot_fine",
    cost="CPU s a simulated s",
    wanted=1e-2,
    problems={name: PROBLEMS[name] for name in ("settled", "thrust")},
    entries=lambda name: ((model, tolerance) for model in FRICTIONS for tolerance in TOLERANCES[1:5]),
    command=_friction_command,
    more=_floors,
    own=(TRUE_FRICTION,),
)
CONTESTS = {"bearing_laws": CONTEST, "bearing_friction": FRICTION}
