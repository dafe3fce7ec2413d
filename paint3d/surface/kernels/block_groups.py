"""Blocks of a wet surface: which have to do with one another, how often each is moved."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.topology import find_root

__all__ = ["grade_paces", "group_blocks"]


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
    """Let no pace (B,) f32 be more than `most` times that of a neighbour, among wet blocks (K,)."""
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
