"""What a study may ask of a kind of scene: the rows of the kinds' own tables, by name, and their errors."""

from collections.abc import Iterator, Mapping
from typing import Any

from bearing_twin.errors import StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Quantity
from bearing_twin.parameters import echo, unknown


def quantities_of(kind: str) -> dict[str, Quantity]:
    """Every quantity of a kind of scene."""
    return KINDS[kind].quantities_of()


def quantity_of(kind: str, name) -> Quantity:
    """The row of a quantity; raises StudyError with the nearest legal name."""
    known = quantities_of(kind)
    if name not in known:
        raise StudyError(f"{echo(name)} is no quantity of a scene of kind {kind}; {unknown(name, known)}")
    return known[name]


def has_closed_form(kind: str, parameters, names, histories=(), varied=()) -> bool:
    """Whether closed forms give all these quantities and histories of a scene, the `varied` keys being uncertain."""
    form, known = KINDS[kind].closed_form(), quantities_of(kind)
    return (
        form is not None
        and form.describes(parameters)
        and not set(form.without) & set(varied)
        and all(known[name].closed for name in names)
        and all(channel in form.histories for channel in histories)
    )


def errors_of(quantity: Quantity, figures: Mapping[str, Any], by_source: Mapping[str, Mapping]) -> dict[str, float]:
    """Errors of a quantity by source, from those of the figures it is read off; empty where none of them has any.

    `by_source` maps figures to {source: error}. Of each source all figures are moved by their errors, away from zero
    and towards it: the greater change counts.
    """
    read = _Read(figures)
    value = quantity.figure(read)
    found: dict[str, float] = {}
    for source in dict.fromkeys(one for key in read.keys_read for one in by_source.get(key, ())):
        ends = (
            quantity.figure({key: _moved(one, by_source.get(key, {}).get(source), way) for key, one in figures.items()})
            for way in (1.0, -1.0)
        )
        found[source] = max(abs(end - value) for end in ends)
    return found


class _Read(Mapping):
    """Figures that remember which of them were asked for."""

    def __init__(self, figures: Mapping[str, Any]):
        self._figures, self.keys_read = figures, {}

    def __getitem__(self, key):
        self.keys_read[key] = None
        return self._figures[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)


def _moved(value, error, way: float):
    """A figure, or a list of numbers, moved by its error: away from zero for a positive way."""
    if error is None or value is None:
        return value
    if isinstance(value, (list, tuple)):
        errors = error if isinstance(error, (list, tuple)) else [error] * len(value)
        return [_moved(one, off, way) for one, off in zip(value, errors, strict=True)]
    return value + (way if value >= 0.0 else -way) * error
