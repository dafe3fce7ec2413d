"""The record format of the paper (Guo 2017, section 4.3): a painting as a list of vertices.

The paper prints ``InitialPosition={0, 0, 0}`` and rows ``{172, 205, 309, 22, 30, 42, 39}`` of
"position, normal, and RGB": seven numbers where nine are needed. We write nine, in a column order
that the file itself names, and read seven as position, one packed normal, RGB. How the paper
packs a normal is not said; ours is 256 v + u with (u, v) on the octahedron's map, 0 to 255 each.

The paper's records have no faces. Ours follow the rows as comments, ``#{0, 1, 2}`` below a line
``# faces {a, b, c}``, so that a reader of the paper's format passes them over. InitialPosition is
where the object stands: the middle of its box in x and y, its lowest point in z.
"""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import MeshError, Message
from paint3d.files.contents import plain_text, read_contents
from paint3d.files.raw_mesh import RawMesh, parse_numbers
from paint3d.files.sandbox import Found, notes_of, read_apart

__all__ = [
    "Records",
    "child_records",
    "pack_normals",
    "read_records",
    "read_records_here",
    "read_records_mesh",
    "standing_position",
    "unpack_normals",
    "write_records",
]

log = logging.getLogger("paint3d")

NUMBER = r"\s*([-+0-9.eE]+)\s*"
INITIAL = re.compile(rf"InitialPosition\s*=\s*\{{{NUMBER},{NUMBER},{NUMBER}\}}\.?\s*$")
ROW = re.compile(r"\{[^{}]*\}\.?\s*$")
NAMES = {9: "{x, y, z, nx, ny, nz, R, G, B}", 7: "{x, y, z, packed normal, R, G, B}"}
FACES = "# faces {a, b, c}"
FACE = re.compile(r"#\s*\{\s*(\d{1,12})\s*,\s*(\d{1,12})\s*,\s*(\d{1,12})\s*\}$")
CHUNK = 100_000
MAX_BYTES = 1 << 28


class Records(NamedTuple):
    """A painting as the paper stores it.

    Attributes
    ----------
    initial_position : (3,) float64
        What the rows' positions are relative to, mm.
    vertices : (V, 3) float64
        Positions on the object, mm: initial position added.
    normals : (V, 3) float64
        Unit.
    srgb : (V, 3) uint8
    faces : (F, 3) int64 or None
        None where the file has none, as the paper's.
    """

    initial_position: NDArray[np.float64]
    vertices: NDArray[np.float64]
    normals: NDArray[np.float64]
    srgb: NDArray[np.uint8]
    faces: NDArray[np.int64] | None = None


def standing_position(vertices: AnyArray) -> tuple[float, float, float]:
    """Position of an object, mm: middle of its box in x and y, its lowest point in z."""
    low, high = np.min(vertices, axis=0), np.max(vertices, axis=0)
    middle = (low + high) / 2.0
    # to the digits of the rows; 0 is added since -0 would be another text
    x, y, z = (np.round((middle[0], middle[1], low[2]), 4) + 0.0).tolist()
    return x, y, z


def write_records(
    path: str | os.PathLike[str],
    vertices: AnyArray,
    normals: AnyArray,
    srgb: NDArray[np.uint8],
    *,
    faces: AnyArray | None = None,
    initial_position: Sequence[float] = (0.0, 0.0, 0.0),
    packed: bool = False,
) -> None:
    """Write a painting's vertices, nine numbers a row or, `packed`, the paper's seven.

    Parameters
    ----------
    path : path-like
    vertices : (V, 3) array_like, mm
    normals : (V, 3) array_like, unit
    srgb : (V, 3) uint8
    faces : (F, 3) array_like of int, optional
        Written behind the rows, as comments.
    initial_position : (3,) array_like, mm
        Rows hold positions relative to it.
    packed : bool
        Write one packed normal (within 1 degree) for three components.

    Raises
    ------
    InputError
        If an array has the wrong shape or is not finite.
    OSError
        If the file cannot be written.
    """
    start = as_array(initial_position, "initial_position", (3,))
    position = as_array(vertices, "vertices", (None, 3)) - start
    shape = (len(position), 3)
    normal = as_array(normals, "normals", shape)
    codes = as_array(srgb, "srgb", shape, np.int64)
    middle = "%d" if packed else "%.5f, %.5f, %.5f"
    row = f"{{%.4f, %.4f, %.4f, {middle}, %d, %d, %d}}\n"
    columns = [position, pack_normals(normal)[:, None] if packed else normal, codes]
    table = np.concatenate(columns, axis=1)
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write(f"# columns {NAMES[7 if packed else 9]}, mm and sRGB codes\n")
        file.write("InitialPosition={{{:.9g}, {:.9g}, {:.9g}}}\n".format(*start))
        for first in range(0, len(table), CHUNK):
            part = table[first : first + CHUNK]
            file.write(row * len(part) % tuple(part.ravel().tolist()))
        if faces is None:
            return
        triangles = as_array(faces, "faces", (None, 3), np.int64)
        file.write(f"{FACES}, rows from 0\n")
        for first in range(0, len(triangles), CHUNK):
            part = triangles[first : first + CHUNK]
            file.write("#{%d, %d, %d}\n" * len(part) % tuple(part.ravel().tolist()))


