"""The subcommand `bearing`: one bearing in equilibrium under loads, as text in engineering units, a sheet and CSV.

Imports of kinds are late, so that --help is quick.
"""

import argparse
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

from bearing_twin.base.errors import SceneError, echo, legal_hint
from bearing_twin.base.parameters import NUMBER, describe
from bearing_twin.base.paths import user_folder
from bearing_twin.base.units import UNITS, Limits, axis_label, readable_unit, rounded_to_error, two_digits, with_unit
from bearing_twin.command.outcome import (
    Outcome,
    Subcommand,
    add_changes,
    new_path,
    number,
    overrides_of,
    picture_path,
    quantity,
)
from bearing_twin.command.terminal import progress, say, show_columns, show_pairs, show_paragraph, show_text

SHORT_KEYS = {"clearance": "geometry.radial_clearance", "speed": "drive.speed"}
MOST_VALUES = 10_000
UNNAMED_SECTIONS = ("geometry", "drive", "materials")  # of a scene: their keys are clear without
LOAD_HELP = (
    "force on the inner ring [N, or with units, as 0,-2kN,500N]; x and y are radial, z is the axis; - leaves a "
    "coordinate to --displacement"
)
PLACE_HELP = "hold the ring's centre there [m, or as 0,-10um,0]; - leaves a coordinate to --load"
TILT_HELP = "hold the ring's tilt about x and y there [rad]; without it and --moment: 0"
VECTORS = {  # option: names of its numbers, unit, an example, help
    "load": (("FX", "FY", "FZ"), "N", "0,-3000,0", LOAD_HELP),
    "moment": (("MX", "MY"), "N m", "5,0", "moment on the inner ring about x and y [N m]"),
    "displacement": (("X", "Y", "Z"), "m", "0,-1e-5,0", PLACE_HELP),
    "misalignment": (("TX", "TY"), "rad", "1e-3,0", TILT_HELP),
}


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `bearing` to its parser."""
    parser.add_argument(
        "scene",
        nargs="?",
        help="designation, such as 6308 or 6308-2RS/C3 (see --list), name of a bearing scene or path of a YAML file",
    )
    parser.add_argument("--list", action="store_true", help="list the catalogue, with the origin of each ball set")
    parser.add_argument(
        "--catalogue", metavar="FILE", help="add the bearings of this YAML file to the catalogue, for this command"
    )
    add_changes(parser, "change one key of the scene; may be repeated")
    parser.add_argument("--speed", metavar="W", help="of the inner ring [rad/s, or as 3000rpm]; drive.speed")
    parser.add_argument(
        "--clearance", metavar="C", help="radial clearance before mounting [m, or as 20um]; geometry.radial_clearance"
    )
    for name, (names, _, _, text) in VECTORS.items():
        parser.add_argument(f"--{name}", metavar=",".join(names), help=text)
    parser.add_argument(
        "--arm", choices=("groove", "pitch"), default="groove", help="arm of a tilt: groove centre, or pitch circle"
    )
    parser.add_argument(
        "--control",
        choices=("auto", "outer", "inner", "shared", "settled"),
        help="raceway control of the balls, auto = by Harris' criterion (settled, of earlier versions: shared)",
    )
    parser.add_argument("--ball-angle", metavar="DEG", help="azimuth of ball 0 from +x (default: on the load line)")
    mass = quantity("kg", Limits(above=0.0))
    parser.add_argument(
        "--mass", type=mass, metavar="M", help="natural frequencies of a mass on the ring [kg] at this stiffness"
    )
    parser.add_argument(
        "--sweep",
        action="append",
        metavar="KEY=FROM:TO:N",
        help="curves over N values of load, clearance, speed or a scene's key, as clearance=0:40um:21",
    )
    parser.add_argument("--plot", metavar="PNG", help="draw the loads around the bearing, or the curves of --sweep")
    parser.add_argument(
        "--out",
        metavar="FILE",
        help="write a sheet (.html) with result and picture, or the table of --csv (.csv)",
    )
    parser.add_argument("--csv", action="store_true", help="print the result as comma-separated values, in SI units")


def _run(arguments: argparse.Namespace) -> Outcome:
    """One equilibrium, or a sweep of them; raises BearingTwinError with a sentence for what has none."""
    from bearing_twin.kinds.bearing.catalogue import add_file

    if arguments.catalogue is not None:
        add_file(arguments.catalogue)
    if arguments.csv and arguments.json:
        raise SceneError("--csv and --json are two forms of one result; give one of them")
    if arguments.list:
        return list_catalogue()
    if arguments.scene is None:
        raise SceneError("which bearing? give a designation, such as 6308, or a scene; --list lists the designations")
    picture = picture_path(arguments.plot)
    out = new_path(arguments.out, (".html", ".htm", ".csv"), "sheet")
    table = out if out and out.suffix.lower() == ".csv" else None
    sheet = out if out != table else None
    support_options = {name: _vector(name, getattr(arguments, name)) for name in VECTORS}
    text = arguments.ball_angle
    degrees = None if text is None else number("--ball-angle", text.removesuffix("deg").removesuffix("°"))
    angle = None if degrees is None else math.radians(math.fmod(degrees, 360.0))
    sweeps = [_sweep(sweep_text) for sweep_text in arguments.sweep or ()]
    if len(sweeps) > 1:
        raise SceneError("--sweep is given once; bearing_twin.equilibrium() in Python takes arrays of several keys")

    swept = (f"{SHORT_KEYS.get(key, key)}={last}" for key, _, last, _ in sweeps)
    note_bare_speed(_bearing_scene(arguments), [*overrides_of(arguments, **SHORT_KEYS), *swept])
    result, show = None, show_row
    if not (sweeps or picture or sheet or arguments.mass):
        result = _catalogue_only(arguments, support_options)
    if result is None:
        with progress("solving"):
            result = (_solve_sweep if sweeps else _solve)(arguments, support_options, angle, *sweeps)
        show = show_sweep if sweeps else show_equilibrium
    if picture or sheet:
        from bearing_twin.kinds.bearing.picture import draw_equilibrium, draw_sweep

        draw = draw_sweep if sweeps else draw_equilibrium
        if picture:
            result["plot"] = str(draw(result, picture))
        if sheet:
            result["out"] = str(write_sheet(result, show, draw, sheet))
    if table:
        table.write_text(csv_of(result), encoding="utf-8")
        result["out"] = str(table)
    if arguments.csv:
        return Outcome(result, result.get("flags", []), lambda: show_text(csv_of(result).rstrip("\n")))
    return Outcome(result, result.get("flags", []), lambda: show(result), True)


BEARING = Subcommand(
    "a bearing in equilibrium under load: displacement, loads, stiffness, ratings, life, fault frequencies",
    _add_arguments,
    _run,
    (
        "bearing_twin bearing --list",
        "bearing_twin bearing 6308 --load 0,-3kN,0",
        "bearing_twin bearing bearing_6203 --displacement 0,-1e-5,0 --json",
        "bearing_twin bearing 6308 --load 0,-1,0 --sweep load=100:5000:20 --plot c.png",
        "bearing_twin bearing 6308/C3 --load 0,-2kN,0 --mass 20kg --out sheet.html",
        "bearing_twin bearing 6308 --load 0,-1,0 --sweep load=1kN:5kN:5 --out k.csv",
    ),
)


def _vector(name: str, text: str | None) -> list[float | None] | None:
    """The numbers of an option, None for a `-`; None where it is not given."""
    if text is None:
        return None
    names, unit, example, _ = VECTORS[name]
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != len(names):
        raise SceneError(
            f"--{name} {echo(text)} must be {len(names)} numbers in {unit}, as {','.join(names)}, such as {example}; "
            "x and y are radial, z is the bearing's axis"
        )
    limits = Limits(greatest=UNITS[unit].greatest)
    return [None if part == "-" else number(f"--{name}", part, unit, limits) for part in parts]


def _support(options: dict, parameters):
    """Held coordinates and loads of the ring, by the options, or by the scene where there is none."""
    from bearing_twin.kinds.bearing.equilibrium import Support, support_of

    if all(values is None for values in options.values()):
        return support_of(parameters)
    free, loads, held = [], [], []
    for load, hold in (("load", "displacement"), ("moment", "misalignment")):
        count = len(VECTORS[load][0])
        pushed, held_at = (options[name] or [None] * count for name in (load, hold))
        tilts_held = load == "moment" and options[load] is None and options[hold] is None
        for i in range(count):
            if pushed[i] is not None and held_at[i] is not None:
                axis = VECTORS[load][0][i], VECTORS[hold][0][i]
                raise SceneError(f"{axis[0]} of --{load} and {axis[1]} of --{hold} are both given; leave one out by -")
            free.append(held_at[i] is None and not tilts_held)
            loads.append(pushed[i] or 0.0)
            held.append(held_at[i] or 0.0)
    return Support(tuple(free), tuple(loads), tuple(held))


def _bearing_scene(arguments, overrides=()):
    from bearing_twin.run.scene import load_scene, require_bearing

    changed = overrides_of(arguments, control="model.control", **SHORT_KEYS)
    return require_bearing(load_scene(arguments.scene, [*changed, *overrides]))


def _catalogue_name(parameters) -> str:
    """The designation of a bearing whose geometry is that of the catalogue, empty for another."""
    from bearing_twin.kinds.bearing.catalogue import entries

    name = parameters.geometry.designation
    return name if name in entries() else ""


def _catalogue_only(arguments, options) -> dict | None:
    """The row of the catalogue for a bearing with clearance and without load: no ball touches both rings."""
    parameters = _bearing_scene(arguments).parameters
    support, name = _support(options, parameters), _catalogue_name(parameters)
    if not name or any(support.loads) or any(support.held):
        return None
    from bearing_twin.kinds.bearing.geometry import operating_geometry
    from bearing_twin.kinds.bearing.ratings import catalogue_sheet

    if operating_geometry(parameters).radial_clearance < 0.0:
        return None
    return catalogue_sheet(parameters)


def _solve(arguments, options, angle, overrides=(), factor=None) -> dict:
    """One equilibrium; `factor` multiplies the loads."""
    from bearing_twin.kinds.bearing.equilibrium import control_reason, controlled_equilibrium, load_line, solver_of
    from bearing_twin.kinds.bearing.equilibrium_report import answer_of, natural_frequencies
    from bearing_twin.kinds.bearing.ratings import frequency_errors, row_in_use
    from bearing_twin.run.scene import choose

    scene = _bearing_scene(arguments, overrides)
    parameters, law = scene.parameters, choose(scene).law
    support = _support(options, parameters)
    if factor is not None:
        support = support._replace(loads=tuple(factor * value for value in support.loads))
    ball_angle = load_line(support) if angle is None else angle
    solver = solver_of(parameters, law, ball_angle, arguments.arm)
    solution = controlled_equilibrium(parameters, solver, support)
    head = {"scene": scene.name, "law": law, "arm": arguments.arm, "control": solution.control}
    head["control_reason"] = control_reason(parameters, solution)
    if _catalogue_name(parameters):
        head["catalogue"] = row_in_use(parameters)
        head["fault_frequencies_hz_error"] = frequency_errors(head["catalogue"], parameters)
    head["speed_rad_s"] = parameters.drive.speed
    values = answer_of(parameters, law, solver, support, solution)
    if arguments.mass is not None:
        values |= natural_frequencies(solution.stiffness, arguments.mass, support.free[3:])
    if scene.outside:
        head["outside_range"] = list(scene.outside)
        values["flags"] = [*scene.outside, *values["flags"]]
    return head | values


def _sweep(text: str) -> tuple[str, str, str, int]:
    """Key, first and last value as text, and how many, of KEY=FROM:TO:N."""
    key, equals, span = text.partition("=")
    parts = span.split(":")
    if not equals or not key.strip() or len(parts) != 3:
        raise SceneError(f"--sweep {echo(text)} must look like load=100:2000:20, a key with first, last and how many")
    count = number("--sweep", parts[2])
    if count != int(count) or not 2 <= count <= MOST_VALUES:
        raise SceneError(f"--sweep {echo(text)} must have 2 to {MOST_VALUES} values; give their number after TO:")
    return key.strip(), parts[0].strip(), parts[1].strip(), int(count)


def _linspace(first: str, last: str, count: int, unit: str) -> list[float]:
    """The values of a sweep in SI; those without a unit are in SI."""
    start, end = (number("--sweep", text, unit) for text in (first, last))
    return [start + (end - start) / (count - 1) * k for k in range(count)]


def _solve_sweep(arguments, options, angle, sweep) -> dict:
    """Curves over a sweep, with how its axis is shown."""
    from bearing_twin.kinds.bearing.equilibrium_report import curves_of

    path, axis, values, change = _changes(arguments, options, sweep)

    head, flagged = {}, []

    def solve(value):
        result = _solve(arguments, options, angle, **change(value))
        head.update({name: result[name] for name in ("scene", "law", "arm", "control") if name not in head})
        if result["flags"]:
            flagged.append((value, result["flags"]))
        return result

    curves = curves_of(values, solve)
    flags = [f"{_labelled_value(axis, row['value'])}: {row['reason']}" for row in curves["refused"][:1]]
    if flagged:
        value, listed = max(reversed(flagged), key=lambda item: len(item[1]))
        others = f", one of {len(flagged)} values with warnings" if flagged[1:] else ""
        flags += [f"{_labelled_value(axis, value)}{others}: {flag}" for flag in listed]
    held = _conditions(_bearing_scene(arguments).parameters, options, path)
    return head | {"sweep": path, "held": held, "values": values, "axis": axis} | curves | {"flags": flags}


def _conditions(parameters, options, path: str) -> str:
    """Load and speed that a sweep over the key `path` holds constant, in words."""
    loads = _support(options, parameters).loads[:3]
    load = f"load ({', '.join(map(short, loads))}) N" if any(loads) else ""
    conditions = {"load": load, "drive.speed": f"{parameters.drive.speed * 30.0 / math.pi:.5g} rpm"}
    return ", ".join(text for key, text in conditions.items() if text and key != path)


def _labelled_value(axis: dict, value: float) -> str:
    label, _, unit = axis["label"].rstrip("]").partition(" [")
    return f"{label} {short(axis['scale'] * value)}{with_unit(unit)}"


def _changes(arguments, options, sweep) -> tuple:
    """Path, axis and values of a sweep, and what a value changes, as arguments of `_solve`."""
    from bearing_twin.run.scene import has_override

    key, first_value, last_value, count = sweep
    scene = _bearing_scene(arguments)
    if key == "load":
        size = math.dist(_support(options, scene.parameters).loads[:3], (0.0,) * 3)
        if size == 0.0:
            raise SceneError("--sweep load=... changes the size of a load; give its direction by --load")
        values, axis = _linspace(first_value, last_value, count, "N"), {"label": "load [N]", "scale": 1.0}
        return key, axis, values, lambda value: {"factor": value / size}
    path = SHORT_KEYS.get(key, key)
    if has_override(overrides_of(arguments, **SHORT_KEYS), path):
        raise SceneError(f"{path} is given by --sweep and by another option; keep one of them")
    unit = _unit_of(scene, path)
    values = _linspace(first_value, last_value, count, unit)
    return path, _axis_of(path, unit, values), values, lambda value: {"overrides": (f"{path}={value!r}",)}


def _unit_of(scene, path: str) -> str:
    """The unit of a number of a scene; raises SceneError for another key."""
    from bearing_twin.kinds import KINDS

    rows = {row.key: row for row in describe(KINDS[scene.kind].parameters) if row.type == "number"}
    if path not in rows:
        raise SceneError(
            f"--sweep {echo(path)} is no number of a {scene.kind}; {legal_hint(path, ['load', *SHORT_KEYS, *rows])}"
        )
    return rows[path].unit


def _axis_of(path: str, unit: str, values) -> dict:
    """Label of the axis of a sweep over a key, with its unit, and the factor into that unit."""
    shown, scale = readable_unit(unit or "1", max(map(abs, values)))
    section, _, name = path.partition(".")
    words = (name if section in UNNAMED_SECTIONS else path).replace(".", " ").replace("_", " ")
    return {"label": axis_label(words, shown), "scale": scale}


L10 = "L10 lives: 90 % of bearings survive them, under the assumptions of the standards."
HELD_MOMENT = 1e-3  # N m: what holds tilts is named from there on
STEP = math.radians(0.01)  # of a tilt, for which its stiffness is shown
DEGREE, MOMENT, PRESSURE = (UNITS[symbol].engineering[1] for symbol in ("rad", "N m", "Pa"))
AXES = ("x", "y", "z", "about x", "about y")
RACES = ("inner", "outer")
CLEARANCE_PARTS = {
    "initial": "as made",
    "shaft_fit": "fit on shaft",
    "housing_fit": "fit in housing",
    "temperature": "temperature",
}
MODEL_SOURCES = {
    "law": "elastic law",
    "half_space": "half-space assumption",
    "first_order_tilt": "first-order tilt",
}
ROUNDING = 1e-9  # of the greatest load: the law is exact Hertz, whose integrals are taken to 1e-10


def short(value: float, digits: int = 4) -> str:
    """So many digits, without a power of ten up to 1e7; 0 where it is rounding."""
    if not math.isfinite(value):
        return "without limit"
    return "0" if abs(value) < 1e-9 else rounded_to_error(value, None, digits)


def list_catalogue() -> Outcome:
    """Every designation with its row, and what the ways are in which ball sets were found."""
    from bearing_twin.kinds.bearing.catalogue import FOUND, designations, row_of

    rows, folder = [row_of(name) for name in designations()], str(user_folder("bearings"))

    def show() -> None:
        header = ("", "bore\n[mm]", "outside\n[mm]", "width\n[mm]", "balls\n ", "of\n[mm]", "±\n[mm]")
        sizes = ("bore_m", "outside_diameter_m", "width_m")
        cells = (
            (
                row["designation"],
                *(_millimetres(row[key]) for key in sizes),
                _balls_of(row),
                *(_millimetres(row[f"ball_diameter{suffix}_m"]) for suffix in ("", "_doubt")),
                _range(row["published_dynamic_rating_n"], 1e-3),
                row["found"],
            )
            for row in rows
        )
        show_columns((*header, "published\nC [kN]", "found\n "), cells)
        show_text()
        for name, count in sorted(Counter(row["found"] for row in rows).items()):
            show_paragraph(f"{name} ({count} of {len(rows)}): {FOUND[name]}")
        show_text(f"\nyour own bearings: --catalogue FILE, or YAML files in\n{folder}")

    return Outcome({"bearings": rows, "found": FOUND, "own_folder": folder}, [], show)


def show_row(result: dict) -> None:
    """Print one row of the catalogue with its ratings."""
    sizes = " x ".join(_millimetres(result[f"{key}_m"]) for key in ("bore", "outside_diameter", "width"))
    error, clearance = result["pitch_diameter_doubt_m"], result["radial_clearance_m"]
    show_text(f"{_ball_set(result)}\n")
    show_pairs(
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
        }.items()
    )


def show_equilibrium(result: dict) -> None:
    """Print one equilibrium: ring, balls, lives, then models and their errors."""
    balls = _ball_set(result["catalogue"]) if "catalogue" in result else result["scene"]
    show_text(f"{balls}, {_rpm(result)}, law {result['law']}\n")
    tilts, moments = result["misalignment_rad"], result["ring_moment_nm"]
    coordinates = [1e6 * shift for shift in result["ring_displacement_m"]] + [DEGREE * tilt for tilt in tilts]
    loads = [0.0 - force for force in result["ring_force_n"]] + [0.0 - MOMENT * moment for moment in moments]
    errors = [
        factor * error
        for factor, key in ((1e6, "ring_displacement_m"), (DEGREE, "misalignment_rad"))
        for error in map(sum, zip(*(errors[key] for errors in result["model_errors"].values()), strict=True))
    ] or [0.0] * len(coordinates)
    cells = (_to_error(coordinate, error) for coordinate, error in zip(coordinates, errors, strict=True))
    rows = [("displacement [µm, °]", *cells), ("load [N, N mm]", *(short(load, 5) for load in loads))]
    rows.append(("stiffness [N, N mm]", *("",) * len(AXES)))
    for axis, column in zip(AXES, zip(*result["stiffness"], strict=True), strict=True):
        name, step = (f"  per 0.01° {axis}", STEP) if "about" in axis else (f"  per 1 µm along {axis}", 1e-6)
        units = (1.0, 1.0, 1.0, MOMENT, MOMENT)
        rows.append((name, *(short(unit * step * stiffness) for unit, stiffness in zip(units, column, strict=True))))
    show_columns(("inner ring", *AXES), rows)
    if not any(result["misalignment_rad"]) and max(map(abs, result["ring_moment_nm"])) > HELD_MOMENT:
        show_text("tilts are held, by these moments; --moment MX,MY [N m] frees them")
    _show_balls(result)
    _show_lives(result)
    control = f"{result['control']}, {result['control_reason']}" if result["speed_rad_s"] else ""
    show_text()
    show_pairs(
        {
            "raceway control": control,
            "arm of tilts": result["arm"],
            "errors of the model": _model_errors(result),
        }.items()
    )


def _to_error(value: float, error: float) -> str:
    """A value to the second digit of its error; what is smaller than that keeps two digits, and rounding is 0."""
    if not error or abs(value) < error:
        return short(value, 2 if error else 4)
    return rounded_to_error(value, error, 4)


def _show_balls(result: dict) -> None:
    show_text()
    load_error = sum(errors["normal_load_n"] for errors in result["model_errors"].values())
    header, columns = ["ball", "azimuth\n\n[°]"], [range(len(result["ball_azimuth_rad"]))]
    columns.append([f"{180.0 - (180.0 - math.degrees(angle)) % 360.0:.2f}" for angle in result["ball_azimuth_rad"]])
    for label, unit, key, show in (
        ("load", "N", "normal_load_{}_n", lambda load: _to_error(load, load_error)),
        ("angle", "°", "contact_angle_{}_rad", lambda angle: f"{math.degrees(angle):.3f}"),
        ("p max", "MPa", "peak_pressure_{}_pa", lambda pressure: f"{PRESSURE * pressure:.0f}"),
    ):
        header += [f"{label}\n{race}\n[{unit}]" for race in RACES]
        columns += [map(show, result[key.format(race)]) for race in RACES]
    header += [f"ellipse\n{axis} inner\n[mm]" for axis in ("a", "b")]
    columns += [[f"{1e3 * length:.3f}" for length in result[f"semi_{axis}_inner_m"]] for axis in ("major", "minor")]
    show_columns(header, zip(*columns, strict=True))


def _model_errors(result: dict) -> str:
    """One line a source: what it makes of the greatest load, the greatest angle and the place of the ring."""
    lines = []
    for source, label in MODEL_SOURCES.items():
        errors = result["model_errors"].get(source)
        if not errors or (source == "law" and errors["normal_load_n"] <= ROUNDING * max(result["normal_load_outer_n"])):
            continue
        load, angle = two_digits(errors["normal_load_n"]), two_digits(DEGREE * errors["contact_angle_rad"])
        displacement = two_digits(1e6 * math.hypot(*errors["ring_displacement_m"]))
        lines.append(f"{label}: load of a ball ± {load} N, angle ± {angle}°, ring ± {displacement} µm")
    return "\n".join(lines)


def _show_lives(result: dict) -> None:
    parts = result["clearance_m"]
    shown = [f"{label} {1e6 * parts[key]:+.4g}" for key, label in CLEARANCE_PARTS.items() if parts[key]]
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
        "static safety factor": short(result["static_safety"], 3),
        "friction torque": _friction(result),
        "limiting speed": limiting(limits) if (limits := result["limiting_speed_rad_s"]) else "",
    }
    if "mass_kg" in result:
        frequencies = zip(result["natural_frequencies_hz"], result["natural_directions"], strict=True)
        cells = (
            f"{frequency:.4g} along ({', '.join(f'{part:.2g}' for part in direction)})"
            for frequency, direction in frequencies
        )
        rows["natural frequencies"] = f"of {result['mass_kg']:g} kg [Hz]: {', '.join(cells)}"
    show_text()
    rows["fault frequencies [Hz]"] = _frequencies(result)
    show_pairs(rows.items())


def _friction(result: dict) -> str:
    """The friction torque by parts, or the catalogue's estimate, in words; "" where there is neither."""
    from bearing_twin.kinds.bearing.ratings import BASE_VISCOSITY

    torques, estimate = result.get("friction_torque_nm"), result.get("catalogue_drive_torque_nm")
    if not torques:
        grease = f"by Palmgren, with grease of {1e6 * BASE_VISCOSITY:g} mm²/s and no seals"
        return "" if estimate is None else f"{_scattered(estimate)}\n{grease}"
    shown_torques = {name: torque and short(MOMENT * torque, 2) for name, torque in torques.items()}
    cells = ", ".join(f"{name} {shown_torques[name]}" for name in ("film", "hysteresis", "slip"))
    empirical = [
        f"{name} {shown_torques[key]} N mm"
        for key, name in (("skf", "SKF"), ("palmgren", "Palmgren"))
        if shown_torques[key]
    ]
    return "\n".join(
        (
            f"{_scattered(torques['total'])} ({cells})",
            f"{short(result['friction_loss_w'], 2)} W lost; by {', by '.join(empirical)}",
            f"thinnest film {short(1e6 * result['film_m'], 2)} µm, film parameter Λ {short(result['lambda'], 2)}",
            result["friction_note"],
        )
    )


