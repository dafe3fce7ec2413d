"""Cut the saving of a session at every system call, and fill the disk under it, byte by byte.

    python scripts/cut_saves.py [--full-disk FOLDER]

A child process saves a session over an older one and is stopped before each of its system calls
(ptrace, Linux): it is killed at the first, then at the second, and so on until it gets through.
After each death the file must be the old one or the new one, byte for byte. Then the same with
limits on the size of files, as a full disk has them: the old file must be left, and no other.
--full-disk runs that in a folder on a small file system of your own (say, a tmpfs of 64 KiB).
"""

from __future__ import annotations

import argparse
import ctypes
import os
import resource
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from paint3d.colour.pigments import load_pigment
from paint3d.device.recorded import Recording
from paint3d.errors import ExportError
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_plane

__all__ = ["cut_everywhere", "survives_full_disk", "traces"]

TRACE_ME, NEXT_CALL, SET_OPTIONS = 0, 24, 0x4200
MARK_CALLS, DIE_WITH_PARENT = 1, 0x100000
AT_CALL = signal.SIGTRAP | 0x80
_libc = ctypes.CDLL(None, use_errno=True)


def make_session(coats: float) -> Session:
    """Make a small session with wet and dry paint, and a recording."""
    surface = PaintedSurface(make_plane(), resolution=None)
    column = surface.column_of(load_pigment("pine soot"))
    for k in (3, 5):
        surface.ink.amounts[k, column], surface.ink.coverage[k] = coats, 0.5
        surface.touch(np.array([k], np.int32))
    surface.settle(np.array([3], np.int32))
    n = 4
    recording = Recording(np.arange(n), np.zeros((n, 3)), np.tile([1.0, 0, 0, 0], (n, 1)))
    return Session(surface, (recording,), {"coats": coats})


def _trace(request: int, process: int, data: int = 0) -> bool:
    return _libc.ptrace(request, process, None, ctypes.c_void_p(data)) == 0


def run_until_call(action: Callable[[], object], n: int) -> bool:
    """Run `action` in a child that is killed before its system call number `n`.

    Returns
    -------
    bool
        Whether it got through, and so was not killed.
    """
    process = os.fork()
    if process == 0:
        try:
            _trace(TRACE_ME, 0)
            os.kill(os.getpid(), signal.SIGSTOP)
            action()
            os._exit(0)
        finally:
            os._exit(1)
    os.waitpid(process, 0)
    _trace(SET_OPTIONS, process, MARK_CALLS | DIE_WITH_PARENT)
    stops = 0  # one before each call and one after
    while _trace(NEXT_CALL, process):
        _, status = os.waitpid(process, 0)
        if os.WIFEXITED(status):
            if os.WEXITSTATUS(status):
                raise RuntimeError(f"the child failed with status {os.WEXITSTATUS(status)}")
            return True
        if os.WIFSTOPPED(status) and os.WSTOPSIG(status) == AT_CALL:
            if stops == 2 * n:
                os.kill(process, signal.SIGKILL)
                os.waitpid(process, 0)
                return False
            stops += 1
    raise RuntimeError("the child cannot be traced")


def traces() -> bool:
    """Return whether children can be traced here."""
    try:
        return run_until_call(lambda: None, 1000)
    except (RuntimeError, OSError):
        return False


def cut_everywhere(folder: Path) -> tuple[int, int]:
    """Cut a save at every system call; return how many there were, and how many files were old.

    Raises
    ------
    AssertionError
        If a file was neither the old nor the new one.
    """
    old, new = make_session(0.25), make_session(0.75)
    target = folder / "a.p3d"
    save_session(new, target)
    after = target.read_bytes()
    save_session(old, target)
    before = target.read_bytes()
    calls = left_old = 0
    while not run_until_call(lambda: save_session(new, target), calls):
        content = target.read_bytes()
        assert content in (before, after), f"a file of {len(content)} bytes after call {calls}"
        left_old += content == before
        for other in folder.iterdir():
            if other != target:
                other.unlink()
        target.write_bytes(before)
        calls += 1
    assert target.read_bytes() == after
    return calls, left_old


def survives_full_disk(folder: Path, limits: range) -> int:
    """Save with every limit on the size of a file; return how many saves failed as they should.

    Raises
    ------
    AssertionError
        If a failed save changed the file, or left another.
    """
    old, new = make_session(0.25), make_session(0.75)
    target = folder / "a.p3d"
    save_session(old, target)
    before = target.read_bytes()
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    failed = 0
    for limit in limits:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
        try:
            save_session(new, target)
        except ExportError:
            failed += 1
            assert target.read_bytes() == before
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
        assert [file.name for file in folder.iterdir()] == ["a.p3d"]
        target.write_bytes(before)
    return failed


def fill(folder: Path) -> None:
    """Save into a folder whose file system is filled up beforehand, byte by byte less.

    Raises
    ------
    AssertionError
        If a failed save changed the file, or left another.
    """
    target, ballast = folder / "a.p3d", folder / "ballast"
    save_session(make_session(0.25), target)
    before = target.read_bytes()
    new, failed = make_session(0.75), 0
    room = os.statvfs(folder)
    for leave in range(0, 4 * len(before), 4096):
        size = room.f_bavail * room.f_bsize - leave
        ballast.write_bytes(bytes(max(size, 0)))
        try:
            save_session(new, target)
            target.write_bytes(before)
        except ExportError:
            failed += 1
            assert target.read_bytes() == before
        assert sorted(file.name for file in folder.iterdir()) == ["a.p3d", "ballast"]
        ballast.unlink()
    sys.stdout.write(f"{failed} saves failed on a full disk, and left the old file\n")


def main() -> None:
    """Run what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--full-disk", metavar="FOLDER", type=Path)
    options = parser.parse_args()
    if options.full_disk is not None:
        fill(options.full_disk)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        calls, left_old = cut_everywhere(folder)
        sys.stdout.write(
            f"killed before each of {calls} system calls: {left_old} times the old file, "
            f"{calls - left_old} times the new one\n"
        )
        size = (folder / "a.p3d").stat().st_size
        failed = survives_full_disk(folder, range(0, size + 64, 7))
        sys.stdout.write(f"{failed} saves failed for want of room, and left the old file\n")
        load_session(folder / "a.p3d")


if __name__ == "__main__":
    main()
