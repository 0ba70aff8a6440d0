"""Tortures of logs: killed writers, full disks, cuts and torn writes, flips, bombs; size and reading of long logs."""

import contextlib
import io
import mmap
import os
import resource
import signal
import struct
import time
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Header, Schema
from mcap.writer import Writer
from torture_rows import Found, Row, fork, in_a_process, megabytes, part_of, until

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.mcap_write import MAGIC
from bearing_twin.log.raw_log import SCENE_RECORD, RawLogWriter, Safety, recover
from bearing_twin.log.run_log import read_log
from bearing_twin.run.scene import parse_scene
from bearing_twin.uq.study import parse_study

MAX_LOSS, ALLOWED = 0.1, 0.15  # s: of the log, and with 50 ms for the flush itself
RATES = (1.0, 20.0, 500.0, 5000.0)  # messages a second
KILLED_TOGETHER = 10
STATE = struct.Struct("<Q")
MOST_NUMBERS = 200_000
MANY, LAST, HELD, TIMES = range(4)  # what a writer notes: messages, last sign of life, time without a turn, times
NAP, PUNCTUAL = 0.01, 1e-3  # s between signs of life, and by which they may come late
HELD_UP = NAP + 0.02  # s without a sign of life of a writer that should have given one


def clock_log(path, **safety) -> tuple[RawLogWriter, int]:
    """A log of one topic, and its number."""
    log = RawLogWriter(path, safety=Safety(**safety))
    return log, log.add_topic("/clock", cdr.CLOCK)


class _Life:
    """Notes of a writer in `shared` on its life: when it had its last turn, and how long the machine let it wait."""

    def __init__(self, shared):
        self._shared, self._wall, self._cpu = shared, time.monotonic(), time.process_time()

    def sign(self, slept: float = 0.0) -> float:
        """A sign of life after a sleep [s]; returns the time."""
        wall, cpu = time.monotonic(), time.process_time()
        self._shared[HELD] += max(0.0, wall - self._wall - slept - (cpu - self._cpu) - PUNCTUAL)
        self._shared[LAST] = self._wall = wall
        self._cpu = cpu
        return wall


def _write_until_killed(path, rate: float, shared) -> None:
    """Writes numbered messages at `rate`, and notes in `shared` how many, and when each was handed over."""
    log, topic = clock_log(path, max_loss=MAX_LOSS, patient=True)
    handed, life = shared[TIMES:], _Life(shared)
    number, began = 0, time.monotonic()
    while number < len(handed):
        now = life.sign()
        while (left := began + number / rate - now) > 0.0:
            nap = min(NAP, left)
            time.sleep(nap)
            now = life.sign(nap)
        log.write(topic, number, int(now * 1e9), STATE.pack(number))
        handed[number] = now
        number += 1
        shared[MANY] = number


def kills(share: float, folder: Path) -> Found:
    """Writers killed with -9 at random instants: what was handed over more than `ALLOWED` before is in the log."""
    random, trials = np.random.default_rng(1), part_of(40, share, len(RATES))
    survived = lost = silent = 0
    worst = held_up = 0.0
    rates = [RATES[k % len(RATES)] for k in range(trials)]
    for first in range(0, trials, KILLED_TOGETHER):
        together = []
        for k in range(first, min(first + KILLED_TOGETHER, trials)):
            shared, path = np.frombuffer(mmap.mmap(-1, 8 * (TIMES + MOST_NUMBERS))), folder / f"killed_{k}.mcap"
            child = fork()
            if child == 0:
                try:
                    _write_until_killed(path, rates[k], shared)
                finally:
                    os._exit(1)
            together.append((child, shared, path))
        for _, shared, _ in together:
            until(lambda shared=shared: shared[MANY] > 0, 300.0)
        for child, shared, path in together:
            time.sleep(random.uniform(0.02, 0.15))
            killed = time.monotonic()
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            written = _numbers(path, folder)
            missing = shared[TIMES + len(written) : TIMES + int(shared[MANY])]
            # A machine with more to do than it can may not let a writer run for a while: no log is written then.
            alive = min(killed, shared[LAST] + HELD_UP) - shared[HELD]
            held_up = max(held_up, killed - alive)
            worst = max(worst, alive - missing.min(initial=alive))
            late = int(np.sum(alive - missing > ALLOWED))
            lost += late
            survived += not late
            silent += written != list(range(len(written)))
            path.unlink()
    said = f"max_loss {MAX_LOSS} s, greatest loss {1e3 * worst:.0f} ms"
    return Found(trials, survived, lost, silent, f"{said} ({1e3 * held_up:.0f} ms held up by the machine)")


