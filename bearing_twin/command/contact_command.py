"""The subcommand `contact`: a Hertz calculator. Imports are late, so that --help is quick."""

import argparse
import math

from bearing_twin.base.errors import SceneError
from bearing_twin.base.units import UNITS, Limits
from bearing_twin.command.outcome import Outcome, Subcommand, picture_path, quantity
from bearing_twin.command.terminal import show_paragraph, show_rows, show_text

BODY_GROUP = "bodies, in one of three ways"
MATERIAL_GROUP = "materials: one value for both bodies, or two (default: the scene's, or steel)"
QUANTITY_GROUP = "exactly one of"
OTHER_GROUP = "others"
# option: group, unit of its number or None, name of its value, help; several values where the name ends with +
OPTIONS = {
    "--bearing": (BODY_GROUP, None, "NAME", "a bearing scene or its designation, such as 6203"),
    "--race": (BODY_GROUP, None, ("inner", "outer"), "the raceway of --bearing (default inner)"),
    "--radii-1": (BODY_GROUP, "m", "R+", "radii of body 1 [m] along x and y"),
    "--radii-2": (BODY_GROUP, "m", "R+", "of body 2; inf = flat (default)"),
    "--hollow": (BODY_GROUP, None, ("x", "y", "both"), "directions in which body 2 is concave"),
    "--angle": (BODY_GROUP, "rad", "RAD", "rotation of body 2's directions about the normal"),
    "--curvature-small": (BODY_GROUP, "1/m", "P", "gap z = P x^2 + Q y^2 [1/m]"),
    "--curvature-large": (BODY_GROUP, "1/m", "Q", "Q >= P > 0 [1/m]"),
    "--material": (MATERIAL_GROUP, None, "NAME+", "named materials"),
    "--young": (MATERIAL_GROUP, "Pa", "E+", "Young's modulus [Pa]"),
    "--poisson": (MATERIAL_GROUP, "1", "NU+", "Poisson's ratio"),
    "--yield-strength": (MATERIAL_GROUP, "Pa", "Y", "yield strength of the weaker body [Pa]"),
    "--load": (QUANTITY_GROUP, "N", "F", "normal load [N]"),
    "--approach": (QUANTITY_GROUP, "m", "H", "mutual approach [m]"),
    "--peak-pressure": (QUANTITY_GROUP, "Pa", "P0", "pressure at the centre [Pa]"),
    "--semi-major": (QUANTITY_GROUP, "m", "A", "longer semi-axis of the ellipse [m]"),
    "--semi-minor": (QUANTITY_GROUP, "m", "B", "shorter semi-axis [m]"),
    "--speed": (QUANTITY_GROUP, "m/s", "V", "speed of an elastic impact [m/s], with --mass"),
    "--mass": (OTHER_GROUP, "kg", "M", "m1 m2/(m1 + m2) of the impact [kg]"),
    "--restitution": (OTHER_GROUP, "1", "E", "with --speed: the damping that gives it, by several formulas"),
    "--frozen-at": (OTHER_GROUP, "1", "RATIO", "b/a at which the law constant is exact (1)"),
    "--stiffness": (OTHER_GROUP, "N/m", "K", "of the law linear [N/m] (default: the slope of exact Hertz here)"),
    "--plot": (OTHER_GROUP, None, "PNG", "draw ellipse, pressure, stress below and the laws' errors"),
}  # fmt: skip
ROUNDING = 1e-9  # of a load: exact Hertz is taken to 1e-10
QUANTITIES = [name for name, (group, *_) in OPTIONS.items() if group == QUANTITY_GROUP]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `contact` to its parser."""
    groups = {
        title: parser.add_argument_group(title) for title in (BODY_GROUP, MATERIAL_GROUP, QUANTITY_GROUP, OTHER_GROUP)
    }
    for name, (group, unit, value, text) in OPTIONS.items():
        positive = group == QUANTITY_GROUP or name in ("--mass", "--yield-strength")
        limits = Limits(above=0.0, greatest=UNITS[unit].greatest) if positive else None
        form = {"type": quantity(unit, limits)} if unit else {}
        form |= {"metavar": value.rstrip("+")} if isinstance(value, str) else {"choices": value}
        form |= {"nargs": "+"} if value[-1] == "+" else {}
        groups[group].add_argument(name, help=text, **form)


def _run(arguments: argparse.Namespace) -> Outcome:
    """Solve one contact; raises SceneError for arguments that make no contact."""
    from bearing_twin.contact import calculator, validity
    from bearing_twin.contact.materials import effective_modulus

    picture = picture_path(arguments.plot)
    gap, scene_bodies = _gap(arguments)
    first, second = _materials(arguments, scene_bodies)
    modulus = effective_modulus(first, second)
    name, value = _given_quantity(arguments)
    impact_values, flags = {}, []
    if name == "speed":
        contact, duration = calculator.impact(gap, modulus, value, arguments.mass)
        size = 2.0 * gap.least_radius
        impact_values = {"contact_duration_s": duration, **_damping(arguments.restitution, value)}
        slowest = min((first, second), key=lambda body: body.young_modulus / body.density)
        flags = validity.gathered(
            validity.wave_warning(duration, validity.wave_transit(size, slowest.young_modulus, slowest.density))
            if math.isfinite(size)
            else None
        )
    else:
        contact = calculator.solve(gap, modulus, "normal_load" if name == "load" else name, value)
    strength = _yield_strength(arguments, (first, second))
    frozen_at = 1.0 if arguments.frozen_at is None else arguments.frozen_at
    result = calculator.answer(gap, first, second, contact, strength, frozen_at, arguments.stiffness)
    result["flags"] += flags
    result |= impact_values
    if picture:
        from bearing_twin.contact.picture import plot_contact

        result["plot"] = str(plot_contact(result, first.poisson_ratio, picture))
    return Outcome(result, result["flags"], lambda: _show(result))


CONTACT = Subcommand(
    "one Hertzian contact: load, approach, ellipse, pressure, shear, and a comparison of all laws",
    _add_arguments,
    _run,
    (
        "bearing_twin contact --bearing 6203 --race inner --load 50",
        "bearing_twin contact --radii-1 0.01 --load 100 --plot contact.png",
        "bearing_twin contact --radii-1 0.01 --speed 1 --mass 0.03 --restitution 0.8",
    ),
)


def _value(arguments, option: str):
    return getattr(arguments, option[2:].replace("-", "_"))


def _gap(arguments):
    """The gap, and the materials of a bearing's ball and ring where there is one."""
    from bearing_twin.contact import calculator

    curvatures = arguments.curvature_small, arguments.curvature_large
    definitions = [arguments.bearing is not None, arguments.radii_1 is not None, curvatures != (None, None)]
    if sum(definitions) != 1:
        raise SceneError("say the bodies in one way: --bearing, or --radii-1, or --curvature-small with -large")
    only = {"--bearing": ("--race",), "--radii-1": ("--radii-2", "--hollow", "--angle")}
    for definition, options in only.items():
        for option in options:
            if _value(arguments, definition) is None and _value(arguments, option) is not None:
                raise SceneError(f"{option} goes with {definition}; leave one of the two out")
    if arguments.bearing is not None:
        return _raceway(arguments.bearing, arguments.race or "inner")
    if None not in curvatures:
        return calculator.gap_of_curvatures(*curvatures), None
    if arguments.radii_1 is None:
        raise SceneError("a gap has two curvatures; give both --curvature-small and --curvature-large")
    hollow = arguments.hollow in ("x", "both"), arguments.hollow in ("y", "both")
    first, second = _pair(arguments.radii_1, "--radii-1"), _pair(arguments.radii_2 or [math.inf], "--radii-2")
    return calculator.gap_of_radii(first, second, arguments.angle or 0.0, hollow), None


