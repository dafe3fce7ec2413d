"""OFF in ASCII, with C, N and ST: polygons, comments anywhere, colours, normals of vertices."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, Message
from paint3d.files.colours import colour_codes
from paint3d.files.contents import plain_text
from paint3d.files.raw_mesh import (
    FACE_COLOURS,
    RawMesh,
    check_count,
    index_array,
    left_out,
    parse_numbers,
    with_face_colours,
)

__all__ = ["read_off"]

KIND = re.compile(rb"(?i:(?P<kind>(ST|C|N){0,3}OFF))(?=[\s\d]|$)")  # MeshLab writes NCOFF, CSTOFF
WITH_DIMENSION = re.compile(rb"(?i:(ST)?C?N?(4n?|n)OFF)\b")
UNIT = 1e-2  # that the length of a normal may differ from 1
LEAST_VERTEX_BYTES, LEAST_FACE_BYTES = 6, 2
GREY = 170  # two thirds: of faces without a colour among others with one


def read_off(data: bytes, texture: bool = False) -> RawMesh:
    """Read an OFF file.

    The word OFF may be missing, as the format allows, and a face may go on in the next line.

    Parameters
    ----------
    data : bytes
        The whole file.
    texture : bool
        Whether colours of faces are wanted.

    Raises
    ------
    MeshError
        If it is not OFF in text form, or holds less than its counts promise.
    """
    lines = [line.partition(b"#")[0] for line in plain_text(data).split(b"\n")]
    lines = [line for line in lines if line.strip()]
    kind, lines = _read_kind(lines)
    rows = [line.split() for line in lines]
    n_vertices, n_faces = _read_counts(rows, len(data))
    table, rest = rows[1 : 1 + n_vertices], rows[1 + n_vertices : 1 + n_vertices + n_faces]
    whole = all(row[0].isdigit() and len(row) > int(row[0]) for row in rest)
    if len(rest) < n_faces or not whole:
        table, rest = _read_over_lines(rows, kind, n_vertices, n_faces)
    corners, sizes = _read_faces(rest)
    normals, colours, notes = _read_attributes(table, kind)
    raw = RawMesh(_columns(table, slice(0, 3)), corners, sizes, colours, normals, notes=notes)
    codes, more_notes = _read_face_colours(rest)
    raw = replace(raw, notes=raw.notes + more_notes)
    return raw if codes is None else with_face_colours(raw, codes, texture)


def _read_kind(lines: list[bytes]) -> tuple[bytes, list[bytes]]:
    """Return the word that begins an OFF file, in capitals, and what follows."""
    first = lines[0].strip() if lines else b""
    match = KIND.match(first)
    if match is None:
        if WITH_DIMENSION.match(first):
            raise MeshError("it has vertices of other than three dimensions; expected three")
        words = first.split()
        if len(words) != 3 or not all(word.isdigit() for word in words):
            raise MeshError("it does not start with 'OFF'; expected an OFF file")
        return b"OFF", lines
    rest = first[match.end() :].strip()
    if rest.upper().startswith(b"BINARY"):
        raise MeshError("it is a binary OFF file; expected OFF in text form")
    return match["kind"].upper(), [rest, *lines[1:]] if rest else lines[1:]


def _read_over_lines(
    rows: list[list[bytes]], kind: bytes, n_vertices: int, n_faces: int
) -> tuple[list[list[bytes]], list[list[bytes]]]:
    """Return the rows of vertices and faces of a file whose lines end anywhere.

    Raises
    ------
    MeshError
        If its words are not just as many as that takes.
    """
    words = [word for row in rows for word in row]
    plain = 3 + 3 * (b"N" in kind) + 2 * (b"ST" in kind)
    for width in (plain + 4, plain + 3) if b"C" in kind else (plain,):
        at = 3 + width * n_vertices
        faces: list[list[bytes]] = []
        while len(faces) < n_faces and at < len(words) and words[at].isdigit():
            after = at + 1 + int(words[at])
            faces.append(words[at:after])
            at = after
        if len(faces) == n_faces and at == len(words):
            vertices = [words[3 + width * k : 3 + width * (k + 1)] for k in range(n_vertices)]
            return vertices, faces
    n_lines = len(rows) - 1
    if n_lines < n_vertices + n_faces:
        raise MeshError(
            "it promises {n_vertices} vertices and {n_faces} faces but has {n_lines} lines; the "
            "file is cut short",
            n_vertices=n_vertices,
            n_faces=n_faces,
            n_lines=n_lines,
        )
    if all(row[0].isdigit() for row in rows[1 + n_vertices : 1 + n_vertices + n_faces]):
        raise MeshError("a face has fewer corners than it says; the file is cut short or damaged")
    raise MeshError("a face line does not start with its number of corners")


def _read_counts(lines: list[list[bytes]], n_bytes: int) -> tuple[int, int]:
    words = lines[0] if lines else []
    if len(words) < 2 or not all(word.isdigit() for word in words[:2]):
        raise MeshError("the line after 'OFF' is not a count of vertices, faces and edges")
    n_vertices, n_faces = int(words[0]), int(words[1])
    check_count(n_vertices, LEAST_VERTEX_BYTES, n_bytes, Message("vertices"))
    check_count(n_faces, LEAST_FACE_BYTES, n_bytes, Message("faces"))
    return n_vertices, n_faces


def _columns(table: list[list[bytes]], columns: slice) -> NDArray[np.float64]:
    width = columns.stop - columns.start
    if any(len(words) < columns.stop for words in table):
        short = min(table, key=len)
        shown = b" ".join(short)[:40].decode("ascii", "replace")
        raise MeshError(
            "a vertex line holds {shown!r}; expected {stop} numbers",
            shown=shown,
            stop=columns.stop,
        )
    words = [word for row in table for word in row[columns]]
    return parse_numbers(b" ".join(words), Message("a vertex")).reshape(-1, width)


def _read_attributes(
    table: list[list[bytes]], kind: bytes
) -> tuple[NDArray[np.float64] | None, NDArray[np.uint8] | None, tuple[Message, ...]]:
    """Return normals (V, 3), colours (V, 3), and notes on them.

    Geomview has normals before colours, MeshLab after them: those of length 1 are normals. Where
    the file's first word says neither, whole numbers to 255 are colours.
    """
    width = min(map(len, table), default=3) - 2 * (b"ST" in kind)
    is_normal, is_colour = b"N" in kind and width >= 6, b"C" in kind and width >= 6
    if not is_normal and not is_colour:
        return None, *_read_unannounced(table, width)
    if not is_colour:
        return _columns(table, slice(3, 6)), None, ()
    first, last = slice(3, 6), slice(width - 3, width)
    if not is_normal or width < 9:
        return None, *_read_colours(table, slice(3, min(width, 7)))
    after = _are_unit(_columns(table, last)) and not _are_unit(_columns(table, first))
    normals, start = (last, 3) if after else (first, 6)
    return _columns(table, normals), *_read_colours(table, slice(start, start + min(width - 6, 4)))


def _read_unannounced(
    table: list[list[bytes]], width: int
) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    if width not in (6, 7) or any(len(row) != width for row in table):
        return None, ()
    words = [word for row in table for word in row[3:6]]
    if all(word.isdigit() for word in words) and max(map(int, words)) <= 255:
        return _read_colours(table, slice(3, width))
    return None, left_out([Message("numbers after the places of vertices")])


def _are_unit(rows: NDArray[np.float64]) -> bool:
    length = np.linalg.norm(rows, axis=1)
    return bool(np.mean(np.abs(length - 1.0) < UNIT) > 0.5)


def _read_colours(
    table: list[list[bytes]], columns: slice
) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    whole = all(word.isdigit() for words in table for word in words[columns])
    return colour_codes(_columns(table, columns), 255 if whole else 1)


def _read_face_colours(
    table: list[list[bytes]],
) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    """Return colours (P, 3) after the corners of faces: whole numbers to 255, or fractions to 1.

    Faces without one are grey, as the format says, where others have some. A single number is a
    index into a table that the viewer has; it is left out.
    """
    after = [row[1 + int(row[0]) :] for row in table]
    coloured = np.array([len(words) >= 3 for words in after], np.bool_)
    numbered = any(len(words) == 1 for words in after)
    notes = left_out([Message("numbers of colours")]) if numbered else ()
    if not coloured.any():
        return None, notes
    width = min(4, *(len(row) for row in after if len(row) >= 3))
    words = [word for row in after if len(row) >= 3 for word in row[:width]]
    try:
        rgba = parse_numbers(b" ".join(words), Message("a face")).reshape(-1, width)
    except MeshError:  # words of no colour, after faces of somebody's dialect
        return None, left_out([FACE_COLOURS])
    whole = all(word.isdigit() for word in words)
    codes, more_notes = colour_codes(rgba, 255 if whole else 1, FACE_COLOURS)
    notes += more_notes
    if codes is None:
        return None, notes
    every = np.full((len(table), 3), GREY, np.uint8)
    every[coloured] = codes
    return every, notes


def _read_faces(table: list[list[bytes]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    sizes = np.array([int(words[0]) for words in table], np.int64)
    words = [word for row, n in zip(table, sizes, strict=True) for word in row[1 : 1 + n]]
    return index_array(parse_numbers(b" ".join(words), Message("a face")), Message("a face")), sizes
