"""Meshes that other packages hold in memory: trimesh, Open3D, PyVista. None is imported here.

Whoever has such an object has imported its package, so its class is looked up among the modules
that are loaded.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message
from paint3d.files.colours import MAX_PIXELS, Look, colour_codes, linear_from_srgb
from paint3d.files.raw_mesh import FACE_COLOURS, RawMesh, join_meshes, left_out, with_face_colours
from paint3d.mesh.foreign import arrays_of

__all__ = ["package_class", "read_object", "read_trimesh"]

_COLOURS = ("srgb", "RGB", "RGBA", "rgb", "rgba", "colors", "Colors")  # arrays of a PolyData
_PICTURES = Message("its colours and pictures")


def package_class(mesh: object) -> str | None:
    """Return the name of another package's class that an object is of; None for all others."""
    for name in _READERS:
        package, *words = name.split(".")
        kind: Any = sys.modules.get(package)
        for word in words:
            kind = getattr(kind, word, None)
        if isinstance(kind, type) and isinstance(mesh, kind):
            return name
    return None


def read_object(mesh: object, texture: bool = False) -> RawMesh:
    """Return the polygons of a mesh of another package, not yet checked.

    Parameters
    ----------
    mesh : (vertices, faces), trimesh.Trimesh, trimesh.Scene, open3d.geometry.TriangleMesh,
            open3d.t.geometry.TriangleMesh or pyvista.PolyData
        It is not changed.
    texture : bool
        Whether to take colours of faces, and the materials and pictures of trimesh.

    Raises
    ------
    MeshError
        If it is none of these, or its arrays do not fit together.
    """
    kind = package_class(mesh)
    if isinstance(mesh, tuple | list):
        return RawMesh.of_triangles(*arrays_of(mesh))
    if kind is None:
        raise MeshError(
            "a mesh is a {module}.{qualname}; expected a file, the name of an object, (vertices, "
            "faces), or one of {readers}",
            module=type(mesh).__module__,
            qualname=type(mesh).__qualname__,
            readers=", ".join(_READERS),
        )
    return _READERS[kind](mesh, texture)


# -- trimesh ------------------------------------------------------------------------------------


def read_trimesh(mesh_or_scene: Any, texture: bool = False) -> RawMesh:
    """Return the polygons of a Trimesh, or of all of a Scene's, transformed."""
    meshes = [mesh_or_scene] if hasattr(mesh_or_scene, "faces") else mesh_or_scene.dump()
    solid = [mesh for mesh in meshes if hasattr(mesh, "faces")]
    raws = [_read_one_trimesh(mesh, texture) for mesh in solid]
    notes = left_out({type(mesh).__name__ for mesh in meshes} - {type(m).__name__ for m in solid})
    unit_mm, unit_notes = _unit_of_trimesh(mesh_or_scene)
    raw = join_meshes(raws)
    every = tuple(dict.fromkeys((*raw.notes, *notes, *unit_notes)))
    return replace(raw, unit_mm=unit_mm, notes=every)


def _read_one_trimesh(mesh: Any, texture: bool) -> RawMesh:
    vertices = np.asarray(mesh.vertices, np.float64)
    faces = np.asarray(mesh.faces, np.int64)
    sound = len(faces) > 0 and faces.min() >= 0 and faces.max() < len(vertices)
    normals = _given_normals(mesh) if sound else None  # for trimesh looks at all of them
    raw = RawMesh.of_triangles(vertices, faces, normals=normals)
    look = mesh.visual
    kind = look.kind
    if kind == "vertex":
        return replace(raw, colours=_codes(look.vertex_colors))
    if kind == "face":
        return with_face_colours(raw, _codes(look.face_colors), texture)
    if kind != "texture":
        return raw
    if not texture:
        return replace(raw, notes=left_out([_PICTURES]))
    return _with_picture(raw, look)


def _given_normals(mesh: Any) -> NDArray[np.float64] | None:
    """Normals given with a Trimesh; None where it would compute them from its faces."""
    own, computed = mesh.vertex_normals, mesh.copy(include_cache=False).vertex_normals
    same = np.shape(own) == np.shape(computed) and np.allclose(own, computed, atol=1e-6)
    return None if same else np.asarray(own, np.float64)


def _with_picture(raw: RawMesh, visual: Any) -> RawMesh:
    look = _look_of(visual.material)
    notes: tuple[Message, ...] = ()
    uv = np.full((len(raw.corners), 2), np.nan)
    coordinates = None if visual.uv is None else np.asarray(visual.uv, np.float64)
    if coordinates is not None and len(coordinates) == len(raw.vertices):
        uv = coordinates[raw.corners, :2] * (1.0, -1.0) + (0.0, 1.0)
    elif look.picture is not None:
        look = replace(look, picture=None)
        notes = (Message("a texture is left out: the mesh has no places on it"),)
    look_of = np.zeros(len(raw.sizes), np.int64)
    return replace(raw, looks=(look,), look_of=look_of, uv=uv, notes=notes)


def _look_of(material: Any) -> Look:
    """Look of a material of trimesh: a linear factor (PBR), or a picture, or else a colour."""
    if hasattr(material, "diffuse"):
        if material.image is not None:
            return Look(picture=_pixels(material.image))
        factor = linear_from_srgb(np.asarray(material.diffuse, np.uint8)[:3])
    else:
        material = material if hasattr(material, "baseColorTexture") else material.to_pbr()
        base_factor = material.baseColorFactor
        factor = (
            np.ones(3) if base_factor is None else np.asarray(base_factor, np.uint8)[:3] / 255.0
        )
    red, green, blue = factor.tolist()
    picture = getattr(material, "baseColorTexture", None)
    return Look((red, green, blue), None if picture is None else _pixels(picture))


