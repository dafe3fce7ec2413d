"""One pigment: how it absorbs and scatters light, by wavelength, and where that is from."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from paint3d.core.arrays import as_array, as_number
from paint3d.core.types import AnyArray
from paint3d.errors import PigmentError

__all__ = ["BANDS_NM", "COARSEST_UM", "USUAL_FINE", "Pigment"]

BANDS_NM = np.arange(400.0, 701.0, 10.0)
"""(31,) wavelengths of K and S, nm."""
BANDS_NM.flags.writeable = False
USUAL_FINE = 0.12
"""Of a pigment of which nothing is said, what goes wherever its water goes."""
COARSEST_UM = 1000.0
"""Diameter of grains, um, up to which a pigment may have any."""
_STRONGEST = 1e6  # K and S of a coat; measured inks stay below 100


@dataclass(frozen=True, eq=False)
class Pigment:
    """One pigment, ink or paint.

    Parameters
    ----------
    name, chinese : str
    K, S : (31,) array_like
        Absorption and scattering per full coat at 400, 410, ... 700 nm, 0 to a million.
    source, basis, licence : str
        Whose measurement; how K and S came from it, and for what it stands in; its terms.
    saunderson : bool
        Whether K and S describe the film below its gloss, so that Saunderson's correction leads
        to what is measured. Otherwise they give the measured reflectance themselves.
    gloss : float
        How glossy a full coat of it dries, 0 (as what it lies on) to 1.
    fine : float
        The share of it that no pore holds back, 0 (all grains) to 1 (dissolved).
    grain_um : float
        Diameter of the grains of the rest, um, 0 (no larger than soot) to 1000.

    Raises
    ------
    PigmentError
        If the name is empty, K or S has the wrong length or is not between 0 and a million,
        gloss or fine are not between 0 and 1, or grain_um is not between 0 and 1000.
    """

    name: str
    chinese: str
    K: AnyArray
    S: AnyArray
    source: str = ""
    basis: str = ""
    licence: str = ""
    saunderson: bool = False
    gloss: float = 0.0
    fine: float = USUAL_FINE
    grain_um: float = 0.0

    def __post_init__(self) -> None:
        if not self.name:
            raise PigmentError("a pigment has no name")
        for share in ("gloss", "fine"):
            value = getattr(self, share)
            as_number(value, f"{share} of {self.name}", 0.0, 1.0, error=PigmentError)
        grain = f"grain_um of {self.name}"
        as_number(self.grain_um, grain, 0.0, COARSEST_UM, error=PigmentError)
        for letter in "KS":
            values = as_array(
                getattr(self, letter), f"{letter} of {self.name}", (31,), error=PigmentError
            ).copy()
            if not 0.0 <= values.min() <= values.max() <= _STRONGEST:
                worst = int(values.argmin() if values.min() < 0.0 else values.argmax())
                raise PigmentError(
                    f"{letter} of {self.name} is {values[worst]:g} at {BANDS_NM[worst]:.0f} nm; "
                    f"expected 0 to {_STRONGEST:g}"
                )
            values.flags.writeable = False
            object.__setattr__(self, letter, values)

    def is_like(self, other: Pigment) -> bool:
        """Whether it absorbs, scatters, shines and runs as another does, whatever its name."""
        if self is other:
            return True
        same = np.array_equal(self.K, other.K) and np.array_equal(self.S, other.S)
        how = attrgetter("saunderson", "gloss", "fine", "grain_um")
        return same and how(self) == how(other)
