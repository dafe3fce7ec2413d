"""Where the package `kanjivg` keeps its characters, if it is installed."""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from pathlib import Path

__all__ = ["find_kanjivg"]


@lru_cache(maxsize=1)
def find_kanjivg() -> Path | None:
    """The folder with the characters, or None where the package is not installed."""
    for place in sys.path:  # where pip has put it; `importlib.metadata` takes 10 ms to find it
        folder = Path(place, "kanji")
        if not os.path.isdir(folder):  # nor where one may not look: `Path.is_dir` raises there
            continue
        if next(folder.parent.glob("kanjivg-*.dist-info"), None) is not None:
            return folder
    return _find_anywhere()


def _find_anywhere() -> Path | None:
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        package = distribution("kanjivg")
    except PackageNotFoundError:
        return None
    folder = Path(str(package.locate_file("kanji")))
    return folder if folder.is_dir() else None
