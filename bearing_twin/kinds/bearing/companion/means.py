"""How far a mean over outputs is off: by the windows of a run, whose errors are partly alike and partly not."""

import math

from bearing_twin.kinds.bearing.companion.windows import ALL, PLACE


class MeanError:
    """Takes rows of WINDOW, and tells the error of the mean torque on a ball.

    A window's mean error has a part that all windows share and one that is as often one way as the other. What is
    shared is the mean of the windows, signs counted. The rest falls with the root of the windows that the time holds;
    no window is taken to be quieter than the worst. What a copy of the run or an inherited error says counts in full.
    """

    def __init__(self) -> None:
        # Of single balls and of all together: windows, the sum of their errors, the most of error times root of time.
        self.seen = [[0, 0.0, 0.0], [0, 0.0, 0.0]]
        self.whole = 0.0

    def add(self, row) -> None:
        """Takes a row in."""
        error, ball = float(row[PLACE["mean_torque"]]), row[PLACE["ball"]]
        if ball < ALL:
            self.whole = max(self.whole, abs(error))
            return
        kept = self.seen[int(ball == ALL)]
        rest = abs(error) * math.sqrt(max(row[0] - row[PLACE["begin"]], 0.0))
        kept[:] = kept[0] + 1, kept[1] + error, max(kept[2], rest)

    def over(self, seconds: float, times: float, most: float) -> float:
        """The error [N m] of a mean over so long, where balls together err so many `times` what their windows show.

        No more than the `most` that an instant is off.
        """
        found = [
            scale * (abs(total) / windows + rest / math.sqrt(seconds))
            for scale, (windows, total, rest) in zip((1.0, times), self.seen, strict=True)
            if windows and seconds > 0.0
        ]
        known = found and all(map(math.isfinite, found))
        return max(min(max(found), most), self.whole) if known else most
