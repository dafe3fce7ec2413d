"""Triangles along common edges, and corners with a common normal.

Edges are told apart by welded vertices (one id per position), so that seams of the file do not
open the surface. Around each edge its half-edges form a ring; more than two in a ring is a
non-manifold edge, one alone an open one.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.bvh import closest_on
from paint3d.mesh.kernels.mesh_arrays import find_cell, sheet_of

__all__ = [
    "corner_normals",
    "count_around",
    "find_root",
    "link_cracks",
    "link_radial",
    "longest_sides",
    "measure_faces",
    "pieces_of",
    "smooth_corners",
    "weld_positions",
]


@kernel
def link_radial(faces, n_vertices):
    """Rings of half-edges: entry 3 t + e is the next half-edge around edge e of triangle t.

    Edge e runs from corner e to corner e + 1. `faces` (T, 3) int32 holds welded vertex ids.
    """
    n = faces.shape[0]
    first = np.zeros(n_vertices + 1, np.int32)
    for t in range(n):
        for e in range(3):
            first[min(faces[t, e], faces[t, (e + 1) % 3]) + 1] += 1
    for v in range(n_vertices):
        first[v + 1] += first[v]
    listed = np.empty(3 * n, np.int32)
    place = first[:-1].copy()
    for t in range(n):
        for e in range(3):
            low = min(faces[t, e], faces[t, (e + 1) % 3])
            listed[place[low]] = 3 * t + e
            place[low] += 1
    radial = np.empty(3 * n, np.int32)
    for v in range(n_vertices):
        for i in range(first[v], first[v + 1]):
            h = listed[i]
            if h < 0:
                continue
            high = max(faces[h // 3, h % 3], faces[h // 3, (h % 3 + 1) % 3])
            previous = h
            for j in range(i + 1, first[v + 1]):
                g = listed[j]
                if g < 0:
                    continue
                if max(faces[g // 3, g % 3], faces[g // 3, (g % 3 + 1) % 3]) == high:
                    radial[previous] = g
                    previous = g
                    listed[j] = -1
            radial[previous] = h
    return radial


@kernel
def find_root(parent, i):
    """The set that i belongs to, by its root; `parent` is changed so that it is found sooner."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel
def _join(parent, a, b):
    a = find_root(parent, a)
    b = find_root(parent, b)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b


@kernel
def pieces_of(faces, n_vertices):
    """Which faces hang together by their vertices: for each face the first vertex of its piece."""
    parent = np.arange(n_vertices).astype(np.int32)
    for t in range(faces.shape[0]):
        _join(parent, faces[t, 0], faces[t, 1])
        _join(parent, faces[t, 1], faces[t, 2])
    piece = np.empty(faces.shape[0], np.int32)
    for t in range(faces.shape[0]):
        piece[t] = find_root(parent, faces[t, 0])
    return piece


@kernel
def smooth_corners(faces, face_normals, radial, least_cosine):
    """Group the corners (3 T) that share one normal: same vertex, joined over smooth edges.

    Returns, for every corner, the first corner of its group. An edge is smooth when exactly two
    triangles meet there, run around it in opposite senses, and turn by less than the crease angle.
    """
    n = faces.shape[0]
    parent = np.arange(3 * n).astype(np.int32)
    for h in range(3 * n):
        g = radial[h]
        if g <= h or radial[g] != h:
            continue
        t, e = h // 3, h % 3
        s, f = g // 3, g % 3
        if faces[t, e] != faces[s, (f + 1) % 3]:
            continue
        cosine = 0.0
        for k in range(3):
            cosine += face_normals[t, k] * face_normals[s, k]
        if cosine < least_cosine:
            continue
        _join(parent, h, 3 * s + (f + 1) % 3)
        _join(parent, 3 * t + (e + 1) % 3, g)
    for c in range(3 * n):
        parent[c] = find_root(parent, c)
    return parent


@kernel
def corner_normals(points, faces, face_normals, vertex_of_corner, normals):
    """Sum the face normals around every vertex, weighted by the corner's angle; unit length."""
    normals[:] = 0.0
    for t in range(faces.shape[0]):
        for i in range(3):
            a = faces[t, i]
            b = faces[t, (i + 1) % 3]
            c = faces[t, (i + 2) % 3]
            dot, uu, vv = 0.0, 0.0, 0.0
            for k in range(3):
                u = np.float64(points[b, k]) - np.float64(points[a, k])
                v = np.float64(points[c, k]) - np.float64(points[a, k])
                dot += u * v
                uu += u * u
                vv += v * v
            span = np.sqrt(uu * vv)
            angle = np.arccos(min(1.0, max(-1.0, dot / span))) if span > 0.0 else 0.0
            for k in range(3):
                normals[vertex_of_corner[3 * t + i], k] += angle * face_normals[t, k]
    for v in range(normals.shape[0]):
        length = 0.0
        for k in range(3):
            length += normals[v, k] ** 2
        length = np.sqrt(length)
        for k in range(3):
            normals[v, k] = normals[v, k] / length if length > 0.0 else (1.0 if k == 2 else 0.0)


@kernel
def count_around(radial):
    """The most triangles that share one edge."""
    most = 0
    for h in range(radial.shape[0]):
        n = 1
        g = radial[h]
        while g != h and n < 1 << 20:
            n += 1
            g = radial[g]
        most = max(most, n)
    return most


