"""The user's folders: the home, or a private folder where the home cannot be written.

Service accounts, containers run under another user's number and read-only homes leave a program
nowhere to store files. Some of its files are code (compiled kernels), so the folder that replaces
the home must be one that nobody else can have put anything into.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

from paint3d.core.machine import is_private, user_number
from paint3d.errors import ExportError

__all__ = ["can_write", "find_home", "private_folder"]


def find_home() -> Path | None:
    """Return the user's home, which need not exist; None if the system knows none."""
    try:
        home = Path.home()
    except RuntimeError:  # a user without an entry in the list of users, and no HOME
        return None
    return home if home.is_absolute() else None


def can_write(folder: Path) -> bool:
    """Return whether files can be made in a folder or, while it does not exist, in its parent."""
    there = os.fspath(folder)
    while not os.path.lexists(there) and there != os.path.dirname(there):
        there = os.path.dirname(there)
    try:
        tempfile.TemporaryFile(dir=there).close()
    except OSError:
        return False
    return True


@cache
def private_folder() -> Path:
    """Return a folder among the temporary files that only this user can enter.

    It is the same at every start, unless somebody else has made one of its name, or may enter it:
    then it is a fresh one.

    Raises
    ------
    ExportError
        If no temporary folder can be written.
    """
    try:
        own = Path(tempfile.gettempdir()) / f"paint3d-{user_number()}"
        with suppress(FileExistsError):
            own.mkdir(mode=0o700)
        return own if is_private(own) else Path(tempfile.mkdtemp(prefix="paint3d-"))
    except OSError as cause:
        raise ExportError(
            "neither the home nor a temporary folder can be written ({cause}); expected HOME or "
            "TMPDIR to name a folder that can",
            cause=cause,
        ) from None
