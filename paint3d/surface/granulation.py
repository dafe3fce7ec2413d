"""Granulation: how unevenly coarse grains lie, seen as grain in thin washes of stone.

Of N clumps of grains that fall at random on a patch, the number varies by 1 / sqrt(N) (Poisson), so
few large grains show and many small ones do not. A coat of stone holds .06 mm of solid
(`scripts/grains.py` gives .058 of azurite and .069 of malachite for the second grade to hide), and
grains of a grade differ as they do there. That two grains stick together is set by eye. Patches
are as small as vertices can show. Where grains gather depends on the place alone: all pigments
gather in the same hollows, and a replay shows the same.

Only what is seen varies. Amounts of ink, and how they move, stay as they are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.surface.kernels.grain import fill_grain

__all__ = ["COARSE_UM", "granulated"]

COARSE_UM = 4.5
"""Diameter, um, from which grains are seen to lie unevenly."""
_SOLID_MM = 0.06  # of pigment in a full coat
_CLUMP = 2.0  # grains that stick together
_HEAVIER = 3.08  # a grain's mean volume, by volume, over that of the mean: exp(4.5 spread^2)
_LEAST_MM = 0.25  # lattice of the noise on fine meshes
_NOISE = 0.15  # standard deviation of `fill_grain`
_MOST = 0.7  # of the logarithm of the thickness


def granulated(
    amounts: NDArray[np.float32],
    coverage: NDArray[np.float32],
    points: NDArray[np.float64],
    grain_um: AnyArray,
    spacing: float,
) -> NDArray[np.float32]:
    """Return the amounts (N, P) of ink that are seen at points (N, 3), mm.

    Parameters
    ----------
    amounts : (N, P) float32
        Coats times the covered fraction.
    coverage : (N,) float32
        Covered fraction, above 0 where there is ink.
    points : (N, 3) float64
    grain_um : (P,) float64
        Diameters of the pigments' grains, um.
    spacing : float
        Of the vertices, mm.
    """
    lattice = max(2.0 * spacing, _LEAST_MM)
    height = np.empty(len(points))
    fill_grain(points, lattice, height)
    denser = (height - 0.5) / _NOISE
    seen = amounts.copy()
    for p in np.flatnonzero(grain_um >= COARSE_UM):
        clump_mm3 = _CLUMP * _HEAVIER * np.pi / 6.0 * (1e-3 * grain_um[p]) ** 3
        coats = amounts[:, p] / np.maximum(coverage, 1e-6)
        number = coats * (_SOLID_MM * (0.5 * lattice) ** 2 / clump_mm3)
        deviation = np.minimum(1.0 / np.sqrt(np.maximum(number, 1e-6)), _MOST)
        seen[:, p] *= np.exp(deviation * denser - 0.5 * deviation**2)
    return seen