def _raceway(name, race):
    from bearing_twin.contact.calculator import gap_in_groove
    from bearing_twin.run.scene import load_scene, require_bearing, scene_names

    scene = require_bearing(load_scene(f"bearing_{name}" if f"bearing_{name}" in scene_names() else name))
    geometry, materials = scene.parameters.geometry, scene.parameters.materials
    side, conformity, ring = {
        "inner": (-1.0, geometry.inner_conformity, materials.inner_ring),
        "outer": (1.0, geometry.outer_conformity, materials.outer_ring),
    }[race]
    return gap_in_groove(geometry.ball_diameter, geometry.pitch_diameter, conformity, side), (materials.ball, ring)


def _materials(arguments, bodies):
    """The two materials: the scene's or steel, or those named, with moduli and ratios given replaced."""
    from bearing_twin.base.errors import echo, legal_hint
    from bearing_twin.base.parameters import plain, read_strict
    from bearing_twin.contact.materials import MATERIALS, Material

    bodies = bodies or (MATERIALS["steel"],) * 2
    if arguments.material:
        names = _pair(arguments.material, "--material")
        for name in names:
            if name not in MATERIALS:
                raise SceneError(f"--material {echo(name)} is not known; {legal_hint(name, MATERIALS)}")
        bodies = tuple(MATERIALS[name] for name in names)
    values = [plain(body) for body in bodies]
    for key, entries in (("young_modulus", arguments.young), ("poisson_ratio", arguments.poisson)):
        for body, value in zip(values, _pair(entries, key) if entries else (), strict=False):
            body[key] = value
    return tuple(read_strict(Material, body, f"body {number}") for number, body in enumerate(values, start=1))


