"""An eraser: a brush that takes dry paint off where it would have put ink.

It paints as it always does, so its print is that of the brush; what fell on the surface goes back
into the brush, and the fraction of each vertex that was covered loses so much of the paint of the
layer. The rest of a row shows as it did, over any ground: `DryLayers` keeps it by three of them.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.brush_engine.ink_transfer import level_reservoirs
from paint3d.colour.kernels.glazing import GROUNDS, SPECTRUM_STEPS
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Eraser", "give_back"]

_ALL = 0.98  # covered fraction from which nothing is left


class Eraser:
    """Erases the layer that is painted on, during one stroke; its wet paint dries first.

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        surface.dry()
        self._gone = np.zeros(0, np.float32)  # fraction of each vertex that has been erased

    def wipe(self) -> float:
        """Take off what lies where the brush has just been.

        Returns
        -------
        float
            How much ink is gone, coats x mm2: for the ledger of who painted it.
        """
        surface = self._surface
        ink, dry = surface.ink, surface.dry_layers
        ids = ink.dirty_ids[: int(ink.n_dirty[0])]
        ids = ids[(ink.coverage[ids] > 0.0) | ink.amounts[ids].any(axis=1)]
        if not len(ids):
            return 0.0
        self._gone = np.pad(self._gone, (0, max(0, surface.n_vertices - len(self._gone))))
        covered = np.where(ink.coverage[ids] >= _ALL, np.float32(1.0), ink.coverage[ids])
        self._take_back_ink(ids)
        more = (covered > self._gone[ids]) & dry.has_row(ids)
        ids, covered = ids[more], covered[more]
        if not len(ids):
            return 0.0
        stays = (1.0 - covered) / (1.0 - self._gone[ids])
        self._gone[ids] = covered
        rows = dry.reserve_rows(ids, surface.paint_mesh.capacity)
        before = dry.amounts[rows]
        dry.amounts[rows] = before * stays[:, None]
        dry.coverage[rows] *= stays
        bare = surface.bare_spectra(ids).astype(np.float64)
        _fade(dry.spectra, rows, bare, stays)
        for grey, over in zip(GROUNDS, dry.over, strict=True):
            _fade(over, rows, grey * SPECTRUM_STEPS, stays)
        dry.changes += 1
        erased = (before - dry.amounts[rows]).sum(axis=1, dtype=np.float64)
        surface.touch(ids)
        return math.fsum(surface.vertex_areas[ids] * erased)

    def _take_back_ink(self, ids: AnyArray) -> None:
        """Put what the brush left on vertices (N,) back into it."""
        ink = self._surface.ink
        amounts = ink.amounts[ids].astype(np.float64)
        ink.amounts[ids], ink.coverage[ids] = 0.0, 0.0
        give_back(self._surface, ids, amounts)


def _fade(spectra: AnyArray, rows: AnyArray, ground: AnyArray | float, stays: AnyArray) -> None:
    """Bring rows of spectra, in `SPECTRUM_STEPS`, nearer to the ground."""
    shown = ground + stays[:, None] * (spectra[rows].astype(np.float64) - ground)
    spectra[rows] = np.rint(np.clip(shown, 0, SPECTRUM_STEPS))


def give_back(surface: PaintedSurface, ids: AnyArray, amounts: AnyArray) -> AnyArray:
    """Put amounts (N, P) of vertices (N,) back into the brush, wherever along it such ink is.

    Returns what it has more, (P,) float64, coats x mm2.
    """
    ink = surface.ink
    parts = surface.vertex_areas[ids, None] * amounts
    caught = np.array([math.fsum(part) for part in parts.T])  # the same in any order
    wanted = ink.load + caught
    held = np.maximum(wanted, 0.0)
    given = held - ink.load
    fractions = np.divide(held, ink.load, out=np.zeros_like(held), where=ink.load > 0.0)
    empty = (ink.load <= 0.0) & (held > 0.0)
    ink.reservoirs[:] *= fractions
    if len(ink.reservoirs) > 1:
        ink.reservoirs[:, empty] = held[empty] / len(ink.reservoirs)
        level_reservoirs(ink.reservoirs)
    ink.load[:] = held
    ink.off_surface[:] += wanted - held  # what it drank and has left elsewhere already
    result: AnyArray = given
    return result
