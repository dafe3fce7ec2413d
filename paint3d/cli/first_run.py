"""Say once that the loops are being compiled, so that a first run does not look stuck.

numba keeps compiled loops in files named ``<module>.<function>-<line>.py<version>.nbi``: in
``$NUMBA_CACHE_DIR``, else in ``__pycache__`` beside the source, else (when that folder cannot be
written) in the user's cache folder.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path

import paint3d

__all__ = ["is_compiled", "say_if_compiling"]

_LAST_COMPILED = "deposit"
_SECONDS = 100


def _cached_files(kernels: Path) -> Iterable[Path]:
    pattern = f"{_LAST_COMPILED}.*.py{sys.version_info.major}{sys.version_info.minor}.nbi"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return Path(chosen).rglob(pattern)
    beside = kernels / "__pycache__"
    if os.access(beside if beside.exists() else kernels, os.W_OK):
        return beside.glob(pattern)
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return (home / "numba").rglob(pattern)


def is_compiled() -> bool:
    """Whether compiled loops newer than their source are in numba's cache."""
    kernels = Path(paint3d.__file__).parent / "kernels"  # not imported: numba would be, too
    source = kernels / f"{_LAST_COMPILED}.py"
    try:
        changed = source.stat().st_mtime
        return any(file.stat().st_mtime >= changed for file in _cached_files(kernels))
    except OSError:
        return False


def say_if_compiling(*, quiet: bool) -> None:
    """Write one line to stderr when the loops are yet to be compiled."""
    if not quiet and not is_compiled():
        sys.stderr.write(f"compiling the brush (once, about {_SECONDS} s) ...\n")
        sys.stderr.flush()
