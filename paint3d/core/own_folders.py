"""The user's folders: in the home, or a private folder if that cannot be written.

Service accounts, containers run under another user's number and read-only homes leave a program
nowhere to store files. Some of its files are code (compiled kernels), so the folder that replaces
the home must be one that no other user can have written to.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

from paint3d.core.machine import is_private, user_id
from paint3d.errors import ExportError

__all__ = [
    "can_write",
    "config_folder",
    "fallback_folder",
    "find_home",
    "make_private",
    "make_private_folder",
    "private_folder",
    "recovery_folder",
    "usual_config_folder",
]

# Of each folder: its own variable, its parent's (XDG base directories), its parent in the home.
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

    It is the same at every start, unless another user has made one of this name, or may enter it:
    then it is a new one.

    Raises
    ------
    ExportError
        If no temporary folder can be written.
    """
    try:
        own = Path(tempfile.gettempdir()) / f"paint3d-{user_id()}"
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
    """Return the folder of settings: ``PAINT3D_CONFIG``, or paint3d's in the config folder."""
    return _folder(*_CONFIG) or private_folder() / "config"


def usual_config_folder() -> Path | None:
    """Return the folder of settings, even if it cannot be written; None if there is no home."""
    return _usual(*_CONFIG)


def recovery_folder() -> Path:
    """Return the folder of recovery data: ``PAINT3D_STATE``, or paint3d's in the state folder."""
    return (_folder(*_STATE) or private_folder() / "state") / "sittings"


def fallback_folder() -> Path | None:
    """Return the folder that replaces a home that cannot be written; None if it can."""
    return None if _folder(*_CONFIG) and _folder(*_STATE) else private_folder()


def make_private_folder(folder: Path) -> None:
    """Make a folder, and missing parents, that only the user can enter; existing ones are kept.

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
    """Restrict a file or folder to the user, whatever the umask is.

    Nothing happens if the file system has no such rights, or another user owns it.
    """
    with suppress(OSError):
        path.chmod(0o700 if path.is_dir() else 0o600)


def _folder(own: str, base: str, fallback: str) -> Path | None:
    """Return a folder if it can be written, or if the user names it by its own variable."""
    folder = _usual(own, base, fallback)
    return folder if os.environ.get(own) or (folder and can_write(folder)) else None


def _usual(own: str, base: str, fallback: str) -> Path | None:
    if os.environ.get(own):
        return Path(os.environ[own])
    parent = os.environ.get(base, "")
    if os.path.isabs(parent):
        return Path(parent) / "paint3d"
    home = find_home()
    return None if home is None else home / fallback / "paint3d"
