"""Reading of strangers' files in a child process, which may crash alone.

A reader may be wrong about a file nobody has seen before: it may loop, ask for all memory, or
take the process down with it. Started afresh (a fork of a process with threads is not safe), the
child costs about 0.2 s and loads NumPy and one reader. It limits itself before it looks at the
file: memory, processor time and the size of what is handed back; where the system can, it then
neither writes files nor reaches a network nor starts programs (`core.confinement`). The arrays come
back in one memory file, of which the parent trusts nothing.
"""

from __future__ import annotations

import json
import math
import mmap
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, TypeAlias

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.confinement import LANDLOCK, SECCOMP, confine_process
from paint3d.core.machine import inherit_file, limit_process, make_memory_file, open_inherited
from paint3d.errors import InputError, MeshError, Message
from paint3d.files.progress import Progress

__all__ = [
    "MAX_IDLE_SECONDS",
    "MAX_MEMORY",
    "MAX_SECONDS",
    "PICTURE_SECONDS",
    "Found",
    "Watch",
    "main",
    "notes_of",
    "read_apart",
    "receive",
    "send",
]

Found: TypeAlias = tuple[dict[str, AnyArray], dict[str, Any]]
"""What a reader found: arrays, and facts that JSON can hold."""

MAX_MEMORY = 2 << 30
MAX_SECONDS = 20  # of computing
MAX_IDLE_SECONDS = 60  # without computing: asleep, or waiting for a disk
POLL_S = 0.05  # how often it is looked what the child does, and whether it is still wanted
START_S, BYTES_A_SECOND = 0.4, 20e6  # what reading takes, about
PICTURE_SECONDS = 60  # where a mesh is made fine enough for its pictures
_UNCONFINED = Message(
    "its reader was held by limits of memory and time alone: this system has neither Landlock nor "
    "seccomp; open only files that you trust"
)
_noted = threading.Event()  # that this process has said so
START = "import sys, json; sys.path[:] = json.loads(sys.argv.pop()); \
from paint3d.files.sandbox import main; main()"


