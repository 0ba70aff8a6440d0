"""The subcommand `spectrum`: what an acceleration record says of a bearing. Imports are late, so --help is quick."""

import argparse
import math
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.units import Limits
from bearing_twin.command.outcome import RUN, Outcome, Subcommand, number, picture_path, quantity
from bearing_twin.command.terminal import progress, say, show_columns, show_pairs, show_text


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `spectrum` to its parser."""
    parser.add_argument("file", help="acceleration record: a log or bag (MCAP), .csv, .npz or .mat")
    parser.add_argument("--topic", metavar="TOPIC", help="of a log: the topic with the record")
    parser.add_argument("--key", metavar="NAME", help="column, variable, channel, or field of the messages")
    rate = quantity("Hz", Limits(above=0.0))
    parser.add_argument(
        "--rate", type=rate, metavar="HZ", help="sampling rate, if it is not in the file [Hz, or as 12kHz]"
    )
    parser.add_argument("--speed", metavar="W", help="of the shaft [rad/s, or as 1750rpm]; default: the log's own")
    parser.add_argument(
        "--bearing",
        metavar="NAME",
        help="designation, such as 6205, or scene with the ball set; default: the log's own",
    )
    parser.add_argument(
        "--band",
        metavar="LOW,HIGH",
        help="band of the envelope [Hz]; default: of four octaves that of greatest kurtosis",
    )
    parser.add_argument("--run", **RUN)
    parser.add_argument("--plot", metavar="PNG", help="draw the spectrum with the lines of damage")


def _run(arguments: argparse.Namespace) -> Outcome:
    """Read a record and judge it; raises BearingTwinError for one that cannot be judged."""
    picture = picture_path(arguments.plot)
    speed = None if arguments.speed is None else number("--speed", arguments.speed, "rad/s")
    band = None if arguments.band is None else _band(arguments.band)
    geometry, uncertain = (None, []) if arguments.bearing is None else _geometry(arguments.bearing)

    import numpy as np

    from bearing_twin.log.acceleration_record import read_record
    from bearing_twin.vibration.envelope import SPEED_ERROR, spectrum_of

    if speed and arguments.speed.strip()[-1] in "0123456789.":
        rpm = 30.0 / math.pi * speed
        say(f"--speed {arguments.speed} is in rad/s, {rpm:.6g} rpm; if it is meant in rpm, give {arguments.speed}rpm")
    with progress(f"reading {arguments.file}"):
        record = read_record(arguments.file, arguments.key, arguments.rate, arguments.topic, arguments.run)
        speed = record.speed if speed is None else speed
        geometry = record.geometry if geometry is None else geometry
        if speed is None:
            raise BearingTwinError(f"{arguments.file} does not say how fast the shaft turns; give --speed, as 1750rpm")
        if geometry is None:
            raise BearingTwinError(f"{arguments.file} does not name its bearing; give --bearing, as 6205")
        spectrum = spectrum_of(record.samples, record.rate, geometry, speed, band)
    result = {"file": str(arguments.file), "rate_hz": record.rate} | spectrum.as_dict()
    if picture:
        from bearing_twin.vibration.envelope import draw_spectrum

        result["plot"] = str(draw_spectrum(spectrum, Path(arguments.file).name, picture))
    warnings = [*record.notes, *spectrum.warnings, *uncertain]
    if arguments.speed is not None and record.speed is not None:
        recorded_speed = abs(float(np.mean(record.speed[1] if isinstance(record.speed, tuple) else record.speed)))
        if recorded_speed and abs(abs(speed) / recorded_speed - 1.0) > SPEED_ERROR:
            turns = f"{30.0 / math.pi * recorded_speed:.5g} rpm"
            warnings.append(f"{arguments.file} was recorded at {turns}, and --speed differs; leave it out to take that")
    return Outcome(result, warnings, lambda: _show(result), True)


SPECTRUM = Subcommand(
    "envelope spectrum of an acceleration record: lines of damage to a bearing, and a verdict",
    _add_arguments,
    _run,
    (
        "bearing_twin spectrum run.mcap",
        "bearing_twin spectrum a.csv --bearing 6205 --speed 1750rpm --plot a.png",
        "bearing_twin spectrum a.mat --key DE_time --bearing 6205 --speed 183",
        "bearing_twin spectrum bag --topic /imu --key linear_acceleration.z",
    ),
)


def _show(result: dict) -> None:
    """Prints verdict, levels and lines; levels to 0.1 dB, which noise alone changes by more."""
    from bearing_twin.vibration.envelope import DAMAGE

    low, high = result["band_hz"]
    levels = ", ".join(f"{family} {level:.1f}" for family, level in result["level_db"].items())
    speed = f"{result['shaft_rpm']:.5g} rpm ({result['shaft_hz']:.5g} Hz)"
    course = "it varies: the envelope is resampled by angle" if result["by_order"] else "steady"
    show_pairs(
        {
            "verdict": DAMAGE.get(result["verdict"], result["verdict"]),
            "level over noise [dB]": f"{levels}; means of three harmonics",
            "shaft speed": f"{speed}, {course}",
            "acceleration": f"RMS {result['rms']:.4g} m/s², kurtosis {result['kurtosis']:.3g}",
            "envelope band": f"{low:.5g} to {high:.5g} Hz",
            "record": f"{result['file']}, {result['seconds']:.4g} s at {result['rate_hz']:.6g} Hz",
            "plot": result.get("plot", ""),
        }.items()
    )
    show_text()
    rows = (
        (
            line["name"],
            f"{line['expected_hz']:.2f}",
            f"{line['found_hz']:.2f}",
            f"{100.0 * line['off']:+.2f}",
            f"{line['amplitude']:.3g}",
            f"{line['over_noise_db']:.1f}",
            line["same_as"],
        )
        for line in result["lines"]
    )
    show_columns(
        (
            "line",
            "expected\n[Hz]",
            "found\n[Hz]",
            "difference\n[%]",
            "amplitude\n[m/s²]",
            "over noise\n[dB]",
            "same\nline as",
        ),
        rows,
    )


def _band(text: str) -> tuple[float, float]:
    ends = text.split(",")
    if len(ends) != 2:
        raise BearingTwinError("--band must be two frequencies, as 2kHz,5.9kHz")
    low, high = (number("--band", end.strip(), "Hz") for end in ends)
    return low, high


def _geometry(name: str) -> tuple:
    """The geometry of a designation or a scene, and a warning where its number of balls is not known."""
    from bearing_twin.kinds.bearing.catalogue import entries
    from bearing_twin.kinds.bearing.ratings import row_in_use
    from bearing_twin.run.scene import load_scene, require_bearing

    scene = require_bearing(load_scene(name))
    geometry = scene.parameters.geometry
    row = row_in_use(scene.parameters) if geometry.designation in entries() else {"balls_doubt": 0}
    if not row["balls_doubt"]:
        return geometry, []
    return geometry, [
        f"{name} has {row['balls']} ± {row['balls_doubt']} balls, and its lines lie elsewhere with another number: "
        "count them, and give a scene with geometry.balls"
    ]
