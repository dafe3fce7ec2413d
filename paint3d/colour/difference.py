"""Colour difference: CIE L*a*b* and CIEDE2000.

Sharma, Wu, Dalal: The CIEDE2000 color-difference formula, Color Research and Application 30(1),
2005, numbers the equations used here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paint3d.colour.illuminants import observer_weights
from paint3d.colour.spectra import RGB_FROM_XYZ, WHITE_XYZ, decode_srgb, xyz_from_reflectance
from paint3d.core.arrays import AnyArray

__all__ = [
    "COMPARED",
    "Seen",
    "compare_spectra",
    "delta_e",
    "lab_from_linear_rgb",
    "lab_from_reflectance",
    "lab_from_srgb",
    "lab_from_xyz",
]

_XYZ_FROM_RGB = np.linalg.inv(RGB_FROM_XYZ)


def lab_from_xyz(xyz: ArrayLike, white: ArrayLike = WHITE_XYZ) -> AnyArray:
    """CIE L*a*b* (..., 3) of XYZ (..., 3) relative to a white (3,), by default D65 at Y = 1."""
    ratio = np.asarray(xyz, dtype=np.float64) / np.asarray(white, dtype=np.float64)
    line = ratio * (841.0 / 108.0) + 4.0 / 29.0
    f = np.where(ratio > (6.0 / 29.0) ** 3, np.cbrt(ratio), line)
    fx, fy, fz = f[..., 0], f[..., 1], f[..., 2]
    return np.stack([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)], axis=-1)


def lab_from_linear_rgb(linear_rgb: ArrayLike) -> AnyArray:
    """CIE L*a*b* (..., 3) of linear sRGB (..., 3)."""
    return lab_from_xyz(np.asarray(linear_rgb, dtype=np.float64) @ _XYZ_FROM_RGB.T)


def lab_from_srgb(srgb: ArrayLike) -> AnyArray:
    """CIE L*a*b* (..., 3) of uint8 or float [0, 1] sRGB (..., 3)."""
    return lab_from_linear_rgb(decode_srgb(srgb))


def lab_from_reflectance(spectra: ArrayLike) -> AnyArray:
    """CIE L*a*b* (..., 3) of reflectance spectra (..., 31)."""
    return lab_from_xyz(xyz_from_reflectance(spectra))


def delta_e(lab_1: ArrayLike, lab_2: ArrayLike) -> AnyArray:
    """CIEDE2000 colour difference (...,) of two arrays of L*a*b* (..., 3), kL = kC = kH = 1."""
    one, two = np.asarray(lab_1, dtype=np.float64), np.asarray(lab_2, dtype=np.float64)
    b1, b2 = one[..., 2], two[..., 2]
    chroma = (np.hypot(one[..., 1], b1) + np.hypot(two[..., 1], b2)) / 2
    stretch = 1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    a1, a2 = one[..., 1] * stretch, two[..., 1] * stretch
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    grey = c1 * c2 == 0
    h1, h2 = np.arctan2(b1, a1) % (2 * np.pi), np.arctan2(b2, a2) % (2 * np.pi)  # Eq. 7
    turn = np.where(grey, 0.0, (h2 - h1 + np.pi) % (2 * np.pi) - np.pi)  # Eq. 10
    apart = np.abs(h1 - h2) > np.pi
    hue = np.where(apart, (h1 + h2 + 2 * np.pi) / 2 % (2 * np.pi), (h1 + h2) / 2)
    hue = np.where(grey, h1 + h2, hue)  # Eq. 14
    light, chroma = (one[..., 0] + two[..., 0]) / 2, (c1 + c2) / 2
    t = (
        1
        - 0.17 * np.cos(hue - np.radians(30))
        + 0.24 * np.cos(2 * hue)
        + 0.32 * np.cos(3 * hue + np.radians(6))
        - 0.20 * np.cos(4 * hue - np.radians(63))
    )
    s_l = 1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2)
    d_l = (two[..., 0] - one[..., 0]) / s_l
    d_c = (c2 - c1) / (1 + 0.045 * chroma)
    d_h = 2 * np.sqrt(c1 * c2) * np.sin(turn / 2) / (1 + 0.015 * chroma * t)
    bend = np.radians(30) * np.exp(-(((np.degrees(hue) - 275) / 25) ** 2))
    rotation = -2 * np.sin(2 * bend) * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    result: AnyArray = np.sqrt(np.maximum(d_l**2 + d_c**2 + d_h**2 + rotation * d_c * d_h, 0.0))
    return result


# ---- Metamerism ----------------------------------------------------------------------------------
# How much two inks that match in one light differ in others (CIE 15:2018).

REFERENCE = "D65"
COMPARED = (REFERENCE, "D50", "A", "F2", "F11", "LED-B3")


class Seen(NamedTuple):
    """Colours of two spectra in one light.

    Attributes
    ----------
    illuminant : str
    lab : (2, 3) array
        CIE L*a*b* of each, relative to the light's white.
    difference : float
        dE00.
    shift : float
        Special metamerism index for a change of light, with the multiplicative correction of
        CIE 15: dE00 after the second's XYZ are scaled so that both match in the first light.
        0 in the first light.
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
        If a light or the observer is unknown, or colour-science is missing.
    """
    pair = np.stack([np.asarray(one, np.float64), np.asarray(two, np.float64)])
    ratio = None
    results = []
    for name in illuminants:
        weights = observer_weights(name, observer)
        white, xyz = weights.sum(axis=0), pair @ weights
        if ratio is None:
            ratio = xyz[0] / np.maximum(xyz[1], 1e-12)
        lab = lab_from_xyz(xyz, white)
        corrected = lab_from_xyz(xyz[1] * ratio, white)
        results.append(Seen(name, lab, float(delta_e(*lab)), float(delta_e(lab[0], corrected))))
    return results
