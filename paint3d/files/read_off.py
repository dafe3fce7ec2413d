"""OFF and COFF in ASCII: polygons, comments anywhere, vertex colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.contents import plain_text
from paint3d.files.raw_mesh import RawMesh, check_count, index_array, parse_numbers
from paint3d.files.vertex_colours import colour_codes

__all__ = ["read_off"]

KINDS = (b"OFF", b"COFF", b"NOFF", b"CNOFF")
LEAST_VERTEX_BYTES, LEAST_FACE_BYTES = 6, 2


def read_off(data: bytes) -> RawMesh:
    """Read an OFF file; colours of faces are passed over.

    Parameters
    ----------
    data : bytes
        The whole file.

    Raises
    ------
    MeshError
        If it is not OFF in text form, or holds less than its counts promise.
    """
    lines = [line.partition(b"#")[0].split() for line in plain_text(data).split(b"\n")]
    lines = [words for words in lines if words]
    if not lines or lines[0][0].upper() not in KINDS:
        raise MeshError("it does not start with 'OFF'; expected an OFF file")
    kind, rest = lines[0][0].upper(), lines[0][1:]
    if rest[:1] == [b"BINARY"]:
        raise MeshError("it is a binary OFF file; expected OFF in text form")
    lines = lines[1:] if not rest else [rest, *lines[1:]]
    n_vertices, n_faces = _counts(lines, len(data))
    if len(lines) < 1 + n_vertices + n_faces:
        raise MeshError(
            f"it promises {n_vertices} vertices and {n_faces} faces but has "
            f"{len(lines) - 1} lines; the file is cut short"
        )
    table = lines[1 : 1 + n_vertices]
    corners, sizes = _faces(lines[1 + n_vertices : 1 + n_vertices + n_faces])
    colours, notes = _colours(table) if kind == b"COFF" else (None, ())
    return RawMesh(_columns(table, slice(0, 3)), corners, sizes, colours, notes=notes)


def _counts(lines: list[list[bytes]], n_bytes: int) -> tuple[int, int]:
    words = lines[0] if lines else []
    if len(words) < 2 or not all(word.isdigit() for word in words[:2]):
        raise MeshError("the line after 'OFF' is not a count of vertices, faces and edges")
    n_vertices, n_faces = int(words[0]), int(words[1])
    check_count(n_vertices, LEAST_VERTEX_BYTES, n_bytes, "vertices")
    check_count(n_faces, LEAST_FACE_BYTES, n_bytes, "faces")
    return n_vertices, n_faces


def _columns(table: list[list[bytes]], columns: slice) -> NDArray[np.float64]:
    width = columns.stop - columns.start
    if any(len(words) < columns.stop for words in table):
        short = min(table, key=len)
        shown = b" ".join(short)[:40].decode("ascii", "replace")
        raise MeshError(f"a vertex line holds {shown!r}; expected {columns.stop} numbers")
    words = [word for row in table for word in row[columns]]
    return parse_numbers(b" ".join(words), "a vertex").reshape(-1, width)


def _colours(table: list[list[bytes]]) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    if any(len(words) < 6 for words in table):
        return None, ()
    rgb = _columns(table, slice(3, 6))
    whole = all(b"." not in word for words in table for word in words[3:6])
    return colour_codes(rgb / 255.0 if whole else rgb)


def _faces(table: list[list[bytes]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    if not all(words[0].isdigit() for words in table):
        raise MeshError("a face line does not start with its number of corners")
    sizes = np.array([int(words[0]) for words in table], np.int64)
    words = [word for row, n in zip(table, sizes, strict=True) for word in row[1 : 1 + n]]
    if len(words) != sizes.sum():
        raise MeshError("a face has fewer corners than it says; the file is cut short or damaged")
    return index_array(parse_numbers(b" ".join(words), "a face"), "a face"), sizes
