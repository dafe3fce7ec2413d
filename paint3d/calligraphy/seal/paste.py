"""Laying a seal's paste on a surface."""

from __future__ import annotations

from paint3d.calligraphy.seal.impression import Impression
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["lay_paste"]


def lay_paste(surface: PaintedSurface, left: Impression, parts: AnyArray) -> float:
    """Lay what a seal leaves on the layer that is painted on.

    What is wet below it dries first; the paste lies on it and does not run.

    Parameters
    ----------
    surface : PaintedSurface
    left : Impression
    parts : (P,) array
        Fractions of the surface's pigments in the paste, of sum 1.

    Returns
    -------
    float
        How much ink came onto the surface, coats x mm2.
    """
    before = surface.wet_ink() + surface.dry_ink()
    surface.settle(left.vertex_ids)
    surface.ink.amounts[left.vertex_ids] = left.coats[:, None] * parts
    surface.ink.coverage[left.vertex_ids] = left.coverage
    surface.settle(left.vertex_ids)
    return surface.wet_ink() + surface.dry_ink() - before
