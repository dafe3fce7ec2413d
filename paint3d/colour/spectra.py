"""Spectra to XYZ, linear RGB and sRGB under D65 for the CIE 1931 2-degree observer.

Spectra are sampled at `WAVELENGTHS`: 400 to 700 nm by 10 nm, 31 values. The sums over the bands
are scaled per channel so that a perfect reflector is exactly the sRGB white (1, 1, 1): the
visible light outside 400-700 nm is left out, and without the scaling white would be yellowish by
0.3 dE00. The observer and illuminant come from a small table (`scripts/build_observer.py`).
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import InputError

__all__ = [
    "N_BANDS",
    "RGB_FROM_XYZ",
    "WAVELENGTHS",
    "WHITE_XYZ",
    "decode_srgb",
    "encode_srgb",
    "linear_rgb_from_reflectance",
    "rgb_from_xyz",
    "rgb_weights",
    "srgb_codes",
    "srgb_from_linear",
    "srgb_from_reflectance",
    "xyz_from_reflectance",
    "xyz_weights",
]

WAVELENGTHS = np.arange(400.0, 701.0, 10.0)
"""(31,) nm."""
WAVELENGTHS.flags.writeable = False
N_BANDS = WAVELENGTHS.size

_RED, _GREEN, _BLUE, _WHITE = (0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.3290)
_TABLE = Path(__file__).parent / "data" / "observer.csv"


def _xyz_of_chromaticity(xy: tuple[float, float]) -> AnyArray:
    x, y = xy
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


WHITE_XYZ = _xyz_of_chromaticity(_WHITE)
"""(3,) XYZ of the sRGB white, D65 by its chromaticity (0.3127, 0.3290), Y = 1."""


def rgb_from_xyz(
    red: tuple[float, float], green: tuple[float, float], blue: tuple[float, float]
) -> AnyArray:
    """(3, 3) linear RGB from XYZ for primaries with these chromaticities (x, y) and white D65."""
    primaries = np.column_stack([_xyz_of_chromaticity(xy) for xy in (red, green, blue)])
    return np.linalg.inv(primaries * np.linalg.solve(primaries, WHITE_XYZ))


RGB_FROM_XYZ = rgb_from_xyz(_RED, _GREEN, _BLUE)
"""(3, 3) linear sRGB from XYZ, computed from the primaries and white of IEC 61966-2-1."""


@lru_cache(maxsize=1)
def xyz_weights() -> AnyArray:
    """Return (31, 3) weights: XYZ of a reflectance spectrum is ``spectrum @ weights``."""
    table = np.loadtxt(_TABLE, delimiter=",", skiprows=1)
    weights = table[:, 1:4] * table[:, 4:5]
    weights *= WHITE_XYZ / weights.sum(axis=0)
    weights.flags.writeable = False
    return weights


@lru_cache(maxsize=1)
def rgb_weights() -> AnyArray:
    """Return (31, 3) weights: linear sRGB of a reflectance spectrum is ``spectrum @ weights``."""
    weights = xyz_weights() @ RGB_FROM_XYZ.T
    weights.flags.writeable = False
    return weights


def _as_spectra(spectra: ArrayLike) -> AnyArray:
    values = np.asarray(spectra)
    shape = (*(None,) * (values.ndim - 1), N_BANDS)
    return as_array(values, "spectra", shape if values.ndim else (N_BANDS,))


def xyz_from_reflectance(spectra: ArrayLike) -> AnyArray:
    """XYZ (..., 3), white at Y = 1, of reflectance spectra (..., 31).

    Raises
    ------
    InputError
        If the last axis has not 31 values or one is not finite.
    """
    return _as_spectra(spectra) @ xyz_weights()


def linear_rgb_from_reflectance(spectra: ArrayLike) -> AnyArray:
    """Linear sRGB (..., 3) of reflectance spectra (..., 31); saturated colours leave [0, 1].

    Raises
    ------
    InputError
        If the last axis has not 31 values or one is not finite.
    """
    return _as_spectra(spectra) @ rgb_weights()


def encode_srgb(linear_rgb: ArrayLike) -> AnyArray:
    """The sRGB transfer function (IEC 61966-2-1), linear to encoded; odd below zero."""
    linear = np.asarray(linear_rgb, dtype=np.float64)
    size = np.abs(linear)
    curve = 1.055 * np.power(np.maximum(size, 0.0031308), 1 / 2.4) - 0.055
    return np.copysign(np.where(size <= 0.0031308, 12.92 * size, curve), linear)


def decode_srgb(srgb: ArrayLike) -> AnyArray:
    """Linear RGB of encoded sRGB: floats in [0, 1], or uint8.

    Raises
    ------
    InputError
        If the values are neither floats nor uint8.
    """
    values = np.asarray(srgb)
    if values.dtype == np.uint8:
        values = values / 255.0
    elif values.dtype.kind != "f":
        raise InputError(
            "srgb has type {values_dtype}; expected uint8 or floats in [0, 1]",
            values_dtype=values.dtype,
        )
    curve = ((np.maximum(values, 0.04045) + 0.055) / 1.055) ** 2.4
    return np.where(values <= 0.04045, values / 12.92, curve)


def srgb_from_linear(linear_rgb: ArrayLike) -> AnyArray:
    """Rounded uint8 sRGB of linear RGB; colours outside the sRGB gamut go to its border.

    Notes
    -----
    Clipping the channels is how a display shows such a colour. Of the palette on white, films of
    verdigris leave the gamut furthest: linear red is -0.18 at a tenth of a coat.
    """
    return np.rint(255.0 * encode_srgb(np.clip(linear_rgb, 0.0, 1.0))).astype(np.uint8)


@lru_cache(maxsize=1)
def srgb_codes() -> AnyArray:
    """Return the sRGB codes (16384,) uint8 of evenly spaced linear values, <= 0.2 codes a step."""
    return srgb_from_linear(np.linspace(0.0, 1.0, 1 << 14))


def srgb_from_reflectance(spectra: ArrayLike) -> AnyArray:
    """uint8 sRGB (..., 3) of reflectance spectra (..., 31), gamut as in `srgb_from_linear`.

    Raises
    ------
    InputError
        If the last axis has not 31 values or one is not finite.
    """
    return srgb_from_linear(linear_rgb_from_reflectance(spectra))
