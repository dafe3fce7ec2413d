"""Edges of paint between vertices, as sharp as the picture: what vertices give to shaders.

Vertices stand a resolution apart, and an edge drawn by interpolating their colours is a ramp as
wide, with the mesh's triangles in it. But the share of a vertex's area that paint covers tells
where between them it ends: where the interpolated share is half. A shader that knows it draws the
edge two pixels wide at any scale, as letters are drawn from distance fields (Green, Improved
alpha-tested magnification for vector textures and special effects, 2007).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["LEAST", "MIXED", "SHARPENED", "UNPACKED", "Edges", "edge_shares", "packed"]

MIXED = 0.6  # of the neighbours in a vertex's share: shares alone end within one edge's length
LEAST = 1.5  # over the largest share around: a line thinner than the mesh is still drawn


class Edges(NamedTuple):
    """What a shader needs besides each vertex's colour.

    Attributes
    ----------
    bare : (V, 3) uint8
        sRGB without any paint.
    shares : (V, 2) uint8
        Codes of the share that is half where paint ends, and of the share that is painted.
    """

    bare: NDArray[np.uint8]
    shares: NDArray[np.uint8]

    def at(self, ids: AnyArray) -> Edges:
        """Return those of some vertices (N,)."""
        return Edges(self.bare[ids], self.shares[ids])


def edge_shares(faces: AnyArray, painted: AnyArray) -> NDArray[np.uint8]:
    """Return the shares (V, 2) of `Edges` on triangles (F, 3).

    Parameters
    ----------
    faces : (F, 3) int
    painted : (V,) uint8
        Share of each vertex's area that is under paint, 255: all.
    """
    n = len(painted)
    total, counts = np.zeros(n), np.zeros(n)
    for k in range(3):
        beside = painted[faces[:, k - 1]].astype(np.float64) + painted[faces[:, k - 2]]
        total += np.bincount(faces[:, k], beside, n)
        counts += 2.0 * np.bincount(faces[:, k], minlength=n)
    mean = np.where(counts > 0.0, total / np.maximum(counts, 1.0), painted)
    smooth = ((1.0 - MIXED) * painted + MIXED * mean) / 255.0
    top, of_face = smooth.copy(), smooth[faces].max(axis=1)
    for k in range(3):
        np.maximum.at(top, faces[:, k], of_face)
    share = smooth / np.clip(LEAST * top, 1e-9, 1.0)
    sharp = (255.0 * np.minimum(share, 1.0) + 0.5).astype(np.uint8)
    return np.stack([sharp, painted], axis=1)


def packed(codes: AnyArray) -> NDArray[np.float32]:
    """Return codes (N, 2 or 3) uint8 as a number (N, 1) each: VTK sends bytes as floats anyway."""
    number = codes[:, 0].astype(np.float32)
    for column in codes.T[1:]:
        number = number * np.float32(256.0) + column
    return number[:, None]


UNPACKED = """
vec3 unpacked(float number) {
  vec3 codes = floor(vec3(number / 65536.0, number / 256.0, number));
  return (codes - 256.0 * vec3(0.0, codes.xy)) / 255.0;
}
"""
"""GLSL: three codes, 0 to 1, from what `packed` returns; of two the last two."""

_WIDE = 1.5  # pixels from bare to painted
SHARPENED = f"""
// How wide an edge is, in shares, where the first of them changes by `slope` a pixel.
float edge_width(vec2 slope) {{ return {_WIDE:.1f} * length(slope); }}

// The light where `bare` is that without paint and `ink` what paint adds to it, all interpolated.
vec3 sharpened(vec3 bare, vec3 ink, vec2 shares, float wide) {{
  float drawn = clamp((shares.x - 0.5) / clamp(wide, 0.02, 1.0) + 0.5, 0.0, 1.0);
  vec3 light = max(bare + ink * (drawn / max(shares.y, 0.08)), 0.0);
  float mean = dot(light, vec3(1.0 / 3.0)); // of dark ink the codes of its edge tell no hue
  return mix(vec3(mean), light, min(mean / 0.03, 1.0));
}}

// Which part of it is shown, the rest as interpolated: none from afar, nor where there is no edge.
float edge_part(vec2 shares, float wide) {{
  return shares.x > 0.002 && shares.x < 0.998 ? 1.0 - smoothstep(0.5, 1.0, wide) : 0.0;
}}
"""
"""GLSL functions."""
