"""Results of `bearing_twin bearing` as text of 80 columns in engineering units, as a sheet and as CSV."""

import base64
import contextlib
import csv
import html
import io
import math
import tempfile
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

from bearing_twin.base.units import UNITS
from bearing_twin.command import catalogue_table
from bearing_twin.command.catalogue_table import kilonewtons, limiting
from bearing_twin.command.terminal import show_text
from bearing_twin.kinds.bearing import BASE_VISCOSITY, TORQUE_SCATTER, hours_of

L10 = "L10 lives: 90 % of bearings survive them, under the assumptions of the standards."
HELD_MOMENT = 1e-3  # N m: what holds tilts is named from there on
STEP = math.radians(0.01)  # of a tilt, for which its stiffness is shown
_DEGREE, _MOMENT, _PRESSURE = (UNITS[symbol].people[1] for symbol in ("rad", "N m", "Pa"))
PARTS = {
    "initial": "as made",
    "shaft_fit": "fit on shaft",
    "housing_fit": "fit in housing",
    "temperature": "temperature",
}


def show_equilibrium(result: dict) -> None:
    """Prints one equilibrium."""
    speed = result["speed_rad_s"] * 30.0 / math.pi
    show_text(f"{result['scene']}   law {result['law']}   {speed:.5g} rpm   arm of tilts {result['arm']}")
    if speed:
        show_text(textwrap.fill(f"raceway control: {result['control']}, {result['control_reason']}", 80))
    if "catalogue" in result:
        show_text(catalogue_table.summary(result["catalogue"]))
    show_text()
    show_text(f"{'inner ring':<22}" + "".join(f"{name:>11}" for name in ("x", "y", "z", "about x", "about y")))
    moved = [1e6 * one for one in result["ring_displacement_m"]]
    _row("displacement", "µm, °", moved, result["misalignment_rad"], _DEGREE)
    _row("load", "N, N mm", [0.0 - one for one in result["ring_force_n"]], result["ring_moment_nm"], -_MOMENT)
    if not any(result["misalignment_rad"]) and max(map(abs, result["ring_moment_nm"])) > HELD_MOMENT:
        show_text("tilts are held, by these moments; --moment MX,MY [N m] frees them")
    show_text("stiffness: load [N, N mm] for 1 µm or 0.01° more along")
    rises = (1.0, 1.0, 1.0, _MOMENT, _MOMENT)
    for name, row, rise in zip(("x", "y", "z", "about x", "about y"), result["stiffness"], rises, strict=True):
        steps = (1e-6, 1e-6, 1e-6, STEP, STEP)
        cells = (rise * one * step for one, step in zip(row, steps, strict=True))
        show_text(f"  {name:<20}" + "".join(f"{_short(one):>11}" for one in cells))
    _balls(result)
    _lives(result)


def _row(name, units, lengths, turns, scale, show=None):
    cells, show = [*lengths, *(0.0 + scale * one for one in turns)], show or _short
    show_text(f"{name:<13}{units:<9}" + "".join(f"{show(one):>11}" for one in cells))


def _rounded(error):
    """An error in two digits."""
    return _short(float(f"{error:.2g}"), 8)


def _short(value, room=10):
    """At most `room` (8 or more) characters, so that columns wider than that stay apart; no power of ten up to 1e7."""
    if 99999.5 <= abs(value) < 1e7:
        return f"{value:.0f}"
    shown = "0" if abs(value) < 1e-9 else f"{value:.5g}"
    return next((one for one in (shown, f"{value:.4g}", f"{value:.2g}") if len(one) <= room), shown)


def _balls(result):
    show_text()
    show_text(f"{'ball':>4}{'azimuth':>9}{'load [N]':>18}{'angle [°]':>15}{'pressure [MPa]':>16}{'inner a x b':>17}")
    show_text(f"{'':>4}{'[°]':>9}{'inner':>9}{'outer':>9}{'inner':>8}{'outer':>7}{'inner':>8}{'outer':>8}{'[mm]':>17}")
    for k, azimuth in enumerate(result["ball_azimuth_rad"]):
        load = [result[f"normal_load_{race}_n"][k] for race in ("inner", "outer")]
        angle = [math.degrees(result[f"contact_angle_{race}_rad"][k]) for race in ("inner", "outer")]
        pressure = [_PRESSURE * result[f"peak_pressure_{race}_pa"][k] for race in ("inner", "outer")]
        size = [1e3 * result[f"semi_{axis}_inner_m"][k] for axis in ("major", "minor")]
        degrees = 180.0 - (180.0 - math.degrees(azimuth)) % 360.0
        show_text(
            f"{k:>4}{degrees:>9.2f}{_short(load[0], 8):>9}{_short(load[1], 8):>9}{angle[0]:>8.3f}{angle[1]:>7.3f}"
            f"{pressure[0]:>8.1f}{pressure[1]:>8.1f}{size[0]:>9.4f}{size[1]:>8.4f}"
        )
    _model_errors(result)


