"""Result of every mesh reader: polygons as the file has them, not yet checked."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message
from paint3d.files.colours import Look

__all__ = [
    "FACE_COLOURS",
    "RawMesh",
    "check_count",
    "index_array",
    "join_meshes",
    "left_out",
    "parse_numbers",
    "with_face_colours",
]


@dataclass(frozen=True)
class RawMesh:
    """A file's polygons.

    Attributes
    ----------
    vertices : (V, 3) float64
        In the file's unit and axes.
    corners : (N,) int64
        Vertex indices of all polygons, one after the other.
    sizes : (P,) int64
        Corners of each polygon.
    colours : (V, 3) uint8 or None
        sRGB codes.
    normals : (V, 3) float64 or None
    unit_mm : float or None
        Millimetres in one unit, where the format or the file says so.
    up : {"y", "z"} or None
        The axis that points up, where the format says so.
    announces : str
        What the file speaks of besides points, such as faces, even if it holds none: without
        triangles it is no point cloud then.
    notes : tuple of Message
        What the user should know, such as a texture that was left out.
    looks : tuple of Look
        The materials that were read.
    look_of : (P,) int64 or None
        Of each polygon, -1 for none; None where no material was read.
    uv : (N, 2) float64 or None
        Place of every corner on its polygon's picture, from the upper left; nan where unknown.
    corner_colours : (N, 3) uint8 or None
        sRGB codes of every corner, where those of one vertex may differ; they count where looks
        are read, and `colours` elsewhere.
    """

    vertices: NDArray[np.float64]
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    colours: NDArray[np.uint8] | None = None
    normals: NDArray[np.float64] | None = None
    unit_mm: float | None = None
    up: str | None = None
    announces: str = ""
    notes: tuple[Message, ...] = ()
    looks: tuple[Look, ...] = ()
    look_of: NDArray[np.int64] | None = None
    uv: NDArray[np.float64] | None = None
    corner_colours: NDArray[np.uint8] | None = None

    @classmethod
    def of_triangles(cls, vertices: AnyArray, faces: AnyArray, **others: Any) -> RawMesh:
        """Return a raw mesh with (F, 3) triangles."""
        faces = np.asarray(faces, np.int64).reshape(-1, 3)
        return cls(vertices, faces.ravel(), np.full(len(faces), 3), **others)


def join_meshes(raws: Sequence[RawMesh]) -> RawMesh:
    """Return several meshes as one, with all their looks and notes.

    Where some have colours, the others are white; normals are kept where all have them.
    """
    if not raws:
        empty = np.empty(0, np.int64)
        return RawMesh(np.empty((0, 3)), empty, empty)
    first = np.cumsum([0, *(len(raw.vertices) for raw in raws)])
    looks_before = np.cumsum([0, *(len(raw.looks) for raw in raws)])
    looks, coordinates, colours, corner_colours = [], [], [], []
    for raw, before in zip(raws, looks_before, strict=False):
        look_of = np.full(len(raw.sizes), -1) if raw.look_of is None else raw.look_of
        looks.append(np.where(look_of < 0, -1, look_of + before))
        coordinates.append(np.full((len(raw.corners), 2), np.nan) if raw.uv is None else raw.uv)
        white = np.full((len(raw.vertices), 3), 255, np.uint8)
        colours.append(white if raw.colours is None else raw.colours)
        own = raw.corner_colours
        if own is None and any(other.corner_colours is not None for other in raws):
            inside = np.clip(raw.corners, 0, max(len(raw.vertices) - 1, 0))
            own = colours[-1][inside] if len(raw.vertices) else np.empty((0, 3), np.uint8)
        corner_colours.append(own)
    pictured = any(raw.look_of is not None for raw in raws)
    cornered = [own for own in corner_colours if own is not None]
    normals = [raw.normals for raw in raws if raw.normals is not None]
    return RawMesh(
        np.concatenate([raw.vertices for raw in raws]),
        np.concatenate([raw.corners + n for raw, n in zip(raws, first, strict=False)]),
        np.concatenate([raw.sizes for raw in raws]),
        np.concatenate(colours) if any(raw.colours is not None for raw in raws) else None,
        np.concatenate(normals) if len(normals) == len(raws) else None,
        notes=tuple(dict.fromkeys(note for raw in raws for note in raw.notes)),
        looks=tuple(look for raw in raws for look in raw.looks),
        look_of=np.concatenate(looks) if pictured else None,
        uv=np.concatenate(coordinates) if pictured else None,
        corner_colours=np.concatenate(cornered) if cornered else None,
    )


FACE_COLOURS = Message("colours of faces")


def with_face_colours(raw: RawMesh, codes: NDArray[np.uint8], wanted: bool) -> RawMesh:
    """Return a mesh whose polygons have the colours `codes` (P, 3), sRGB.

    Where they are not wanted, a note says that they are left out.
    """
    if not wanted:
        return replace(raw, notes=(*raw.notes, *left_out([FACE_COLOURS])))
    return replace(
        raw,
        looks=(Look(),),
        look_of=np.zeros(len(raw.sizes), np.int64),
        uv=np.full((len(raw.corners), 2), np.nan),
        corner_colours=np.repeat(codes, raw.sizes, axis=0),
    )


def left_out(what: Iterable[str]) -> tuple[Message, ...]:
    """Return one note on parts of a file that are ignored; none where there are none."""
    named = [one if isinstance(one, Message) else Message(one) for one in sorted(what)]
    if not named:
        return ()
    several = reduce(lambda one, other: Message("{one}, {other}", one=one, other=other), named)
    return (Message("left out: {what}", what=several),)


def parse_numbers(text: bytes, what: str) -> NDArray[np.float64]:
    """Return all numbers of a white-space separated text.

    Raises
    ------
    MeshError
        Naming the first word that is not a number.
    """
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text.decode("latin-1"), sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    numbers = []
    for word in text.split():
        try:
            numbers.append(float(word))
        except ValueError:
            shown = word[:20].decode("ascii", "replace")
            raise MeshError(
                "{what} has {shown!r} where a number was expected",
                what=what,
                shown=shown,
            ) from None
    return np.array(numbers)


def index_array(numbers: AnyArray, what: str) -> NDArray[np.int64]:
    """Return numbers read as text as indices.

    Raises
    ------
    MeshError
        If one is not a whole number or beyond 2^53.
    """
    whole = np.isfinite(numbers) & (np.abs(numbers) < 2.0**53)
    whole &= np.floor(np.where(whole, numbers, 0.5)) == numbers
    if not whole.all():
        raise MeshError(
            "{what} has {numbers:g} where a vertex index was expected",
            what=what,
            numbers=numbers[~whole][0],
        )
    return numbers.astype(np.int64)


def check_count(count: float, n_bytes_each: float, n_bytes: int, what: str) -> None:
    """Refuse a count that the rest of the file cannot hold, before memory is taken for it.

    Raises
    ------
    MeshError
        If there is not enough data.
    """
    capacity = math.floor(n_bytes / n_bytes_each)
    if count < 0:
        raise MeshError("it says it has {count} {what}; expected 0 or more", count=count, what=what)
    if count > capacity:
        raise MeshError(
            "it says it has {count:,} {what}, but what follows has room for {room:,} at most; the "
            "file is cut short or its header is wrong",
            count=count,
            what=what,
            room=capacity,
        )
