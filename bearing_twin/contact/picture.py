"""The picture of one Hertzian contact: its ellipse, pressure, stresses below the surface, and errors of the laws."""

from pathlib import Path

import numpy as np

from bearing_twin.contact.calculator import COMPARED, Gap, axis_stresses, laws_at
from bearing_twin.contact.elasticity import curvature_ratio
from bearing_twin.contact.laws import LAWS
from bearing_twin.pictures import LOAD_MAP, STYLE, Axis, Line, Map, Panel, Sheet, figure_of, line_style, save

LEAST_SHOWN = 1e-12  # of the laws' errors
INK = {"color": STYLE["ink"], "linewidth": 1.2}
MEGAPASCAL = ("MPa", 1e-6)  # and the factor into it


def plot_contact(result: dict, poisson_ratio: float, png_path) -> Path:
    """Write the picture of a `calculator.answer`; stresses are those in a body of that Poisson's ratio."""
    facts = (
        f"approach {1e6 * result['approach_m']:.4g} µm, stiffness {1e-6 * result['stiffness_n_per_m']:.4g} N/µm, "
        f"E* {1e-9 * result['effective_modulus_pa']:.4g} GPa"
    )
    title = f"Hertz contact under {result['normal_load_n']:.4g} N, b/a = {result['axis_ratio']:.3g}"
    contact = result["semi_major_m"], result["semi_minor_m"], result["peak_pressure_pa"]
    rows = [[_ellipse(*contact), _pressure(*contact)], [_stress(result, *contact, poisson_ratio), _laws(result)]]
    return save(figure_of(Sheet(title, rows, facts, [])), png_path)


def _ellipse(major: float, minor: float, peak: float) -> Panel:
    x, y = np.linspace(-major, major, 401), np.linspace(-minor, minor, 201)
    inside = 1.0 - (x / major) ** 2 - (y[:, None] / minor) ** 2
    pressure = np.where(inside >= 0.0, 1e-6 * peak * np.sqrt(np.maximum(inside, 0.0)), np.nan)
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    parts = [
        Map("pressure", "MPa", x, y, pressure, LOAD_MAP, (0.0, 1e-6 * peak)),
        Line("", major * np.cos(turn), minor * np.sin(turn), INK, False),
    ]
    title = f"Contact ellipse, {2e6 * major:.4g} × {2e6 * minor:.4g} µm"
    half_height = max(1.15 * minor, 0.6 * major)
    up = Axis("minor axis", "m", limits=(-half_height, half_height))
    return Panel(title, Axis("along the major axis", "m"), up, parts, equal_aspect=True)


def _pressure(major: float, minor: float, peak: float) -> Panel:
    share = np.sin(np.linspace(-0.5, 0.5, 201) * np.pi)
    pressure = peak * np.sqrt(1.0 - share**2)
    parts = [
        Line(f"along the {name} axis, ±{1e6 * semi_axis:.4g} µm", semi_axis * share, pressure, line_style(colour))
        for name, semi_axis, colour in (("major", major, 0), ("minor", minor, 5))
    ]
    up = Axis("pressure", "Pa", limits=(0.0, 1.3 * peak), shown=MEGAPASCAL)
    return Panel(f"Pressure along the axes, peak {1e-6 * peak:.4g} MPa", Axis("from the centre", "m"), up, parts)


def _stress(result, major: float, minor: float, peak: float, poisson_ratio: float) -> Panel:
    depth = np.linspace(0.0, 3.0 * minor, 300)
    stresses = np.array(axis_stresses(major, minor, peak, poisson_ratio, depth))
    names = "along the major axis", "along the minor axis", "normal to the surface"
    parts = [Line(*row, line_style(k)) for *row, k in zip(names, [depth] * 3, stresses, (0, 5, 2), strict=True)]
    shear = 0.5 * (stresses.max(axis=0) - stresses.min(axis=0))
    parts.append(Line("greatest shear", depth, shear, INK | {"linewidth": 2.2, "linestyle": "--"}))
    deepest, greatest = result["max_shear_depth_m"], result["max_shear_pa"]
    parts.append(Line("", [deepest], [greatest], {"color": STYLE["ink"], "marker": "o"}, False))
    title = f"Stress below the centre: shear {1e-6 * greatest:.4g} MPa at {1e6 * deepest:.3g} µm"
    up = Axis("stress", "Pa", shown=MEGAPASCAL)
    return Panel(title, Axis("depth below the centre", "m"), up, parts, "lower right")


def _laws(result) -> Panel:
    ratios, frozen = np.geomspace(1e-3, 1.0, 241), result["constant_frozen_at_axis_ratio"]
    results = [laws_at(Gap(1.0, float(curvature_ratio(ratio)), 1.0), 1.0, 1e-6, frozen) for ratio in ratios]
    # What the user measured has no error; hertz_exact is what the others are measured against.
    names = [name for name in COMPARED if not LAWS[name].measured and name != "hertz_exact"]
    parts = [
        Line(name, ratios, [max(abs(row[name].error), LEAST_SHOWN) for row in results], line_style(number))
        for number, name in enumerate(names)
    ]
    edges = 0.5 * LEAST_SHOWN, 2.0
    parts.append(Line("this contact", [result["axis_ratio"]] * 2, edges, INK | {"linestyle": ":"}))
    title = f"Error of each law against exact Hertz (constant: exact at b/a = {frozen:.3g})"
    up = Axis("|error| of the load", log=True, limits=edges)
    return Panel(title, Axis("b/a", log=True), up, parts, "center left")
