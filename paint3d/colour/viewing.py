"""Viewing conditions: the light, the observer, chromatic adaptation and the screen's gamut.

Reflectance goes to XYZ in the light (`illuminants`), by chromatic adaptation to the screen's white
(Li et al. 2017 for CAT16, Lam 1985 for Bradford, both complete), and to linear RGB of the screen's
primaries. All three screens have the white D65, and their files sRGB's transfer function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.colour.illuminants import OBSERVERS, observer_weights
from paint3d.colour.spectra import (
    RGB_FROM_XYZ,
    WHITE_XYZ,
    encode_srgb,
    rgb_from_xyz,
    xyz_weights,
)
from paint3d.core.arrays import AnyArray
from paint3d.errors import UnknownNameError

__all__ = ["ADAPTATIONS", "GAMUTS", "Codes", "Gamut", "Viewing", "linear_srgb_of"]

NONE = "none"
_CAT16 = (  # Li et al. 2017, equation (5)
    (0.401288, 0.650173, -0.051461),
    (-0.250268, 1.204414, 0.045854),
    (-0.002079, 0.048952, 0.953127),
)
_BRADFORD = (  # Lam 1985
    (0.8951, 0.2664, -0.1614),
    (-0.7502, 1.7135, 0.0367),
    (0.0389, -0.0685, 1.0296),
)
ADAPTATIONS = {"cat16": _CAT16, "bradford": _BRADFORD, NONE: None}
_BLOCK = 1 << 16  # spectra encoded at a time


class Gamut(NamedTuple):
    """A screen: chromaticities of red, green and blue, and its number in H.273 (`cICP`)."""

    title: str
    red: tuple[float, float]
    green: tuple[float, float]
    blue: tuple[float, float]
    h273: int

    @property
    def rgb_from_xyz(self) -> AnyArray:
        """(3, 3) linear RGB from XYZ, white at (1, 1, 1)."""
        return rgb_from_xyz(self.red, self.green, self.blue)


GAMUTS = {
    "srgb": Gamut("sRGB", (0.64, 0.33), (0.30, 0.60), (0.15, 0.06), 1),
    "p3": Gamut("Display P3", (0.680, 0.320), (0.265, 0.690), (0.150, 0.060), 12),
    "rec2020": Gamut("Rec. 2020", (0.708, 0.292), (0.170, 0.797), (0.131, 0.046), 9),
}


class Codes(NamedTuple):
    """Colours as codes, and the number that were out of gamut.

    Attributes
    ----------
    rgb : (N, 3) uint8
    n_clipped : int
        Colours outside the gamut, by more than half a code.
    """

    rgb: NDArray[np.uint8]
    n_clipped: int


@dataclass(frozen=True)
class Viewing:
    """Viewing conditions of spectra.

    Parameters
    ----------
    illuminant : str
        See `illuminants.find_illuminant`.
    observer : {2, 10}
        Degrees: the CIE's of 1931 and of 1964.
    adaptation : {"cat16", "bradford", "none"}
        To the light, so that a white sheet is white. Without it, the picture has the light's
        colour, as bright as the gamut allows.
    gamut : {"srgb", "p3", "rec2020"}

    Raises
    ------
    InputError
        If one of them is unknown, or colour-science is needed and missing.
    """

    illuminant: str = "D65"
    observer: int = 2
    adaptation: str = "cat16"
    gamut: str = "srgb"

    def __post_init__(self) -> None:
        if self.adaptation not in ADAPTATIONS:
            raise UnknownNameError("adaptation", str(self.adaptation), ADAPTATIONS)
        if self.gamut not in GAMUTS:
            raise UnknownNameError("gamut", str(self.gamut), GAMUTS)
        if self.observer not in OBSERVERS:
            known = [str(degrees) for degrees in OBSERVERS]
            raise UnknownNameError("observer", str(self.observer), known)
        if not self.is_own_light:
            observer_weights(self.illuminant, self.observer)

    @property
    def is_own_light(self) -> bool:
        """Whether it is the default light and observer: D65, 2 degrees."""
        return self.illuminant.strip().upper() == "D65" and self.observer == 2

    @property
    def is_plain(self) -> bool:
        """Whether all is as by default: D65, 2 degrees, sRGB."""
        return self.is_own_light and self.gamut == "srgb"

    @cached_property
    def weights(self) -> AnyArray:
        """(31, 3): linear RGB of a reflectance spectrum is ``spectrum @ weights``."""
        primaries = GAMUTS[self.gamut].rgb_from_xyz
        if self.is_own_light:
            return xyz_weights() @ primaries.T
        weights = observer_weights(self.illuminant, self.observer)
        matrix = ADAPTATIONS[self.adaptation]
        if matrix is not None:
            return weights @ adapt_white(matrix, weights.sum(axis=0), WHITE_XYZ).T @ primaries.T
        seen: AnyArray = weights @ primaries.T
        seen = seen / seen.sum(axis=0).max()
        return seen

    def linear_rgb(self, spectra: ArrayLike) -> AnyArray:
        """Linear RGB (..., 3) of reflectance spectra (..., 31); it leaves [0, 1] out of gamut."""
        return np.asarray(spectra) @ self.weights

    def codes(self, spectra: ArrayLike) -> Codes:
        """Codes (N, 3) of reflectance spectra (N, 31); those out of gamut are clipped."""
        return encoded(self.linear_rgb(spectra))

    def codes_of(self, n: int, spectra_of: Callable[[AnyArray], AnyArray]) -> Codes:
        """Codes of `n` spectra; ``spectra_of(ids)`` gives a block of them, (K, 31)."""
        parts = [
            self.codes(spectra_of(np.arange(first, min(first + _BLOCK, n), dtype=np.int32)))
            for first in range(0, n, _BLOCK)
        ]
        if not parts:
            return Codes(np.empty((0, 3), np.uint8), 0)
        return Codes(
            np.concatenate([part.rgb for part in parts]), sum(part.n_clipped for part in parts)
        )


def encoded(linear: AnyArray) -> Codes:
    """Encode linear RGB (N, 3) of any gamut."""
    values = 255.0 * encode_srgb(linear)
    outside = ((values < -0.5) | (values > 255.5)).any(axis=1)
    return Codes(np.rint(np.clip(values, 0.0, 255.0)).astype(np.uint8), int(outside.sum()))


def adapt_white(matrix: ArrayLike, white: AnyArray, to: AnyArray) -> AnyArray:
    """Return (3, 3) XYZ from XYZ: complete von Kries adaptation from one white to another."""
    cones = np.asarray(matrix)
    scale = (cones @ to) / (cones @ white)
    result: AnyArray = np.linalg.solve(cones, scale[:, None] * cones)
    return result


def linear_srgb_of(linear: AnyArray, gamut: str) -> AnyArray:
    """Linear sRGB (..., 3), unclipped, of linear RGB of another gamut."""
    matrix = RGB_FROM_XYZ @ np.linalg.inv(GAMUTS[gamut].rgb_from_xyz)
    return np.asarray(linear) @ matrix.T
