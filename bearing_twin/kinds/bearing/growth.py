"""Whether errors of balls that a companion follows grow by themselves, so that a motion cannot be known beyond."""

from bearing_twin.kinds.bearing.windows import PLACE
from bearing_twin.kinds.doubt import CHAOTIC, horizon

FLOOR = 1e-9  # of friction: rounding, as approaches are small differences of positions
MOST = 32  # balls with their begin whose first error is kept


class Growth:
    """Takes rows of WINDOW; those of one ball with one begin are of a companion that went on beside the run."""

    def __init__(self, tolerance: float):
        self.tolerance = tolerance
        self.first: dict[tuple[int, float], tuple[float, float]] = {}  # error at first, and kept until [s]
        self.grown, self.kept = 0.0, 0.0

    def add(self, row, greatest: float) -> None:
        """Takes a row in; `greatest` load [N] so far."""
        off = max(float(row[PLACE["load"]]) / (greatest or 1.0), float(row[PLACE["friction"]]), FLOOR)
        key = int(row[PLACE["ball"]]), float(row[PLACE["begin"]])
        first, kept = self.first.pop(key, (off, key[1]))
        if off <= self.tolerance:
            kept = float(row[0])
        elif off > CHAOTIC * first and (not self.grown or kept < self.kept):
            self.grown, self.kept = off / first, kept
        self.first[key] = first, kept
        if len(self.first) > MOST:
            del self.first[next(iter(self.first))]

    @property
    def notes(self) -> dict[str, str]:
        """The note on the horizon, if there is one."""
        return {"horizon": horizon(self.grown, "a companion began to follow a ball", self.kept)} if self.grown else {}
