"""Depth maps of a cloud of surface samples: what is hidden from a parallel light.

A map has cells x cells entries, the largest w met in each, -inf where nothing is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["DepthMap", "Floor", "Light", "add_sunlight", "fill_depth_map"]


class DepthMap(NamedTuple):
    """What a parallel light meets first."""

    centre: NDArray[np.float64]  # (3,), mm: what places are relative to
    axes: NDArray[np.float64]  # (3, 3), rows u, v, w; w toward the light
    scale: float  # cells per mm
    depth: NDArray[np.float32]  # (C, C), mm


class Light(NamedTuple):
    """A parallel source."""

    irradiance: NDArray[np.float64]  # (3,), of a surface that faces it
    share: float  # weight with which the cosine of incidence counts as hidden


class Floor(NamedTuple):
    """A square floor: a source below it shines through its openness."""

    openness: NDArray[np.float64]  # (M, M)
    x: float  # of its middle, mm
    y: float
    z: float
    half: float  # of its width, mm


@kernel
def fill_depth_map(points, depth_map):
    """Write the depth of `points` (N, 3) float32 into a map; cost O(N)."""
    centre, axes, scale, out = depth_map
    cells = out.shape[0]
    out[:] = -np.inf
    for n in range(points.shape[0]):
        x, y, z = points[n, 0] - centre[0], points[n, 1] - centre[1], points[n, 2] - centre[2]
        u = int((axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z) * scale + 0.5 * cells)
        v = int((axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z) * scale + 0.5 * cells)
        w = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
        if 0 <= u < cells and 0 <= v < cells and w > out[v, u]:
            out[v, u] = w


@kernel
def add_sunlight(points, normals, lift, depth_map, light, floor, lit, hidden):
    """Add the light of one parallel source to points of a surface; cost O(N).

    Parameters
    ----------
    points, normals : (N, 3) float32
    lift : float
        How far along its normal a point is moved before it is looked up, mm.
    depth_map : DepthMap
    light : Light
    floor : Floor
    lit : (N, 3) float64
        Increased by cosine times irradiance where the source is seen.
    hidden : (N,) float64
        Increased by cosine times share where the object stands in between.
    """
    centre, axes, scale, depth = depth_map
    cells = depth.shape[0]
    middle = 0.5 * cells
    for n in range(points.shape[0]):
        cosine = (
            normals[n, 0] * axes[2, 0] + normals[n, 1] * axes[2, 1] + normals[n, 2] * axes[2, 2]
        )
        if cosine <= 0.0:
            continue
        x = points[n, 0] + lift * normals[n, 0] - centre[0]
        y = points[n, 1] + lift * normals[n, 1] - centre[1]
        z = points[n, 2] + lift * normals[n, 2] - centre[2]
        u = (axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z) * scale + middle
        v = (axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z) * scale + middle
        w = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
        inside = 0.0 <= u < cells and 0.0 <= v < cells
        if inside and depth[int(v), int(u)] > w:
            hidden[n] += light.share * cosine
            continue
        if axes[2, 2] < 0.0:
            cosine *= _floor_openness(points[n], axes[2], floor)
        for k in range(3):
            lit[n, k] += cosine * light.irradiance[k]


@kernel
def _floor_openness(point, direction, floor):
    """Return the openness of the floor where the line from `point` downward meets it."""
    openness, x, y, z, half = floor
    size = openness.shape[0]
    reach = (point[2] - z) / -direction[2]
    j = ((point[0] + reach * direction[0] - x) / half + 1.0) * 0.5 * size
    i = ((point[1] + reach * direction[1] - y) / half + 1.0) * 0.5 * size
    if 0.0 <= i < size and 0.0 <= j < size:
        return openness[int(i), int(j)]
    return 1.0
