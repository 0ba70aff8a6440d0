"""How far a mean over outputs is off: by the windows of a run, whose errors are partly alike and partly not."""

import math

from bearing_twin.kinds.bearing.companion.windows import ALL, BESIDE, PLACE


class MeanError:
    """Takes rows of WINDOW, and tells the error of the mean torque on a ball.

    A window's mean error has a part that all windows share and one that is as often one way as the other. What is
    shared is their mean over the time of all, signs counted. The rest falls with the root of the windows that it holds;
    no window is taken to be quieter than the worst. What a copy of the run or an inherited error says counts in full.
    """

    def __init__(self) -> None:
        # Of single balls, of all together, of these with what bumps carry on: time of windows, the sum of errors times
        # it, the most of one times its root.
        self.seen = [[0.0, 0.0, 0.0] for _ in range(3)]
        self.whole = 0.0

    def add(self, row) -> None:
        """Takes a row in."""
        error, ball = float(row[PLACE["mean_torque"]]), row[PLACE["ball"]]
        if ball < ALL and ball != BESIDE:
            self.whole = max(self.whole, abs(error))
            return
        kept, length = self.seen[{ALL: 1, BESIDE: 2}.get(int(ball), 0)], max(float(row[0] - row[PLACE["begin"]]), 0.0)
        kept[:] = kept[0] + length, kept[1] + error * length, max(kept[2], abs(error) * math.sqrt(length))

    def over(self, seconds: float, times: float, most: float) -> float:
        """The error [N m] of a mean over so long, where balls together err so many `times` what their windows show.

        No more than the `most` that an instant is off.
        """
        found = [
            scale * (abs(total) / looked_at + rest / math.sqrt(seconds))
            for scale, (looked_at, total, rest) in zip((1.0, times, 1.0), self.seen, strict=True)
            if looked_at and seconds > 0.0
        ]
        known = found and all(map(math.isfinite, found))
        return max(min(max(found), most), self.whole) if known else most