def _yield_strength(arguments, bodies):
    if arguments.yield_strength is not None:
        return arguments.yield_strength
    known = [body.yield_strength for body in bodies if body.yield_strength > 0.0]
    return min(known, default=None)


def _pair(values, name):
    if len(values) > 2:
        raise SceneError(f"{name} has {len(values)} values; give one for both, or two")
    return (values[0], values[-1])


def _given_quantity(arguments):
    values = {option: value for option in QUANTITIES if (value := _value(arguments, option)) is not None}
    if len(values) != 1:
        raise SceneError(f"give exactly one of {', '.join(QUANTITIES)}")
    if ("--speed" in values) != (arguments.mass is not None):
        raise SceneError("--speed and --mass belong together: an impact needs both")
    if arguments.restitution is not None and "--speed" not in values:
        raise SceneError("--restitution goes with --speed and --mass: give these, or leave it out")
    [(option, value)] = values.items()
    return option[2:].replace("-", "_"), value


def _damping(restitution, speed):
    """Hunt and Crossley's damping for a restitution at this speed, exactly and by the usual formulas."""
    from bearing_twin.contact.laws import shortcuts

    if restitution is None:
        return {}
    formulas = shortcuts(restitution, speed)
    return {
        "damping": {
            name: {"damping_s_per_m": formula.damping, "restitution": formula.restitution}
            for name, formula in formulas.items()
        }
    }


def _show(result):
    """The result as tables."""
    from bearing_twin.command.results import show_quantities

    show_quantities({key: value for key, value in result.items() if isinstance(value, (float, str))})
    _show_laws(result["laws"])
    if "damping" in result:
        rows = ((name, *(f"{number:.6g}" for number in row.values())) for name, row in result["damping"].items())
        show_rows(("formula", "damping [s/m]", "restitution at this speed"), rows)
    show_paragraph(
        f"constant: its coefficient is exact for b/a = {result['constant_frozen_at_axis_ratio']:g} at equal sqrt(PQ) "
        "(--frozen-at); linear: the slope of exact Hertz here, or --stiffness; hertz_differential and "
        "hertz_unprojected: integrated from a circular contact to this one"
    )


def _show_laws(laws):
    rows = []
    for name, row in laws.items():
        load, error = row["normal_load_n"], row["error"]
        if not math.isfinite(load):  # of a law carried too far without projection
            rows.append((name, "diverges", "-"))
            continue
        shown = "-" if error is None else f"{100 * error if abs(error) > ROUNDING else 0.0:+.2g}"
        rows.append((name, f"{load:.5g}", shown))
    show_text()
    show_rows(("law", "load at this approach [N]", "error [%]"), rows)
