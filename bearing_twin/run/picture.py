"""The picture of a run or of a log: the same numbers, the same picture."""

import math
from pathlib import Path

from bearing_twin.base.report import Report
from bearing_twin.base.units import known_digits, readable, two_digits, with_unit
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Facts, Picture
from bearing_twin.pictures.worth import JudgedFigure
from bearing_twin.run.doubt import greatest

MOST = 30  # rows in a picture


def picture_of(stream) -> Picture:
    """An empty picture of a run or a log, by its kind; of a log without a scene, one drawn from its channels."""
    scene, choice = stream.scene, stream.choice
    facts = Facts(scene, choice.law, choice.stepper)
    if scene is None:
        from bearing_twin.pictures.channels import ChannelPicture

        return ChannelPicture(facts)
    return KINDS[scene.kind].picture(facts)


def worth_of(report: Report) -> list[JudgedFigure]:
    """Rows of the errors of a report's figures, for pictures: of figures that are not 0, lists by their greatest.

    Values have their signs; of several the least and the greatest are told, with the greatest of their errors.
    """
    rows = []
    for key, parts in report.errors.get("errors_by_source", {}).items():
        value = report.figures[key]
        size = greatest(value)
        if not 0.0 < size < math.inf:
            continue
        errors = {source: greatest(part) for source, part in parts.items()}
        whole = math.fsum(errors.values())
        words, unit, factor = readable(key, max(size, whole) if math.isfinite(whole) else size)
        several = list(value) if isinstance(value, (list, tuple)) else [value]
        # Once where both ends read the same, as of one value.
        ends = dict.fromkeys(_told(one, factor, whole) for one in (min(several), max(several)))
        text = f"{' to '.join(ends)} ± {two_digits(factor * whole)}{with_unit(unit)}"
        many = f" ({len(several)} values)" if len(several) > 1 else ""
        shares = {source: error / size for source, error in errors.items() if error > 0.0}
        rows.append(JudgedFigure(words + many, text, shares))
    return [row for row in rows if row.parts][:MOST]


def _told(value, factor: float, error: float) -> str:
    """One value in the unit that people read; a count stays whole."""
    return str(value) if isinstance(value, int) else known_digits(factor * value, factor * error)


def plot(stream, path) -> Path:
    """Draws a run (which is then simulated) or a log to a PNG; returns its path. Raises BearingTwinError."""
    picture = picture_of(stream)
    for block in stream.blocks():
        picture.add(block)
    return picture.write(path)
