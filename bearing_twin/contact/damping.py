"""The viscous part of the normal load."""

from bearing_twin.compiled import inlined


@inlined
def damped_load(elastic, approach_rate, damping):
    """Normal load [N] with the viscous term d(h) dh/dt, d(h) = damping * elastic load (Hunt and Crossley 1975).

    `damping` [s/m]; the term vanishes with the approach, as paper 1, section 5 asks. The load never pulls: when
    the bodies part faster than 1/damping it is zero and the elastic energy left is lost.
    """
    return elastic * max(1.0 + damping * approach_rate, 0.0)
