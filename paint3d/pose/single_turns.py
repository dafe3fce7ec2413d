"""Rotations of one thing at a time, in plain floats.

The same as `paint3d.core.frames`, which is for arrays and costs some 50 us a call however few they
are; these cost 1 to 2 us, and run a thousand times a second.
"""

from __future__ import annotations

import math

__all__ = ["Quaternion", "Vector", "multiply", "normalized", "slerp_one", "turn", "turn_by"]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_SMALL = 1e-9


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation `b` followed by the rotation `a`, w first."""
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
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


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
    """From `a` to `b` along the shorter arc; fraction in [0, 1]."""
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
