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

__all__ = ["link_triangles"]

_FLAT = 1e-9  # sine of the sum of two angles that counts as 180 degrees
_FLIPS_PER_FACE = 100


@kernel
def _pair_edges(order, low, high, mates):
    """Mates of half-edges, from their edges' ends (3F,) and the order that sorts these.

    Edges with one or more than two triangles have none (-1): they are never flipped.
    """
    n = order.shape[0]
    i = 0
    while i < n:
        first = order[i]
        j = i + 1
        while j < n and low[order[j]] == low[first] and high[order[j]] == high[first]:
            j += 1
        if j - i == 2:
            mates[first] = order[i + 1]
            mates[order[i + 1]] = first
        else:
            for k in range(i, j):
                mates[order[k]] = -1
        i = j


@kernel(error_model="numpy")
def _cosine(opposite, a, b):
    return min(1.0, max(-1.0, (a * a + b * b - opposite * opposite) / (2.0 * a * b)))


@kernel(error_model="numpy")
def _set_face(faces, lengths, f, corners, sides):
    """Set a face's corners (3,), and sides (3,) from each to the next."""
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
def _flip_to_delaunay(faces, lengths, mates):
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
def _cotangent_weights(lengths, weights):
    """Half the cotangent of the angle opposite each edge, (F, 3), from lengths (F, 3)."""
    for f in range(lengths.shape[0]):
        for k in range(3):
            a, b, c = lengths[f, k], lengths[f, (k + 1) % 3], lengths[f, (k + 2) % 3]
            cosine = _cosine(a, b, c)
            sine = np.sqrt(max(1.0 - cosine * cosine, 1e-16))
            weights[f, k] = 0.5 * cosine / sine


@kernel
def _sort_by(keys, n, order, starts, sorted_order):
    """Sort `order` (K,) by keys (M,), 0 to n - 1, into `sorted_order`; equal ones stay in order."""
    starts[: n + 1] = 0
    for k in range(order.shape[0]):
        starts[keys[order[k]] + 1] += 1
    for i in range(n):
        starts[i + 1] += starts[i]
    for k in range(order.shape[0]):
        key = keys[order[k]]
        sorted_order[starts[key]] = order[k]
        starts[key] += 1


@kernel
def _sort_pairs(first, second, n, starts):
    """(K,) i32 order that sorts pairs of numbers from 0 to n - 1."""
    order, work = np.empty((2, first.shape[0]), np.int32)
    for k in range(first.shape[0]):
        work[k] = k
    _sort_by(second, n, work, starts, order)
    _sort_by(first, n, order, starts, work)
    return work


@kernel
def _in_order(faces, n, starts):
    """Triangles (F, 3) each from its lowest corner on, sorted: whatever order they came in."""
    count = faces.shape[0]
    corners = np.empty((3, count), np.int32)
    order, work = np.empty((2, count), np.int32)
    for f in range(count):
        k = 0
        for other in range(1, 3):
            if faces[f, other] < faces[f, k]:
                k = other
        for step in range(3):
            corners[step, f] = faces[f, (k + step) % 3]
        order[f] = f
    _sort_by(corners[2], n, order, starts, work)
    _sort_by(corners[1], n, work, starts, order)
    _sort_by(corners[0], n, order, starts, work)
    ordered = np.empty((count, 3), np.int32)
    for f in range(count):
        for k in range(3):
            ordered[f, k] = corners[k, work[f]]
    return ordered


@kernel(error_model="numpy")
def _leave_out_flat(points, faces, lengths):
    """Keep the triangles with an area, and fill the lengths of their sides; return how many."""
    n = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        ab, bc, ca = _between(points, a, b), _between(points, b, c), _between(points, c, a)
        longest = max(ab, max(bc, ca))
        if ab + (bc + ca) - 2.0 * longest > 1e-9 * longest and min(ab, min(bc, ca)) > 0.0:
            _set_face(faces, lengths, n, (a, b, c), (ab, bc, ca))
            n += 1
    return n


@kernel(error_model="numpy", inline="always")
def _between(points, a, b):
    x, y, z = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1], points[a, 2] - points[b, 2]
    return np.sqrt(x * x + y * y + z * z)


@kernel
def _add_up(first, second, halves, order, runs, links, weights):
    """Add up what half-edges (K,) between the same two nodes have; see `link_triangles`."""
    n_links = 0
    node = 0
    k = 0
    while k < order.shape[0]:
        a, b = first[order[k]], second[order[k]]
        weight = halves[order[k]]
        more = 0.0
        k += 1
        while k < order.shape[0] and first[order[k]] == a and second[order[k]] == b:
            more += halves[order[k]]
            k += 1
        weight += more
        while node <= a:
            runs[node] = n_links
            node += 1
        if weight > 0.0 and a != b:
            links[n_links] = b
            weights[n_links] = weight
            n_links += 1
    runs[node:] = n_links
    return n_links


@kernel
def link_triangles(points, faces, runs, links, weights):
    """Find who touches whom in a triangle mesh, how strongly: the links from every node.

    The intrinsic Delaunay triangulation gives them, and half the sum of the two cotangents opposite
    an edge is its weight. It does not matter in which order triangles come. Those without an area
    are left out, and links whose weight is not above 0, which there are at borders alone.

    Parameters
    ----------
    points : (N, 3) f64
    faces : (F, 3) i32
    runs : (N + 1,) i64
        Filled: where the links of each node begin.
    links, weights : (6 F,) i32, f64
        Filled: the nodes that they lead to, rising for each node.

    Returns
    -------
    int
        How many links there are.
    """
    n = points.shape[0]
    starts = np.empty(n + 1, np.int64)
    ordered = _in_order(faces, n, starts)
    lengths = np.empty(ordered.shape)
    count = _leave_out_flat(points, ordered, lengths)
    ordered, lengths = ordered[:count], lengths[:count]
    ends = np.empty((2, 6 * count), np.int32)  # the edges from lower to higher, then both ways
    n_halves = 3 * count
    for f in range(count):
        for k in range(3):
            a, b = ordered[f, k], ordered[f, (k + 1) % 3]
            ends[0, 3 * f + k], ends[1, 3 * f + k] = min(a, b), max(a, b)
    mates = np.empty(n_halves, np.int64)
    low, high = ends[0, :n_halves], ends[1, :n_halves]
    _pair_edges(_sort_pairs(low, high, n, starts), low, high, mates)
    _flip_to_delaunay(ordered, lengths, mates)
    halves = np.empty(6 * count)
    _cotangent_weights(lengths, halves[:n_halves].reshape(lengths.shape))
    halves[n_halves:] = halves[:n_halves]
    for f in range(count):
        for k in range(3):
            h = 3 * f + k
            a, b = ordered[f, k], ordered[f, (k + 1) % 3]
            ends[0, h], ends[1, h], ends[0, n_halves + h], ends[1, n_halves + h] = a, b, b, a
    order = _sort_pairs(ends[0], ends[1], n, starts)
    return _add_up(ends[0], ends[1], halves, order, runs, links, weights)
