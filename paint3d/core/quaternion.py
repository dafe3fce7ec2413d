"""Rotations: unit quaternions (w, x, y, z), of one thing, of many, and in kernels.

A transform is named after both its frames: `world_from_object` carries coordinates in the
object's frame to coordinates in the world's, so that
``world_from_pen = world_from_object @ object_from_pen`` reads correctly from right to left.
`q` and `-q` are the same rotation.

The arithmetic is written once, on components. Plain floats go through it as they are, for what
turns one thing a thousand times a second: half a microsecond a call, where arrays take twenty
however few they are. Arrays (..., 4) go through it component by component, and kernels compile it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.kernel import kernel

__all__ = [
    "Quaternion",
    "Vector",
    "compiled_multiply",
    "compiled_relative",
    "compiled_turn",
    "compiled_turn_back",
    "compiled_x_axis",
    "compiled_y_axis",
    "compiled_z_axis",
    "matrices_from_quaternions",
    "multiply",
    "multiply_quaternions",
    "normalized",
    "quaternions_from_matrices",
    "rotate",
    "slerp",
    "slerp_one",
    "turn",
    "turn_by",
]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_SMALL = 1e-9  # rad, or sine of an angle

# -- by components ------------------------------------------------------------------------------


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation `b` followed by the rotation `a`."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def turn(q: Quaternion, v: Vector) -> Vector:
    """The vector `v` turned by the unit quaternion `q`."""
    w, x, y, z = q
    vx, vy, vz = v
    tx = 2.0 * (y * vz - z * vy)
    ty = 2.0 * (z * vx - x * vz)
    tz = 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + (y * tz - z * ty),
        vy + w * ty + (z * tx - x * tz),
        vz + w * tz + (x * ty - y * tx),
    )


def _x_axis(q: Quaternion) -> Vector:
    """Direction of the x axis after the rotation: the first column of its matrix."""
    w, x, y, z = q
    return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)


def _y_axis(q: Quaternion) -> Vector:
    """Direction of the y axis after the rotation."""
    w, x, y, z = q
    return 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)


def _z_axis(q: Quaternion) -> Vector:
    """Direction of the z axis after the rotation."""
    w, x, y, z = q
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


# -- of one thing -------------------------------------------------------------------------------


def turn_by(angles: Vector) -> Quaternion:
    """The quaternion of a rotation vector, rad."""
    x, y, z = angles
    angle = math.sqrt(x * x + y * y + z * z)
    share = 0.5 if angle < _SMALL else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), share * x, share * y, share * z


def normalized(q: Quaternion) -> Quaternion:
    """The unit quaternion along `q`."""
    w, x, y, z = q
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * scale, x * scale, y * scale, z * scale


def slerp_one(a: Quaternion, b: Quaternion, fraction: float) -> Quaternion:
    """`slerp` of two quaternions."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    sign = -1.0 if dot < 0.0 else 1.0
    angle = math.acos(min(1.0, abs(dot)))
    sine = math.sin(angle)
    if sine < _SMALL:
        one, other = 1.0 - fraction, fraction * sign
    else:
        one = math.sin((1.0 - fraction) * angle) / sine
        other = sign * math.sin(fraction * angle) / sine
    return normalized(
        (
            one * a[0] + other * b[0],
            one * a[1] + other * b[1],
            one * a[2] + other * b[2],
            one * a[3] + other * b[3],
        )
    )


# -- of many ------------------------------------------------------------------------------------


def _components(array: AnyArray) -> Any:
    values = np.asarray(array, dtype=np.float64)
    return [values[..., k] for k in range(values.shape[-1])]


def _together(components: Any) -> AnyArray:
    """Components (...) as one array (..., K); `numpy.stack` takes thrice as long for few."""
    out = np.empty((*np.shape(components[0]), len(components)))
    for k, component in enumerate(components):
        out[..., k] = component
    return out


def multiply_quaternions(a: AnyArray, b: AnyArray) -> AnyArray:
    """The rotation `b` followed by the rotation `a`; shapes (..., 4)."""
    return _together(multiply(_components(a), _components(b)))


def rotate(quaternions: AnyArray, vectors: AnyArray) -> AnyArray:
    """Rotate vectors (..., 3) by unit quaternions (..., 4)."""
    return _together(turn(_components(quaternions), _components(vectors)))


def matrices_from_quaternions(quaternions: AnyArray) -> AnyArray:
    """Rotation matrices (N, 3, 3) of unit quaternions (N, 4)."""
    q = _components(quaternions)
    axes = [np.stack(axis(q), axis=-1) for axis in (_x_axis, _y_axis, _z_axis)]
    return np.stack(axes, axis=-1)


def quaternions_from_matrices(matrices: AnyArray) -> AnyArray:
    """Unit quaternions (..., 4), w first and not negative, of rotation matrices (..., 3, 3).

    A matrix that is not quite a rotation is taken for the nearest one.
    """
    from scipy.spatial.transform import Rotation  # which takes long to load

    given = np.asarray(matrices, dtype=np.float64)
    xyzw = Rotation.from_matrix(given.reshape(-1, 3, 3)).as_quat()
    wxyz = xyzw[:, [3, 0, 1, 2]]
    result: AnyArray = np.where(wxyz[:, :1] < 0, -wxyz, wxyz).reshape(*given.shape[:-2], 4)
    return result


def slerp(a: AnyArray, b: AnyArray, fraction: AnyArray) -> AnyArray:
    """Interpolate along the shorter arc from `a` (..., 4) to `b` (..., 4); fraction in [0, 1]."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    t = np.asarray(fraction, dtype=np.float64)[..., None]
    dot = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(dot < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0))
    sine = np.sin(angle)
    small = sine < _SMALL
    sine = np.where(small, 1.0, sine)
    weight_a = np.where(small, 1.0 - t, np.sin((1.0 - t) * angle) / sine)
    weight_b = np.where(small, t, np.sin(t * angle) / sine)
    mixed = weight_a * a + weight_b * b
    result: AnyArray = mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)
    return result


# -- in kernels: tuples of four, or arrays ------------------------------------------------------

compiled_x_axis, compiled_y_axis, compiled_z_axis = map(kernel, (_x_axis, _y_axis, _z_axis))
_turn, compiled_multiply = kernel(turn), kernel(multiply)


@kernel
def compiled_turn(q, x, y, z):  # type: ignore[no-untyped-def]
    """(x, y, z) turned by the unit quaternion q (4,)."""
    return _turn((q[0], q[1], q[2], q[3]), (x, y, z))


@kernel
def compiled_turn_back(q, x, y, z):  # type: ignore[no-untyped-def]
    """(x, y, z) turned by the inverse of the unit quaternion q (4,)."""
    return _turn((q[0], -q[1], -q[2], -q[3]), (x, y, z))


@kernel
def compiled_relative(a, b, out):  # type: ignore[no-untyped-def]
    """inverse(a) b of two quaternions (4,)."""
    inverse, other = (a[0], -a[1], -a[2], -a[3]), (b[0], b[1], b[2], b[3])
    out[0], out[1], out[2], out[3] = compiled_multiply(inverse, other)
