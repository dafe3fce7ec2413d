"""What glaze mirrors of the lamps, vertex by vertex."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["add_shine"]

_STEPS = 2048  # of a cosine


@kernel(fastmath=True)
def add_shine(points, normals, colours, eye, lamps, lobes, plain, out):
    """Write colours with the highlights of parallel lamps on them (Phong).

    Parameters
    ----------
    points, normals : (N, 3) float32
        Either side of a surface shines.
    colours : (N, 4) uint8
        The fourth says how each shines: `plain` as the first lobe, 255 as the second, 1 as the
        third, and between them as fractions of both.
    eye : (3,) float64
        From where it is seen.
    lamps : (L, 6) float64
        The unit vector toward each lamp, and its light.
    lobes : (3, 2) float64
        How narrow the highlight of each is (the exponent of a cosine), and how bright.
    plain : int
    out : (N, 4) uint8
        Written; the fourth is 255.
    """
    red_green_blue = np.empty(3)
    bright = np.empty((3, _STEPS + 1))
    for k in range(3):
        bright[k] = 255.0 * lobes[k, 1] * (np.arange(_STEPS + 1) / _STEPS) ** lobes[k, 0]
    for i in range(points.shape[0]):
        vx, vy, vz = eye[0] - points[i, 0], eye[1] - points[i, 1], eye[2] - points[i, 2]
        away = 1.0 / np.sqrt(max(vx * vx + vy * vy + vz * vz, 1e-12))
        vx, vy, vz = vx * away, vy * away, vz * away
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        facing = nx * vx + ny * vy + nz * vz
        if facing < 0.0:
            nx, ny, nz, facing = -nx, -ny, -nz, -facing
        mx, my, mz = 2 * facing * nx - vx, 2 * facing * ny - vy, 2 * facing * nz - vz
        shine = (colours[i, 3] - plain) / (255.0 - plain)
        other, part = (1, shine) if shine > 0.0 else (2, -shine)
        red_green_blue[:] = 0.0
        for k in range(lamps.shape[0]):
            x, y, z = lamps[k, 0], lamps[k, 1], lamps[k, 2]
            if nx * x + ny * y + nz * z > 0.0:
                at = int(max(0.0, min(1.0, mx * x + my * y + mz * z)) * _STEPS + 0.5)
                light = bright[0, at] + part * (bright[other, at] - bright[0, at])
                for c in range(3):
                    red_green_blue[c] += light * lamps[k, 3 + c]
        out[i, 3] = 255
        for c in range(3):
            out[i, c] = min(255, int(colours[i, c] + red_green_blue[c] + 0.5))
