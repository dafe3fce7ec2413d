"""Unlimited undo and redo: a step stores only what it changed, and old steps spill to disk.

A step extends from its beginning to that of the next one, so it includes what ran, dried or was
dipped in between. Beyond a memory budget the steps farthest from the present are written to an
unnamed temporary file, and read back when undo reaches them.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.refined_mesh import PaintMesh, saved_ids
from paint3d.surface.dry_layers import DryRows
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import StackState
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import BRUSH_TRANSFER, FLOW_VERTICES

__all__ = [
    "BrushLoad",
    "DeltaRecorder",
    "PackedDelta",
    "PackedFlow",
    "PaintedPart",
    "Part",
    "Step",
    "SurfaceDelta",
    "UndoHistory",
    "VertexNumbers",
    "pack_delta",
    "pack_flow",
]

# ---- Deltas --------------------------------------------------------------------------------------
# The bit-exact difference of a surface between two moments.
#
# Painting writes into the surface's arrays inside kernels, which do not record undo. So
# `DeltaRecorder` keeps a second copy of the wet ink, filled only where there was paint, and
# compares the vertices that are known to have been touched. Exchanging a delta with the surface
# gives the inverse delta: undo and redo are the same operation.


@dataclass(frozen=True, eq=False)
class BrushLoad:
    """The ink in the brush, and the ink that went off the surface; see `InkField`."""

    load: AnyArray
    off_surface: AnyArray
    reservoirs: AnyArray
    transfer: AnyArray

    @classmethod
    def of(cls, surface: PaintedSurface) -> BrushLoad:
        """Return a copy of what the surface's brush holds."""
        ink = surface.ink
        return cls(*(getattr(ink, name).copy() for name in cls.__annotations__))

    def put(self, surface: PaintedSurface) -> None:
        """Set the surface's brush to this; pigments added since get none."""
        ink, count = surface.ink, len(surface.pigments)
        for name in ("load", "off_surface"):
            getattr(ink, name)[:] = np.pad(getattr(self, name), (0, count - len(self.load)))
        ink.transfer[BRUSH_TRANSFER] = self.transfer[BRUSH_TRANSFER]
        missing = count - self.reservoirs.shape[1]
        surface.ink = ink._replace(reservoirs=np.pad(self.reservoirs, ((0, 0), (0, missing))))


@dataclass(frozen=True, eq=False)
class SurfaceDelta:
    """The state of some vertices, the brush and the water at another moment.

    Attributes
    ----------
    vertex_ids : (N,) int32
    amounts : (N, P) float32
    coverage : (N,) float32
    dry : DryRows
    brush : BrushLoad
    flow : mapping or None
        From `PaintedSurface.keep_flow`.
    """

    vertex_ids: NDArray[np.int32]
    amounts: NDArray[np.float32]
    coverage: NDArray[np.float32]
    dry: DryRows
    brush: BrushLoad
    flow: Mapping[str, AnyArray] | None

    @property
    def n_bytes(self) -> int:
        """Memory that it takes, without the brush."""
        arrays = [self.vertex_ids, self.amounts, self.coverage, *self.dry[1:6], *self.dry.over]
        return sum(array.nbytes for array in [*arrays, *(self.flow or {}).values()])

    def exchange(
        self, surface: PaintedSurface, water: Mapping[str, AnyArray] | None
    ) -> tuple[SurfaceDelta, AnyArray]:
        """Apply the delta to the surface.

        Parameters
        ----------
        surface : PaintedSurface
        water : mapping or None
            The present result of `PaintedSurface.keep_flow`.

        Returns
        -------
        SurfaceDelta
            The inverse delta.
        vertex_ids : (M,) int32
            Vertices whose colours may have changed.
        """
        ink, ids, dry = surface.ink, self.vertex_ids, surface.dry_layers
        amounts, coverage, brush = ink.amounts[ids], ink.coverage[ids], BrushLoad.of(surface)
        missing = len(surface.pigments) - self.amounts.shape[1]
        ink.amounts[ids] = np.pad(self.amounts, ((0, 0), (0, missing)))
        ink.coverage[ids] = self.coverage
        gone = dry.vertex_ids[self.dry.count :].copy()
        rows = dry.exchange(self.dry, surface.paint_mesh.capacity)
        self.brush.put(surface)
        dried = (gone, rows.vertex_ids, self.dry.vertex_ids)
        touched = union([ids, *dried], surface.paint_mesh.capacity)
        surface.touch(touched)
        if self.flow is not water:  # identity: restoring the same water again would cost much
            surface.drop_flow()
            if self.flow is not None:
                surface.restore_flow(self.flow)
        return SurfaceDelta(ids, amounts, coverage, rows, brush, water), touched


