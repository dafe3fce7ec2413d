"""A sheet of paper laid on a surface: the geodesic exponential map around a point.

Node (x, y) of a regular grid lies where the straightest geodesic that leaves the origin in the
direction (x, y) arrives after sqrt(x^2 + y^2) mm, so lengths along rays from the origin are
kept, and those across them shrink or grow with the curvature in between (by sin(r/R)/(r/R) on
a sphere). Between the nodes the map is a bicubic spline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import as_array, as_number, cross, dots_of, lengths_of
from paint3d.core.types import AnyArray
from paint3d.errors import InputError, MeshError
from paint3d.mesh.closest_points import ClosestPoints
from paint3d.mesh.spline_map import SplineMap

__all__ = ["SurfaceChart", "SurfaceFrame", "frame_at", "make_chart"]

_STEP_MM = 0.5
_FINEST_STEP = 1e-3
_LEAST_ADVANCE = 0.6
"""A step that gains less than this share of its length has run into the surface's end."""
_MOST_NODES = 400
_PROBES = 5  # along each side: these rays are followed first, to see whether the surface ends
_FARTHEST_SIZES = 8.0  # diagonals of the object that a chart may reach from its middle
_INVERSE_NODES = 81


@dataclass(frozen=True, eq=False)
class SurfaceFrame:
    """A point of a surface with its tangent plane.

    Attributes
    ----------
    origin : (3,) float64
        mm, on the surface.
    x_axis, y_axis : (3,) float64
        Unit tangent vectors, to the right and upwards.
    normal : (3,) float64
        Outward unit normal, x_axis cross y_axis.
    """

    origin: NDArray[np.float64]
    x_axis: NDArray[np.float64]
    y_axis: NDArray[np.float64]
    normal: NDArray[np.float64]


def frame_at(surface: ClosestPoints, point: ArrayLike, up: ArrayLike) -> SurfaceFrame:
    """The frame at the surface's closest point to `point`, its y axis as near `up` as can be.

    Parameters
    ----------
    surface : ClosestPoints
    point : (3,) array_like
        mm.
    up : (3,) array_like
        Any length but zero, not along the normal.

    Raises
    ------
    InputError
        If `up` is zero or runs along the normal.
    """
    wanted = as_array(up, "up", (3,))
    found = surface.find(as_array(point, "point", (3,))[None])
    normal = found.normals[0]
    tangent = wanted - normal * (wanted @ normal)
    length = math.sqrt(tangent @ tangent)
    if length < 1e-6 * max(math.sqrt(wanted @ wanted), 1e-12):
        raise InputError(
            f"up is {wanted.tolist()}, along the surface's normal; expected another direction"
        )
    y_axis = tangent / length
    return SurfaceFrame(found.points[0], cross(y_axis, normal), y_axis, normal)