def read_records(path: str | os.PathLike[str]) -> Records:
    """Read a file of seven or nine numbers a row, in a child process as `load_mesh` does.

    Raises
    ------
    MeshError
        ``file: line N: what`` if a line is neither, or rows differ in kind.
    """
    arrays, facts = read_apart(Path(path), f"{__name__}:{child_records.__name__}", [])
    for note in notes_of(facts):
        log.warning("%s: %s", path, note)
    arrays = {name: array.copy() for name, array in arrays.items()}
    start = np.array(facts["start"], np.float64)
    positions, directions, colours = (arrays[k] for k in ("positions", "directions", "colours"))
    return Records(start, positions, directions, colours, arrays.get("rows"))


def child_records(path: Path, wanted: list[Any]) -> Found:
    """Read records in the child process: what `read_records` makes `Records` of."""
    records = read_records_here(path)
    arrays: dict[str, AnyArray] = {"positions": records.vertices, "directions": records.normals}
    arrays |= {} if records.faces is None else {"rows": records.faces}
    arrays["colours"] = records.srgb
    return arrays, {"start": records.initial_position.tolist()}


def read_records_here(path: Path) -> Records:
    """Read such a file in this process.

    Raises
    ------
    MeshError
        As `read_records`.
    """
    try:
        return _parse_records(read_contents(path, MAX_BYTES))
    except MeshError as cause:
        raise MeshError("{file}: {cause}", file=path, cause=cause) from None


def _parse_records(data: bytes) -> Records:
    """Return the records in a file's bytes.

    Raises
    ------
    MeshError
        As `read_records`, without the file's name.
    """
    try:
        lines = plain_text(data).decode("utf-8").split("\n")
    except UnicodeDecodeError as cause:
        raise MeshError("it is not UTF-8: {cause}", cause=cause) from None
    rows = [(k, line.strip()) for k, line in enumerate(lines, 1) if line.strip()]
    comments = [(k, line) for k, line in rows if line.startswith("#")]
    rows = [(k, line) for k, line in rows if not line.startswith("#")]
    match = INITIAL.match(rows[0][1]) if rows else None
    if match is None:
        raise MeshError("expected InitialPosition={x, y, z} on its first line")
    try:
        start = np.array([float(number) for number in match.groups()])
    except ValueError:
        raise MeshError("line {first}: a coordinate is not a number", first=rows[0][0]) from None
    if len(rows) < 2:
        raise MeshError("it has no rows; expected one for each vertex")
    table = _parse_rows(rows[1:])
    normals = unpack_normals(table[:, 3]) if table.shape[1] == 7 else _normalise(table[:, 3:6])
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = table[:, :3] + start
    if not np.isfinite(vertices).all():
        raise MeshError("a position is not finite; expected numbers in mm")
    srgb = table[:, -3:].astype(np.uint8)
    return Records(start, vertices, normals, srgb, _read_faces(comments, len(vertices)))


