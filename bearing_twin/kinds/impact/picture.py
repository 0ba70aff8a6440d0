"""The picture of two colliding bodies: force over time and approach, velocities, energies."""

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.base.units import prefixed
from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.kinds.impact.figures import CONTACT
from bearing_twin.kinds.impact.view import ENERGIES
from bearing_twin.pictures.panels import draw_peaks
from bearing_twin.pictures.run import RunPicture, scaled_time
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, marker_of, scaled

MISSED = 10  # outputs in a contact: fewer may pass its peak by
NONE = np.empty((3, 0))


class PairPicture(RunPicture):
    """The picture of one impact, from all its outputs: an impact is short."""

    kept = CONTACT.name

    def contacts(self) -> np.ndarray:
        """Begin, end [s] and greatest force [N] of each contact that has ended, (3, n)."""
        start, lasting, peak = self.recorded(CONTACT, "start", "duration", "peak_force")
        return np.stack([start, start + lasting, peak])  # "time" may be that of the output that brought the record

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(2, 2, left=0.06, right=0.98, top=0.89, bottom=0.095, hspace=0.3, wspace=0.16)
        time, scale, unit = scaled_time(values["time"])
        force, approach = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        draw_force(force, time, values, scale, self.contacts())
        force.set_xlabel(f"time [{unit}]")
        frame(approach)
        inside = values["approach"] >= 0.0
        deep, load = values["approach"][inside], values["normal_load"][inside]
        (by_length, length), (by_force, newtons) = scaled(deep, "m"), scaled(values["normal_load"], "N")
        approach.plot(
            by_length * deep, by_force * load, color=BALL_COLOURS[0], linewidth=2, marker=marker_of(len(time))
        )
        across, up = f"approach [{length}]", f"contact force [{newtons}]"
        heading(approach, "Force against approach: the loop is the energy lost", across, up)
        velocity = figure.add_subplot(grid[1, 0])
        frame(velocity)
        for body, name in enumerate(("first", "second")):
            look = {"color": BALL_COLOURS[body], "linewidth": 2, "marker": marker_of(len(time)), "label": name}
            velocity.plot(time, values["velocity"][:, body], **look)
        velocity.margins(x=0.0)
        velocity.legend(frameon=False, fontsize=11)
        heading(velocity, "The two bodies", f"time [{unit}]", "velocity [m/s]")
        draw_energies(figure.add_subplot(grid[1, 1]), time, unit, values)


def draw_force(axis, time, values, scale: float = 1.0, contacts=NONE) -> None:
    """The contact force over time, its peak in the heading; `time` is by `scale` in another unit than the contacts.

    Of `contacts`, (3, n) as of `PairPicture.contacts`, those that fewer outputs than MISSED see are marked.
    """
    frame(axis)
    load, (begin, end, recorded) = values["normal_load"], (scale * contacts[0], scale * contacts[1], contacts[2])
    peak = max(float(load.max()), float(recorded.max())) if recorded.size else peak_of(load)
    factor, unit = prefixed(peak, "N")
    axis.fill_between(time, factor * load, color=BALL_COLOURS[0], alpha=0.2, linewidth=0)
    axis.plot(time, factor * load, color=BALL_COLOURS[0], linewidth=2, marker=marker_of(len(time)))
    seen = np.searchsorted(time, end, side="right") - np.searchsorted(time, begin)
    missed = seen < MISSED
    if missed.any():
        draw_peaks(axis, time[-1] - time[0], begin[missed], end[missed], factor * recorded[missed])
        axis.legend(frameon=False, fontsize=10, loc="best")
    axis.margins(x=0.0)
    heading(axis, f"Contact force, peak {factor * peak:.5g} {unit}", up=f"contact force [{unit}]")


def draw_energies(axis, time, unit, values, shown=ENERGIES) -> None:
    """Stored energies on top of each other, as a share of the initial energy: it is conserved where they reach 1."""
    frame(axis)
    initial = values["kinetic_energy"][0]
    parts = [values[name] / initial for name, _ in shown]
    axis.stackplot(time, parts, labels=[text for _, text in shown], colors=BALL_COLOURS[: len(parts)], alpha=0.75)
    axis.axhline(1.0, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.margins(x=0.0)
    axis.tick_params(pad=6)  # its first numbers stand in one corner
    axis.set_ylim(0.0, max(1.3, 1.15 * float(np.sum(parts, axis=0).max())))
    axis.legend(frameon=False, fontsize=10, ncol=3, loc="upper right")
    heading(axis, "Energy", f"time [{unit}]", "share of the initial energy")
