"""Painting a copy on trial, to see how dry it comes out, and correcting the dryness that is asked.

What a brush leaves bare depends on more than its load: where its bundles of hairs are supplied
worse, what it goes over again, other strokes that cross. The same recording paints the same, so
what a trial shows at the stations of all strokes is what will be there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.flying_white import BLACKEST, dryness_at
from paint3d.calligraphy.photo.copying import CopiedSheet
from paint3d.calligraphy.photo.likeness import (
    PaintedSheet,
    dryness_of_both,
    painted_sheet,
    strength_of_both,
)
from paint3d.calligraphy.writing import Written
from paint3d.core.types import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["rehearsed"]

_TAKEN = 0.8  # of what is missing: all of it swings
_PALE = 0.9999  # of the light that black ink takes: no ink without water


def rehearsed(
    sheet: CopiedSheet, written: Written, paint: Callable[[Written], PaintedSurface], trials: int
) -> Written:
    """A plan whose dryness is corrected by what trials left bare.

    Parameters
    ----------
    sheet : CopiedSheet
    written : Written
        The plan of its page; where no stroke says how dry it is, it comes back as it is.
    paint : callable
        Paints a plan on a fresh surface.
    trials : int
        How often that is done.
    """
    for _ in range(trials):
        if written.dryness is None or written.station is None or written.page is None:
            break
        placed = list(zip(written.page.pieces, written.placed, strict=True))
        painted = painted_sheet(sheet, placed, paint(written))
        asked, got = dryness_of_both(sheet, painted)
        missing = _TAKEN * dryness_at(written.station, asked - got)
        written = replace(written, dryness=np.clip(written.dryness + missing, 0.0, 1.0))
        if written.strength is not None:
            written = replace(written, strength=_as_pale(sheet, painted, written))
    return written


def _as_pale(sheet: CopiedSheet, painted: PaintedSheet, written: Written) -> NDArray[np.float64]:
    """Strengths (N,) with as much less water as the strokes' densities came out too low."""
    assert written.strength is not None, "it was looked at"
    assert written.station is not None, "it was looked at"
    asked, got = strength_of_both(sheet, painted)
    factor = np.ones(len(got))  # of a stroke that left no ink to be seen nothing is known
    there = got > 0.0
    factor[there] = _density(asked[there]) / np.maximum(_density(got[there]), 1e-3)
    counts = [len(one.dryness) for piece in sheet.page.pieces for one in piece.glyph.strokes]
    known = np.isfinite(written.strength) & np.isfinite(written.station)
    stroke = np.searchsorted(np.cumsum(counts) - 0.5, written.station[known], side="right")
    before = written.strength[known]
    after = (1.0 - 10.0 ** -(factor[stroke] * _density(before))) / BLACKEST
    strength = written.strength.copy()
    strength[known] = np.where(before < 1.0, np.clip(after, 0.0, _PALE), before)
    return strength


def _density(strength: AnyArray) -> NDArray[np.float64]:
    """-log10 of the light of ink of a strength."""
    result: NDArray[np.float64] = -np.log10(1.0 - BLACKEST * np.clip(strength, 0.0, 1.0))
    return result