SOURCES = {
    "law": "elastic law",
    "half_space": "half-spaces",
    "first_order_tilt": "tilt of first order",
}

ROUNDING = 1e-9  # of the greatest load: the law is exact Hertz, whose integrals are taken to 1e-10


def _model_errors(result):
    """One line a source: what it makes of the greatest load, the greatest angle and the place of the ring."""
    lines = []
    for source, words in SOURCES.items():
        off = result["model_errors"].get(source)
        if not off or (source == "law" and off["normal_load_n"] <= ROUNDING * max(result["normal_load_outer_n"])):
            continue
        load, angle = _rounded(off["normal_load_n"]), _rounded(_DEGREE * off["contact_angle_rad"])
        moved = _rounded(1e6 * math.hypot(*off["ring_displacement_m"]))
        lines.append(f"  {words:<21}load of a ball ± {load} N, angle ± {angle}°, ring ± {moved} µm")
    if lines:
        show_text("\nerrors of the model (the equilibrium is solved to rounding)")
        show_text("\n".join(lines))


def _lives(result):
    parts = result["clearance_m"]
    shown = [f"{words} {1e6 * parts[key]:+.4g}" for key, words in PARTS.items() if parts[key] or key == "initial"]
    dynamic, static = (kilonewtons(result[f"basic_{kind}_rating_n"]) for kind in ("dynamic", "static"))
    basic, reference = (_life(result[f"{name}_life_mrev"], result) for name in ("basic", "reference"))
    loads = (_short(result[f"equivalent_{kind}_load_n"]) for kind in ("dynamic", "static"))
    rows = {
        "clearance": f"{1e6 * parts['operating']:.4g} µm ({', '.join(shown)})",
        "rating": f"C {dynamic}, C0 {static}",
        "equivalent load": "P {} N, P0 {} N".format(*loads),
        "basic life": f"{basic} (ISO 281)",
        "reference life": f"{reference} (ISO/TS 16281)\n{L10}",
        "static safety": _finite(result["static_safety"]),
        "friction torque": _friction(result),
        "limiting speed": limiting(limits) if (limits := result["limiting_speed_rad_s"]) else "",
    }
    if "mass_kg" in result:
        pairs = zip(result["natural_frequencies_hz"], result["natural_directions"], strict=True)
        cells = (f"{one:.4g} along ({', '.join(f'{part:.2g}' for part in way)})" for one, way in pairs)
        rows["natural frequencies"] = f"of {result['mass_kg']:g} kg [Hz]: {', '.join(cells)}"
    show_text()
    catalogue_table.show_named(rows | {"fault frequencies [Hz]": catalogue_table.frequencies(result)})


def _friction(result) -> str:
    """The friction torque by parts, or the catalogue's estimate, in words; "" where there is neither."""
    torques = result.get("friction_torque_nm")
    if not torques:
        torque = result["catalogue_drive_torque_nm"]
        if torque is None:
            return ""
        shown = " ± ".join(_rounded(_MOMENT * part * torque) for part in (1.0, TORQUE_SCATTER))
        return f"{shown} N mm\nby Palmgren, with grease of {1e6 * BASE_VISCOSITY:g} mm²/s and no seals"
    parts = {name: one and _short(float(f"{_MOMENT * one:.3g}")) for name, one in torques.items()}
    cells = ", ".join(f"{name} {parts[name]}" for name in ("film", "hysteresis", "slip"))
    shown = [f"{name} {parts[key]} N mm" for key, name in (("skf", "SKF"), ("palmgren", "Palmgren")) if parts[key]]
    return "\n".join(
        (
            f"{parts['total']} ± {_rounded(_MOMENT * TORQUE_SCATTER * torques['total'])} N mm ({cells})",
            f"{result['friction_loss_w']:.3g} W lost; by {', by '.join(shown)}",
            f"thinnest film {1e6 * result['film_m']:.3g} µm, {result['lambda']:.3g} of the roughness",
            result["friction_note"],
        )
    )


def _finite(value):
    return f"{value:.4g}" if math.isfinite(value) else "without limit"


def _life(turns, result):
    if not math.isfinite(turns):
        return "without limit"
    speed = result["speed_rad_s"]
    hours = f", {_short(hours_of(turns, speed))} h" if speed else ""
    return f"{_short(turns)} million turns{hours}"


