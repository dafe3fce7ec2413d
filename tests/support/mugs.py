"""Mugs with a handle, whose wall goes on where the handle stands on it, as in files of parts."""

from __future__ import annotations

import functools

import numpy as np
import trimesh

from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["make_mug"]

_RADIUS, _HEIGHT = 41.0, 95.0


@functools.cache
def make_mug(degrees: float, *, square: bool = False, at: tuple[float, float] = (0.0, 0.0)):
    """A mug about z, 82 mm wide and 95 mm high, with a ring as its handle.

    Parameters
    ----------
    degrees : float
        Where the handle is, from +x to the left seen from above.
    square : bool
        Whether it is a box that is open to the top.
    at : (float, float)
        Where its axis is, mm.
    """
    if square:
        wall = trimesh.creation.box((2 * _RADIUS, 2 * _RADIUS, _HEIGHT))
        wall.apply_translation([0.0, 0.0, 0.5 * _HEIGHT])
        wall = wall.subdivide_to_size(8.0)
    else:
        radii = [0, 40, 41, 41, 40.5, 38, 38, 37, 0]
        heights = [0, 0, 1, 94, 95, 95, 94, 4, 4]
        wall = trimesh.creation.revolve(np.column_stack([radii, heights]), sections=128)
    handle = trimesh.creation.torus(25.0, 5.0, major_sections=48, minor_sections=24)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([_RADIUS + 14.0, 0.0, 48.0])
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [0, 0, 1]))
    mug = trimesh.util.concatenate([wall, handle])
    mug.apply_translation([*at, 0.0])
    return TriangleMesh(mug.vertices, mug.faces, name="mug")
