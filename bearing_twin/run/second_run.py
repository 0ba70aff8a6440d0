"""A run and a second, finer run: their difference is the error estimate of the first, which is given out.

The second run has the same start, commands and outputs, and a fraction of the tolerance; or half the divisions of a
mesh, by whose greater error the differences are divided (`kinds.error_estimates`). Both advance chunk by chunk, the
second in a thread that ends with the chunk. The differences are rows of the table `second_run`, the last of which holds
for the run so far; they are logged, so that the report of a log is the same.
"""

import copy
import math
import threading
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Columns, Table, layout_of, stack_channels
from bearing_twin.base.units import key_unit
from bearing_twin.kinds.contract import Kind
from bearing_twin.kinds.error_estimates import SECOND_RUN, Comparison, is_checked

COMPARISON_FACTOR = 4.0  # figures are compared at times that grow by it, and at the end of a run
LAST = 1.0 - 1e-6  # of an output period before the end of a run: where its last output lies at the earliest
LEAST_SHARE = 0.1  # share of the outputs that lie beyond a horizon at least: a single impact is none
LEAST_COUNT = 4  # outputs or contacts at least that lie beyond one
NO_SECOND_RUN = "this kind of scene has no second run"
ROUNDING = 1e-12  # of a figure: no difference is said to be smaller
UNKNOWN = -1.0  # in a row: there is none
HEAD = (
    Channel("time", "s", (), "to where this row holds"),
    Channel("compared", "s", (), "to where both runs were compared"),
    Channel("horizon", "s", (), "from where more than half of the outputs differ by more than the tolerance; -1: none"),
)
TIME, COMPARED, HORIZON = range(len(HEAD))
OUTPUT_COLUMNS = 3  # columns of each requested output


def has_second_run(kind: Kind, parameters, choice: Choice) -> bool:
    """True where a scene specifies a second run and has one: closed forms and equilibria have none."""
    return is_checked(parameters) and _refined(kind, parameters, choice) is not None


def _refined(kind: Kind, parameters, choice: Choice):
    """Parameters and choice of the second run, None where there is none."""
    return None if kind.comparison is None else kind.comparison(parameters, choice).refined()


def _compared(kind: Kind, comparison: Comparison) -> dict[str, str]:
    """The figures of a kind that have an error of the method, with their meanings."""
    return {key: text for key, text in kind.meanings_of().items() if key not in comparison.exact}


def record_tables(kind: Kind, parameters) -> tuple[Table, ...]:
    """The tables of a scene: the kind's own, and that of the second run where the scene specifies one."""
    tables = tuple(kind.records(parameters))
    return (*tables, _table(kind, parameters)) if kind.comparison is not None and is_checked(parameters) else tables


def _table(kind: Kind, parameters) -> Table:
    columns, comparison = list(HEAD), kind.comparison(parameters, None)
    for name, norm in comparison.outputs.items():
        columns += [
            Channel(f"of_{name}", "1", (), f"greatest difference of {name}, {norm}; -1: not compared"),
            Channel(f"when_{name}", "s", (), "when it was greatest"),
            Channel(f"of_{name}_until", "1", (), "the same up to the horizon; -1: there is none"),
        ]
    for key, meaning in _compared(kind, comparison).items():
        columns.append(Channel(f"of_{key}", key_unit(key), (), f"difference of: {meaning}; -1: not known"))
    meaning = "difference between the run so far and a second run at a fraction of its tolerance"
    return Table(SECOND_RUN, tuple(columns), meaning, needed=False)


def difference(value, second, coarser: float = 1.0) -> float:
    """The difference of a figure over `coarser`, the greatest of a list; UNKNOWN where either run has none."""
    if isinstance(value, list) and isinstance(second, list):
        differences = [difference(*pair, coarser) for pair in zip(value, second, strict=True)]
        return UNKNOWN if UNKNOWN in differences else max(differences, default=0.0)
    if not all(isinstance(number, (int, float)) and math.isfinite(number) for number in (value, second)):
        return UNKNOWN
    return float(max(abs(value - second) / coarser, ROUNDING * abs(second)))


class GreatestDifference(NamedTuple):
    """The greatest difference of an output so far, the greatest size, when [s], and the error up to the horizon."""

    difference: float = 0.0
    size: float = 0.0
    when: float = 0.0
    until: float = 0.0

    @property
    def error(self) -> float:
        """The greatest difference over the greatest size."""
        return _relative(self.difference, self.size)


