"""How wet a surface looks: smoother and darker under water, as matt as dried ink where that lies.

Water that stands above the pores is a film with a smooth surface; what is only damp is as rough as
before, and darker: light that comes out of it is thrown back by the water's surface and passes what
absorbs once more (Angstrom 1925; Lekner, Dorf, Appl. Opt. 27, 1278, 1988).
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
    "damp_share",
    "darkened",
    "film_share",
    "shine_of_inks",
]

FILM_ROUGHNESS = 0.08
"""Of water's surface, which follows what it stands on a little; set by eye."""
MATT_ROUGHNESS = 0.6
"""Of a dried ink without gloss, on what is smoother; on what is rougher it is as rough as that."""
_FILM_MM = 0.004  # of water above the pores, that smooths two thirds of their tooth; set by eye
_DRIED = 0.25  # roughness of an ink that dries as glossily as can be
_THROWN_BACK = 0.472
"""Share of diffuse light that water's surface throws back inside: 1 - (1 - .066) / 1.333^2."""


class WetLook(NamedTuple):
    """How the V vertices of a surface look beside what they are made of.

    Attributes
    ----------
    film : (V,) float32
        How smooth a film of water makes them, 0 to 1.
    damp : (V,) float32
        How much of the pores, or of the surface, is under water, 0 to 1.
    gloss : (V,) float32
        Of the inks that have dried, 0 to 1, times the share that they hide.
    hidden : (V,) float32
        How much of the material the inks hide when they are dry, 0 to 1.
    """

    film: NDArray[np.float32]
    damp: NDArray[np.float32]
    gloss: NDArray[np.float32]
    hidden: NDArray[np.float32]

    def roughness(self, material: float) -> NDArray[np.float32]:
        """(V,) float32 roughness, on a material of this one.

        An ink that hides everything has .6 or the material's, whichever is more; of gloss 1 .25.
        A film of water leaves .08.
        """
        dry = _dry_roughness(material, self.gloss, self.hidden)
        rough: NDArray[np.float32] = dry - self.film * np.maximum(dry - FILM_ROUGHNESS, 0.0)
        return rough.astype(np.float32)

    def seen(self, srgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Codes (V, 3) by those of the dry surface: darker where it is wet."""
        codes, ids = srgb.copy(), np.flatnonzero(self.damp)
        codes[ids] = darkened(codes[ids], self.damp[ids])
        return codes

    def at(self, ids: AnyArray) -> WetLook:
        """The same of some vertices (N,)."""
        return WetLook(*(shares[ids] for shares in self))


def _dry_roughness(material: float, gloss: AnyArray, hidden: AnyArray) -> AnyArray:
    matt = max(material, MATT_ROUGHNESS)
    dry: AnyArray = material + hidden * (matt - material) - gloss * max(matt - _DRIED, 0.0)
    return dry


def shine_of_inks(material: float, gloss: AnyArray, hidden: AnyArray) -> AnyArray:
    """How dried inks shine beside a material of this roughness (N,), by `WetLook`'s shares (N,).

    From -1, as matt as ink without gloss, over 0, as the material, to 1, as a film of water.
    """
    if material >= MATT_ROUGHNESS:
        return gloss
    more = material - _dry_roughness(material, gloss, hidden)
    shine: AnyArray = np.clip(more / (MATT_ROUGHNESS - material), -1.0, 1.0)
    return shine


def film_share(depth_mm: AnyArray, pores_mm: float) -> AnyArray:
    """How smooth a film of water makes the surface (N,), 0 to 1; depth (N,), pores included."""
    shares: AnyArray = 1.0 - np.exp(-np.maximum(depth_mm - pores_mm, 0.0) / _FILM_MM)
    return shares


def damp_share(depth_mm: AnyArray, pores_mm: float) -> AnyArray:
    """How much of the pores is full of water (N,), 0 to 1; without pores, how much is covered."""
    if pores_mm > 0.0:
        full: AnyArray = np.clip(depth_mm / pores_mm, 0.0, 1.0)
        return full
    return film_share(depth_mm, 0.0)


def darkened(srgb: NDArray[np.uint8], damp: AnyArray) -> NDArray[np.uint8]:
    """Codes (N, 3) of a surface that is damp (N,), 0 to 1, by its codes when it is dry.

    R (1 - p) / (1 - p R), channel by channel, with p = .472 times the share that is under water.
    The codes may be those of any gamut.
    """
    linear = decode_srgb(srgb)
    thrown = _THROWN_BACK * np.asarray(damp)[:, None]
    seen = linear * (1.0 - thrown) / (1.0 - thrown * linear)
    return np.rint(255.0 * encode_srgb(seen)).astype(np.uint8)
