"""What a layer shows over another ground than the one it dried on.

Kubelka and Munk's layer is a Moebius function of the reflectance below it, and so is any pile of
them with the gloss between; three points of it are the whole of it. Where paint covers only a part
of a vertex it is that with a share of the ground itself, which the same three points describe
nearly (docs/studio-model.md). The points are not at 0: gloss alone reflects 3 %.
"""

from __future__ import annotations

import numpy as np

from paint3d.colour.kernels.glazing import SPECTRUM_STEPS
from paint3d.core.kernel import kernel

__all__ = ["GROUNDS", "see_through"]

GROUNDS = (0.04, 0.52, 1.0)
"""Reflectances of the grey grounds over which a dried row says what it shows; evenly spaced."""

_LEAST, _MOST = 1e-3, 0.6  # share of the rise in the first half: 1/2 for a layer without scattering


@kernel(error_model="numpy")
def see_through(places, rows, low, middle, high, spectra):
    """Lay dried rows over the spectra below them.

    Parameters
    ----------
    places : (N,) i32
        Rows of `spectra`: what is below, and then what shows.
    rows : (N,) i32
        Rows of the next three.
    low, middle, high : (D, 31) u16
        Reflectance shown over `GROUNDS`, in steps of 1/65535.
    spectra : (M, 31) u16
    """
    n_bands = spectra.shape[1]
    scale = 1.0 / SPECTRUM_STEPS
    span = 1.0 / (GROUNDS[2] - GROUNDS[0])
    for j in range(places.size):
        shown = spectra[places[j]]
        row = rows[j]
        for w in range(n_bands):
            dark = np.float64(low[row, w])
            rise = np.float64(high[row, w]) - dark
            value = dark
            if rise > 0.0:
                first = (np.float64(middle[row, w]) - dark) / rise
                first = min(max(first, _LEAST), _MOST)
                bend = (2.0 * first - 1.0) / (1.0 - first)
                t = (np.float64(shown[w]) * scale - GROUNDS[0]) * span
                value += rise * (1.0 + bend) * t / (1.0 + bend * t)
            shown[w] = np.uint16(min(max(value, 0.0), 65535.0) + 0.5)
