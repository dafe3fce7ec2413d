"""Loading the object to paint: a built-in one by name, or a mesh file by suffix."""

from __future__ import annotations

import bz2
import gzip
import logging
import os
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, UnknownNameError
from paint3d.files.raw_mesh import RawMesh
from paint3d.mesh.polygons import triangulate
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["BUILT_IN_OBJECTS", "MESH_SUFFIXES", "UNITS_MM", "load_mesh"]

BUILT_IN_OBJECTS = ("bowl", "plate", "vase", "sphere", "plane")
UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
READERS = {".ply": "ply", ".obj": "obj", ".stl": "stl", ".off": "off", ".3mf": "3mf"}
READERS |= {".glb": "gltf", ".gltf": "gltf"}
MESH_SUFFIXES = tuple(READERS)
PACKED = {".gz": gzip.GzipFile, ".bz2": bz2.BZ2File}
MAX_UNPACKED = 4 << 30

# What damaged structure makes a reader stumble over; the careful messages come before these.
SURPRISES = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)

log = logging.getLogger("paint3d")


def load_mesh(
    path: str | os.PathLike[str], unit: str | None = None, *, from_points: bool = False
) -> TriangleMesh:
    """Load a mesh in millimetres, z up, with the vertex and face order of its file.

    Parameters
    ----------
    path : str or path-like
        A file (.ply .obj .stl .off .glb .gltf .3mf, also packed as .gz or .bz2), or the name of
        a built-in object: bowl, plate, vase, sphere, plane. An existing file wins over a name.
    unit : {"mm", "cm", "m", "in"}, optional
        Length of one unit in the file. By default what the format says (glTF: metres, 3MF: as
        the file states), and millimetres for formats that say nothing.
    from_points : bool
        Whether to build a surface through the points of a file that has no faces. Off by
        default: a guessed surface should not be mistaken for a measured one.

    Returns
    -------
    TriangleMesh
        Scenes are merged into one mesh with their transforms applied; polygons are cut into
        triangles; vertex colours are sRGB; faces that name a vertex twice are dropped.

    Raises
    ------
    MeshError
        If the file cannot be read or holds no usable surface: one line with file, reason and
        what was expected.
    """
    if unit is not None and unit not in UNITS_MM:
        raise UnknownNameError("unit", str(unit), UNITS_MM)
    path = _find(path)
    try:
        raw = _reader(path)(path)
        return _finish(raw, path.name.split(".")[0], unit, from_points)
    except MeshError as cause:
        raise MeshError(f"{path}: {cause}") from None
    except MemoryError:
        raise MeshError(f"{path}: it does not fit into memory") from None
    except SURPRISES as cause:
        raise MeshError(f"{path}: its structure is damaged near {cause}") from None


def _find(path: str | os.PathLike[str]) -> Path:
    found = Path(path)
    if found.is_file():
        return found
    if str(path) in BUILT_IN_OBJECTS:
        return _built_in(str(path))
    if found.is_dir():
        raise MeshError(f"{found}: it is a folder; expected a mesh file")
    names = ", ".join(BUILT_IN_OBJECTS)
    expected = f"expected a mesh file or one of the built-in objects {names}"
    raise MeshError(f"{found}: no such file; {expected}")


def _built_in(name: str) -> Path:
    """Return the file of a built-in object, in an installation or in a source tree."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "meshes", package.parent / "meshes"):
        if (folder / f"{name}.ply").is_file():
            return folder / f"{name}.ply"
    raise MeshError(f"the built-in object {name!r} is missing from this installation")


def _reader(path: Path) -> Callable[[Path], RawMesh]:
    """Return the reader for a path, by its suffix."""
    inner = Path(path.stem) if path.suffix.lower() in PACKED else path
    suffix = inner.suffix.lower()
    if suffix not in READERS:
        wanted = " ".join(MESH_SUFFIXES)
        shown = f"the suffix {suffix!r} is not known" if suffix else "it has no suffix"
        raise MeshError(f"{shown}; expected one of {wanted}")
    module = import_module(f"paint3d.files.read_{READERS[suffix]}")
    read = getattr(module, f"read_{READERS[suffix]}")
    if READERS[suffix] == "gltf":
        return lambda path: read(_contents(path), path.parent)
    return lambda path: read(_contents(path))


def _contents(path: Path) -> bytes:
    """Return the file's bytes, unpacked."""
    packing = PACKED.get(path.suffix.lower())
    try:
        if packing is None:
            data = path.read_bytes()
        else:
            with packing(path) as file:
                data = file.read(MAX_UNPACKED + 1)
    except (OSError, EOFError) as cause:
        raise MeshError(f"cannot read it: {getattr(cause, 'strerror', None) or cause}") from None
    if len(data) > MAX_UNPACKED:
        raise MeshError(f"it is larger than {MAX_UNPACKED >> 30} GiB; expected less")
    if not data:
        raise MeshError("the file is empty")
    return data


def _finish(raw: RawMesh, name: str, unit: str | None, from_points: bool) -> TriangleMesh:
    """Check a file's polygons and turn them into a mesh in mm, z up."""
    _check_raw(raw)
    if raw.y_up:
        raw = _z_up(raw)
    scale = UNITS_MM[unit] if unit else raw.unit_mm or 1.0
    vertices = raw.vertices * scale
    if len(raw.sizes) == 0:
        return _without_faces(raw, vertices, name, from_points)
    faces = triangulate(vertices, raw.corners, raw.sizes)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    if not distinct.all() and distinct.any():
        log.info("%s: dropped %d faces that name a vertex twice", name, (~distinct).sum())
        faces = faces[distinct]
    return TriangleMesh(vertices, faces, raw.colours, name, _unit_normals(raw.normals))


def _check_raw(raw: RawMesh) -> None:
    if len(raw.vertices) == 0:
        raise MeshError("it has no vertices and no triangles; expected a surface")
    bad = np.flatnonzero(~np.isfinite(raw.vertices).all(axis=1))
    if len(bad):
        where = ", ".join(f"{x:g}" for x in raw.vertices[bad[0]])
        raise MeshError(f"vertex {bad[0]} is ({where}); expected finite numbers")
    n = len(raw.vertices)
    outside = np.flatnonzero((raw.corners < 0) | (raw.corners >= n))
    if len(outside):
        face = int(np.searchsorted(np.cumsum(raw.sizes), outside[0], side="right"))
        index = int(raw.corners[outside[0]])
        raise MeshError(f"face {face} refers to vertex {index}; expected 0 to {n - 1}")


def _without_faces(
    raw: RawMesh, vertices: NDArray[np.float64], name: str, from_points: bool
) -> TriangleMesh:
    if not from_points:
        raise MeshError(
            f"it has {len(vertices):,} points but no triangles; expected a surface "
            "(from_points builds one through the points)"
        )
    from paint3d.files.points import surface_through

    faces = surface_through(vertices, raw.normals)
    log.warning("%s: built %d triangles through %d points", name, len(faces), len(vertices))
    return TriangleMesh(vertices, faces, raw.colours, name)


def _z_up(raw: RawMesh) -> RawMesh:
    def turn(v: NDArray | None) -> NDArray | None:
        return None if v is None else np.stack([v[:, 0], -v[:, 2], v[:, 1]], axis=1)

    return replace(raw, vertices=turn(raw.vertices), normals=turn(raw.normals))


def _unit_normals(normals: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """Return normals of length 1, or None where the file's are not usable as such."""
    if normals is None or not np.isfinite(normals).all():
        return None
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / length if (length > 1e-6).all() else None
