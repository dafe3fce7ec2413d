"""An object cut into patches for a renderer that takes whole arrays: what to send it again.

Every triangle belongs to the patch of the sheet in which its middle lies: the walls of a bowl are
patches apart, and those that turn away need not be drawn. A patch keeps its own list of vertices,
which only ever grows, so a vertex's places in patches (*entries*, linked per vertex) stay good
while refinement replaces triangles around it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.mesh_arrays import find_cell, sheet_of

__all__ = [
    "Entries",
    "add_faces",
    "cone_of",
    "light_of_added",
    "mark_changed",
    "mark_holders",
    "mark_split",
    "place_faces",
    "shown_colours",
]


class Entries(NamedTuple):
    """Entries of vertices in patches (V: capacity for vertices, E: for entries)."""

    head: NDArray  # (V,) int32, a vertex's first entry, -1: in no patch
    patch: NDArray  # (E,) int32
    place: NDArray  # (E,) int32, the vertex's number within the patch
    following: NDArray  # (E,) int32, the vertex's next entry, -1 ends
    count: NDArray  # (1,) int64, entries there are


@kernel
def place_faces(field, faces, first, sheet_patch, out):
    """Write the patch of the faces (F, 3) from number `first` on into `out` (F,) int32.

    `sheet_patch` (S,) int32 is the patch of each sheet.
    """
    third = 1.0 / 3.0
    for f in range(first, faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x = (np.float64(field.px[a]) + field.px[b] + field.px[c]) * third
        y = (np.float64(field.py[a]) + field.py[b] + field.py[c]) * third
        z = (np.float64(field.pz[a]) + field.pz[b] + field.pz[c]) * third
        sheet = field.vertex_sheet[a]
        cell = find_cell(field, x, y, z)
        if cell >= 0:  # else it is rounded out of the lattice
            root = field.node_root[f] if f < field.node_root.shape[0] else f
            found = sheet_of(field, cell, root)
            sheet = found if found >= 0 else field.pair_sheet[field.cell_pairs[cell]]
        out[f] = sheet_patch[sheet]


@kernel
def mark_split(child, n_before, face_patch, marks):
    """Mark the patches of faces below `n_before` that have been split since."""
    for f in range(n_before):
        if child[f] >= n_before:
            marks[face_patch[f]] = 1


@kernel
def add_faces(all_faces, chosen, patch, n_held, entries, local_faces, new_ids):
    """Write a patch's faces with its own vertex numbers; vertices new to it are given one.

    Parameters
    ----------
    all_faces : (F, 3) int32
    chosen : (L,) int32
        The patch's faces.
    patch, n_held : int
        The patch, and how many vertices it has already.
    entries : Entries
        Filled; needs room for 3 L more.
    local_faces : (L, 3) int32
    new_ids : (3 L,) int32
        The vertices that are new, in the order of their numbers.

    Returns
    -------
    int
        How many are new.
    """
    fresh = 0
    for k in range(chosen.shape[0]):
        for corner in range(3):
            v = all_faces[chosen[k], corner]
            e = entries.head[v]
            while e >= 0 and entries.patch[e] != patch:
                e = entries.following[e]
            if e < 0:
                e = entries.count[0]
                entries.count[0] += 1
                entries.patch[e] = patch
                entries.place[e] = n_held + fresh
                entries.following[e] = entries.head[v]
                entries.head[v] = e
                new_ids[fresh] = v
                fresh += 1
            local_faces[k, corner] = entries.place[e]
    return fresh


@kernel
def mark_holders(vertex_ids, entries, marks):
    """Mark the patches that hold any of the vertices (N,) int32."""
    for i in range(vertex_ids.shape[0]):
        e = entries.head[vertex_ids[i]]
        while e >= 0:
            marks[entries.patch[e]] = 1
            e = entries.following[e]


@kernel
def mark_changed(before, colours, faces, marks):
    """Mark the corners of those triangles that look otherwise than before.

    Parameters
    ----------
    before : (N, C) uint8
        Colours that vertices had; vertices from number N on had none.
    colours : (K, C) uint8
        Those that they get.
    faces : (L, 3) int32
    marks : (K,) uint8
        Written: 0; 1 for a corner of a triangle one of whose corners changes.
    """
    changed, n_before = np.zeros(len(colours), np.uint8), len(before)
    for i in range(len(colours)):
        marks[i] = 0
        if i >= n_before:
            changed[i] = 1
            continue
        for c in range(colours.shape[1]):
            if before[i, c] != colours[i, c]:
                changed[i] = 1
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if changed[a] | changed[b] | changed[c]:
            marks[a] = marks[b] = marks[c] = 1


@kernel
def light_of_added(parents, first, last, light):
    """Give vertices `first` to `last` of `light` (V, 3) float32 the mean of their parents'."""
    half = np.float32(0.5)
    for v in range(first, last):
        a, b = parents[v, 0], parents[v, 1]
        for k in range(3):
            light[v, k] = half * (light[a, k] + light[b, k])


@kernel
def shown_colours(vertex_ids, srgb, light, linear, codes, out):
    """Colours (N, 3) uint8 of vertices as they are seen: their paint times the light on them.

    Parameters
    ----------
    vertex_ids : (N,) int32
    srgb : (V, 3) uint8
    light : (V, 3) float32
        On each vertex, over what makes ideal white as bright as the screen can show.
    linear : (256,) float32
        Linear light of each sRGB code.
    codes : (M,) uint8
        sRGB code of evenly spaced linear light from 0 to 1.
    out : (N, 3) uint8
    """
    last = codes.shape[0] - 1
    scale = np.float32(last)
    for i in range(vertex_ids.shape[0]):
        v = vertex_ids[i]
        for k in range(3):
            x = linear[srgb[v, k]] * light[v, k] * scale + np.float32(0.5)
            out[i, k] = codes[min(int(x), last)]


# ---- Facing --------------------------------------------------------------------------------------
# Which ways the triangles of a patch look.


@kernel
def cone_of(points, faces, cone):
    """Find a cone around the normals of some triangles.

    Parameters
    ----------
    points : (K, 3) float32
        mm.
    faces : (L, 3) int32
    cone : (4,) float64
        Written: its unit axis, and the cosine of the angle between it and the normal that is
        furthest from it. NaN where no triangle has an area, or the normals' sum is nothing.
    """
    normal, axis = np.empty(3), np.zeros(3)
    for i in range(faces.shape[0]):
        _cross(points, faces, i, normal)
        axis += normal
    size = np.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    cone[:] = np.nan
    if not size > 0.0:
        return
    cone[:3], cone[3] = axis / size, 1.0
    for i in range(faces.shape[0]):
        _cross(points, faces, i, normal)
        length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        if length > 0.0:
            along = normal[0] * cone[0] + normal[1] * cone[1] + normal[2] * cone[2]
            cone[3] = min(cone[3], along / length)


@kernel(inline="always")
def _cross(points, faces, i, normal):
    a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
    ax, ay, az = np.float64(points[a, 0]), np.float64(points[a, 1]), np.float64(points[a, 2])
    ux, uy, uz = points[b, 0] - ax, points[b, 1] - ay, points[b, 2] - az
    vx, vy, vz = points[c, 0] - ax, points[c, 1] - ay, points[c, 2] - az
    normal[0] = uy * vz - uz * vy
    normal[1] = uz * vx - ux * vz
    normal[2] = ux * vy - uy * vx
