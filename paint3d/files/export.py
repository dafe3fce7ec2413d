"""A painting to a file, in the format its suffix names."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.arrays import as_array
from paint3d.errors import ExportError, MeshError, UnknownNameError
from paint3d.files.atomic import write_atomically
from paint3d.files.records import write_records
from paint3d.files.write_3mf import write_3mf
from paint3d.files.write_glb import write_glb
from paint3d.files.write_obj import write_obj
from paint3d.files.write_ply import write_ply

__all__ = ["EXPORT_SUFFIXES", "Exportable", "check_export_path", "export"]

DEFAULT_ROUGHNESS = 0.5


class Exportable(Protocol):
    """What can be exported: a PaintedSurface, or anything with its arrays and material."""

    @property
    def material(self) -> object:
        """The material; its ``name`` goes into the file and chooses the shine."""
        ...

    def export_arrays(self) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Return vertices (V, 3) mm, faces (F, 3), unit normals (V, 3) and sRGB codes (V, 3)."""
        ...


class Painting(NamedTuple):
    """Checked arrays of a painting and the name of its material."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    srgb: NDArray[np.uint8]
    material: str


def export(surface: Exportable, path: str | os.PathLike[str]) -> None:
    """Write a painting to `path`; the suffix chooses the format.

    .ply binary PLY (mm, sRGB bytes); .glb glTF 2.0 (metres, y up, linear colours); .obj (mm, sRGB
    after the position); .3mf (mm, sRGB at each corner, for printers); .p3d.txt the paper's
    records (vertices only); .png a picture.

    Parameters
    ----------
    surface : PaintedSurface
    path : path-like
        An existing file is replaced at the end, in one step; after a failure it is as it was.

    Raises
    ------
    ExportError
        If the suffix is not known or the file cannot be written.
    """
    path = Path(path)
    write = check_export_path(path)
    painting = _painting(surface)
    with write_atomically(path) as temporary:
        write(temporary, painting)


def check_export_path(path: str | os.PathLike[str]) -> Callable[[Path, Painting], None]:
    """Return the writer for a path, so that a bad suffix or folder is known before the work.

    Raises
    ------
    ExportError
        If the suffix is not known, or the folder is missing.
    """
    path = Path(path)
    name = path.name.lower()
    suffix = next((s for s in WRITERS if name.endswith(s)), None)
    if suffix is None:
        known = " ".join(EXPORT_SUFFIXES)
        shown = f"the suffix {path.suffix!r} is not known" if path.suffix else "it has no suffix"
        raise ExportError(f"{path}: {shown}; expected one of {known}")
    if not path.parent.is_dir():
        raise ExportError(f"{path}: the folder {path.parent} does not exist")
    return WRITERS[suffix]


def _painting(surface: Exportable) -> Painting:
    """Return the surface's arrays in the types that the writers take, checked."""
    vertices, faces, normals, srgb = surface.export_arrays()
    vertices = as_array(vertices, "vertices", (None, 3), np.float32, MeshError)
    shape = (len(vertices), 3)
    return Painting(
        vertices,
        as_array(faces, "faces", (None, 3), np.int32, MeshError),
        _unit(as_array(normals, "normals", shape, np.float32, MeshError)),
        _codes(srgb, shape),
        str(getattr(surface.material, "name", "painting")),
    )


def _codes(srgb: NDArray, shape: tuple[int, int]) -> NDArray[np.uint8]:
    srgb = np.ascontiguousarray(srgb)
    if srgb.dtype != np.uint8 or srgb.shape != shape:
        raise MeshError(f"srgb is {srgb.dtype} {srgb.shape}; expected uint8 {shape}")
    return srgb


def _unit(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return normals of length 1; vertices without one, which no face uses, point up."""
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals, dtype=np.float64))[:, None]
    unit = normals / np.where(length > 0.0, length, 1.0)
    return np.where(length > 0.0, unit, (0.0, 0.0, 1.0)).astype(np.float32)


def _write_ply(path: Path, painting: Painting) -> None:
    write_ply(path, painting.vertices, painting.faces, painting.normals, painting.srgb)


def _write_glb(path: Path, painting: Painting) -> None:
    gloss = _gloss(painting.material)
    roughness = DEFAULT_ROUGHNESS if gloss is None else gloss.roughness
    write_glb(path, *painting[:4], name=painting.material, roughness=roughness)


def _write_obj(path: Path, painting: Painting) -> None:
    write_obj(path, *painting[:4], name=painting.material)


def _write_3mf(path: Path, painting: Painting) -> None:
    write_3mf(path, painting.vertices, painting.faces, painting.srgb, name=painting.material)


def _write_records(path: Path, painting: Painting) -> None:
    write_records(path, painting.vertices, painting.normals, painting.srgb)


def _write_png(path: Path, painting: Painting) -> None:
    from paint3d.view.picture import render_picture  # brings VTK: only where a picture is asked

    render_picture(*painting[:4], path, gloss=_gloss(painting.material))


def _gloss(material: str) -> object | None:
    """Return how a material shines, or None for one that the view does not know."""
    from paint3d.view.studio import Gloss

    try:
        return Gloss.of(material)
    except UnknownNameError:
        return None


WRITERS: dict[str, Callable[[Path, Painting], None]] = {
    ".ply": _write_ply,
    ".glb": _write_glb,
    ".obj": _write_obj,
    ".3mf": _write_3mf,
    ".p3d.txt": _write_records,
    ".png": _write_png,
}
EXPORT_SUFFIXES = tuple(WRITERS)
