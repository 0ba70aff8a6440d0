"""The picture of a run of any length: its blocks taken in, its panels drawn by the kind, its title and foot."""

from abc import ABC, abstractmethod
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.pictures.style import SIZE
from bearing_twin.pictures.values import ChannelValues, footer
from bearing_twin.pictures.worth import finish
from bearing_twin.sample import Block


class RunPicture(ABC):
    """What all pictures of runs but the bearing's share; each draws its panels."""

    def __init__(self, facts):
        self._facts, self._values = facts, ChannelValues()

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._values.add(block)

    @abstractmethod
    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        """Fills the figure with panels."""

    def write(self, path, worth=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        values, scene = self._values.arrays(), self._facts.scene
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        self.draw(figure, values)
        title = scene.description or scene.name if scene is not None else "Recorded run"
        return finish(figure, title, footer(self._facts, self._values), path, size=17, worth=worth)