class SurfaceChart:
    """A smooth map from a flat rectangle, in mm, onto a surface.

    Made by `make_chart`. The rectangle reaches from -half_width to half_width in x and from
    -half_height to half_height in y; (0, 0) is the frame's origin.

    Attributes
    ----------
    frame : SurfaceFrame
    half_width, half_height : float
        mm.
    """

    def __init__(
        self,
        frame: SurfaceFrame,
        xs: AnyArray,
        ys: AnyArray,
        points: AnyArray,
        normals: AnyArray,
    ) -> None:
        self.frame = frame
        self.half_width = float(xs[-1])
        self.half_height = float(ys[-1])
        self._points, self._normals = SplineMap(xs, ys, points), SplineMap(xs, ys, normals)

    def points(self, xy: ArrayLike) -> AnyArray:
        """Points (N, 3) of the surface at chart coordinates (N, 2), mm.

        Raises
        ------
        InputError
            If a coordinate lies outside the chart.
        """
        return self._points(self._checked(xy))

    def normals(self, xy: ArrayLike) -> AnyArray:
        """Outward unit normals (N, 3)."""
        return _normalised(self._normals(self._checked(xy)))

    def tangents(self, xy: ArrayLike) -> AnyArray:
        """Frames (N, 3, 3) whose columns are the directions of x and y and the normal.

        The normal is that of `normals`; x and y are turned alike until they are orthogonal, so
        that neither is favoured where the map shears.
        """
        checked = self._checked(xy)
        normals = _normalised(self._normals(checked))
        along_x = _in_plane(self._points(checked, dx=1), normals)
        along_y = _in_plane(self._points(checked, dy=1), normals)
        middle = _normalised(along_x + along_y)
        across = np.cross(normals, middle)
        root = math.sqrt(0.5)
        x_axis, y_axis = root * (middle - across), root * (middle + across)
        return np.stack([x_axis, y_axis, normals], axis=-1)

    def coordinates(self, points: ArrayLike, most_off: float = 0.5) -> AnyArray:
        """Chart coordinates (N, 2), mm, of points (N, 3) on the surface.

        NaN for points outside the chart, or farther than `most_off` mm from its surface.

        Notes
        -----
        The nearest of a grid of nodes, then four Gauss-Newton steps.
        """
        from scipy.spatial import cKDTree

        wanted = as_array(points, "points", (None, 3))
        reach = np.array([self.half_width, self.half_height])
        lines = [np.linspace(-half, half, _INVERSE_NODES) for half in reach]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        spacing = float(2.0 * reach.max() / (_INVERSE_NODES - 1))
        tree = cKDTree(self.points(grid))
        distance, nearest = tree.query(wanted, distance_upper_bound=1.5 * spacing + most_off)
        near = np.flatnonzero(np.isfinite(distance))
        xy = grid[nearest[near]]
        for _ in range(4):
            inside = np.clip(xy, -reach, reach)
            off = wanted[near] - self._points(inside)
            along = [self._points(inside, dx=1), self._points(inside, dy=1)]
            slope = np.stack(along, axis=-1)
            gram = np.einsum("nki,nkj->nij", slope, slope)
            step = np.linalg.solve(gram, np.einsum("nki,nk->ni", slope, off)[..., None])[..., 0]
            xy = inside + step
        inside = np.clip(xy, -reach, reach)
        left = np.linalg.norm(wanted[near] - self._points(inside), axis=1)
        out = np.full((len(wanted), 2), np.nan)
        kept = (left <= most_off) & (np.abs(xy) <= reach * (1.0 + 1e-9)).all(axis=1)
        out[near[kept]] = inside[kept]
        return out

    def _checked(self, xy: ArrayLike) -> AnyArray:
        checked = as_array(xy, "xy", (None, 2))
        reach = np.array([self.half_width, self.half_height])
        out = np.flatnonzero((np.abs(checked) > reach * (1.0 + 1e-9)).any(axis=1))
        if len(out):
            x, y = checked[out[0]]
            raise InputError(
                f"({x:.3f}, {y:.3f}) mm lies outside the chart; expected within "
                f"+-{self.half_width:g} and +-{self.half_height:g} mm"
            )
        return checked


def make_chart(
    surface: ClosestPoints,
    frame: SurfaceFrame,
    half_width: float,
    half_height: float,
    spacing: float = 2.0,
    step: float = _STEP_MM,
) -> SurfaceChart:
    """Lay a rectangle on the surface around a frame.

    Parameters
    ----------
    surface : ClosestPoints
    frame : SurfaceFrame
        From `frame_at`.
    half_width, half_height : float
        How far the chart reaches in x and y, mm.
    spacing : float
        Distance of the grid's nodes, mm; made larger where there would be over 400 in a row.
    step : float
        Longest step along a geodesic, mm.

    Raises
    ------
    MeshError
        If the surface ends within the rectangle.
    InputError
        If an extent or the spacing is not positive, or the rectangle reaches farther from its
        middle than eight times the object's size.

    Notes
    -----
    All nodes are traced side by side, in steps along the tangent followed by the closest point:
    for n nodes and a reach r, n r / step closest points of about 1 us.
    """
    half_width = as_number(half_width, "half_width", 1e-3, 1e6)
    half_height = as_number(half_height, "half_height", 1e-3, 1e6)
    spacing = as_number(spacing, "spacing", 1e-3, 1e6)
    step = as_number(step, "step", 1e-3, 1e6)
    size = float(np.linalg.norm(np.ptp(surface.mesh.bounds, axis=0)))
    reach = math.hypot(half_width, half_height)
    if reach > _FARTHEST_SIZES * size:
        raise InputError(
            f"{surface.mesh.name} is {size:.0f} mm in size; expected a sheet that reaches less "
            f"than {reach:.0f} mm from its middle"
        )
    xs, ys = _nodes(half_width, spacing), _nodes(half_height, spacing)
    x, y = (grid.ravel() for grid in np.meshgrid(xs, ys, indexing="ij"))
    _trace(surface, frame, *_rim(half_width, half_height), step)
    points, normals = _trace(surface, frame, x, y, step)
    shape = (len(xs), len(ys), 3)
    return SurfaceChart(frame, xs, ys, points.reshape(shape), normals.reshape(shape))


