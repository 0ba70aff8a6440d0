"""Runs that fail: their last good output, the state to go on from, and the file that keeps both."""

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import bearing_twin
from bearing_twin.base.errors import BearingTwinError, IntegrationError, LogError, SceneError
from bearing_twin.base.report import json_text, parse_json
from bearing_twin.base.sample import Block, Channel, Sample
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Kind
from bearing_twin.run.scene import Scene, choose, load_scene, parse_scene, read_logged_scene

FORMAT = "bearing_twin failure 1"
LARGEST_FILE = 20_000_000  # bytes
TOLERANCE_FACTOR = 0.1  # of the tolerance, to go on with
SAME_TIME = 1e-9  # of a time: closer ones are the same
STEP_FACTOR = 0.25  # of a fixed step


class Failure(NamedTuple):
    """A run that failed: its error, the `values` of its last good output, the motion's `state` after `sequence`.

    `state` is that of the motion's `snapshot`, or None where the run can only be repeated; its `sequence` is then -1.
    """

    scene: Scene
    sentence: str
    reason: str
    seconds: float
    body: str
    contact: str
    good_seconds: float
    values: Mapping[str, Any]
    sequence: int
    state: Mapping[str, Any] | None

    def body_rows(self) -> list[tuple[str, float, str]]:
        """(channel with its contact, value, unit) of the last good output for the body that failed, or all scalars."""
        kind, rows = KINDS[self.scene.kind], []
        for channel in self.scene.channels:
            values = _number_array(self.values.get(channel.name, np.full(channel.shape, math.nan)))
            if values is None or values.shape != channel.shape:
                raise SceneError(f"the last good output in it does not fit its scene at {channel.name}")
            for index in np.ndindex(channel.shape):
                body, contact = kind.place_of(channel, index)
                if body == self.body:
                    label = " ".join((channel.name, contact, *_axis(channel, index))).replace("  ", " ").strip()
                    rows.append((label, float(values[index]), channel.unit))
        return rows

    def with_tighter_tolerance(self, tolerance: float | None = None) -> Scene:
        """The scene with a tenth of its tolerance, or with `tolerance`, and a fixed step a quarter as long.

        Friction that was chosen stays, for a tighter tolerance might choose another.
        """
        mapping = self.scene.resolved()
        if friction := choose(self.scene).friction:
            mapping["contact"]["friction"] = friction
        wanted, solver = mapping.get("wanted", {}), mapping.get("solver", {})
        if "tolerance" in wanted:
            wanted["tolerance"] = wanted["tolerance"] * TOLERANCE_FACTOR if tolerance is None else tolerance
        elif tolerance is not None:
            raise SceneError(f"a scene of kind {self.scene.kind} has no wanted.tolerance; leave out --tolerance")
        step = solver.get("step", 0.0) or (self.state or {}).get("fixed_step", 0.0)
        if "step" in solver and step:
            solver["step"] = step * STEP_FACTOR
        return parse_scene(mapping, f"scene {self.scene.name}")


def record_of(scene: Scene, error: IntegrationError, good: Sample | None, sequence: int, state) -> dict:
    """Content of the file of a failure, as plain data."""
    values = {} if good is None else {name: np.asarray(value).tolist() for name, value in good.values.items()}
    return {
        "format": FORMAT,
        "bearing_twin_version": bearing_twin.__version__,
        "failure": str(error),
        "reason": error.reason,
        "seconds": error.seconds,
        "body": error.body,
        "contact": error.contact,
        "last_good_s": 0.0 if good is None else 1e-9 * good.time_ns,
        "last_good_output": values,
        "state_after_output": sequence,
        "state": state,
        "scene": scene.text,
    }


def recorded_error(error: IntegrationError, last_output: float, contact: str, scene: Scene, *state) -> IntegrationError:
    """The error of a run whose `last_output` was given out at [s], with the record of its failure.

    `state`: the last good output, the number of the output to go on after, and the motion's snapshot there.
    """
    failure = IntegrationError(f"after {last_output:.9g} s: {error}", error.reason, error.seconds, error.body, contact)
    good, sequence, snapshot = state
    failure.record = record_of(scene, failure, good, sequence, snapshot)
    return failure


FAILURE_KEYS = {
    "failure": str,
    "failure_reason": str,
    "failure_at_s": float,
    "failure_body": str,
    "failure_contact": str,
}
"""Keys of a report on the failure that ended its run: sentence, reason, time [s], body, contact, where known."""


def failure_keys(error: IntegrationError) -> dict[str, Any]:
    """The FAILURE_KEYS of an error that ended a run."""
    return _known_keys((str(error), error.reason, error.seconds, error.body, error.contact))


def logged_failure(report: Mapping[str, Any]) -> dict[str, Any] | None:
    """The FAILURE_KEYS in a log's own report; None without a failure, and for invalid values."""
    try:
        return _known_keys(report.get(key) for key in FAILURE_KEYS) if report.get("failure") else None
    except (TypeError, ValueError, OverflowError):
        return None


def _known_keys(values: Iterable) -> dict[str, Any]:
    known = {
        key: kind(value) for (key, kind), value in zip(FAILURE_KEYS.items(), values, strict=True) if value is not None
    }
    return {key: value for key, value in known.items() if (math.isfinite(value) if isinstance(value, float) else value)}


