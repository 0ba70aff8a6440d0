"""Pictures that move: frames drawn one after the other into a .gif."""

from collections.abc import Callable, Iterable
from pathlib import Path

from matplotlib.animation import PillowWriter

from bearing_twin.base.paths import written_whole

FRAMES_A_SECOND = 20


def write_moving(figure, path, frames: Iterable, draw: Callable) -> Path:
    """Writes one picture a frame, `draw(frame)` filling the figure, whole or not at all; raises as `written_whole`."""
    writer = PillowWriter(fps=FRAMES_A_SECOND)
    with written_whole(path) as draft, writer.saving(figure, str(draft), dpi=figure.dpi):
        for frame in frames:
            draw(frame)
            writer.grab_frame()
    return Path(path)