def _numbers(path: Path, folder: Path) -> list[int]:
    """The numbers in a log that was not closed, in order."""
    saved = folder / "saved.mcap"
    saved.unlink(missing_ok=True)
    try:
        recover(path, saved)
    except LogError:
        return []
    return [STATE.unpack(message.data)[0] for message in raw_messages(saved)]


def full_disk(share: float, folder: Path) -> Found:
    """The kernel refuses to let files grow (RLIMIT_FSIZE) from a random instant on, and lets them again later."""
    random, trials = np.random.default_rng(3), part_of(80, share, 5)
    survived = lost = silent = dropped = 0
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    for k in range(trials):
        path = folder / f"full_{k}.mcap"
        log, topic = clock_log(path, patient=True)
        flushed, full = [], int(random.integers(20, 300))
        again, problem = full + int(random.integers(1, 200)), False
        try:
            for number in range(600):
                if number == full:
                    room = log.bytes + int(random.integers(0, 2000))
                    resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
                if number == again:
                    resource.setrlimit(resource.RLIMIT_FSIZE, limits)
                log.write(topic, number, number, struct.pack("<Q", number) + random.bytes(100))
                if number % 7 == 0:
                    log.flush()
                    problem |= bool(log.problem)
                    if not log.problem:
                        flushed = list(range(number + 1))
                    elif not flushed or log.messages > len(flushed):
                        flushed = list(range(log.messages))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        dropped += log.dropped
        log.close()
        found = [struct.unpack_from("<Q", message.data)[0] for message in raw_messages(path)]
        missing = set(flushed) - set(found)
        lost += len(missing)
        silent += len(found) + log.dropped != 600
        survived += not missing and found[-1] == 599 and len(found) + log.dropped == 600
        path.unlink()
    return Found(trials, survived, lost, silent, f"{dropped} messages dropped and counted")


def _added_to(path: Path) -> None:
    with path.open("ab") as file:
        file.write(os.urandom(3000))


def meddled(share: float, folder: Path) -> Found:
    """Another program removes, moves, adds to or cuts the file at a random instant: it is whole, or it is said."""
    random, trials = np.random.default_rng(10), part_of(100, share, 8)
    moved = folder / "moved.mcap"
    ways = (Path.unlink, lambda path: path.rename(moved), _added_to, lambda path: os.truncate(path, 100))
    survived = lost = silent = 0
    for k in range(trials):
        path, way, place = folder / "meddled.mcap", ways[k % len(ways)], int(random.integers(1, 500))
        log, topic = clock_log(path, patient=True)
        reported = False
        try:
            for number in range(500):
                if number == place:
                    way(path)
                log.write(topic, number, number, struct.pack("<Q", number) + random.bytes(100))
                if number % 7 == 0:
                    log.flush()
            log.close()
        except LogError:
            reported = True
        here = moved if moved.exists() else path
        found = [] if reported else [STATE.unpack_from(message.data)[0] for message in raw_messages(here)]
        whole, gone = found == list(range(500)), way in (ways[0], ways[-1])
        lost += not whole and not gone
        silent += not whole and not reported
        survived += reported if gone else whole
        here.unlink(missing_ok=True)
    return Found(trials, survived, lost, silent, "")


CHUNKS, CHUNK_MESSAGES = 3, 5  # of a small log


def _small_log(folder: Path) -> tuple[bytes, list]:
    """A log of some chunks: its bytes and its messages."""
    path, random = folder / "small.mcap", np.random.default_rng(4)
    log, topic = clock_log(path)
    for number in range(CHUNKS * CHUNK_MESSAGES):
        log.write(topic, number, number, struct.pack("<Q", number) + random.bytes(24))
        if number % CHUNK_MESSAGES == CHUNK_MESSAGES - 1:
            log.flush()
    log.close()
    return path.read_bytes(), [message.data for message in raw_messages(path)]


def _tried(path: Path, whole: list, folder: Path) -> tuple[list | None, list, bool]:
    """(messages as read, or None where that was refused; messages recovered; whether nothing but LogError came)."""
    read, saved, well = None, [], True
    out = folder / "saved.mcap"
    out.unlink(missing_ok=True)
    try:
        read = [message.data for message in raw_messages(path)]
    except LogError:
        pass
    except Exception:
        well = False
    try:
        recover(path, out)
        saved = [message.data for message in raw_messages(out)]
    except LogError:
        pass
    except Exception:
        well = False
    return read, saved, well