def _scattered(torque: float) -> str:
    """A friction torque [N m] with the scatter of measured ones."""
    from bearing_twin.kinds.bearing.ratings import TORQUE_SCATTER

    error = MOMENT * TORQUE_SCATTER * torque
    return f"{rounded_to_error(MOMENT * torque, error, 4)} ± {two_digits(error)} N mm"


def _life(result: dict, name: str) -> str:
    from bearing_twin.kinds.bearing.ratings import hours_of

    turns, speed = result[f"{name}_life_mrev"], result["speed_rad_s"]
    if not math.isfinite(turns):
        return short(turns)
    return f"{short(turns, 3)} million turns" + (f", {short(hours_of(turns, speed), 3)} h" if speed else "")


def show_sweep(result: dict) -> None:
    """Print the curves of a sweep, one line a value."""
    label, _, unit = result["axis"]["label"].partition(" [")
    conditions = filter(None, (result["held"], f"law {result['law']}", f"arm of tilts {result['arm']}"))
    show_paragraph(f"{result['scene']} over {label}: {', '.join(conditions)}")
    show_text()
    header = [f"{label}\n[{unit}" if unit else label]
    header += [f"{axis}\n[µm]" for axis in AXES[:3]] + [f"stiffness {axis}\n[N/µm]" for axis in AXES[:3]]
    rows, films = [], []
    for k, value in enumerate(result["values"]):
        shown, stiffness = short(result["axis"]["scale"] * value), result["stiffness"][k]
        if stiffness is None:
            rows.append((shown, "no equilibrium", *("",) * 7))
            continue
        cells = [1e6 * shift for shift in result["ring_displacement_m"][k]]
        cells += [1e-6 * stiffness[i][i] for i in range(3)]
        cells += [result["greatest_normal_load_inner_n"][k], result["reference_life_mrev"][k]]
        rows.append((shown, *map(short, cells)))
        if "friction_torque_nm" in result and (torque := result["friction_torque_nm"][k]):
            cells = MOMENT * torque["total"], 1e6 * result["film_m"][k], result["lambda"][k]
            films.append((shown, *(short(cell, 2) for cell in cells)))
    show_columns((*header, "ball\n[N]", "life\n[1e6]"), rows)
    if films:
        show_text()
        show_columns((header[0], "torque\n[N mm]", "film\n[µm]", "Λ\n"), films)
    show_paragraph(L10)


