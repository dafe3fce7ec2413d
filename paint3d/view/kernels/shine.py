"""What glaze mirrors of the lamps, vertex by vertex."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["add_shine"]

_STEPS = 2048  # of a cosine


@kernel(fastmath=True)
def add_shine(points, normals, colours, eye, lamps, power, share, out):
    """Write colours with the highlights of parallel lamps on them (Phong).

    Parameters
    ----------
    points, normals : (N, 3) float32
        Either side of a surface shines.
    colours : (N, 3) uint8
    eye : (3,) float64
        From where it is seen.
    lamps : (L, 6) float64
        The unit vector toward each lamp, and its light.
    power, share : float
        How narrow a highlight is, and how bright.
    out : (N, 3) uint8
        Written.
    """
    red_green_blue = np.empty(3)
    bright = 255.0 * share * (np.arange(_STEPS + 1) / _STEPS) ** power
    for i in range(points.shape[0]):
        vx, vy, vz = eye[0] - points[i, 0], eye[1] - points[i, 1], eye[2] - points[i, 2]
        away = 1.0 / np.sqrt(max(vx * vx + vy * vy + vz * vz, 1e-12))
        vx, vy, vz = vx * away, vy * away, vz * away
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        facing = nx * vx + ny * vy + nz * vz
        if facing < 0.0:
            nx, ny, nz, facing = -nx, -ny, -nz, -facing
        mx, my, mz = 2 * facing * nx - vx, 2 * facing * ny - vy, 2 * facing * nz - vz
        red_green_blue[:] = 0.0
        for k in range(lamps.shape[0]):
            x, y, z = lamps[k, 0], lamps[k, 1], lamps[k, 2]
            if nx * x + ny * y + nz * z > 0.0:
                at = int(max(0.0, min(1.0, mx * x + my * y + mz * z)) * _STEPS + 0.5)
                for c in range(3):
                    red_green_blue[c] += bright[at] * lamps[k, 3 + c]
        for c in range(3):
            out[i, c] = min(255, int(colours[i, c] + red_green_blue[c] + 0.5))
