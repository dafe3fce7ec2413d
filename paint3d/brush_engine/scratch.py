"""The scratch arrays that the placement and stroke kernels work in, made once for a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.coverage import Chords, make_chords
from paint3d.brush_engine.footprint import SWEEP
from paint3d.brush_engine.ink_transfer import LINES
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE
from paint3d.brush_engine.vertex_query import CURSOR_SIZE, DISC_ROWS
from paint3d.mesh.kernels.mesh_arrays import Patch, make_patch
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["ROWS", "Block", "Found", "Query", "Scratch", "grow_scratch", "make_scratch"]

_BLOCK = 2032  # vertices projected and weighed at a time; an odd number of cache lines
_COUNTERS = 8
ROWS = 7  # of numbers of a block's vertices


class Query(NamedTuple):
    """State of the search for what of a surface a sweep may reach."""

    tick: NDArray  # (1,) int64, sweeps gathered so far
    cell_ticks: NDArray  # (cells,) int64, tick at which a cell was last found
    cells: NDArray  # (sheets,) int32
    slopes: NDArray  # (sheets,) float32, greatest tangent of a cell's normals to the plane's,
    # negative where they look all ways
    discs: NDArray  # (DISC_ROWS, sheets or blocks) float32, cells or blocks laid in the plane
    fates: NDArray  # (sheets) uint8, where cells lie to the sweep
    block_fates: NDArray  # (blocks) uint8, and blocks
    runs: NDArray  # (cells + blocks, 3) int32, runs of base vertices, and where they lie
    cursor: NDArray  # (CURSOR_SIZE,) int64, where the next block of vertices begins


class Block(NamedTuple):
    """Vertices that are worked on together (N at the most)."""

    stretch: NDArray  # (N,) float32, how many times their area that of the plane is
    rows: NDArray  # (ROWS, N) float32, scratch
    work: NDArray  # (ROWS, N) float32
    near: NDArray  # (2, N) int32


class Found(NamedTuple):
    """Vertices that a sweep may cover: base vertices in runs, then those that refinement added.

    One more is written before it is known whether it counts.
    """

    count: NDArray  # (1,) int64, runs
    runs: NDArray  # (cells + 2 blocks + 1, 2) int32, first vertex of each, and how many
    ids: NDArray  # (cap + 1,) int32
    ahead: NDArray  # (cap + 1,) float32, where they lie along the sweep's way, mm
    aside: NDArray  # (cap + 1,) float32, and across it
    fraction: NDArray  # (cap + 1,) float32, of the ink: time-mean coverage times the stretch
    cover: NDArray  # (cap + 1,) float32, greatest fraction covered, 0 to 1
    lanes: NDArray  # (cap + 1,) int16, of the hairs' map; a solid tuft has none
    under: NDArray  # (cap + 1,) float32, fraction that hairs cover there; a solid tuft has none
    area: NDArray  # (cap + 1,) float32, that the vertex stands for, mm2
    take: NDArray  # (cap + 1,) float32, factor on the ink that it takes
    px: NDArray  # (cap + 1,) float32, where it is, mm
    py: NDArray
    pz: NDArray
    covered: NDArray  # (cap + 1,) float32, fraction of its area that was covered already
    coats: NDArray  # (cap + 1,) float32, wet ink that lies there
    heights: NDArray  # (cap + 1,) float32, of the tuft's liquid over it
    lacks: NDArray  # (cap + 1,) float32, coats of a first film that it lacks
    brings: NDArray  # (cap + 1,) float32, what bundles of hairs bring there, over their mean


class Scratch(NamedTuple):
    """Scratch arrays of the stroke kernels (P pigments)."""

    counters: NDArray  # (8,) int64: SAMPLES, FOOTPRINTS, VISITED, PAINTED, TILT_LIMITED,
    # OVERPRESSED, LEANING_OVER, each beside the kernels that count it
    pose: NDArray  # (9,), see `place_stamp`
    foot: NDArray  # (6,)
    warm: NDArray  # (5,), what `find_foot` knows of the last foot
    vector: NDArray  # (3,)
    drag: NDArray  # (3,)
    held: NDArray  # (3,)
    tuft: NDArray  # (SCRATCH_SIZE,)
    reach: NDArray  # (OUTLINE_CAPACITY,)
    half_width: NDArray  # (OUTLINE_CAPACITY,)
    sweep: NDArray  # (1,) of SWEEP
    chords: Chords
    part: NDArray  # (P,)
    taken: NDArray  # (P,)
    patch: Patch
    query: Query
    block: Block
    found: Found
    gains: NDArray  # (2, LINES) float32, what lines of the footprint along its way get, as
    # straight lines: first + second x place


def make_scratch(mesh: PaintMesh, n_pigments: int) -> Scratch:
    """Scratch for painting on a mesh with so many pigments."""
    return Scratch(
        counters=np.zeros(_COUNTERS, np.int64),
        pose=np.zeros(9),
        foot=np.zeros(6),
        warm=np.zeros(5),
        vector=np.zeros(3),
        drag=np.zeros(3),
        held=np.zeros(3),
        tuft=np.zeros(SCRATCH_SIZE),
        reach=np.zeros(OUTLINE_CAPACITY),
        half_width=np.zeros(OUTLINE_CAPACITY),
        sweep=np.zeros(1, SWEEP),
        chords=make_chords(),
        part=np.zeros(n_pigments),
        taken=np.zeros(n_pigments),
        patch=make_patch(mesh.n_sheets),
        query=_make_query(mesh),
        block=_make_block(),
        found=_make_found(mesh),
        gains=np.zeros((2, LINES), np.float32),
    )


def grow_scratch(scratch: Scratch, mesh: PaintMesh, n_pigments: int) -> Scratch:
    """The same scratch, for a mesh that has grown or a pigment more; what was begun goes on."""
    return scratch._replace(
        found=_make_found(mesh), part=np.zeros(n_pigments), taken=np.zeros(n_pigments)
    )


def _make_query(mesh: PaintMesh) -> Query:
    sheets, cells, blocks = mesh.n_sheets, mesh.n_cells, mesh.n_blocks
    return Query(
        tick=np.zeros(1, np.int64),
        cell_ticks=np.zeros(cells, np.int64),
        cells=np.zeros(sheets, np.int32),
        slopes=np.zeros(sheets, np.float32),
        discs=np.zeros((DISC_ROWS, max(sheets, blocks)), np.float32),
        fates=np.zeros(sheets, np.uint8),
        block_fates=np.zeros(blocks, np.uint8),
        runs=np.zeros((cells + blocks, 3), np.int32),
        cursor=np.zeros(CURSOR_SIZE, np.int64),
    )


def _make_block() -> Block:
    return Block(
        np.zeros(_BLOCK, np.float32),
        np.zeros((ROWS, _BLOCK), np.float32),
        np.zeros((ROWS, _BLOCK), np.float32),
        np.zeros((2, _BLOCK), np.int32),
    )


def _make_found(mesh: PaintMesh) -> Found:
    n, runs = mesh.capacity + 1, mesh.n_cells + 2 * mesh.n_blocks + 1
    kinds = {"ids": np.int32, "lanes": np.int16}
    return Found(
        np.zeros(1, np.int64),
        np.zeros((runs, 2), np.int32),
        *(np.zeros(n, kinds.get(name, np.float32)) for name in Found._fields[2:]),
    )
