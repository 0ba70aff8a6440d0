"""Drawing beside the curves of a sphere on a beam: the beam at instants (paper 2, figures 2 and 3)."""

import numpy as np

from bearing_twin.kinds.beam.display import view
from bearing_twin.kinds.bodies.figures import CONTACT
from bearing_twin.kinds.picture import RunPicture
from bearing_twin.pictures import BALL_COLOURS, STYLE, heading, readable_scale, style_axes

ABOVE, BELOW = 0.75, 1.35  # what is seen above and below the beam at rest, in greatest deflections


class BeamPicture(RunPicture):
    """The picture of one impact on a beam."""

    view, peaks = staticmethod(view), (CONTACT, "start", "time", "peak_force")

    def draw_bodies(self, figure, cell, values) -> None:
        """The beam and the sphere at the start, at the greatest force and at the greatest deflection."""
        axis, parameters, time = figure.add_subplot(cell), self.parameters, values["time"]
        style_axes(axis)
        span, greatest = 1e3 * parameters.beam.span, values["shape"].max() or 1e-6
        factor, unit = readable_scale(greatest, "m")
        stations = np.linspace(0.0, span, values["shape"].shape[1])
        instants = {
            "start": 0,
            "greatest force": int(values["normal_load"].argmax()),
            "greatest deflection": _first_peak(values["deflection"][:, 0]),
        }
        if not values["normal_load"].any():  # no output fell into a contact
            del instants["greatest force"]
        for colour, (name, row) in zip(BALL_COLOURS, instants.items(), strict=False):
            label = f"{name}, {1e6 * time[row]:.4g} µs"
            axis.plot(stations, factor * values["shape"][row], color=colour, linewidth=2.6, label=label)
            bottom = values["sphere_position"][row] - max(values["approach"][row], 0.0)
            if -ABOVE * greatest < bottom < BELOW * greatest:
                marker_style = {"color": colour, "markersize": 11, "markeredgecolor": "white"}
                axis.plot(span * parameters.blow.point, factor * bottom, "o", **marker_style)
        axis.plot([0.0, span], [0.0, 0.0], "^", color=STYLE["edge"], markersize=12, clip_on=False)
        axis.set_ylim(factor * BELOW * greatest, -factor * ABOVE * greatest)
        axis.legend(frameon=False, fontsize=11, loc="lower left")
        title = "The beam at instants; dots: the sphere's lowest point"
        heading(axis, title, "along the beam [mm]", f"deflection, downward [{unit}]")


def _first_peak(values) -> int:
    """The first sample within a thousandth of the greatest: an undamped beam comes back to it again and again."""
    return int(np.argmax(values >= 0.999 * values.max()))
