"""The subcommand `bearing`: one bearing in equilibrium under loads. Imports are late, so that --help is quick."""

import argparse
import math

from bearing_twin.base.errors import SceneError
from bearing_twin.base.units import Limits
from bearing_twin.command import bearing_table
from bearing_twin.command.outcome import (
    Outcome,
    add_changes,
    new_path,
    number,
    overrides_of,
    picture_path,
)
from bearing_twin.command.terminal import progress

HELP = "a bearing in equilibrium under load: displacement, loads, stiffness, ratings, life, fault frequencies"
EXAMPLES = (
    "bearing_twin bearing --list",
    "bearing_twin bearing 6308 --load 0,-3kN,0",
    "bearing_twin bearing bearing_6203 --displacement 0,-1e-5,0 --json",
    "bearing_twin bearing 6308 --load 0,-1,0 --sweep load=100:5000:20 --plot c.png",
    "bearing_twin bearing 6308/C3 --load 0,-2kN,0 --mass 20kg --out sheet.html",
    "bearing_twin bearing 6308 --load 0,-1,0 --sweep load=1kN:5kN:5 --out k.csv",
)
SHORT_KEYS = {"clearance": "geometry.radial_clearance", "speed": "drive.speed"}
MOST_VALUES = 10_000
VECTORS = {  # option: names of its numbers, unit, an example
    "load": (("FX", "FY", "FZ"), "N", "0,-3000,0"),
    "moment": (("MX", "MY"), "N m", "5,0"),
    "displacement": (("X", "Y", "Z"), "m", "0,-1e-5,0"),
    "misalignment": (("TX", "TY"), "rad", "1e-3,0"),
}
WORDS = {
    "load": "force on the inner ring [N, or with units, as 0,-2kN,500N]; x and y are radial, z is the axis; - leaves a "
    "coordinate to --displacement",
    "moment": "moment on the inner ring about x and y [N m]",
    "displacement": "hold the ring's centre there [m, or as 0,-10um,0]; - leaves a coordinate to --load",
    "misalignment": "hold the ring's tilt about x and y there [rad]; without it and --moment: 0",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `bearing` to its parser."""
    parser.add_argument(
        "scene",
        nargs="?",
        help="designation, such as 6308 or 6308-2RS/C3 (see --list), name of a bearing scene or path of a YAML file",
    )
    parser.add_argument("--list", action="store_true", help="list the catalogue, and how each ball set was found")
    parser.add_argument(
        "--catalogue", metavar="FILE", help="add the bearings of this YAML file to the catalogue, for this command"
    )
    add_changes(parser, "change one key of the scene; may be repeated")
    parser.add_argument("--speed", metavar="W", help="of the inner ring [rad/s, or as 3000rpm]; drive.speed")
    parser.add_argument(
        "--clearance", metavar="C", help="radial clearance as made [m, or as 20um]; geometry.radial_clearance"
    )
    for name, (names, *_) in VECTORS.items():
        parser.add_argument(f"--{name}", metavar=",".join(names), help=WORDS[name])
    parser.add_argument(
        "--arm", choices=("groove", "pitch"), default="groove", help="arm of a tilt: groove centre, or pitch circle"
    )
    parser.add_argument(
        "--control",
        choices=("auto", "outer", "inner", "shared", "settled"),
        help="raceway control of the balls, auto = by Harris' criterion (settled, of earlier versions: shared)",
    )
    parser.add_argument("--ball-angle", metavar="DEG", help="azimuth of ball 0 from +x (default: on the load line)")
    parser.add_argument("--mass", metavar="M", help="natural frequencies of a mass on the ring [kg] at this stiffness")
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


def run(arguments: argparse.Namespace) -> Outcome:
    """One equilibrium, or a sweep of them; raises BearingTwinError with a sentence for what has none."""
    from bearing_twin.kinds.bearing import add_file

    if arguments.catalogue is not None:
        add_file(arguments.catalogue)
    if arguments.csv and arguments.json:
        raise SceneError("--csv and --json are two forms of one result; give one of them")
    if arguments.list:
        return bearing_table.listed_catalogue()
    if arguments.scene is None:
        raise SceneError("which bearing? give a designation, such as 6308, or a scene; --list lists the designations")
    picture = picture_path(arguments.plot) if arguments.plot else None
    out = new_path(arguments.out, (".html", ".htm", ".csv"), "sheet") if arguments.out else None
    table = out if out and out.suffix.lower() == ".csv" else None
    sheet = out if out != table else None
    given = {name: _vector(name, getattr(arguments, name)) for name in VECTORS}
    text = arguments.ball_angle
    turned = None if text is None else number("--ball-angle", text.removesuffix("deg").removesuffix("°"))
    angle = None if turned is None else math.radians(math.fmod(turned, 360.0))
    sweeps = [_sweep(one) for one in arguments.sweep or ()]
    if len(sweeps) > 1:
        raise SceneError("--sweep is given once; bearing_twin.equilibrium() in Python takes arrays of several keys")

    swept = (f"{SHORT_KEYS.get(key, key)}={last}" for key, _, last, _ in sweeps)
    bearing_table.note_bare_numbers(_bearing_scene(arguments), [*overrides_of(arguments, **SHORT_KEYS), *swept])
    result, show = None, bearing_table.show_row
    if not (sweeps or picture or sheet or arguments.mass):
        result = _row_alone(arguments, given)
    if result is None:
        with progress("solving"):
            result = (_swept if sweeps else _solved)(arguments, given, angle, *sweeps)
        show = bearing_table.show_sweep if sweeps else bearing_table.show_equilibrium
    if picture or sheet:
        from bearing_twin.kinds.bearing import draw_equilibrium, draw_sweep

        draw = draw_sweep if sweeps else draw_equilibrium
        if picture:
            result["plot"] = str(draw(result, picture))
        if sheet:
            result["out"] = str(bearing_table.write_sheet(result, show, draw, sheet))
    if table:
        table.write_text(bearing_table.csv_of(result), encoding="utf-8")
        result["out"] = str(table)
    if arguments.csv:
        return Outcome(result, result.get("flags", []), lambda: bearing_table.show_csv(result))
    return Outcome(result, result.get("flags", []), lambda: show(result), True)


def _vector(name: str, text: str | None) -> list[float | None] | None:
    """The numbers of an option, None for a `-`; None where it is not given."""
    from bearing_twin.base.parameters import echo

    if text is None:
        return None
    names, unit, such = VECTORS[name]
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != len(names):
        raise SceneError(
            f"--{name} {echo(text)} must be {len(names)} numbers in {unit}, as {','.join(names)}, such as {such}; "
            "x and y are radial, z is the bearing's axis"
        )
    return [None if part == "-" else number(f"--{name}", part, unit) for part in parts]


def _support(given: dict, parameters):
    """Held coordinates and loads of the ring, by the options, or by the scene where there is none."""
    from bearing_twin.kinds.bearing import Support, support_of

    if all(values is None for values in given.values()):
        return support_of(parameters)
    free, loads, held = [], [], []
    for load, place in (("load", "displacement"), ("moment", "misalignment")):
        count = len(VECTORS[load][0])
        pushed, kept = (given[name] or [None] * count for name in (load, place))
        tilts_rest = load == "moment" and given[load] is None and given[place] is None
        for i in range(count):
            if pushed[i] is not None and kept[i] is not None:
                axis = VECTORS[load][0][i], VECTORS[place][0][i]
                raise SceneError(f"{axis[0]} of --{load} and {axis[1]} of --{place} are both given; leave one out by -")
            free.append(kept[i] is None and not tilts_rest)
            loads.append(pushed[i] or 0.0)
            held.append(kept[i] or 0.0)
    return Support(tuple(free), tuple(loads), tuple(held))


def _bearing_scene(arguments, overrides=()):
    from bearing_twin.run.scene import load_scene

    control = [f"model.control={arguments.control}"] if arguments.control else []
    changed = overrides_of(arguments, **SHORT_KEYS)
    scene = load_scene(arguments.scene, [*changed, *control, *overrides])
    if scene.kind != "bearing":
        raise SceneError(f"scene {scene.name} is no bearing but a {scene.kind}; give a scene of kind bearing")
    return scene


def _row(parameters) -> str:
    """The designation of a bearing whose geometry is that of the catalogue, empty for another."""
    from bearing_twin.kinds.bearing import entries

    name = parameters.geometry.designation
    return name if name in entries() else ""


def _row_alone(arguments, given) -> dict | None:
    """The row of the catalogue for a bearing with clearance and without load: no ball touches both rings."""
    parameters = _bearing_scene(arguments).parameters
    support, name = _support(given, parameters), _row(parameters)
    if not name or any(support.loads) or any(support.held):
        return None
    from bearing_twin.kinds.bearing import catalogue_sheet, operating_geometry

    if operating_geometry(parameters).radial_clearance < 0.0:
        return None
    return catalogue_sheet(name, parameters)


def _solved(arguments, given, angle, overrides=(), factor=None) -> dict:
    """One equilibrium; `factor` multiplies the loads."""
    from bearing_twin.kinds.bearing import (
        answer_of,
        control_reason,
        controlled,
        frequency_errors,
        load_line,
        natural_frequencies,
        row_of,
        solver_of,
    )
    from bearing_twin.run.scene import choose

    scene = _bearing_scene(arguments, overrides)
    parameters, law = scene.parameters, choose(scene).law
    support = _support(given, parameters)
    if factor is not None:
        support = support._replace(loads=tuple(factor * value for value in support.loads))
    first = load_line(support) if angle is None else angle
    solver = solver_of(parameters, law, first, arguments.arm)
    found = controlled(parameters, solver, support)
    head = {"scene": scene.name, "law": law, "arm": arguments.arm, "control": found.control}
    head["control_reason"] = control_reason(parameters, found)
    if catalogued := _row(parameters):
        head["catalogue"] = row_of(catalogued)
        head["fault_frequencies_hz_error"] = frequency_errors(catalogued, parameters)
    head["speed_rad_s"] = parameters.drive.speed
    found_values = answer_of(parameters, law, solver, support, found)
    if arguments.mass is not None:
        mass = number("--mass", arguments.mass, "kg", Limits(above=0.0))
        found_values |= natural_frequencies(found.stiffness, mass, support.free[3:])
    if scene.outside:
        head["outside_range"] = list(scene.outside)
        found_values["flags"] = [*scene.outside, *found_values["flags"]]
    return head | found_values


def _sweep(text: str) -> tuple[str, str, str, int]:
    """Key, first and last value as text, and how many, of KEY=FROM:TO:N."""
    from bearing_twin.base.parameters import echo

    key, equals, rest = text.partition("=")
    parts = rest.split(":")
    if not equals or not key.strip() or len(parts) != 3:
        raise SceneError(f"--sweep {echo(text)} must look like load=100:2000:20, a key with first, last and how many")
    count = number("--sweep", parts[2])
    if count != int(count) or not 2 <= count <= MOST_VALUES:
        raise SceneError(f"--sweep {echo(text)} must have 2 to {MOST_VALUES} values; give their number after TO:")
    return key.strip(), parts[0].strip(), parts[1].strip(), int(count)


def _evenly(first: str, last: str, count: int, unit: str) -> list[float]:
    """The values of a sweep in SI; those without a unit are in SI."""
    begin, end = (number("--sweep", text, unit) for text in (first, last))
    return [begin + (end - begin) / (count - 1) * k for k in range(count)]


def _swept(arguments, given, angle, sweep) -> dict:
    """Curves over a sweep, with how its axis is shown."""
    from bearing_twin.base.units import with_unit
    from bearing_twin.kinds.bearing import curves_of

    path, unit, axis, values, change = _changes(arguments, given, sweep)

    def solved(value):
        return _solved(arguments, given, angle, **change(value))

    curves = curves_of(values, solved)
    first = next(k for k, one in enumerate(curves["stiffness"]) if one is not None)
    head = {name: solved(values[first])[name] for name in ("scene", "law", "arm", "control")}
    flags = [f"{path} {one['value']:g}{with_unit(unit)}: {one['reason']}" for one in curves["refused"][:1]]
    return head | {"sweep": path, "values": values, "axis": axis} | curves | {"flags": flags}


def _changes(arguments, given, sweep) -> tuple:
    """Path, unit, axis and values of a sweep, and what a value changes, as arguments of `_solved`."""
    from bearing_twin.run.scene import gives

    key, first_value, last_value, count = sweep
    scene = _bearing_scene(arguments)
    if key == "load":
        size = math.dist(_support(given, scene.parameters).loads[:3], (0.0,) * 3)
        if size == 0.0:
            raise SceneError("--sweep load=... changes the size of a load; give its direction by --load")
        values, axis = _evenly(first_value, last_value, count, "N"), {"label": "load [N]", "scale": 1.0}
        return key, "N", axis, values, lambda value: {"factor": value / size}
    path = SHORT_KEYS.get(key, key)
    if gives(overrides_of(arguments, **SHORT_KEYS), path):
        raise SceneError(f"{path} is given by --sweep and by another option; keep one of them")
    unit = _unit_of(scene, path)
    values = _evenly(first_value, last_value, count, unit)
    return path, unit, _axis_of(path, unit, values), values, lambda value: {"overrides": (f"{path}={value!r}",)}


def _unit_of(scene, path: str) -> str:
    """The unit of a number of a scene; raises SceneError for another key."""
    from bearing_twin.base.parameters import describe, echo, unknown
    from bearing_twin.kinds import KINDS

    rows = {row.key: row for row in describe(KINDS[scene.kind].parameters) if row.type == "number"}
    if path not in rows:
        raise SceneError(
            f"--sweep {echo(path)} is no number of a {scene.kind}; {unknown(path, ['load', *SHORT_KEYS, *rows])}"
        )
    return rows[path].unit


def _axis_of(path: str, unit: str, values) -> dict:
    """Label of the axis of a sweep over a key, with its unit, and the factor into that unit."""
    from bearing_twin.base.units import UNITS, for_people, labelled

    shown, scale = for_people(max(map(abs, values)), UNITS[unit or "1"])
    return {"label": labelled(path, shown), "scale": scale}
