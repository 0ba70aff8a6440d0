"""How a stretch of an integration ended, and what it cost: one table, so that a number means the same in every kind.

OK: all of it is done; NOT_FINITE: a state is not a number any more; TOO_DEEP: bodies have run through each other;
STALLED: an iteration or the step control makes no progress; FULL: the arrays handed over are full; SEPARATED: the
bodies have come apart; TIME_UP: the time asked for is over and they have not; STOPPED: somebody wanted it to stop;
UNTRACKED: the opposing points found are no contact of two bodies.
"""

OK, NOT_FINITE, TOO_DEEP, STALLED, FULL, SEPARATED, TIME_UP, STOPPED, UNTRACKED = range(9)

WORDS = {NOT_FINITE: "not finite", TOO_DEEP: "too deep", STALLED: "stalled", UNTRACKED: "untracked"}
NO_END = "no end"
"""The reason that an `IntegrationError` gives for such an end, and for a contact that does not end."""

STEPS, REJECTIONS, EVALUATIONS, JACOBIANS = range(4)
"""What a stretch cost: steps made, steps made again, right-hand sides, linearisations."""
