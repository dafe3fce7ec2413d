"""Reading a stranger's file in a process of its own, which may crash alone.

A reader may be wrong about a file nobody has seen before: it may loop, ask for all memory, or
take the process down with it. Started afresh (a fork of a process with threads is not safe), the
child costs about 0.2 s and loads NumPy and one reader.
"""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import handed_to_child, make_memory_file
from paint3d.errors import MeshError
from paint3d.files.progress import Progress
from paint3d.files.reading import Reading, Wanted
from paint3d.files.sandbox.handover import receive
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "MAX_IDLE_SECONDS",
    "MAX_MEMORY",
    "MAX_SECONDS",
    "PICTURE_SECONDS",
    "Watch",
    "read_apart",
    "read_photograph_apart",
    "read_records_apart",
    "refers_to_apart",
]

# ---- Patience ------------------------------------------------------------------------------------
# How long a process is waited for: by what it does with its time, not by the clock.
#
# On a busy machine a good file may take ten times as long as alone. What counts is the time that
# the process computes, and the time in which it does not even want to: asleep, or blocked by a
# disk. Waiting for a core counts as neither, nor does time in which nobody looked: whoever is
# stopped by Ctrl+Z, or starved, was mostly not alone in it.


NANOSECOND = 1e-9
LONGEST_LOOK_S = 0.5  # of the clock, that one look accounts for


class Watch:
    """Watches a process from now on.

    Where the system does not tell how long processes wait for a core (others than Linux), all the
    time of the clock counts as idle.

    Parameters
    ----------
    process_id : int

    Attributes
    ----------
    computed : float
        Seconds of a core that it used, as far as was looked.
    idle : float
        Seconds of the clock in which none of its threads used or waited for a core; of the time
        since the last look no more than half a second.
    """

    def __init__(self, process_id: int) -> None:
        self._threads = Path(f"/proc/{process_id}/task")
        self._before: dict[str, tuple[float, float]] = {}
        self._looked = time.monotonic()
        self.computed = self.idle = 0.0

    def look(self) -> None:
        """Take account of the time since the last look."""
        now, times = time.monotonic(), self._times()
        wanting = 0.0
        for thread, (used, queued) in times.items():
            before = self._before.get(thread, (0.0, 0.0))
            self.computed += used - before[0]
            wanting = max(wanting, used - before[0] + queued - before[1])
        # a thread's waiting is told when it ends: the next look may take back what this one adds
        passed = min(now - self._looked, LONGEST_LOOK_S)
        self.idle = max(0.0, self.idle + passed - wanting)
        self._before, self._looked = times, now

    def _times(self) -> dict[str, tuple[float, float]]:
        """Seconds that each thread has used a core and waited for one."""
        times = {}
        with suppress(OSError):
            for thread in self._threads.iterdir():
                with suppress(OSError, ValueError):  # it may end meanwhile
                    words = (thread / "schedstat").read_text().split()
                    times[thread.name] = (NANOSECOND * int(words[0]), NANOSECOND * int(words[1]))
        return times


# --------------------------------------------------------------------------------------------------


MAX_MEMORY = 2 << 30
MAX_SECONDS = 20  # of computing
MAX_IDLE_SECONDS = 60  # without computing: asleep, or waiting for a disk
LOOK_S = 0.05  # how often it is looked what the child does, and whether it is still wanted
START_S, BYTES_A_SECOND = 0.4, 20e6  # what reading takes, about
PICTURE_SECONDS = 60  # where a mesh is made fine enough for its pictures
START = "import sys, json; sys.path[:] = json.loads(sys.argv.pop()); \
from paint3d.files.sandbox.child import main; main()"


def read_apart(
    path: Path,
    wanted: Wanted,
    seconds: float | None = None,
    progress: Progress | None = None,
    idle_seconds: float = MAX_IDLE_SECONDS,
) -> Reading:
    """Read a mesh file in a child process with 2 GiB of memory and 20 s, with pictures 60 s.

    The seconds are of computing; waiting for a core costs none, and of standing still, as for a
    slow disk, there may be `idle_seconds` besides. `progress` is told a share guessed from the
    file's size; what it raises ends the child.

    Raises
    ------
    MeshError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    if seconds is None:
        seconds = PICTURE_SECONDS if wanted.texture else MAX_SECONDS
    limits = seconds, idle_seconds
    return _reading(*_read_apart(path, "mesh", list(wanted), limits, progress))


def read_photograph_apart(
    path: Path, longest: int, progress: Progress | None = None
) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    """Read a photograph in a child process with 2 GiB of memory and 60 s of computing.

    Parameters
    ----------
    path : Path
    longest : int
        Pixels of its longer side, at the most: larger ones are made smaller.
    progress : callable, optional

    Returns
    -------
    (H, W, 3) uint8
        sRGB codes, upright.
    (int, int)
        Its own height and width.

    Raises
    ------
    InputError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    limits = PICTURE_SECONDS, MAX_IDLE_SECONDS
    arrays, facts = _read_apart(path, "photograph", [longest], limits, progress)
    (height, width), full = facts["size"], facts["full"]
    return arrays["pixels"].reshape(int(height), int(width), 3), (int(full[0]), int(full[1]))