def cuts(share: float, folder: Path) -> Found:
    """A log cut at every byte, of two in three with zeros or noise behind, as of a torn write.

    It is refused with a sentence, or whole; everything before the cut chunk is recovered.
    """
    content, whole = _small_log(folder)
    step, random = max(1, round(1.0 / share)), np.random.default_rng(2)
    tried = survived = lost = silent = 0
    path, least = folder / "cut.mcap", 0
    for length in range(0, len(content), step):
        more = int(random.integers(1, 5000))
        path.write_bytes(content[:length] + (b"", bytes(more), random.bytes(more))[tried % 3])
        read, saved, well = _tried(path, whole, folder)
        tried += 1
        fewer = len(saved) < least
        least = max(least, len(saved))
        wrong = (read is not None and read != whole) or saved != whole[: len(saved)] or not well
        silent += wrong
        lost += fewer
        survived += not (wrong or fewer)
    lost += len(whole) - least
    return Found(tried, survived, lost, silent, f"{len(content)} bytes, {len(whole)} messages in {CHUNKS} chunks")


def flips(share: float, folder: Path) -> Found:
    """One bit flipped anywhere: no other message is ever read; recover loses one chunk at most."""
    content, whole = _small_log(folder)
    random, trials = np.random.default_rng(5), part_of(3000, share, 100)
    survived = lost = silent = 0
    path, known = folder / "flipped.mcap", set(whole)
    for _ in range(trials):
        data = bytearray(content)
        data[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        path.write_bytes(data)
        read, saved, well = _tried(path, whole, folder)
        header = data[: len(MAGIC)] != MAGIC  # of a file that is no log any more, nothing is promised
        wrong = (read is not None and read != whole) or not known.issuperset(saved) or not well
        few = len(saved) < len(whole) - CHUNK_MESSAGES and not header
        silent += wrong
        lost += few
        survived += not (wrong or few)
    return Found(trials, survived, lost, silent, "lost: flips that cost more than a chunk")


def _file_of(*records) -> bytes:
    builder = RecordBuilder()
    Header("ros2", "").write(builder)
    for record in records:
        record.write(builder)
    return MAGIC + builder.end()


PACKED = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}


def _chunk(content: bytes, data: bytes, compression: str, size: int | None = None) -> Chunk:
    return Chunk(
        compression=compression, data=data, message_end_time=0, message_start_time=0,
        uncompressed_crc=zlib.crc32(content[: 1 << 20]), uncompressed_size=len(content) if size is None else size,
    )  # fmt: skip


def _log_of_scene(scene: str) -> bytes:
    """A whole log without outputs, with this text in place of the scene."""
    written = io.BytesIO()
    log = Writer(written)
    log.start("ros2")
    schema = log.register_schema(cdr.SAMPLE_BLOCK, "ros2msg", cdr.schema_text(cdr.SAMPLE_BLOCK).encode())
    log.register_channel("/bearing/samples", "cdr", schema)
    log.add_metadata(SCENE_RECORD, {"scene": scene})
    log.finish()
    return written.getvalue()


TABLE = '{"kind": "bearing", "rings": {"inner": {"table": [%s]}}}'


def log_bombs() -> dict[str, Callable[[], bytes]]:
    """Small files that would unpack, count or allocate without end, made when they are wanted, by what they are."""
    described = Schema(1, b"", "ros2msg", "a/msg/B"), Channel(1, "/a", "cdr", {}, 1)
    huge = struct.pack("<BQ", 6, 1 << 62)

    def unpacked(compression: str, size: int, reported: int | None = None, times: int = 1) -> bytes:
        """Chunks of so many zeros that tell this size."""
        zeros = bytes(size)
        return _file_of(*[_chunk(zeros, PACKED[compression](zeros), compression, reported)] * times)

    def counted(compression: str, record: bytes, times: int) -> bytes:
        """A chunk of so many records."""
        return _file_of(*described, _chunk(record * times, PACKED[compression](record * times), compression))

    found: dict[str, Callable[[], bytes]] = {}
    for name in PACKED:
        found[f"{name}, size as it is"] = partial(unpacked, name, 1 << 28)
        found[f"{name}, size small"] = partial(unpacked, name, 1 << 28, 1000)
        found[f"{name}, size huge"] = partial(unpacked, name, 1 << 28, 1 << 62)
        found[f"{name}, many chunks"] = partial(unpacked, name, 1 << 28, 1 << 26, 8)
        found[f"{name}, empty records"] = partial(counted, name, struct.pack("<BQ", 0x80, 0), 3_000_000)
        message = struct.pack("<BQHIQQ", 5, 22, 1, 0, 0, 0)
        found[f"{name}, empty messages"] = partial(counted, name, message, 1_000_000)
        found[f"{name}, just under the limit"] = partial(unpacked, name, 1 << 26, None, 4)
    channels = (Channel(k % 65536, "/a" * 50, "cdr", {}, 1) for k in range(100_000))
    rows = (f"[{k}e-3, 1,1,1,0,0]" for k in range(300_000))
    return found | {
        "a record of 2^62 bytes": lambda: _file_of() + huge,
        "a record of 2^62 bytes in a chunk": lambda: _file_of(_chunk(huge, huge, "")),
        "a chunk without end": lambda: MAGIC + struct.pack("<BQ", 6, 1 << 25) + bytes(100),
        "magic alone, many times": lambda: MAGIC * 100_000,
        "100 000 channels": lambda: _file_of(described[0], *channels),
        "a scene of 30 MB": lambda: _log_of_scene("kind: bearing\ndescription: " + "x" * 30_000_000),
        "a scene of 7 MB of lists": lambda: _log_of_scene('{"kind": "bearing", "a": [' + "[]," * 2_300_000 + "0]}"),
        "a scene of deep lists": lambda: _log_of_scene('{"a": ' + "[" * 5_000_000),
        "a scene with a long table": lambda: _log_of_scene(TABLE % ", ".join(rows)),
        "a schema of 30 MB": lambda: _file_of(Schema(1, bytes(30_000_000), "ros2msg", "a/msg/B")),
    }


