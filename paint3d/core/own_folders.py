"""The user's folders: the home and its parts, or a private folder where it cannot be written.

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

__all__ = [
    "can_write",
    "config_folder",
    "find_home",
    "make_private",
    "make_private_folder",
    "private_folder",
    "recovery_folder",
    "stand_in",
    "usual_config_folder",
]

# Of a folder: what names it, what names its parent (XDG base directories), its parent in the home.
_CONFIG = ("PAINT3D_CONFIG", "XDG_CONFIG_HOME", ".config")
_STATE = ("PAINT3D_STATE", "XDG_STATE_HOME", ".local/state")


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


def config_folder() -> Path:
    """Return that for settings: ``PAINT3D_CONFIG``, or paint3d's in the user's config folder."""
    return _folder(*_CONFIG) or private_folder() / "config"


def usual_config_folder() -> Path | None:
    """Return where settings lie that can be read but not written; None where there is no home."""
    return _usual(*_CONFIG)


def recovery_folder() -> Path:
    """Return that for what a crash would lose: ``PAINT3D_STATE``, or paint3d's among the states."""
    return (_folder(*_STATE) or private_folder() / "state") / "sittings"


def stand_in() -> Path | None:
    """Return the folder in place of a home that cannot be written; None if it can."""
    return None if _folder(*_CONFIG) and _folder(*_STATE) else private_folder()


def make_private_folder(folder: Path) -> None:
    """Make a folder that only the user can enter, and so those above it that are missing.

    One that is there stays as it is.

    Raises
    ------
    OSError
        If one cannot be made.
    """
    for one in reversed([folder, *folder.parents]):
        if not one.is_dir():
            one.mkdir(mode=0o700, exist_ok=True)
            make_private(one)


def make_private(path: Path) -> None:
    """Let only the user read and write a file, or enter a folder, whatever the umask is.

    Nothing happens where a file system has no such rights, or it is somebody else's.
    """
    with suppress(OSError):
        path.chmod(0o700 if path.is_dir() else 0o600)


def _folder(own: str, base: str, fallback: str) -> Path | None:
    """Return a folder if it can be written; one that the user names is taken as it is."""
    folder = _usual(own, base, fallback)
    return folder if os.environ.get(own) or (folder and can_write(folder)) else None


def _usual(own: str, base: str, fallback: str) -> Path | None:
    if os.environ.get(own):
        return Path(os.environ[own])
    found = os.environ.get(base, "")
    if os.path.isabs(found):
        return Path(found) / "paint3d"
    home = find_home()
    return None if home is None else home / fallback / "paint3d"
