"""Names of what a ball's axis of spin is taken to do in equilibrium, for scenes, which are read without a compiler."""

from bearing_twin.contact.names import AUTO

SHARED, OUTER, SETTLED = "shared", "outer", "settled"
CONTROL_WORDS = AUTO, SHARED, OUTER, SETTLED
"""Words of `model.control`."""
