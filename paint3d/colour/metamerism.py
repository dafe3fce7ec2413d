"""How far two inks that look alike in one light part in others: metamerism (CIE 15:2018)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paint3d.colour.difference import delta_e, lab_from_xyz
from paint3d.colour.illuminants import observer_weights
from paint3d.core.types import AnyArray

__all__ = ["COMPARED", "Seen", "compare_spectra"]

REFERENCE = "D65"
COMPARED = (REFERENCE, "D50", "A", "F2", "F11", "LED-B3")


class Seen(NamedTuple):
    """Two spectra in one light.

    Attributes
    ----------
    illuminant : str
    lab : (2, 3) array
        CIE L*a*b* of each, relative to the light's white.
    difference : float
        dE00.
    shift : float
        dE00 that is left when the second's XYZ are scaled so that both are the same in the first
        light: the special metamerism index for a change of light, with the multiplicative
        correction of CIE 15. 0 in the first light.
    """

    illuminant: str
    lab: AnyArray
    difference: float
    shift: float


def compare_spectra(
    one: ArrayLike, two: ArrayLike, illuminants: Sequence[str] = COMPARED, observer: int = 2
) -> list[Seen]:
    """Compare two reflectance spectra (31,) light by light; the first light is the reference.

    Raises
    ------
    InputError
        If a light or the observer is not known, or colour-science is missing.
    """
    pair = np.stack([np.asarray(one, np.float64), np.asarray(two, np.float64)])
    ratio = None
    found = []
    for name in illuminants:
        weights = observer_weights(name, observer)
        white, xyz = weights.sum(axis=0), pair @ weights
        if ratio is None:
            ratio = xyz[0] / np.maximum(xyz[1], 1e-12)
        lab = lab_from_xyz(xyz, white)
        corrected = lab_from_xyz(xyz[1] * ratio, white)
        found.append(Seen(name, lab, float(delta_e(*lab)), float(delta_e(lab[0], corrected))))
    return found
