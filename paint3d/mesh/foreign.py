"""Meshes that others hold in memory, by their arrays: pairs, trimesh, Open3D, PyVista."""

from __future__ import annotations

from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["arrays_of", "as_mesh"]


def as_mesh(found: Any) -> TriangleMesh:
    """Return a mesh from whatever holds one: its vertices are mm, its faces triangles.

    Colours, units and axes are left out; `load_mesh` takes them.

    Parameters
    ----------
    found : TriangleMesh, (vertices, faces), or a mesh of trimesh, Open3D or PyVista
        Arrays (V, 3) and (F, 3).

    Raises
    ------
    MeshError
        If it holds no such arrays, or they cannot be used.
    """
    if isinstance(found, TriangleMesh):
        return found
    return TriangleMesh(*arrays_of(found))


def arrays_of(found: Any) -> tuple[AnyArray, AnyArray]:
    """Return vertices (V, 3) and faces (F, 3) of what holds a mesh.

    Raises
    ------
    MeshError
        If it holds none.
    """
    try:
        if isinstance(found, tuple | list):
            vertices, faces = found
        elif hasattr(found, "n_cells"):  # PyVista
            shape = found if found.is_all_triangles else found.triangulate()
            vertices, faces = shape.points, shape.regular_faces
        elif hasattr(found, "triangle") and hasattr(found, "vertex"):  # Open3D's tensors
            vertices = found.vertex["positions"].cpu().numpy()
            faces = found.triangle["indices"].cpu().numpy()
        elif hasattr(found, "faces"):  # trimesh, and what is like it
            vertices, faces = found.vertices, found.faces
        else:  # Open3D
            vertices, faces = found.vertices, found.triangles
        arrays = np.asarray(vertices, np.float64), np.asarray(faces, np.int64)
    except (AttributeError, KeyError, TypeError, ValueError):
        raise MeshError(
            "a mesh is {module}.{qualname}; expected (vertices, faces), or a mesh of load_mesh, "
            "trimesh, Open3D or PyVista",
            module=type(found).__module__,
            qualname=type(found).__qualname__,
        ) from None
    for name, array in zip(("vertices", "faces"), arrays, strict=True):
        if array.ndim != 2 or array.shape[1] != 3:
            raise MeshError(
                "{name} have shape {array_shape}; expected (N, 3)",
                name=name,
                array_shape=array.shape,
            )
    return arrays
