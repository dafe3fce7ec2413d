"""Order and direction of strokes where nothing is known of the character."""

from __future__ import annotations

from collections.abc import Sequence

from paint3d.calligraphy.shapes.regions import Piece

__all__ = ["in_writing_order"]


def in_writing_order(pieces: Sequence[Piece]) -> list[Piece]:
    return list(pieces)
