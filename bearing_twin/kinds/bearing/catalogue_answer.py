"""What a catalogue tells of a bearing: its row, how sure it is, and the ratings that follow beside those published."""

from dataclasses import replace

from bearing_twin.kinds.bearing import catalogue
from bearing_twin.kinds.bearing.quasi_static.answer import rolling_frequencies
from bearing_twin.kinds.bearing.ratings import limiting_speeds, ratings_of, speed_doubt


def row_of(name: str) -> dict:
    """The row of a designation with SI-suffixed keys; ranges are (least, greatest), None where nothing is published."""
    entry = catalogue.entries()[name]
    return {
        "designation": name,
        "bore_m": entry.bore,
        "outside_diameter_m": entry.outside_diameter,
        "width_m": entry.width or None,
        "balls": entry.balls,
        "balls_doubt": entry.balls_doubt,
        "ball_diameter_m": entry.ball_diameter,
        "ball_diameter_doubt_m": entry.ball_diameter_doubt,
        "pitch_diameter_m": entry.pitch_diameter,
        "pitch_diameter_doubt_m": entry.pitch_diameter_doubt,
        "contact_angle_rad": entry.contact_angle,
        "inner_conformity": entry.inner_conformity,
        "outer_conformity": entry.outer_conformity,
        "radial_clearance_m": None if entry.contact_angle else list(catalogue.clearance_of(entry)),
        "found": entry.found,
        "found_means": catalogue.FOUND[entry.found],
        "source": entry.source,
        "published_dynamic_rating_n": list(entry.dynamic) if entry.dynamic[1] else None,
        "published_static_rating_n": list(entry.static) if entry.static[1] else None,
    }


def frequency_errors(name: str, parameters) -> dict[str, float]:
    """By how much fault frequencies [Hz] may be wrong, as the row's pitch circle and ball diameter may be."""
    entry, geometry, speed = catalogue.entries()[name], parameters.geometry, parameters.drive.speed
    sizes = {"pitch_diameter": entry.pitch_diameter_doubt, "ball_diameter": entry.ball_diameter_doubt}
    errors = dict.fromkeys(rolling_frequencies(geometry, speed), 0.0)
    for key, doubt in sizes.items():
        ends = [replace(geometry, **{key: getattr(geometry, key) + sign * doubt}) for sign in (-1.0, 1.0)]
        low, high = (rolling_frequencies(one, speed) for one in ends)
        errors = {word: error + 0.5 * abs(high[word] - low[word]) for word, error in errors.items()}
    return errors


def answer_of(name: str, parameters) -> dict:
    """The row of a designation, and of the scene that uses it the ratings by ISO 281 and ISO 76 and fault frequencies.

    Fault frequencies are those of balls that roll without load, at the nominal contact angle.
    """
    ratings, speed, row = ratings_of(parameters), parameters.drive.speed, row_of(name)
    made, taken = row["radial_clearance_m"], parameters.geometry.radial_clearance
    if made and abs(taken - 0.5 * sum(made)) > 1e-9:
        row["radial_clearance_m"] = [taken, taken]
    return row | {
        "basic_dynamic_rating_n": ratings.dynamic,
        "basic_static_rating_n": ratings.static,
        "speed_rad_s": speed,
        "limiting_speed_rad_s": limiting_speeds(parameters.geometry),
        "fault_frequencies_hz": rolling_frequencies(parameters.geometry, speed),
        "fault_frequencies_hz_error": frequency_errors(name, parameters),
        "flags": [doubt] if (doubt := speed_doubt(parameters.geometry, speed)) else [],
    }
