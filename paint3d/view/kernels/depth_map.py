"""Depth maps of a cloud of surface samples: what is hidden from a parallel light.

A map has cells x cells entries, the largest w met in each, -inf where nothing is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel

__all__ = ["DepthMap", "Floor", "Light", "add_sunlight", "fill_depth_map", "shade_floor"]

_BLOCK = 1024  # points whose cells are found at once, by vector instructions


class DepthMap(NamedTuple):
    """Depth map of a parallel light: what it meets first."""

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
    """Write the depth of points into a map; cost O(N), 3 ns each.

    Parameters
    ----------
    points : (3, N) float32
        Their x, y and z from the map's centre, mm; none may lie outside the map.
    depth_map : DepthMap
        Its `depth` is written.
    """
    _, axes, scale, out = depth_map
    cells = out.shape[0]
    middle, last = np.float32(0.5 * cells), np.int32(cells - 1)
    u_axis, v_axis = (axes[0] * scale).astype(np.float32), (axes[1] * scale).astype(np.float32)
    w_axis = axes[2].astype(np.float32)
    ux, uy, uz, vx, vy, vz = u_axis[0], u_axis[1], u_axis[2], v_axis[0], v_axis[1], v_axis[2]
    wx, wy, wz = w_axis[0], w_axis[1], w_axis[2]
    cell, depth = np.empty(_BLOCK, np.int32), np.empty(_BLOCK, np.float32)
    flat, zero = out.reshape(cells * cells), np.int32(0)
    flat[:] = -np.inf
    for start in range(0, points.shape[1], _BLOCK):
        size = min(_BLOCK, points.shape[1] - start)
        xs, ys, zs = points[0, start:], points[1, start:], points[2, start:]
        for n in range(size):
            x, y, z = xs[n], ys[n], zs[n]
            u = min(max(np.int32(ux * x + uy * y + uz * z + middle), zero), last)
            v = min(max(np.int32(vx * x + vy * y + vz * z + middle), zero), last)
            cell[n] = v * np.int32(cells) + u
            depth[n] = wx * x + wy * y + wz * z
        for n in range(size):  # stored in any case: no branch to be guessed
            met = flat[cell[n]]
            flat[cell[n]] = depth[n] if depth[n] > met else met


@kernel
def add_sunlight(points, normals, offset, depth_map, light, floor, lit, hidden):
    """Add the light of one parallel source to points of a surface; cost O(N).

    Parameters
    ----------
    points, normals : (N, 3) float32
    offset : float
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
        x = points[n, 0] + offset * normals[n, 0] - centre[0]
        y = points[n, 1] + offset * normals[n, 1] - centre[1]
        z = points[n, 2] + offset * normals[n, 2] - centre[2]
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


@kernel
def shade_floor(depth_map, weight, floor):
    """Take a parallel light's weight off the cells of a floor that the object hides from it.

    Cost: that of the cells over which the map lies.

    Parameters
    ----------
    depth_map : DepthMap
        Seen from above the floor.
    weight : float
    floor : Floor
        Its `openness` is written.
    """
    centre, axes, scale, depth = depth_map
    openness, x, y, z, half = floor
    cells, size = depth.shape[0], openness.shape[0]
    step = 2.0 * half / size
    at_x, z = x - half + 0.5 * step - centre[0], z - centre[2]
    across = step * scale  # cells of the map to a cell of the floor
    for i in range(size):
        at_y = y - half + (i + 0.5) * step - centre[1]
        u0 = (axes[0, 0] * at_x + axes[0, 1] * at_y + axes[0, 2] * z) * scale + 0.5 * cells
        v0 = (axes[1, 0] * at_x + axes[1, 1] * at_y + axes[1, 2] * z) * scale + 0.5 * cells
        w0 = axes[2, 0] * at_x + axes[2, 1] * at_y + axes[2, 2] * z
        first, end = _cells_within(u0, axes[0, 0] * across, cells, 0, size)
        first, end = _cells_within(v0, axes[1, 0] * across, cells, first, end)
        for j in range(first, end):
            u, v = u0 + j * axes[0, 0] * across, v0 + j * axes[1, 0] * across
            inside = 0.0 <= u < cells and 0.0 <= v < cells
            if inside and depth[int(v), int(u)] > w0 + j * axes[2, 0] * step:
                openness[i, j] -= weight


@kernel
def _cells_within(start, step, cells, first, end):
    """Return the part of `first` to `end` with start + n step from 0 to `cells`, or a bit more."""
    if abs(step) < 1e-9:
        return (first, end) if 0.0 <= start < cells else (first, first)
    low, high = -start / step, (cells - start) / step
    low, high = min(low, high), max(low, high)
    return max(first, int(max(low, -1.0))), min(end, int(min(high, 1e9)) + 1)
