"""K and S of indigo (hua qing) by wavelength, for nobody's measured spectrum may ship.

What is published is where it absorbs most: cotton that is dyed with it has its greatest K/S at
660 nm (Ratnapandian, Application of natural dyes by padding, thesis, RMIT University, 2013, section
6), and solid indigo is known for a band that falls off slowly towards green and fast towards the
infrared. K is one such band over the wavenumber, half a Gauss curve to either side, above a grey
that goes through all wavelengths; S is the same at all. The widths, the grey and S are set by eye,
such that washes are of the grey blue that leaves and water have in painting and full coats navy.

Prussian blue stood in for it before: twice as colourful in washes, and greenish.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import WAVELENGTHS

MOST_NM = 660.0
TO_RED, TO_GREEN = 2400.0, 5500.0  # full widths at half height of either side, 1/cm
GREY, SCATTERING = 0.35, 0.08  # over the band's height


def indigo() -> tuple[NDArray, NDArray]:
    """Relative K and S (31,)."""
    apart = 1e7 / np.asarray(WAVELENGTHS) - 1e7 / MOST_NM
    band = np.exp(-4.0 * np.log(2.0) * (apart / np.where(apart < 0.0, TO_RED, TO_GREEN)) ** 2)
    return band + GREY, np.full(band.shape, SCATTERING)
