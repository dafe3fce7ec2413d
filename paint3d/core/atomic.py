"""Writing a file so that either all of it appears or nothing changes."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from paint3d.core.machine import flush_folder
from paint3d.errors import ExportError

__all__ = ["write_atomically"]


@contextmanager
def write_atomically(
    path: str | os.PathLike[str], progress: Callable[[float], None] | None = None
) -> Iterator[Path]:
    """Yield a temporary path beside `path`; move it over `path` when the block ends well.

    The data are flushed to the disk before the move, so after a crash the old file or the new
    one is there, never half of one. If the block raises, the temporary file is removed and an
    existing file at `path` stays as it was. Where `path` is a symbolic link, the file that it
    leads to is replaced and the link stays.

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
        If the folder is missing or not writable, or the system refuses the writing.
    """
    named = Path(path)
    try:
        target = _behind_links(named)
        temporary = _reserve(target)
    except OSError as cause:
        raise ExportError(f"{named}: cannot write here: {_reason(cause)}") from None
    try:
        yield temporary
        _flush(temporary)
        if progress is not None:
            progress(1.0)
        os.replace(temporary, target)
        flush_folder(target.parent)
    except OSError as cause:
        raise ExportError(f"{named}: cannot write: {_reason(cause)}") from None
    finally:
        with suppress(OSError):
            temporary.unlink()


def _behind_links(path: Path) -> Path:
    """The file that a path leads to, through all symbolic links; it need not be there."""
    if not path.is_symlink():
        return path
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    return target


def _reserve(target: Path) -> Path:
    if target.is_dir():
        raise IsADirectoryError(f"{target.name or target} is a folder; expected a file name")
    suffixes = "".join(target.suffixes[-2:])
    handle, name = tempfile.mkstemp(
        dir=target.parent, prefix=f".{target.name[:40]}.", suffix=suffixes
    )
    os.close(handle)
    umask = os.umask(0)
    os.umask(umask)
    os.chmod(name, 0o666 & ~umask)  # mkstemp makes private files; a result is an ordinary one
    return Path(name)


def _flush(path: Path) -> None:
    with open(path, "rb+") as file:
        os.fsync(file.fileno())


def _reason(cause: OSError) -> str:
    return cause.strerror or str(cause)
