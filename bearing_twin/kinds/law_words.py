"""What the choice of an elastic law says, alike in every kind whose curvatures change."""

from bearing_twin.contact.laws import LAWS

HERTZ_FOLLOWS = "hertz, because its rational form is exact to 1e-10 and the cheapest law that follows the curvatures"


def drift(law: str) -> list[str]:
    """A warning of a law that carries a state whose errors add up, or none; names that are no law's have none."""
    state = LAWS[law].state if law in LAWS else None
    if state is None or state.projects:
        return []
    return [f"nothing pulls the errors of {law} back; contact.normal: hertz_differential does"]