def _rpm(result: dict) -> str:
    return f"{result['speed_rad_s'] * 30.0 / math.pi:.5g} rpm"


def _frequencies(result: dict) -> str:
    """The fault frequencies of a result [Hz] in words, with their errors."""
    errors = result.get("fault_frequencies_hz_error", {})
    return ", ".join(
        f"{name.upper() if len(name) <= 4 else name.replace('_', ' ')} {rounded_to_error(value, errors.get(name), 5)}"
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
    return rounded_to_error(1e3 * value, 1e3 * error, 5) + (f" ± {two_digits(1e3 * error)}" if error else "")


def _range(pair, scale: float) -> str:
    return "-".join(dict.fromkeys(f"{scale * end:.4g}" for end in pair)) if pair else "-"


def _rating(result: dict, name: str, standard: str) -> str:
    published = result[f"published_{name}_rating_n"]
    note = f"; published {_range(published, 1e-3)} kN" if published else ""
    return f"{1e-3 * result[f'basic_{name}_rating_n']:.4g} kN by {standard}{note}"


def limiting(speeds: dict[str, float]) -> str:
    """Limiting speeds [rad/s] by lubrication, with their source."""
    from bearing_twin.kinds.bearing.ratings import LIMITING, LIMITING_SCATTER

    rounded = ", ".join(f"{name} {float(f'{speed * 30.0 / math.pi:.2g}'):.0f}" for name, speed in speeds.items())
    products = " and ".join(f"{1e-5 * product:g}e5" for product in LIMITING.values())
    return f"{rounded} rpm ± {100.0 * LIMITING_SCATTER:.0f} %, estimated by n d_m = {products} mm/min (FBJ)"


def note_bare_speed(scene, overrides: Iterable[str]) -> None:
    """Note on standard error that a speed without a unit is in rad/s, if it is above the limiting speed."""
    speeds = [
        text.strip()
        for override in overrides
        for key, _, text in [override.partition("=")]
        if key.strip() == "drive.speed"
    ]
    if scene.kind != "bearing" or not speeds or not NUMBER.fullmatch(speeds[-1]):
        return
    from bearing_twin.kinds.bearing.ratings import command_warning

    if warning := command_warning(scene.parameters, float(speeds[-1])):
        say(f"drive.speed: {warning}; if it is meant in rpm, give {speeds[-1]}rpm")


def write_sheet(result: dict, show: Callable, draw: Callable, path: Path) -> Path:
    """Write a page with the table that `show` prints, the picture of `draw`, and the warnings."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        show(result)
    with tempfile.TemporaryDirectory() as folder:
        picture = base64.b64encode(Path(draw(result, Path(folder) / "sheet.png")).read_bytes()).decode()
    title = html.escape(f"Bearing {result['scene']}")
    warnings = "".join(f"<li>{html.escape(flag)}</li>" for flag in result.get("flags", []))
    with path.open("w", encoding="utf-8") as stream:
        stream.write(
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
            f'<body style="font-family: sans-serif; max-width: 62rem; margin: 2rem auto"><h1>{title}</h1>'
            f"<pre>{html.escape(printed.getvalue())}</pre>"
            f"{f'<h2>Warnings</h2><ul>{warnings}</ul>' if warnings else ''}"
            f'<img alt="{title}" style="width: 100%" src="data:image/png;base64,{picture}"></body></html>\n'
        )
    return path


NOT_CURVES = "values", "flags", "refused"  # lists of a sweep that are no curves


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
        table.writerows(_flat_numbers("", result))
    return out.getvalue()


def _rows(result: dict) -> list[dict]:
    """The rows of a sweep."""
    key, values = result["sweep"], result["values"]
    curves = [name for name, column in result.items() if isinstance(column, list) and len(column) == len(values)]
    return [
        {key: value}
        | {
            name: item
            for curve in curves
            if curve not in NOT_CURVES
            for name, item in _flat_numbers(curve, result[curve][index])
        }
        for index, value in enumerate(values)
    ]


def _flat_numbers(key: str, value) -> Iterator[tuple[str, object]]:
    """(name, number or text) of all that a result holds: `ring_displacement_m[1]`, `clearance_m.operating`."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _flat_numbers(f"{key}.{name}" if key else name, item)
    elif isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            yield from _flat_numbers(f"{key}[{index}]", item)
    elif value is not None:
        yield key, value
