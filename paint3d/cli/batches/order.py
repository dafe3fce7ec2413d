"""In what order rows are started: the longest first, so that none waits for a late long one."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from paint3d.calligraphy.kanjivg_folder import find_kanjivg
from paint3d.cli.batches.record import FinishedRows
from paint3d.cli.batches.rows import Row

__all__ = ["longest_first"]

# Rough seconds, enough to tell long rows from short ones.
_PER_GLYPH_BYTE = 2e-4  # of the SVG file, which grows with the number of strokes
_USUAL_GLYPH = 3300  # bytes
_PER_RECORDING_BYTE = 1.5e-7
_PER_MESH_BYTE = 3e-8


def longest_first(rows: Sequence[Row], finished: FinishedRows) -> list[Row]:
    """Return the rows by how long each took before, or is thought to take; equals as they were."""
    seconds = {}
    for row in rows:
        before = finished.seconds(row)
        seconds[row.line] = _expected(row) if before is None else before
    return sorted(rows, key=lambda row: -seconds[row.line])


def _expected(row: Row) -> float:
    """Rough seconds that a row takes, by the strokes of its text or its files' sizes."""
    command, *words = row.arguments
    meshes = [word.removeprefix("--on=") for word in words if word.startswith("--on=")]
    loading = _PER_MESH_BYTE * sum(_size(mesh) for mesh in meshes)
    if command == "replay":
        return loading + _PER_RECORDING_BYTE * _size(words[-1])
    return loading + _PER_GLYPH_BYTE * sum(map(_glyph_size, "".join(words[-1].split())))


def _glyph_size(character: str) -> int:
    folder = find_kanjivg()
    return (_size(folder / f"{ord(character):05x}.svg") if folder else 0) or _USUAL_GLYPH


def _size(path: str | Path) -> int:
    """Bytes of a file; 0 where there is none."""
    try:
        return os.stat(path).st_size
    except (OSError, ValueError):
        return 0
