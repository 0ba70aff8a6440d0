"""Which contacts carry a ball's gyroscopic moment in equilibrium, `model.control`."""

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import AUTO, POINT
from bearing_twin.kinds.bearing.controls import OUTER, SETTLED, SHARED
from bearing_twin.kinds.bearing.parameters import rubbing_by
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, dimension_of

CONTROLS = {SHARED: (1.0, 1.0), OUTER: (0.0, 2.0), SETTLED: (1.0, 1.0), AUTO: (1.0, 1.0)}
"""Shares that friction carries on the inner and on the outer raceway, the axis of spin as in rolling."""


def control_of(parameters) -> str:
    """As the scene says; left to itself `outer` with friction over spots, which resist drilling, else `auto`.

    That is `settled` in equilibria where it matters (`axes.settling_matters`), else `shared`.
    """
    control = parameters.model.control
    if control != AUTO:
        return control
    friction = rubbing_by(parameters, POINT).contact.friction
    return OUTER if FRICTIONS[friction].over_spot else AUTO


def begins_settled(parameters) -> bool:
    """Whether axes of spin may have settled where the scene's run begins: balls that move start in rolling.

    Unless `model.control` asks for settled ones.
    """
    control = control_of(parameters)
    return control == SETTLED or (control == AUTO and dimension_of(parameters) == QUASI_STATIC)