def _pixels(picture: Any) -> NDArray[np.uint8]:
    if picture.width * picture.height > MAX_PIXELS:
        size = f"{picture.width:,} x {picture.height:,}"
        raise MeshError(
            "its texture has {size} pixels; expected {most:,}",
            size=size,
            most=MAX_PIXELS,
        )
    return np.asarray(picture.convert("RGB"))


def _unit_of_trimesh(mesh_or_scene: Any) -> tuple[float | None, tuple[Message, ...]]:
    if mesh_or_scene.units is None:
        return None, ()
    convert = sys.modules["trimesh"].units.unit_conversion
    try:
        return float(convert(mesh_or_scene.units, "millimeters")), ()
    except (ValueError, KeyError):
        return None, (
            Message("its unit {unit!r:.40} is not known: mm are taken", unit=mesh_or_scene.units),
        )


# -- Open3D -------------------------------------------------------------------------------------


def _read_open3d(mesh: Any, texture: bool) -> RawMesh:
    normals = np.array(mesh.vertex_normals) if mesh.has_vertex_normals() else None
    raw = RawMesh.of_triangles(np.array(mesh.vertices), np.array(mesh.triangles), normals=normals)
    notes = left_out([_PICTURES]) if mesh.has_textures() else ()
    if not mesh.has_vertex_colors():
        return replace(raw, notes=notes)
    colours, more_notes = colour_codes(np.array(mesh.vertex_colors))
    return replace(raw, colours=colours, notes=(*notes, *more_notes))


def _read_open3d_tensor(mesh: Any, texture: bool) -> RawMesh:
    of_vertices = {name: mesh.vertex[name].cpu().numpy() for name in mesh.vertex}
    of_faces = {name: mesh.triangle[name].cpu().numpy() for name in mesh.triangle}
    empty = np.empty((0, 3))
    normals = of_vertices.get("normals")
    raw = RawMesh.of_triangles(
        np.asarray(of_vertices.get("positions", empty), np.float64),
        of_faces.get("indices", empty),
        normals=None if normals is None else np.asarray(normals, np.float64),
    )
    notes = left_out([_PICTURES]) if "texture_uvs" in of_faces else ()
    if "colors" in of_vertices:
        colours, more_notes = colour_codes(of_vertices["colors"])
        return replace(raw, colours=colours, notes=(*notes, *more_notes))
    if "colors" in of_faces:
        codes, more_notes = colour_codes(of_faces["colors"], whose=FACE_COLOURS)
        raw = raw if codes is None else with_face_colours(raw, codes, texture)
        return replace(raw, notes=(*raw.notes, *notes, *more_notes))
    return replace(raw, notes=notes)


# -- PyVista ------------------------------------------------------------------------------------


def _read_polydata(polydata: Any, texture: bool) -> RawMesh:
    mesh = polydata.triangulate() if polydata.n_strips else polydata
    corners, sizes = _polygons_of(np.asarray(mesh.faces, np.int64))
    normals = mesh.point_data.active_normals
    what = [Message("lines")] if mesh.n_lines else []
    raw = RawMesh(
        np.asarray(mesh.points, np.float64), corners, sizes,
        normals=None if normals is None else np.asarray(normals, np.float64),
        announces=Message("lines") if mesh.n_lines else "",
        notes=left_out(what) if len(sizes) else (),
    )  # fmt: skip
    colours = _find_colours(mesh.point_data)
    if colours is not None:
        return replace(raw, colours=_codes(colours))
    of_faces = _find_colours(mesh.cell_data)
    if of_faces is None or len(of_faces) != mesh.n_cells:
        return raw
    first = int(mesh.n_verts + mesh.n_lines)  # a PolyData counts points, lines, then polygons
    codes = _codes(of_faces)[first : first + len(sizes)]
    return with_face_colours(raw, codes, texture)


def _polygons_of(padded: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners (N,) and sizes (P,) of polygons stored as size, corners, size, corners."""
    if len(padded) and len(padded) % (padded[0] + 1) == 0:
        table = padded.reshape(-1, padded[0] + 1)
        if (table[:, 0] == padded[0]).all():
            return table[:, 1:].ravel(), table[:, 0].copy()
    at, sizes = 0, []
    starts = np.zeros(len(padded), np.bool_)
    while at < len(padded):
        starts[at] = True
        sizes.append(int(padded[at]))
        at += sizes[-1] + 1
    return padded[~starts], np.array(sizes, np.int64)


def _find_colours(data: Any) -> AnyArray | None:
    """The array of codes among a PolyData's: the one that is shown, else one named so."""
    names = [data.active_scalars_name, *_COLOURS]
    for name in names:
        if name in data.keys():  # noqa: SIM118  # it is no dictionary
            array = np.asarray(data[name])
            if array.dtype == np.uint8 and array.ndim == 2 and array.shape[1] in (3, 4):
                return array
    return None


# -- what they have in common -------------------------------------------------------------------


def _codes(colours: Any) -> NDArray[np.uint8]:
    """Codes (N, 3) of uint8 colours with or without an opacity."""
    return np.ascontiguousarray(np.asarray(colours)[:, :3], np.uint8)


_READERS: dict[str, Callable[[Any, bool], RawMesh]] = {
    "trimesh.Trimesh": read_trimesh,
    "trimesh.Scene": read_trimesh,
    "open3d.geometry.TriangleMesh": _read_open3d,
    "open3d.t.geometry.TriangleMesh": _read_open3d_tensor,
    "pyvista.PolyData": _read_polydata,
}
