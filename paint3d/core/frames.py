"""Rigid transforms between frames.

A transform is named after both its frames: `world_from_object` carries coordinates in the
object's frame to coordinates in the world's, so that
``world_from_pen = world_from_object @ object_from_pen`` reads correctly from right to left.
Quaternions are (w, x, y, z), unit length; `q` and `-q` are the same rotation.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.types import AnyArray

__all__ = [
    "cross",
    "matrices_from_quaternions",
    "multiply_quaternions",
    "quaternions_from_matrices",
    "rotate",
    "slerp",
]


def matrices_from_quaternions(quaternions: AnyArray) -> AnyArray:
    """Rotation matrices (N, 3, 3) of unit quaternions (N, 4), w first."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, dtype=np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternions_from_matrices(matrices: AnyArray) -> AnyArray:
    """Unit quaternions (N, 4), w first and not negative, of rotation matrices (N, 3, 3)."""
    from scipy.spatial.transform import Rotation

    xyzw = Rotation.from_matrix(np.asarray(matrices, dtype=np.float64)).as_quat()
    wxyz = np.roll(xyzw, 1, axis=-1)
    result: AnyArray = np.where(wxyz[..., :1] < 0, -wxyz, wxyz)
    return result


def multiply_quaternions(a: AnyArray, b: AnyArray) -> AnyArray:
    """The rotation `b` followed by the rotation `a`; shapes (..., 4), w first."""
    aw, ax, ay, az = np.moveaxis(np.asarray(a, dtype=np.float64), -1, 0)
    bw, bx, by, bz = np.moveaxis(np.asarray(b, dtype=np.float64), -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def rotate(quaternions: AnyArray, vectors: AnyArray) -> AnyArray:
    """Rotate vectors (..., 3) by unit quaternions (..., 4), w first."""
    q = np.asarray(quaternions, dtype=np.float64)
    v = np.asarray(vectors, dtype=np.float64)
    u = q[..., 1:]
    t = 2.0 * cross(u, v)
    return v + q[..., :1] * t + cross(u, t)


def cross(u: AnyArray, v: AnyArray) -> AnyArray:
    """Cross products of vectors (..., 3), float64; for few of them faster than NumPy's own."""
    x = u[..., 1] * v[..., 2] - u[..., 2] * v[..., 1]
    y = u[..., 2] * v[..., 0] - u[..., 0] * v[..., 2]
    z = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    out = np.empty((*np.shape(x), 3))
    out[..., 0], out[..., 1], out[..., 2] = x, y, z
    return out


def slerp(a: AnyArray, b: AnyArray, fraction: AnyArray) -> AnyArray:
    """Interpolate along the shorter arc from `a` (..., 4) to `b` (..., 4); fraction in [0, 1]."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    t = np.asarray(fraction, dtype=np.float64)[..., None]
    dot = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(dot < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0))
    sine = np.sin(angle)
    small = sine < 1e-9
    sine = np.where(small, 1.0, sine)
    weight_a = np.where(small, 1.0 - t, np.sin((1.0 - t) * angle) / sine)
    weight_b = np.where(small, t, np.sin(t * angle) / sine)
    mixed = weight_a * a + weight_b * b
    result: AnyArray = mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)
    return result
