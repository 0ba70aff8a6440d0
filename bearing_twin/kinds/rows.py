"""The parts of a kind that its folder has under the usual names."""

from collections.abc import Callable

from bearing_twin.kinds.contract import late

USUAL = {
    "check": "derived:check",
    "resolve": "derived:resolve",
    "choose": "models:choose",
    "motion": "motion:motion",
    "channels": "outputs:channels",
    "records": "figures:tables",
    "meanings": "figures:MEANINGS",
    "quantities": "quantities:quantities",
    "topics": "topics:topics",
    "view": "view:view",
}


def parts_in(home: str, **others: str) -> dict[str, Callable]:
    """The parts of a `Kind` in the package `home`, imported at their first call: USUAL and `others`, "module:name".

    A part whose place is "" the kind does without.
    """
    return {part: late(f"{home}.{place}") for part, place in (USUAL | others).items() if place}
