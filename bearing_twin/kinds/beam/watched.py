"""A sphere on a beam at the points that are watched: channels over time, and what is greatest there."""

from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elastic import HERTZIAN, approaches_of_loads, energies_at
from bearing_twin.kinds.beam.impact import BeamImpact
from bearing_twin.kinds.beam.modes import beam_energy, deflection_shapes, stress_shapes
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.impact.collision import peak_of

PEAK_SAMPLES = 4000
TOGETHER = 500_000  # states of modes read off at once


class Top(NamedTuple):
    """The greatest `value` of a watched point by magnitude, and times [s] around its instant."""

    value: float
    point: int
    times: np.ndarray


class WatchedPoints:
    """The channels of a known motion at increasing times [s]; beyond its end the last instant stands."""

    def __init__(self, parameters: SphereOnBeamScene, found: BeamImpact):
        self._found, beam, modes = found, found.beam, found.modes
        points = np.array([parameters.blow.point, *parameters.outputs.points]) * beam.span
        stations = np.linspace(0.0, beam.span, parameters.outputs.stations)
        self._deflection, self._stress = deflection_shapes(beam, modes, points), stress_shapes(beam, modes, points)
        self._shape = deflection_shapes(beam, modes, stations)

    def __call__(self, times) -> tuple[np.ndarray, ...]:
        """One array (times, *shape) a channel."""
        return self._in_blocks(times, self._channels)

    def at_points(self, times) -> tuple[np.ndarray, np.ndarray]:
        """Deflection [m] and bending stress [Pa], (times, points): the point of impact, then `outputs.points`."""
        return self._in_blocks(times, self._bending)

    def greatest(self) -> list[Top]:
        """Greatest deflection [m] and bending stress [Pa] by magnitude, of all watched points and the whole motion."""
        times, results = np.linspace(0.0, self._found.end, PEAK_SAMPLES), []
        for column, values in enumerate(self.at_points(times)):
            size = np.abs(values)
            top, point = np.unravel_index(int(np.argmax(size)), size.shape)
            low, high = times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)]
            fine = np.linspace(low, high, 101)
            results.append(Top(self.top_near(column, point, fine), point, fine))
        return results

    def top_near(self, column: int, point: int, times) -> float:
        """The greatest deflection (column 0) or stress (1) by magnitude, of one point at times close to each other."""
        return peak_of(np.abs(self.at_points(times)[column][:, point]))

    def _in_blocks(self, times, function):
        """`function` of (states, force, position, velocity), so many times at once that memory stays small."""
        times = np.minimum(np.asarray(times, float), self._found.end)
        rows = max(1, TOGETHER // len(self._found.modes.index))
        parts = [function(*self._found.at(times[row : row + rows])) for row in range(0, len(times), rows)]
        return tuple(np.concatenate(column) for column in zip(*parts, strict=True))

    def _bending(self, states, force, *_):
        q = self._found.coordinates(states)
        return tuple(q @ modal.T + force[:, None] * still for modal, still in (self._deflection, self._stress))

    def _channels(self, states, force, position, velocity):
        found, (deflection, stress) = self._found, self._bending(states, force)
        contact = approaches_of_loads(found.sphere.coefficient, HERTZIAN, force)
        return (
            np.where(force > 0.0, contact, position - deflection[:, 0]),
            force,
            position,
            velocity,
            deflection,
            stress,
            found.coordinates(states) @ self._shape[0].T + force[:, None] * self._shape[1],
            0.5 * found.sphere.mass * velocity**2,
            beam_energy(found.modes, states, force),
            energies_at(found.sphere.coefficient, HERTZIAN, contact),
        )
