"""What a run will take, told before it begins: outputs, the size of its log, memory. Its time is told as it goes."""

from typing import NamedTuple

from bearing_twin.run.chunks import CHUNK_OUTPUTS
from bearing_twin.run.scene import Scene

LARGE = 1e9  # bytes of log or memory from which on a run is announced
COPIES = 4  # of a chunk of outputs: as computed, cut, encoded, packed
PACKED = 0.8  # size of a log's samples on disk as a share of their numbers, measured with bearing_6203
MESSAGES = 1.1  # size of a log with its other topics over its samples alone


class Cost(NamedTuple):
    """Outputs of a run, bytes of a log of all of them, and bytes of memory beyond those of any run."""

    outputs: int
    log_bytes: float
    memory_bytes: float

    def sentence(self, with_log: bool, free_bytes: float) -> str:
        """What is large about it, with the room there is on the disk; empty where nothing is."""
        large = []
        if with_log and self.log_bytes > min(LARGE, free_bytes):
            large.append(f"a log of about {self.log_bytes:.2g} B where {free_bytes:.2g} B are free")
        if self.memory_bytes > LARGE:
            large.append(f"about {self.memory_bytes:.2g} B of memory")
        return f"{self.outputs} outputs, {' and '.join(large)}" if large else ""


def cost_of(scene: Scene) -> Cost:
    """What the scene's run will take, from its channels and their rate."""
    row = 8.0 * sum(channel.width for channel in scene.channels)
    together = min(CHUNK_OUTPUTS, scene.outputs)
    return Cost(scene.outputs, scene.outputs * row * PACKED * MESSAGES, COPIES * together * row)
