"""The picture of one Hertzian contact: its ellipse, pressure, stresses below the surface, and errors of the laws."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.contact.calculator import COMPARED, Gap, axis_stresses, laws_at
from bearing_twin.contact.elasticity import curvature_ratio
from bearing_twin.contact.laws import LAWS
from bearing_twin.pictures import BALL_COLOURS, LOAD_MAP, SIZE, STYLE, ball_style, heading, save, style_axes

LEAST_SHOWN = 1e-12  # of the laws' errors


def plot_contact(result: dict, poisson_ratio: float, png_path) -> Path:
    """Write the picture of a `calculator.answer`; stresses are those in a body of that Poisson's ratio."""
    figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
    grid = figure.add_gridspec(2, 2, left=0.07, right=0.97, top=0.87, bottom=0.09, wspace=0.17, hspace=0.34)
    axes = [figure.add_subplot(grid[row, column]) for row in (0, 1) for column in (0, 1)]
    _draw_ellipse(figure, axes[0], result)
    _draw_pressure(axes[1], result)
    _draw_stress(axes[2], result, poisson_ratio)
    _draw_laws(axes[3], result)
    title = f"Hertz contact under {result['normal_load_n']:.4g} N, b/a = {result['axis_ratio']:.3g}"
    figure.text(0.07, 0.95, title, fontsize=20, weight="bold", color=STYLE["ink"], va="center")
    facts = (
        f"approach {1e6 * result['approach_m']:.4g} µm, stiffness {1e-6 * result['stiffness_n_per_m']:.4g} N/µm, "
        f"E* {1e-9 * result['effective_modulus_pa']:.4g} GPa"
    )
    figure.text(0.07, 0.915, facts, fontsize=12, color=STYLE["soft"], va="center")
    return save(figure, png_path)


def _draw_ellipse(figure, axis, result):
    style_axes(axis)
    a, b = 1e6 * result["semi_major_m"], 1e6 * result["semi_minor_m"]
    x, y = np.meshgrid(np.linspace(-a, a, 401), np.linspace(-b, b, 201))
    inside = 1.0 - (x / a) ** 2 - (y / b) ** 2
    pressure = 1e-9 * result["peak_pressure_pa"] * np.sqrt(np.maximum(inside, 0.0))
    image = axis.pcolormesh(x, y, np.where(inside >= 0.0, pressure, np.nan), cmap=LOAD_MAP, rasterized=True)
    figure.colorbar(image, ax=axis, pad=0.015, label="pressure [GPa]")
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    axis.plot(a * np.cos(turn), b * np.sin(turn), color=STYLE["ink"], linewidth=1.2)
    axis.set_aspect("equal")
    axis.set_xlim(-1.08 * a, 1.08 * a)
    axis.set_ylim(-max(1.15 * b, 0.45 * a), max(1.15 * b, 0.45 * a))
    axis.set_xlabel("along the major axis [µm]")
    axis.set_ylabel("minor axis [µm]")
    heading(axis, f"Contact ellipse, {2.0 * a:.4g} × {2.0 * b:.4g} µm, same scale both ways")


def _draw_pressure(axis, result):
    style_axes(axis)
    share = np.sin(np.linspace(-0.5, 0.5, 201) * np.pi)
    pressure = 1e-9 * result["peak_pressure_pa"] * np.sqrt(1.0 - share**2)
    for name, key, colour in (("major", "semi_major_m", 0), ("minor", "semi_minor_m", 5)):
        label = f"along the {name} axis, ±{1e6 * result[key]:.4g} µm"
        axis.plot(1e6 * result[key] * share, pressure, color=BALL_COLOURS[colour], linewidth=2.2, label=label)
    axis.set_ylim(0.0, 1.3 * pressure.max())
    axis.legend(frameon=False, loc="upper right")
    heading(axis, f"Pressure along the axes, peak {pressure.max():.4g} GPa", "from the centre [µm]", "pressure [GPa]")


def _draw_stress(axis, result, poisson_ratio):
    style_axes(axis)
    contact = result["semi_major_m"], result["semi_minor_m"], result["peak_pressure_pa"]
    depth = np.linspace(0.0, 3.0 * result["semi_minor_m"], 300)
    stresses = np.array(axis_stresses(*contact, poisson_ratio, depth))
    names = ("along the major axis", "along the minor axis", "normal to the surface")
    for stress, name, colour in zip(stresses, names, (0, 5, 2), strict=True):
        axis.plot(1e6 * depth, 1e-9 * stress, color=BALL_COLOURS[colour], linewidth=2.0, label=name)
    shear = 0.5 * (stresses.max(axis=0) - stresses.min(axis=0))
    axis.plot(1e6 * depth, 1e-9 * shear, color=STYLE["ink"], linewidth=2.2, linestyle="--", label="greatest shear")
    greatest = 1e6 * result["max_shear_depth_m"], 1e-9 * result["max_shear_pa"]
    axis.plot(*greatest, marker="o", color=STYLE["ink"])
    axis.set_xlabel("depth below the centre [µm]")
    axis.set_ylabel("stress [GPa]")
    axis.legend(frameon=False, loc="lower right")
    heading(axis, f"Stress below the centre: shear {greatest[1]:.3g} GPa at {greatest[0]:.3g} µm")


def _draw_laws(axis, result):
    style_axes(axis)
    ratios = np.geomspace(1e-3, 1.0, 241)
    # What the user measured has no error; hertz_exact is what the others are measured against.
    errors = {name: [] for name in COMPARED if not LAWS[name].measured and name != "hertz_exact"}
    frozen = result["constant_frozen_at_axis_ratio"]
    for ratio in ratios:
        gap = Gap(1.0, float(curvature_ratio(ratio)), 1.0)
        results = laws_at(gap, 1.0, 1e-6, frozen)
        for name in errors:
            errors[name].append(max(abs(results[name].error), LEAST_SHOWN))
    for number, (name, error) in enumerate(errors.items()):
        axis.loglog(ratios, error, **ball_style(number), linewidth=2.0, label=name)
    axis.axvline(result["axis_ratio"], color=STYLE["ink"], linewidth=1.2, linestyle=":")
    axis.annotate(
        "this contact", (result["axis_ratio"], 0.03), xycoords=("data", "axes fraction"), rotation=90, ha="right",
        color=STYLE["ink"], xytext=(-3, 0), textcoords="offset points",
    )  # fmt: skip
    axis.set_ylim(0.5 * LEAST_SHOWN, 2.0)
    axis.set_xlabel("b/a")
    axis.set_ylabel("|error| of the load")
    axis.legend(frameon=False, loc="center left")
    heading(axis, f"Error of each law against exact Hertz (constant: exact at b/a = {frozen:.3g})")
