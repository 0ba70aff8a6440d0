"""The outputs of a run kept for a picture: whole while they are few, thinned evenly where they are many."""

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Block
from bearing_twin.base.units import prefixed

GREATEST_ROWS = 100_000  # outputs kept; of longer runs every second, fourth ... is


class ChannelValues:
    """Takes blocks in and gives arrays back; `stride` tells how much was thinned, `greatest` what was seen of each."""

    def __init__(self):
        self.stride, self.outputs = 1, 0
        self.greatest: dict[str, float] = {}
        self._rows = 0
        self._time: list[np.ndarray] = []
        self._values: list[dict[str, np.ndarray]] = []

    def add(self, block: Block) -> None:
        self.outputs += len(block)
        for name, values in block.values.items():
            if values.ndim == 1:
                self.greatest[name] = max(self.greatest.get(name, -np.inf), float(values.max(initial=-np.inf)))
        keep = slice(-block.first_sequence % self.stride, None, self.stride)
        self._time.append(1e-9 * block.time_ns[keep])
        self._values.append({name: values[keep] for name, values in block.values.items()})
        self._rows += len(self._time[-1])
        if self._rows > GREATEST_ROWS:
            whole = self.arrays()
            self.stride *= 2
            self._time = [whole.pop("time")[::2]]
            self._values = [{name: values[::2] for name, values in whole.items()}]
            self._rows = len(self._time[0])

    def arrays(self) -> dict[str, np.ndarray]:
        """Time [s] as "time", and every channel by name, of the outputs kept; raises LogError without a sample."""
        if not self._rows:
            raise LogError("there is no sample to draw; recover the log from the original, or simulate again")
        values = {name: np.concatenate([part[name] for part in self._values]) for name in self._values[0]}
        return {"time": np.concatenate(self._time), **values}


def footer(facts, values: ChannelValues) -> str:
    """What stands below the picture of a run: scene, outputs, law and stepper, version."""
    thinned = f", every {values.stride}th" if values.stride > 1 else ""
    words = [f"{values.outputs} output{'s' * (values.outputs != 1)}{thinned}"]
    words += [f"{name}: {text}" for name, text in (("law", facts.law), ("stepper", facts.stepper)) if text]
    if facts.scene is not None:
        words.insert(0, facts.scene.name)
    return f"{', '.join(words)}; bearing_twin {__version__}"


def scaled_time(time: np.ndarray) -> tuple[np.ndarray, float, str]:
    """Times in a readable unit, the factor from seconds, and the unit."""
    scale, unit = prefixed(float(time[-1]), "s")
    return scale * time, scale, unit
