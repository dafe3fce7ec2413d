"""What changed on a surface between two moments, to the bit, and the way there and back.

Painting writes into the surface's arrays inside kernels, which cannot know what will be undone. So
`DeltaRecorder` keeps a second copy of the wet ink as it was, fills it only where there was paint,
and compares the vertices that are known to have been touched. Exchanging a delta with the surface
gives the delta that leads back: undo and redo are the same step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.surface.dry_layers import DryRows
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.vertex_sets import union

__all__ = ["BrushLoad", "DeltaRecorder", "SurfaceDelta"]


@dataclass(frozen=True, eq=False)
class BrushLoad:
    """The ink in the brush, and what ran off the surface; see `InkField`."""

    load: AnyArray
    off_surface: AnyArray
    reservoirs: AnyArray
    transfer: AnyArray

    @classmethod
    def of(cls, surface: PaintedSurface) -> BrushLoad:
        """What the surface's brush holds now."""
        ink = surface.ink
        return cls(*(getattr(ink, name).copy() for name in cls.__annotations__))

    def put(self, surface: PaintedSurface) -> None:
        """Let the surface's brush hold this; pigments that came since get nothing."""
        ink, count = surface.ink, len(surface.pigments)
        for name in ("load", "off_surface"):
            getattr(ink, name)[:] = np.pad(getattr(self, name), (0, count - len(self.load)))
        ink.transfer[:] = self.transfer
        missing = count - self.reservoirs.shape[1]
        surface.ink = ink._replace(reservoirs=np.pad(self.reservoirs, ((0, 0), (0, missing))))


@dataclass(frozen=True, eq=False)
class SurfaceDelta:
    """What some vertices, the brush and the water are at another moment.

    Attributes
    ----------
    vertex_ids : (N,) int32
    amounts : (N, P) float32
    coverage : (N,) float32
    dry : DryRows
    brush : BrushLoad
    flow : mapping or None
        As `PaintedSurface.keep_flow` gives it.
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
        """Bring the surface there.

        Parameters
        ----------
        surface : PaintedSurface
        water : mapping or None
            What `PaintedSurface.keep_flow` gives now.

        Returns
        -------
        SurfaceDelta
            The way back.
        vertex_ids : (M,) int32
            Vertices whose colours may have changed.
        """
        ink, ids, dry = surface.ink, self.vertex_ids, surface.dry_layers
        back = ink.amounts[ids], ink.coverage[ids], BrushLoad.of(surface)
        missing = len(surface.pigments) - self.amounts.shape[1]
        ink.amounts[ids] = np.pad(self.amounts, ((0, 0), (0, missing)))
        ink.coverage[ids] = self.coverage
        gone = dry.vertex_ids[self.dry.count :].copy()
        rows = dry.exchange(self.dry, surface.paint_mesh.capacity)
        self.brush.put(surface)
        dried = (gone, rows.vertex_ids, self.dry.vertex_ids)
        touched = union([ids, *dried], surface.paint_mesh.capacity)
        surface.touch(touched)
        if self.flow is not water:
            self._move_water(surface)
        return SurfaceDelta(ids, back[0], back[1], rows, back[2], water), touched

    def _move_water(self, surface: PaintedSurface) -> None:
        surface.drop_flow()
        if self.flow is not None:
            surface.restore_flow(self.flow)


def _same(one: Mapping[str, AnyArray] | None, two: Mapping[str, AnyArray] | None) -> bool:
    """Whether the water was kept twice as it is."""
    if one is None or two is None:
        return one is two
    return all(np.array_equal(one[name], two[name]) for name in one)


class DeltaRecorder:
    """Remembers a surface as it was at a moment, and says what changed since.

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
        """Take the surface as it is now, whatever it was."""
        ink = self._surface.ink
        self._clear()
        painted = np.flatnonzero((ink.coverage > 0.0) | ink.amounts.any(axis=1))
        self._surface.take_changed()
        self._follow(painted, self._surface.keep_flow())

    @property
    def water(self) -> Mapping[str, AnyArray] | None:
        """What `PaintedSurface.keep_flow` gave when this was last asked."""
        return self._flow

    def accept(self, vertex_ids: AnyArray, water: Mapping[str, AnyArray] | None) -> None:
        """Take what was brought to these vertices (N,), and this water, as what there is."""
        self._surface.take_changed()
        self._fit()
        self._follow(vertex_ids, water)

    def before(self, vertex_ids: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Amounts (N, P) and coverage (N,) of vertices (N,) when this was last asked."""
        self._fit()
        return self._amounts[vertex_ids], self._coverage[vertex_ids]

    def take(self) -> SurfaceDelta:
        """The way back to where this was last asked; from now on it is the way back to here."""
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
        self._follow(ids[at], self._flow if _same(self._flow, water) else water)
        return delta

    def _follow(self, ids: AnyArray, water: Mapping[str, AnyArray] | None) -> None:
        surface = self._surface
        self._amounts[ids] = surface.ink.amounts[ids]
        self._coverage[ids] = surface.ink.coverage[ids]
        surface.dry_layers.mark()
        self._brush = BrushLoad.of(surface)
        self._flow = water

    def _clear(self) -> None:
        """Remember no paint, with room for all vertices: memory is taken only where it comes."""
        ink = self._surface.ink
        self._amounts = np.zeros(ink.amounts.shape, np.float32)
        self._coverage = np.zeros(ink.coverage.shape, np.float32)

    def _fit(self) -> None:
        """Follow a surface that has grown, or knows more pigments."""
        ink = self._surface.ink
        amounts, coverage = self._amounts, self._coverage
        if amounts.shape == ink.amounts.shape:
            return
        inked = np.flatnonzero((coverage > 0.0) | amounts.any(axis=1))
        self._clear()
        self._amounts[inked, : amounts.shape[1]] = amounts[inked]
        self._coverage[inked] = coverage[inked]
