"""Vertices drawn together: what a mesh looks like whose triangles are smaller than a pixel.

Vertices in one cell of a lattice whose normals point the same way, roughly, are one *cluster*; it
stands at their mean, in their mean colour. A triangle whose corners lie in fewer than three
clusters is gone. As each vertex goes to one cluster, what was connected stays connected.
"""

from __future__ import annotations

from typing import NamedTuple

from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["Members", "cluster_vertices", "coarse_triangles", "list_members", "mean_of", "renumber"]

_SIDE = 0.5  # a normal's part along an axis beyond which it counts as pointing that way
_MOST = (1 << 19) - 1  # cells along an axis


class Members(NamedTuple):
    """The vertices of each of C clusters."""

    starts: NDArray  # (C + 1,) int32
    vertices: NDArray  # (V,) int32


@kernel(inline="always")
def _side(x):
    return 2 if x > _SIDE else (0 if x < -_SIDE else 1)


@kernel
def cluster_vertices(field, n, low, cells, size, table, keys, cluster):
    """Give vertices 0 to n - 1 their clusters, numbered as they are met.

    Parameters
    ----------
    field : MeshArrays
    n : int
    low : (3,) float64
        The lattice's corner, mm.
    cells : (3,) int64
        Cells along each axis; more than 2**19 count as so many.
    size : float
        Of a cell, mm.
    table : (T,) int32
        All -1; T a power of 2, above n.
    keys : (n,) int64
        Scratch.
    cluster : (n,) int32
        Written.

    Returns
    -------
    int
        How many clusters there are.
    """
    mask, scale, count = table.shape[0] - 1, 1.0 / size, 0
    for v in range(n):
        i = min(int((field.px[v] - low[0]) * scale), _MOST)
        j = min(int((field.py[v] - low[1]) * scale), _MOST)
        k = min(int((field.pz[v] - low[2]) * scale), _MOST)
        side = _side(field.nx[v]) + 3 * (_side(field.ny[v]) + 3 * _side(field.nz[v]))
        key = ((((i << 19) | j) << 19) | k) * 27 + side
        slot = (i + cells[0] * (j + cells[1] * k) + 7919 * side) & mask
        while table[slot] >= 0 and keys[table[slot]] != key:
            slot = (slot + 1) & mask
        if table[slot] < 0:
            table[slot] = count
            keys[count] = key
            count += 1
        cluster[v] = table[slot]
    return count


@kernel
def list_members(cluster, starts, vertices):
    """Sort vertices by cluster (V,) into `vertices` (V,); `starts` (C + 1,) is all 0 before."""
    for c in cluster:
        starts[c + 1] += 1
    for c in range(starts.shape[0] - 1):
        starts[c + 1] += starts[c]
    for v in range(cluster.shape[0] - 1, -1, -1):
        starts[cluster[v] + 1] -= 1
        vertices[starts[cluster[v] + 1]] = v
    for c in range(starts.shape[0] - 1):
        starts[c] = starts[c + 1]
    starts[-1] = cluster.shape[0]


@kernel
def coarse_triangles(faces, order, ends, cluster, out, out_ends):
    """Triangles between clusters, run by run.

    Parameters
    ----------
    faces : (F, 3) int32
    order : (L,) int32
        Which of them, in runs.
    ends : (R,) int64
        Where each run ends in `order`.
    cluster : (V,) int32
    out : (L, 3) int32
        Written: clusters.
    out_ends : (R,) int64
        Written: where each run ends in `out`.

    Returns
    -------
    int
        How many there are.
    """
    n, at = 0, 0
    for r in range(ends.shape[0]):
        while at < ends[r]:
            f = order[at]
            a, b, c = cluster[faces[f, 0]], cluster[faces[f, 1]], cluster[faces[f, 2]]
            if a != b and b != c and c != a:
                out[n, 0], out[n, 1], out[n, 2] = a, b, c
                n += 1
            at += 1
        out_ends[r] = n
    return n


@kernel
def renumber(triangles, numbers, ids):
    """Give the corners of triangles (L, 3) int32 numbers of their own, from 0.

    `numbers` (C,) int32 is all -1 before and after; `ids` (3 L,) is filled with what each number
    stands for. Returns how many there are.
    """
    n = 0
    for t in range(triangles.shape[0]):
        for k in range(3):
            c = triangles[t, k]
            if numbers[c] < 0:
                numbers[c] = n
                ids[n] = c
                n += 1
            triangles[t, k] = numbers[c]
    for i in range(n):
        numbers[ids[i]] = -1
    return n


@kernel
def mean_of(members, chosen, columns, out):
    """Write the mean of each chosen cluster's (N,) vertices: columns (V, K) to rows of `out`."""
    for c in chosen:
        first, last = members.starts[c], members.starts[c + 1]
        for k in range(columns.shape[1]):
            total = 0.0
            for m in range(first, last):
                total += columns[members.vertices[m], k]
            out[c, k] = total / (last - first)
