"""Which vertices lie at one place: a hash table of exact positions."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["weld_positions"]


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
