"""How far a simulation computes in one go."""

from bearing_twin.base.sample import outputs_at_once
from bearing_twin.run.scene import Scene

CHUNK_OUTPUTS = 400  # integrate at most so many outputs in one go, so that memory stays small ...
CHUNK_NS = 50_000_000  # ... and so much simulated time, for which commands wait, or `longest_chunk`
COMMANDED_NS, COMMANDING_NS = 20_000_000, 1_000_000_000  # in one go after a command, for so long


def chunk_outputs(scene: Scene, longest_ns: int) -> int:
    """Outputs that are computed in one go, of at most so much simulated time."""
    return max(1, min(CHUNK_OUTPUTS, outputs_at_once(scene.channels), longest_ns // scene.output_period_ns))


def chunk_end(scene: Scene, first: int, chunk: int, commanded: bool) -> int:
    """Number of the output before which the chunk ends that begins with `first`: a multiple of `chunk` outputs.

    It is shorter where something was `commanded` of late.
    """
    if commanded:
        chunk = min(chunk, chunk_outputs(scene, COMMANDED_NS))
    until = first - first % chunk + chunk
    if first < scene.outputs < until:
        until = scene.outputs  # what lies beyond the end of the scene is seldom asked for
    return until
