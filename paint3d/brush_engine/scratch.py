"""The scratch arrays that the placement and stroke kernels work in, made once for a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.coverage import WORK_ROWS
from paint3d.brush_engine.distance import DISC_ROWS
from paint3d.brush_engine.sweep import BETWEEN_SHAPE, SWEEP
from paint3d.brush_engine.tuft import OUTLINE_CAPACITY, SCRATCH_SIZE
from paint3d.brush_engine.vertex_query import CURSOR_SIZE
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["Room", "grow_room", "make_room"]

_BLOCK = 2032  # vertices projected and weighed at a time; an odd number of cache lines


class Room(NamedTuple):
    """Scratch arrays of the stroke kernels."""

    foot: NDArray  # (6,)
    warm: NDArray  # (5,), what `find_foot` knows of the last foot
    vector: NDArray  # (3,)
    drag: NDArray  # (3,)
    tuft: NDArray  # (SCRATCH_SIZE,)
    reach: NDArray  # (OUTLINE_CAPACITY,)
    half_width: NDArray  # (OUTLINE_CAPACITY,)
    bounds: NDArray  # (8,)
    sweep: NDArray  # (1,) of SWEEP
    between: NDArray  # BETWEEN_SHAPE
    tick: NDArray  # (2,) int64, patches flooded and sweeps gathered so far
    patch: NDArray  # (1,) int64, sheets in the patch that was flooded last
    stamps: NDArray  # (sheets,) int64, tick at which a sheet was last in the patch
    sheets: NDArray  # (sheets,) int32
    cell_ticks: NDArray  # (cells,) int64
    cells: NDArray  # (sheets,) int32
    slopes: NDArray  # (sheets,) float32, how far the cell's normals lean from the plane's
    discs: NDArray  # (DISC_ROWS, sheets or blocks) float32, cells or blocks laid in the plane
    where: NDArray  # (2, sheets or blocks) uint8, where those lie to the sweep
    blocks: NDArray  # (blocks, 3) int32, runs of base vertices that may be reached
    runs: NDArray  # (cells + blocks, 3) int32, runs of base vertices, and where they lie
    cursor: NDArray  # (CURSOR_SIZE,) int64, where the next block of vertices begins
    rows: NDArray  # (7, _BLOCK) float32, what `weigh_block` knows of each vertex
    ids: NDArray  # (_BLOCK,) int32
    packed: NDArray  # (7, _BLOCK) float32
    packed_ids: NDArray  # (_BLOCK,) int32
    work: NDArray  # (WORK_ROWS, _BLOCK) float32
    near: NDArray  # (2, _BLOCK) int32
    kinds: NDArray  # (_BLOCK,) uint8
    eights: NDArray  # (_BLOCK / 8,) uint64, the same memory
    found: NDArray  # (cap + 1,) int32
    share: NDArray  # (cap + 1,) float32
    cover: NDArray  # (cap + 1,) float32
    part: NDArray  # (P,)
    taken: NDArray  # (P,)


def make_room(mesh: PaintMesh, n_pigments: int) -> Room:
    """Scratch for painting on a mesh with so many pigments."""
    sheets, cells = mesh.n_sheets, mesh.n_cells
    kinds = np.zeros(_BLOCK, np.uint8)
    return Room(
        foot=np.zeros(6),
        warm=np.zeros(5),
        vector=np.zeros(3),
        drag=np.zeros(3),
        tuft=np.zeros(SCRATCH_SIZE),
        reach=np.zeros(OUTLINE_CAPACITY),
        half_width=np.zeros(OUTLINE_CAPACITY),
        bounds=np.zeros(8),
        sweep=np.zeros(1, SWEEP),
        between=np.zeros(BETWEEN_SHAPE),
        tick=np.zeros(2, np.int64),
        patch=np.zeros(1, np.int64),
        stamps=np.zeros(sheets, np.int64),
        sheets=np.zeros(sheets, np.int32),
        cell_ticks=np.zeros(cells, np.int64),
        cells=np.zeros(sheets, np.int32),
        slopes=np.zeros(sheets, np.float32),
        discs=np.zeros((DISC_ROWS, max(sheets, mesh.n_blocks)), np.float32),
        where=np.zeros((2, max(sheets, mesh.n_blocks)), np.uint8),
        blocks=np.zeros((mesh.n_blocks, 3), np.int32),
        runs=np.zeros((cells + mesh.n_blocks, 3), np.int32),
        cursor=np.zeros(CURSOR_SIZE, np.int64),
        rows=np.zeros((7, _BLOCK), np.float32),
        ids=np.zeros(_BLOCK, np.int32),
        packed=np.zeros((7, _BLOCK), np.float32),
        packed_ids=np.zeros(_BLOCK, np.int32),
        work=np.zeros((WORK_ROWS, _BLOCK), np.float32),
        near=np.zeros((2, _BLOCK), np.int32),
        kinds=kinds,
        eights=kinds.view(np.uint64),
        **_per_vertex(mesh, n_pigments),
    )


def grow_room(room: Room, mesh: PaintMesh, n_pigments: int) -> Room:
    """The same scratch, for a mesh that has grown or a pigment more; what was begun goes on."""
    return room._replace(**_per_vertex(mesh, n_pigments))


def _per_vertex(mesh: PaintMesh, n_pigments: int) -> dict[str, NDArray]:
    room = mesh.capacity + 1  # one is written before it is known whether it counts
    return {
        "found": np.zeros(room, np.int32),
        "share": np.zeros(room, np.float32),
        "cover": np.zeros(room, np.float32),
        "part": np.zeros(n_pigments),
        "taken": np.zeros(n_pigments),
    }
