"""The grain of a surface: smooth noise in space, by which paper's pores vary from place to place.

Value noise (random numbers on a lattice, blended between) of a hash of the place alone: no seed and
no state, so a painting is repeatable, and two meshings of one object have the same grain.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import mix

__all__ = ["fill_grain"]

_TURN = (  # thirds: so that the lattice lies along no side of a flat sheet
    (2.0, -1.0, 2.0),
    (2.0, 2.0, -1.0),
    (-1.0, 2.0, 2.0),
)


@uncounted
def _corner(i, j, k):
    """A number in [0, 1) for a lattice point."""
    code = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15)
    code ^= mix(np.uint64(j) + np.uint64(0xD1B54A32D192ED03))
    code ^= mix(mix(np.uint64(k) + np.uint64(0x8CB92BA72F3D8DD7)))
    return np.float64(mix(code) >> np.uint64(11)) * 2.0**-53


@uncounted
def _noise(x, y, z):
    """Value noise in [0, 1] with lattice points at whole numbers."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    u, v, w = x - i, y - j, z - k
    u = u * u * (3.0 - 2.0 * u)
    v = v * v * (3.0 - 2.0 * v)
    w = w * w * (3.0 - 2.0 * w)
    total = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                total += weight * _corner(i + a, j + b, k + c)
    return total


@uncounted
def _grain_at(x, y, z, length):
    """Height of the grain at a place (mm), 0 to 1, mean 1/2: bumps of `length` mm and half that."""
    length *= 3.0
    a = (_TURN[0][0] * x + _TURN[0][1] * y + _TURN[0][2] * z) / length
    b = (_TURN[1][0] * x + _TURN[1][1] * y + _TURN[1][2] * z) / length
    c = (_TURN[2][0] * x + _TURN[2][1] * y + _TURN[2][2] * z) / length
    return 0.67 * _noise(a, b, c) + 0.33 * _noise(2.0 * c + 7.3, 2.0 * a + 1.9, 2.0 * b + 4.1)


@uncounted
def fill_grain(points, length, out):
    """`_grain_at` of points (N, 3)."""
    for n in range(points.shape[0]):
        out[n] = _grain_at(points[n, 0], points[n, 1], points[n, 2], length)
