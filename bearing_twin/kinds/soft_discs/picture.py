"""The picture of a soft disc: force, velocity and energies over time, and the deformed mesh at three instants."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bearing_twin.kinds.contract import Facts
from bearing_twin.kinds.impact.picture import PairPicture, draw_energies, draw_force
from bearing_twin.kinds.soft_discs.derived import wall_speed
from bearing_twin.kinds.soft_discs.mesh import half_disc
from bearing_twin.kinds.soft_discs.strain_energy import density_at_nodes
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading, scaled
from bearing_twin.pictures.values import scaled_time

ENERGIES = (("kinetic_energy", "kinetic"), ("elastic_energy", "strain"), ("contact_energy", "in the penalty"))
COLOURS = "viridis"


class SoftDiscPicture(PairPicture):
    """The picture of one impact of a soft disc, from all its outputs."""

    def __init__(self, facts: Facts):
        super().__init__(facts)
        self._parameters = facts.scene.parameters

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        """Fills the figure with panels."""
        grid = figure.add_gridspec(2, 12, left=0.055, right=0.98, top=0.89, bottom=0.1, hspace=0.32, wspace=3.0)
        time, _, unit = scaled_time(values["time"])
        force, velocity, energy = (figure.add_subplot(grid[0, 4 * k : 4 * k + 4]) for k in range(3))
        draw_force(force, time, values)
        force.set_xlabel(f"time [{unit}]")
        _draw_velocity(velocity, time, unit, values, wall_speed(self._parameters))
        draw_energies(energy, time, unit, values, ENERGIES)
        self._draw_shapes(figure, [figure.add_subplot(grid[1, 4 * k : 4 * k + 4]) for k in range(3)], values, unit)

    def _draw_shapes(self, figure, axes, values, unit):
        mesh = self._parameters.mesh
        mesh = half_disc(mesh.divisions, mesh.order, mesh.integration)
        time, _, _ = scaled_time(values["time"])
        rows = _instants(values["normal_load"])
        shapes = [values["shape"][row] for row in rows]
        densities = [density_at_nodes(self._parameters, mesh, shape) for shape in shapes]
        factor, label = scaled(np.concatenate(densities), "Pa")
        length, length_unit = scaled(shapes[0], "m")
        greatest = factor * max(one.max() for one in densities)
        triangles = _triangles(mesh)
        texts = ("half-way to the peak", "greatest force", "last contact")
        widest, highest = (1.05 * length * max(np.abs(shape[:, k]).max() for shape in shapes) for k in range(2))
        for axis, row, shape, density, text in zip(axes, rows, shapes, densities, texts, strict=True):
            frame(axis)
            axis.grid(False)
            x, y = length * shape.T
            for side in (1.0, -1.0):
                drawn = axis.tripcolor(
                    side * x, y, triangles, factor * density, shading="gouraud", cmap=COLOURS, vmin=0.0, vmax=greatest
                )
                for line in _edges(mesh):
                    axis.plot(side * x[line].T, y[line].T, color="white", linewidth=0.4, alpha=0.6)
            axis.plot([-widest, widest], [0.0, 0.0], color=STYLE["ink"], linewidth=2.0)
            axis.set_aspect("equal")
            axis.set_xlim(-widest, widest)
            axis.set_ylim(-0.05 * highest, highest)
            axis.set_xlabel(f"along the wall [{length_unit}]")
            axis.xaxis.set_major_locator(MaxNLocator(5))
            heading(axis, f"{text}, {time[row]:.3g} {unit}")
        bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.03)
        bar.outline.set_visible(False)
        bar.set_label(f"strain energy [{label.replace('Pa', 'J/m³')}]", fontsize=11, color=STYLE["ink"])
        bar.ax.tick_params(length=0, labelsize=10, labelcolor=STYLE["ink"])
        axes[0].set_ylabel(f"above the wall [{length_unit}]")


def _draw_velocity(axis, time, unit, values, speed):
    frame(axis)
    axis.plot(time, values["velocity"], color=BALL_COLOURS[0], linewidth=2)
    axis.axhline(0.0, color=STYLE["soft"], linewidth=1.0)
    axis.margins(x=0.0)
    axis.set_xlabel(f"time [{unit}]")
    axis.set_ylabel("velocity [m/s]")
    heading(axis, f"Centre of mass, restitution {values['velocity'][-1] / speed:.4f}")


def _instants(force: np.ndarray) -> list[int]:
    """Outputs at half the greatest force on the way up, at the greatest force, and at the last contact."""
    peak = int(np.argmax(force))
    touching = np.flatnonzero(force > 0.0)
    half = int(np.argmax(force >= 0.5 * force[peak]))
    return [half, peak, int(touching[-1]) if len(touching) else peak]


def _triangles(mesh) -> np.ndarray:
    """Two triangles (t, 3) for each cell between neighbouring nodes of an element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    a, b, c, d = grid[:, :-1, :-1], grid[:, :-1, 1:], grid[:, 1:, 1:], grid[:, 1:, :-1]
    return np.concatenate([np.stack([one.ravel() for one in three], axis=1) for three in ((a, b, c), (a, c, d))])


def _edges(mesh) -> list[np.ndarray]:
    """Nodes (e, order + 1) along each of the four sides of every element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    return [grid[:, 0], grid[:, -1], grid[:, :, 0], grid[:, :, -1]]
