"""Filling triangles of a texture with colours interpolated between their corners."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["fill_triangles"]

_ON_EDGE = 1e-9  # of a triangle: texels on an edge belong to both sides, so that none is missed


@kernel
def fill_triangles(places, faces, colours, image, filled):
    """Colour the texels whose middle lies in a triangle.

    Parameters
    ----------
    places : (N, 2) float64
        Of corners in the texture, texels; a texel's middle is at its place + 0.5.
    faces : (F, 3) int32
        The corners of triangles, turned either way; without area they are passed over.
    colours : (N, 3) uint8
        At the corners.
    image : (H, W, 3) uint8
        Filled in.
    filled : (H, W) uint8
        1 where a triangle has been.
    """
    height, width = filled.shape
    for face in range(len(faces)):
        a, b, c = faces[face]
        ax, ay = places[a]
        abx, aby = places[b, 0] - ax, places[b, 1] - ay
        acx, acy = places[c, 0] - ax, places[c, 1] - ay
        area = abx * acy - aby * acx
        if area == 0.0:
            continue
        x_low, x_high = min(0.0, abx, acx) + ax, max(0.0, abx, acx) + ax
        y_low, y_high = min(0.0, aby, acy) + ay, max(0.0, aby, acy) + ay
        first, last = max(0, math.ceil(x_low - 0.5)), min(width - 1, math.floor(x_high - 0.5))
        top, bottom = max(0, math.ceil(y_low - 0.5)), min(height - 1, math.floor(y_high - 0.5))
        for y in range(top, bottom + 1):
            for x in range(first, last + 1):
                px, py = x + 0.5 - ax, y + 0.5 - ay
                v = (px * acy - py * acx) / area
                w = (abx * py - aby * px) / area
                u = 1.0 - v - w
                if min(u, v, w) < -_ON_EDGE:
                    continue
                filled[y, x] = 1
                for band in range(3):
                    code = u * colours[a, band] + v * colours[b, band] + w * colours[c, band]
                    image[y, x, band] = np.uint8(min(max(code + 0.5, 0.0), 255.0))
