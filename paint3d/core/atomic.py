"""Writing a file so that either all of it appears or nothing changes.

A program that is killed may leave a temporary file, ``.NAME.paint3d-XXXXXXXXYYYY.SUFFIX``, where X
tells the machine. As long as it is written it is locked, where the system has locks; the next
program that writes into the folder removes those that nobody writes any more. Not all folders that
machines share have locks that they share: another machine's are removed when they are a day old.
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
    flush_folder,
    hold_new,
    nobodys,
    this_machine,
)
from paint3d.errors import ExportError

__all__ = ["write_atomically"]

_LEFT = re.compile(r"\..*\.paint3d-([0-9a-f]{8})(?:[0-9a-f]{4})?(\..*)?", re.DOTALL)
_OLD_S = 86400.0  # since it was written to last
_STEM, _SUFFIXES = 20, 32  # characters and bytes: a name has up to 255 bytes, on some systems 143
_TRIES = 100
_TIDY: set[Path] = set()  # folders that were looked through by this process


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
        Where the file is wanted. The temporary name keeps its suffixes, since some writers
        choose the format by them.
    progress : callable, optional
        Called with 1 when all is written, just before the move; what it raises leaves everything
        as it was.

    Raises
    ------
    ExportError
        If the folder is missing or not writable, the system refuses the writing, or `path` is no
        plain file: of a pipe or a device nothing could be replaced.
    """
    named = Path(path)
    try:
        target = _behind_links(named)
        _tidy(target.parent)
        temporary, held = _reserve(target)
    except OSError as cause:
        raise ExportError("{file}: cannot write here: {cause}", file=named, cause=cause) from None
    try:
        yield temporary
        _flush(temporary)
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
        if held is not None:
            os.close(held)


def _behind_links(path: Path) -> Path:
    """The file that a path leads to, through all symbolic links; it need not be there."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError("it is a pipe or a device; expected a file name")
    if not path.is_symlink():
        return path
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    return target


def _reserve(target: Path) -> tuple[Path, int | None]:
    """A new file beside the target, and what keeps it locked; see `hold_new`."""
    if target.is_dir():
        raise IsADirectoryError(f"{target.name or target} is a folder; expected a file name")
    mode = 0o600 if target.exists() else 0o666  # nobody else may look before `copy_permissions`
    stem, suffixes = target.name[:_STEM], _short_suffixes(target)
    held: int | None = None

    def make() -> Path:
        nonlocal held
        for left in reversed(range(_TRIES)):
            name = f".{stem}.paint3d-{this_machine()}{secrets.token_hex(2)}{suffixes}"
            try:
                held = hold_new(target.parent / name, mode)
                break
            except FileExistsError:
                if not left:
                    raise
        return target.parent / name

    return begin_file(make), held


def _short_suffixes(target: Path) -> str:
    """The last two suffixes, fewer where they are parts of a long name, which may have points."""
    for n in (2, 1):
        suffixes = "".join(target.suffixes[-n:])
        if len(os.fsencode(suffixes)) <= _SUFFIXES:
            return suffixes
    return ""


def _tidy(folder: Path) -> None:
    """Remove what killed programs left in a folder; looked for once."""
    if folder in _TIDY:
        return
    _TIDY.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _may_be_left(entry):
                with suppress(OSError), nobodys(Path(entry.path)) as is_left:
                    if is_left:
                        os.unlink(entry.path)


def _may_be_left(entry: os.DirEntry[str]) -> bool:
    """Whether it has such a name, and is this machine's or old."""
    named = _LEFT.fullmatch(entry.name)
    if named is None or not entry.is_file(follow_symlinks=False):
        return False
    if named[1] == this_machine():
        return True
    with suppress(OSError):
        return time.time() - entry.stat(follow_symlinks=False).st_mtime > _OLD_S
    return False


def _flush(path: Path) -> None:
    with open(path, "rb+") as file:
        os.fsync(file.fileno())
