"""The ink in the brush, as it is told and shown: which inks, how much, and their colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.pigments import WATER, Pigment
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.core.arrays import AnyArray
from paint3d.painter.painter import Painter

__all__ = ["DISH", "HAIR", "HeldInk", "held_ink", "ink_srgb"]

DISH = np.full(31, 0.9)
"""Reflectance of white porcelain."""

HAIR = np.linspace(0.42, 0.62, 31)
"""Reflectance of a brush's dry hair."""

_LEAST = 5e-3  # of what is held: less is told by nobody


@dataclass(frozen=True, eq=False)
class HeldInk:
    """What a brush holds.

    Attributes
    ----------
    parts : tuple of (Pigment, float)
        Shares of what it holds, of sum 1, the most first; empty for an empty brush.
    share : float
        Of a full load, 0 to 1.
    bands : tuple of (int, int, int)
        sRGB of the ink along the tuft as in a dish, the tip's first; one where it is alike.
    """

    parts: tuple[tuple[Pigment, float], ...]
    share: float
    bands: tuple[tuple[int, int, int], ...]


def held_ink(painter: Painter) -> HeldInk:
    """What the brush of a painter holds now; may be asked while it paints."""
    ink, pigments = painter.surface.ink, tuple(painter.surface.pigments)
    load, reservoirs = np.maximum(ink.load, 0.0), np.maximum(ink.reservoirs, 0.0)
    total = float(load.sum())
    if total <= 0.0 or len(load) > len(pigments):
        return HeldInk((), 0.0, ())
    along = reservoirs if len(reservoirs) > 1 else load[None]
    shares = along / np.maximum(along.sum(axis=1, keepdims=True), 1e-30)
    bands = [ink_srgb(pigments, tuple(np.round(part, 3))) for part in shares]
    parts = sorted(zip(pigments, load / total, strict=False), key=lambda part: -part[1])
    told = tuple((pigment, float(share)) for pigment, share in parts if share > _LEAST)
    return HeldInk(told, min(1.0, total / painter.tuft.load), tuple(dict.fromkeys(bands)))


@lru_cache(maxsize=256)
def ink_srgb(
    pigments: tuple[Pigment, ...], parts: Sequence[float], on_hair: bool = False
) -> tuple[int, int, int]:
    """sRGB of a coat of mixed inks in a dish, or on hair; water lets through what is behind.

    Parameters
    ----------
    pigments : tuple of Pigment (P)
    parts : tuple of float (P)
        Shares of sum 1; all 0 for none.
    on_hair : bool
    """
    inked: dict[str | Pigment, float]
    inked = {p: w for p, w in zip(pigments, parts, strict=False) if w > 0.0 and p is not WATER}
    shown: AnyArray = HAIR if on_hair else DISH
    if inked:
        shown = mixture_reflectance(inked, sum(inked.values()), shown)
    red, green, blue = (int(code) for code in srgb_from_reflectance(shown))
    return red, green, blue
