"""K and S of indigo (hua qing) and gamboge (teng huang), of which no measurement may ship.

Published of indigo is where it absorbs most: cotton that is dyed with it has its greatest K/S at
660 nm (Ratnapandian, Application of natural dyes by padding, thesis, RMIT University, 2013, section
6), and solid indigo is known for a band that falls off slowly towards green and fast towards the
infrared. K is one such band over the wavenumber, half a Gauss curve to either side, above a grey
that goes through all wavelengths; S is the same at all. The widths, the grey and S are set by eye,
such that washes are of the dull grey blue that leaves and water have in painting and full coats
navy.

Gamboge is a clear resin that takes up violet and ever less towards green: lemon where it is thin,
golden where it is thick. K is one edge over the wavelength, exponential on its long side. Its
place and width are set such that two coats on paper are near the gamboge of Maerz and Paul, A
Dictionary of Color (1930; sRGB 228, 155, 15); S and the strength of a coat are set by eye.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import WAVELENGTHS

MOST_NM = 660.0
TO_RED, TO_GREEN = 2600.0, 6500.0  # full widths at half height of either side, 1/cm
GREY, SCATTERING = 0.7, 0.06  # over the band's height

EDGE_NM, EDGE_WIDTH_NM = 435.0, 31.0
GAMBOGE, CLOUD = 6.0, 0.12  # K below the edge and S, per coat


def indigo() -> tuple[NDArray, NDArray]:
    """Compute relative K and S (31,)."""
    apart = 1e7 / np.asarray(WAVELENGTHS) - 1e7 / MOST_NM
    band = np.exp(-4.0 * np.log(2.0) * (apart / np.where(apart < 0.0, TO_RED, TO_GREEN)) ** 2)
    return band + GREY, np.full(band.shape, SCATTERING)


def gamboge() -> tuple[NDArray, NDArray]:
    """Compute K and S (31,) per coat."""
    below = 1.0 / (1.0 + np.exp((np.asarray(WAVELENGTHS) - EDGE_NM) / EDGE_WIDTH_NM))
    return GAMBOGE * below, np.full(below.shape, CLOUD)
