"""When an ensemble is large enough: the 95 % interval of a named statistic, looked at in batches, twice in a row.

Looking often and stopping at the first narrow interval favours lucky looks: the interval at such a moment covers less
than 95 %. Against that (1) there is a least number of samples before the first look, (2) looks are spaced by a batch,
later by a fifth of the samples so far, and (3) the interval must be narrow at two looks in a row. The looks are at
the same numbers of samples whatever the number of workers, and whether a study was continued or not.

A half width tells how far sampling may be off, not whether the model is right.
"""

from collections.abc import Iterator
from typing import NamedTuple

from bearing_twin.uq.sampling import REPLICATES
from bearing_twin.uq.study import Stop

GROWTH = 0.2  # of the samples so far, between later looks
IN_A_ROW = 2


class StopRule(NamedTuple):
    """The greatest half width of a statistic of a quantity: absolute, or relative to the estimate; 0 = no bound."""

    quantity: str
    statistic: str
    probability: float
    tolerance: float
    relative_tolerance: float

    @property
    def bounds(self) -> bool:
        """Whether there is anything to stop for."""
        return self.tolerance > 0.0 or self.relative_tolerance > 0.0

    @property
    def asked(self) -> str | float:
        """The statistic as `statistics.estimate` takes it."""
        return self.probability if self.statistic == "quantile" else self.statistic

    def satisfied(self, estimate: float, half_width: float) -> bool:
        """Whether one look found the interval narrow enough; never for a NaN."""
        return half_width <= max(self.tolerance, self.relative_tolerance * abs(estimate))

    @property
    def watched(self) -> str:
        """The statistic and its quantity in words: `std of contact_duration`."""
        what = f"{self.probability:g} quantile" if self.statistic == "quantile" else self.statistic
        return f"{what} of {self.quantity}"

    def text(self) -> str:
        """The rule in words, for reports."""
        bound = f"{self.tolerance:g}" if self.tolerance else f"{100.0 * self.relative_tolerance:g} % of it"
        return f"the half width of the 95 % interval of the {self.watched} is at most {bound}"


def rule_of(stop: Stop, quantity: str) -> StopRule:
    """The rule of a study."""
    return StopRule(quantity, stop.statistic, stop.probability, stop.tolerance, stop.relative_tolerance)


def looks(samples: int, batch: int, minimum: int, sampler: str) -> Iterator[int]:
    """Increasing numbers of samples at which the statistics are looked at; the last is `samples`.

    Interleaved Sobol sequences are balanced only at REPLICATES times a power of two, so they are looked at there.
    """
    if sampler == "sobol":
        size = REPLICATES
        while size < samples:
            if size >= minimum:
                yield size
            size *= 2
    elif sampler == "random":
        size = batch
        while size < samples:
            if size >= minimum:
                yield size
            size += batch * max(1, round(GROWTH * size / batch))
    # a latin hypercube is one sample of its whole size: parts of it are no hypercubes
    yield samples
