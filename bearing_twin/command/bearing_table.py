"""Bearings and their equilibria as text in engineering units, as a sheet and as CSV. Imports of kinds are late."""

import base64
import contextlib
import csv
import html
import io
import math
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from bearing_twin.base.parameters import NUMBER
from bearing_twin.base.units import UNITS, known_digits, two_digits
from bearing_twin.command.outcome import Outcome
from bearing_twin.command.terminal import say, show_columns, show_named, show_paragraph, show_text

L10 = "L10 lives: 90 % of bearings survive them, under the assumptions of the standards."
HELD_MOMENT = 1e-3  # N m: what holds tilts is named from there on
STEP = math.radians(0.01)  # of a tilt, for which its stiffness is shown
DEGREE, MOMENT, PRESSURE = (UNITS[symbol].people[1] for symbol in ("rad", "N m", "Pa"))
AXES = ("x", "y", "z", "about x", "about y")
RACES = ("inner", "outer")
PARTS = {
    "initial": "as made",
    "shaft_fit": "fit on shaft",
    "housing_fit": "fit in housing",
    "temperature": "temperature",
}
SOURCES = {
    "law": "elastic law",
    "half_space": "half-spaces",
    "first_order_tilt": "tilt of first order",
}
COLD = 173.15  # K: a temperature below it is noted
ROUNDING = 1e-9  # of the greatest load: the law is exact Hertz, whose integrals are taken to 1e-10


def short(value: float, digits: int = 4) -> str:
    """So many digits, without a power of ten up to 1e7; 0 where it is rounding."""
    return "0" if abs(value) < 1e-9 else known_digits(value, None, digits)


def listed_catalogue() -> Outcome:
    """Every designation with its row, and what the ways are in which ball sets were found."""
    from bearing_twin.base.paths import own_folder
    from bearing_twin.kinds.bearing import FOUND, designations, row_of

    rows, folder = [row_of(name) for name in designations()], str(own_folder("bearings"))

    def show() -> None:
        header = ("", "bore\n[mm]", "outside\n[mm]", "width\n[mm]", "balls\n ", "of\n[mm]", "±\n[mm]")
        sizes = ("bore_m", "outside_diameter_m", "width_m")
        cells = (
            (
                row["designation"],
                *(_millimetres(row[key]) for key in sizes),
                _balls_of(row),
                *(_millimetres(row[f"ball_diameter{end}_m"]) for end in ("", "_doubt")),
                _range(row["published_dynamic_rating_n"], 1e-3),
                row["found"],
            )
            for row in rows
        )
        show_columns((*header, "published\nC [kN]", "found\n "), cells)
        show_text()
        for name, number in sorted(Counter(row["found"] for row in rows).items()):
            show_paragraph(f"{name} ({number} of {len(rows)}): {FOUND[name]}")
        show_text(f"\nyour own bearings: --catalogue FILE, or YAML files in\n{folder}")

    return Outcome({"bearings": rows, "found": FOUND, "own_folder": folder}, [], show)


def show_row(result: dict) -> None:
    """Prints one row of the catalogue with its ratings."""
    sizes = " x ".join(_millimetres(result[f"{key}_m"]) for key in ("bore", "outside_diameter", "width"))
    error, clearance = result["pitch_diameter_doubt_m"], result["radial_clearance_m"]
    show_text(f"{_ball_set(result)}\n")
    show_named(
        {
            "bore, outside, width": f"{sizes} mm (ISO 15)",
            "pitch diameter": _millimetres(result["pitch_diameter_m"], error) + " mm",
            "groove radius / ball": f"inner {result['inner_conformity']:g}, outer {result['outer_conformity']:g}",
            "radial clearance": _clearance(clearance) if clearance else "",
            "contact angle": f"{math.degrees(result['contact_angle_rad']):.4g}°" if result["contact_angle_rad"] else "",
            "dynamic rating C": f"{_rating(result, 'dynamic', 'ISO 281')}; SKF's are 4 to 6 % above the standard",
            "static rating C0": _rating(result, "static", "ISO 76"),
            "limiting speed": limiting(result["limiting_speed_rad_s"]) if result["limiting_speed_rad_s"] else "",
            "fault frequencies": f"{_frequencies(result)} Hz at {_rpm(result)}",
            "ball set": result["source"] or result["found_means"],
            "loads": "none; add --load FX,FY,FZ [N], x and y radial, z along the axis",
        }
    )


