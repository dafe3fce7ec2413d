"""Wavefront OBJ: polygons, relative indices, colours after the position, continued lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.readers.contents import plain_text
from paint3d.files.readers.obj_materials import names_materials, obj_looks
from paint3d.files.readers.raw_mesh import RawMesh, index_array, left_out, parse_numbers
from paint3d.files.readers.vertex_colours import colour_codes

__all__ = ["read_obj"]

COLOUR_COLUMN = {6: 3, 7: 4}  # numbers in a vertex line: where red stands (7: after a weight)
NO_POINTS = {
    b"l": "lines",
    b"curv": "curves, which are not read",
    b"surf": "free-form surfaces, which are not read",
}
PASSED_OVER = {b"l": "lines", b"p": "points", b"curv": "curves", b"surf": "free-form surfaces"}
ATTRIBUTES = re.compile(rb"/\S*")
ODD_EXPONENT = re.compile(rb"(?<=\d)([+-])[eE](?=\d)")


def read_obj(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read an OBJ file; lines, points, curves and free-form surfaces are passed over, and noted.

    Relative (negative) indices count back from the vertices read so far, as the format says.
    Vertices without a colour, among others with one, are white.

    Parameters
    ----------
    data : bytes
        The whole file.
    folder : Path
        Where its material libraries and pictures lie; others are not followed.
    texture : bool
        Whether materials and their pictures are read, instead of vertex colours.

    Raises
    ------
    MeshError
        If a vertex or face line holds something else than numbers, or an index is 0.
    """
    lines = _lines(data)
    vertex_lines = [line[2:] for line in lines if line[:2] == b"v "]
    face_lines = [line[2:] for line in lines if line[:2] == b"f "]
    vertices, colours, notes = _vertices(vertex_lines)
    sizes = np.array([len(line.split()) for line in face_lines], np.int64)
    corners = index_array(
        parse_numbers(ATTRIBUTES.sub(b"", b"\n".join(face_lines)), "a face"), "a face"
    )
    if (corners == 0).any():
        raise MeshError("a face refers to vertex 0; OBJ counts from 1")
    if (corners < 0).any():
        before = np.repeat(_vertices_before_faces(lines), sizes)
        corners = np.where(corners < 0, corners + before, corners - 1)
    else:
        corners = corners - 1
    announced = "" if len(sizes) else _announced(lines)
    dropped = _passed_over(lines)
    if not texture:
        dropped |= {"its colours and pictures"} if names_materials(lines) else set()
        notes += left_out(dropped)
        return RawMesh(vertices, corners, sizes, colours, announces=announced, notes=notes)
    found = obj_looks(lines, sizes, folder)
    told = found.notes + left_out(dropped | found.dropped)
    if not found.looks:
        return RawMesh(vertices, corners, sizes, colours, announces=announced, notes=notes + told)
    return RawMesh(
        vertices, corners, sizes, notes=told,
        looks=found.looks, look_of=found.look_of, uv=found.uv,
    )  # fmt: skip


def _lines(data: bytes) -> list[bytes]:
    """Return the lines without indentation, comments and continuations."""
    data = plain_text(data).replace(b"\t", b" ")
    data = data.replace(b"\\\n", b" ")
    return [line.partition(b"#")[0].strip() for line in data.split(b"\n")]


def _vertices(
    lines: Sequence[bytes],
) -> tuple[NDArray[np.float64], NDArray[np.uint8] | None, tuple[str, ...]]:
    widths = np.array([len(line.split()) for line in lines], np.int64)
    if len(lines) == 0:
        return np.empty((0, 3)), None, ()
    if widths.min() < 3:
        line = lines[int(widths.argmin())].decode("ascii", "replace")
        raise MeshError(f"a vertex line holds {line[:40]!r}; expected three numbers")
    numbers = _numbers(b"\n".join(lines))
    first = np.cumsum(widths) - widths
    vertices = numbers[first[:, None] + np.arange(3)]
    rgb = np.empty((len(lines), 3))
    for width, column in COLOUR_COLUMN.items():
        rows = np.flatnonzero(widths == width)
        rgb[rows] = numbers[first[rows, None] + column + np.arange(3)]
    coloured = np.isin(widths, list(COLOUR_COLUMN))
    if not coloured.any():
        return vertices, None, ()
    codes, notes = colour_codes(rgb[coloured])
    if codes is None:
        return vertices, None, notes
    colours = np.full((len(lines), 3), 255, np.uint8)
    colours[coloured] = codes
    return vertices, colours, notes


def _passed_over(lines: Sequence[bytes]) -> set[str]:
    """What there is besides faces, and is not read."""
    kinds = {line.partition(b" ")[0] for line in lines}
    return {what for kind, what in PASSED_OVER.items() if kind in kinds}


def _announced(lines: Sequence[bytes]) -> str:
    """What there is besides points, in a file without faces."""
    kinds = {line.partition(b" ")[0] for line in lines}
    return next((what for kind, what in NO_POINTS.items() if kind in kinds), "")


def _numbers(text: bytes) -> NDArray[np.float64]:
    """Parse numbers; where that fails, read exponents like 3.1+e2, which some programs write."""
    try:
        return parse_numbers(text, "a vertex")
    except MeshError:
        return parse_numbers(ODD_EXPONENT.sub(rb"e\1", text), "a vertex")


def _vertices_before_faces(lines: Sequence[bytes]) -> NDArray[np.int64]:
    """Return for each face line how many vertex lines come before it."""
    kind = np.array([1 if line[:2] == b"v " else 2 if line[:2] == b"f " else 0 for line in lines])
    result: NDArray[np.int64] = np.cumsum(kind == 1)[kind == 2]
    return result
