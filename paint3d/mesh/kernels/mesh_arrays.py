"""The refined surface as kernels see it: vertices, bisection forest, cells and sheets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import uncounted

__all__ = [
    "BLOCK_VERTICES",
    "Cells",
    "Patch",
    "SurfaceField",
    "as_index",
    "build_table",
    "find_cell",
    "find_pair",
    "flood_patch",
    "lookup",
    "make_patch",
    "mix",
    "sheet_of",
]

BLOCK_VERTICES = 16  # base vertices to a block: neighbours, looked at together


@uncounted
def mix(x):
    """Scramble 64 bits (splitmix64's finaliser)."""
    x ^= x >> np.uint64(30)
    x *= np.uint64(0xBF58476D1CE4E5B9)
    x ^= x >> np.uint64(27)
    x *= np.uint64(0x94D049BB133111EB)
    x ^= x >> np.uint64(31)
    return x


@uncounted(forceinline=True)
def as_index(v):
    """The number of a vertex as an index of 31 bits, which is known for none from an array's end.

    Compilers then look eight vertices up at once.
    """
    return np.uint32(v) & np.uint32(0x7FFFFFFF)


class Patch(NamedTuple):
    """Sheets of surface that hang together, flooded anew for every place (S sheets in all)."""

    tick: NDArray  # (1,) int64, patches flooded so far
    count: NDArray  # (1,) int64, sheets in the one that was flooded last
    sheets: NDArray  # (S,) int32, these
    ticks: NDArray  # (S,) int64, tick at which a sheet was last in the patch


def make_patch(n_sheets: int) -> Patch:
    """A patch of a surface with so many sheets; nothing is flooded yet."""
    return Patch(
        tick=np.zeros(1, np.int64),
        count=np.zeros(1, np.int64),
        sheets=np.zeros(n_sheets, np.int32),
        ticks=np.zeros(n_sheets, np.int64),
    )


class Cells(NamedTuple):
    """The cells that a surface meets, and the sheets of surface in them (C cells).

    What `SurfaceField` knows of them, by the same names, before there is one.
    """

    origin: NDArray  # (3,) float64, corner of the lattice, mm
    cell_size: float  # mm
    table: NDArray  # (2^k,) int32, hash table from lattice place to cell; -1 is empty
    cell_place: NDArray  # (C, 3) int32, lattice place
    cell_pairs: NDArray  # (C + 1,) int64, run of each cell in pair_root
    pair_root: NDArray  # (pairs,) int32, triangles that meet the cell, ascending
    pair_sheet: NDArray  # (pairs,) int32, the sheet that each belongs to there
    cell_sheets: NDArray  # (C + 1,) int32, run of sheets


class SurfaceField(NamedTuple):
    """Arrays of a `PaintMesh` (cap: room for vertices, N: for nodes, C cells, S sheets, R roots).

    A *cell* is a cube of a regular lattice that the surface meets. A *sheet* is one connected
    piece of surface in one cell. The base vertices of a cell stand in a run, cut into blocks
    of BLOCK_VERTICES neighbours; those that refinement adds are linked. Roots of the forest are
    the base triangles.
    """

    counts: NDArray  # (2,) int64: vertices, nodes
    resolution: float  # longest edge wanted, mm
    cell_size: float  # mm
    soft_edge: float  # width of a footprint's edge, mm
    area_unit: float  # mm2, of `area_units`
    area_step: float  # mm2, a power of two: of weighed areas, where these are summed
    paper: float  # how uneven fibres make edge and film: 0 on a glaze, 1 on raw xuan
    px: NDArray  # (cap,) float32 positions, mm
    py: NDArray
    pz: NDArray
    nx: NDArray  # (cap,) float32 unit normals
    ny: NDArray
    nz: NDArray
    mx: NDArray  # (cap,) float32, where a footprint's outline meets the vertex, mm: see `paper`
    my: NDArray
    mz: NDArray
    take: NDArray  # (cap,) float32, factor on the ink that a vertex takes
    key: NDArray  # (cap,) uint64, the same for the same vertex whatever the order of refinement
    parents: NDArray  # (cap, 2) int32, ends of the edge a vertex halved; -1 for base vertices
    vertex_sheet: NDArray  # (cap,) int32
    area_units: NDArray  # (cap,) int64, what a vertex stands for, in area units
    area: NDArray  # (cap,) float32, the same in mm2
    next_in_cell: NDArray  # (cap,) int32, -1 ends
    node_vertices: NDArray  # (N, 3) int32
    node_root: NDArray  # (N,) int32
    child: NDArray  # (N,) int32, first of two children, -1 for a leaf
    longest: NDArray  # (N,) int8, which edge is longest
    radial: NDArray  # (3 N,) int32, next half-edge around the same edge
    node_area: NDArray  # (N,) int64, the node's area, in area units
    origin: NDArray  # (3,) float64, corner of the lattice, mm
    table: NDArray  # (2^k,) int32, hash table from lattice place to cell; -1 is empty
    cell_place: NDArray  # (C, 3) int32, lattice place
    cell_pairs: NDArray  # (C + 1,) int64, run of each cell in pair_root
    pair_root: NDArray  # (pairs,) int32, roots that meet the cell, ascending
    pair_sheet: NDArray  # (pairs,) int32
    cell_sheets: NDArray  # (C + 1,) int32, run of sheets
    base_start: NDArray  # (C + 1,) int32, run of base vertices
    cell_blocks: NDArray  # (C + 1,) int32, run of blocks
    block_balls: NDArray  # (4, blocks) float32: centre and radius of a ball around the block, mm
    head: NDArray  # (C,) int32, first added vertex
    done: NDArray  # (C,) uint8, 1 where every leaf is fine enough
    sheet_cell: NDArray  # (S,) int32
    sheet_place: NDArray  # (S, 4) int32, lattice place of its cell, and the cell
    sheet_area: NDArray  # (S,) float64, mm2
    sheet_normal: NDArray  # (S, 3) float64, area times mean normal
    sheet_centre: NDArray  # (S, 3) float64, mm
    sheet_pack: NDArray  # (S, 8) float32: those three in one place: normal, area, centre, 0
    sheet_links: NDArray  # (S + 1,) int64
    linked_sheet: NDArray  # (links,) int32
    path: NDArray  # (64k,) int32 scratch


# ---- The lattice of cells ------------------------------------------------------------------------
# The lattice of cells that the surface meets, and the sheets of surface in them.
#
# Cells are hashed: memory goes with the surface, not with the box around it. A sheet is a connected
# piece of surface within a cell; the graph of sheets is what tells the two sides of a thin wall, or
# two shells a millimetre apart, from one another (the patch of Guo 2017, Fig. 7, made safe).


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