def _is_same_flow(one: Mapping[str, AnyArray] | None, two: Mapping[str, AnyArray] | None) -> bool:
    """Return whether two results of `keep_flow` are equal."""
    if one is None or two is None:
        return one is two
    return all(np.array_equal(one[name], two[name]) for name in one)


class DeltaRecorder:
    """Snapshot of a surface at a moment, from which the changes since are computed.

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        self._amounts = np.zeros((0, 0), np.float32)
        self._coverage = np.zeros(0, np.float32)
        surface.take_changed()
        self.restart()

    def restart(self) -> None:
        """Take a new snapshot, whatever changed before."""
        ink = self._surface.ink
        self._clear()
        painted = np.flatnonzero((ink.coverage > 0.0) | ink.amounts.any(axis=1))
        self._surface.take_changed()
        self._follow(painted, self._surface.keep_flow())

    @property
    def water(self) -> Mapping[str, AnyArray] | None:
        """The result of `PaintedSurface.keep_flow` at the snapshot."""
        return self._flow

    def accept(self, vertex_ids: AnyArray, water: Mapping[str, AnyArray] | None) -> None:
        """Update the snapshot where an exchange set these vertices (N,), and this water."""
        self._surface.take_changed()
        self._fit()
        self._follow(vertex_ids, water)

    def before(self, vertex_ids: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return amounts (N, P) and coverage (N,) of vertices (N,) at the snapshot."""
        self._fit()
        return self._amounts[vertex_ids], self._coverage[vertex_ids]

    def take(self) -> SurfaceDelta:
        """Return the delta back to the snapshot, and take a new one."""
        surface = self._surface
        ids = surface.take_changed()
        self._fit()
        amounts, coverage = self._amounts[ids], self._coverage[ids]
        ink = surface.ink
        differs = (amounts != ink.amounts[ids]).any(axis=1) | (coverage != ink.coverage[ids])
        at = np.flatnonzero(differs)
        delta = SurfaceDelta(
            ids[at],
            amounts[at],
            coverage[at],
            surface.dry_layers.since_mark(),
            self._brush,
            self._flow,
        )
        water = surface.keep_flow()
        self._follow(ids[at], self._flow if _is_same_flow(self._flow, water) else water)
        return delta

    def _follow(self, ids: AnyArray, water: Mapping[str, AnyArray] | None) -> None:
        """Update the snapshot: the wet ink at vertices (N,), all else as it is now."""
        surface = self._surface
        self._amounts[ids] = surface.ink.amounts[ids]
        self._coverage[ids] = surface.ink.coverage[ids]
        surface.dry_layers.mark()
        self._brush = BrushLoad.of(surface)
        self._flow = water

    def _clear(self) -> None:
        """Reset the copy to no paint; zeroed pages take no memory until they are written to."""
        ink = self._surface.ink
        self._amounts = np.zeros(ink.amounts.shape, np.float32)
        self._coverage = np.zeros(ink.coverage.shape, np.float32)

    def _fit(self) -> None:
        """Resize to a surface that has gained vertices or pigments."""
        ink = self._surface.ink
        amounts, coverage = self._amounts, self._coverage
        if amounts.shape == ink.amounts.shape:
            return
        inked = np.flatnonzero((coverage > 0.0) | amounts.any(axis=1))
        self._clear()
        self._amounts[inked, : amounts.shape[1]] = amounts[inked]
        self._coverage[inked] = coverage[inked]


# ---- Packed deltas -------------------------------------------------------------------------------
# A compact `SurfaceDelta`, with vertices by their numbers in a file.
#
# Most of what a stroke covers was bare before, and most of a patch of water is dry: only rows that
# are not zero are kept.


class NumbersNow(Protocol):
    """Interface of a mapping from vertex numbers in a file to those in the mesh."""

    def now(self, saved: AnyArray) -> AnyArray:
        """Return numbers (N,) int32 in the mesh."""
        ...


