"""Refinement repeated from its log: the same bisections in the same order give the same mesh."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.refine import MOST_AROUND_EDGE, _split_edge

__all__ = ["BAD_LOG", "NO_ROOM", "repeat_splits"]

NO_ROOM, BAD_LOG = -1, -2


@kernel
def repeat_splits(field, log, at):
    """Bisect the nodes of `log` (n,) int32 from place `at[0]` on, where they are not yet halved.

    A log may come from a stranger, so each entry is checked before anything is changed: it must
    name a node there is, whose longest edge is longest in all triangles on that edge.

    Returns 0, NO_ROOM (reserve and call again), or BAD_LOG with the entry's place in `at`.
    """
    ring = np.empty(MOST_AROUND_EDGE, np.int64)
    mids = np.empty(2 * MOST_AROUND_EDGE, np.int64)
    while at[0] < log.shape[0]:
        t = log[at[0]]
        if t < 0 or t >= field.counts[1]:
            return BAD_LOG
        if field.child[t] >= 0:
            at[0] += 1
            continue
        h0 = 3 * t + field.longest[t]
        around = 1
        h = field.radial[h0]
        while h != h0:
            if field.longest[h // 3] != h % 3 or around == MOST_AROUND_EDGE:
                return BAD_LOG
            around += 1
            h = field.radial[h]
        if field.counts[0] + around > field.px.shape[0]:
            return NO_ROOM
        if field.counts[1] + 2 * around > field.child.shape[0]:
            return NO_ROOM
        _split_edge(field, h0, ring, mids)
        at[0] += 1
    return 0
