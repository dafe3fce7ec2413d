"""Strangers' files, read in processes forked from one that has imported what reads them.

Starting Python and importing is nearly all that a small file costs. The child that users have reads
the first file of each kind, which says by what packages it is read, and whatever comes with limits
of its own.
"""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import reduction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from paint3d.files import sandbox
from tests.support.forked import forkserver

__all__ = ["reading_by_forks"]

_COMMAND = [sys.executable, "-I", "-W", "ignore", "-c", sandbox.START]
_SECONDS = {math.ceil(sandbox.MAX_SECONDS), math.ceil(sandbox.PICTURE_SECONDS)}
_MEMORY = sandbox.MAX_MEMORY
_PACKED = re.compile(rb"KHR_draco|EXT_meshopt")  # in a glTF: unpacked by a package of its own


class _Handed:
    """An open file that a forked process gets, too."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def __reduce__(self) -> tuple[Any, ...]:
        return _as_it_is, (reduction.DupFd(self._descriptor),)


def _as_it_is(handed: Any) -> Any:
    return handed


def _be_the_child(request: dict[str, Any], file: Any, environment: dict[str, str], cwd: str):
    """The child of `sandbox` in a process that was forked when its modules were there."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for number in range(3):
        os.dup2(nowhere, number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(cwd)
    warnings.simplefilter("ignore")
    sys.argv = ["-c", json.dumps({**request, "file": file.detach()})]
    sandbox.main()


class _Forked:
    """The part of `subprocess.Popen` that `sandbox` uses."""

    def __init__(self, request: dict[str, Any], environment: dict[str, str]) -> None:
        handed = _Handed(request["file"])
        self._process = forkserver().Process(
            target=_be_the_child, args=(request, handed, environment, os.getcwd())
        )
        self._process.start()
        self.pid = self._process.pid

    def __enter__(self) -> _Forked:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.join()

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def communicate(self, timeout: float) -> None:
        self._process.join(timeout)
        if self._process.exitcode is None:
            raise subprocess.TimeoutExpired(_COMMAND, timeout)

    def kill(self) -> None:
        self._process.kill()


def _usual(command: list[str]) -> dict[str, Any] | None:
    """Return whether a child is wanted with the usual limits, in our own environment."""
    *begin, said, path = command
    request: dict[str, Any] = json.loads(said)
    limited = request["memory"] == _MEMORY and request["seconds"] in _SECONDS
    here = json.loads(path) == [os.path.abspath(entry) for entry in sys.path]
    return request if begin == _COMMAND and limited and here else None


def _kind(request: dict[str, Any]) -> tuple[object, ...]:
    """Return what decides which packages read a file."""
    path = Path(os.fsdecode(bytes.fromhex(request["path"])))
    packed: set[bytes] = set()
    with suppress(OSError):
        packed |= set(_PACKED.findall(path.read_bytes()))
    with_pictures = request["wanted"][2:3] == [True]
    return request["reader"], *Path(path.name.lower()).suffixes[-2:], *sorted(packed), with_pictures


@contextmanager
def reading_by_forks() -> Iterator[None]:
    """Read files in forks, all but the first of each kind."""
    seen: set[tuple[object, ...]] = set()

    def start(command: list[str], **how: Any) -> subprocess.Popen[bytes] | _Forked:
        request = _usual(command)
        if request is None:
            return subprocess.Popen(command, **how)
        kind = _kind(request)
        if kind not in seen:
            seen.add(kind)
            return subprocess.Popen(command, **how)
        return _Forked(request, how["env"])

    before = sandbox.subprocess
    sandbox.subprocess = SimpleNamespace(
        Popen=start,
        DEVNULL=subprocess.DEVNULL,
        PIPE=subprocess.PIPE,
        TimeoutExpired=subprocess.TimeoutExpired,
    )
    try:
        yield
    finally:
        sandbox.subprocess = before