class VertexNumbers:
    """Mapping between vertex numbers in the mesh and in a file; later vertices are included.

    Parameters
    ----------
    mesh : PaintMesh
    """

    def __init__(self, mesh: PaintMesh) -> None:
        n = mesh.n_base_vertices  # vertices added by refinement have the same number in both
        self._saved = saved_ids(mesh)[:n]
        self._now = np.empty(n, np.int32)
        self._now[self._saved] = np.arange(n, dtype=np.int32)

    def saved(self, vertex_ids: AnyArray) -> NDArray[np.int32]:
        """Return numbers (N,) int32 in a file."""
        return _mapped(vertex_ids, self._saved)

    def now(self, saved: AnyArray) -> NDArray[np.int32]:
        """Return numbers (N,) int32 in the mesh."""
        return _mapped(saved, self._now)


def _mapped(ids: AnyArray, table: AnyArray) -> AnyArray:
    """Map ids (N,) through the table; ids beyond its end are unchanged."""
    mapped = np.array(ids, np.int32)
    base = mapped < len(table)
    mapped[base] = table[mapped[base]]
    return mapped


@dataclass(frozen=True, eq=False)
class PackedFlow:
    """The result of `PaintedSurface.keep_flow` without rows that are zero.

    Attributes
    ----------
    n : int
        Number of vertices of the patch, C.
    rows : (H,) int32
        Rows that are not zero.
    arrays : mapping
        Per-vertex arrays of floats with these rows only; vertices are by their numbers in a file.
    """

    n: int
    rows: NDArray[np.int32]
    arrays: Mapping[str, AnyArray]

    @property
    def n_bytes(self) -> int:
        """Memory that it takes."""
        return self.rows.nbytes + sum(array.nbytes for array in self.arrays.values())

    def unpacked(self, numbers: NumbersNow) -> dict[str, AnyArray]:
        """Return the flow for `PaintedSurface.restore_flow`."""
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
    """Return whether an array of a flow holds floats for each vertex of its patch."""
    return array.dtype.kind == "f"


def pack_flow(flow: Mapping[str, AnyArray], numbers: VertexNumbers) -> PackedFlow:
    """Pack a flow by leaving out rows that are zero."""
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
    """A packed `SurfaceDelta` (N vertices, the first I of them with ink, P pigments).

    Attributes
    ----------
    vertex_ids : (N,) int32
        Vertex numbers in a file.
    amounts : (I, P) float32
    coverage : (I,) float32
    dry : DryRows
        With vertex numbers in a file.
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
        """Return the delta, with its flow already unpacked by the caller."""
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
    """Pack a delta by leaving out amounts of bare vertices; `flow` is the delta's own, packed."""
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


# ---- History -------------------------------------------------------------------------------------


MEMORY_BUDGET = 512 << 20  # bytes
_LAYER = "1"


class Part(Protocol):
    """Interface of a change other than of ink in a step; exchanged like a `SurfaceDelta`."""

    def exchange(self, surface: PaintedSurface) -> tuple[Part, AnyArray]:
        """Apply this to the surface; return the inverse, and the vertices (N,) to recolour."""
        ...


