"""What a newcomer takes against the product: SciPy with its defaults, a fixed step of 0.1 ms, explicit Euler.

The equations are the product's, the right-hand side is compiled: what differs is the method and its setting. Seconds
are CPU seconds per simulated second.
"""

from bearing_twin.charts.bearing_cells import NAIVE, Case, bearing_row, command_of
from bearing_twin.charts.contest_picture import Contest
from bearing_twin.charts.table import DONE, Row

CASES = {
    "settled": Case("bearing_6203", (), 1e-3, 10),
    "sliding": Case("bearing_6203", ("initial.motion=rest", "drive.offset=[0.0,-1e-6,5e-6]"), 5e-5, 20),
    "lift-off": Case("bearing_6203_loose", (), 1e-3, 10),
}
COARSE = 1e-4  # s, the step that is often tried first
LADDERS = {
    "rodas4": (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6),
    "rk4": (COARSE, 1e-5, 1e-6, 3e-7),
    "explicit Euler": (COARSE, 1e-5, 1e-6, 1e-7, 1e-8),
    "solve_ivp RK45": (1e-3, 1e-6, 1e-9),  # the first is SciPy's default
    "solve_ivp LSODA": (1e-3, 1e-6, 1e-9),
}
DEFAULTS = {"rodas4": 1e-3, "rk4": COARSE, **{name: 1e-3 if "solve" in name else COARSE for name in NAIVE}}
"""What is taken without a thought: the product's default, SciPy's, a step of 0.1 ms."""


def judge(name: str, method: str, setting: float, limit: float) -> Row:
    """One run."""
    return bearing_row(Row(name, method, setting, command=_command(name, method, setting)), CASES[name], limit)


def _command(name, method, setting):
    return "" if method in NAIVE else command_of(CASES[name], method, setting)


def _defaults(rows: list[Row]) -> list[str]:
    """What each method gives as it is first tried."""
    sentences = []
    for method, setting in DEFAULTS.items():
        mine = [row for row in rows if row.method == method and row.setting == setting]
        words = (f"{row.problem} {row.error:.1g}" if row.status == DONE else f"{row.problem} none" for row in mine)
        sentences.append(f"{method} as first tried, at {setting:g}: error {', '.join(words)}.")
    return sentences


CONTEST = Contest(
    judge=judge,
    title="What a newcomer takes, against the product's rodas4",
    error="greatest error of load or friction",
    cost="CPU s a simulated s",
    wanted=1e-3,
    problems={name: name for name in CASES},
    entries=lambda name: ((method, setting) for method, ladder in LADDERS.items() for setting in ladder),
    command=_command,
    more=_defaults,
    own=("rodas4",),
)
CONTESTS = {"newcomers": CONTEST}
