"""The catalogue of bearings as text of 80 columns, in millimetres and kilonewtons."""

import math
import textwrap
from collections import Counter
from collections.abc import Iterable, Mapping

from bearing_twin.base.parameters import NUMBER
from bearing_twin.base.units import known_digits, two_digits
from bearing_twin.command.outcome import Outcome
from bearing_twin.command.terminal import say, show_text


def listed_catalogue() -> Outcome:
    """Every designation with its row, and what the ways are in which ball sets were found."""
    from bearing_twin.base.paths import own_folder
    from bearing_twin.kinds.bearing import FOUND, designations, row_of

    rows = [row_of(name) for name in designations()]
    result = {"bearings": rows, "found": FOUND, "own_folder": str(own_folder("bearings"))}
    return Outcome(result, [], lambda: _list(rows))


def _list(rows) -> None:
    from bearing_twin.base.paths import own_folder
    from bearing_twin.kinds.bearing import FOUND

    show_text(f"{'':<10}{'bore':>6}{'outside':>8}{'width':>6}  {'balls':<7}{'of':>8}{'± ':>7}{'C [kN]':>10}  found")
    show_text(f"{'':<10}{'[mm]':>6}{'[mm]':>8}{'[mm]':>6}{'':>9}{'[mm]':>8}{'[mm] ':>7}{'published':>10}")
    for row in rows:
        sizes = "".join(
            f"{_millimetres(row[f'{key}_m']):>{width}}"
            for key, width in (("bore", 6), ("outside_diameter", 8), ("width", 6))
        )
        balls = f"{row['balls']}" + (f" ± {row['balls_doubt']}" if row["balls_doubt"] else "")
        show_text(
            f"{row['designation']:<10}{sizes}  {balls:<7}{_millimetres(row['ball_diameter_m']):>8}"
            f"{_millimetres(row['ball_diameter_doubt_m']):>6} {_range(row['published_dynamic_rating_n'], 1e-3):>10}  "
            f"{row['found']}"
        )
    show_text()
    numbers = Counter(row["found"] for row in rows)
    for name, number in sorted(numbers.items()):
        show_text(textwrap.fill(f"{name} ({number} of {len(rows)}): {FOUND[name]}", 80, subsequent_indent="  "))
    show_text("\nyour own bearings: --catalogue FILE, or YAML files in")
    show_text(str(own_folder("bearings")))


def show_row(result: dict) -> None:
    """Prints one row with its ratings."""
    show_text(summary(result) + "\n")
    clearance = result["radial_clearance_m"]
    rows = {
        "bore, outside, width": " x ".join(
            _millimetres(result[f"{key}_m"]) for key in ("bore", "outside_diameter", "width")
        )
        + " mm (ISO 15)",
        "pitch diameter": _millimetres(result["pitch_diameter_m"])
        + (f" ± {_millimetres(doubt)}" if (doubt := result["pitch_diameter_doubt_m"]) else "")
        + " mm",
        "groove radius / ball": f"inner {result['inner_conformity']:g}, outer {result['outer_conformity']:g}",
        "radial clearance": _clearance(clearance) if clearance else "",
        "contact angle": f"{math.degrees(result['contact_angle_rad']):.4g}°" if result["contact_angle_rad"] else "",
        "dynamic rating C": _rating(result, "dynamic", "ISO 281") + "; SKF's are 4 to 6 % above the standard",
        "static rating C0": _rating(result, "static", "ISO 76"),
        "limiting speed": limiting(result["limiting_speed_rad_s"]) if result["limiting_speed_rad_s"] else "",
        "fault frequencies": f"{frequencies(result)} Hz at {result['speed_rad_s'] * 30.0 / math.pi:.5g} rpm\n ",
        "ball set": result["source"] or result["found_means"],
        "loads": "none given; add --load FX,FY,FZ [N]",
    }
    show_named(rows)


def show_named(rows: Mapping[str, str]) -> None:
    """Prints names and texts, those that are not empty, in 80 columns; each line of a text begins below its first."""
    for name, text in rows.items():
        for line in text.splitlines():
            show_text(textwrap.fill(f"{name:<23}{line}", 80, subsequent_indent=" " * 23).rstrip())
            name = ""


def frequencies(result: dict) -> str:
    """The fault frequencies of a result [Hz] in words, with their errors."""
    errors = result.get("fault_frequencies_hz_error", {})
    return ", ".join(
        f"{name.replace('_', ' ')} {known_digits(value, errors.get(name), 5)}"
        + (f" ± {two_digits(errors[name])}" if errors.get(name) else "")
        for name, value in result["fault_frequencies_hz"].items()
    )


def summary(row: dict) -> str:
    """One line about a row's ball set and how sure it is."""
    balls = f"{row['balls']}" + (f" ± {row['balls_doubt']}" if row["balls_doubt"] else "")
    size, doubt = (_millimetres(row[f"ball_diameter{end}_m"]) for end in ("", "_doubt"))
    return f"{row['designation']}: {balls} balls of {size}{f' ± {doubt}' if float(doubt) else ''} mm ({row['found']})"


def _clearance(pair) -> str:
    """The range of a row as made, of a group or a specified clearance its middle."""
    shown = _range(pair, 1e6)
    return f"{shown} µm as made" + ("; the middle is taken" if pair[0] != pair[1] else "")


def _millimetres(value) -> str:
    return "-" if value is None else f"{1e3 * value:.5g}"


def _range(pair, scale: float) -> str:
    if not pair:
        return "-"
    low, high = (f"{scale * one:.4g}" for one in pair)
    return low if low == high else f"{low}-{high}"


def _rating(result, name: str, standard: str) -> str:
    value, published = result[f"basic_{name}_rating_n"], result[f"published_{name}_rating_n"]
    beside = f"; published {_range(published, 1e-3)} kN" if published else ""
    return f"{kilonewtons(value)} by {standard}{beside}"


def limiting(speeds: dict[str, float]) -> str:
    """Limiting speeds [rad/s] by lubrication, with their source."""
    from bearing_twin.kinds.bearing import LIMITING, LIMITING_SCATTER

    shown = ", ".join(f"{name} {float(f'{one * 30.0 / math.pi:.2g}'):.0f}" for name, one in speeds.items())
    products = " and ".join(f"{1e-5 * one:g}e5" for one in LIMITING.values())
    return f"{shown} rpm ± {100.0 * LIMITING_SCATTER:.0f} %, estimated by n d_m = {products} mm/min (FBJ)"


def note_bare_speed(scene, overrides: Iterable[str]) -> None:
    """Says on standard error that a speed without a unit is in rad/s, where it is above a bearing's limiting speeds."""
    given = [text for one in overrides for key, _, text in [one.partition("=")] if key.strip() == "drive.speed"]
    if scene.kind != "bearing" or not given or not NUMBER.fullmatch(given[-1].strip()):
        return
    from bearing_twin.kinds.bearing import limiting_speeds

    speed, limits = abs(scene.parameters.drive.speed), limiting_speeds(scene.parameters.geometry)
    if limits and speed > max(limits.values()):
        say(
            f"drive.speed = {given[-1]} is in rad/s, {math.degrees(speed) / 6.0:.6g} rpm, above the limiting speeds "
            f"({limiting(limits)}); if it is meant in rpm, give {given[-1].strip()}rpm"
        )


def kilonewtons(value: float) -> str:
    """A rating [N] as catalogues give it."""
    return f"{1e-3 * value:.4g} kN"
