"""Loading the object to paint: a built-in one by name, a mesh file by suffix, others' meshes."""

from __future__ import annotations

import logging
import os
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from paint3d.colour.materials import load_material
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.errors import MeshError, Message, UnknownNameError
from paint3d.files.package_meshes import package_class
from paint3d.files.progress import Progress
from paint3d.files.reading import (
    MESH_SUFFIXES,
    UNITS_MM,
    Reading,
    ReadOptions,
    read_surface,
    read_surface_apart,
    take_object,
)
from paint3d.mesh.sheet_mesh import make_sheet, with_paper
from paint3d.mesh.sheets import FORMS, is_sheet, parse_sheet
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import UP_AXES, turn_mesh, turn_up

__all__ = [
    "AUTO",
    "BUILT_IN_OBJECTS",
    "MESH_SUFFIXES",
    "UNITS_MM",
    "is_built_in",
    "load_mesh",
    "read_mesh",
]

AUTO = "auto"

BUILT_IN_OBJECTS = ("bowl", "plate", "vase", "sphere", "plane")

log = logging.getLogger("paint3d")

Foreign: TypeAlias = Any
"""Arrays, or a mesh of trimesh, Open3D or PyVista, none of which has to be there."""


def is_built_in(name: str) -> bool:
    """Return whether a name is that of a built-in object or a sheet."""
    return name in BUILT_IN_OBJECTS or is_sheet(name)


def load_mesh(
    path: str | os.PathLike[str] | Foreign,
    unit: str | None = None,
    *,
    from_points: bool | None = None,
    texture: bool = False,
    up: str | None = None,
    progress: Progress | None = None,
) -> TriangleMesh:
    """Load a mesh in millimetres, z up, with the vertex and face order of its file.

    With `texture` its vertices come first, where each of them has one colour. A file is read in a
    child process, which is given 20 s of computing (60 s with `texture`) and 2 GiB of memory and
    may crash alone. What the user should know about the result (a surface built through points, a
    texture left out) is logged as a warning by the logger "paint3d".

    Parameters
    ----------
    path : str, path-like, (vertices, faces), or mesh of another package
        A file whose suffix is one of `MESH_SUFFIXES`, also packed as .gz or .bz2, or the name of
        a built-in object: bowl, plate, vase, sphere, plane; or that of a sheet: scroll, couplet,
        square, horizontal, fan, round-fan, album, handscroll, a4, a3 or sheet:WIDTHxHEIGHT in mm,
        followed by another size, margin=MM or mounted, as in scroll:340x1000:mounted
        (`mesh.sheets`). An existing file wins over a name.
        Or arrays (vertices, faces) of triangles, a trimesh.Trimesh or Scene, an
        open3d.geometry.TriangleMesh or open3d.t.geometry.TriangleMesh, or a pyvista.PolyData: its
        arrays are copied and checked as a file's are, in this process.
    unit : {"mm", "cm", "m", "in"}, optional
        Length of one unit in the file. By default what the format says (glTF: metres, 3MF: as
        the file states), and millimetres for formats that say nothing.
    from_points : bool, optional
        Whether to build a surface through the points of a file without triangles. By default
        only for point clouds: files that speak of faces and hold none are refused.
    texture : bool
        Whether to take the colours and pictures of materials and faces (glTF, OBJ, PLY, 3MF).
        Where a picture is finer than the mesh, triangles are halved until it shows, up to some
        200,000 vertices more. Pictures outside the file's folder are not followed, and the logger
        says so, as it says what else a file holds that is left out.
    up : {"z", "y", "x", "-z", "-y", "-x", "auto"}, optional
        The axis of the file that points up; it becomes z. By default what the format says (glTF:
        y), and z for formats that say nothing. With "auto" those are guessed from how the object
        would stand, and the logger says what was taken for up; where that is not sure, it is z.
    progress : callable, optional
        Called with about the fraction done, now and then; what it raises stops it.

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

    Examples
    --------
    >>> import paint3d
    >>> paint3d.load_mesh("bowl").name
    'bowl'
    >>> corners, triangles = [(0, 0, 0), (40, 0, 0), (0, 40, 0)], [(0, 1, 2)]
    >>> paint3d.load_mesh((corners, triangles)).vertices.shape
    (3, 3)
    """
    reading = read_mesh(
        path, unit, from_points=from_points, texture=texture, up=up, progress=progress
    )
    for note in reading.notes:
        name = path if isinstance(path, str | os.PathLike) else package_class(path) or "mesh"
        log.warning("%s: %s", name, note)
    return reading.mesh


def read_mesh(
    path: str | os.PathLike[str] | Foreign,
    unit: str | None = None,
    *,
    from_points: bool | None = None,
    texture: bool = False,
    up: str | None = None,
    progress: Progress | None = None,
) -> Reading:
    """Load a mesh as `load_mesh` does, with its notes instead of logging them.

    Raises
    ------
    MeshError, UnknownNameError
    """
    if unit is not None and unit not in UNITS_MM:
        raise UnknownNameError("unit", str(unit), UNITS_MM)
    if up is not None and up not in (*UP_AXES, AUTO):
        raise UnknownNameError("up axis", str(up), (*UP_AXES, AUTO))
    wanted = ReadOptions(unit, from_points, texture, None if up == AUTO else up)
    if not isinstance(path, str | os.PathLike):
        taken = take_object(path, wanted)
        return _turn_as_guessed(taken) if up == AUTO and not taken.knows_up else taken
    file = _find_file(path)
    if file is None and is_sheet(str(path)):
        sheet = parse_sheet(str(path))
        paper = srgb_from_reflectance(load_material(sheet.usual.material).reflectance)
        return Reading(with_paper(make_sheet(sheet), paper), knows_up=True)
    if file is None:
        return replace(read_surface(_built_in_file(str(path)), wanted), knows_up=True)
    reading = read_surface_apart(file, wanted, progress=progress)
    return _turn_as_guessed(reading) if up == AUTO and not reading.knows_up else reading


def _turn_as_guessed(reading: Reading) -> Reading:
    guess = reading.likely_up
    if guess is None or not guess.sure:
        note = Message("which way is up is not sure; z is taken")
        return replace(reading, notes=(*reading.notes, note))
    if guess.up == "z":
        return reading
    mesh = turn_mesh(reading.mesh, turn_up(guess.up))
    note = Message("{axis} is taken for up", axis=guess.up)
    return replace(reading, mesh=mesh, notes=(*reading.notes, note))


def _find_file(path: str | os.PathLike[str]) -> Path | None:
    """Return the path of a file, or None for the name of a built-in object."""
    file = Path(path)
    if file.is_file():
        return file
    if is_built_in(str(path)):
        return None
    if file.is_dir():
        raise MeshError("{file}: it is a folder; expected a mesh file", file=file)
    if os.path.lexists(file):
        if file.is_symlink():
            raise MeshError(
                "{file}: it is a link that leads nowhere; expected a mesh file", file=file
            )
        raise MeshError("{file}: it is no plain file; expected a mesh file", file=file)
    raise MeshError(
        "{file}: no such file; expected a mesh file or one of the built-in objects {names}",
        file=file,
        names=", ".join((*BUILT_IN_OBJECTS, *FORMS)),
    )


def _built_in_file(name: str) -> Path:
    """Return the file of a built-in object, in an installation or in a source tree."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "meshes", package.parent / "meshes"):
        if (folder / f"{name}.ply").is_file():
            return folder / f"{name}.ply"
    raise MeshError("the built-in object {name!r} is missing from this installation", name=name)
