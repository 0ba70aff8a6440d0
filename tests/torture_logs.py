"""Tortures of logs: killed writers, full disks, meddling, cuts and torn writes, flips."""

import mmap
import os
import resource
import signal
import struct
import time
from pathlib import Path

import numpy as np
from mcap.writer import MCAP0_MAGIC
from torture_rows import Found, Row, part_of, until

from bearing_twin.base.errors import LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.raw_log import RawLogWriter, Safety, recover

MAX_LOSS, ALLOWED = 0.1, 0.15  # s: of the log, and with 50 ms for the flush itself
RATES = (1.0, 20.0, 500.0, 5000.0)  # messages a second
STATE = struct.Struct("<Q")
MOST_NUMBERS = 200_000


def clock_log(path, **safety) -> tuple[RawLogWriter, int]:
    """A log of one topic, and its number."""
    log = RawLogWriter(path, safety=Safety(**safety))
    return log, log.add_topic("/clock", cdr.CLOCK)


def _write_until_killed(path, rate: float, shared) -> None:
    """Writes numbered messages at `rate`; `shared` holds how many there are, and when each was handed over."""
    log, topic = clock_log(path, max_loss=MAX_LOSS, patient=True)
    began = time.monotonic()
    for number in range(MOST_NUMBERS):
        while (remaining := began + number / rate - time.monotonic()) > 0.0:
            time.sleep(remaining)
        now = time.monotonic()
        log.write(topic, number, int(now * 1e9), STATE.pack(number))
        shared[number + 1] = now
        shared[0] = number + 1


def kills(share: float, folder: Path) -> Found:
    """Writers killed with -9 at random instants: what was handed over more than `ALLOWED` before is in the log.

    Of a machine that has nothing else to do: it may let no thread wait.
    """
    random, trials = np.random.default_rng(1), part_of(40, share, len(RATES))
    survived = lost = silent = 0
    worst, path = 0.0, folder / "killed.mcap"
    for k in range(trials):
        shared = np.frombuffer(mmap.mmap(-1, 8 * (1 + MOST_NUMBERS)))
        child = os.fork()
        if child == 0:
            try:
                _write_until_killed(path, RATES[k % len(RATES)], shared)
            finally:
                os._exit(1)
        until(lambda shared=shared: shared[0] > 0, 300.0)
        time.sleep(random.uniform(0.1, 0.5))
        killed = time.monotonic()
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        written = _numbers(path, folder)
        loss = killed - shared[1 + len(written) : 1 + int(shared[0])]  # ages of what is missing
        delayed = int(np.sum(loss > ALLOWED))
        worst = max(worst, loss.max(initial=0.0))
        lost += delayed
        survived += not delayed
        silent += written != list(range(len(written)))
        path.unlink()
    return Found(trials, survived, lost, silent, f"max_loss {MAX_LOSS} s, greatest loss {1e3 * worst:.0f} ms")


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
        numbers = [struct.unpack_from("<Q", message.data)[0] for message in raw_messages(path)]
        missing = set(flushed) - set(numbers)
        lost += len(missing)
        silent += len(numbers) + log.dropped != 600
        survived += not missing and numbers[-1] == 599 and len(numbers) + log.dropped == 600
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
        path, way, removed_at = folder / "meddled.mcap", ways[k % len(ways)], int(random.integers(1, 500))
        log, topic = clock_log(path, patient=True)
        reported = False
        try:
            for number in range(500):
                if number == removed_at:
                    way(path)
                log.write(topic, number, number, struct.pack("<Q", number) + random.bytes(100))
                if number % 7 == 0:
                    log.flush()
            log.close()
        except LogError:
            reported = True
        present = moved if moved.exists() else path
        numbers = [] if reported else [STATE.unpack_from(message.data)[0] for message in raw_messages(present)]
        complete, gone = numbers == list(range(500)), way in (ways[0], ways[-1])
        lost += not complete and not gone
        silent += not complete and not reported
        survived += reported if gone else complete
        present.unlink(missing_ok=True)
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


def _tried(path: Path, complete: list, folder: Path) -> tuple[list | None, list, bool]:
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
    content, complete = _small_log(folder)
    step, random = max(1, round(1.0 / share)), np.random.default_rng(2)
    attempts = survived = lost = silent = 0
    path, least = folder / "cut.mcap", 0
    for length in range(0, len(content), step):
        greater = int(random.integers(1, 5000))
        path.write_bytes(content[:length] + (b"", bytes(greater), random.bytes(greater))[attempts % 3])
        read, saved, well = _tried(path, complete, folder)
        attempts += 1
        smaller = len(saved) < least
        least = max(least, len(saved))
        wrong = (read is not None and read != complete) or saved != complete[: len(saved)] or not well
        silent += wrong
        lost += smaller
        survived += not (wrong or smaller)
    lost += len(complete) - least
    return Found(attempts, survived, lost, silent, f"{len(content)} bytes, {len(complete)} messages in {CHUNKS} chunks")


def flips(share: float, folder: Path) -> Found:
    """One bit flipped anywhere: no other message is ever read; recover loses one chunk at most."""
    content, complete = _small_log(folder)
    random, trials = np.random.default_rng(5), part_of(3000, share, 100)
    survived = lost = silent = 0
    path, known = folder / "flipped.mcap", set(complete)
    for _ in range(trials):
        data = bytearray(content)
        data[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        path.write_bytes(data)
        read, saved, well = _tried(path, complete, folder)
        header = data[: len(MCAP0_MAGIC)] != MCAP0_MAGIC  # of a file that is no log any more, nothing is promised
        wrong = (read is not None and read != complete) or not known.issuperset(saved) or not well
        few = len(saved) < len(complete) - CHUNK_MESSAGES and not header
        silent += wrong
        lost += few
        survived += not (wrong or few)
    return Found(trials, survived, lost, silent, "lost: flips that cost more than a chunk")


ROWS = (
    Row("kill", "writers killed with -9 over four rates", kills),
    Row("full", "files that cannot grow, from a random instant to another", full_disk),
    Row("meddle", "logs that another program removes, moves, adds to or cuts while they are written", meddled),
    Row("cut", "a log cut at every byte, some with noise behind, as of a torn write", cuts),
    Row("flip", "one bit flipped", flips),
)
