"""Undo and redo without limit: a step holds only what it changed, the oldest lie on the disk.

A step reaches from its beginning to that of the next one, so what ran, dried or was dipped in
between goes with it. Past a budget of memory the steps that are farthest from now are written to a
temporary file without a name, and read again when undo comes to them.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import BinaryIO, Protocol

import numpy as np

from paint3d.core.types import AnyArray
from paint3d.surface.delta import BrushLoad, DeltaRecorder, SurfaceDelta
from paint3d.surface.layer_stack import StackState
from paint3d.surface.packed_delta import (
    PackedDelta,
    PackedFlow,
    VertexNumbers,
    pack_delta,
    pack_flow,
)
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.vertex_sets import union

__all__ = ["Painting", "Part", "Step", "UndoHistory"]

MEMORY_BUDGET = 512 << 20  # bytes
_LAYER = "1"


class Part(Protocol):
    """Something that a step changed besides ink; exchanged like a `SurfaceDelta`."""

    def exchange(self, surface: PaintedSurface) -> tuple[Part, AnyArray]:
        """Bring the surface there; return the way back, and vertices to colour anew (N,)."""
        ...


class UndoHistory:
    """The steps that led to a surface as it is, and those that were undone.

    Parameters
    ----------
    surface : PaintedSurface
    memory_budget : int
        Bytes of steps that are kept in memory.
    keep, restore : callable, optional
        What the painter remembers besides the surface: `keep` returns it, `restore` takes it.

    Attributes
    ----------
    memory_budget : int
    done, undone : list
        Labels of the steps: oldest first, and the one that `redo` takes next last.
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
        self._since = Step(None, 0)  # what came after an undo: the next undo or redo forgets it
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
        """Labels of the steps that can be done again, the next one last."""
        return [step.label for step in self._undone]

    @property
    def newest(self) -> int:
        """Number of the step that was begun last, ever; they count from 1."""
        return self._newest

    @property
    def next_undo(self) -> int:
        """Number of the step that `undo` would take back; 0 for none."""
        return self._done[-1].number if self._done else 0

    @property
    def next_redo(self) -> int:
        """Number of the step that `redo` would do again; 0 for none."""
        return self._undone[-1].number if self._undone else 0

    @property
    def n_bytes(self) -> int:
        """Memory that the steps take, without those on the disk."""
        parts = [part for step in self._steps() for part in step.parts]
        return sum(part.n_bytes for part in parts if isinstance(part, Painting))

    @property
    def n_spilled(self) -> int:
        """Parts of steps that lie on the disk."""
        parts = [part for step in self._steps() for part in step.parts]
        return sum(isinstance(p, Painting) and isinstance(p.delta, _Place) for p in parts)

    def begin(self, label: object) -> None:
        """Start a step; what was undone before cannot be done again."""
        self.seal()
        if self._done:
            self._done[-1].parts += self._since.parts
        self._since.parts = []
        self._undone.clear()
        self._newest += 1
        self._done.append(Step(label, self._newest))
        self._spill()

    def change(self, state: Callable[[], Part], action: Callable[[], None]) -> None:
        """Do something that ink has no part in; the step that goes on takes it back as well.

        Parameters
        ----------
        state : callable
            Returns how it is now, as something that can be exchanged.
        action : callable
        """
        self.seal()
        before = state()
        action()
        self._add(before)
        self._begin_here()

    def before(self, vertex_ids: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Amounts (N, P) and coverage (N,) of vertices (N,) when a step or `seal` was last."""
        return self._recorder.before(vertex_ids)

    def seal(self) -> None:
        """Put what changed so far into the step that goes on, if anything did."""
        part = self._take()
        if not self._is_nothing(part):
            self._add(part)

    def _is_nothing(self, part: Painting) -> bool:
        """Whether a part that was just taken leads nowhere."""
        delta, dry = self._read(part), self._surface.dry_layers
        if len(delta.vertex_ids) or len(delta.dry.rows) or delta.dry.count != dry.count:
            return False
        if delta.flow is not self._recorder.water:
            return False
        brush = vars(BrushLoad.of(self._surface))
        return _equal(vars(delta.brush), brush) and _equal(part.kept, self._kept)

    def _add(self, part: Part | Painting) -> None:
        """Put a part into the step that goes on, if there is one."""
        if self._undone:
            self._since.parts.append(part)
        elif self._done:
            self._done[-1].parts.append(part)

    def _take(self) -> Painting:
        delta, kept = self._recorder.take(), self._kept
        self._kept = self._keep()
        return Painting(delta, kept, delta.n_bytes)

    def undo(self) -> AnyArray:
        """Take back the last step; return the vertices (N,) int32 whose colours may change.

        Nothing happens where there is none.
        """
        if not self._done:
            return np.empty(0, np.int32)
        first = self._take_back_since()
        step = self._done.pop()
        second = self._exchange(step)
        self._undone.append(step)
        self._spill()
        return self._union([first, second])

    def redo(self) -> AnyArray:
        """Do again what was undone last; return vertices (N,) int32. What came since goes."""
        if not self._undone:
            return np.empty(0, np.int32)
        first = self._take_back_since()
        step = self._undone.pop()
        second = self._exchange(step)
        self._done.append(step)
        self._spill()
        return self._union([first, second])

    def _take_back_since(self) -> AnyArray:
        """Bring the surface to the end of the last step that is done, where one was undone."""
        return self.lay_aside_since()[1]

    def _union(self, sets: list[AnyArray]) -> AnyArray:
        return union(sets, self._surface.paint_mesh.capacity)

    def revert(self) -> AnyArray:
        """Take back the step that goes on and forget it, as when a stroke is cancelled."""
        touched = self.undo()
        if self._undone:
            self._undone.pop()
        return touched

    def prepend(self, prepare: Callable[[], None], paint: Callable[[], None]) -> None:
        """Have steps before all others: those that `paint` begins on a layer of its own.

        That the layers, the brush and the water as they are now come instead belongs to the last
        of its steps. Where something is raised, everything is as it was.

        Parameters
        ----------
        prepare : callable
            Makes the bare surface and the brush ready: where undo ends.
        paint : callable
            Begins one step at least.
        """
        if self._done:
            raise ValueError("steps are done; expected them to be undone first")
        self._take_back_since()
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
            self.seal()
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
        """Take back what came since an undo; `resume_since` brings it back.

        Returns it, and vertices (N,) int32 whose colours may change.
        """
        self.seal()
        step, self._since = self._since, Step(None, 0)
        return step, self._exchange(step)

    def resume_since(self, step: Step) -> AnyArray:
        """Bring back what came since an undo; returns vertices (N,) int32."""
        touched, self._since = self._exchange(step), step
        return touched

    def exchange_undone(self, steps: Sequence[Step]) -> list[Step]:
        """Have other steps to do again, which lead on from where the surface is, the next one last.

        Nothing came since the undo. Returns the steps that there were.
        """
        aside, self._undone = self._undone, list(steps)
        self._spill(aside)
        return aside

    def _begin_here(self) -> None:
        """Take everything as it is now, whatever it was."""
        self._recorder.restart()
        self._kept = self._keep()

    def _exchange(self, step: Step) -> AnyArray:
        """Bring the surface to the other end of a step, and turn the step round."""
        if not step.parts:
            return np.empty(0, np.int32)
        back: list[Part | Painting] = []
        touched: list[AnyArray] = [np.empty(0, np.int32)]
        water = self._recorder.water
        for part in reversed(step.parts):
            if isinstance(part, Painting):
                painting, ids, water = self._exchange_painting(part, water)
                back.append(painting)
            else:
                other, ids = part.exchange(self._surface)
                water = self._surface.keep_flow()
                back.append(other)
            touched.append(ids)
        step.parts = back
        everything = self._union(touched)
        if all(isinstance(part, Painting) for part in back):
            self._recorder.accept(everything, water)
        else:  # another layer may lie open
            self._recorder.restart()
        self._kept = self._keep()
        return everything

    def _exchange_painting(
        self, part: Painting, water: Mapping[str, AnyArray] | None
    ) -> tuple[Painting, AnyArray, Mapping[str, AnyArray] | None]:
        delta = self._read(part)
        if isinstance(delta, PackedDelta):
            delta = delta.unpacked(self._vertex_numbers(), self._unpacked_flow(delta.flow))
        kept = self._keep()
        back, ids = delta.exchange(self._surface, water)
        self._restore(part.kept)
        return Painting(back, kept, back.n_bytes), ids, delta.flow

    def _steps(self) -> list[Step]:
        return [*self._done, self._since, *self._undone]

    def _read(self, part: Painting) -> SurfaceDelta | PackedDelta:
        """What a part holds, wherever it lies."""
        return self._file.read(part.delta) if isinstance(part.delta, _Place) else part.delta

    def _vertex_numbers(self) -> VertexNumbers:
        if self._numbers is None:
            self._numbers = VertexNumbers(self._surface.paint_mesh)
        return self._numbers

    def _unpacked_flow(self, flow: PackedFlow | None) -> Mapping[str, AnyArray] | None:
        """Water as it was; the same where it is asked for twice, so that none has to be moved."""
        if flow is not self._water[0]:
            self._water = flow, flow.unpacked(self._vertex_numbers()) if flow else None
        return self._water[1]

    # -- for a file -------------------------------------------------------------------------

    def steps(self) -> tuple[Sequence[Step], Step, Sequence[Step]]:
        """The steps done, what came since one was undone, and those undone; sealed."""
        self.seal()
        return tuple(self._done), self._since, tuple(self._undone)

    def packed(self, step: Step, place: int, flows: dict[int, PackedFlow]) -> PackedDelta:
        """A `Painting` of a step as a file holds it; so it is kept from now on.

        Parameters
        ----------
        step : Step
        place : int
            Of the part in it.
        flows : dict
            Of what was packed before, by identity; filled.
        """
        part = step.parts[place]
        assert isinstance(part, Painting), "another part holds no delta"
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
        if not isinstance(part.delta, _Place):
            step.parts[place] = Painting(packed, part.kept, packed.n_bytes)
        return packed

    def resume(self, done: Sequence[Step], since: Step, undone: Sequence[Step]) -> None:
        """Have the steps of another history, of the same surface as it is now."""
        self._done, self._since, self._undone = list(done), since, list(undone)
        for number, step in enumerate([*done, *reversed(undone)], self._newest + 1):
            step.number = number
        self._newest += len(done) + len(undone)
        self._spill()

    def _spill(self, aside: Sequence[Step] = ()) -> None:
        """Write to the disk what memory has no room for: what is farthest from now first."""
        n_bytes = self.n_bytes + sum(
            part.n_bytes for step in aside for part in step.parts if isinstance(part, Painting)
        )
        for step in [*aside, *self._done[:-1], *self._undone[:-1]]:
            for k, part in enumerate(step.parts):
                if n_bytes <= self.memory_budget:
                    return
                if (
                    isinstance(part, Painting)
                    and not isinstance(part.delta, _Place)
                    and part.n_bytes
                ):
                    n_bytes -= part.n_bytes
                    step.parts[k] = Painting(self._file.write(part.delta), part.kept, 0)


def _equal(one: object, two: object) -> bool:
    """Whether two things that were kept say the same."""
    if one is two:
        return True
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_equal(one[key], two[key]) for key in one)
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return np.array_equal(one, two)
    return type(one) is type(two) and isinstance(one, int | float | str) and one == two


@dataclass(frozen=True)
class _Place:
    """Where on the disk a delta lies."""

    start: int
    length: int


@dataclass(frozen=True, eq=False)
class Painting:
    """A delta, what the painter remembered, and how much memory that takes."""

    delta: SurfaceDelta | PackedDelta | _Place
    kept: object
    n_bytes: int


@dataclass(eq=False)
class Step:
    """What leads back over a step, or over it again, oldest part first."""

    label: object
    number: int
    parts: list[Part | Painting] = field(default_factory=list)


class _StepFile:
    """Deltas in a file that has no name and is gone with the program."""

    def __init__(self) -> None:
        self._file: BinaryIO | None = None
        self._end = 0

    def write(self, delta: SurfaceDelta | PackedDelta) -> _Place:
        if self._file is None:
            self._file = tempfile.TemporaryFile(prefix="paint3d-undo-")  # noqa: SIM115
        data = pickle.dumps(delta, protocol=5)
        self._file.seek(self._end)
        self._file.write(data)
        place = _Place(self._end, len(data))
        self._end += len(data)
        return place

    def __del__(self) -> None:
        if self._file is not None:
            self._file.close()

    def read(self, place: _Place) -> SurfaceDelta | PackedDelta:
        assert self._file is not None, "nothing was written"
        self._file.seek(place.start)
        result: SurfaceDelta | PackedDelta = pickle.loads(
            self._file.read(place.length)
        )  # our own bytes, in a file of our own
        return result