def read_records_apart(
    path: Path,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.int64] | None,
]:
    """Read the paper's records in a child process: what `files.project.records.Records` holds.

    Raises
    ------
    MeshError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    limits = MAX_SECONDS, MAX_IDLE_SECONDS
    arrays, facts = _read_apart(path, "records", [], limits, None)
    arrays = {name: array.copy() for name, array in arrays.items()}
    start = np.array(facts["start"], np.float64)
    places, directions, colours = (arrays[k] for k in ("positions", "directions", "colours"))
    return start, places, directions, colours, arrays.get("rows")


def refers_to_apart(mesh: Path, file: Path) -> bool:
    """Whether a mesh file speaks of another one: asked in a child with limits.

    Nothing is started where the names tell that it cannot. A mesh that reaches the limits speaks
    of nothing: whoever reads it says what is wrong with it.
    """
    from paint3d.files.references import may_refer_to  # few commands ask for it

    if not may_refer_to(mesh, file):
        return False
    limits = MAX_SECONDS, MAX_IDLE_SECONDS
    try:
        _, facts = _read_apart(mesh, "references", [os.fsencode(file).hex()], limits, None)
    except (MeshError, OSError):
        return False
    return facts.get("refers") is True


def _read_apart(
    path: Path,
    kind: str,
    wanted: list[Any],
    limits: tuple[float, float],
    progress: Progress | None,
) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    """What a child process reads of a file: arrays, and facts."""
    descriptor = make_memory_file()
    try:
        _run(path, kind, wanted, descriptor, limits, progress)
        return _received(path, descriptor)
    finally:
        os.close(descriptor)


def _run(
    path: Path,
    kind: str,
    wanted: list[Any],
    descriptor: int,
    limits: tuple[float, float],
    progress: Progress | None,
) -> None:
    number, handed = handed_to_child(descriptor)
    request = {
        "path": os.fsencode(path).hex(),
        "kind": kind,
        "wanted": wanted,
        "file": number,
        "memory": MAX_MEMORY,
        "seconds": math.ceil(limits[0]),  # where its parent cannot look, or is gone
    }
    command = [sys.executable, "-I", "-W", "ignore", "-c", START]
    command += [json.dumps(request), json.dumps([os.path.abspath(entry) for entry in sys.path])]
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,  # nothing comes, but its end tells at once that the child ended
        stderr=subprocess.DEVNULL,
        **handed,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # its threads reserve memory
    ) as child:
        try:
            _wait(child, path, limits, progress)
        except BaseException:
            child.kill()
            raise
    if child.returncode < 0:
        number = -child.returncode
        if number == signal.SIGXCPU:
            raise _too_long(path, limits[0])
        if number == signal.SIGKILL:
            raise MeshError(f"{path}: reading it took too long or too much memory")
        raise MeshError(f"{path}: reading it crashed ({signal.Signals(number).name})")


def _wait(
    child: subprocess.Popen[bytes],
    path: Path,
    limits: tuple[float, float],
    progress: Progress | None,
) -> None:
    """Wait for a child to end, telling how far it should be by now."""
    began, expected = time.monotonic(), START_S
    with suppress(OSError):  # the child says what is wrong with the file
        expected += path.stat().st_size / BYTES_A_SECOND
    watch, (seconds, idle_seconds) = Watch(child.pid), limits
    while True:
        try:
            child.communicate(timeout=LOOK_S)
            return
        except subprocess.TimeoutExpired:
            watch.look()
        if watch.computed >= seconds:
            raise _too_long(path, seconds)
        if watch.idle >= idle_seconds:
            raise MeshError(
                f"{path}: reading it has stood still for {idle_seconds:g} s; "
                "expected a file on a disk that answers"
            )
        if progress is not None:
            gone = time.monotonic() - began
            progress(gone / (gone + expected))


def _too_long(path: Path, seconds: float) -> MeshError:
    return MeshError(
        f"{path}: reading it took longer than {seconds:g} s of computing; expected a simpler file"
    )


def _received(path: Path, descriptor: int) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    try:
        arrays, facts = receive(descriptor)
    except MeshError as cause:
        raise MeshError(
            f"{path}: {cause}: it takes more than {MAX_MEMORY >> 30} GiB, or its reader failed"
        ) from None
    if "error" in facts:
        raise MeshError(str(facts["error"]))
    return arrays, facts


def _reading(arrays: dict[str, AnyArray], facts: dict[str, Any]) -> Reading:
    mesh = TriangleMesh(
        arrays["vertices"],
        arrays["faces"],
        arrays.get("colours"),
        str(facts["name"]),
        arrays.get("normals"),
    )
    notes = tuple(map(str, facts["notes"]))
    knows_up, unit_mm, up = facts["knows_up"], facts["unit_mm"], facts["up"]
    return Reading(mesh, notes, bool(knows_up), float(unit_mm), str(up))
