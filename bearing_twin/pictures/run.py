"""The picture of a run of any length: its blocks taken in, its panels drawn by the kind, its title and foot."""

from abc import ABC, abstractmethod
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.base.sample import Block, Table
from bearing_twin.pictures.style import SIZE
from bearing_twin.pictures.values import ChannelValues, footer
from bearing_twin.pictures.worth import finish


class RunPicture(ABC):
    """What all pictures of runs but the bearing's share; each draws its panels.

    `kept` names the table of records that a picture draws from, if any.
    """

    kept = ""

    def __init__(self, facts):
        self._facts, self._values = facts, ChannelValues()
        self._records: list[np.ndarray] = []

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._values.add(block)
        if len(rows := block.records.get(self.kept, ())):
            self._records.append(rows)

    def recorded(self, table: Table, *columns: str) -> np.ndarray:
        """Columns (len(columns), n) of the records kept, which are those of `table`."""
        names = [column.name for column in table.columns]
        wanted = [names.index(name) for name in columns]
        return np.concatenate([np.empty((0, len(wanted))), *(rows[:, wanted] for rows in self._records)]).T

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