def show_equilibrium(result: dict) -> None:
    """Prints one equilibrium: ring, balls, lives, then what they rest on."""
    balls = _ball_set(result["catalogue"]) if "catalogue" in result else result["scene"]
    show_text(f"{balls}, {_rpm(result)}, law {result['law']}\n")
    turned, moments = result["misalignment_rad"], result["ring_moment_nm"]
    moved = [1e6 * one for one in result["ring_displacement_m"]] + [DEGREE * one for one in turned]
    loads = [0.0 - one for one in result["ring_force_n"]] + [0.0 - MOMENT * one for one in moments]
    errors = [
        factor * error
        for factor, key in ((1e6, "ring_displacement_m"), (DEGREE, "misalignment_rad"))
        for error in map(sum, zip(*(one[key] for one in result["model_errors"].values()), strict=True))
    ] or [0.0] * len(moved)
    places = (_known(one, error) for one, error in zip(moved, errors, strict=True))
    rows = [("displacement [µm, °]", *places), ("load [N, N mm]", *(short(one, 5) for one in loads))]
    rows.append(("stiffness [N, N mm]", *("",) * len(AXES)))
    for axis, column in zip(AXES, zip(*result["stiffness"], strict=True), strict=True):
        name, step = (f"  per 0.01° {axis}", STEP) if "about" in axis else (f"  per 1 µm along {axis}", 1e-6)
        units = (1.0, 1.0, 1.0, MOMENT, MOMENT)
        rows.append((name, *(short(unit * step * one) for unit, one in zip(units, column, strict=True))))
    show_columns(("inner ring", *AXES), rows)
    if not any(result["misalignment_rad"]) and max(map(abs, result["ring_moment_nm"])) > HELD_MOMENT:
        show_text("tilts are held, by these moments; --moment MX,MY [N m] frees them")
    _show_balls(result)
    _show_lives(result)
    control = f"{result['control']}, {result['control_reason']}" if result["speed_rad_s"] else ""
    show_text()
    show_named(
        {"raceway control": control, "arm of tilts": result["arm"], "errors of the model": _model_errors(result)}
    )


def _known(value: float, error: float) -> str:
    """A value to the second digit of its error; what is smaller than that keeps two digits, and rounding is 0."""
    if not error or abs(value) < error:
        return short(value, 2 if error else 4)
    return known_digits(value, error, 4)


def _show_balls(result: dict) -> None:
    show_text()
    off = sum(one["normal_load_n"] for one in result["model_errors"].values())
    header, columns = ["ball", "azimuth\n\n[°]"], [range(len(result["ball_azimuth_rad"]))]
    columns.append([f"{180.0 - (180.0 - math.degrees(one)) % 360.0:.2f}" for one in result["ball_azimuth_rad"]])
    for words, unit, key, show in (
        ("load", "N", "normal_load_{}_n", lambda one: _known(one, off)),
        ("angle", "°", "contact_angle_{}_rad", lambda one: f"{math.degrees(one):.3f}"),
        ("p max", "MPa", "peak_pressure_{}_pa", lambda one: f"{PRESSURE * one:.0f}"),
    ):
        header += [f"{words}\n{race}\n[{unit}]" for race in RACES]
        columns += [map(show, result[key.format(race)]) for race in RACES]
    header += [f"ellipse\n{axis} inner\n[mm]" for axis in ("a", "b")]
    columns += [[f"{1e3 * one:.3f}" for one in result[f"semi_{axis}_inner_m"]] for axis in ("major", "minor")]
    show_columns(header, zip(*columns, strict=True))


def _model_errors(result: dict) -> str:
    """One line a source: what it makes of the greatest load, the greatest angle and the place of the ring."""
    lines = []
    for source, words in SOURCES.items():
        off = result["model_errors"].get(source)
        if not off or (source == "law" and off["normal_load_n"] <= ROUNDING * max(result["normal_load_outer_n"])):
            continue
        load, angle = two_digits(off["normal_load_n"]), two_digits(DEGREE * off["contact_angle_rad"])
        moved = two_digits(1e6 * math.hypot(*off["ring_displacement_m"]))
        lines.append(f"{words}: load of a ball ± {load} N, angle ± {angle}°, ring ± {moved} µm")
    return "\n".join(lines)


