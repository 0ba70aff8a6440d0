"""The picture of two bodies that meet: force over time and approach, velocities, energies."""

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.kinds.impact.view import ENERGIES
from bearing_twin.pictures.run import RunPicture
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, scaled
from bearing_twin.pictures.values import scaled_time


class PairPicture(RunPicture):
    """The picture of one impact, from all its outputs: an impact is short."""

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(2, 2, left=0.06, right=0.98, top=0.89, bottom=0.095, hspace=0.3, wspace=0.16)
        time, _, unit = scaled_time(values["time"])
        force, approach = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        draw_force(force, time, values)
        force.set_xlabel(f"time [{unit}]")
        frame(approach)
        inside = values["approach"] >= 0.0
        deep, load = values["approach"][inside], values["normal_load"][inside]
        (by_length, length), (by_force, newtons) = scaled(deep, "m"), scaled(values["normal_load"], "N")
        approach.plot(by_length * deep, by_force * load, color=BALL_COLOURS[0], linewidth=2)
        across, up = f"approach [{length}]", f"contact force [{newtons}]"
        heading(approach, "Force against approach: the loop is what is lost", across, up)
        velocity = figure.add_subplot(grid[1, 0])
        frame(velocity)
        for body, name in enumerate(("first", "second")):
            velocity.plot(time, values["velocity"][:, body], color=BALL_COLOURS[body], linewidth=2, label=name)
        velocity.margins(x=0.0)
        velocity.legend(frameon=False, fontsize=11)
        heading(velocity, "The two bodies", f"time [{unit}]", "velocity [m/s]")
        draw_energies(figure.add_subplot(grid[1, 1]), time, unit, values)


def draw_force(axis, time, values) -> None:
    """The contact force over time, its peak in the heading."""
    frame(axis)
    factor, unit = scaled(values["normal_load"], "N")
    axis.fill_between(time, factor * values["normal_load"], color=BALL_COLOURS[0], alpha=0.2, linewidth=0)
    axis.plot(time, factor * values["normal_load"], color=BALL_COLOURS[0], linewidth=2)
    axis.margins(x=0.0)
    peak = factor * peak_of(values["normal_load"])
    heading(axis, f"Contact force, at most {peak:.5g} {unit}", up=f"contact force [{unit}]")


def draw_energies(axis, time, unit, values, shown=ENERGIES) -> None:
    """Stored energies on top of each other, as a share of what was brought: the books are closed where they reach 1."""
    frame(axis)
    brought = values["kinetic_energy"][0]
    parts = [values[name] / brought for name, _ in shown]
    axis.stackplot(time, parts, labels=[text for _, text in shown], colors=BALL_COLOURS[: len(parts)], alpha=0.75)
    axis.axhline(1.0, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.margins(x=0.0)
    axis.set_ylim(0.0, max(1.3, 1.15 * float(np.sum(parts, axis=0).max())))
    axis.legend(frameon=False, fontsize=10, ncol=3, loc="upper right")
    heading(axis, "Energy", f"time [{unit}]", "share of what came")
