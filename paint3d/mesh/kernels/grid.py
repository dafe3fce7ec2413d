"""The lattice of cells that the surface meets, and the sheets of surface in them.

Cells are hashed: memory goes with the surface, not with the box around it. A sheet is a connected
piece of surface within a cell; the graph of sheets is what tells the two sides of a thin wall, or
two shells a millimetre apart, from one another (the patch of Guo 2017, Fig. 7, made safe).
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import uncounted

__all__ = ["build_table", "find_cell", "find_pair", "flood_patch", "lookup", "sheet_of"]


@uncounted
def _hash(i, j, k):
    h = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15)
    h ^= np.uint64(j) * np.uint64(0xC2B2AE3D27D4EB4F)
    h ^= np.uint64(k) * np.uint64(0x165667B19E3779F9)
    h ^= h >> np.uint64(32)
    return h


@uncounted
def build_table(places, table):
    """Fill the hash table (a power of two long, -1 everywhere) with the cells' places (C, 3)."""
    mask = np.uint64(table.shape[0] - 1)
    for c in range(places.shape[0]):
        slot = _hash(places[c, 0], places[c, 1], places[c, 2]) & mask
        while table[slot] >= 0:
            slot = (slot + np.uint64(1)) & mask
        table[slot] = c


@uncounted
def lookup(table, places, i, j, k):
    """The cell at a lattice place, or -1."""
    mask = np.uint64(table.shape[0] - 1)
    slot = _hash(i, j, k) & mask
    while table[slot] >= 0:
        c = table[slot]
        if places[c, 0] == i and places[c, 1] == j and places[c, 2] == k:
            return c
        slot = (slot + np.uint64(1)) & mask
    return -1


@uncounted
def find_cell(field, x, y, z):
    """The cell that holds a point (mm), or -1 where no surface is near; `field` may be `Cells`."""
    size = field.cell_size
    i = int(np.floor((x - field.origin[0]) / size))
    j = int(np.floor((y - field.origin[1]) / size))
    k = int(np.floor((z - field.origin[2]) / size))
    return lookup(field.table, field.cell_place, i, j, k)


@uncounted
def sheet_of(field, cell, root):
    """The sheet that base triangle `root` belongs to in `cell`, or -1 if it does not meet it."""
    pair = find_pair(field.cell_pairs, field.pair_root, cell, root)
    return field.pair_sheet[pair] if pair >= 0 else -1


@uncounted
def find_pair(cell_pairs, pair_root, cell, root):
    """Index of the pair (cell, root), by bisection, or -1."""
    low = cell_pairs[cell]
    high = cell_pairs[cell + 1]
    while low < high:
        mid = (low + high) // 2
        if pair_root[mid] < root:
            low = mid + 1
        else:
            high = mid
    if low < cell_pairs[cell + 1] and pair_root[low] == root:
        return low
    return -1


@uncounted
def flood_patch(field, start, centre, radius, patch):
    """Sheets reached from `start` through sheets whose cells meet the ball.

    Parameters
    ----------
    field : SurfaceField
    start : int
        The sheet to start from; it is taken wherever the ball is.
    centre, radius : (3,) float64, float
        The ball, mm.
    patch : Patch
        Filled, nearest links first.

    Returns
    -------
    int
        Number of sheets in the patch.
    """
    patch.tick[0] += 1
    tick, ticks, sheets = patch.tick[0], patch.ticks, patch.sheets
    links, linked, places = field.sheet_links, field.linked_sheet, field.sheet_place
    size = field.cell_size
    r2 = (radius / size) ** 2
    px = (centre[0] - field.origin[0]) / size
    py = (centre[1] - field.origin[1]) / size
    pz = (centre[2] - field.origin[2]) / size
    sheets[0] = start
    ticks[start] = tick
    n = 1
    at = 0
    while at < n:
        s = sheets[at]
        at += 1
        for link in range(links[s], links[s + 1]):
            other = linked[link]
            if ticks[other] == tick:
                continue
            i = np.float64(places[other, 0])
            j = np.float64(places[other, 1])
            k = np.float64(places[other, 2])
            dx = max(0.0, max(i - px, px - i - 1.0))
            dy = max(0.0, max(j - py, py - j - 1.0))
            dz = max(0.0, max(k - pz, pz - k - 1.0))
            if dx * dx + dy * dy + dz * dz > r2:
                continue
            ticks[other] = tick
            sheets[n] = other
            n += 1
    patch.count[0] = n
    return n