def _nodes(half: float, spacing: float) -> AnyArray:
    n = min(max(2, math.ceil(half / spacing)), _MOST_NODES // 2)
    return np.linspace(-half, half, 2 * n + 1)


def _rim(half_width: float, half_height: float) -> tuple[AnyArray, AnyArray]:
    """Some chart coordinates x, y (N,) on the rectangle's rim, with its corners."""
    along = np.linspace(-1.0, 1.0, _PROBES)
    x, y = (grid.ravel() for grid in np.meshgrid(along, along, indexing="ij"))
    rim = np.maximum(np.abs(x), np.abs(y)) == 1.0
    return half_width * x[rim], half_height * y[rim]


def _trace(
    surface: ClosestPoints, frame: SurfaceFrame, x: AnyArray, y: AnyArray, step_mm: float
) -> tuple[AnyArray, AnyArray]:
    """Follow the straightest geodesics from the frame to chart coordinates x, y: (N, 3) each."""
    reach = np.hypot(x, y)
    n_steps = max(1, math.ceil(reach.max() / step_mm))
    step = (reach / n_steps)[:, None]
    safe = np.where(reach > 0.0, reach, 1.0)[:, None]
    heading = (x[:, None] * frame.x_axis + y[:, None] * frame.y_axis) / safe
    points = np.broadcast_to(frame.origin, heading.shape).copy()
    normals = np.broadcast_to(frame.normal, heading.shape).copy()
    for k in range(n_steps):
        found = surface.find(points + step * heading)
        advance = np.sum((found.points - points) * heading, axis=1)
        turned = np.sum(found.normals * normals, axis=1)
        lost = (advance < _LEAST_ADVANCE * step[:, 0] - _FINEST_STEP) | (turned <= 0.0)
        if lost.any():
            i = int(np.flatnonzero(lost)[0])
            raise MeshError(
                f"{surface.mesh.name}: the surface ends {step[i, 0] * k:.1f} mm from the middle "
                f"of the chart, towards ({x[i]:.1f}, {y[i]:.1f}) mm; expected it to go on"
            )
        heading = _carried(heading, normals, found.normals)
        points, normals = found.points, found.normals
    return points, normals


def _carried(heading: AnyArray, before: AnyArray, after: AnyArray) -> AnyArray:
    """Tangents (N, 3) turned by the least rotation that takes one normal to the next.

    Projecting them instead would pull every geodesic towards the direction of least bending.
    """
    share = np.sum(heading * after, axis=1) / (1.0 + np.sum(before * after, axis=1))
    return _in_plane(heading - share[:, None] * (before + after), after)


def _normalised(vectors: AnyArray) -> AnyArray:
    length = lengths_of(vectors)[..., None]
    return vectors / np.where(length > 0.0, length, 1.0)


def _in_plane(vectors: AnyArray, normals: AnyArray) -> AnyArray:
    """Unit vectors along the parts of `vectors` that are orthogonal to `normals`."""
    return _normalised(vectors - normals * dots_of(vectors, normals)[..., None])
