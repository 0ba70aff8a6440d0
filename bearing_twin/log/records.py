"""What the metadata records of a log say, as data: anybody may have written them."""

import math
from collections.abc import Mapping

from bearing_twin.contact.laws import LAWS
from bearing_twin.parameters import echo
from bearing_twin.report import DIGITS, Choice, parsed_json
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import Scene


def count_in(text: str | None) -> int | None:
    """A count that a log says of itself; None where it says none, or nonsense."""
    return int(text) if text and text.isdecimal() and len(text) <= DIGITS else None


def report_in(record: Mapping[str, str]) -> dict | None:
    """What a run said of itself in RUN_RECORD; None where it said nothing, or nonsense."""
    try:
        found = parsed_json(record["report"])
    except (KeyError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def choice_in(record: Mapping[str, str]) -> Choice:
    """The model named in a log's metadata; empty texts where there is none."""
    named = (record.get("law", ""), record.get("stepper", ""), math.nan, record.get("reason", ""))
    try:
        warnings = tuple(map(str, parsed_json(record.get("warnings", "[]"))))
        predicted = parsed_json(record.get("predicted", "null"))
        setting, friction = float(record.get("setting", "nan")), record.get("friction", "")
        return Choice(*named, warnings, setting, predicted and dict(predicted), friction=friction)
    except (ValueError, TypeError):
        return Choice(*named, ())


def known_choice(choice: Choice, scene: Scene | None) -> Choice:
    """The model a log names; where it names no law there is, that which its scene gets now, with a warning."""
    if scene is None or choice.law in LAWS:
        return choice
    now = choose(scene)
    if choice.law == now.law:  # of a kind that has laws of its own
        return choice
    named = f"names the law {echo(choice.law)}, which there is not" if choice.law else "does not name its law"
    doubt = f"the log {named}: it is judged by {now.law}, which its scene gets now"
    return now._replace(stepper=choice.stepper or now.stepper, warnings=(*choice.warnings, doubt))
