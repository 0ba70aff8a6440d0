"""The viscous part of the normal load."""

from bearing_twin.compiled import inlined


@inlined
def damped_load(elastic, stiffness, approach_rate, damping, relaxation_time):
    """Normal load [N] with the viscous term d(h) dh/dt, d(h) = damping * load + relaxation_time * stiffness.

    `elastic` [N] and `stiffness` = d(load)/dh [N/m] belong to one approach h. The first part is Hunt and Crossley's
    (1975), `damping` [s/m]; the second is a viscoelastic half-space's (Brilliantov et al. 1996), `relaxation_time` [s]:
    the damping proportional to stiffness that Kraemer (1993) gives for rolling bearings. Both vanish with the
    approach, as h^1.5 and h^0.5 (paper 1, section 5). The load never pulls: where the viscous part would, it is zero
    and the elastic energy left is lost.
    """
    return max(elastic + (damping * elastic + relaxation_time * stiffness) * approach_rate, 0.0)