def _read_faces(comments: list[tuple[int, str]], n_vertices: int) -> NDArray[np.int64] | None:
    """Return the triangles among a file's comments, from the line that announces them on."""
    announced = [n for n, (_, line) in enumerate(comments) if line.startswith(FACES)]
    if not announced:
        return None
    faces = []
    for k, line in comments[announced[0] + 1 :]:
        match = FACE.match(line)
        corners = [int(word) for word in match.groups()] if match else [n_vertices]
        if max(corners) >= n_vertices:
            raise MeshError(
                "line {k}: {line!r}; expected a face #{{a, b, c}} of rows from 0 to {n_vertices}",
                k=k,
                line=line[:60],
                n_vertices=n_vertices - 1,
            )
        faces.append(corners)
    return np.array(faces, np.int64).reshape(-1, 3)


def _normalise(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(over="ignore"):
        length = np.linalg.norm(normals, axis=1, keepdims=True)
    if not ((length > 0.0) & (length < np.inf)).all():
        raise MeshError("a normal has length 0, or more than numbers can tell")
    result: NDArray[np.float64] = normals / length
    return result


def _parse_rows(rows: list[tuple[int, str]]) -> NDArray[np.float64]:
    """Return all rows' numbers, (V, 7) or (V, 9)."""
    width = rows[0][1].count(",") + 1
    for k, line in rows:
        if not ROW.match(line) or line.count(",") + 1 != width or width not in NAMES:
            expected = NAMES.get(width, " or ".join(NAMES.values()))
            raise MeshError(
                "line {k}: {line!r}; expected {expected}",
                k=k,
                line=line[:60],
                expected=expected,
            )
    text = " ".join(line.strip("{}. \t").replace(",", " ") for _, line in rows)
    table = parse_numbers(text.encode("utf-8"), Message("a row"))
    if table.size != width * len(rows) or not np.isfinite(table).all():
        raise MeshError("a number is missing or not finite")
    table = table.reshape(-1, width)
    codes = table[:, -3:]
    wrong = np.flatnonzero(((codes < 0) | (codes > 255) | (codes % 1 != 0)).any(axis=1))
    if len(wrong):
        k, line = rows[wrong[0]]
        raise MeshError("line {k}: {line!r}; expected RGB codes from 0 to 255", k=k, line=line[:60])
    return table


def pack_normals(normals: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return one integer, 0 to 65535, for each unit normal (V, 3): its octahedral cell."""
    total = np.abs(normals).sum(axis=1, keepdims=True)
    n = normals / np.where(total > 0.0, total, 1.0)
    side = np.where(n[:, :2] >= 0.0, 1.0, -1.0)
    folded = np.where(n[:, 2:] >= 0.0, n[:, :2], (1.0 - np.abs(n[:, 1::-1])) * side)
    cell = np.clip(np.floor((folded + 1.0) * 128.0), 0, 255).astype(np.int64)
    return 256 * cell[:, 1] + cell[:, 0]


def unpack_normals(codes: AnyArray) -> NDArray[np.float64]:
    """Return the unit normals (V, 3) at the middle of the octahedral cells `codes` (V,).

    Raises
    ------
    MeshError
        If a code is not a whole number from 0 to 65535.
    """
    codes = np.asarray(codes, np.float64)
    if ((codes < 0) | (codes > 65535) | (codes % 1 != 0)).any():
        raise MeshError("a packed normal is out of range; expected 0 to 65535")
    cell = codes.astype(np.int64)
    flat = (np.stack([cell % 256, cell // 256], axis=1) + 0.5) / 128.0 - 1.0
    height = 1.0 - np.abs(flat).sum(axis=1)
    side = np.where(flat >= 0.0, 1.0, -1.0)
    unfolded = np.where(height[:, None] >= 0.0, flat, (1.0 - np.abs(flat[:, ::-1])) * side)
    normals = np.concatenate([unfolded, height[:, None]], axis=1)
    result: NDArray[np.float64] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return result


def read_records_mesh(data: bytes) -> RawMesh:
    """Read the paper's records as a mesh: positions, normals, and the colours as its ground.

    Without faces, as in the paper, it is a cloud of points with normals, and a surface is built
    through them.

    Raises
    ------
    MeshError
        With the number of the line that is not as expected.
    """
    records = _parse_records(data)
    faces = np.empty((0, 3), np.int64) if records.faces is None else records.faces
    announces = "" if records.faces is None else Message("faces")
    return RawMesh.of_triangles(
        records.vertices,
        faces,
        colours=records.srgb,
        normals=records.normals,
        unit_mm=1.0,
        up="z",
        announces=announces,
    )
