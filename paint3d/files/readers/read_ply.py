"""PLY: polygons of any and mixed sizes, triangle strips, colours and normals of vertices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.readers.ply_looks import PlyLooks, has_face_colours, picture_names, ply_looks
from paint3d.files.readers.ply_tables import Element, Tables, read_tables
from paint3d.files.readers.raw_mesh import RawMesh, index_array, left_out
from paint3d.files.readers.vertex_colours import COLOUR_NAMES, colour_codes

__all__ = ["read_ply"]

WANTED = ("vertex", "face", "tristrips")
INDEX_NAMES = ("vertex_indices", "vertex_index")
STRIP_END = -1


def read_ply(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read a PLY file.

    Parameters
    ----------
    data : bytes
        The whole file.
    folder : Path
        Where its pictures lie; others are not followed.
    texture : bool
        Whether pictures and colours of faces are read, instead of vertex colours.

    Raises
    ------
    MeshError
        If the header is not PLY's, or the body does not hold what the header promises.
    """
    tables = read_tables(data, WANTED)
    vertex = next((e for e in tables.elements if e.name == "vertex"), None)
    if vertex is None or not {"x", "y", "z"} <= set(vertex.values):
        raise MeshError("no vertex positions; expected an element vertex with x, y and z")
    vertices = np.stack([vertex.values[k].astype(np.float64) for k in "xyz"], axis=1)
    corners, sizes = _polygons(tables)
    colours, notes = _colours(vertex)
    notes += tuple(f"its header's line {line[:60]!r} is passed over" for line in tables.unknown)
    dropped = ["lines"] if any(e.name == "edge" and e.count for e in tables.elements) else []
    if texture and len(sizes):
        found = ply_looks(tables, corners, sizes, folder)
        notes += found.notes
    else:
        found = PlyLooks()
        dropped += ["its pictures"] if picture_names(tables) else []
        dropped += ["colours of faces"] if has_face_colours(tables) else []
    notes += left_out(dropped)
    return RawMesh(
        vertices,
        corners,
        sizes,
        None if found.looks else colours,
        _normals(vertex),
        announces=_announced(tables),
        notes=notes,
        looks=found.looks,
        look_of=found.look_of,
        uv=found.uv,
        corner_colours=found.corner_colours,
    )


def _announced(tables: Tables) -> str:
    """What it speaks of besides points."""
    others = [e for e in tables.elements if e.name != "vertex" and (e.count or e.name in WANTED)]
    if any(element.name in WANTED for element in others):
        return "faces"
    return f"'{others[0].name[:40]}', which is not read" if others else ""


def _polygons(tables: Tables) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the corners of all polygons, then of the triangles of all strips, and their sizes."""
    corners, sizes = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for kind, what in (("face", "a face"), ("tristrips", "a strip")):
        for element in (e for e in tables.elements if e.name == kind):
            name = next((n for n in INDEX_NAMES if n in element.list_sizes), None)
            if name is None:
                continue
            ids = index_array(element.values[name], what)
            each = element.list_sizes[name].astype(np.int64)
            if kind == "tristrips":
                ids = _strips(ids, each)
                each = np.full(len(ids) // 3, 3)
            corners.append(ids)
            sizes.append(each)
    return np.concatenate(corners), np.concatenate(sizes)


def _strips(ids: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the corners of the triangles of strips (lists of these sizes; -1 begins another).

    Every second triangle of a strip is turned round; those that name a vertex twice only lead on
    to the next.
    """
    ids = np.where(ids == np.iinfo(np.uint32).max, STRIP_END, ids)
    ids = np.insert(ids, np.cumsum(sizes), STRIP_END)
    place = np.arange(len(ids))
    start = np.maximum.accumulate(np.where(ids == STRIP_END, place + 1, 0))
    faces = np.stack([ids[:-2], ids[1:-1], ids[2:]], axis=1)
    odd = (place - start)[:-2] % 2 == 1
    faces[odd] = faces[odd][:, [1, 0, 2]]
    whole = (faces != STRIP_END).all(axis=1)
    whole &= (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    result: NDArray[np.int64] = faces[whole].ravel()
    return result


def _colours(vertex: Element) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    for names in COLOUR_NAMES:
        if set(names) <= set(vertex.values):
            return colour_codes(np.stack([vertex.values[k] for k in names], axis=1))
    return None, ()


def _normals(vertex: Element) -> NDArray[np.float64] | None:
    if not {"nx", "ny", "nz"} <= set(vertex.values):
        return None
    return np.stack([vertex.values[k].astype(np.float64) for k in ("nx", "ny", "nz")], axis=1)
