"""Painting a copy on trial, to see how dry it comes out, and correcting the dryness that is asked.

What a brush leaves bare depends on more than its load: where its bundles of hairs are supplied
worse, what it goes over again, other strokes that cross. The same recording paints the same, so
what a trial shows at the stations of all strokes is what will be there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from paint3d.calligraphy.flying_white import dryness_at
from paint3d.calligraphy.photo.copying import CopiedSheet
from paint3d.calligraphy.photo.likeness import dryness_of_both, painted_sheet
from paint3d.calligraphy.writing import Written
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["rehearsed"]

_TAKEN = 0.8  # of what is missing: all of it swings


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
        asked, got = dryness_of_both(sheet, painted_sheet(sheet, placed, paint(written)))
        missing = _TAKEN * dryness_at(written.station, asked - got)
        written = replace(written, dryness=np.clip(written.dryness + missing, 0.0, 1.0))
    return written
