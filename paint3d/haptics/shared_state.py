"""Memory that the program and the servo share: the surface once, snapshots in, samples out.

One side writes each part. A snapshot is guarded by a counter that is odd while it is written (a
seqlock): the reader tries again, and keeps what it had if it never gets a whole one. Samples go
through a ring whose head is moved after its entry is written; a reader that falls behind by more
than the ring holds is told how many it lost. The order of plain stores is that of x86 and of the
interpreter; both sides only ever look at numbers of eight bytes.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import reserve_space
from paint3d.errors import DeviceError
from paint3d.mesh.kernels.bvh import ContactTree

__all__ = [
    "BIN_US",
    "RING_COLUMNS",
    "SNAPSHOT_COLUMNS",
    "ServoBoard",
    "TreeBlock",
    "make_shared_memory",
    "percentile_us",
]

# ---- Shared memory -------------------------------------------------------------------------------
# Memory that a device's process shares with the program, with its room taken when it is made.
#
# Where shared memory is a small disk of its own, as in most containers, a page for which there is
# no room ends whoever writes there, without a word.


_DISK = Path("/dev/shm")  # on Linux


def make_shared_memory(n_bytes: int) -> SharedMemory:
    """Return new memory that other processes attach by its name; whoever holds it unlinks it.

    Raises
    ------
    DeviceError
        If there is no room for it.
    """
    try:
        memory = SharedMemory(create=True, size=max(n_bytes, 1))
    except OSError as cause:
        raise _no_room(n_bytes, cause) from None
    try:
        with suppress(FileNotFoundError), open(_DISK / memory.name, "r+b") as file:
            reserve_space(file, memory.size)
    except OSError as cause:
        memory.close()
        memory.unlink()
        raise _no_room(n_bytes, cause) from None
    return memory


def _no_room(n_bytes: int, cause: OSError) -> DeviceError:
    return DeviceError(
        f"no {1e-6 * n_bytes:.3g} MB of memory to share with the stylus' process "
        f"({cause.strerror}); expected room for them in {_DISK}: a container is given more of it "
        "when it is started (--shm-size)"
    )


# --------------------------------------------------------------------------------------------------


SNAPSHOT_COLUMNS = 32
"""time (as int64 bits), object pose (7), settings (22), spare."""
_RING_ROWS = 8192
RING_COLUMNS = 16
"""time (as int64 bits), root (3), orientation (4), buttons, force (3), descent, flags, spare."""
BIN_US = 10
_BINS = 1000
_COUNTERS = 32
_TEXT = 512

# Counters of the board, all int64.
SEQUENCE, HEAD, STATE, STEPS, LATE, LONGEST_NS, REFUSED = range(7)
PID, SCHEDULE, BEAT_NS, STOP, SOFTENING_PPM, WORST_STEP_NS = range(7, 13)
STARTING, RUNNING, STOPPED, FAILED = range(4)


@dataclass(frozen=True)
class TreeBlock:
    """Where a contact tree lies in shared memory: name and (shape, type, offset) of its arrays."""

    name: str
    parts: tuple[tuple[tuple[int, ...], str, int], ...]

    @classmethod
    def share(cls, tree: ContactTree) -> tuple[TreeBlock, SharedMemory]:
        """Copy a tree into new shared memory; whoever holds the memory unlinks it.

        Raises
        ------
        DeviceError
            If there is no room for it.
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
        """The tree in another process; keep the memory as long as the tree."""
        memory = SharedMemory(name=self.name)
        views = self._views(memory)
        for view in views:
            view.view(np.uint8).reshape(-1)[::4096].sum()  # touch every page now, not in the loop
        return ContactTree(*views), memory

    def _views(self, memory: SharedMemory) -> list[AnyArray]:
        return [np.ndarray(shape, dtype, memory.buf, offset) for shape, dtype, offset in self.parts]


class ServoBoard:
    """The board that both sides write on; see the module.

    Parameters
    ----------
    name : str, optional
        Of an existing board; None makes one, which this object then owns.

    Raises
    ------
    DeviceError
        If there is no room for a new one.
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
        """Write a snapshot: where the object is, and what the force depends on."""
        row = np.zeros(SNAPSHOT_COLUMNS)
        row[:1].view(np.int64)[0] = time_ns
        row[1:8] = object_pose
        row[8 : 8 + len(settings)] = settings
        self.counters[SEQUENCE] += 1
        self._snapshot[:] = row
        self.counters[SEQUENCE] += 1

    def read_snapshot(self, out: AnyArray) -> bool:
        """Copy the last whole snapshot into `out` (32,); False if there is none to be had."""
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
        """Samples since the last call (N, RING_COLUMNS), and how many were lost before them."""
        head = int(self.counters[HEAD])
        first = max(self._tail, head - _RING_ROWS + 64)
        lost = first - self._tail
        rows = self._ring[np.arange(first, head) % _RING_ROWS]
        self._tail = head
        return rows, lost

    # -- statistics -------------------------------------------------------------------------

    def note(self, bins: AnyArray, nanoseconds: int) -> None:
        """Count a time in a histogram of 10 us bins."""
        bins[min(nanoseconds // (1000 * BIN_US), _BINS - 1)] += 1

    def explain(self, fault: str) -> None:
        """Write down why the servo ended."""
        data = fault.encode()[: _TEXT - 1]
        self._text[: len(data)] = np.frombuffer(data, np.uint8)

    def fault(self) -> str:
        """Why the servo ended; empty where nothing went wrong."""
        return self._text.tobytes().rstrip(b"\0").decode(errors="replace")

    def close(self) -> None:
        """Let the memory go; its owner also removes it."""
        del self.counters, self._snapshot, self._ring, self.periods, self.durations, self._text
        self._memory.close()
        if self._owner:
            self._memory.unlink()


def percentile_us(bins: AnyArray, percent: float) -> float:
    """A percentile of a histogram of 10 us bins: the upper edge of its bin, us."""
    total = int(bins.sum())
    if total == 0:
        return float("nan")
    reached = np.searchsorted(np.cumsum(bins), percent / 100.0 * total)
    return float((int(reached) + 1) * BIN_US)