def write_failure(error: IntegrationError, folder: Path) -> Path | None:
    """Write the record of a failed run to a new file in `folder`; None without a record, or if it cannot be written."""
    if error.record is None:
        return None
    stem = f"failure_{time.strftime('%Y%m%d_%H%M%S')}"
    for number in range(1, 1000):
        path = folder / (f"{stem}.json" if number == 1 else f"{stem}_{number}.json")
        try:
            file = path.open("x", encoding="utf-8")
        except FileExistsError:
            continue
        except OSError:
            return None
        try:
            with file:
                file.write(json_text(error.record) + "\n")
            return path
        except OSError:
            path.unlink(missing_ok=True)  # a part of one is none
            return None
    return None


def failure_sentence(error: IntegrationError, folder: Path) -> str:
    """The sentence on a failed run, with the command that explains the file written to `folder`, if any."""
    path = write_failure(error, folder)
    advice = f"; look into it and go on from the last good state: bearing_twin explain {path}" if path else ""
    return f"{error}{advice}"


def read_failure(path) -> Failure:
    """The failure in a file; raises BearingTwinError for another file."""
    path = Path(path)
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)  # a device has no size
        if len(content) > LARGEST_FILE:
            raise BearingTwinError(f"{path} is too large for a failure; give a file that a failed run wrote")
        record = parse_json(content)
        if record["format"] != FORMAT:
            raise ValueError
        seconds = record["seconds"]
        return Failure(
            scene=read_logged_scene(str(record["scene"]), f"the scene in {path.name}"),
            sentence=str(record["failure"]),
            reason=str(record["reason"]),
            seconds=math.nan if seconds is None else float(seconds),
            body=str(record["body"]),
            contact=str(record["contact"]),
            good_seconds=float(record["last_good_s"]),
            values=dict(record["last_good_output"]),
            sequence=int(record["state_after_output"]),
            state=None if record["state"] is None else dict(record["state"]),
        )
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be read ({error.strerror}); give the file of a failed run") from error
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise BearingTwinError(f"{path} is not the file of a failed run; give one that a failed run wrote") from error


def continuation(log, seconds: float, overrides: Iterable[str] = ()) -> Failure:
    """The state near the end of the run in a log, with its scene lengthened by `seconds` [s], for `simulate`.

    It is that at the end of the last whole chunk, so that the continuation is that of one long run to the bit.
    `overrides` change the scene from there on. Raises LogError where the log holds no state, SceneError for overrides
    that do not fit.
    """
    if log.scene is None or log.state is None:
        raise LogError(
            f"{log.path} holds no state to continue from: it is a recording, was interrupted, comes from an earlier "
            "version, or its kind of scene keeps none; simulate its scene with a longer --duration"
        )
    sequence, state = log.state
    end = log.scene.parameters.run.duration
    scene = load_scene(log.scene.resolved(), (*overrides, f"run.duration={end + seconds!r}"))
    if scene.output_period_ns != log.scene.output_period_ns:
        raise SceneError("run.output_rate must be that of the log, for its outputs go on; leave it out")
    return Failure(scene, "", "", math.nan, "", "", end, {}, sequence, state)


def with_duration(scene: Scene, seconds: float) -> Scene:
    """The scene with another duration."""
    run = dataclasses.replace(scene.parameters.run, duration=seconds)
    return dataclasses.replace(scene, parameters=dataclasses.replace(scene.parameters, run=run))


def _number_array(plain) -> np.ndarray | None:
    """Plain data as an array of numbers, NaN for null; None for other data."""
    try:
        return np.asarray(plain, float)
    except (TypeError, ValueError, OverflowError):
        return None


def _axis(channel: Channel, index: tuple[int, ...]) -> tuple[str, ...]:
    """The letter of the component of a vector or quaternion; nothing for a number."""
    width = channel.shape[-1] if channel.shape else 0
    return ("xyzw"[index[-1]],) if width in (3, 4) else ()


class Breakdown(NamedTuple):
    """The error that ends a run; the number of the output to go on after, and the motion's state there."""

    error: IntegrationError
    sequence: int
    state: Any


def snapshot_of(motion):
    """The state of a motion as plain data, None of one that has none."""
    return motion.snapshot() if hasattr(motion, "snapshot") else None


def outputs_before_failure(
    motion, compute: Callable[[np.ndarray], Block], first: int, times: np.ndarray, now: float, restart: Breakdown, block
) -> tuple[Block | None, Breakdown]:
    """The outputs before the error of a chunk from number `first` on, at `times` (n,) [s] from `now` [s].

    `block` holds them if the error is an impossible output; otherwise `compute` repeats the chunk from its beginning,
    up to the error or earlier. None without such outputs, or where the motion cannot go back.
    """
    times = times[now + times < restart.error.seconds * (1.0 - SAME_TIME)]
    if block is not None:
        return block.part(0, len(times)), restart
    while len(times) and hasattr(motion, "take_back"):
        motion.take_back()
        try:
            block = compute(times)
        except IntegrationError:  # earlier than it said
            times = times[: len(times) // 2]
        else:
            return block, Breakdown(restart.error, first + len(times) - 1, snapshot_of(motion))
    return None, restart


def deepest_contact(kind: Kind, sample, channels: tuple[Channel, ...], body: str) -> str:
    """The contact of `body` with the greatest approach in an output; empty where the kind names none."""
    deepest, name = -math.inf, ""
    for channel in channels:
        if channel.name != "approach" or sample is None:
            continue
        for index in np.ndindex(channel.shape):
            location, value = kind.place_of(channel, index), float(sample[channel.name][index])
            if location[0] == body and location[1] and value > deepest:
                deepest, name = value, location[1]
    return name
