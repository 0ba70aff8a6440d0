"""Names of the raceway control of balls in equilibrium, for scenes, which are read without a compiler."""

from bearing_twin.contact.friction import AUTO

SHARED, OUTER, INNER = "shared", "outer", "inner"
CONTROLS = {AUTO: (1.0, 1.0), SHARED: (1.0, 1.0), OUTER: (0.0, 2.0), INNER: (2.0, 0.0)}
"""Words of `model.control`: shares of the gyroscopic moment that friction carries on the inner and outer raceway."""
ALIASES = {"settled": SHARED}
"""Words of earlier versions, and how they are read."""
