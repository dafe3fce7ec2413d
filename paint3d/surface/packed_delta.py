"""A `SurfaceDelta` in few bytes, with vertices by the numbers that they have in a file.

Most of what a stroke goes over was bare before, and most of a patch of water is dry: only rows that
hold something are kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.refinement_log import saved_ids
from paint3d.surface.delta import BrushLoad, SurfaceDelta
from paint3d.surface.dry_layers import DryRows
from paint3d.surface.state import FLOW_VERTICES

__all__ = ["PackedDelta", "PackedFlow", "VertexNumbers", "pack_delta", "pack_flow"]


class NumbersNow(Protocol):
    """What the numbers of vertices in a file are in the mesh."""

    def now(self, saved: AnyArray) -> AnyArray:
        """(N,) int32 in the mesh."""
        ...


class VertexNumbers:
    """The numbers of a mesh's vertices in a file, and the other way; more may come.

    Parameters
    ----------
    mesh : PaintMesh
    """

    def __init__(self, mesh: PaintMesh) -> None:
        n = mesh.n_base_vertices  # those that were added have the same number in both
        self._saved = saved_ids(mesh)[:n]
        self._now = np.empty(n, np.int32)
        self._now[self._saved] = np.arange(n, dtype=np.int32)

    def saved(self, vertex_ids: AnyArray) -> NDArray[np.int32]:
        """(N,) int32 in a file."""
        return _mapped(vertex_ids, self._saved)

    def now(self, saved: AnyArray) -> NDArray[np.int32]:
        """(N,) int32 in the mesh."""
        return _mapped(saved, self._now)


def _mapped(ids: AnyArray, table: AnyArray) -> AnyArray:
    found = np.array(ids, np.int32)
    base = found < len(table)
    found[base] = table[found[base]]
    return found


@dataclass(frozen=True, eq=False)
class PackedFlow:
    """What `PaintedSurface.keep_flow` gives, without rows in which nothing is.

    Attributes
    ----------
    n : int
        Vertices of the patch, C.
    rows : (H,) int32
        Those that hold something.
    arrays : mapping
        Of floats with a row a vertex only those rows; numbers of vertices are those of a file.
    """

    n: int
    rows: NDArray[np.int32]
    arrays: Mapping[str, AnyArray]

    @property
    def n_bytes(self) -> int:
        """Memory that it takes."""
        return self.rows.nbytes + sum(array.nbytes for array in self.arrays.values())

    def unpacked(self, numbers: NumbersNow) -> dict[str, AnyArray]:
        """As `PaintedSurface.restore_flow` takes it."""
        flow = {}
        for name, array in self.arrays.items():
            if name in FLOW_VERTICES:
                flow[name] = numbers.now(array)
            elif is_by_vertex(name, array):
                flow[name] = np.zeros((self.n, *array.shape[1:]), array.dtype)
                flow[name][self.rows] = array
            else:
                flow[name] = array
        return flow


def is_by_vertex(name: str, array: AnyArray) -> bool:
    """Whether an array of a flow has floats for each vertex of its patch."""
    return array.dtype.kind == "f"


def pack_flow(flow: Mapping[str, AnyArray], numbers: VertexNumbers) -> PackedFlow:
    """Leave out what is nothing."""
    n = len(flow["vertices"])
    own = [name for name, array in flow.items() if is_by_vertex(name, array)]
    holds = np.zeros(n, bool)
    for name in own:
        holds |= flow[name].any(axis=tuple(range(1, flow[name].ndim)))
    rows = np.flatnonzero(holds).astype(np.int32)
    packed = {}
    for name, array in flow.items():
        if name in FLOW_VERTICES:
            packed[name] = numbers.saved(array)
        else:
            packed[name] = array[rows] if name in own else array
    return PackedFlow(n, rows, packed)


@dataclass(frozen=True, eq=False)
class PackedDelta:
    """What `SurfaceDelta` holds (N vertices, the first I of them with ink, P pigments).

    Attributes
    ----------
    vertex_ids : (N,) int32
        Numbers in a file.
    amounts : (I, P) float32
    coverage : (I,) float32
    dry : DryRows
        With numbers in a file.
    brush : BrushLoad
    flow : PackedFlow or None
    """

    vertex_ids: NDArray[np.int32]
    amounts: NDArray[np.float32]
    coverage: NDArray[np.float32]
    dry: DryRows
    brush: BrushLoad
    flow: PackedFlow | None

    @property
    def n_bytes(self) -> int:
        """Memory that it takes, without the brush."""
        arrays = [self.vertex_ids, self.amounts, self.coverage, *self.dry[1:6], *self.dry.over]
        own = sum(array.nbytes for array in arrays)
        return own + (0 if self.flow is None else self.flow.n_bytes)

    def unpacked(self, numbers: VertexNumbers, flow: Mapping[str, AnyArray] | None) -> SurfaceDelta:
        """The delta, with its flow as it was unpacked elsewhere."""
        missing = len(self.vertex_ids) - len(self.coverage)
        return SurfaceDelta(
            numbers.now(self.vertex_ids),
            np.pad(self.amounts, ((0, missing), (0, 0))),
            np.pad(self.coverage, (0, missing)),
            self.dry._replace(vertex_ids=numbers.now(self.dry.vertex_ids)),
            self.brush,
            flow,
        )


def pack_delta(delta: SurfaceDelta, numbers: VertexNumbers, flow: PackedFlow | None) -> PackedDelta:
    """Keep only rows that hold something; `flow` is the delta's own, packed."""
    holds = (delta.coverage != 0.0) | delta.amounts.any(axis=1)
    inked, bare = np.flatnonzero(holds), np.flatnonzero(~holds)
    return PackedDelta(
        numbers.saved(delta.vertex_ids[np.concatenate([inked, bare])]),
        delta.amounts[inked],
        delta.coverage[inked],
        delta.dry._replace(vertex_ids=numbers.saved(delta.dry.vertex_ids)),
        delta.brush,
        flow,
    )
