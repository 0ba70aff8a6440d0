"""The greatest errors in rows of WINDOW, and how far what nobody looked at may exceed them."""

import numpy as np

from bearing_twin.kinds.bearing.companion.windows import ALL, BESIDE, PLACE, WINDOW, place_of

NOTICED = 1.01  # times what was greatest before: rows that show more are kept, so that memory stays small
# Times what windows show, where contacts come and go, each time anew: few of these times are looked at. Its study is
# `python bench/missed.py`.
MISSED = 1.5
OF_INSTANTS = {"load", "friction", "torque", "contact_angle", "orbit_speed", "roll_rate", "ring_displacement"}
OF_INSTANTS |= {"ring_force"}  # errors whose worst instant may lie outside all windows; others are of whole windows
ALONE, TOGETHER, GROWN, TOLD = range(4)  # of single balls, of all, of what bumps were seen to grow, of no window
KINDS = {ALL: TOGETHER, BESIDE: GROWN}  # other balls with numbers are alone, what has none is told


class Worst:
    """Takes rows of WINDOW and tells the greatest error by what was looked at."""

    def __init__(self) -> None:
        self.windows = 0
        self.most = np.zeros((TOLD + 1, len(WINDOW.columns)))
        self.rows = {name: np.zeros(len(WINDOW.columns)) for name in ("load", "friction", "steps")}  # the worst of each
        self._least = self.most.copy()  # of those noticed
        self._noticed: list[tuple[int, np.ndarray]] = []

    def add(self, row: np.ndarray) -> None:
        """Takes a row in."""
        ball = row[PLACE["ball"]]
        kind = KINDS.get(int(ball), ALONE if ball > ALL else TOLD)
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

    def seen(self, name: str, inherited: float, eventful: bool) -> float:
        """The greatest error in a quantity; `inherited` times what windows of all balls show, more if `eventful`."""
        alone, together, grown, told = self.most[:, PLACE[name]].tolist()
        missed = MISSED if eventful and name in OF_INSTANTS else 1.0
        return max(missed * alone, max(missed, inherited) * together, grown, told)
