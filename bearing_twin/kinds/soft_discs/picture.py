"""The picture of soft discs: force, velocity and energies over time, the deformed mesh at three instants or moving."""

from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bearing_twin.kinds.bodies.picture import PairPicture, draw_curves, draw_energies, draw_force
from bearing_twin.kinds.contract import Facts
from bearing_twin.kinds.soft_discs.derived import bodies_of, wall_speed
from bearing_twin.kinds.soft_discs.display import ENERGIES
from bearing_twin.kinds.soft_discs.figures import IMPACT
from bearing_twin.kinds.soft_discs.mesh import density_at_nodes, edges_of, half_disc, triangles_of
from bearing_twin.pictures import STYLE, frame, heading, scaled, scaled_time, write_moving

COLOURS = "viridis"
FRAMES = 40  # of an animation


class SoftDiscPicture(PairPicture):
    """The picture of one impact of a soft disc, from all its outputs."""

    kept, animated = IMPACT.name, True

    def __init__(self, facts: Facts):
        super().__init__(facts)
        self._parameters = facts.scene.parameters

    def contacts(self) -> np.ndarray:
        """The instant [s] of the greatest force, twice, and that force [N], once the impact is over: (3, n)."""
        return self.recorded(IMPACT, "peak_time", "peak_time", "peak_force")

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(2, 12, left=0.055, right=0.965, top=0.89, bottom=0.1, hspace=0.32, wspace=3.0)
        time, scale, unit = scaled_time(values["time"])
        force, velocity, energy = (figure.add_subplot(grid[0, 4 * k : 4 * k + 4]) for k in range(3))
        draw_force(force, time, values, scale, self.contacts())
        force.set_xlabel(f"time [{unit}]")
        kept = values["velocity"][-1] / wall_speed(self._parameters)
        title = f"Centre of mass, restitution {kept:.4f}"
        draw_curves(velocity, time, {"": values["velocity"]}, title, f"time [{unit}]", "velocity [m/s]")
        velocity.axhline(0.0, color=STYLE["soft"], linewidth=1.0)
        draw_energies(energy, time, unit, values, ENERGIES)
        self._draw_shapes(figure, [figure.add_subplot(grid[1, 4 * k : 4 * k + 4]) for k in range(3)], values, unit)

    def write(self, path, errors=()) -> Path:
        """Writes a picture or, where `path` ends in .gif, FRAMES shapes one after the other, with the force."""
        if Path(path).suffix.lower() != ".gif":
            return super().write(path, errors)
        values = self._values.arrays()
        rows = np.unique(np.linspace(0, len(values["time"]) - 1, FRAMES).astype(int))
        time, _, unit = scaled_time(values["time"])
        shapes = _Shapes(self._parameters, values, rows)
        figure = Figure(figsize=(8.0, 8.0), dpi=60, facecolor="white")
        axis = figure.add_axes((0.14, 0.1, 0.72, 0.8))
        bars = []

        def draw(row):
            axis.clear()
            drawn = shapes.draw(axis, row)
            heading(axis, f"{time[row]:.1f} {unit}, {values['normal_load'][row]:.4g} N", up=shapes.height)
            if not bars:
                bars.append(shapes.bar(figure, drawn, axis))

        return write_moving(figure, path, rows, draw)

    def _draw_shapes(self, figure, axes, values, unit):
        time, _, _ = scaled_time(values["time"])
        rows = _instants(values["normal_load"])
        shapes = _Shapes(self._parameters, values, rows)
        texts = ("half-way to the peak", "greatest force", "last contact")
        for axis, row, text in zip(axes, rows, texts, strict=True):
            drawn = shapes.draw(axis, row)
            heading(axis, f"{text}, {time[row]:.3g} {unit}")
        shapes.bar(figure, drawn, axes)
        axes[0].set_ylabel(shapes.height)


class _Shapes:
    """The deformed meshes of a run at some of its outputs, coloured by strain energy on one scale."""

    def __init__(self, parameters, values, rows):
        self._mesh = half_disc(parameters.mesh)
        self._against = parameters.against
        names, signs = ("shape", "other_shape"), ((1.0, 1.0), (1.0, -1.0))
        parts = list(zip(bodies_of(parameters).values(), names, signs, strict=False))
        self._discs = {
            row: [
                (values[name][row] * sign, density_at_nodes(one, self._mesh, values[name][row]))
                for one, name, sign in parts
            ]
            for row in rows
        }
        every = [disc for discs in self._discs.values() for disc in discs]
        self._factor, self._unit = scaled(np.concatenate([density for _, density in every]), "Pa")
        self._length, self._length_unit = scaled(np.concatenate([shape.ravel() for shape, _ in every]), "m")
        ground = "wall" if self._against == "wall" else "place of first touch"
        self.height = f"above the {ground} [{self._length_unit}]"
        self._greatest = self._factor * max(density.max() for _, density in every)
        places = self._length * np.concatenate([shape for shape, _ in every])
        self._widest = 1.05 * np.abs(places[:, 0]).max()
        margin = 0.05 * np.ptp(places[:, 1])
        self._low, self._high = places[:, 1].min() - margin, places[:, 1].max() + margin
        self._triangles, self._edges = triangles_of(self._mesh), edges_of(self._mesh)

    def draw(self, axis, row):
        """The discs at one output; returns what a colour bar is made of."""
        frame(axis)
        axis.grid(False)
        for shape, density in self._discs[row]:
            x, y = self._length * shape.T
            for side in (1.0, -1.0):
                drawn = axis.tripcolor(
                    side * x, y, self._triangles, self._factor * density, shading="gouraud", cmap=COLOURS, vmin=0.0,
                    vmax=self._greatest,
                )  # fmt: skip
                lines = np.concatenate([np.stack([side * x[line], y[line]], axis=-1) for line in self._edges])
                axis.add_collection(LineCollection(lines, colors="white", linewidths=0.4, alpha=0.6), autolim=False)
        if self._against != "other_disc":
            axis.plot([-self._widest, self._widest], [0.0, 0.0], color=STYLE["ink"], linewidth=2.0)
        axis.set_aspect("equal")
        axis.set_xlim(-self._widest, self._widest)
        axis.set_ylim(self._low, self._high)
        axis.set_xlabel(f"across the line of flight [{self._length_unit}]")
        axis.xaxis.set_major_locator(MaxNLocator(5))
        return drawn

    def bar(self, figure, drawn, axes):
        """The scale of colours."""
        bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.03)
        bar.outline.set_visible(False)
        bar.set_label(f"strain energy [{self._unit.replace('Pa', 'J/m³')}]", fontsize=11, color=STYLE["ink"])
        bar.ax.tick_params(length=0, labelsize=10, labelcolor=STYLE["ink"])
        return bar


def _instants(force: np.ndarray) -> list[int]:
    """Outputs at half the greatest force on the way up, at the greatest force, and at the last contact."""
    peak = int(np.argmax(force))
    touching = np.flatnonzero(force > 0.0)
    half = int(np.argmax(force >= 0.5 * force[peak]))
    return [half, peak, int(touching[-1]) if len(touching) else peak]
