"""Runs and logs on their way through a command: into a log, and past a picture. Imports are late."""

from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import IntegrationError, LogError


class ShownStream:
    """A run or log whose blocks, gone through once, are shown to its picture, if there is one."""

    def __init__(self, stream, drawn: bool = False):
        self._stream, self._blocks = stream, None
        self._picture = None
        if drawn:
            from bearing_twin.run.report import picture_of

            self._picture = picture_of(stream)

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def blocks(self):
        """The blocks that nobody has taken yet: whoever stops half way leaves the others."""
        self._blocks = self._blocks or self._shown()
        return self._blocks

    def _shown(self):
        for block in self._stream.blocks():
            if self._picture is not None:
                self._picture.add(block)
            yield block

    def write(self, path, report) -> str:
        """Draws the picture of what has gone past."""
        from bearing_twin.command.terminal import progress
        from bearing_twin.run.report import figure_errors

        with progress(f"drawing {path}"):
            return str(self._picture.write(path, figure_errors(report)))


class Ended(NamedTuple):
    """End of a run: why its log is incomplete ("" if it is not), and the error that ended the run, or None."""

    incomplete: str
    failure: IntegrationError | None


def ended(run: ShownStream, log: Path | None, max_loss: float = 0.0) -> Ended:
    """Has a run go to its end, into a new `log` if one is given; where there is no room for that, on without it.

    Raises LogError where no log can be begun for another reason, before anything is computed.
    """
    incomplete = ""
    try:
        if log:
            incomplete = _logged(run, log, max_loss)
        for _ in run.blocks():
            pass
    except IntegrationError as error:
        return Ended(incomplete, error)
    return Ended(incomplete, run.failure)


def _logged(run: ShownStream, log: Path, max_loss: float) -> str:
    from bearing_twin.command.terminal import say
    from bearing_twin.log.mcap_write import FullDisk
    from bearing_twin.log.run_log import write_log

    try:
        write_log(run, log, max_loss=max_loss)
    except LogError as error:
        begun = run.simulation.sequence >= 0
        if not begun and not isinstance(error, FullDisk):
            raise
        said = f"{'the log is incomplete' if begun else 'there is no log'}: {error}"
        if run.simulation.sequence + 1 < run.outputs and run.failure is None:
            say(f"{said}; the run goes on without it")
        return said
    return ""
