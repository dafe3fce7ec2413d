"""A sheet of paper laid on a surface: the geodesic exponential map around a point.

Node (x, y) of a regular grid is the end of the straightest geodesic that leaves the origin in the
direction (x, y) and is sqrt(x^2 + y^2) mm long. So lengths along rays from the origin are
preserved, and those across them shrink or grow with the curvature in between (by sin(r/R)/(r/R) on
a sphere). Between the nodes the map is a bicubic spline.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number, dots_of, length_of, lengths_of
from paint3d.errors import InputError, MeshError, Message
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.kernels.tensor_spline import eliminate_spline, evaluate_splines, solve_spline

__all__ = [
    "EmSquare",
    "SplineMap",
    "SquareLimits",
    "SurfaceChart",
    "SurfaceFrame",
    "frame_at",
    "frame_near",
    "lattice",
    "lay_square",
    "lay_squares",
    "make_chart",
    "overlapping",
    "unroll",
]

# ---- Splines over a sheet ------------------------------------------------------------------------
# Bicubic, through the values of several functions at the nodes of one grid.

_DEGREE = 3


class SplineMap:
    """F functions of (x, y), each a bicubic spline through its values at the nodes of a grid.

    Parameters
    ----------
    xs, ys : (A,), (B,) float64
        Rising; at least four each.
    values : (A, B, F) float64
    """

    def __init__(
        self, xs: NDArray[np.float64], ys: NDArray[np.float64], values: NDArray[np.float64]
    ) -> None:
        x_knots, y_knots = _knots(xs), _knots(ys)
        coefficients = _fit_spline(xs, x_knots, ys, y_knots, values)
        along_x = _differences(coefficients, x_knots)
        along_y = _differences(coefficients.transpose(1, 0, 2), y_knots).transpose(1, 0, 2)
        self._parts = {
            (0, 0): (x_knots, y_knots, (_DEGREE, _DEGREE), coefficients),
            (1, 0): (x_knots[1:-1].copy(), y_knots, (_DEGREE - 1, _DEGREE), along_x),
            (0, 1): (
                x_knots, y_knots[1:-1].copy(), (_DEGREE, _DEGREE - 1), np.ascontiguousarray(along_y)
            ),
        }  # fmt: skip

    def split(self, n: int) -> list[SplineMap]:
        """Split F functions into n maps of F / n."""
        maps = []
        parts = {
            key: [np.ascontiguousarray(one) for one in np.split(part[-1], n, axis=2)]
            for key, part in self._parts.items()
        }
        for k in range(n):
            one = object.__new__(SplineMap)
            one._parts = {key: (*part[:-1], parts[key][k]) for key, part in self._parts.items()}
            maps.append(one)
        return maps

    def __call__(self, xy: AnyArray, dx: int = 0, dy: int = 0) -> AnyArray:
        """Values (N, F) at positions (N, 2), or their first derivatives along x or along y.

        Beyond the grid they are those at its rim.
        """
        x_knots, y_knots, degrees, coefficients = self._parts[dx, dy]
        out = np.empty((len(xy), coefficients.shape[2]))
        evaluate_splines(x_knots, y_knots, degrees, coefficients, np.array(xy, np.float64), out)
        return out


def _knots(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Knots of a spline through `nodes`: all but the second from each end, the ends fourfold."""
    ends = [np.repeat(nodes[end], _DEGREE + 1) for end in (0, -1)]
    return np.concatenate([ends[0], nodes[2:-2], ends[1]])


def _fit_spline(
    xs: AnyArray, x_knots: AnyArray, ys: AnyArray, y_knots: AnyArray, values: AnyArray
) -> NDArray[np.float64]:
    """Coefficients (A, B, F), to the last bit those of FITPACK (SciPy's RectBivariateSpline)."""
    n_x, n_y, n_functions = values.shape
    along_x = np.array(values, np.float64, order="C").reshape(n_x, -1)
    x_triangle = eliminate_spline(xs, x_knots, along_x)
    along_y = np.ascontiguousarray(along_x.reshape(values.shape).swapaxes(0, 1)).reshape(n_y, -1)
    solve_spline(eliminate_spline(ys, y_knots, along_y), along_y)
    both = along_y.reshape(n_y, n_x, n_functions).swapaxes(0, 1)
    along_x = np.ascontiguousarray(both).reshape(n_x, -1)
    solve_spline(x_triangle, along_x)
    return along_x.reshape(values.shape)


