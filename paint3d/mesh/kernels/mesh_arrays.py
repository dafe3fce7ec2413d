"""The refined surface as kernels see it: vertices, bisection forest, cells and sheets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["BLOCK_VERTICES", "Cells", "Patch", "SurfaceField", "make_patch"]

BLOCK_VERTICES = 32  # base vertices to a block: neighbours, looked at together


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
    px: NDArray  # (cap,) float32 positions, mm
    py: NDArray
    pz: NDArray
    nx: NDArray  # (cap,) float32 unit normals
    ny: NDArray
    nz: NDArray
    key: NDArray  # (cap,) uint64, the same for the same vertex whatever the order of refinement
    parents: NDArray  # (cap, 2) int32, ends of the edge a vertex halved; -1 for base vertices
    vertex_sheet: NDArray  # (cap,) int32
    area_units: NDArray  # (cap,) int64, a third of the area around a vertex, in area units
    next_in_cell: NDArray  # (cap,) int32, -1 ends
    node_vertices: NDArray  # (N, 3) int32
    node_root: NDArray  # (N,) int32
    child: NDArray  # (N,) int32, first of two children, -1 for a leaf
    longest: NDArray  # (N,) int8, which edge is longest
    radial: NDArray  # (3 N,) int32, next half-edge around the same edge
    node_area: NDArray  # (N,) int64, a sixth of the node's area, in area units
    origin: NDArray  # (3,) float64, corner of the lattice, mm
    table: NDArray  # (2^k,) int32, hash table from lattice place to cell; -1 is empty
    cell_place: NDArray  # (C, 3) int32, lattice place
    cell_pairs: NDArray  # (C + 1,) int64, run of each cell in pair_root
    pair_root: NDArray  # (pairs,) int32, roots that meet the cell, ascending
    pair_sheet: NDArray  # (pairs,) int32
    cell_sheets: NDArray  # (C + 1,) int32, run of sheets
    base_start: NDArray  # (C + 1,) int32, run of base vertices
    cell_blocks: NDArray  # (C + 1,) int32, run of blocks
    block_balls: NDArray  # (blocks, 4) float32: centre and radius of a ball around the block, mm
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
