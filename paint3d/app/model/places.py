"""Where a user's settings and what can be recovered lie (XDG base directories)."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["config_folder", "recovery_folder"]


def config_folder() -> Path:
    """The folder for settings: ``PAINT3D_CONFIG``, or paint3d's in the user's config folder."""
    return _folder("PAINT3D_CONFIG", "XDG_CONFIG_HOME", ".config")


def recovery_folder() -> Path:
    """The folder for what a crash would lose: ``PAINT3D_STATE``, or paint3d's among the states."""
    return _folder("PAINT3D_STATE", "XDG_STATE_HOME", ".local/state") / "sittings"


def _folder(own: str, base: str, fallback: str) -> Path:
    if os.environ.get(own):
        return Path(os.environ[own])
    found = os.environ.get(base, "")
    root = Path(found) if os.path.isabs(found) else Path.home() / fallback
    return root / "paint3d"
