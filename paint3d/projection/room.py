"""The scratch arrays that the placement and stroke kernels work in, made once for a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.kernels.sweep import BETWEEN_SHAPE, FRAME_SIZE
from paint3d.kernels.tuft import OUTLINE_CAPACITY, SCRATCH_SIZE
from paint3d.mesh.paint_mesh import PaintMesh

__all__ = ["Room", "grow_room", "make_room"]

_BLOCK = 4096  # vertices projected at a time


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
    frame: NDArray  # (FRAME_SIZE,)
    between: NDArray  # BETWEEN_SHAPE
    tick: NDArray  # (2,) int64, patches flooded and sweeps gathered so far
    patch: NDArray  # (1,) int64, sheets in the patch that was flooded last
    stamps: NDArray  # (sheets,) int64, tick at which a sheet was last in the patch
    sheets: NDArray  # (sheets,) int32
    cell_ticks: NDArray  # (cells,) int64
    cells: NDArray  # (cells,) int32
    inside: NDArray  # (cells,) uint8, the cell lies well inside the outline
    xs: NDArray  # (_BLOCK,) float32
    ys: NDArray  # (_BLOCK,) float32
    stretch: NDArray  # (_BLOCK,) float32
    work: NDArray  # (4, _BLOCK) float32
    near: NDArray  # (_BLOCK,) int32
    ids: NDArray  # (_BLOCK,) int32
    found: NDArray  # (cap,) int32
    share: NDArray  # (cap,) float32
    cover: NDArray  # (cap,) float32
    part: NDArray  # (P,)


def make_room(mesh: PaintMesh, n_pigments: int) -> Room:
    """Scratch for painting on a mesh with so many pigments."""
    sheets, cells = mesh.n_sheets, mesh.n_cells
    return Room(
        foot=np.zeros(6),
        warm=np.zeros(5),
        vector=np.zeros(3),
        drag=np.zeros(3),
        tuft=np.zeros(SCRATCH_SIZE),
        reach=np.zeros(OUTLINE_CAPACITY),
        half_width=np.zeros(OUTLINE_CAPACITY),
        bounds=np.zeros(8),
        frame=np.zeros(FRAME_SIZE),
        between=np.zeros(BETWEEN_SHAPE),
        tick=np.zeros(2, np.int64),
        patch=np.zeros(1, np.int64),
        stamps=np.zeros(sheets, np.int64),
        sheets=np.zeros(sheets, np.int32),
        cell_ticks=np.zeros(cells, np.int64),
        cells=np.zeros(cells, np.int32),
        inside=np.zeros(cells, np.uint8),
        xs=np.zeros(_BLOCK, np.float32),
        ys=np.zeros(_BLOCK, np.float32),
        stretch=np.zeros(_BLOCK, np.float32),
        work=np.zeros((4, _BLOCK), np.float32),
        near=np.zeros(_BLOCK, np.int32),
        ids=np.zeros(_BLOCK, np.int32),
        **_per_vertex(mesh, n_pigments),
    )


def grow_room(room: Room, mesh: PaintMesh, n_pigments: int) -> Room:
    """The same scratch, for a mesh that has grown or a pigment more; what was begun goes on."""
    return room._replace(**_per_vertex(mesh, n_pigments))


def _per_vertex(mesh: PaintMesh, n_pigments: int) -> dict[str, NDArray]:
    return {
        "found": np.zeros(mesh.capacity, np.int32),
        "share": np.zeros(mesh.capacity, np.float32),
        "cover": np.zeros(mesh.capacity, np.float32),
        "part": np.zeros(n_pigments),
    }
