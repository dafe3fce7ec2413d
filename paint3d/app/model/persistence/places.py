"""Where a user's settings and what can be recovered lie (XDG base directories).

Without a home that can be written they lie in a private folder among the temporary files, which the
next start of the system may empty.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from paint3d.core.own_folders import can_write, find_home, private_folder

__all__ = [
    "config_folder",
    "make_private",
    "make_private_folder",
    "recovery_folder",
    "stand_in",
    "usual_config_folder",
]

_CONFIG = ("PAINT3D_CONFIG", "XDG_CONFIG_HOME", ".config")
_STATE = ("PAINT3D_STATE", "XDG_STATE_HOME", ".local/state")


def config_folder() -> Path:
    """The folder for settings: ``PAINT3D_CONFIG``, or paint3d's in the user's config folder."""
    return _folder(*_CONFIG) or private_folder() / "config"


def usual_config_folder() -> Path | None:
    """Where settings lie if they can be read but not written; None where there is no home."""
    return _usual(*_CONFIG)


def recovery_folder() -> Path:
    """The folder for what a crash would lose: ``PAINT3D_STATE``, or paint3d's among the states."""
    return (_folder(*_STATE) or private_folder() / "state") / "sittings"


def stand_in() -> Path | None:
    """The folder that takes the home's place, where that cannot be written; None if it can."""
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
    """The folder that can be written; one that the user names is taken as it is."""
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
