"""Cached previews: a brush's stroke on a small sheet, and mixtures of inks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.spec import BrushSpec
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, Pigment, load_pigment
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.core.arrays import AnyArray
from paint3d.view.brush_shape import draw_stroke

__all__ = ["Ink", "ink_coat", "ink_swatch", "sorted_parts", "stroke_preview"]

Ink = str | Pigment
_WASH = (("pine soot", 0.02), (WATER.name, 0.98))


def stroke_preview(brush: BrushSpec, ink: Ink | Mapping[Ink, float]) -> NDArray[np.uint8]:
    """Draw one stroke from left to right, pressed twice and lifted slowly: (H, W, 3) uint8.

    Cost: 0.1 s the first time; kept for the last brushes and inks.

    Parameters
    ----------
    brush : BrushSpec
    ink : str, Pigment, or mapping of these to parts
        By name from the palette, or an ink itself, as one that was picked up from the object.
        Clear water, which leaves nothing, is drawn as a wash that shows what the brush wets.
    """
    parts = sorted_parts(ink)
    is_clear = all(_name(part) == WATER.name for part, _ in parts)
    return _cached_stroke(brush, _WASH if is_clear else parts)


def sorted_parts(ink: Ink | Mapping[Ink, float]) -> tuple[tuple[Ink, float], ...]:
    """Return inks and their parts, sorted by name."""
    parts = ink if isinstance(ink, Mapping) else {ink: 1.0}
    return tuple(sorted(parts.items(), key=lambda part: _name(part[0])))


def _name(ink: Ink) -> str:
    return ink if isinstance(ink, str) else ink.name


@lru_cache(maxsize=128)
def _cached_stroke(brush: BrushSpec, parts: tuple[tuple[Ink, float], ...]) -> AnyArray:
    pixels = draw_stroke(brush, dict(parts))
    pixels.setflags(write=False)
    return pixels


@lru_cache(maxsize=512)
def ink_swatch(parts: tuple[tuple[Ink, float], ...], n: int = 24) -> NDArray[np.uint8]:
    """Return a mixture's colours on paper, (n, 3) uint8, from a thin wash to the darkest."""
    from paint3d.colour.vertex_colours import ColourModel

    pigments = [load_pigment(ink) if isinstance(ink, str) else ink for ink, _ in parts]
    weights = np.array([fraction for _, fraction in parts], np.float64)
    coats = np.geomspace(0.03, 2.0, n)
    amounts = (coats[:, None] * (weights / weights.sum())).astype(np.float32)
    model = ColourModel(pigments, load_material("xuan").reflectance)
    out = np.empty((n, 3), np.uint8)
    return model.srgb(np.ascontiguousarray(amounts), np.ones(n, np.float32), out)


def ink_coat(parts: Mapping[Ink, float]) -> tuple[int, int, int]:
    """Return the sRGB of a coat of a mixture with water on xuan; without ink, of the sheet."""
    inked = {
        ink: fraction for ink, fraction in parts.items() if ink is not WATER and ink != WATER.name
    }
    sheet = load_material("xuan").reflectance
    total = sum(parts.values())
    shown = sheet
    if inked:
        coats = sum(inked.values()) / total
        shown = mixture_reflectance(inked, coats, sheet, by_volume=True)
    red, green, blue = (int(code) for code in srgb_from_reflectance(shown))
    return red, green, blue
