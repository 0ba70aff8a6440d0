"""What a study may ask of a kind of scene: the rows of the kinds' own tables, by name."""

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
