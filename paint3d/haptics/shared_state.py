"""Shared memory of the program and the servo: the surface once, snapshots in, samples out.

Each part has one writer. A snapshot is guarded by a seqlock, a counter that is odd during a write:
the reader retries, and keeps its old snapshot if it never gets a consistent one. Samples go through
a ring buffer whose head advances after an entry is written; a reader that falls behind by more than
its capacity learns how many it lost. There are no memory barriers: this relies on x86's order of
stores and the interpreter's, and on all numbers being of eight bytes.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import reserve_space
from paint3d.errors import DeviceError, Message
from paint3d.mesh.kernels.bvh import ContactTree

__all__ = [
    "RING_COLUMNS",
    "SNAPSHOT_COLUMNS",
    "ServoBoard",
    "TreeBlock",
    "make_shared_memory",
    "percentile_us",
]

# ---- Allocation ----------------------------------------------------------------------------------

_DISK = Path("/dev/shm")  # on Linux


def make_shared_memory(n_bytes: int) -> SharedMemory:
    """Allocate memory that other processes attach by its name; the caller must unlink it.

    Raises
    ------
    DeviceError
        If there is too little memory.
    """
    try:
        memory = SharedMemory(create=True, size=max(n_bytes, 1))
    except OSError as cause:
        raise _too_little_memory(n_bytes, cause) from None
    try:
        # /dev/shm may be a small disk, as in most containers. A write to a page that does not fit
        # on it would then kill the process, so all pages are reserved now.
        with suppress(FileNotFoundError), open(_DISK / memory.name, "r+b") as file:
            reserve_space(file, memory.size)
    except OSError as cause:
        memory.close()
        memory.unlink()
        raise _too_little_memory(n_bytes, cause) from None
    return memory


def _too_little_memory(n_bytes: int, cause: OSError) -> DeviceError:
    return DeviceError(
        "{megabytes:.3g} MB of memory to share with the stylus' process cannot be allocated "
        "({cause}); expected as much in {disk}: a container gets more when it is started with a "
        "larger one",
        hint="--shm-size",
        megabytes=1e-6 * n_bytes,
        cause=cause,
        disk=_DISK,
    )


# ---- The board -----------------------------------------------------------------------------------

SNAPSHOT_COLUMNS = 32
"""time (as int64 bits), object pose (7), settings (22), spare."""
_RING_ROWS = 8192
RING_COLUMNS = 16
"""time (as int64 bits), root (3), orientation (4), buttons, force (3), descent, flags, spare."""
BIN_US = 10
_BINS = 1000
_COUNTERS = 32
_TEXT = 2048

# Counters of the board, all int64.
SEQUENCE, HEAD, STATE, STEPS, LATE, LONGEST_NS, REFUSED = range(7)
PID, SCHEDULE, BEAT_NS, STOP, SOFTENING_PPM, WORST_STEP_NS = range(7, 13)
STARTING, RUNNING, STOPPED, FAILED = range(4)


@dataclass(frozen=True)
class TreeBlock:
    """A contact tree in shared memory: its name, and (shape, type, offset) of the arrays."""

    name: str
    parts: tuple[tuple[tuple[int, ...], str, int], ...]

    @classmethod
    def allocate(cls, tree: ContactTree) -> tuple[TreeBlock, SharedMemory]:
        """Copy a tree into new shared memory, which the caller must unlink.

        Raises
        ------
        DeviceError
            If there is too little memory.
        """
        parts, offset = [], 0
        for array in tree:
            parts.append((array.shape, array.dtype.str, offset))
            offset += -(-array.nbytes // 64) * 64
        memory = make_shared_memory(offset)
        block = cls(memory.name, tuple(parts))
        for view, array in zip(block._views(memory), tree, strict=True):
            view[...] = array
        return block, memory

    def attach(self) -> tuple[ContactTree, SharedMemory]:
        """Attach the tree in another process; the memory must outlive it."""
        memory = SharedMemory(name=self.name)
        views = self._views(memory)
        for view in views:
            view.view(np.uint8).reshape(-1)[::4096].sum()  # touch every page now, not in the loop
        return ContactTree(*views), memory

    def _views(self, memory: SharedMemory) -> list[AnyArray]:
        return [np.ndarray(shape, dtype, memory.buf, offset) for shape, dtype, offset in self.parts]


class ServoBoard:
    """Counters, snapshot, ring of samples and histograms in shared memory; see the module.

    Parameters
    ----------
    name : str, optional
        Of an existing board; None makes one that this object owns.

    Raises
    ------
    DeviceError
        If there is too little memory for a new one.
    """

    def __init__(self, name: str | None = None) -> None:
        sizes = [_COUNTERS, SNAPSHOT_COLUMNS, _RING_ROWS * RING_COLUMNS, _BINS, _BINS, _TEXT // 8]
        self._owner = name is None
        self._memory = (
            make_shared_memory(8 * sum(sizes)) if name is None else SharedMemory(name=name)
        )
        self.name = self._memory.name
        ends = np.cumsum([0, *sizes]) * 8
        buffer = self._memory.buf
        self.counters = np.ndarray(_COUNTERS, np.int64, buffer, ends[0])
        self._snapshot = np.ndarray(SNAPSHOT_COLUMNS, np.float64, buffer, ends[1])
        self._ring = np.ndarray((_RING_ROWS, RING_COLUMNS), np.float64, buffer, ends[2])
        self.periods = np.ndarray(_BINS, np.int64, buffer, ends[3])
        self.durations = np.ndarray(_BINS, np.int64, buffer, ends[4])
        self._text = np.ndarray(_TEXT, np.uint8, buffer, ends[5])
        self._tail = 0

    # -- snapshots: program to servo --------------------------------------------------------

    def publish(self, time_ns: int, object_pose: AnyArray, settings: AnyArray) -> None:
        """Write a snapshot of the object's pose (7,) and the settings."""
        row = np.zeros(SNAPSHOT_COLUMNS)
        row[:1].view(np.int64)[0] = time_ns
        row[1:8] = object_pose
        row[8 : 8 + len(settings)] = settings
        self.counters[SEQUENCE] += 1
        self._snapshot[:] = row
        self.counters[SEQUENCE] += 1

    def read_snapshot(self, out: AnyArray) -> bool:
        """Copy the last snapshot into `out` (32,); return False if no consistent one was read."""
        for _ in range(4):
            before = self.counters[SEQUENCE]
            if before == 0:
                return False
            if before & 1:
                continue
            out[:] = self._snapshot
            if self.counters[SEQUENCE] == before:
                return True
        return False

    # -- samples: servo to program ----------------------------------------------------------

    def push(self, row: AnyArray) -> None:
        """Add a sample (RING_COLUMNS,)."""
        head = int(self.counters[HEAD])
        self._ring[head % _RING_ROWS] = row
        self.counters[HEAD] = head + 1

    def take(self) -> tuple[NDArray[np.float64], int]:
        """Return samples since the last call (N, RING_COLUMNS), and how many were lost before."""
        head = int(self.counters[HEAD])
        first = max(self._tail, head - _RING_ROWS + 64)  # the writer may overwrite the oldest now
        lost = first - self._tail
        rows = self._ring[np.arange(first, head) % _RING_ROWS]
        self._tail = head
        return rows, lost

    # -- statistics -------------------------------------------------------------------------

    def count(self, bins: AnyArray, nanoseconds: int) -> None:
        """Count a time in a histogram of 10 us bins."""
        bins[min(nanoseconds // (1000 * BIN_US), _BINS - 1)] += 1

    def store_fault(self, fault: Message) -> None:
        """Store why the servo ended; a message that is too long is cut."""
        for message in (fault, Message(fault[: _TEXT // 8])):
            data = json.dumps(message.to_json(), ensure_ascii=False).encode()
            if len(data) <= _TEXT:
                break
        self._text[: len(data)] = np.frombuffer(data, np.uint8)

    def fault(self) -> Message | None:
        """Return why the servo ended; None if nothing went wrong."""
        data = self._text.tobytes().rstrip(b"\0")
        return Message.from_json(json.loads(data)) if data else None

    def close(self) -> None:
        """Release the memory; its owner also unlinks it."""
        del self.counters, self._snapshot, self._ring, self.periods, self.durations, self._text
        self._memory.close()
        if self._owner:
            self._memory.unlink()


def percentile_us(bins: AnyArray, percent: float) -> float:
    """Compute a percentile of a histogram of 10 us bins: the upper edge of its bin, us."""
    total = int(bins.sum())
    if total == 0:
        return float("nan")
    reached = np.searchsorted(np.cumsum(bins), percent / 100.0 * total)
    return float((int(reached) + 1) * BIN_US)
