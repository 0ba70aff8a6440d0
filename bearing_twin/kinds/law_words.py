"""What the choice of an elastic law or of a method says, and of a mass, alike in several kinds."""

from bearing_twin.contact.laws import LAWS


def drift(law: str) -> list[str]:
    """A warning of a law that carries a state whose errors add up, or none; names that are no law's have none."""
    if law not in LAWS or not LAWS[law].carries or LAWS[law].keeps:
        return []
    return [f"nothing pulls the errors of {law} back; contact.normal: hertz_differential does"]


LEAST_SHARE = 0.25  # tuned: a hollow sphere with a wall of a tenth of its radius has 0.27 of the solid one's mass
MOST_SHARE = 4.0  # tuned: with another body attached, as a hammer's head


def odd_mass(key: str, mass: float, whole: float) -> list[str]:
    """A warning of a given mass [kg] that size and density contradict, by which a homogeneous body has `whole`."""
    if not mass or LEAST_SHARE * whole <= mass <= MOST_SHARE * whole:
        return []
    return [
        f"{key} = {mass:.4g} kg is {mass / whole:.2g} times the {whole:.4g} kg that size and density give; check all "
        f"three, or leave {key} out"
    ]


def idle_step(step: float, stepper: str, fixed: tuple[str, ...]) -> list[str]:
    """That a `step` [s] asked for does nothing, as a warning, where the stepper is none of those with `fixed` steps."""
    if not step or stepper in fixed:
        return []
    return [f"solver.step does nothing with {stepper}; solver.stepper: {fixed[0]} takes it"]