class Differences:
    """Greatest differences so far, and the horizon: from where on more than half of the outputs exceed the tolerance.

    Of all outputs so far, those that exceed it count +1, the others -1; the sum is least at the horizon, since more
    than half of those that follow exceed it (the change point of a cumulative sum; E. S. Page, Biometrika 41 (1954)
    100).
    """

    def __init__(self, tolerance: float):
        self.tolerance = tolerance
        self.worst: dict[str, GreatestDifference] = {}
        self.count = self.sum = self.least = self.at_least = 0
        self.turned = 0.0

    def add(self, times: np.ndarray, differences: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> None:
        """Takes in differences and sizes (n,) at `times` (n,) [s], by output."""
        if not len(times) or not differences:
            return
        beyond, worst, so_far = np.zeros(len(times), bool), dict(self.worst), {}
        for name, (difference, sizes) in differences.items():
            previous = worst.get(name, GreatestDifference(when=float(times[int(np.argmax(difference))])))
            sizes = np.maximum.accumulate(np.maximum(sizes, previous.size))
            beyond |= ~(difference <= self.tolerance * sizes)
            greatest = np.maximum.accumulate(np.maximum(difference, previous.difference))
            so_far[name] = greatest, sizes
            is_greater = not greatest[-1] <= previous.difference
            when = float(times[int(np.argmax(difference))]) if is_greater else previous.when
            worst[name] = GreatestDifference(float(greatest[-1]), float(sizes[-1]), when, previous.until)
        path = self.sum + np.cumsum(np.where(beyond, 1, -1))
        low = len(path) - 1 - int(np.argmin(path[::-1]))
        if path[low] <= self.least:
            self.least, self.at_least, self.turned = int(path[low]), self.count + low + 1, float(times[low])
            for name, (greatest, sizes) in so_far.items():
                worst[name] = worst[name]._replace(until=_relative(float(greatest[low]), float(sizes[low])))
        self.worst, self.sum, self.count = worst, int(path[-1]), self.count + len(path)

    @property
    def horizon(self) -> float:
        """The horizon [s], UNKNOWN where there is none."""
        later = self.count - self.at_least
        beyond = self.sum > self.least and later > max(LEAST_SHARE * self.count, LEAST_COUNT)
        return self.turned if beyond else UNKNOWN


def _relative(difference: float, size: float) -> float:
    return difference / size if size > 0.0 else 0.0 if difference == 0.0 else UNKNOWN


class CheckedMotion:
    """A motion and its second run as one `Motion`: outputs of the first, costs of both.

    The blocks of a chunk are added to the figures of both when the next one begins, so that `take_back` drops them.
    """

    def __init__(self, kind: Kind, parameters, choice: Choice, channels: tuple[Channel, ...]):
        self._kind, self._parameters, self._choice = kind, parameters, choice
        refined = _refined(kind, parameters, choice)
        self._motion, self._second = kind.motion(parameters, choice), kind.motion(*refined)
        self._layouts = layout_of(channels), layout_of(tuple(kind.channels(refined[0])))  # meshes may differ
        self._begin()

    def _begin(self, now: float = 0.0) -> None:
        model = self._parameters, self._choice
        self._comparison = self._kind.comparison(*model)
        self._keys, self._coarser = tuple(_compared(self._kind, self._comparison)), self._comparison.coarser
        self._figures = [self._kind.figures_of(*model) for _ in range(2)]
        self._differences = self._event_differences = Differences(self._parameters.wanted.tolerance)
        self._now_ns = round(1e9 * now)
        self._figures_until = self._compared = now  # s: to where figures, and outputs, were compared
        self._row, self._blocks, self._records, self._failure = None, None, {}, ""
        self._previous: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        attribute = getattr(self._motion, name)
        in_both = name in ("resume", "take_back")  # if the first run has them
        return getattr(self, f"_{name}") if in_both else attribute

    @property
    def stop(self) -> np.ndarray:
        """The flag that stops both, see `Motion`."""
        return self._motion.stop

    @stop.setter
    def stop(self, stop: np.ndarray) -> None:
        for motion in (self._motion, self._second):
            if hasattr(motion, "stop"):
                motion.stop = stop

    @property
    def goal_speed(self) -> float:
        """The speed [rad/s] that ring or shaft goes to."""
        return self._motion.goal_speed

    @goal_speed.setter
    def goal_speed(self, speed: float) -> None:
        self._motion.goal_speed = self._second.goal_speed = speed

    def set_load(self, force, moment) -> None:
        """Set the load of both motions."""
        self._motion.set_load(force, moment)
        self._second.set_load(force, moment)

    def set_torque(self, torque: float) -> None:
        """Set the torque of both motions."""
        self._motion.set_torque(torque)
        self._second.set_torque(torque)

    def reset(self) -> None:
        """Back to the start."""
        self._motion.reset()
        self._second.reset()
        self._begin()

    def _resume(self, state: dict) -> None:
        """Restore a state of `snapshot`; earlier errors are not in the estimate."""
        self._motion.resume(state)
        self._second.resume(state)
        self._begin(float(state.get("elapsed", state.get("now", 0.0))))

    def _take_back(self) -> None:
        """Back to before the last `advance`, for both."""
        self._motion.take_back()
        self._second.take_back()
        vars(self).update(self._previous)

    def first_outputs(self):
        """The outputs at the present instant."""
        values = self._motion.first_outputs()
        self._records = self._motion.take_records()
        try:
            second = self._second.first_outputs(), self._second.take_records()
        except IntegrationError as error:
            self._failure = str(error)
        else:
            self._compare(np.array([self._now_ns]), (values, self._records), second)
        return values

    def advance(self, times: np.ndarray, duration: float):
        """Advance both; raises what the first one raises, and Stopped after both have stopped."""
        for figures, block in zip(self._figures, self._blocks or (), strict=False):
            figures.add(block)
        self._blocks, self._previous = None, {}
        copies = {name: copy.copy(getattr(self, name)) for name in ("_comparison", "_differences")}
        self._previous = vars(self) | copies  # other attributes are replaced, not changed
        second: list = []
        thread = threading.Thread(
            target=_advance_second, args=(self._second, times, duration, second), name="second run", daemon=True
        )
        if not self._failure:
            thread.start()
        try:
            values = self._motion.advance(times, duration)
        finally:
            if not self._failure:
                thread.join()
        self._records = self._motion.take_records()
        if second and isinstance(second[0], IntegrationError):
            self._failure = str(second[0])
        elif second and isinstance(second[0], Exception):
            raise second[0]
        times_ns = self._now_ns + np.rint(1e9 * np.asarray(times, float)).astype(np.int64)
        if self._failure:
            self._row = self._row or [UNKNOWN] * len(self._keys)
            self._record_row(1e-9 * times_ns[-1])
        else:
            self._compare(times_ns, (values, self._records), second[0])
        self._now_ns += round(1e9 * duration)
        return values

    def _compare(self, times_ns: np.ndarray, *runs) -> None:
        """Compare the outputs and records of both runs, and their figures when that is due."""
        self._blocks = [_block(layout, times_ns, *outputs) for layout, outputs in zip(self._layouts, runs, strict=True)]
        differences = self._comparison.differences(*self._blocks)
        self._differences.add(
            1e-9 * times_ns,
            {name: (difference / self._coarser, size) for name, (difference, size) in differences.items()},
        )
        self._compared = until = 1e-9 * float(times_ns[-1])
        run = self._parameters.run
        if until > 0.0 and until >= min(COMPARISON_FACTOR * self._figures_until, run.duration - LAST / run.output_rate):
            self._compare_figures()
            self._figures_until = until
        self._record_row(until)

    def _compare_figures(self) -> None:
        self._figures = copy.deepcopy(self._figures)  # the earlier ones stay unchanged, for `take_back`
        for writer, block in zip(self._figures, self._blocks, strict=True):
            writer.add(block)
        self._blocks = None
        first, second = (writer.figures() for writer in self._figures)
        self._row = [difference(first.get(key), second.get(key), self._coarser) for key in self._keys]
        self._event_differences = Differences(self._parameters.wanted.tolerance)
        for name, columns in self._comparison.events(*self._figures).items():
            times, differences, sizes = (np.asarray(column, float) for column in columns)
            self._event_differences.add(times, {name: (differences / self._coarser, sizes)})

    def _record_row(self, until: float) -> None:
        """Add the row of the run up to `until` [s] to the records."""
        if self._row is None:
            return
        horizon = UNKNOWN
        if self._comparison.grows:
            horizons = self._differences.horizon, self._event_differences.horizon
            horizon = horizons[0] if horizons[0] != UNKNOWN else horizons[1]
        worst, row = self._event_differences.worst | self._differences.worst, [until, self._compared, horizon]
        for name in self._comparison.outputs:
            greatest = worst.get(name)
            until_horizon = UNKNOWN if greatest is None or horizon == UNKNOWN else greatest.until
            row += [UNKNOWN, 0.0, UNKNOWN] if greatest is None else [greatest.error, greatest.when, until_horizon]
        self._records = self._records | {SECOND_RUN: np.array([[*row, *self._row]])}

    def take_records(self) -> dict[str, np.ndarray]:
        """Records of the first run since the last call, and the row of the comparison."""
        records, self._records = self._records, {}
        return records

    def costs(self) -> dict[str, int]:
        """Of the first run, and the steps of the second."""
        second = self._second.costs()
        steps = {f"second_run_{name}": count for name, count in second.items() if name.endswith("steps")}
        return self._motion.costs() | steps


def _block(layout, times_ns: np.ndarray, values, records) -> Block:
    numbers = values.numbers if isinstance(values, Columns) else stack_channels(layout, values, len(times_ns))
    return Block(layout.channels, 0, times_ns, numbers, records)


def _advance_second(motion, times, duration: float, results: list) -> None:
    """Append outputs and records of a motion, or what it raised, to `results`: a thread returns nothing."""
    try:
        results.append((motion.advance(times, duration), motion.take_records()))
    except Exception as error:
        results.append(error)


class OutputError(NamedTuple):
    """The error estimate of a requested output: `error` in its `norm`, when it was greatest [s], up to the horizon."""

    norm: str
    error: float | None
    when: float
    until: float | None


class Estimate:
    """The errors of the method, from the rows of the table in a run or in its log.

    `unknown` is the reason why there is no `comparison`, or no row of one; empty where rows are expected.
    """

    in_stretches = False

    def __init__(self, comparison: Comparison | None = None, keys: tuple[str, ...] = (), unknown: str = ""):
        self._comparison, self._keys, self._unknown = comparison, keys, unknown
        self._outputs = {} if comparison is None else comparison.outputs
        self.tolerance = 0.0 if comparison is None else comparison.parameters.wanted.tolerance
        self._row: np.ndarray | None = None

    def add(self, block: Block) -> None:
        """Take a block."""
        rows = block.records.get(SECOND_RUN, ())
        if len(rows) and rows.shape[1] == len(HEAD) + OUTPUT_COLUMNS * len(self._outputs) + len(self._keys):
            self._row = np.array(rows[-1])  # rows of another version have another length

    def of_figures(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """The error of each figure that was compared, in its unit and shape; None where it is not known."""
        errors_of = {}
        errors = [UNKNOWN] * len(self._keys) if self._row is None else self._row[-len(self._keys) :].tolist()
        for key, error in zip(self._keys, errors, strict=True):
            if (value := figures.get(key)) is not None:
                shaped = [error] * len(value) if isinstance(value, list) else error
                errors_of[key] = shaped if error >= 0.0 else None
        return errors_of

    def of_outputs(self) -> dict[str, OutputError]:
        """The error of each requested output."""
        errors = {}
        for index, (name, norm) in enumerate(self._outputs.items()):
            first = len(HEAD) + OUTPUT_COLUMNS * index
            row = [UNKNOWN, 0.0, UNKNOWN] if self._row is None else self._row[first : first + OUTPUT_COLUMNS].tolist()
            error, until = (number if number >= 0.0 else None for number in row[::2])
            errors[name] = OutputError(norm, error, row[1], until)
        return errors

    @property
    def smaller(self) -> str:
        """A remedy against the error of the method."""
        return "" if self._comparison is None else self._comparison.smaller

    @property
    def horizon(self) -> float | None:
        """The horizon [s], if there is one."""
        return None if self._row is None or self._row[HORIZON] < 0.0 else float(self._row[HORIZON])

    @property
    def note(self) -> str:
        """Why the error of the method is not known, or only up to a time; "" where it is."""
        if self._row is None:
            return self._unknown or "no second run was compared, so the error of the method is not known"
        if self._row[COMPARED] < self._row[TIME]:
            return f"the second run broke off: errors are those up to {self._row[COMPARED]:.6g} s"
        return ""


def estimate_of(kind: Kind, parameters, choice: Choice) -> Estimate:
    """An empty estimate of a scene of this kind."""
    if kind.comparison is None:
        return Estimate(unknown=NO_SECOND_RUN)
    comparison, unknown = kind.comparison(parameters, choice), ""
    if not is_checked(parameters):
        unknown = "solver.check: none, so the error of the method is not known"
    elif comparison.refined() is None:
        unknown = "this model has no second run: its solutions are closed forms or equilibria"
    return Estimate(comparison, tuple(_compared(kind, comparison)), unknown)