class UndoHistory:
    """The done and the undone steps of a surface.

    Parameters
    ----------
    surface : PaintedSurface
    memory_budget : int
        Bytes of steps to keep in memory.
    keep, restore : callable, optional
        Save and restore the painter's state besides the surface, as one object.

    Attributes
    ----------
    memory_budget : int
    done, undone : list
        Labels of the steps, the one that `undo` or `redo` takes next last.
    """

    def __init__(
        self,
        surface: PaintedSurface,
        memory_budget: int = MEMORY_BUDGET,
        keep: Callable[[], object] | None = None,
        restore: Callable[[object], None] | None = None,
    ) -> None:
        self._surface = surface
        self.memory_budget = memory_budget
        self._keep = keep or (lambda: None)
        self._restore = restore or (lambda kept: None)
        self._recorder = DeltaRecorder(surface)
        self._done: list[Step] = []
        self._undone: list[Step] = []
        self._since = Step(None, 0)  # changes after an undo: the next undo or redo drops them
        self._newest = 0
        self._numbers: VertexNumbers | None = None
        self._water: tuple[PackedFlow | None, Mapping[str, AnyArray] | None] = (None, None)
        self._file = _StepFile()
        self._kept = self._keep()

    @property
    def done(self) -> list[object]:
        """Labels of the steps that can be undone, oldest first."""
        return [step.label for step in self._done]

    @property
    def undone(self) -> list[object]:
        """Labels of the steps that can be redone, the next one last."""
        return [step.label for step in self._undone]

    @property
    def newest(self) -> int:
        """Number of the most recently begun step, counted from 1 and never reused."""
        return self._newest

    @property
    def next_undo(self) -> int:
        """Number of the step that `undo` would undo; 0 for none."""
        return self._done[-1].number if self._done else 0

    @property
    def next_redo(self) -> int:
        """Number of the step that `redo` would redo; 0 for none."""
        return self._undone[-1].number if self._undone else 0

    @property
    def n_bytes(self) -> int:
        """Memory that the steps take, in bytes, without those on disk."""
        parts = [part for step in self._steps() for part in step.parts]
        return sum(part.n_bytes for part in parts if isinstance(part, PaintedPart))

    @property
    def n_spilled(self) -> int:
        """Number of parts of steps that are on disk."""
        parts = [part for step in self._steps() for part in step.parts]
        return sum(isinstance(p, PaintedPart) and isinstance(p.delta, _DiskRange) for p in parts)

    def begin(self, label: object) -> None:
        """Start a step; steps undone before can no longer be redone."""
        self.end_part()
        if self._done:
            self._done[-1].parts += self._since.parts
        self._since.parts = []
        self._undone.clear()
        self._newest += 1
        self._done.append(Step(label, self._newest))
        self._spill()

    def change(self, state: Callable[[], Part], action: Callable[[], None]) -> None:
        """Run an action that changes something other than ink, as part of the current step.

        Parameters
        ----------
        state : callable
            Returns the present state of it as an exchangeable part.
        action : callable
        """
        self.end_part()
        before = state()
        action()
        self._add(before)
        self._begin_here()

    def before(self, vertex_ids: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return amounts (N, P) and coverage (N,) of vertices (N,) at the last step or part."""
        return self._recorder.before(vertex_ids)

    def end_part(self) -> None:
        """Add what changed so far to the current step, if anything did."""
        delta, kept = self._recorder.take(), self._kept
        self._kept = self._keep()
        part = PaintedPart(delta, kept, delta.n_bytes)
        if not self._is_no_change(part):
            self._add(part)

    def _is_no_change(self, part: PaintedPart) -> bool:
        """Return whether a part that was just taken changes nothing."""
        delta, dry = self._read(part), self._surface.dry_layers
        if len(delta.vertex_ids) or len(delta.dry.rows) or delta.dry.count != dry.count:
            return False
        if delta.flow is not self._recorder.water:
            return False
        brush = vars(BrushLoad.of(self._surface))
        return _equal(vars(delta.brush), brush) and _equal(part.kept, self._kept)

    def _add(self, part: Part | PaintedPart) -> None:
        """Add a part to the current step, if there is one."""
        if self._undone:
            self._since.parts.append(part)
        elif self._done:
            self._done[-1].parts.append(part)

    def undo(self) -> AnyArray:
        """Undo the last step; return the vertices (N,) int32 whose colours may change.

        Does nothing if there is none.
        """
        if not self._done:
            return np.empty(0, np.int32)
        _, first = self.lay_aside_since()
        step = self._done.pop()
        second = self._exchange(step)
        self._undone.append(step)
        self._spill()
        return self._union([first, second])

    def redo(self) -> AnyArray:
        """Redo the last undone step; return vertices (N,) int32. Changes since the undo are lost.

        Does nothing if there is none.
        """
        if not self._undone:
            return np.empty(0, np.int32)
        _, first = self.lay_aside_since()
        step = self._undone.pop()
        second = self._exchange(step)
        self._done.append(step)
        self._spill()
        return self._union([first, second])

    def _union(self, sets: list[AnyArray]) -> AnyArray:
        return union(sets, self._surface.paint_mesh.capacity)

    def revert(self) -> AnyArray:
        """Undo the current step and drop it, as when a stroke is cancelled."""
        touched = self.undo()
        if self._undone:
            self._undone.pop()
        return touched

    def prepend(self, prepare: Callable[[], None], paint: Callable[[], None]) -> None:
        """Insert steps before all others: those that `paint` begins, on a layer of its own.

        Its last step includes the change to the present layers, brush and water. On an exception
        everything is restored.

        Parameters
        ----------
        prepare : callable
            Prepares the bare surface and the brush, at which undo ends.
        paint : callable
            Begins at least one step.
        """
        if self._done:
            raise ValueError("steps are done; expected them to be undone first")
        self.lay_aside_since()
        surface, stack = self._surface, self._surface.use_layers()
        undone, self._undone = self._undone, []
        now, brush, kept = stack.state(), BrushLoad.of(surface), self._keep()
        try:
            stack.add(_LAYER, 0)
            own = stack.state().active
            stack.put(StackState((own,), own))
            prepare()
            self._begin_here()
            paint()
            self.change(stack.state, lambda: stack.put(now))
            brush.put(surface)
            self._restore(kept)
            self.end_part()
        except BaseException:
            self._done = []
            stack.put(now)
            brush.put(surface)
            self._restore(kept)
            self._begin_here()
            raise
        finally:
            self._undone = undone
        self._spill()

    def lay_aside_since(self) -> tuple[Step, AnyArray]:
        """Undo the changes since an undo; `resume_since` brings them back.

        Returns them as a step, and the vertices (N,) int32 whose colours may change.
        """
        self.end_part()
        step, self._since = self._since, Step(None, 0)
        return step, self._exchange(step)

    def resume_since(self, step: Step) -> AnyArray:
        """Redo changes that were laid aside; return the vertices (N,) int32 to recolour."""
        touched, self._since = self._exchange(step), step
        return touched

    def exchange_undone(self, steps: Sequence[Step]) -> list[Step]:
        """Replace the undone steps by others from the present surface on, the next one last.

        There must be no changes since the undo. Returns the steps that were replaced.
        """
        aside, self._undone = self._undone, list(steps)
        self._spill(aside)
        return aside

    def _begin_here(self) -> None:
        """Take the present as the end of the last step, whatever changed before."""
        self._recorder.restart()
        self._kept = self._keep()

    def _exchange(self, step: Step) -> AnyArray:
        """Bring the surface to the other end of a step, and invert the step."""
        if not step.parts:
            return np.empty(0, np.int32)
        back: list[Part | PaintedPart] = []
        touched: list[AnyArray] = [np.empty(0, np.int32)]
        water = self._recorder.water
        for part in reversed(step.parts):
            if isinstance(part, PaintedPart):
                painting, ids, water = self._exchange_painting(part, water)
                back.append(painting)
            else:
                inverse, ids = part.exchange(self._surface)
                water = self._surface.keep_flow()
                back.append(inverse)
            touched.append(ids)
        step.parts = back
        ids = self._union(touched)
        if all(isinstance(part, PaintedPart) for part in back):
            self._recorder.accept(ids, water)
        else:  # another layer may be active
            self._recorder.restart()
        self._kept = self._keep()
        return ids

    def _exchange_painting(
        self, part: PaintedPart, water: Mapping[str, AnyArray] | None
    ) -> tuple[PaintedPart, AnyArray, Mapping[str, AnyArray] | None]:
        """Exchange one painting; return its inverse, the touched vertices, and the new water."""
        delta = self._read(part)
        if isinstance(delta, PackedDelta):
            delta = delta.unpacked(self._vertex_numbers(), self._unpacked_flow(delta.flow))
        kept = self._keep()
        back, ids = delta.exchange(self._surface, water)
        self._restore(part.kept)
        return PaintedPart(back, kept, back.n_bytes), ids, delta.flow

    def _steps(self) -> list[Step]:
        return [*self._done, self._since, *self._undone]

    def _read(self, part: PaintedPart) -> SurfaceDelta | PackedDelta:
        """Return the delta of a part, from memory or from disk."""
        return self._file.read(part.delta) if isinstance(part.delta, _DiskRange) else part.delta

    def _vertex_numbers(self) -> VertexNumbers:
        if self._numbers is None:
            self._numbers = VertexNumbers(self._surface.paint_mesh)
        return self._numbers

    def _unpacked_flow(self, flow: PackedFlow | None) -> Mapping[str, AnyArray] | None:
        """Unpack a flow; the last one is cached, since identical water need not be restored."""
        if flow is not self._water[0]:
            self._water = flow, flow.unpacked(self._vertex_numbers()) if flow else None
        return self._water[1]

    # -- for a file -------------------------------------------------------------------------

    def steps(self) -> tuple[Sequence[Step], Step, Sequence[Step]]:
        """Return the done steps, the changes since an undo, and the undone steps, all sealed."""
        self.end_part()
        return tuple(self._done), self._since, tuple(self._undone)

    def packed(self, step: Step, place: int, flows: dict[int, PackedFlow]) -> PackedDelta:
        """Return a `PaintedPart` of a step in packed form, and keep it so in memory.

        Parameters
        ----------
        step : Step
        place : int
            Index of the part in it.
        flows : dict
            Flows packed so far, by the identity of the unpacked one; added to.
        """
        part = step.parts[place]
        assert isinstance(part, PaintedPart), "only a painting holds a delta"
        delta = self._read(part)
        if isinstance(delta, PackedDelta):
            return delta
        flow, packed_flow = delta.flow, None
        if flow is not None:
            if id(flow) not in flows:
                flows[id(flow)] = pack_flow(flow, self._vertex_numbers())
            packed_flow = flows[id(flow)]
            if flow is self._recorder.water:
                self._water = packed_flow, flow
        packed = pack_delta(delta, self._vertex_numbers(), packed_flow)
        if not isinstance(part.delta, _DiskRange):
            step.parts[place] = PaintedPart(packed, part.kept, packed.n_bytes)
        return packed

    def resume(self, done: Sequence[Step], since: Step, undone: Sequence[Step]) -> None:
        """Adopt the steps of another history of the same surface in its present state."""
        self._done, self._since, self._undone = list(done), since, list(undone)
        for number, step in enumerate([*done, *reversed(undone)], self._newest + 1):
            step.number = number
        self._newest += len(done) + len(undone)
        self._spill()

    def _spill(self, aside: Sequence[Step] = ()) -> None:
        """Write parts beyond the memory budget to disk, farthest from the present first."""
        n_bytes = self.n_bytes + sum(
            part.n_bytes for step in aside for part in step.parts if isinstance(part, PaintedPart)
        )
        for step in [*aside, *self._done[:-1], *self._undone[:-1]]:
            for k, part in enumerate(step.parts):
                if n_bytes <= self.memory_budget:
                    return
                if (
                    isinstance(part, PaintedPart)
                    and not isinstance(part.delta, _DiskRange)
                    and part.n_bytes
                ):
                    n_bytes -= part.n_bytes
                    step.parts[k] = PaintedPart(self._file.write(part.delta), part.kept, 0)


def _equal(one: object, two: object) -> bool:
    """Return whether two saved states are equal."""
    if one is two:
        return True
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_equal(one[key], two[key]) for key in one)
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return np.array_equal(one, two)
    return type(one) is type(two) and isinstance(one, int | float | str) and one == two


@dataclass(frozen=True)
class _DiskRange:
    """Position of a delta in the spill file, in bytes."""

    start: int
    length: int


@dataclass(frozen=True, eq=False)
class PaintedPart:
    """A delta, the painter's state with it, and the memory of the delta in bytes."""

    delta: SurfaceDelta | PackedDelta | _DiskRange
    kept: object
    n_bytes: int


@dataclass(eq=False)
class Step:
    """The parts that undo a step, or redo it, oldest first."""

    label: object
    number: int
    parts: list[Part | PaintedPart] = field(default_factory=list)


class _StepFile:
    """Deltas in an unnamed temporary file, which the system deletes with the process."""

    def __init__(self) -> None:
        self._file: BinaryIO | None = None
        self._end = 0

    def write(self, delta: SurfaceDelta | PackedDelta) -> _DiskRange:
        if self._file is None:
            self._file = tempfile.TemporaryFile(prefix="paint3d-undo-")  # noqa: SIM115
        data = pickle.dumps(delta, protocol=5)
        self._file.seek(self._end)
        self._file.write(data)
        place = _DiskRange(self._end, len(data))
        self._end += len(data)
        return place

    def __del__(self) -> None:
        if self._file is not None:
            self._file.close()

    def read(self, place: _DiskRange) -> SurfaceDelta | PackedDelta:
        assert self._file is not None, "nothing was written"
        self._file.seek(place.start)
        # Unpickling is safe: nobody else can write to the unnamed file.
        result: SurfaceDelta | PackedDelta = pickle.loads(self._file.read(place.length))
        return result