def _differences(coefficients: AnyArray, knots: AnyArray) -> AnyArray:
    """Coefficients of the derivative along the first axis."""
    spans = knots[_DEGREE + 1 : -1] - knots[1 : -_DEGREE - 1]
    result: AnyArray = np.diff(coefficients, axis=0) * _DEGREE / spans[:, None, None]
    return result


# ---- Charts --------------------------------------------------------------------------------------


_STEP_MM = 0.5
_FINEST_STEP = 1e-3
_LEAST_ADVANCE = 0.6
"""A step that gains less than this fraction of its length has run off the surface."""
_MOST_NODES = 400
_PROBES = 5  # geodesics to each side of the rim that are traced first
_FARTHEST_SIZES = 8.0  # reach of a chart from its middle, in diagonals of the object
_INVERSE_NODES = 81  # of `coordinates`, likewise


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
    """Return the frame at the closest point to `point`, its y axis as near `up` as can be.

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
    return frame_near(surface, as_array(point, "point", (3,)), as_array(up, "up", (3,)))


def frame_near(
    surface: ClosestPoints, point: NDArray[np.float64], wanted: NDArray[np.float64]
) -> SurfaceFrame:
    """Return the frame of `frame_at` for a point and an up that are known to be finite."""
    found = surface.find_checked(point[None])
    normal = found.normals[0]
    (up_x, up_y, up_z), (x, y, z) = wanted.tolist(), normal.tolist()
    along = up_x * x + up_y * y + up_z * z  # numbers: arrays of three take four times as long
    rise_x, rise_y, rise_z = up_x - x * along, up_y - y * along, up_z - z * along
    length = math.sqrt(rise_x * rise_x + rise_y * rise_y + rise_z * rise_z)
    if length < 1e-6 * max(length_of(wanted), 1e-12):
        raise InputError(
            "up is {wanted}, along the surface's normal; expected another direction",
            wanted=wanted.tolist(),
        )
    rise_x, rise_y, rise_z = rise_x / length, rise_y / length, rise_z / length
    across = rise_y * z - rise_z * y, rise_z * x - rise_x * z, rise_x * y - rise_y * x
    y_axis = np.array([rise_x, rise_y, rise_z])
    return SurfaceFrame(found.points[0], np.array(across), y_axis, normal)


def lattice(xs: AnyArray, ys: AnyArray) -> NDArray[np.float64]:
    """Points (N, 2) of a lattice by its places along x and along y, the latter running faster."""
    return np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)


class SurfaceChart:
    """A smooth map from a flat rectangle, in mm, onto a surface.

    Made by `make_chart`. The rectangle extends from -reach to reach in x and y; (0, 0) is the
    frame's origin.

    Attributes
    ----------
    frame : SurfaceFrame
    reach : (2,) float64
        Half its width and half its height, mm.
    """

    def __init__(
        self, frame: SurfaceFrame, reach: NDArray[np.float64], points: SplineMap, normals: SplineMap
    ) -> None:
        self.frame, self.reach = frame, reach
        self._points, self._normals = points, normals

    def points(self, xy: ArrayLike) -> AnyArray:
        """Points (N, 3) of the surface at chart coordinates (N, 2), mm.

        Raises
        ------
        InputError
            If a coordinate lies outside the chart.
        """
        return self._points(self._check_inside(xy))

    def normals(self, xy: ArrayLike) -> AnyArray:
        """Outward unit normals (N, 3)."""
        return _normalise(self._normals(self._check_inside(xy)))

    def tangents(self, xy: ArrayLike) -> AnyArray:
        """Frames (N, 3, 3) whose columns are the directions of x and y and the normal.

        The normal is that of `normals`; where the map shears, x and y are turned by the same angle
        to become orthogonal.
        """
        checked = self._check_inside(xy)
        normals = _normalise(self._normals(checked))
        along_x = _unit_tangents(self._points(checked, dx=1), normals)
        along_y = _unit_tangents(self._points(checked, dy=1), normals)
        middle = _normalise(along_x + along_y)
        across = np.cross(normals, middle)
        root = math.sqrt(0.5)
        x_axis, y_axis = root * (middle - across), root * (middle + across)
        return np.stack([x_axis, y_axis, normals], axis=-1)

    def coordinates(self, points: ArrayLike, most_off: float = 0.5) -> AnyArray:
        """Chart coordinates (N, 2), mm, of points (N, 3) on the surface.

        NaN for points outside the chart, or farther than `most_off` mm from its surface.

        Notes
        -----
        The nearest of a grid of nodes, then four Gauss-Newton steps with the spline's own slopes.
        `unroll` inverts the same map by sums and differences alone, so that seals are printed in a
        browser to the same bits: neither gives the other's last bits, and both are painted with.
        """
        from scipy.spatial import cKDTree

        wanted = as_array(points, "points", (None, 3))
        reach = self.reach
        lines = [np.linspace(-half, half, _INVERSE_NODES) for half in reach]
        grid = lattice(*lines)
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

    def _check_inside(self, xy: ArrayLike) -> AnyArray:
        checked = as_array(xy, "xy", (None, 2))
        out = np.flatnonzero((np.abs(checked) > self.reach * (1.0 + 1e-9)).any(axis=1))
        if len(out):
            x, y = checked[out[0]]
            raise InputError(
                "({x:.3f}, {y:.3f}) mm lies outside the chart; expected within +-{half_width:g} "
                "and +-{half_height:g} mm",
                x=x,
                y=y,
                half_width=self.reach[0],
                half_height=self.reach[1],
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
        Extent of the chart in x and y, mm.
    spacing : float
        Spacing of the grid's nodes, mm; made larger where there would be over 400 in a row.
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
    ((_, charts, _),) = _make_charts(surface, [frame], [(half_width, half_height)], spacing, step)
    return charts[0]


def _make_charts(
    surface: ClosestPoints,
    frames: Sequence[SurfaceFrame],
    halves: Sequence[tuple[float, float]],
    spacing: float,
    step: float,
) -> list[tuple[list[int], list[SurfaceChart], SplineMap]]:
    """Lay rectangles of half a width and height, mm, around frames, all side by side.

    For each size the indices of its n frames, their charts, and a map to all their points and
    normals: 6 n functions, the points first.
    """
    spacing = as_number(spacing, "spacing", 1e-3, 1e6)
    step = as_number(step, "step", 1e-3, 1e6)
    size = float(np.linalg.norm(np.ptp(surface.mesh.bounds, axis=0)))
    along = np.linspace(-1.0, 1.0, _PROBES)
    rim = lattice(along, along)
    rim = rim[np.abs(rim).max(axis=1) == 1.0]
    grids, rims = [], []
    for half_width, half_height in halves:
        half_width = as_number(half_width, "half_width", 1e-3, 1e6)
        half_height = as_number(half_height, "half_height", 1e-3, 1e6)
        reach = math.hypot(half_width, half_height)
        if reach > _FARTHEST_SIZES * size:
            raise InputError(
                "{object} is {size:.0f} mm in size; expected a sheet that reaches less than "
                "{reach:.0f} mm from its middle",
                object=surface.mesh.name,
                size=size,
                reach=reach,
            )
        grids.append((_nodes(half_width, spacing), _nodes(half_height, spacing)))
        rims.append(np.array([half_width, half_height]) * rim)
    # the rim first: where the surface ends within the rectangle, a few geodesics show it
    _trace(surface, frames, rims, step)
    traced = _trace(surface, frames, [lattice(xs, ys) for xs, ys in grids], step)
    alike: dict[tuple[float, float], list[int]] = {}
    for k, both_halves in enumerate(halves):
        alike.setdefault(both_halves, []).append(k)
    groups = []
    for those in alike.values():
        xs, ys = grids[those[0]]
        values = np.concatenate([traced[k][kind] for kind in (0, 1) for k in those], axis=1)
        joint = SplineMap(xs, ys, values.reshape(len(xs), len(ys), -1))
        maps = joint.split(2 * len(those))
        corner = np.array([xs[-1], ys[-1]])
        charts = [
            SurfaceChart(frames[k], corner, points, normals)
            for k, points, normals in zip(
                those, maps[: len(those)], maps[len(those) :], strict=True
            )
        ]
        groups.append((those, charts, joint))
    return groups


def _nodes(half: float, spacing: float) -> AnyArray:
    n = min(max(2, math.ceil(half / spacing)), _MOST_NODES // 2)
    return np.linspace(-half, half, 2 * n + 1)


def _trace(
    surface: ClosestPoints,
    frames: Sequence[SurfaceFrame],
    ends: Sequence[AnyArray],
    step_mm: float,
) -> list[tuple[AnyArray, AnyArray]]:
    """Trace geodesics from frames to chart coordinates (N, 2) of each; points, normals (N, 3)."""
    n_steps = [max(1, math.ceil(lengths_of(xy).max() / step_mm)) for xy in ends]
    traced: dict[int, tuple[AnyArray, AnyArray]] = {}
    for n in dict.fromkeys(n_steps):
        those = [k for k, wanted in enumerate(n_steps) if wanted == n]
        counts = [len(ends[k]) for k in those]
        starts = [
            np.repeat([getattr(frames[k], axis) for k in those], counts, axis=0)
            for axis in ("origin", "x_axis", "y_axis", "normal")
        ]
        points, normals = _trace_steps(surface, starts, np.concatenate([ends[k] for k in those]), n)
        parts = np.cumsum(counts)[:-1]
        split = zip(np.split(points, parts), np.split(normals, parts), strict=True)
        traced.update(zip(those, split, strict=True))
    return [traced[k] for k in range(len(ends))]


def _trace_steps(
    surface: ClosestPoints, starts: Sequence[AnyArray], ends: AnyArray, n_steps: int
) -> tuple[AnyArray, AnyArray]:
    """Trace geodesics in so many steps from origins with x axes, y axes and normals (N, 3)."""
    points, x_axes, y_axes, normals = starts
    x, y = ends.T
    reach = lengths_of(ends)
    step = (reach / n_steps)[:, None]
    safe = np.where(reach > 0.0, reach, 1.0)[:, None]
    heading = (x[:, None] * x_axes + y[:, None] * y_axes) / safe
    for k in range(n_steps):
        found = surface.find(points + step * heading)
        advance = dots_of(found.points - points, heading)
        turned = dots_of(found.normals, normals)  # cosine between the two normals
        lost = (advance < _LEAST_ADVANCE * step[:, 0] - _FINEST_STEP) | (turned <= 0.0)
        if lost.any():
            i = int(np.flatnonzero(lost)[0])
            raise MeshError(
                "{object}: the surface ends {step:.1f} mm from the middle of the chart, towards "
                "({x:.1f}, {y:.1f}) mm; expected it to go on",
                object=surface.mesh.name,
                step=step[i, 0] * k,
                x=x[i],
                y=y[i],
            )
        # Parallel transport: the least rotation that takes one normal to the next. Projecting the
        # headings instead would pull every geodesic towards the direction of least bending.
        ratio = dots_of(heading, found.normals) / (1.0 + turned)
        heading = _unit_tangents(
            heading - ratio[:, None] * (normals + found.normals), found.normals
        )
        points, normals = found.points, found.normals
    return points, normals


def _normalise(vectors: AnyArray) -> AnyArray:
    length = lengths_of(vectors)[..., None]
    return vectors / np.where(length > 0.0, length, 1.0)


def _unit_tangents(vectors: AnyArray, normals: AnyArray) -> AnyArray:
    """Unit vectors along the parts of `vectors` that are orthogonal to `normals`."""
    return _normalise(vectors - normals * dots_of(vectors, normals)[..., None])


# ---- From the surface back to the sheet ----------------------------------------------------------

_NODES = 65  # of `unroll`: along each side of the grid that gives the first guess
_ROUNDS = 4
_DIFFERENCE = 1e-3  # of the chart's half width


def unroll(chart: SurfaceChart, points: ArrayLike) -> NDArray[np.float64]:
    """Chart coordinates (N, 2), mm, of points (N, 3) on the surface; NaN outside the chart.

    Newton's method from the nearest of 65 by 65 nodes, with slopes by differences, as in
    `web/src/mesh/spline_chart.ts`; a point's distance from the surface, along its normal, does not
    matter. See also `SurfaceChart.coordinates`.

    Raises
    ------
    InputError
        If `points` is not an array of points.
    """
    from scipy.spatial import KDTree

    given, reach = as_array(points, "points", (None, 3)), chart.reach
    nodes = lattice(*(np.linspace(-r, r, _NODES) for r in reach))
    there = chart.points(nodes)
    step = 2.0 * reach.max() / (_NODES - 1)
    stretch = np.linalg.norm(np.diff(there.reshape(_NODES, _NODES, 3), axis=0), axis=2).max()
    most = 2.0 * max(step, stretch)
    apart, nearest = KDTree(there).query(given, k=4, distance_upper_bound=most)
    near = np.flatnonzero(np.isfinite(apart[:, 0]))
    flat = np.full((len(given), 2), np.nan)
    # of several that are as near the first, which no tree says of itself
    first = np.where(apart == apart[:, :1], nearest, len(nodes)).min(axis=1)
    at = nodes[first[near]]
    beyond = np.zeros(len(near), np.bool_)
    for _ in range(_ROUNDS):
        moved = at + _newton_step(chart, at, given[near])
        at = np.clip(moved, -reach, reach)
        beyond = (np.abs(moved - at) > 0.01 * step).any(axis=1)
    at[beyond] = np.nan
    flat[near] = at
    return flat


def _newton_step(chart: SurfaceChart, at: AnyArray, wanted: AnyArray) -> NDArray[np.float64]:
    """Return the least-squares step (N, 2) in the chart towards points (N, 3)."""
    away = wanted - chart.points(at)
    columns = []
    for axis in range(2):
        offset = np.zeros(2)
        offset[axis] = _DIFFERENCE * chart.reach[axis]
        high, low = np.minimum(at + offset, chart.reach), np.maximum(at - offset, -chart.reach)
        span = (high - low)[:, axis, None]
        columns.append((chart.points(high) - chart.points(low)) / span)
    along_x, along_y = columns
    xx, xy, yy = dots_of(along_x, along_x), dots_of(along_x, along_y), dots_of(along_y, along_y)
    bx, by = dots_of(along_x, away), dots_of(along_y, away)
    determinant = xx * yy - xy * xy
    result: NDArray[np.float64] = (
        np.stack([yy * bx - xy * by, xx * by - xy * bx], axis=1) / determinant[:, None]
    )
    return result


# ---- Squares and boxes on a surface --------------------------------------------------------------
# The em square or box of a character: its chart, its distortion, and the overlap of two.

_EM_NODES = 12  # nodes of the chart along an em
_EM_PROBES = 20  # points along an em that are checked
_FEWEST = 6  # of these points along a side, however short it is
_FINEST_MM = 0.25
_ROUNDING = 1e-6  # of the em: so much may two squares of one plane lie above each other
_FREE = 0.7  # of the height: anything nearer is in the way, or a hollow is too tight


@dataclass(frozen=True)
class SquareLimits:
    """The distortion up to which a square can be written in.

    Attributes
    ----------
    stretch : float
        Largest relative error of a side's length.
    shear : float
        Largest error of a corner's angle, rad.
    crease : float
        Largest angle between the normals of neighbouring probes (a 20th of the em), rad.
    turn : float
        Largest angle between a normal within the square and the one in its middle, rad.
    margin : float
        Fraction of the em around the square that must lie on the surface as well, for the handle.
    room_mm : float
        Height above the surface that must be free, for the tuft.
    """

    stretch: float = 0.06
    shear: float = math.radians(5.0)
    crease: float = math.radians(16.0)
    turn: float = math.radians(80.0)
    margin: float = 0.04
    room_mm: float = 0.0


@dataclass(frozen=True, eq=False)
class EmSquare:
    """A square of `em_mm`, or a box of that scale, around the middle of a chart.

    Attributes
    ----------
    chart : SurfaceChart
        Reaches a margin beyond the square.
    em_mm : float
    width_mm, height_mm : float
        Both are the em of a square.
    points, normals : (K, L, 3) float64
        A grid over the square, x first, with the corners at its ends.
    """

    chart: SurfaceChart
    em_mm: float
    width_mm: float
    height_mm: float
    points: NDArray[np.float64]
    normals: NDArray[np.float64]

    def sides(self) -> NDArray[np.float64]:
        """Lengths (4,) on the surface of the lower, right, upper and left side, mm."""
        return _sides(self.points)

    def corner_angles(self) -> NDArray[np.float64]:
        """Angles (4,) between the sides that meet in each corner, rad."""
        return _corner_angles(self.points, self.normals)

    def overlap(self, other: EmSquare) -> float:
        """Return how far the other square extends into this one, mm; 0 where they are apart."""
        edge = other.points
        middle = edge[edge.shape[0] // 2, edge.shape[1] // 2]  # of one that lies upon this
        rim = np.concatenate([edge[:, 0], edge[-1], edge[::-1, -1], edge[0, ::-1], [middle]])
        flat = self.points.reshape(-1, 3)
        size = np.array([self.width_mm, self.height_mm])
        spacings = size / (np.array(self.points.shape[:2]) - 1)
        spacing = float(spacings.max())
        reach = 1.5 * spacing
        near = (rim > flat.min(axis=0) - reach) & (rim < flat.max(axis=0) + reach)
        rim = rim[near.all(axis=1)]
        if not len(rim):
            return 0.0
        apart = np.linalg.norm(rim[:, None] - flat, axis=2)
        nearest = apart.argmin(axis=1)
        close = apart[np.arange(len(rim)), nearest] < reach
        i, j = np.divmod(nearest[close], self.points.shape[1])
        at = np.stack([i, j], axis=1) * spacings - 0.5 * size
        axes = self.chart.tangents(at)
        local = np.einsum("nk,nkd->nd", rim[close] - flat[nearest[close]], axes)
        thin = np.abs(local[:, 2]) < 0.5 * spacing  # excludes the other side of a thin wall
        inside = (0.5 * size - np.abs(at + local[:, :2])).min(axis=1)
        return float(np.max(inside[thin], initial=0.0))


def _sides(p: AnyArray) -> NDArray[np.float64]:
    """Lengths (..., 4) of the sides of grids of points (..., K, L, 3)."""
    edges = (p[..., 0, :], p[..., -1, :, :], p[..., -1, :], p[..., 0, :, :])
    return np.stack([lengths_of(np.diff(e, axis=-2)).sum(axis=-1) for e in edges], axis=-1)


def _corner_angles(p: AnyArray, normals: AnyArray) -> NDArray[np.float64]:
    """Angles (..., 4) in the corners of grids of points (..., K, L, 3), rad."""
    angles = []
    for i, di in ((0, 1), (-1, -1)):
        for j, dj in ((0, 1), (-1, -1)):
            corner, normal = p[..., i, j, :], normals[..., i, j, :]
            one, two = p[..., i + di, j, :] - corner, p[..., i, j + dj, :] - corner
            one = one - normal * dots_of(one, normal)[..., None]
            two = two - normal * dots_of(two, normal)[..., None]
            cosine = dots_of(one, two) / (lengths_of(one) * lengths_of(two))
            angles.append(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return np.stack(angles, axis=-1)


def _find_faults(
    points: AnyArray,
    n: AnyArray,
    middles: AnyArray,
    size: tuple[float, float],
    limits: SquareLimits,
) -> dict[int, Message]:
    """Say why boxes of one size cannot be written in, by their indices, of those that cannot.

    Parameters
    ----------
    points, n : (N, K, L, 3) float64
        Grids of points and normals over them.
    middles : (N, 3) float64
        Normals in their middles.
    size : (float, float)
        mm.
    limits : SquareLimits
    """
    neighbours = np.minimum(
        dots_of(n[:, 1:], n[:, :-1]).min(axis=(1, 2)),
        dots_of(n[:, :, 1:], n[:, :, :-1]).min(axis=(1, 2)),
    )
    turned = dots_of(n, middles[:, None, None]).min(axis=(1, 2))
    stretch = np.abs(_sides(points) / np.array([*size, *size]) - 1.0).max(axis=1)
    shear = np.abs(_corner_angles(points, n) - 0.5 * math.pi).max(axis=1)
    creased, away = neighbours < math.cos(limits.crease), turned < math.cos(limits.turn)
    distorted = (stretch > limits.stretch) | (shear > limits.shear)
    faults: dict[int, Message] = {}
    for k in np.flatnonzero(creased | away | distorted).tolist():
        if creased[k]:
            faults[k] = Message("the surface has an edge or a tight bend there")
        elif away[k]:
            faults[k] = Message("the surface turns away there")
        else:
            faults[k] = Message(
                "the surface is so curved there that the square would be stretched by "
                "{percent:.0f} % and sheared by {degrees:.0f} degrees",
                percent=100.0 * stretch[k],
                degrees=math.degrees(shear[k]),
            )
    return faults


def overlapping(
    squares: Sequence[EmSquare], allowed: Callable[[int, int], float]
) -> tuple[int, int] | None:
    """The first two squares that share more than is allowed (mm, by their numbers); or None."""
    if not squares:
        return None
    corners = np.array([[s.points.min(axis=(0, 1)), s.points.max(axis=(0, 1))] for s in squares])
    rounding = _ROUNDING * max(square.em_mm for square in squares)  # flat ones have no thickness
    low, high = corners[:, 0] - rounding, corners[:, 1] + rounding
    axis = int(np.ptp(corners, axis=(0, 1)).argmax())
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    ends = np.searchsorted(low[:, axis], high[:, axis])  # of those that begin within it
    pairs = []
    for k, end in enumerate(ends.tolist()):
        near = (low[k + 1 : end] < high[k]) & (high[k + 1 : end] > low[k])
        others = order[k + 1 + np.flatnonzero(near.all(axis=1))].tolist()
        here = int(order[k])
        pairs += [(min(here, other), max(here, other)) for other in others]
    for k, other in sorted(pairs):
        one, two, most = squares[k], squares[other], allowed(k, other)
        if one.overlap(two) > most or two.overlap(one) > most:
            return k, other
    return None


def lay_square(
    surface: ClosestPoints,
    frame: SurfaceFrame,
    em_mm: float,
    limits: SquareLimits | None = None,
    size: tuple[float, float] | None = None,
) -> EmSquare:
    """Lay an em square, or a box, around a frame.

    Parameters
    ----------
    surface : ClosestPoints
    frame : SurfaceFrame
    em_mm : float
        Side, mm.
    limits : SquareLimits, optional
    size : (float, float), optional
        Width and height of a box, mm; by default it is a square.

    Raises
    ------
    MeshError
        If the surface ends there, or the square breaks the limits; the message says which.
    """
    (square,) = lay_squares(surface, [frame], em_mm, [size or (em_mm, em_mm)], limits)
    return square


def lay_squares(
    surface: ClosestPoints,
    frames: Sequence[SurfaceFrame],
    em_mm: float,
    sizes: Sequence[tuple[float, float]],
    limits: SquareLimits | None = None,
) -> list[EmSquare]:
    """Lay boxes around frames, as `lay_square` lays one; many of few sizes in a fifth of the time.

    Raises
    ------
    MeshError
        For the first that has no place.
    """
    limits = limits or SquareLimits()
    spacing = em_mm / _EM_NODES
    halves = [
        ((0.5 + limits.margin * (em_mm / width)) * width,
         (0.5 + limits.margin * (em_mm / height)) * height)
        for width, height in sizes
    ]  # fmt: skip
    try:
        groups = _make_charts(surface, frames, halves, spacing, max(spacing, _FINEST_MM))
    except InputError as cause:
        if len(frames) > 1:  # which?
            half = len(frames) // 2
            first = lay_squares(surface, frames[:half], em_mm, sizes[:half], limits)
            return first + lay_squares(surface, frames[half:], em_mm, sizes[half:], limits)
        if not isinstance(cause, MeshError):
            raise
        raise _no_place_error(
            surface, frames[0], em_mm, Message("the surface ends within it")
        ) from None
    squares: dict[int, EmSquare] = {}
    faults: dict[int, Message] = {}
    for those, charts, joint in groups:
        size = sizes[those[0]]
        lines = [
            np.linspace(
                -0.5 * side, 0.5 * side, max(_FEWEST, round(_EM_PROBES * (side / em_mm))) + 1
            )
            for side in size
        ]
        values = joint(lattice(*lines)).reshape(len(lines[0]), len(lines[1]), 2, len(those), 3)
        points, normals = np.ascontiguousarray(values.transpose(2, 3, 0, 1, 4))
        normals = _normalise(normals)
        middles = np.array([frames[k].normal for k in those])
        for n, fault in _find_faults(points, normals, middles, size, limits).items():
            faults[those[n]] = fault
        for k, chart, its_points, its_normals in zip(those, charts, points, normals, strict=True):
            squares[k] = EmSquare(chart, em_mm, *size, its_points, its_normals)
    for k in range(len(frames)):
        why = faults.get(k) or _find_obstacle(surface, squares[k], limits.room_mm)
        if why is not None:
            raise _no_place_error(surface, frames[k], em_mm, why)
    return [squares[k] for k in range(len(frames))]


def _find_obstacle(surface: ClosestPoints, square: EmSquare, height: float) -> Message | None:
    """Say what is nearer to points `height` mm above the square than it is; None if nothing."""
    if height <= 0.0:
        return None
    sparse = tuple(slice(None, None, min(_EM_PROBES // 4, n // 2)) for n in square.points.shape[:2])
    foot = square.points[sparse].reshape(-1, 3)
    above = foot + height * square.normals[sparse].reshape(-1, 3)
    found = surface.find(above).points
    away = np.linalg.norm(found - above, axis=1)
    worst = int(away.argmin())
    if away[worst] > _FREE * height:
        return None
    x, y, z = found[worst]
    return Message(
        "there is no room for the brush above it, which takes {height:.0f} mm: another part of the "
        "object is in the way at ({x:.1f}, {y:.1f}, {z:.1f})",
        height=height,
        x=x,
        y=y,
        z=z,
    )


def _no_place_error(
    surface: ClosestPoints, frame: SurfaceFrame, em_mm: float, why: Message
) -> MeshError:
    x, y, z = frame.origin
    return MeshError(
        "{object}: no place for an em of {em_mm:g} mm around ({x:.1f}, {y:.1f}, {z:.1f}): {why}",
        object=surface.mesh.name,
        em_mm=em_mm,
        x=x,
        y=y,
        z=z,
        why=why,
    )
