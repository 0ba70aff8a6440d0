"""Many messages of one topic at once as little-endian CDR: what differs between them is written column by column."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.errors import LogError
from bearing_twin.log.encoding import SECOND, Draft, laid_out

MOST_LAYOUTS = 200  # of a topic's messages that are kept
LARGE = 16 * 1024  # bytes of a message from which on each copy of it counts


class Encoder:
    """All messages of one topic, many at once: how they are laid out is found with the first of a size and kept.

    Fields are those of `encoded`, but an array has one row a message in front, and texts of one length may be an array
    of bytes; what is no array is the same in all messages that this encoder ever makes.
    """

    def __init__(self, ros_type: str, frame: str):
        self._type, self._frame = ros_type, frame
        self._layouts: dict[tuple, _Layout] = {}

    def encoded(self, values, stamps_ns: np.ndarray, stamps: np.ndarray | None = None) -> list:
        """One message a stamp [ns], in order; `stamps` are `stamps_of` them, if they are at hand.

        `values` are fields, or (rows, fields) for each group of messages of one size.
        """
        stamps = stamps_of(stamps_ns) if stamps is None else stamps
        if not isinstance(values, list):
            found = self.together(values, stamps_ns, stamps)
            if isinstance(found, list):
                return [b"".join(pieces) for pieces in found]
            data, size = found.tobytes(), found.shape[1]
            return [data[low : low + size] for low in range(0, len(data), size)]
        found: list = [None] * len(stamps_ns)
        for rows, fields in values:
            for row, data in zip(rows.tolist(), self.encoded(fields, stamps_ns[rows], stamps[rows]), strict=True):
                found[row] = data
        return found

    def together(self, values: Mapping[str, Any], stamps_ns: np.ndarray, stamps: np.ndarray) -> np.ndarray | list:
        """Messages of one size as bytes (count, size); of large ones the pieces of each, its arrays not copied."""
        count, arrays = len(stamps_ns), list(_arrays(values))
        sizes = tuple([(array.shape[1:], array.itemsize) for array in arrays])
        layout = self._layouts.get(sizes)
        if layout is None:
            if len(self._layouts) >= MOST_LAYOUTS:
                self._layouts.clear()
            layout = self._layouts[sizes] = self._laid_out(values, stamps_ns, arrays)
        size = layout.record.itemsize
        if size >= LARGE:
            return [layout.pieces(row, arrays, stamps) for row in range(count)]
        records = np.empty(count, layout.record)
        found = records.view((np.uint8, size))
        found[...] = layout.template
        for name, place in layout.filled:
            records[name] = stamps if place is None else arrays[place].reshape(count, -1)
        return found

    def _laid_out(self, values, stamps_ns, arrays) -> "_Layout":
        for array in arrays:
            if len(array) != len(stamps_ns):
                raise LogError(f"a field of {self._type} has {len(array)} rows for {len(stamps_ns)} messages")
        draft = laid_out(self._type, values, Draft(stamps_ns, self._frame, len(stamps_ns)))
        numbers = {id(array): place for place, array in enumerate(arrays)}
        filled = [
            (f"f{i}", None if array is None else numbers[id(array)]) for i, (_, _, array) in enumerate(draft.places)
        ]
        record = {
            "names": [name for name, _ in filled],
            "formats": [what for _, what, _ in draft.places],
            "offsets": [offset for offset, _, _ in draft.places],
            "itemsize": len(draft.data),
        }
        return _Layout(np.frombuffer(bytes(draft.data), np.uint8), filled, np.dtype(record))


class _Layout(NamedTuple):
    """Messages of one size: the first of them, (field, number of its array; None: the stamp), the record to fill."""

    template: np.ndarray
    filled: list[tuple[str, int | None]]
    record: np.dtype

    def pieces(self, row: int, arrays: list[np.ndarray], stamps: np.ndarray) -> list[memoryview]:
        """One message as its pieces, its arrays as they are."""
        pieces, position, template = [], 0, self.template.data
        for name, place in self.filled:
            kind, begin = self.record.fields[name][:2]
            numbers = stamps[row] if place is None else arrays[place][row]
            flat = np.ascontiguousarray(numbers, kind.base).reshape(-1).view(np.uint8).data
            pieces += [template[position:begin], flat]
            position = begin + kind.itemsize
        return [*pieces, template[position:]]


def stamps_of(stamps_ns: np.ndarray) -> np.ndarray:
    """Stamps as they stand in a header: eight bytes, seconds first, then nanoseconds."""
    seconds, nanoseconds = np.divmod(stamps_ns, SECOND)
    return seconds + (nanoseconds << 32)


def _arrays(values) -> Iterator[np.ndarray]:
    """Every array in nested mappings and sequences, in order."""
    for value in values.values() if isinstance(values, dict) else values:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, dict) or (isinstance(value, (list, tuple)) and value and isinstance(value[0], dict)):
            yield from _arrays(value)
