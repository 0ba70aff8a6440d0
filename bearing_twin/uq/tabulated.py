"""Quantiles from a table, for samplers that take a million of a distribution that looks for each by iteration.

Between nodes even in t = log(u/(1 - u)) stands a cubic with the slopes of the distribution. What is tabulated is the
logarithm of a positive value, or log(s/(1 - s)) of the share s between two bounds: both are nearly straight far out.
The table knows its greatest error, halfway between nodes; where it would be above MOST, as of distributions that reach
down to what doubles cannot hold, quantiles stay the distribution's own.
"""

import functools
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.interpolate import CubicHermiteSpline
from scipy.special import expit, logit

MOST = 1e-11  # error, of a positive value relative to it, of one between bounds relative to their distance
NODES, FARTHEST = 8192, 38.0  # over |t| <= FARTHEST: as far out as doubles reach
PER_UNIT = (NODES - 1) / (2.0 * FARTHEST)
ITERATED = {"gamma": False, "beta": True}  # distributions without closed quantiles: whether they have two bounds


class Quantiles(NamedTuple):
    """Cubics (4, NODES - 1) of the transformed value, the lower bound, the width between bounds, the greatest error."""

    cubics: np.ndarray
    low: float
    width: float
    bounded: bool
    error: float

    def __call__(self, u):
        """Values (n,) at probabilities u (n,) in (0, 1)."""
        return self.at(logit(u))

    def at(self, t):
        """Values (n,) at log(u/(1 - u))."""
        place = (t + FARTHEST) * PER_UNIT  # even nodes need no search, which takes ten times as long as the rest
        piece = np.clip(place.astype(np.intp), 0, NODES - 2)
        place -= piece
        value, *others = (one.take(piece) for one in self.cubics)
        for one in others:
            value *= place
            value += one
        return self.low + self.width * (expit if self.bounded else np.exp)(value)


def numbers_kept(names) -> int:
    """Numbers held at most while the tables of inputs with distributions of these names are made, one by one."""
    tables = sum(name in ITERATED for name in names)
    return NODES * (6 * tables + 22 * (tables > 0))


def quantiles(name: str, distribution) -> Quantiles | None:
    """The table of a SciPy distribution of that name; None where it has closed quantiles or no table is good enough."""
    if name not in ITERATED:
        return None
    return _made(name, distribution.args, tuple(sorted(distribution.kwds.items())))


@functools.lru_cache(maxsize=4)
def _made(name: str, arguments: tuple, keywords: tuple[tuple[str, float], ...]) -> Quantiles | None:
    """Kept, a quarter of a megabyte each: every value of a sweep and every further study has the same inputs."""
    distribution = getattr(stats, name)(*arguments, **dict(keywords))
    bounded, t = ITERATED[name], np.linspace(-FARTHEST, FARTHEST, 2 * NODES - 1)
    low, high = map(float, distribution.support())
    width = high - low if bounded else 1.0
    with np.errstate(all="ignore"):
        # From the nearer tail, for u has no digits left near 1.
        x = np.where(t < 0.0, distribution.ppf(expit(t)), distribution.isf(expit(-t)))
        share = (x - low) / width
        inner = np.clip(share, 1e-300, np.nextafter(1.0, 0.0) if bounded else np.inf)
        steepness = distribution.pdf(x) * width * inner * (1.0 - inner if bounded else 1.0)
        slopes = np.nan_to_num(expit(t) * expit(-t) / steepness, posinf=0.0)
        values = logit(inner) if bounded else np.log(inner)
        if not np.all(np.isfinite(values)):
            return None
        cubics = CubicHermiteSpline(np.arange(NODES), values[::2], slopes[::2] / PER_UNIT).c
        table = Quantiles(cubics, low, width, bounded, 0.0)
        found = (table.at(t[1::2]) - low) / width
        error = np.max(np.abs(found - share[1::2]) / (1.0 if bounded else share[1::2]))
    return table._replace(error=float(error)) if error <= MOST else None
