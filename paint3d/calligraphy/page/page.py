"""A flat page of pieces, in writing order: what fonts, drawings and files of strokes become."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Box, Glyph
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon, Polygon

__all__ = [
    "Composer",
    "Page",
    "Photograph",
    "Piece",
    "as_multipolygon",
    "bounds_of",
    "digest_of",
    "fill_rings",
    "polygons_of",
]

# ---- Ink -----------------------------------------------------------------------------------------
# Ink shapes: closed curves filled by a rule, as polygons with holes.


_LEAST_SHARE = 1e-5  # of the largest polygon's area: smaller ones are dust of the arithmetic


def fill_rings(rings: Sequence[AnyArray], *, even_odd: bool = False) -> MultiPolygon:
    """Area that closed curves enclose, by the winding number of each point.

    Parameters
    ----------
    rings : sequence of (N, 2) float64
        They may cross themselves and each other.
    even_odd : bool
        Ink is where the number of turns is odd; without it, where it is not zero.
    """
    from shapely import LineString, MultiPolygon, unary_union
    from shapely.ops import polygonize

    closed = [np.concatenate([ring, ring[:1]]) for ring in rings if len(ring) > 2]
    if not closed:
        return MultiPolygon()
    faces = list(polygonize(unary_union([LineString(ring) for ring in closed])))
    if not faces:
        return MultiPolygon()
    inside = np.array([face.representative_point().coords[0] for face in faces])
    turns = np.sum([_winding_numbers(ring, inside) for ring in closed], axis=0)
    inked = turns % 2 != 0 if even_odd else turns != 0
    return as_multipolygon(
        unary_union([face for face, ink in zip(faces, inked, strict=True) if ink])
    )


def _winding_numbers(ring: AnyArray, points: AnyArray) -> NDArray[np.int64]:
    """Winding number of a closed ring (N, 2) around each of some points (M, 2)."""
    a, b = ring[:-1, None], ring[1:, None]
    side = (b[..., 0] - a[..., 0]) * (points[:, 1] - a[..., 1])
    side -= (points[:, 0] - a[..., 0]) * (b[..., 1] - a[..., 1])
    below_a, below_b = a[..., 1] <= points[:, 1], b[..., 1] <= points[:, 1]
    up, down = below_a & ~below_b & (side > 0.0), ~below_a & below_b & (side < 0.0)
    result: NDArray[np.int64] = up.sum(axis=0) - down.sum(axis=0)
    return result


def polygons_of(shape: Geometry) -> list[Polygon]:
    """The polygons of a shape that have an area, without lines, points and dust."""
    from shapely import Polygon

    parts = [part for part in getattr(shape, "geoms", [shape]) if isinstance(part, Polygon)]
    least = _LEAST_SHARE * max((part.area for part in parts), default=0.0)
    return [part for part in parts if part.area > least]


def as_multipolygon(shape: Geometry) -> MultiPolygon:
    """A shape as polygons."""
    from shapely import MultiPolygon

    return MultiPolygon(polygons_of(shape))


# ---- Pages ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Piece:
    """A glyph on a page: a character, ink that hangs together, or an element of a drawing.

    Attributes
    ----------
    glyph : Glyph
        May stand on the page several times; it is planned once.
    at : (float, float)
        Where the middle of its box lies on the page, glyph units, y upwards.
    word : (int, int), optional
        The line and the word in it, from 0, that it stays together with.
    """

    glyph: Glyph
    at: tuple[float, float]
    word: tuple[int, int] | None = None

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
            raise InputError(
                "{source}: there is nothing to write; expected strokes",
                source=self.source,
            )

    @property
    def runs_down(self) -> bool:
        """False: the lines of a page are set already."""
        return False

    @cached_property
    def bounds(self) -> Box:
        """The box around all pieces, glyph units."""
        return bounds_of(piece.box for piece in self.pieces)

    def compose(self, length: float) -> Page:
        """Return the page itself, whose lines are set already."""
        return self

    def least_size(self, length: float) -> tuple[float, float]:
        """No lower bound: the size of a page is known."""
        return 0.0, 0.0


class Composer(Protocol):
    """Something that is set as a page in lines of an available length."""

    @property
    def runs_down(self) -> bool:
        """Return whether its lines are columns."""
        ...

    def compose(self, length: float) -> Page:
        """The page with lines no longer than `length`, glyph units, where they can be broken.

        It is the same page, not a copy, where the lines are broken alike.
        """
        ...

    def least_size(self, length: float) -> tuple[float, float]:
        """Least length and height of its page, glyph units, by advances alone.

        Along the lines, of those that cannot be broken, and across them.
        """
        ...


def digest_of(file: Path) -> str:
    """Digest (SHA-256) of a file's bytes; empty where it cannot be read."""
    try:
        with file.open("rb") as data:
            return hashlib.file_digest(data, "sha256").hexdigest()
    except OSError:
        return ""


def bounds_of(boxes: Iterable[Box]) -> Box:
    """The box around boxes, of which there is at least one."""
    left, lower, right, upper = zip(*boxes, strict=True)
    return min(left), min(lower), max(right), max(upper)
