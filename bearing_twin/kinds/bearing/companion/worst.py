"""The greatest errors in rows of WINDOW, and how far what nobody looked at may exceed them."""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.windows import ALL, APART, BESIDE, BETWEEN, PLACE, WINDOW, place_of

NOTICED = 1.01  # times what was greatest before: rows that show more are kept, so that memory stays small
# Times what windows show, where contacts come and go, each time anew: few of these times are looked at. Its study is
# `python bench/missed.py`.
MISSED = 1.5
# Times what is told the true error may be, in 95 of 100 runs: by windows of single balls and of all where contacts come
# and go, and by all that is told where each bears load throughout. Its study is the same.
SPREAD_ALONE, SPREAD_TOGETHER, SPREAD_CALM = 2.4, 1.9, 1.25
OF_INSTANTS = {"load", "friction", "torque", "contact_angle", "orbit_speed", "roll_rate", "ring_displacement"}
OF_INSTANTS |= {"ring_force"}  # errors whose worst instant may lie outside all windows; others are of whole windows
# Of single balls, of all, of what bumps were seen to grow, of no window, and of none but known exactly.
ALONE, TOGETHER, GROWN, TOLD, SURE = range(5)
# Goes on since earlier than any window: what balls are off their way round is in its loads, and is not added to them.
FROM_START = (APART, BESIDE)
KINDS = {ALL: TOGETHER, BESIDE: GROWN, BETWEEN: SURE}  # other balls with numbers are alone, what has none is told


class Worst:
    """Takes rows of WINDOW and tells the greatest error by what was looked at."""

    def __init__(self) -> None:
        self.windows = 0
        self.most = np.zeros((SURE + 1, len(WINDOW.columns)))
        self.rows = {name: np.zeros(len(WINDOW.columns)) for name in ("load", "friction", "steps")}  # the worst of each
        self._least = self.most.copy()  # of those noticed
        self._noticed: list[tuple[int, np.ndarray]] = []

    def add(self, row: np.ndarray) -> None:
        """Takes a row in."""
        ball = row[PLACE["ball"]]
        kind = KINDS.get(int(ball), ALONE if ball > ALL else TOLD)
        if ball in FROM_START:
            row = row.copy()
            row[PLACE["orbit_angle"]] = 0.0
        if (row > NOTICED * self._least[kind])[PLACE["load"] :].any():
            self._noticed.append((kind, row.copy()))
            self._least[kind] = np.maximum(self._least[kind], row)
        self.most[kind] = np.maximum(self.most[kind], row)
        self.windows += 1
        for name, kept in self.rows.items():
            if row[PLACE[name]] > kept[PLACE[name]]:
                self.rows[name] = row.copy()

    def where(self, name: str) -> str:
        """Where the greatest error in load or friction was; empty where there is none."""
        row = self.rows[name]
        return place_of(row) if row[PLACE[name]] != 0.0 else ""

    def until(self, time: float) -> "Worst":
        """What rows that end by then [s] told."""
        earlier = Worst()
        for kind, row in self._noticed:
            if row[0] <= time:
                earlier.most[kind] = np.maximum(earlier.most[kind], row)
        return earlier

    def seen(self, name: str, inherited: float, eventful: bool, spread: "Spread | None" = None) -> float:
        """The greatest error in a quantity; `inherited` times what windows of all balls show, more if `eventful`.

        With the `spread` of such estimates: what it may be. What is known exactly has none.
        """
        alone, together, grown, told, sure = self.most[:, PLACE[name]].tolist()
        missed, wide = MISSED if eventful and name in OF_INSTANTS else 1.0, spread or Spread(1.0, 1.0, 1.0)
        whole = wide.together * max(missed, inherited) * together
        return max(wide.alone * missed * alone, whole, grown, wide.told * told, sure)


class Spread(NamedTuple):
    """How many times what is told the true error may be: of windows of single balls and of all, of what is told."""

    alone: float
    together: float
    told: float


def spread_of(eventful: bool, carries: bool) -> Spread:
    """The spread of estimates where contacts come and go (`eventful`), or each bears load throughout.

    Of what a ring `carries` on 84 of 100 are within it: a wider one would make runs doubtful that keep their tolerance.
    """
    if not eventful:
        return Spread(SPREAD_CALM, SPREAD_CALM, SPREAD_CALM)
    return Spread(SPREAD_ALONE, SPREAD_TOGETHER, SPREAD_CALM if carries else SPREAD_ALONE)
