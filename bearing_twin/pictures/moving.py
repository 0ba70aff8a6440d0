"""Pictures that move: frames drawn one after the other into a .gif."""

from collections.abc import Callable, Iterable
from pathlib import Path

from matplotlib.animation import PillowWriter

from bearing_twin.errors import BearingTwinError

FRAMES_A_SECOND = 20


def write_moving(figure, path, frames: Iterable, draw: Callable) -> Path:
    """Writes one picture a frame, `draw(frame)` filling the figure; raises BearingTwinError for a bad place."""
    writer = PillowWriter(fps=FRAMES_A_SECOND)
    try:
        with writer.saving(figure, str(path), dpi=figure.dpi):
            for frame in frames:
                draw(frame)
                writer.grab_frame()
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror}); give another path") from error
    return Path(path)