@kernel
def measure_faces(points, faces, normals, double_areas):
    """Unit normals (F, 3) and twice the areas (F,) of triangles; a normal without area is 0."""
    for t in range(faces.shape[0]):
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        ux = np.float64(points[b, 0]) - np.float64(points[a, 0])
        uy = np.float64(points[b, 1]) - np.float64(points[a, 1])
        uz = np.float64(points[b, 2]) - np.float64(points[a, 2])
        vx = np.float64(points[c, 0]) - np.float64(points[a, 0])
        vy = np.float64(points[c, 1]) - np.float64(points[a, 1])
        vz = np.float64(points[c, 2]) - np.float64(points[a, 2])
        x = uy * vz - uz * vy
        y = uz * vx - ux * vz
        z = ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        double_areas[t] = length
        scale = 1.0 / length if length > 0.0 else 0.0
        normals[t, 0] = x * scale
        normals[t, 1] = y * scale
        normals[t, 2] = z * scale


@kernel
def longest_sides(points, faces, out):
    """The longest side (F,) of every triangle."""
    for t in range(faces.shape[0]):
        best = 0.0
        for e in range(3):
            a, b = faces[t, e], faces[t, (e + 1) % 3]
            length2 = 0.0
            for axis in range(3):
                d = np.float64(points[a, axis]) - np.float64(points[b, axis])
                length2 += d * d
            best = max(best, length2)
        out[t] = np.sqrt(best)


# ---- Welding -------------------------------------------------------------------------------------
# Which vertices lie at one place: a hash table of exact positions.


@kernel
def weld_positions(bits, table, ids):
    """Number the distinct rows of `bits` (V, 3) uint32 in the order in which they first come.

    Parameters
    ----------
    bits : (V, 3) uint32
        Positions as bit patterns; no minus zeros, so that equal bits are equal numbers.
    table : (2^k,) int32
        -1 everywhere, and longer than V: scratch.
    ids : (V,) int32
        Filled with each vertex's number.

    Returns
    -------
    int
        How many distinct positions there are.
    """
    mask = np.uint64(table.shape[0] - 1)
    n = 0
    for v in range(bits.shape[0]):
        h = np.uint64(bits[v, 0]) * np.uint64(0x9E3779B97F4A7C15)
        h = (h ^ (h >> np.uint64(29))) + np.uint64(bits[v, 1])
        h *= np.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> np.uint64(32))) + np.uint64(bits[v, 2])
        h *= np.uint64(0x94D049BB133111EB)
        slot = (h ^ (h >> np.uint64(31))) & mask
        while True:
            u = table[slot]
            if u < 0:
                table[slot] = v
                ids[v] = n
                n += 1
                break
            if bits[u, 0] == bits[v, 0] and bits[u, 1] == bits[v, 1] and bits[u, 2] == bits[v, 2]:
                ids[v] = ids[u]
                break
            slot = (slot + np.uint64(1)) & mask
    return n


# ---- Cracks --------------------------------------------------------------------------------------
# Cracks: open edges that lie so near to other surface that a brush does not know of them.
#
# Two halves of a body that were mirrored and never joined, a face whose long edge has a corner of
# its neighbours in the middle: nothing says that such faces belong together, but paint goes over.


_STEP = 0.25  # of a cell: places along an open edge


@kernel
def _length(points, start, end):
    """Distance between two vertices, mm."""
    length = 0.0
    for axis in range(3):
        length += (np.float64(points[end, axis]) - np.float64(points[start, axis])) ** 2
    return np.sqrt(length)


@kernel
def link_cracks(points, triangles, radial, cells, widest, links):
    """List links (n, 2) between sheets of a cell, one of which ends beside the other.

    Parameters
    ----------
    points, triangles, radial : arrays of `BaseSurface`
    cells : Cells
    widest : float
        Of a crack, mm.
    links : (N, 2) int32
        Filled as far as there is room; a link may come more than once.

    Returns
    -------
    int
        How many there are.
    """
    n = 0
    capacity = links.shape[0]
    place = np.empty(3)
    for h in range(radial.shape[0]):
        if radial[h] != h:
            continue
        t = h // 3
        start = triangles[t, h % 3]
        end = triangles[t, (h % 3 + 1) % 3]
        steps = max(1, int(np.ceil(_length(points, start, end) / (_STEP * cells.cell_size))))
        for k in range(steps):
            fraction = (k + 0.5) / steps
            for axis in range(3):
                place[axis] = (1.0 - fraction) * points[start, axis] + fraction * points[end, axis]
            cell = find_cell(cells, place[0], place[1], place[2])
            sheet = sheet_of(cells, cell, t) if cell >= 0 else -1
            if sheet < 0:
                continue
            for other in range(cells.cell_pairs[cell], cells.cell_pairs[cell + 1]):
                if cells.pair_sheet[other] == sheet:
                    continue
                a, b, c = triangles[cells.pair_root[other]]
                _v, _w, away2 = closest_on(points, a, b, c, place[0], place[1], place[2])
                if away2 > widest * widest:
                    continue
                if n < capacity:
                    links[n, 0] = sheet
                    links[n, 1] = cells.pair_sheet[other]
                n += 1
    return n