def _show_lives(result: dict) -> None:
    parts, safety = result["clearance_m"], result["static_safety"]
    shown = [f"{words} {1e6 * parts[key]:+.4g}" for key, words in PARTS.items() if parts[key]]
    dynamic, static = (f"{1e-3 * result[f'basic_{kind}_rating_n']:.4g} kN" for kind in ("dynamic", "static"))
    loads = (short(result[f"equivalent_{kind}_load_n"]) for kind in ("dynamic", "static"))
    angle = result.get("catalogue", {}).get("contact_angle_rad")
    rows = {
        "contact angle": f"{DEGREE * angle:.4g}° without load" if angle else "",
        "clearance": f"{short(1e6 * parts['operating'])} µm" + (f" ({', '.join(shown)})" if shown[1:] else " as made"),
        "rating": f"C {dynamic}, C0 {static}",
        "equivalent load": "P {} N, P0 {} N".format(*loads),
        "basic life": f"{_life(result, 'basic')} (ISO 281)",
        "reference life": f"{_life(result, 'reference')} (ISO/TS 16281)\n{L10}",
        "static safety": short(safety, 3) if math.isfinite(safety) else "without limit",
        "friction torque": _friction(result),
        "limiting speed": limiting(limits) if (limits := result["limiting_speed_rad_s"]) else "",
    }
    if "mass_kg" in result:
        pairs = zip(result["natural_frequencies_hz"], result["natural_directions"], strict=True)
        cells = (f"{one:.4g} along ({', '.join(f'{part:.2g}' for part in way)})" for one, way in pairs)
        rows["natural frequencies"] = f"of {result['mass_kg']:g} kg [Hz]: {', '.join(cells)}"
    show_text()
    show_named(rows | {"fault frequencies [Hz]": _frequencies(result)})


def _friction(result: dict) -> str:
    """The friction torque by parts, or the catalogue's estimate, in words; "" where there is neither."""
    from bearing_twin.kinds.bearing import BASE_VISCOSITY

    torques, estimate = result.get("friction_torque_nm"), result.get("catalogue_drive_torque_nm")
    if not torques:
        grease = f"by Palmgren, with grease of {1e6 * BASE_VISCOSITY:g} mm²/s and no seals"
        return "" if estimate is None else f"{_scattered(estimate)}\n{grease}"
    parts = {name: one and short(MOMENT * one, 2) for name, one in torques.items()}
    cells = ", ".join(f"{name} {parts[name]}" for name in ("film", "hysteresis", "slip"))
    shown = [f"{name} {parts[key]} N mm" for key, name in (("skf", "SKF"), ("palmgren", "Palmgren")) if parts[key]]
    return "\n".join(
        (
            f"{_scattered(torques['total'])} ({cells})",
            f"{short(result['friction_loss_w'], 2)} W lost; by {', by '.join(shown)}",
            f"thinnest film {short(1e6 * result['film_m'], 2)} µm, film parameter Λ {short(result['lambda'], 2)}",
            result["friction_note"],
        )
    )


def _scattered(torque: float) -> str:
    """A friction torque [N m] with the scatter of measured ones."""
    from bearing_twin.kinds.bearing import TORQUE_SCATTER

    return f"{two_digits(MOMENT * torque)} ± {two_digits(MOMENT * TORQUE_SCATTER * torque)} N mm"


def _life(result: dict, name: str) -> str:
    from bearing_twin.kinds.bearing import hours_of

    turns, speed = result[f"{name}_life_mrev"], result["speed_rad_s"]
    if not math.isfinite(turns):
        return "without limit"
    return f"{short(turns, 3)} million turns" + (f", {short(hours_of(turns, speed), 3)} h" if speed else "")


def show_sweep(result: dict) -> None:
    """Prints the curves of a sweep, one line a value."""
    show_text(f"{result['scene']}, law {result['law']}, arm of tilts {result['arm']}, over {result['sweep']}\n")
    unit = result["axis"]["label"].rpartition("[")[2].rstrip("]")
    header = [f"{result['sweep'].rpartition('.')[2].replace('_', ' ')}\n[{unit}]"]
    header += [f"{axis}\n[µm]" for axis in AXES[:3]] + [f"stiffness {axis}\n[N/µm]" for axis in AXES[:3]]
    rows = []
    for k, value in enumerate(result["values"]):
        shown, stiffness = short(result["axis"]["scale"] * value), result["stiffness"][k]
        if stiffness is None:
            rows.append((shown, "no equilibrium", *("",) * 7))
            continue
        cells = [1e6 * one for one in result["ring_displacement_m"][k]] + [1e-6 * stiffness[i][i] for i in range(3)]
        cells += [result["greatest_normal_load_inner_n"][k], result["reference_life_mrev"][k]]
        rows.append((shown, *map(_tiny, cells)))
    show_columns((*header, "ball\n[N]", "life\n[1e6]"), rows)
    show_paragraph(L10)


def _tiny(value: float) -> str:
    if not math.isfinite(value):
        return "none"
    return "0" if abs(value) < 1e-6 else short(value)


def _rpm(result: dict) -> str:
    return f"{result['speed_rad_s'] * 30.0 / math.pi:.5g} rpm"


