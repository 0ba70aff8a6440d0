"""The picture of one impact: its force over time, and what it does to the bodies; of a beam, its shape at instants."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.errors import LogError
from bearing_twin.kinds.bearing.summary import run_facts
from bearing_twin.kinds.impact.collision import peak_of
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, finish, frame, heading

SIZE = (16.0, 10.0)  # inches at 100 dots each
ENERGIES = (
    ("kinetic_energy", "kinetic"),
    ("elastic_energy", "in the contact"),
    ("beam_energy", "in the beam"),
)


class ImpactHistory:
    """The outputs of an impact, block by block, kept whole: an impact is short."""

    def __init__(self):
        self.blocks = []

    def add_block(self, block) -> None:
        """Takes a block in."""
        self.blocks.append(block)

    def arrays(self) -> dict[str, np.ndarray]:
        """Time [s] as "time", and every channel by name; raises LogError without a sample."""
        if not self.blocks:
            raise LogError("there is no sample in it; recover the log from the original, or simulate again")
        values = {name: np.concatenate([block.values[name] for block in self.blocks]) for name in self.blocks[0].values}
        return {"time": 1e-9 * np.concatenate([block.time_ns for block in self.blocks]), **values}


def plot_impact(source, png_path, facts: dict | None = None) -> Path:
    """Write the picture of an impact: a run, a log or an `ImpactHistory`; returns the path.

    `facts` may name `scene` (a Scene), `law` and `stepper` where the source does not. Raises BearingTwinError.
    """
    history = source
    if not isinstance(source, ImpactHistory):
        history = ImpactHistory()
        for block in source.blocks():
            history.add_block(block)
    facts = run_facts(source) | (facts or {})
    values = history.arrays()
    figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    if "shape" in values:
        _draw_beam(figure, values, facts["scene"])
    else:
        _draw_pair(figure, values)
    scene = facts.get("scene")
    title = scene.description if scene and scene.description else "Impact"
    return finish(figure, title, _footer(facts, values), png_path, size=17)


def summarise_impact(stream, blocks, history: ImpactHistory) -> dict:
    """The figures of an impact read off its samples alone, as plain data with SI-suffixed keys; blocks go to `history`.

    Peaks are those of the parabolas through the greatest samples; contacts shorter than two outputs may be missed.
    """
    missing, following = 0, 0
    for block in blocks:
        history.add_block(block)
        missing += max(block.first_sequence - following, 0)
        following = block.first_sequence + len(block)
    values = history.arrays()
    time, force = values["time"], values["normal_load"]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], force > 0.0, [0]]))).reshape(-1, 2)
    energy = sum(values[name] for name, _ in ENERGIES if name in values)
    scene = getattr(stream, "scene", None)
    result = {
        "scene": scene.name if scene else None,
        "outputs": len(time),
        "missing_outputs": missing,
        "peak_force_n": peak_of(time, force),
        "contacts": [
            {
                "start_s": float(time[max(first - 1, 0)]),
                "duration_s": float(time[min(last, len(time) - 1)] - time[max(first - 1, 0)]),
                "peak_force_n": peak_of(time[first:last], force[first:last]),
                "impulse_ns": float(
                    np.trapezoid(force[max(first - 1, 0) : last + 1], time[max(first - 1, 0) : last + 1])
                ),
            }
            for first, last in edges
        ],
        "stored_energy_change": float(energy[-1] / energy[0] - 1.0),
    }
    if "deflection" in values:
        result["peak_deflection_m"] = float(np.abs(values["deflection"]).max())
        result["peak_stress_pa"] = float(np.abs(values["bending_stress"]).max())
    return result


def _draw_pair(figure, values):
    grid = figure.add_gridspec(2, 2, left=0.06, right=0.98, top=0.89, bottom=0.095, hspace=0.3, wspace=0.16)
    time, _, unit = _scaled_time(values)
    force, approach = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    _draw_force(force, time, values)
    force.set_xlabel(f"time [{unit}]")
    frame(approach)
    inside = values["approach"] >= 0.0
    approach.plot(1e6 * values["approach"][inside], values["normal_load"][inside], color=BALL_COLOURS[0], linewidth=2)
    approach.set_xlabel("approach [µm]")
    approach.set_ylabel("contact force [N]")
    heading(approach, "Force against approach: the loop is what is lost")
    velocity = figure.add_subplot(grid[1, 0])
    frame(velocity)
    for body, name in enumerate(("first", "second")):
        velocity.plot(time, values["velocity"][:, body], color=BALL_COLOURS[body], linewidth=2, label=name)
    velocity.margins(x=0.0)
    velocity.legend(frameon=False, fontsize=11)
    velocity.set_xlabel(f"time [{unit}]")
    velocity.set_ylabel("velocity [m/s]")
    heading(velocity, "The two bodies")
    _draw_energies(figure.add_subplot(grid[1, 1]), time, unit, values)


def _draw_beam(figure, values, scene):
    grid = figure.add_gridspec(3, 2, left=0.06, right=0.98, top=0.90, bottom=0.095, hspace=0.34, wspace=0.16)
    time, scale, unit = _scaled_time(values)
    force, deflection, stress = (figure.add_subplot(grid[row, 0]) for row in range(3))
    _draw_force(force, time, values)
    shares, point = scene.parameters.outputs.points, scene.parameters.blow.point
    others = {i + 1: share for i, share in enumerate(shares) if share != point}
    names, columns = ["impact", *(f"{share:g} of the span" for share in others.values())], [0, *others]
    _draw_points(deflection, time, 1e6 * values["deflection"], columns, names)
    deflection.set_ylabel("deflection [µm]")
    deflection.invert_yaxis()
    heading(deflection, "Deflection, downward")
    deflection.legend(frameon=False, fontsize=10, ncol=4, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderpad=0)
    _draw_points(stress, time, 1e-6 * values["bending_stress"], columns, names)
    stress.set_ylabel("bending stress [MPa]")
    heading(stress, "Bending stress of the lower fibre, tension positive")
    stress.set_xlabel(f"time [{unit}]")
    for axis in (force, deflection):
        axis.tick_params(labelbottom=False)
    shapes = figure.add_subplot(grid[:2, 1])
    _draw_shapes(shapes, values, scene, scale, unit)
    _draw_energies(figure.add_subplot(grid[2, 1]), time, unit, values)


def _draw_force(axis, time, values):
    frame(axis)
    axis.fill_between(time, values["normal_load"], color=BALL_COLOURS[0], alpha=0.2, linewidth=0)
    axis.plot(time, values["normal_load"], color=BALL_COLOURS[0], linewidth=2)
    axis.set_ylabel("contact force [N]")
    axis.margins(x=0.0)
    peak = peak_of(values["time"], values["normal_load"])
    heading(axis, f"Contact force, at most {peak:.5g} N")


def _draw_points(axis, time, lines, columns, names):
    frame(axis)
    for i, (column, name) in enumerate(zip(columns, names, strict=True)):
        style = "-" if i == 0 else (0, (5, 1 + 2 * i))
        axis.plot(time, lines[:, column], color=BALL_COLOURS[i], linewidth=1.8, linestyle=style, label=name)
    axis.margins(x=0.0)


def _draw_shapes(axis, values, scene, scale, unit):
    """The beam and the sphere at the start, at the greatest force and the greatest deflection (paper 2, figs 2, 3)."""
    frame(axis)
    parameters = scene.parameters
    span, point = 1e3 * parameters.beam.span, 1e3 * parameters.beam.span * parameters.blow.point
    stations = np.linspace(0.0, span, values["shape"].shape[1])
    greatest = values["shape"].max() or 1.0
    instants = (
        ("start", 0), ("greatest force", int(values["normal_load"].argmax())),
        ("greatest deflection", _first_peak(values["deflection"][:, 0])),
    )  # fmt: skip
    for i, (name, row) in enumerate(instants):
        label = f"{name}, {scale * values['time'][row]:.4g} {unit}"
        axis.plot(stations, 1e6 * values["shape"][row], color=BALL_COLOURS[i], linewidth=2.6, label=label)
        bottom = values["sphere_position"][row] - max(values["approach"][row], 0.0)
        axis.plot(point, 1e6 * bottom, "o", color=BALL_COLOURS[i], markersize=11, markeredgecolor="white")
    axis.plot([0.0, span], [0.0, 0.0], "^", color=STYLE["edge"], markersize=12, clip_on=False)
    axis.set_ylim(1.35e6 * greatest, -0.75e6 * greatest)
    axis.set_xlabel("along the beam [mm]")
    axis.set_ylabel("deflection, downward [µm]")
    axis.legend(frameon=False, fontsize=11, loc="lower left")
    heading(axis, "The beam at three instants; dots: the sphere's lowest point")
    if not (-0.75 * greatest < values["sphere_position"][instants[2][1]] < 1.35 * greatest):
        axis.text(0.98, 0.96, "by the last instant the sphere has left the picture", transform=axis.transAxes,
                  ha="right", va="top", fontsize=10.5, color=STYLE["soft"])  # fmt: skip


def _first_peak(values) -> int:
    """The first sample within a thousandth of the greatest: an undamped beam comes back to it again and again."""
    return int(np.argmax(values >= 0.999 * values.max()))


def _draw_energies(axis, time, unit, values):
    """Stored energies on top of each other, as a share of what was brought: the books are closed where they reach 1."""
    frame(axis)
    brought = values["kinetic_energy"][0]
    present = [(name, text) for name, text in ENERGIES if name in values]
    parts = [values[name] / brought for name, _ in present]
    axis.stackplot(time, parts, labels=[text for _, text in present], colors=BALL_COLOURS[: len(parts)], alpha=0.75)
    axis.axhline(1.0, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.margins(x=0.0)
    axis.set_ylim(0.0, max(1.3, 1.15 * float(np.sum(parts, axis=0).max())))
    axis.set_xlabel(f"time [{unit}]")
    axis.set_ylabel("share of what came")
    axis.legend(frameon=False, fontsize=10, ncol=3, loc="upper right")
    heading(axis, "Energy")


def _scaled_time(values):
    last = values["time"][-1]
    scale, unit = (1e6, "µs") if last < 1e-3 else (1e3, "ms") if last < 1.0 else (1.0, "s")
    return scale * values["time"], scale, unit


def _footer(facts, values) -> str:
    words = [f"{len(values['time'])} outputs"]
    words += [f"{name}: {facts[name]}" for name in ("law", "stepper") if facts.get(name)]
    scene = facts.get("scene")
    if scene is not None:
        words.insert(0, scene.name)
    return f"{', '.join(words)}; bearing_twin {__version__}"