def yaml_bombs() -> dict[str, str]:
    """Texts that would take a reader of YAML long or much memory, by what they are."""
    billion = "a: &a [x, x, x, x, x, x, x, x]\n" + "".join(
        f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 8)}]\n" for k in range(12)
    )
    return {
        "aliases": billion,
        "merge keys": "a: &a {b: 1}\nc: {" + ", ".join(["<<: *a"] * 1000) + "}",
        "deep lists": "a: " + "[" * 60_000,
        "deep lists, closed": "a: " + "[" * 5000 + "]" * 5000,
        "deep mappings": "a: " + "{a: " * 20_000,
        "deep blocks": "".join(f"{' ' * k}a:\n" for k in range(450)),
        "a long list": "a: [" + "1, " * 40_000 + "]",
        "a long table": TABLE % ", ".join(f"[{k}, 1,0,0,0,0]" for k in range(5800)),
        "a table without end": TABLE % ", ".join(f"[{k}, 1,0,0,0,0]" for k in range(100_000)),
        "a long number": "kind: bearing\nrun: {duration: 1" + "0" * 100_000 + "}",
        "a long text": "kind: bearing\nname: " + "x" * 120_000,
        "many keys": "".join(f"k{k}: 1\n" for k in range(14_000)),
        "the same key": "kind: bearing\n" * 9000,
        "a tag that runs code": "!!python/object/apply:os.system [sleep 100]",
        "many documents": "---\na: 1\n" * 14_000,
        "escapes": 'a: "' + "\\U0001F600" * 12_000 + '"',
        "comments": "#\n" * 60_000,
        "sexagesimals": "a: [" + "190:20:30, " * 11_000 + "]",
    }


def bombs(share: float, folder: Path) -> Found:
    """Each in a process of its own: refused or read, in less than 1 s of processor time and 300 MB.

    A program that reads logs takes 110 MB itself, whatever it reads.
    """
    tried = survived = silent = 0
    worst, dearest = 0.0, 0.0
    names, most_seconds, most_memory = [], 1.0, 300e6 - 110e6

    def job(use, *arguments):
        def work():
            with contextlib.suppress(BearingTwinError):
                use(*arguments)

        return work

    logs, jobs = log_bombs(), []
    for name in sorted(logs):
        path = folder / f"{name}.mcap"
        jobs += [(name, job(lambda path: list(raw_messages(path)), path)), (name, job(read_log, path))]
    for name, text in yaml_bombs().items():
        jobs += [(name, job(parse, text, "a bomb")) for parse in (parse_scene, parse_study)]
    chosen = jobs[:: max(1, round(1.0 / share / 4.0))]

    def write():
        for name in {name for name, _ in chosen} & {*logs}:
            (folder / f"{name}.mcap").write_bytes(logs[name]())

    assert in_a_process(write).well
    for name, work in chosen:
        cost = in_a_process(work)
        tried += 1
        silent += not cost.well
        good = cost.well and cost.seconds < most_seconds and cost.memory < most_memory
        survived += good
        names += [] if good else [f"{name}: {cost.seconds:.1f} s, {megabytes(cost.memory)}"]
        worst, dearest = max(worst, cost.seconds), max(dearest, cost.memory)
    said = f"greatest {worst:.2f} s, {megabytes(dearest)} beside the program itself"
    return Found(tried, survived, 0, silent, "; ".join([said, *names]))


ROWS = (
    Row("kill", "writers killed with -9 over four rates", kills),
    Row("full", "files that cannot grow, from a random instant to another", full_disk),
    Row("meddle", "logs that another program removes, moves, adds to or cuts while they are written", meddled),
    Row("cut", "a log cut at every byte, some with noise behind, as of a torn write", cuts),
    Row("flip", "one bit flipped", flips),
    Row("bomb", "logs and YAML files that would unpack without end, under 1 s and 300 MB", bombs),
)
