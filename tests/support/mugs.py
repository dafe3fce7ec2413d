"""A mug and a pot whose wall goes on where the handle stands on it, as in files of parts."""

from __future__ import annotations

import functools

import numpy as np
import trimesh

from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["make_mug", "make_pot_among_balls", "make_teapot"]

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


@functools.cache
def make_teapot() -> TriangleMesh:
    """A round pot about z, 110 mm wide and 90 mm high: its handle at +x, its spout at -x."""
    turns = np.linspace(-0.45 * np.pi, 0.4 * np.pi, 25)
    radii = [0, *(55.0 * np.cos(turns)), 0]
    heights = [0, *(46.0 + 47.0 * np.sin(turns)), 90]
    heights[1] = 0.0
    pot = trimesh.creation.revolve(np.column_stack([radii, heights]), sections=128)
    handle = trimesh.creation.torus(25.0, 5.0, major_sections=48, minor_sections=24)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([66.0, 0.0, 48.0])
    spout = trimesh.creation.cylinder(8.0, 70.0, sections=32)
    spout.apply_transform(trimesh.transformations.rotation_matrix(np.radians(-45), [0, 1, 0]))
    spout.apply_translation([-70.0, 0.0, 60.0])
    whole = trimesh.util.concatenate([pot, handle, spout])
    return TriangleMesh(whole.vertices, whole.faces, name="teapot")


def make_pot_among_balls(*places: tuple[float, float]) -> TriangleMesh:
    """A cylinder about z, 82 mm wide, with balls in the air before it: at a U and a height, mm."""
    parts = [trimesh.creation.cylinder(_RADIUS, _HEIGHT, sections=128)]
    for turn, height in places:
        angle = 2.0 * np.pi * (turn - 0.75)
        middle = (_RADIUS + 20.0) * np.cos(angle), (_RADIUS + 20.0) * np.sin(angle), height
        parts.append(trimesh.creation.icosphere(2, 6.0).apply_translation(middle))
    pot = trimesh.util.concatenate(parts)
    return TriangleMesh(pot.vertices, pot.faces, name="pot")
