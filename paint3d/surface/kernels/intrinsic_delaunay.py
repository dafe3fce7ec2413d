"""Intrinsic Delaunay triangulation and its cotangent weights.

Edges are flipped on the surface itself, by their lengths alone, until the two angles opposite each
add up to at most 180 degrees: then no cotangent weight inside is negative, which makes the
Laplacian one that cannot create new extremes, whatever the triangles were (Bobenko, Springborn:
A discrete Laplace-Beltrami operator for simplicial surfaces, 2007; Fisher, Springborn, Schroeder,
Bobenko: An algorithm for the construction of intrinsic Delaunay triangulations, 2006).
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["cotangent_weights", "flip_to_delaunay", "pair_edges"]

_FLAT = 1e-9  # sine of the sum of two angles that counts as 180 degrees
_FLIPS_PER_FACE = 100


@kernel
def pair_edges(order, keys, mates):
    """Mates of half-edges, from their edges' keys (3F,) and the order that sorts these.

    Edges with one or more than two triangles have none (-1): they are never flipped.
    """
    n = order.shape[0]
    i = 0
    while i < n:
        j = i + 1
        while j < n and keys[order[j]] == keys[order[i]]:
            j += 1
        if j - i == 2:
            mates[order[i]] = order[i + 1]
            mates[order[i + 1]] = order[i]
        else:
            for k in range(i, j):
                mates[order[k]] = -1
        i = j


@kernel(error_model="numpy")
def _cosine(opposite, a, b):
    return min(1.0, max(-1.0, (a * a + b * b - opposite * opposite) / (2.0 * a * b)))


@kernel(error_model="numpy")
def _set_face(faces, lengths, f, corners, sides):
    """Let a face have these corners (3,), and sides (3,) from each to the next."""
    faces[f, 0], faces[f, 1], faces[f, 2] = corners
    lengths[f, 0], lengths[f, 1], lengths[f, 2] = sides


@kernel
def _join(mates, h, other):
    mates[h] = other
    if other >= 0:
        mates[other] = h


@kernel
def _rejoin(mates, outer, old, now):
    """Join four edges, which are `now`, to their mates `outer`: where one was `old`, it moved."""
    for s in range(4):
        mate = outer[s]
        for t in range(4):
            if outer[s] == old[t]:
                mate = now[t]
        _join(mates, now[s], mate)


@kernel
def _list_inner(mates, stack, waiting):
    """Put one half of every inner edge on the stack; return how many there are."""
    depth = 0
    for h in range(mates.shape[0]):
        if mates[h] > h:
            stack[depth] = h
            depth += 1
            waiting[h] = True
    return depth


@kernel(error_model="numpy")
def _other_diagonal(a, b, c, d, e):
    """Length of the edge that takes the place of one of length a between two triangles.

    Their other sides are b and c, from its end and back to its start, and d and e, from its start.
    """
    lx = (a * a + c * c - b * b) / (2.0 * a)  # laid out in the plane, from 0 to (a, 0)
    qx = (a * a + d * d - e * e) / (2.0 * a)
    ly = np.sqrt(max(0.0, c * c - lx * lx))
    qy = np.sqrt(max(0.0, d * d - qx * qx))
    return np.sqrt((lx - qx) ** 2 + (ly + qy) ** 2)


@kernel(error_model="numpy")
def flip_to_delaunay(faces, lengths, mates):
    """Flip edges until the triangulation is intrinsic Delaunay; return how many were flipped.

    Parameters
    ----------
    faces : (F, 3) i32
        Corners; changed.
    lengths : (F, 3) f64
        Of the edge from corner k to corner k + 1; changed.
    mates : (3F,) i64
        The other half of each half-edge 3 f + k, -1 at borders; changed.
    """
    n = mates.shape[0]
    stack = np.empty(n + 8, np.int64)
    waiting = np.zeros(n, np.bool_)
    depth = _list_inner(mates, stack, waiting)
    flips = 0
    while depth > 0 and flips < _FLIPS_PER_FACE * faces.shape[0]:
        depth -= 1
        h = stack[depth]
        waiting[h] = False
        if mates[h] < 0 or mates[h] // 3 == h // 3:
            continue
        f, k, g, m = h // 3, h % 3, mates[h] // 3, mates[h] % 3
        k1, k2, m1, m2 = (k + 1) % 3, (k + 2) % 3, (m + 1) % 3, (m + 2) % 3
        a, b, c = lengths[f, k], lengths[f, k1], lengths[f, k2]
        d, e = lengths[g, m1], lengths[g, m2]
        one, two = _cosine(a, b, c), _cosine(a, d, e)
        sine_sum = one * np.sqrt(1.0 - two * two) + two * np.sqrt(1.0 - one * one)
        if sine_sum >= -_FLAT:
            continue
        # corners i, j on the edge, left and right opposite it
        i, j, left, right = faces[f, k], faces[f, k1], faces[f, k2], faces[g, m2]
        new = _other_diagonal(a, b, c, d, e)
        if not (new > 0.0 and new < b + e and new < c + d):
            continue  # slivers beyond what lengths can hold
        jl, li, iq, qj = mates[3 * f + k1], mates[3 * f + k2], mates[3 * g + m1], mates[3 * g + m2]
        _set_face(faces, lengths, f, (right, j, left), (e, b, new))
        _set_face(faces, lengths, g, (left, i, right), (c, d, new))
        # an outer edge may be one of the two triangles' own: then its mate has moved
        old = (3 * f + k1, 3 * f + k2, 3 * g + m1, 3 * g + m2)
        now = (3 * f + 1, 3 * g, 3 * g + 1, 3 * f)
        outer = (jl, li, iq, qj)
        _rejoin(mates, outer, old, now)
        _join(mates, 3 * f + 2, 3 * g + 2)
        flips += 1
        for s in range(4):
            edge = now[s]
            if mates[edge] >= 0 and not waiting[edge] and not waiting[mates[edge]]:
                waiting[edge] = True
                stack[depth] = edge
                depth += 1
    return flips


@kernel(error_model="numpy")
def cotangent_weights(lengths, weights):
    """Half the cotangent of the angle opposite each edge, (F, 3), from lengths (F, 3)."""
    for f in range(lengths.shape[0]):
        for k in range(3):
            a, b, c = lengths[f, k], lengths[f, (k + 1) % 3], lengths[f, (k + 2) % 3]
            cosine = _cosine(a, b, c)
            sine = np.sqrt(max(1.0 - cosine * cosine, 1e-16))
            weights[f, k] = 0.5 * cosine / sine
