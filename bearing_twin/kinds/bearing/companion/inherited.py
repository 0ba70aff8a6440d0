"""What no window of a bearing run sees: what its balls and its ring are off from before, and what that does.

A moving ring carries on what it is off until its contacts have damped it. Errors of steps are as often one way as the
other, so that they add up as a random walk does: with the root of that time over the time of the windows they were seen
in. Windows lie where errors are greatest, so that what all of them show a second is taken, and not what the worst one
does. What a ring is off, or a ball on its way round, makes loads err; where a contact bears little, that is much of its
load, and as much of its friction. A ring that rings makes balls slip as well, which windows show. A ball that a ring
has just set free bears next to nothing on one raceway, and rings there by what steps err by. Windows are short and lie
elsewhere: all this is therefore found from what all outputs say of friction and load, and recorded as a row of WINDOW
of its own.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.deviations import LEAST_LOAD, Part
from bearing_twin.kinds.bearing.companion.earlier import stiffest
from bearing_twin.kinds.bearing.companion.throws import Throw, thrown
from bearing_twin.kinds.bearing.companion.windows import ALL, BUMPING, INHERITED, PLACE, UNKNOWN, WINDOW
from bearing_twin.kinds.bearing.forces.layout import RADIAL_VELOCITY
from bearing_twin.kinds.bearing.stepping.pointing import OF_FORCE

NO_LOAD = 1e-300  # N: next to nothing, so that no quotient is infinite
ERRORS = slice(PLACE["load"], None)  # of a row of WINDOW
SLIP = [PLACE[one] for one in ("friction", "torque", "mean_torque")]  # ... those that follow from how balls slip
MEANS = [PLACE["drive_torque"], PLACE["loss"]]  # ... and means over windows, which are no instants of a ring that rings
# Friction over mu N that a ring which rings makes balls err by, over what it makes loads err by, of the greatest: no
# more than this of what windows show together. Balls err by more where they begin to roll, which no ring carries on.
SLIPPING = 4.0
FADING = 0.5  # of the rate at which a ring rings down: that at which what windows showed counts less


class Inherited(NamedTuple):
    """What is known of a run before a part; see `carried_on`.

    The greatest share of `light_share`; how far loads are off [N], and what the place of the ring was off would make
    them off [N], which both fall as the ring rings down; what was told of friction. Of the windows of all balls: the
    sums of the squares of what loads [N] and friction were off, and of the seconds they took, which all fade.
    """

    light: float = 0.0
    off: float = 0.0
    wide: float = 0.0
    told: float = 0.0
    loads: float = 0.0
    slips: float = 0.0
    seconds: float = 0.0


NOTHING = Inherited()


def remembered(told) -> Inherited:
    """What is known as a snapshot `told`; raises ValueError for what no snapshot tells."""
    known = tuple(map(float, told))
    if len(known) != len(NOTHING) or not all(map(math.isfinite, known)):
        raise ValueError("inherited")
    return Inherited(*known)


def light_share(part: Part, greatest: float) -> float:
    """How much friction errs, over mu N, where approaches are off by what changes the greatest load by its whole.

    The contact that feels it most: its load changes with its stiffness, as N^(1 - 1/p), and its friction with its load.
    """
    coefficient = part.bearing.friction_coefficient
    if coefficient <= 0.0 or greatest <= 0.0:
        return 0.0
    load = part.load
    # Where nothing is borne nothing rubs; a mask would take longer.
    felt = rubbing(part, greatest, ...) * (greatest / np.maximum(load, NO_LOAD)) ** (1.0 / part.bearing.inner.law.power)
    return float(felt.max(initial=0.0))


def rubbing(part: Part, greatest: float, those) -> np.ndarray:
    """Friction over what it could be, mu N, of `those` contacts, a mask (outputs, balls, 2) or all; mu is not 0."""
    limit = part.bearing.friction_coefficient * np.maximum(part.load[those], LEAST_LOAD * greatest)
    return part.friction[those] / limit


def landed(part: Part) -> np.ndarray:
    """Which contacts (outputs, balls, 2) bear load where their ball touched neither raceway at the output before."""
    free, bears = part.in_flight, part.load > 0.0
    bears[0], bears[1:] = False, bears[1:] & (free[:-1] & ~free[1:])[..., None]
    return bears


def hops(part: Part, greatest: float, off: float) -> tuple[float, float]:
    """Errors of load [N], and of friction over mu N, of balls that hop, where contacts may be `off` by a load [N].

    A contact is off by no more than what it bears: at an output after one at which its ball touched neither raceway, or
    at the height of the blow that a ball comes to with its speed, which outputs may miss.
    """
    if not part.flies or off <= 0.0:
        return 0.0, 0.0
    free, load, bears, law = part.in_flight, part.load, landed(part), part.bearing.inner.law
    energy = 0.5 * part.bearing.ball_mass * float(np.square(part.filled[0][..., RADIAL_VELOCITY][free]).max())
    blow = law.given * ((law.power + 1.0) * energy / law.given) ** (law.power / (law.power + 1.0))
    friction = 0.0
    if part.bearing.friction_coefficient > 0.0:
        friction = float((rubbing(part, greatest, bears) * np.minimum(off / load[bears], 1.0)).max(initial=0.0))
    return min(off, max(float(load[bears].max(initial=0.0)), blow)), friction


def unseen_landings(part: Part, rows: np.ndarray, greatest: float, apart: float) -> float:
    """Friction over mu N that single balls may be off by where they land and no companion has gone with them.

    As far off across the raceways, `apart` [m], as the balls that it went with while they hopped.
    """
    if apart <= 0.0 or part.bearing.friction_coefficient <= 0.0:
        return 0.0
    bears = landed(part)
    times = part.elapsed + np.asarray(part.times)
    for row in rows[rows[:, PLACE["begin"]] <= part.elapsed]:
        balls = slice(None) if row[PLACE["ball"]] < 0 else int(row[PLACE["ball"]])
        bears[times <= row[0], balls] = False
    law = part.bearing.inner.law
    approach = (part.load[bears] / law.given) ** (1.0 / law.power)
    share = np.minimum((1.0 + apart / approach) ** law.power - 1.0, 1.0)
    return float((rubbing(part, greatest, bears) * share).max(initial=0.0))


def all_of_it(now: float, tolerance: float, since: float, greatest: float, adrift: bool) -> np.ndarray:
    """A row of WINDOW of the rest of a part in which balls met where nobody looked, `since` when [s].

    Where it is `adrift`, nothing is known of it: loads may be off by the `greatest` [N], friction by twice mu N.
    """
    row = np.zeros((1, len(WINDOW.columns)))
    row[0, : PLACE["torque"]] = now, since, UNKNOWN, 0.0, tolerance, adrift * greatest, adrift * 2.0
    return row


def ringing_alone(part: Part, greatest: float) -> float:
    """Friction over mu N that balls on one raceway alone may be off by, as errors of steps make them ring there.

    Nothing else pushes such a ball, so that the error of the force on it is that of its load. By that share its
    friction errs, and next to no load has the greatest. It rings on: steps before the last output count as well.
    """
    if part.all_bear or not len(part.pointer) or part.bearing.friction_coefficient <= 0.0:
        return 0.0
    load = part.load
    alone = (load > 0.0) & ~part.carried[..., None]
    if not alone.any():
        return 0.0
    force = part.bearing.ball_mass * part.pointer[..., OF_FORCE].T
    force[1:] = np.maximum(force[1:], force[:-1])
    share = np.minimum(np.broadcast_to(force[..., None], load.shape)[alone] / load[alone], 1.0)
    return float((rubbing(part, greatest, alone) * share).max())


class Carried(NamedTuple):
    """Rows of WINDOW with that of what a part inherits, if it is more than was told before; what is then known.

    `added` are the rows with what the part itself adds, which alone another go at it betters; `before` is the row of
    what it has from before, and below it the same were there nothing that it cannot exceed: by that a tighter setting
    is chosen.
    """

    rows: np.ndarray
    added: np.ndarray
    before: np.ndarray
    known: Inherited


class Walk(NamedTuple):
    """What steps make a ring err by that carries it on, as rows of WINDOW: by what windows show together, and at worst.

    At worst is what the worst of them alone would make it. `known` has these windows.
    """

    row: np.ndarray
    worst: np.ndarray
    known: Inherited


def walked(known: Inherited, row: np.ndarray, whole: np.ndarray, seconds: float, greatest: float, fades: float) -> Walk:
    """The `row` [WINDOW] with what windows of all balls show (`whole`), at its end.

    What was known before `fades` to this share. `seconds` a ring goes on with what it is off; `greatest` load [N].
    """
    shown, alone = row.copy(), row.copy()
    for one in whole:
        until = np.full(len(row), min(row[0], seconds))  # it rings on to the end of the part
        until[MEANS] = min(one[0], seconds)
        until[PLACE["orbit_angle"]] = one[0]  # how far balls are off their way round nothing damps
        longer = np.sqrt(np.maximum(until / (one[0] - one[PLACE["begin"]]), 1.0))
        longer[SLIP] = 1.0  # balls forget their slip within a window, but what a ring that rings makes of it
        shown[ERRORS] = np.maximum(shown, np.abs(one))[ERRORS]
        alone[ERRORS] = np.maximum(alone, longer * np.abs(one))[ERRORS]
    finite = whole[np.isfinite(whole).all(axis=1)]  # what breaks off has no error that adds up
    loads = fades * known.loads + float(np.square(finite[:, PLACE["load"]]).sum())
    slips = fades * known.slips + float(np.square(finite[:, PLACE["friction"]]).sum())
    taken = fades * known.seconds + float((finite[:, 0] - finite[:, PLACE["begin"]]).sum())
    known, worst = known._replace(loads=loads, slips=slips, seconds=taken), float(alone[PLACE["load"]])
    row = alone.copy()
    if 0.0 < worst < math.inf:
        together = math.sqrt(loads / taken * min(row[0], seconds))
        row[ERRORS] = np.maximum(shown, min(together / worst, 1.0) * alone)[ERRORS]
        rung = min(math.sqrt(slips / loads), SLIPPING / greatest) * row[PLACE["load"]]
        row[PLACE["friction"]] = max(float(row[PLACE["friction"]]), rung)
    return Walk(row, np.maximum(row, alone), known)


def grown(part: Part, greatest: float, off: float, throw: Throw | None) -> tuple[float, float, float]:
    """What loads [N] that a ring makes `off` by become off in a part, and friction over mu N.

    First what loads would be off if nothing bounded it. What a ring that is thrown against its balls is off grows with
    each blow: to what a motion from before it showed (`throw`), of which nobody knows whether steps of the part made
    it, or without one as where balls bump into a cage. So does what a ball is off that hops while the ring lies still
    (`hops`).
    """
    if not part.flies:
        return off, off, 0.0
    if throw is not None:
        return throw.load, min(throw.load, greatest), throw.friction
    hopping, slips = hops(part, greatest, BUMPING * off)
    if thrown(part):
        return BUMPING * off, min(BUMPING * off, greatest), slips
    return (BUMPING * off, hopping, slips) if hopping > off else (off, off, slips)


def carried_on(
    known: Inherited,
    part: Part,
    rows: np.ndarray,
    tolerance: float,
    seconds: float,
    around: float,
    greatest: float,
    apart: float = 0.0,
    throw: Throw | None = None,
) -> Carried:
    """What a part that began with what is `known` inherits, beside these rows of WINDOW.

    `seconds` a ring goes on with what it is off; `around` [rad] balls may be off their way round.
    """
    light, off, wide, told = known[:4]
    row = np.zeros(len(WINDOW.columns))
    row[: PLACE["load"]] = part.elapsed + part.duration, part.elapsed, INHERITED, 0.0, tolerance
    before, whole = row.copy(), rows[rows[:, PLACE["ball"]] == ALL] if seconds else rows[:0]
    fades = 10.0 ** (-FADING * part.duration / seconds) if seconds else 1.0
    walk = walked(known, row, whole, seconds, greatest, fades)
    row = walk.row
    told_of = bool(seconds) and (len(rows) > 0 or throw is not None)
    if throw is not None:
        row[PLACE["steps"]] = throw.found.steps / part.load.shape[1]
        row[ERRORS] = np.maximum(row[ERRORS], throw.errors)
    lies = around * float(part.load.max() - part.load.min())
    now, worst = float(row[PLACE["load"]]) + lies, float(walk.worst[PLACE["load"]]) + lies
    place = max(float(row[PLACE["ring_displacement"]]), float(walk.worst[PLACE["ring_displacement"]]))
    across = stiffest(part.bearing.inner.law, greatest) * place
    # In a throw the motion beside it shows that; contacts that bear little only then say nothing of later ones.
    light, free, loads = light if throw else max(light, light_share(part, greatest)), [now, off], [now, off]
    if part.flies and throw is None:  # what balls hop by follows from the worst that may be
        free[0] = loads[0] = worst
    for place, one in enumerate((row, before) if told_of else ()):
        free[place], most, slips = grown(part, greatest, loads[place], throw)
        if most != loads[place]:
            one[PLACE["load"]] = loads[place] = most
        one[PLACE["friction"]] = max(float(one[PLACE["friction"]]), slips)
    unbounded = before.copy()
    unbounded[PLACE["load"]] *= free[1] / loads[1] if loads[1] else 1.0
    # Friction feels the worst: each window by itself, as contacts that bear little come and go.
    rest = ((row, max(loads[0], worst), across), (before, loads[1], wide), (unbounded, free[1], wide))
    for one, *those in rest if throw is None else ():  # which shows what friction is off as well
        one[PLACE["friction"]] = max(float(one[PLACE["friction"]]), light * max(those) / greatest if greatest else 0.0)
    falls = 10.0 ** (-part.duration / seconds) if told_of else 1.0
    later, wide = max(loads[0], loads[1] * falls), max(across, wide * falls)
    slips = ringing_alone(part, greatest) if seconds else unseen_landings(part, rows, greatest, apart)
    row[PLACE["friction"]] = max(float(row[PLACE["friction"]]), slips)
    both = np.maximum(row, before)
    friction = float(both[PLACE["friction"]])
    known = walk.known._replace(light=light, off=later, wide=wide)
    if friction <= max(told, float(rows[:, PLACE["friction"]].max(initial=0.0))) and not len(whole) and throw is None:
        return Carried(rows, rows, np.array([before, unbounded]), known)
    known = known._replace(told=max(told, friction))
    if throw is None:  # the worst has a part done again, which costs less than what would be missed
        row[ERRORS] = np.maximum(row, walk.worst)[ERRORS]
    return Carried(*(np.concatenate([rows, one[None]]) for one in (both, row)), np.array([before, unbounded]), known)
