"""A flat page of pieces, in writing order: what fonts, drawings and files of strokes become."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Box, Glyph
from paint3d.errors import InputError

__all__ = ["Composer", "Page", "Photograph", "Piece", "bounds_of", "digest_of"]


@dataclass(frozen=True, eq=False)
class Piece:
    """A glyph on a page: a character, ink that hangs together, or an element of a drawing.

    Attributes
    ----------
    glyph : Glyph
        May stand on the page several times; it is planned once.
    at : (float, float)
        Where the middle of its box lies on the page, glyph units, y upwards.
    """

    glyph: Glyph
    at: tuple[float, float]

    @property
    def box(self) -> Box:
        """Its box on the page, glyph units."""
        left, lower, right, upper = self.glyph.box
        x, y = self.at
        half_width, half_height = 0.5 * (right - left), 0.5 * (upper - lower)
        return x - half_width, y - half_height, x + half_width, y + half_height


@dataclass(frozen=True, eq=False)
class Photograph:
    """The photograph that a page's strokes were found in, and how its sheet lies there.

    Attributes
    ----------
    file : Path
    corners : (4, 2) float64
        Of the sheet, the file's pixels: upper left, upper right, lower right, lower left.
    size : (int, int)
        Height and width of the sheet laid flat, pixels.
    per_unit : float
        Of those pixels to a glyph unit; the unit (x, y) of the page lies at pixel
        per_unit * (x, -y) + origin.
    origin : (2,) float64
    invert : bool
        Whether it is a rubbing: white strokes on black.
    digest : str
        Of the file when they were found, by `digest_of`; empty where that is not known.
    """

    file: Path
    corners: NDArray[np.float64]
    size: tuple[int, int]
    per_unit: float
    origin: NDArray[np.float64]
    invert: bool = False
    digest: str = ""


@dataclass(frozen=True, eq=False)
class Page:
    """Pieces in writing order.

    Attributes
    ----------
    pieces : tuple of Piece
    source : str
        Where their shapes are from, for reports.
    licence : str
        Whose shapes they are and under what licence.
    photograph : Photograph, optional
        Where they were found in one.

    Raises
    ------
    InputError
        If there are no pieces, or none of them has a stroke.
    """

    pieces: tuple[Piece, ...]
    source: str
    licence: str
    photograph: Photograph | None = None

    def __post_init__(self) -> None:
        if not any(piece.glyph.strokes for piece in self.pieces):
            raise InputError(f"{self.source}: there is nothing to write; expected strokes")

    @property
    def runs_down(self) -> bool:
        """Of a page that is set already it does not matter."""
        return False

    @property
    def bounds(self) -> Box:
        """The box around all pieces, glyph units."""
        return bounds_of(piece.box for piece in self.pieces)

    def compose(self, room: float) -> Page:
        """The page itself: it is set already."""
        return self


class Composer(Protocol):
    """Something that is set as a page in the room that there is."""

    @property
    def runs_down(self) -> bool:
        """Whether its lines are columns."""
        ...

    def compose(self, room: float) -> Page:
        """The page with lines no longer than `room`, glyph units, where they can be broken.

        It is the same page, not a copy, where the lines are broken alike.
        """
        ...


def digest_of(file: Path) -> str:
    """What tells a file's bytes from others (SHA-256); empty where it cannot be read."""
    try:
        with file.open("rb") as data:
            return hashlib.file_digest(data, "sha256").hexdigest()
    except OSError:
        return ""


def bounds_of(boxes: Iterable[Box]) -> Box:
    """The box around boxes, of which there is at least one."""
    left, lower, right, upper = zip(*boxes, strict=True)
    return min(left), min(lower), max(right), max(upper)
