"""Single rotations inside kernels: quaternions are arrays (4,), w first; vectors three numbers."""

from __future__ import annotations

from paint3d.core.kernel import kernel

__all__ = ["relative", "turn", "turn_back"]


@kernel
def turn(q, x, y, z):
    """(x, y, z) turned by the unit quaternion q."""
    tx = 2.0 * (q[2] * z - q[3] * y)
    ty = 2.0 * (q[3] * x - q[1] * z)
    tz = 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@kernel
def turn_back(q, x, y, z):
    """(x, y, z) turned by the inverse of the unit quaternion q."""
    tx = 2.0 * (q[3] * y - q[2] * z)
    ty = 2.0 * (q[1] * z - q[3] * x)
    tz = 2.0 * (q[2] * x - q[1] * y)
    return (
        x + q[0] * tx + q[3] * ty - q[2] * tz,
        y + q[0] * ty + q[1] * tz - q[3] * tx,
        z + q[0] * tz + q[2] * tx - q[1] * ty,
    )


@kernel
def relative(a, b, out):
    """inverse(a) b of two quaternions."""
    out[0] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    out[1] = a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2]
    out[2] = a[0] * b[2] + a[1] * b[3] - a[2] * b[0] - a[3] * b[1]
    out[3] = a[0] * b[3] - a[1] * b[2] + a[2] * b[1] - a[3] * b[0]
