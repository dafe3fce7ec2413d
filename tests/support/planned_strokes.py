"""Strokes to plan, and slow, obvious measures of how a plan covers them."""

import math

import numpy as np

from paint3d.calligraphy.kernels import planning as kernels

EM = 20.0


def band(angle, length, width, bend=0.0):
    """A stroke of even width with pointed ends, as (outline, median), mm."""
    t = np.linspace(0.0, 1.0, 41)
    heading = angle + bend * (t - 0.5)
    step = length / 40 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    median = np.array([10.0, 10.0]) + np.cumsum(step, axis=0) - step.sum(axis=0) / 2
    half = 0.5 * width * np.minimum(1.0, 6.0 * np.minimum(t, 1.0 - t) + 0.15)[:, None]
    normal = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
    return np.concatenate([median + half * normal, (median - half * normal)[::-1]]), median


def boundary(path, steps, i):
    """Boundary points (B, 2) of the footprint of pose i on paper."""
    k = min(int(path.level[i]), len(steps.points) - 2)
    t = path.level[i] - k
    shape = (1 - t) * steps.points[k] + t * steps.points[k + 1]
    c, s = math.cos(path.azimuth[i]), math.sin(path.azimuth[i])
    return path.centre[i] + shape @ np.array([[c, s], [-s, c]])


def signed_distance(polygon, points):
    """Slow and obvious: distance to the nearest edge, positive inside by the winding angle."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    along = np.einsum("nsk,sk->ns", points[:, None] - a, b - a) / np.sum((b - a) ** 2, axis=1)
    foot = a + np.clip(along, 0, 1)[..., None] * (b - a)
    distance = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    u, v = a - points[:, None], b - points[:, None]
    cross = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    winding = np.arctan2(cross, np.sum(u * v, axis=2)).sum(axis=1)
    return np.where(np.abs(winding) > math.pi, distance, -distance)


def overlap(path, steps, outline, pixel=EM / 512):
    """Intersection over union of what a path paints and its outline, in pixels of so many mm."""
    x, y = outline.min(axis=0) - 0.25 * EM
    columns, rows = np.ceil((np.ptp(outline, axis=0) + 0.5 * EM) / pixel).astype(int)
    field = np.empty((rows, columns))
    kernels.signed_distances(outline, x, y, pixel, field)
    painted = np.zeros(field.shape, np.bool_)
    kernels.cover(
        steps.points, path.level, path.centre, path.azimuth, path.share,
        np.array([x, y, pixel]), painted,
    )  # fmt: skip
    wanted = field > 0.0
    return (painted & wanted).sum() / (painted | wanted).sum()
