"""Undo and redo without limit: a step holds only what it changed, the oldest lie on the disk.

A step reaches from its beginning to that of the next one, so what ran, dried or was dipped in
between goes with it. Past a budget of memory the steps that are farthest from now are written to a
temporary file without a name, and read again when undo comes to them.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.surface.delta import DeltaRecorder, SurfaceDelta
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.vertex_sets import union

__all__ = ["Part", "UndoHistory"]

MEMORY_BUDGET = 512 << 20  # bytes


class Part(Protocol):
    """Something that a step changed besides ink; exchanged like a `SurfaceDelta`."""

    def exchange(self, surface: PaintedSurface) -> tuple[Part, NDArray]:
        """Bring the surface there; return the way back, and vertices to colour anew (N,)."""


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
        self._budget = memory_budget
        self._keep = keep or (lambda: None)
        self._restore = restore or (lambda kept: None)
        self._recorder = DeltaRecorder(surface)
        self._done: list[_Step] = []
        self._undone: list[_Step] = []
        self._newest = 0
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
        return sum(part.n_bytes for part in parts if isinstance(part, _Painting))

    @property
    def n_spilled(self) -> int:
        """Parts of steps that lie on the disk."""
        parts = [part for step in self._steps() for part in step.parts]
        return sum(isinstance(p, _Painting) and isinstance(p.delta, _Place) for p in parts)

    def begin(self, label: object) -> None:
        """Start a step; what was undone before cannot be done again."""
        self.seal()
        self._undone.clear()
        self._newest += 1
        self._done.append(_Step(label, self._newest))
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
        if self._done:
            self._done[-1].parts.append(before)
        self._recorder.restart()
        self._kept = self._keep()

    def before(self, vertex_ids: NDArray) -> tuple[NDArray, NDArray]:
        """Amounts (N, P) and coverage (N,) of vertices (N,) when a step or `seal` was last."""
        return self._recorder.before(vertex_ids)

    def seal(self) -> None:
        """Put what changed so far into the step that goes on."""
        part = self._take()
        if self._done:
            self._done[-1].parts.append(part)

    def _take(self) -> _Painting:
        delta, kept = self._recorder.take(), self._kept
        self._kept = self._keep()
        return _Painting(delta, kept, delta.n_bytes)

    def undo(self) -> NDArray:
        """Take back the last step; return the vertices (N,) int32 whose colours may change.

        Nothing happens where there is none.
        """
        if not self._done:
            return np.empty(0, np.int32)
        self.seal()
        step = self._done.pop()
        touched = self._exchange(step)
        self._undone.append(step)
        self._spill()
        return touched

    def redo(self) -> NDArray:
        """Do again what was undone last; return vertices (N,) int32. What came since goes."""
        if not self._undone:
            return np.empty(0, np.int32)
        first = self._exchange(_Step(None, 0, [self._take()]))
        step = self._undone.pop()
        second = self._exchange(step)
        self._done.append(step)
        self._spill()
        return self._union([first, second])

    def _union(self, sets: list[NDArray]) -> NDArray:
        return union(sets, self._surface.paint_mesh.capacity)

    def revert(self) -> NDArray:
        """Take back the step that goes on and forget it, as when a stroke is cancelled."""
        touched = self.undo()
        if self._undone:
            self._undone.pop()
        return touched

    def _exchange(self, step: _Step) -> NDArray:
        """Bring the surface to the other end of a step, and turn the step round."""
        back, touched = [], [np.empty(0, np.int32)]
        water = self._recorder.water
        for part in reversed(step.parts):
            if isinstance(part, _Painting):
                other, ids, water = self._exchange_painting(part, water)
            else:
                other, ids = part.exchange(self._surface)
                water = self._surface.keep_flow()
            back.append(other)
            touched.append(ids)
        step.parts = back
        everything = self._union(touched)
        if all(isinstance(part, _Painting) for part in back):
            self._recorder.accept(everything, water)
        else:  # another layer may lie open
            self._recorder.restart()
        self._kept = self._keep()
        return everything

    def _exchange_painting(
        self, part: _Painting, water: Mapping[str, NDArray] | None
    ) -> tuple[_Painting, NDArray, Mapping[str, NDArray] | None]:
        delta = part.delta
        if isinstance(delta, _Place):
            delta = self._file.read(delta)
        kept = self._keep()
        back, ids = delta.exchange(self._surface, water)
        self._restore(part.kept)
        return _Painting(back, kept, back.n_bytes), ids, delta.flow

    def _steps(self) -> list[_Step]:
        return [*self._done, *self._undone]

    def _spill(self) -> None:
        """Write to the disk what memory has no room for: what is farthest from now first."""
        n_bytes = self.n_bytes
        for step in [*self._done[:-1], *self._undone[:-1]]:
            for k, part in enumerate(step.parts):
                if n_bytes <= self._budget:
                    return
                if isinstance(part, _Painting) and part.n_bytes:
                    n_bytes -= part.n_bytes
                    step.parts[k] = _Painting(self._file.write(part.delta), part.kept, 0)


@dataclass(frozen=True)
class _Place:
    """Where on the disk a delta lies."""

    start: int
    length: int


@dataclass(frozen=True, eq=False)
class _Painting:
    """A delta, what the painter remembered, and how much memory that takes."""

    delta: SurfaceDelta | _Place
    kept: object
    n_bytes: int


@dataclass(eq=False)
class _Step:
    label: object
    number: int
    parts: list[Part] = field(default_factory=list)


class _StepFile:
    """Deltas in a file that has no name and is gone with the program."""

    def __init__(self) -> None:
        self._file: BinaryIO | None = None
        self._end = 0

    def write(self, delta: SurfaceDelta) -> _Place:
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

    def read(self, place: _Place) -> SurfaceDelta:
        self._file.seek(place.start)
        return pickle.loads(self._file.read(place.length))  # our own bytes, in a file of our own
