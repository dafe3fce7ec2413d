"""A brush or an ink for one stroke: what was in hand comes back with its end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray
from paint3d.painter.painter import Ink, Painter
from paint3d.surface.undo import BrushLoad

__all__ = ["BrushLease"]


class BrushLease:
    """Swaps in another brush, or another ink for the one in hand, until `end` restores it.

    Parameters
    ----------
    painter : Painter
    brush : BrushSpec, optional
        Dipped in the ink, or in that of the brush that waits; that one keeps what it holds.
    ink : str, Pigment or mapping, optional
        Without a brush, as much of it as the brush in hand holds. What this has used up of it when
        it comes back, it has used up of its own.

    Raises
    ------
    Paint3DError
        If the brush or the ink cannot be used; then all is as it was.
    """

    def __init__(
        self,
        painter: Painter,
        brush: BrushSpec | None,
        ink: Ink | None,
    ) -> None:
        self._painter, self._is_brush = painter, brush is not None
        self._kept = painter.keep()
        self._load = BrushLoad.of(painter.surface)
        try:
            if brush is not None:
                painter.change_brush(brush)
                if ink is not None:
                    painter.dip(ink)
            elif ink is not None:
                painter.recolour(ink)
        except BaseException:
            self._load.put(painter.surface)
            painter.restore(self._kept)
            raise
        self._began = BrushLoad.of(painter.surface)
        self._hair_load = None if painter.hairs is None else painter.hairs.load.copy()

    def end(self) -> None:
        """Restore what was in hand before."""
        painter, surface = self._painter, self._painter.surface
        now, hairs = BrushLoad.of(surface), painter.hairs
        own, of_hairs = self._load, self._kept["of_hairs"]
        if not self._is_brush:
            own = replace(
                own,
                load=own.load * _left(now.load.sum(), self._began.load.sum()),
                reservoirs=_fitting(own.reservoirs, now.reservoirs, self._began.reservoirs),
            )
            if isinstance(of_hairs, Mapping) and hairs is not None:
                assert self._hair_load is not None, "it has had hairs all the time"
                left = _left(hairs.load.sum(axis=1), self._hair_load.sum(axis=1))
                load = of_hairs["load"] * left[:, None]
                of_hairs = {"load": load, "memory": hairs.memory.copy()}
                held = load.sum(axis=0)  # hairs know only the inks that they have held
                own = replace(own, load=np.pad(held, (0, len(own.load) - len(held))))
        before, loaded = painter.in_brush(), painter.loaded
        own.put(surface)
        surface.ink.off_surface[:] = now.off_surface
        back = loaded + painter.in_brush() - before
        painter.restore({**self._kept, "of_hairs": of_hairs, "loaded": back})


def _left(now: AnyArray, began: AnyArray) -> AnyArray:
    """The fraction that is left of each."""
    held = np.asarray(began) > 0.0
    fraction: AnyArray = np.where(held, now / np.where(held, began, 1.0), 1.0)
    return fraction


def _fitting(own: AnyArray, now: AnyArray, began: AnyArray) -> AnyArray:
    """Reservoirs (N, P) that have lost what those of the stroke have lost."""
    if now.shape[0] != began.shape[0] or own.shape[0] != now.shape[0]:
        return own
    fraction: AnyArray = own * _left(now.sum(axis=1), began.sum(axis=1))[:, None]
    return fraction
