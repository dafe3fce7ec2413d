"""Trial paintings of strokes, to correct their dryness and strength by what comes out.

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
from paint3d.calligraphy.photo.flat_page import FlatPage
from paint3d.calligraphy.photo.likeness import (
    PaintedSheet,
    dryness_of_both,
    painted_sheet,
    strength_of_both,
)
from paint3d.calligraphy.writing import Written
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["rehearse"]

_TAKEN = 0.8  # of what is missing: all of it swings
_PALE = 0.9999  # of the light that black ink takes: no ink without water


def rehearse(
    written: Written,
    paint: Callable[[Written], PaintedSurface],
    material: Material,
    trials: int,
    sheet: FlatPage | None = None,
) -> Written:
    """Correct a plan's dryness and strengths by what trials left bare and pale.

    Parameters
    ----------
    written : Written
        The plan of a page; where no stroke says how dry or how pale it is, it comes back as it is.
    paint : callable
        Paints a plan on a fresh surface.
    material : Material
        Of that surface: on one without grain no dryness is seen.
    trials : int
        How often that is done.
    sheet : FlatPage, optional
        The page where it was photographed.
    """
    dries = written.dryness is not None and material.grain > 0.0
    if written.page is None or not (dries or written.strength is not None):
        return written
    sheet = sheet or FlatPage.of(written.page)
    for _ in range(trials):
        placed = list(zip(written.page.pieces, written.placed, strict=True))
        painted = painted_sheet(sheet, placed, paint(written))
        if dries and written.dryness is not None and written.station is not None:
            asked, got = dryness_of_both(sheet, painted)
            missing = _TAKEN * dryness_at(written.station, asked - got)
            written = replace(written, dryness=np.clip(written.dryness + missing, 0.0, 1.0))
        if written.strength is not None:
            written = replace(written, strength=_correct_strengths(sheet, painted, written))
    return written


def _correct_strengths(
    sheet: FlatPage, painted: PaintedSheet, written: Written
) -> NDArray[np.float64]:
    """Strengths (N,) with as much less water as the strokes' densities came out too low."""
    assert written.strength is not None, "it was looked at"
    assert written.stroke is not None, "it comes with the strength"
    asked, got = strength_of_both(sheet, painted)
    factor = np.ones(len(got))  # of a stroke that left no ink to be seen nothing is known
    there = got > 0.0
    factor[there] = _density(asked[there]) / np.maximum(_density(got[there]), 1e-3)
    known = written.stroke >= 0
    before = written.strength[known]
    after = (1.0 - 10.0 ** -(factor[written.stroke[known]] * _density(before))) / BLACKEST
    strength = written.strength.copy()
    strength[known] = np.where(before < 1.0, np.clip(after, 0.0, _PALE), before)
    return strength


def _density(strength: AnyArray) -> NDArray[np.float64]:
    """-log10 of the light of ink of a strength."""
    result: NDArray[np.float64] = -np.log10(1.0 - BLACKEST * np.clip(strength, 0.0, 1.0))
    return result