def show_sweep(result: dict) -> None:
    """Prints the curves of a sweep, one line a value."""
    show_text(f"{result['scene']}   law {result['law']}   arm of tilts {result['arm']}   over {result['sweep']}\n")
    head = result["axis"]["label"].rpartition("[")[2].rstrip("]")
    show_text(f"{head:>10}{'displacement [µm]':>24}{'stiffness [N/µm]':>24}{'ball':>8}{'life':>10}")
    show_text(f"{'':>10}{'x':>8}{'y':>8}{'z':>8}{'x':>8}{'y':>8}{'z':>8}{'[N]':>8}{'[1e6]':>10}")
    for k, value in enumerate(result["values"]):
        shown = f"{_short(result['axis']['scale'] * value):>10}"
        if result["stiffness"][k] is None:
            show_text(f"{shown}   no equilibrium")
            continue
        moved = "".join(f"{_tiny(1e6 * one):>8}" for one in result["ring_displacement_m"][k])
        stiff = "".join(f"{_tiny(1e-6 * result['stiffness'][k][i][i]):>8}" for i in range(3))
        life = result["reference_life_mrev"][k]
        show_text(f"{shown}{moved}{stiff}{_tiny(result['greatest_normal_load_inner_n'][k]):>8}{_tiny(life):>10}")
    show_text(textwrap.fill(L10, 80))


def show_crossed(result: dict) -> None:
    """Prints a sweep at each value of another one."""
    label, scale = result["axis"]["label"], result["axis"]["scale"]
    for value, one in zip(result["values"], result["curves"], strict=True):
        if one is None:
            show_text(f"\n{label} {_short(scale * value)}: no equilibrium\n")
            continue
        show_text(f"\n{label} {_short(scale * value)}")
        show_sweep(one)


def _tiny(value):
    if not math.isfinite(value):
        return "none"
    return "0" if abs(value) < 1e-6 else _short(float(f"{value:.4g}"))


def write_sheet(result: dict, show: Callable, draw: Callable, path: Path) -> Path:
    """Writes a page with the table that `show` prints, the picture of `draw`, and what is doubtful; one new file."""
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        show(result)
    with tempfile.TemporaryDirectory() as folder:
        picture = base64.b64encode(Path(draw(result, Path(folder) / "sheet.png")).read_bytes()).decode()
    title = html.escape(f"Bearing {result['scene']}")
    doubts = "".join(f"<li>{html.escape(one)}</li>" for one in result.get("flags", []))
    with path.open("w", encoding="utf-8") as stream:
        stream.write(
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
            f'<body style="font-family: sans-serif; max-width: 62rem; margin: 2rem auto"><h1>{title}</h1>'
            f"<pre>{html.escape(shown.getvalue())}</pre>"
            f"{f'<h2>Doubtful</h2><ul>{doubts}</ul>' if doubts else ''}"
            f'<img alt="{title}" style="width: 100%" src="data:image/png;base64,{picture}"></body></html>\n'
        )
    return path


ASIDE = "values", "flags", "refused"  # lists of a sweep that are no curves


def show_csv(result: dict) -> None:
    """Prints a result as `csv_of` gives it."""
    show_text(csv_of(result).rstrip("\n"))


def csv_of(result: dict) -> str:
    """A result in SI units: of sweeps a row a value, else a row a number, named by its key in the JSON."""
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    if "sweep" in result:
        rows = _rows(result)
        names = dict.fromkeys(name for row in rows for name in row)
        table.writerow(names)
        table.writerows([row.get(name, "") for name in names] for row in rows)
    else:
        table.writerow(["quantity", "value"])
        table.writerows(_numbers("", result))
    return out.getvalue()


def _rows(result: dict) -> list[dict]:
    """The rows of a sweep, or of those at each value of another one."""
    key, values = result["sweep"], result["values"]
    if "curves" in result:
        pairs = zip(values, result["curves"], strict=True)
        return [{key: value} | row for value, one in pairs for row in (_rows(one) if one else [{}])]
    curves = [name for name, one in result.items() if isinstance(one, list) and len(one) == len(values)]
    return [
        {key: value}
        | {name: one for curve in curves if curve not in ASIDE for name, one in _numbers(curve, result[curve][place])}
        for place, value in enumerate(values)
    ]


def _numbers(key: str, value) -> Iterator[tuple[str, object]]:
    """(name, number or text) of all that a result holds: `ring_displacement_m[1]`, `clearance_m.operating`."""
    if isinstance(value, dict):
        for name, one in value.items():
            yield from _numbers(f"{key}.{name}" if key else name, one)
    elif isinstance(value, (list, tuple)):
        for place, one in enumerate(value):
            yield from _numbers(f"{key}[{place}]", one)
    elif value is not None:
        yield key, value
