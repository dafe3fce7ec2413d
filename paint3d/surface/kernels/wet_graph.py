"""The surface cut into blocks of cells, for liquids that move over it: what lies in each."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.topology import find_root

__all__ = [
    "count_vertices",
    "grade_paces",
    "group_blocks",
    "leaves_in_box",
    "list_distinct",
    "list_vertices",
    "pick_nodes",
]


@kernel
def count_vertices(field, cells):
    """Count the vertices that lie in some cells (K,)."""
    n = 0
    for k in range(cells.shape[0]):
        c = cells[k]
        n += field.base_start[c + 1] - field.base_start[c]
        v = field.head[c]
        while v >= 0:
            n += 1
            v = field.next_in_cell[v]
    return n


@kernel
def list_vertices(field, cells, vertices, number):
    """Write the vertices of some cells (K,), cell by cell, and each one's place among `cells`."""
    n = 0
    for k in range(cells.shape[0]):
        c = cells[k]
        for v in range(field.base_start[c], field.base_start[c + 1]):
            vertices[n] = v
            number[n] = k
            n += 1
        v = field.head[c]
        while v >= 0:
            vertices[n] = v
            number[n] = k
            n += 1
            v = field.next_in_cell[v]


@kernel
def _misses(field, corners, t, low, high):
    """Whether the box around a triangle lies outside the box low..high."""
    for axis in range(3):
        x = field.px if axis == 0 else field.py if axis == 1 else field.pz
        a, b, c = x[corners[t, 0]], x[corners[t, 1]], x[corners[t, 2]]
        if max(a, max(b, c)) < low[axis] or min(a, min(b, c)) > high[axis]:
            return True
    return False


@kernel
def leaves_in_box(field, roots, corners, low, high, out):
    """List the triangles that meet a box; return how many, or -1 if `out` is too short.

    Parameters
    ----------
    field : SurfaceField
    roots : (R,) int32
        Where to look.
    corners : (F, 3) int32
        Of the forest's triangles, or of the roots where nothing is refined.
    low, high : (3,) float64
    out : (M,) int32
    """
    n = 0
    forest = field.child.shape[0]
    stack = np.empty(256, np.int64)
    for r in range(roots.shape[0]):
        depth = 0
        stack[0] = roots[r]
        while depth >= 0:
            t = stack[depth]
            depth -= 1
            if _misses(field, corners, t, low, high):
                continue
            if forest > 0 and field.child[t] >= 0:
                stack[depth + 1] = field.child[t]
                stack[depth + 2] = field.child[t] + 1
                depth += 2
                continue
            if n == out.shape[0]:
                return -1
            out[n] = t
            n += 1
    return n


@kernel
def list_distinct(nodes, marks, out):
    """Write each of some nodes (K,) once, and set its mark, which was 0; return how many."""
    n = 0
    for k in range(nodes.shape[0]):
        if marks[nodes[k]] == 0:
            marks[nodes[k]] = 1
            out[n] = nodes[k]
            n += 1
    return n


@kernel
def pick_nodes(starts, stops, out):
    """Write the nodes of some runs (K,), one run after the other; return how many."""
    n = 0
    for k in range(starts.shape[0]):
        for i in range(starts[k], stops[k]):
            out[n] = i
            n += 1
    return n


# ---- Groups of blocks ----------------------------------------------------------------------------
# Blocks of a wet surface: which have to do with one another, how often each is moved.


@kernel
def group_blocks(blocks, first, last, beside, head, group):
    """Number the groups of some blocks, such that no block lies next to two of them.

    Parameters
    ----------
    blocks : (K,) i64
    first, last, beside : (B,) i64, (B,) i64, (M,) i32
        The run of each block's neighbours.
    head : (B,) i32
        Work, -1 before and after.
    group : (K,) i32
        Filled: 0 for the group of the first block, and so on.

    Returns
    -------
    int
        How many groups there are.
    """
    for k in range(blocks.shape[0]):
        b = blocks[k]
        if head[b] < 0:
            head[b] = b
        for e in range(first[b], last[b]):
            c = beside[e]
            if head[c] < 0:
                head[c] = c
            one, other = find_root(head, b), find_root(head, c)
            if one != other:
                head[max(one, other)] = min(one, other)
    count = 0
    number = np.full(head.shape[0], -1, np.int32)
    for k in range(blocks.shape[0]):
        top = find_root(head, blocks[k])
        if number[top] < 0:
            number[top] = count
            count += 1
        group[k] = number[top]
    for k in range(blocks.shape[0]):
        b = blocks[k]
        head[b] = -1
        for e in range(first[b], last[b]):
            head[beside[e]] = -1
    return count


@kernel
def grade_paces(wet, first, last, beside, most, pace):
    """Limit paces (B,) f32 to `most` times those of their neighbours, among wet blocks (K,)."""
    lowered = True
    while lowered:
        lowered = False
        for k in range(wet.shape[0]):
            b = wet[k]
            for e in range(first[b], last[b]):
                limit = np.float32(most * pace[b])  # as it is kept, or this never ends
                if pace[beside[e]] > limit:
                    pace[beside[e]] = limit
                    lowered = True
