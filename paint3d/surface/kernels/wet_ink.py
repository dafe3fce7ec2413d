"""The pigment on a surface's vertices and that on the nodes of its wet part, each after the other.

N vertices, C places (vertices of the wet part), K nodes, B blocks and P pigments: see
`surface.wet_patch`.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["give_back", "mark_news"]


@kernel
def give_back(vertices, node_of, changed, pigment, soaked, written, ink, out):
    """Put pigment back on the vertices of nodes where it moved; ink that came since stays there.

    Parameters
    ----------
    vertices, node_of : (C,) i32
        Of each place.
    changed : (K,) bool
        Nodes where it moved; none afterwards.
    pigment, soaked : (K, P) f64, (K,) f32
        Coats times the covered share, and that share.
    written : (C, P) f32
        What was put there before, and is now.
    ink : InkField
        Of all vertices; changed.
    out : (C,) i32
        Filled with these vertices.

    Returns
    -------
    int
        How many they are.
    """
    amounts, coverage = ink.amounts, ink.coverage
    count = 0
    for place in range(vertices.shape[0]):
        node = node_of[place]
        if not changed[node]:
            continue
        vertex = vertices[place]
        inked = False
        for p in range(written.shape[1]):
            amount = np.float32(pigment[node, p])
            now, before = amounts[vertex, p], written[place, p]
            if now == before:
                amounts[vertex, p] = amount
            else:
                amounts[vertex, p] = max(now + (amount - before), np.float32(0.0))
            written[place, p] = amount
            inked = inked or amount != 0.0
        if inked:
            coverage[vertex] = max(coverage[vertex], soaked[node])
        out[count] = place
        count += 1
    for n in range(count):  # several vertices may share a node
        place = out[n]
        changed[node_of[place]] = False
        out[n] = vertices[place]
    return count


@kernel
def mark_news(ids, place, node_of, block, block_open, written, amounts, out):
    """Mark vertices (N,) whose ink is not what was put there, or lies where no ways are known.

    `place` (N,) i32 is theirs or -1, `block` (K,) i32, `block_open` (B,) bool; `out` (N,) bool is
    filled, the others are as in `give_back`.
    """
    for n in range(ids.shape[0]):
        vertex, at = ids[n], place[n]
        wet = differs = False
        for p in range(written.shape[1]):
            amount = amounts[vertex, p]
            wet = wet or amount != 0.0
            differs = differs or amount != (written[at, p] if at >= 0 else np.float32(0.0))
        out[n] = differs or (wet and not block_open[block[node_of[at]]])
