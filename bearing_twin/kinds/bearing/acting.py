"""The keys of what acts from outside, over time, on a body that moves: a ring with mass, or a shaft."""

from dataclasses import dataclass

from bearing_twin.base.parameters import number_table, quantity

LOAD_COLUMNS = (("time", "s"), ("x", "N"), ("y", "N"), ("z", "N"), ("about x", "N m"), ("about y", "N m"))


@dataclass(frozen=True)
class LoadChange:
    """One change of the load while it runs, added at once to what it was."""

    time: float = quantity(0.0, "s", "when the load changes; 0 = never", at_least=0.0)
    load: tuple[float, float, float] = quantity((0.0, 0.0, 0.0), "N", "added to load")
    moment: tuple[float, float] = quantity((0.0, 0.0), "N m", "added to moment")


def steady_load(where: str):
    """The key `load` [N]: the force on the body, `where` says at which point."""
    return quantity((0.0, 0.0, 0.0), "N", f"force {where}")


def steady_moment(body: str):
    """The key `moment` [N m] about x and y."""
    return quantity((0.0, 0.0), "N m", f"on {body} about x and y")


def load_table():
    """The key `table`: rows of LOAD_COLUMNS, or the name of a CSV file of them."""
    return number_table(
        LOAD_COLUMNS, "loads over time, added to load and moment; straight between rows, then as the last"
    )