def read_apart(
    path: Path,
    reader: str,
    wanted: list[Any],
    seconds: float = MAX_SECONDS,
    idle_seconds: float = MAX_IDLE_SECONDS,
    progress: Progress | None = None,
) -> Found:
    """Read a file in a child process with 2 GiB of memory and some seconds of computing.

    Waiting for a core costs none of them; of standing still, as for a slow disk, there may be
    `idle_seconds` besides.

    Parameters
    ----------
    path : Path
    reader : str
        ``module:function`` of the function that the child calls with `path` and `wanted`; it
        returns arrays (N, 3) of the names in `TYPES`, and facts that JSON can hold. To these comes
        ``is_confined``; see `notes_of`.
    wanted : list
        What JSON can hold.
    seconds, idle_seconds : float
    progress : callable, optional
        Given a fraction guessed from the file's size; what it raises ends the child.

    Raises
    ------
    MeshError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    limits = seconds, idle_seconds
    descriptor = make_memory_file()
    try:
        _run_child(path, reader, wanted, descriptor, limits, progress)
        try:
            arrays, facts = receive(descriptor)
        except MeshError as cause:
            raise MeshError(
                "{file}: {cause}: it takes more than {most} GiB, or its reader failed",
                file=path,
                cause=cause,
                most=MAX_MEMORY >> 30,
            ) from None
    finally:
        os.close(descriptor)
    if "error" in facts:
        raise MeshError(Message.from_json(facts["error"]), hint=facts["hint"])
    return arrays, facts


def notes_of(facts: Mapping[str, Any]) -> tuple[Message, ...]:
    """Notes on the child that read a file: on first use, if nothing confined it.

    Parameters
    ----------
    facts : mapping
        From `read_apart`.
    """
    if facts.get("is_confined") is True or _noted.is_set():
        return ()
    _noted.set()
    return (_UNCONFINED,)


def _run_child(
    path: Path,
    reader: str,
    wanted: list[Any],
    descriptor: int,
    limits: tuple[float, float],
    progress: Progress | None,
) -> None:
    number, handed = inherit_file(descriptor)
    request = {
        "path": os.fsencode(path).hex(),
        "reader": reader,
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
            _wait_for(child, path, limits, progress)
        except BaseException:
            child.kill()
            raise
    if child.returncode < 0:
        number = -child.returncode
        if number == signal.SIGXCPU:
            raise _too_long(path, limits[0])
        if number == signal.SIGKILL:
            raise MeshError("{file}: reading it took too long or too much memory", file=path)
        raise MeshError(
            "{file}: reading it crashed ({signal})",
            file=path,
            signal=signal.Signals(number).name,
        )


def _wait_for(
    child: subprocess.Popen[bytes],
    path: Path,
    limits: tuple[float, float],
    progress: Progress | None,
) -> None:
    """Wait for a child to end, reporting its estimated progress."""
    began, expected = time.monotonic(), START_S
    with suppress(OSError):  # the child says what is wrong with the file
        expected += path.stat().st_size / BYTES_A_SECOND
    watch, (seconds, idle_seconds) = Watch(child.pid), limits
    while True:
        try:
            child.communicate(timeout=POLL_S)
            return
        except subprocess.TimeoutExpired:
            watch.look()
        if watch.computed >= seconds:
            raise _too_long(path, seconds)
        if watch.idle >= idle_seconds:
            raise MeshError(
                "{file}: reading it has stood still for {idle_seconds:g} s; expected a file on a "
                "disk that answers",
                file=path,
                idle_seconds=idle_seconds,
            )
        if progress is not None:
            gone = time.monotonic() - began
            progress(gone / (gone + expected))


def _too_long(path: Path, seconds: float) -> MeshError:
    return MeshError(
        "{file}: reading it took longer than {seconds:g} s of computing; expected a simpler file",
        file=path,
        seconds=seconds,
    )


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


# ---- The child -----------------------------------------------------------------------------------


def main() -> None:
    """Run the child: read the file of the request, JSON in the first argument; send it back."""
    request = json.loads(sys.argv[1])
    limit_process(int(request["memory"]), int(request["seconds"]))
    read = resolve_name(request["reader"])
    is_confined = not {LANDLOCK, SECCOMP}.isdisjoint(confine_process())

    path = Path(os.fsdecode(bytes.fromhex(request["path"])))
    descriptor = open_inherited(int(request["file"]))
    try:
        arrays, facts = read(path, request["wanted"])
    except InputError as cause:
        send(descriptor, {}, {"error": cause.message.to_json(), "hint": cause.hint})
        return
    send(descriptor, arrays, {**facts, "is_confined": is_confined})


# ---- From the child to its parent ----------------------------------------------------------------
# A JSON line, then the numbers. The line's length, the arrays' types and the sum of their sizes are
# checked against the file before any of it is used.


MAX_LINE = 1 << 20
TYPES = {"vertices": "<f4", "faces": "<i4", "normals": "<f4", "colours": "|u1", "pixels": "|u1"}
TYPES |= {"positions": "<f8", "directions": "<f8", "rows": "<i8"}  # of records
NUMBERS_A_ROW = 3
_ALIGNED = 8  # where numbers begin: kernels take no others


def send(descriptor: int, arrays: Mapping[str, AnyArray], facts: Mapping[str, Any]) -> None:
    """Write arrays of the types in `TYPES`, (N, 3) each, and what JSON can hold besides."""
    rows = {name: len(array) for name, array in arrays.items()}
    line = json.dumps({"rows": rows, "facts": facts}).encode("ascii")
    line += b" " * (-(4 + len(line)) % _ALIGNED)
    with open(descriptor, "wb", closefd=False) as file:
        file.write(len(line).to_bytes(4, "little") + line)
        for name, array in arrays.items():
            file.write(np.ascontiguousarray(array, TYPES[name]).data)


def receive(descriptor: int) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    """Return what `send` wrote; the arrays are views of the file and cannot be written.

    Raises
    ------
    MeshError
        If it is not whole.
    """
    size = os.fstat(descriptor).st_size
    try:
        if size < 4:
            raise ValueError
        data = mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
        length = int.from_bytes(data[:4], "little")
        if length > min(MAX_LINE, size - 4):
            raise ValueError
        message = json.loads(data[4 : 4 + length])
        rows, facts, at = message["rows"], message["facts"], 4 + length
        row_bytes = {name: NUMBERS_A_ROW * np.dtype(TYPES[name]).itemsize for name in rows}
        if at + sum(row_bytes[name] * int(n) for name, n in rows.items()) != size:
            raise ValueError
        arrays = {}
        for name, n in rows.items():
            dtype = np.dtype(TYPES[name])
            arrays[name] = np.frombuffer(data, dtype, NUMBERS_A_ROW * n, at).reshape(n, -1)
            at += arrays[name].nbytes
        return arrays, dict(facts)
    except (ValueError, KeyError, TypeError, AttributeError, OSError):
        raise MeshError("reading it ended early") from None
