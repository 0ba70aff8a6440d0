"""What runs are worth that nobody tuned anything to: bearing scenes drawn by chance, each at a tolerance drawn with it.

Each is run as `simulate` runs it, and compared with the truth as in the chart of tolerances.
"""

from collections.abc import Iterator
from functools import partial

from bearing_twin.charts.chart import Chart
from bearing_twin.charts.companion_cost import much, taken
from bearing_twin.charts.draws import draw_of
from bearing_twin.charts.scene_rows import command_of
from bearing_twin.charts.table import DONE
from bearing_twin.charts.tolerance import KNOWABLE, METHOD, ToleranceRow, beside_truth, nearness, said, unknown, unsaid
from bearing_twin.charts.tolerance_picture import draw_all

DRAWS = 400
FIRST = 20261126  # the number of the first draw
NAMES = tuple(f"draw {number}" for number in range(1, DRAWS + 1))


def _numbered(name: str) -> tuple[str, tuple[str, ...], tuple[str, ...], float]:
    return draw_of(FIRST + NAMES.index(name))


def judge(name: str, method: str, tolerance: float, limit: float) -> ToleranceRow:
    """A draw beside the truth."""
    scene, differs, wanted, _ = _numbered(name)
    row = ToleranceRow(name, method, tolerance, command=_command(name, method, tolerance))
    return beside_truth(row, (scene, *differs), wanted, limit)


def _command(name: str, _method: str, tolerance: float) -> str:
    scene, differs, wanted, _ = _numbered(name)
    return command_of(scene, (*differs, *wanted, f"wanted.tolerance={tolerance:g}"))


def reading(points: list[ToleranceRow]) -> Iterator[str]:
    """What the chart says."""
    good = [p for p in points if p.status == DONE]
    if lost := [p for p in points if p.status != DONE]:
        yield f"Of {len(points)} draws {len(lost)} did not run: {'; '.join(p.reason for p in lost)}."
    if not good:
        return
    kept = sum(p.kept for p in good)
    yield f"The error is within the tolerance in {kept} of {len(good)} draws; {said(good)}"
    yield from unsaid(good)
    yield from unknown(good)
    yield f"Above {KNOWABLE:g} {nearness(good)}"
    yield f"The companion takes {taken(good)}; {much(good)}."


CONTESTS = {
    "drawn": Chart(
        judge=judge,
        problems={name: name for name in NAMES},
        entries=lambda name: [(METHOD, _numbered(name)[-1])],
        kind=ToleranceRow,
        command=_command,
        drawn=partial(draw_all, title="Scenes drawn by chance, and what their runs say of themselves"),
        told=reading,
    )
}