def _frequencies(result: dict) -> str:
    """The fault frequencies of a result [Hz] in words, with their errors."""
    errors = result.get("fault_frequencies_hz_error", {})
    return ", ".join(
        f"{name.upper() if len(name) <= 4 else name.replace('_', ' ')} {known_digits(value, errors.get(name), 5)}"
        + (f" ± {two_digits(errors[name])}" if errors.get(name) else "")
        for name, value in result["fault_frequencies_hz"].items()
    )


def _ball_set(row: dict) -> str:
    """A row's ball set and how sure it is."""
    size = _millimetres(row["ball_diameter_m"], row["ball_diameter_doubt_m"])
    return f"{row['designation']}: {_balls_of(row)} balls of {size} mm"


def _balls_of(row: dict) -> str:
    return f"{row['balls']}" + (f" ± {row['balls_doubt']}" if row["balls_doubt"] else "")


def _clearance(pair) -> str:
    """The range of a row as made, of a group or a specified clearance its middle."""
    return f"{_range(pair, 1e6)} µm as made" + ("; the middle is taken" if pair[0] != pair[1] else "")


def _millimetres(value, error: float = 0.0) -> str:
    if value is None:
        return "-"
    return known_digits(1e3 * value, 1e3 * error, 5) + (f" ± {two_digits(1e3 * error)}" if error else "")


def _range(pair, scale: float) -> str:
    return "-".join(dict.fromkeys(f"{scale * one:.4g}" for one in pair)) if pair else "-"


def _rating(result: dict, name: str, standard: str) -> str:
    published = result[f"published_{name}_rating_n"]
    beside = f"; published {_range(published, 1e-3)} kN" if published else ""
    return f"{1e-3 * result[f'basic_{name}_rating_n']:.4g} kN by {standard}{beside}"


def limiting(speeds: dict[str, float]) -> str:
    """Limiting speeds [rad/s] by lubrication, with their source."""
    from bearing_twin.kinds.bearing import LIMITING, LIMITING_SCATTER

    shown = ", ".join(f"{name} {float(f'{one * 30.0 / math.pi:.2g}'):.0f}" for name, one in speeds.items())
    products = " and ".join(f"{1e-5 * one:g}e5" for one in LIMITING.values())
    return f"{shown} rpm ± {100.0 * LIMITING_SCATTER:.0f} %, estimated by n d_m = {products} mm/min (FBJ)"


def note_bare_numbers(scene, overrides: Iterable[str]) -> None:
    """Says on standard error that a speed or temperature without a unit is in SI, where that is hardly meant.

    That is a speed above a bearing's limiting speeds, and a temperature below -100 °C.
    """
    pairs = [(key.strip(), text.strip()) for one in overrides for key, _, text in [one.partition("=")]]
    for key, text in pairs:
        if key.startswith("temperature") and NUMBER.fullmatch(text) and 0.0 < float(text) < COLD:
            say(f"{key} = {text} is in K, {float(text) - 273.15:.4g} °C; if it is meant in °C, give {text}°C")
    given = [text for key, text in pairs if key == "drive.speed"]
    if scene.kind != "bearing" or not given or not NUMBER.fullmatch(given[-1]):
        return
    from bearing_twin.kinds.bearing import limiting_speeds

    speed, limits = abs(float(given[-1])), limiting_speeds(scene.parameters.geometry)
    if limits and speed > max(limits.values()):
        say(
            f"drive.speed = {given[-1]} is in rad/s, {math.degrees(speed) / 6.0:.6g} rpm, above the limiting speeds "
            f"({limiting(limits)}); if it is meant in rpm, give {given[-1]}rpm"
        )


def write_sheet(result: dict, show: Callable, draw: Callable, path: Path) -> Path:
    """Writes a page with the table that `show` prints, the picture of `draw`, and its warnings; one new file."""
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        show(result)
    with tempfile.TemporaryDirectory() as folder:
        picture = base64.b64encode(Path(draw(result, Path(folder) / "sheet.png")).read_bytes()).decode()
    title = html.escape(f"Bearing {result['scene']}")
    warnings = "".join(f"<li>{html.escape(one)}</li>" for one in result.get("flags", []))
    with path.open("w", encoding="utf-8") as stream:
        stream.write(
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
            f'<body style="font-family: sans-serif; max-width: 62rem; margin: 2rem auto"><h1>{title}</h1>'
            f"<pre>{html.escape(shown.getvalue())}</pre>"
            f"{f'<h2>Warnings</h2><ul>{warnings}</ul>' if warnings else ''}"
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
    """The rows of a sweep."""
    key, values = result["sweep"], result["values"]
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
