"""What the choice of an elastic law or of a method says, alike in several kinds."""

from bearing_twin.contact.laws import LAWS


def drift(law: str) -> list[str]:
    """A warning of a law that carries a state whose errors add up, or none; names that are no law's have none."""
    state = LAWS[law].state if law in LAWS else None
    if state is None or state.projects:
        return []
    return [f"nothing pulls the errors of {law} back; contact.normal: hertz_differential does"]


def idle_step(step: float, stepper: str, fixed: tuple[str, ...]) -> list[str]:
    """That a `step` [s] asked for does nothing, as a warning, where the stepper is none of those with `fixed` steps."""
    if not step or stepper in fixed:
        return []
    return [f"solver.step does nothing with {stepper}; solver.stepper: {fixed[0]} takes it"]
