"""A hand's way in the object's frame, sample by sample: where strokes begin, and its tangents."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import uncounted
from paint3d.core.quaternion import compiled_multiply, compiled_turn_back

__all__ = ["carry_points", "carry_to_object", "fill_tangents", "join_samples"]

_MAX_CURVED_GAP_S = 0.1  # longer intervals are straight lines (two periods of a 20 Hz device)
_STEEPEST = 3.0  # tangents of at most three chord speeds cannot overshoot (Fritsch, Carlson 1980)


@uncounted(error_model="numpy")
def carry_points(points, object_position, object_orientation, out):
    """Carry points (N, 3) of the world, one a sample, into the object's frame at that sample."""
    for k in range(points.shape[0]):
        o = object_orientation[k]
        out[k, 0], out[k, 1], out[k, 2] = compiled_turn_back(
            (o[0], o[1], o[2], o[3]),
            points[k, 0] - object_position[k, 0],
            points[k, 1] - object_position[k, 1],
            points[k, 2] - object_position[k, 2],
        )


@uncounted(error_model="numpy")
def carry_to_object(orientation, object_orientation, out):
    """Turn the pen's orientations (N, 4) in the world into unit quaternions in the object's."""
    for k in range(orientation.shape[0]):
        o, p = object_orientation[k], orientation[k]
        w, x, y, z = compiled_multiply((o[0], -o[1], -o[2], -o[3]), (p[0], p[1], p[2], p[3]))
        length = np.sqrt(w * w + x * x + y * y + z * z)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = w / length, x / length, y / length, z / length


@uncounted
def join_samples(pressure, has_contact, out):
    """Fill which samples (N,) are joined by a stroke to the one before: see `joined_samples`.

    `pressure` (N,) is NaN where the device has none.
    """
    out[0] = False
    for k in range(1, pressure.shape[0]):
        lifted = pressure[k] <= 0.0 and pressure[k - 1] <= 0.0
        out[k] = not lifted and has_contact[k] == has_contact[k - 1]


@uncounted(error_model="numpy")
def _chord(time, way, joined, i):
    """Velocity from sample i to the next, and how long that takes; 1 s where it is not joined."""
    step = time[i + 1] - time[i] if joined[i + 1] else 1.0
    x, y, z = way[i + 1, 0] - way[i, 0], way[i + 1, 1] - way[i, 1], way[i + 1, 2] - way[i, 2]
    return x / step, y / step, z / step, step


@uncounted(error_model="numpy")
def _is_curved(time, joined, i):
    """Whether the stroke curves between sample i and the next; False beyond the ends."""
    if i < 0 or i + 1 >= time.shape[0] or not joined[i + 1]:
        return False
    return time[i + 1] - time[i] <= _MAX_CURVED_GAP_S


@uncounted(error_model="numpy")
def _end_tangent(time, way, joined, near, far):
    """Tangent at the end of a curved run, from its last chord and the one beyond, if there is."""
    ax, ay, az, step = _chord(time, way, joined, near)
    if not _is_curved(time, joined, far):
        return ax, ay, az
    bx, by, bz, other = _chord(time, way, joined, far)
    weight = step / (step + other)
    return ax + (ax - bx) * weight, ay + (ay - by) * weight, az + (az - bz) * weight


@uncounted(error_model="numpy")
def _tangent(time, way, joined, i):
    """Tangent at sample i, before it is limited."""
    last = time.shape[0] - 1
    left, right = _is_curved(time, joined, i - 1), _is_curved(time, joined, i)
    straight_in = i > 0 and joined[i] and not left
    straight_out = i < last and joined[i + 1] and not right
    if straight_in and straight_out:
        return 0.0, 0.0, 0.0
    if straight_in or straight_out:
        x, y, z, _ = _chord(time, way, joined, i if straight_out else i - 1)
        return x, y, z
    if left and right:  # each chord is weighted by the other's duration
        ax, ay, az, a = _chord(time, way, joined, i - 1)
        bx, by, bz, b = _chord(time, way, joined, i)
        total = b + a
        return (b * ax + a * bx) / total, (b * ay + a * by) / total, (b * az + a * bz) / total
    if right:
        return _end_tangent(time, way, joined, i, i + 1)
    if left:
        return _end_tangent(time, way, joined, i - 1, i - 2)
    return 0.0, 0.0, 0.0


@uncounted(error_model="numpy")
def fill_tangents(time, way, joined, out):
    """Fill the tangents (N, 3) of the cubics along a way: see `velocities`."""
    n = time.shape[0]
    for i in range(n):
        x, y, z = _tangent(time, way, joined, i)
        slowest = np.inf
        for k in range(max(0, i - 1), min(i, n - 2) + 1):
            if joined[k + 1]:
                cx, cy, cz, _ = _chord(time, way, joined, k)
                slowest = min(slowest, np.sqrt(cx * cx + cy * cy + cz * cz))
        length = np.sqrt(x * x + y * y + z * z)
        factor = _STEEPEST * slowest / length if length > _STEEPEST * slowest else 1.0
        out[i, 0], out[i, 1], out[i, 2] = factor * x, factor * y, factor * z
