"""Where paint ends between vertices: shares covered, made ready to be sharpened by a shader."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["Shares", "Triangles", "follow_shares"]


class Triangles(NamedTuple):
    """Triangles that know their neighbours (F triangles, V: room for vertices)."""

    faces: NDArray  # (F, 3) int32
    radial: NDArray  # (3 F,) int32, next half-edge around the same edge
    face_of: NDArray  # (V,) int32, one of the triangles at each vertex, -1: none


class Shares(NamedTuple):
    """Shares covered by paint (V: room for vertices), and what `view.edges` makes of them."""

    painted: NDArray  # (V,) uint8, 255: all
    smooth: NDArray  # (V,) float32, with those of the neighbours mixed in, 0 to 1
    sharp: NDArray  # (V,) uint8: the edge is where it is half
    marks: NDArray  # (V,) uint8, scratch, all 0 between calls
    listed: NDArray  # (V,) int32, scratch


@kernel(inline="always")
def _corner_of(faces, t, v):
    """Return which corner of triangle t vertex v is; -1 if none."""
    return 0 if faces[t, 0] == v else (1 if faces[t, 1] == v else (2 if faces[t, 2] == v else -1))


@kernel
def _ring(triangles, v, around):
    """List the other two corners of every triangle at vertex v; return how many are listed.

    Of more than fit into `around` (N,) int32 the first ones are listed.
    """
    faces, radial, n = triangles.faces, triangles.radial, 0
    start = triangles.face_of[v]
    if start < 0:
        return 0
    for way in range(2, 0, -1):  # across the edge that ends at v; from a border back the other way
        t, k = start, _corner_of(faces, start, v)
        while k >= 0 and n + 2 <= around.shape[0]:
            if way == 2 or t != start:
                around[n] = faces[t, (k + 1) % 3]
                around[n + 1] = faces[t, (k + 2) % 3]
                n += 2
            edge = 3 * t + (k if way == 1 else (k + 2) % 3)
            after = radial[edge]
            if after == edge:
                break
            t = after // 3
            if t == start:
                return n
            k = _corner_of(faces, t, v)
    return n


@kernel
def _with_rings(triangles, ids, n, marks, listed, around):
    """Mark and list the first n vertices of `ids` and all around them; return how many."""
    count = 0
    for i in range(n):
        v = ids[i]
        if marks[v] == 0:
            marks[v] = 1
            listed[count] = v
            count += 1
    for i in range(n):
        for k in range(_ring(triangles, ids[i], around)):
            v = around[k]
            if marks[v] == 0:
                marks[v] = 1
                listed[count] = v
                count += 1
    for i in range(count):
        marks[listed[i]] = 0
    return count


@kernel
def follow_shares(ids, triangles, mixed, least, shares, changed):
    """Bring `smooth` and `sharp` up to date around vertices whose share painted has changed.

    Parameters
    ----------
    ids : (N,) int32
    triangles : Triangles
    mixed, least : float
        As in `view.edges`.
    shares : Shares
    changed : (V,) int32
        Filled with the vertices whose `sharp` differs now.

    Returns
    -------
    int
        How many these are.
    """
    around = np.empty(64, np.int32)
    painted, smooth, sharp, listed = shares.painted, shares.smooth, shares.sharp, shares.listed
    own, part = np.float32((1.0 - mixed) / 255.0), np.float32(mixed / 255.0)
    count = _with_rings(triangles, ids, ids.shape[0], shares.marks, listed, around)
    for i in range(count):
        v = listed[i]
        n = _ring(triangles, v, around)
        total = np.int64(0)
        for k in range(n):
            total += painted[around[k]]
        mean = np.float32(total) / np.float32(n) if n > 0 else np.float32(painted[v])
        smooth[v] = own * np.float32(painted[v]) + part * mean
        changed[i] = v
    count = _with_rings(triangles, changed, count, shares.marks, listed, around)
    n_changed, floor = 0, np.float32(least)
    for i in range(count):
        v = listed[i]
        top = smooth[v]
        for k in range(_ring(triangles, v, around)):
            top = max(top, smooth[around[k]])
        whole = min(np.float32(1.0), np.float32(floor * top))
        share = smooth[v] / whole if whole > 0.0 else np.float32(0.0)
        code = np.uint8(np.float32(255.0) * min(share, np.float32(1.0)) + np.float32(0.5))
        if code != sharp[v]:
            sharp[v] = code
            changed[n_changed] = v
            n_changed += 1
    return n_changed
