"""Atomic writing of files: either all of a file appears, or nothing changes.

A program that is killed may leave a temporary file, ``.NAME.paint3d-XXXXXXXXYYYY.SUFFIX``, where X
identifies the machine. While it is written it is locked, where the system has locks; the next
program that writes into the folder removes those that are no longer locked. Network folders may
not share locks between machines: files of other machines are removed when they are a day old.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from paint3d.core.ending import begin_file, forget_file
from paint3d.core.machine import (
    copy_permissions,
    create_locked,
    flush_folder,
    this_machine,
    try_locking,
)
from paint3d.errors import ExportError

__all__ = ["write_atomically"]

_TEMPORARY = re.compile(r"\..*\.paint3d-([0-9a-f]{8})(?:[0-9a-f]{4})?(\..*)?", re.DOTALL)
_OLD_S = 86400.0  # since the last write
_STEM, _SUFFIXES = 20, 32  # characters and bytes: a name has up to 255 bytes, on some systems 143
_TRIES = 100
_TIDY: set[Path] = set()  # folders that this process has tidied


@contextmanager
def write_atomically(
    path: str | os.PathLike[str], progress: Callable[[float], None] | None = None
) -> Iterator[Path]:
    """Yield a temporary path beside `path`; move it over `path` when the block ends well.

    The data are flushed to the disk before the move, so after a crash the old file or the new
    one is there, never half of one. If the block raises, the temporary file is removed and an
    existing file at `path` stays as it was. Where `path` is a symbolic link, the file that it
    leads to is replaced and the link stays. What replaces a file takes over its permissions, and
    its group and owner as far as allowed; a new file has what the user's mask leaves.

    Parameters
    ----------
    path : path-like
        Of the file. The temporary name keeps its suffixes, since some writers choose the format by
        them.
    progress : callable, optional
        Called with 1 when all is written, just before the move; what it raises leaves everything
        as it was.

    Raises
    ------
    ExportError
        If the folder is missing or not writable, writing fails, or `path` is a folder, a pipe or a
        device.
    """
    named = Path(path)
    try:
        target = _behind_links(named)
        _tidy(target.parent)
        temporary, descriptor = _reserve(target)
    except OSError as cause:
        raise ExportError("{file}: cannot write here: {cause}", file=named, cause=cause) from None
    try:
        yield temporary
        with open(temporary, "rb+") as file:
            os.fsync(file.fileno())
        if progress is not None:
            progress(1.0)
        if target.exists():
            copy_permissions(target, temporary)
        os.replace(temporary, target)
        flush_folder(target.parent)
    except OSError as cause:
        raise ExportError("{file}: cannot write: {cause}", file=named, cause=cause) from None
    finally:
        with suppress(OSError):
            temporary.unlink()
        forget_file(temporary)
        if descriptor is not None:
            os.close(descriptor)


def _behind_links(path: Path) -> Path:
    """Resolve symbolic links; the file need not exist. OSError for pipes, devices and loops."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError("it is a pipe or a device; expected a file name")
    if not path.is_symlink():
        return path
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    return target


def _reserve(target: Path) -> tuple[Path, int | None]:
    """Make a temporary file beside the target; return it and its lock (`create_locked`)."""
    if target.is_dir():
        raise IsADirectoryError(f"{target.name or target} is a folder; expected a file name")
    mode = 0o600 if target.exists() else 0o666  # no access for others before `copy_permissions`
    stem, suffixes = target.name[:_STEM], _short_suffixes(target)
    descriptor: int | None = None

    def make() -> Path:
        nonlocal descriptor
        for tries_left in reversed(range(_TRIES)):
            name = f".{stem}.paint3d-{this_machine()}{secrets.token_hex(2)}{suffixes}"
            try:
                descriptor = create_locked(target.parent / name, mode)
                break
            except FileExistsError:
                if not tries_left:
                    raise
        return target.parent / name

    return begin_file(make), descriptor


def _short_suffixes(target: Path) -> str:
    """Return the last two suffixes; fewer if they are long, as parts of a name with points."""
    for n in (2, 1):
        suffixes = "".join(target.suffixes[-n:])
        if len(os.fsencode(suffixes)) <= _SUFFIXES:
            return suffixes
    return ""


def _tidy(folder: Path) -> None:
    """Remove the temporary files that killed programs left in a folder, once a process."""
    if folder in _TIDY:
        return
    _TIDY.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _may_be_stale(entry):
                with suppress(OSError), try_locking(Path(entry.path)) as is_stale:
                    if is_stale:
                        os.unlink(entry.path)


def _may_be_stale(entry: os.DirEntry[str]) -> bool:
    """Return whether it is a temporary file by its name, and this machine's or old."""
    match = _TEMPORARY.fullmatch(entry.name)
    if match is None or not entry.is_file(follow_symlinks=False):
        return False
    if match[1] == this_machine():
        return True
    with suppress(OSError):
        return time.time() - entry.stat(follow_symlinks=False).st_mtime > _OLD_S
    return False
