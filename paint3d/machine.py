"""What operating systems do each in their own way, and what is done where one cannot do it."""

from __future__ import annotations

import os
import stat
from pathlib import Path

__all__ = ["is_private", "usable_cores", "user_number"]


def user_number() -> int:
    """The number of the user who runs this process; 0 where users have none."""
    return os.geteuid() if hasattr(os, "geteuid") else 0


def is_private(folder: Path) -> bool:
    """Whether it is a folder (no link to one) that this user owns and nobody else can enter.

    Where users have no numbers, temporary folders are a user's own already.
    """
    found = os.lstat(folder)
    if not stat.S_ISDIR(found.st_mode):
        return False
    if not hasattr(os, "geteuid"):
        return True
    return found.st_uid == os.geteuid() and not found.st_mode & 0o077


def usable_cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
