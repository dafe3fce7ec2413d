"""Where the package `kanjivg` keeps its characters, if it is installed."""

from __future__ import annotations

from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

__all__ = ["find_kanjivg"]


@lru_cache(maxsize=1)
def find_kanjivg() -> Path | None:
    """The folder with the characters, or None where the package is not installed."""
    try:
        package = distribution("kanjivg")
    except PackageNotFoundError:
        return None
    folder = Path(str(package.locate_file("kanji")))
    return folder if folder.is_dir() else None
