"""Roughness and colour of wet surfaces and of dried inks.

Water that stands above the pores is a film with a smooth surface. A surface that is only damp is as
rough as before, and darker: the water's surface reflects some of the outgoing light back in, where
it is absorbed once more (Angstrom 1925; Lekner, Dorf, Appl. Opt. 27, 1278, 1988).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.spectra import decode_srgb, encode_srgb
from paint3d.core.arrays import AnyArray

__all__ = [
    "FILM_ROUGHNESS",
    "MATT_ROUGHNESS",
    "WetLook",
    "damp_fraction",
    "darkened",
    "film_fraction",
    "shine_of_inks",
]

FILM_ROUGHNESS = 0.08
"""Of water's surface, which follows the surface below a little; set by eye."""
MATT_ROUGHNESS = 0.6
"""Of a dried ink without gloss on a smoother material; on a rougher one it is as rough as that."""
_FILM_MM = 0.004  # of water above the pores smooths two thirds of their tooth; set by eye
_DRIED = 0.25  # roughness of a dried ink of gloss 1
_REFLECTED = 0.472
"""Internal diffuse reflectance of water's surface: 1 - (1 - .066) / 1.333^2."""


class WetLook(NamedTuple):
    """Water and dried inks on the V vertices of a surface, as far as they change its look.

    Attributes
    ----------
    film : (V,) float32
        Smoothing by a film of water, 0 to 1.
    damp : (V,) float32
        Fraction of the pores, or of the surface, that is under water, 0 to 1.
    gloss : (V,) float32
        Gloss of the dried inks, 0 to 1, times the fraction that they hide.
    hidden : (V,) float32
        Fraction of the material that the inks hide when they are dry, 0 to 1.
    """

    film: NDArray[np.float32]
    damp: NDArray[np.float32]
    gloss: NDArray[np.float32]
    hidden: NDArray[np.float32]

    def roughness(self, material: float) -> NDArray[np.float32]:
        """(V,) float32 roughness, on a material of roughness `material`.

        An ink that hides everything has .6 or the material's, whichever is more; of gloss 1 .25.
        A film of water leaves .08.
        """
        dry = _dry_roughness(material, self.gloss, self.hidden)
        rough: NDArray[np.float32] = dry - self.film * np.maximum(dry - FILM_ROUGHNESS, 0.0)
        return rough.astype(np.float32)

    def seen(self, srgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Codes (V, 3) of the wet surface from those of the dry one: darker where it is damp."""
        codes, ids = srgb.copy(), np.flatnonzero(self.damp)
        codes[ids] = darkened(codes[ids], self.damp[ids])
        return codes

    def at(self, ids: AnyArray) -> WetLook:
        """The look of some of the vertices, (N,)."""
        return WetLook(*(array[ids] for array in self))


def _dry_roughness(material: float, gloss: AnyArray, hidden: AnyArray) -> AnyArray:
    """Roughness (N,) without a film of water."""
    matt = max(material, MATT_ROUGHNESS)
    dry: AnyArray = material + hidden * (matt - material) - gloss * max(matt - _DRIED, 0.0)
    return dry


def shine_of_inks(material: float, gloss: AnyArray, hidden: AnyArray) -> AnyArray:
    """Shine (N,) of dried inks beside a material of this roughness; gloss, hidden of `WetLook`.

    -1 is as matt as ink without gloss, 0 as the material, 1 as a film of water.
    """
    if material >= MATT_ROUGHNESS:
        return gloss
    more = material - _dry_roughness(material, gloss, hidden)
    shine: AnyArray = np.clip(more / (MATT_ROUGHNESS - material), -1.0, 1.0)
    return shine


def film_fraction(depth_mm: AnyArray, pores_mm: float) -> AnyArray:
    """Smoothing (N,) by a film of water, 0 to 1; depth (N,) with the water in the pores."""
    smoothing: AnyArray = 1.0 - np.exp(-np.maximum(depth_mm - pores_mm, 0.0) / _FILM_MM)
    return smoothing


def damp_fraction(depth_mm: AnyArray, pores_mm: float) -> AnyArray:
    """Fraction (N,) of the pores filled with water, 0 to 1; without pores, of the surface."""
    if pores_mm > 0.0:
        full: AnyArray = np.clip(depth_mm / pores_mm, 0.0, 1.0)
        return full
    return film_fraction(depth_mm, 0.0)


def darkened(srgb: NDArray[np.uint8], damp: AnyArray) -> NDArray[np.uint8]:
    """Codes (N, 3) of a damp surface, `damp` (N,) 0 to 1, from those of the dry one.

    R (1 - p) / (1 - p R), channel by channel, with p = .472 times the fraction that is under water.
    The codes may be those of any gamut.
    """
    linear = decode_srgb(srgb)
    p = _REFLECTED * np.asarray(damp)[:, None]
    seen = linear * (1.0 - p) / (1.0 - p * linear)
    return np.rint(255.0 * encode_srgb(seen)).astype(np.uint8)
