"""The picture of a sphere on a beam: force, deflection and stress over time, the beam at instants, energies."""

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.kinds.beam.display import ENERGIES, watched_points
from bearing_twin.kinds.bodies.picture import ABOVE, PairPicture, draw_curves, draw_energies, draw_force
from bearing_twin.pictures import BALL_COLOURS, STYLE, frame, heading, scaled_time


class BeamPicture(PairPicture):
    """The picture of one impact on a beam, from all its outputs."""

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        scene = self._facts.scene
        grid = figure.add_gridspec(3, 2, left=0.06, right=0.98, top=0.90, bottom=0.095, hspace=0.34, wspace=0.16)
        time, scale, unit = scaled_time(values["time"])
        force, deflection, stress = (figure.add_subplot(grid[row, 0]) for row in range(3))
        draw_force(force, time, values, scale, self.contacts())
        watched = watched_points(scene.parameters)
        down, bent = (
            {name: factor * values[channel][:, column] for column, name in watched.items()}
            for channel, factor in (("deflection", 1e6), ("bending_stress", 1e-6))
        )
        look = {"ncol": 4, "fontsize": 10, **ABOVE}
        draw_curves(deflection, time, down, "Deflection, downward", up="deflection [µm]", dashed=True, **look)
        deflection.invert_yaxis()
        title = "Bending stress of the lower fibre, tension positive"
        draw_curves(stress, time, bent, title, f"time [{unit}]", "bending stress [MPa]", dashed=True)
        stress.get_legend().remove()  # as above
        for axis in (force, deflection):
            axis.tick_params(labelbottom=False)
        shapes = figure.add_subplot(grid[:2, 1])
        _draw_shapes(shapes, values, scene, scale, unit)
        draw_energies(figure.add_subplot(grid[2, 1]), time, unit, values, ENERGIES)


def _draw_shapes(axis, values, scene, scale, unit):
    """The beam and the sphere at the start, at the greatest force and the greatest deflection (paper 2, figs 2, 3)."""
    frame(axis)
    parameters = scene.parameters
    span, point = 1e3 * parameters.beam.span, 1e3 * parameters.beam.span * parameters.blow.point
    stations = np.linspace(0.0, span, values["shape"].shape[1])
    greatest = values["shape"].max() or 1.0
    instants = {
        "start": 0,
        "greatest force": int(values["normal_load"].argmax()),
        "greatest deflection": _first_peak(values["deflection"][:, 0]),
    }
    if not values["normal_load"].any():  # no output fell into a contact
        del instants["greatest force"]
    for i, (name, row) in enumerate(instants.items()):
        label = f"{name}, {scale * values['time'][row]:.4g} {unit}"
        axis.plot(stations, 1e6 * values["shape"][row], color=BALL_COLOURS[i], linewidth=2.6, label=label)
        bottom = values["sphere_position"][row] - max(values["approach"][row], 0.0)
        axis.plot(point, 1e6 * bottom, "o", color=BALL_COLOURS[i], markersize=11, markeredgecolor="white")
    axis.plot([0.0, span], [0.0, 0.0], "^", color=STYLE["edge"], markersize=12, clip_on=False)
    axis.set_ylim(1.35e6 * greatest, -0.75e6 * greatest)
    axis.set_xlabel("along the beam [mm]")
    axis.set_ylabel("deflection, downward [µm]")
    axis.legend(frameon=False, fontsize=11, loc="lower left")
    heading(axis, "The beam at instants; dots: the sphere's lowest point")
    if not (-0.75 * greatest < values["sphere_position"][instants["greatest deflection"]] < 1.35 * greatest):
        axis.text(0.98, 0.96, "by the last instant the sphere has left the picture", transform=axis.transAxes,
                  ha="right", va="top", fontsize=10.5, color=STYLE["soft"])  # fmt: skip


def _first_peak(values) -> int:
    """The first sample within a thousandth of the greatest: an undamped beam comes back to it again and again."""
    return int(np.argmax(values >= 0.999 * values.max()))
