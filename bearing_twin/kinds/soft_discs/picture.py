"""Drawing beside the curves of soft discs: the deformed meshes at the greatest force."""

import numpy as np
from matplotlib.collections import LineCollection

from bearing_twin.kinds.picture import RunPicture
from bearing_twin.kinds.soft_discs.derived import bodies_of
from bearing_twin.kinds.soft_discs.display import view
from bearing_twin.kinds.soft_discs.figures import IMPACT
from bearing_twin.kinds.soft_discs.mesh import density_at_nodes, edges_of, half_disc, triangles_of
from bearing_twin.pictures import STYLE, heading, readable_scale, style_axes


class SoftDiscPicture(RunPicture):
    """The picture of one impact of a soft disc."""

    view, peaks = staticmethod(view), (IMPACT, "peak_time", "peak_time", "peak_force")

    def draw_bodies(self, figure, place, values) -> None:
        """Both halves of each disc, coloured by strain energy."""
        axis, parameters, row = figure.add_subplot(place), self.parameters, values["normal_load"].argmax()
        mesh, drawn = half_disc(parameters.mesh), None
        bodies = dict(zip(("shape", "other_shape"), bodies_of(parameters).values(), strict=False))
        densities = {name: density_at_nodes(body, mesh, values[name][row]) for name, body in bodies.items()}
        factor, unit = readable_scale(np.stack([*densities.values()]), "Pa")
        greatest = factor * max(one.max() for one in densities.values())
        style_axes(axis)
        axis.grid(False)
        for (name, density), up in zip(densities.items(), (1.0, -1.0), strict=False):
            for side in (1.0, -1.0):
                x, y = 1e3 * values[name][row].T * [[side], [up]]
                look = {"shading": "gouraud", "vmin": 0.0, "vmax": greatest}
                drawn = axis.tripcolor(x, y, triangles_of(mesh), factor * density, **look)
                lines = np.concatenate([np.stack([x[line], y[line]], axis=-1) for line in edges_of(mesh)])
                axis.add_collection(LineCollection(lines, colors="white", linewidths=0.4, alpha=0.6))
        if parameters.against != "other_disc":
            axis.axhline(0.0, color=STYLE["ink"], linewidth=2.0)
        axis.set_aspect("equal", adjustable="datalim")
        bar = figure.colorbar(drawn, ax=axis, location="bottom", pad=0.1, fraction=0.03)
        bar.outline.set_visible(False)
        bar.set_label(f"strain energy [{unit.replace('Pa', 'J/m³')}]", fontsize=11, color=STYLE["ink"])
        ground = "wall" if parameters.against == "wall" else "place of first touch"
        heading(axis, "At the greatest force", "across the line of flight [mm]", f"above the {ground} [mm]")
