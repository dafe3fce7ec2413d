"""Which footprints fit into a stroke's outline: distances, containment, best directions, coverage.

Distances are kept on a grid: `field[i, j]` is the signed distance (positive inside) at
(x0 + j step, y0 + i step), with `grid = (x0, y0, step)`. A table of footprints is an array
`points` (L levels, B boundary points, 2): the outline of each descent about its own centroid, with
the bend along +x. Points of the same index belong together, so a level may lie between two rungs;
level -1 stands for a brush that is lifted.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.kernels.raster import fill_polygon
from paint3d.core.kernel import kernel

__all__ = [
    "Target",
    "balance",
    "best_course",
    "cover",
    "fit_level",
    "fit_levels",
    "measure_room",
    "rate",
    "signed_distances",
]

_STRIDE = 4  # rungs between tries, going up
_HALVINGS = 8  # of a bracket of that many
_ROUGH = 4  # halvings where directions are only compared
_SECTIONS = 7  # golden sections of a side step
_STAYING = 0.01  # of a side step, what it must gain


class Target(NamedTuple):
    """Area to fill, the footprints to fill it with, and how far these may leave it."""

    points: NDArray[np.float64]  # (L, B, 2), table of footprints, mm
    support: NDArray[np.float64]  # (L, 2 A), reach of each from its centroid, even ways from 0, mm
    field: NDArray[np.float64]  # (H, W), signed distances of the outline, mm
    grid: NDArray[np.float64]  # (3,), of these: x0, y0, step, mm
    margin: float  # mm


class _Place(NamedTuple):
    """A sample of the centre line: where it is, where it leads, and how wide the stroke is."""

    x: float  # mm
    y: float
    heading: float  # rad
    left: float  # mm to the outline
    right: float


class _Stance(NamedTuple):
    """How a footprint lies: its centroid, mm, its bend, and what share of its length is left."""

    x: float
    y: float
    cosine: float
    sine: float
    share: float


@kernel(inline="always")
def _square_to_edge(polygon, k, x, y):
    """Square of the distance of (x, y) to the edge that ends at corner k."""
    px, py = polygon[k - 1, 0], polygon[k - 1, 1]
    ex, ey = polygon[k, 0] - px, polygon[k, 1] - py
    square = ex * ex + ey * ey
    t = ((x - px) * ex + (y - py) * ey) / square if square > 0.0 else 0.0
    t = min(1.0, max(0.0, t))
    dx, dy = x - px - t * ex, y - py - t * ey
    return dx * dx + dy * dy


@kernel
def signed_distances(polygon, x0, y0, step, out):
    """Distance of every grid point to a closed polygon (N, 2), positive inside (non-zero rule).

    Exact within a step of the polygon; from there the nearest edges spread from point to point,
    which is exact but for few points far off.
    """
    n = polygon.shape[0]
    rows, columns = out.shape
    nearest = np.full((rows, columns), -1, np.int32)
    grid = (x0, y0, step)
    out[:] = np.inf
    for k in range(n):
        ax, ay = (polygon[k - 1, 0] - x0) / step, (polygon[k - 1, 1] - y0) / step
        bx, by = (polygon[k, 0] - x0) / step, (polygon[k, 1] - y0) / step
        for i in range(max(0, int(min(ay, by)) - 1), min(rows, int(max(ay, by)) + 3)):
            for j in range(max(0, int(min(ax, bx)) - 1), min(columns, int(max(ax, bx)) + 3)):
                square = _square_to_edge(polygon, k, x0 + j * step, y0 + i * step)
                if square < out[i, j]:
                    out[i, j], nearest[i, j] = square, k
    for way in (1, -1, 1, -1):
        for row in range(rows):
            i = row if way > 0 else rows - 1 - row
            for turn in (1, -1):
                for column in range(columns):
                    j = column if turn > 0 else columns - 1 - column
                    _take_over(polygon, grid, i, j, i, j - turn, nearest, out)
                    if turn > 0:
                        for aside in (-1, 0, 1):
                            _take_over(polygon, grid, i, j, i - way, j + aside, nearest, out)
    scaled = np.empty_like(polygon)
    for k in range(n):
        scaled[k, 0], scaled[k, 1] = (
            (polygon[k, 0] - x0) / step + 0.5,
            (polygon[k, 1] - y0) / step + 0.5,
        )
    inside = np.zeros((rows, columns), np.bool_)
    fill_polygon(scaled, inside)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = math.sqrt(out[i, j]) if inside[i, j] else -math.sqrt(out[i, j])


@kernel(inline="always")
def _take_over(polygon, grid, i, j, row, column, nearest, out):
    """Try a neighbour's nearest edge for the grid point (i, j)."""
    x0, y0, step = grid
    if 0 <= row < out.shape[0] and 0 <= column < out.shape[1]:
        k = nearest[row, column]
        if k >= 0 and k != nearest[i, j]:
            square = _square_to_edge(polygon, k, x0 + j * step, y0 + i * step)
            if square < out[i, j]:
                out[i, j], nearest[i, j] = square, k


@kernel(inline="always")
def _distance_at(field, grid, x, y):
    """Bilinear signed distance; off the grid the border's value holds, which lies outside."""
    u = min(max((x - grid[0]) / grid[2], 0.0), field.shape[1] - 1.000001)
    v = min(max((y - grid[1]) / grid[2], 0.0), field.shape[0] - 1.000001)
    j, i = int(u), int(v)
    u -= j
    v -= i
    low = (1.0 - u) * field[i, j] + u * field[i, j + 1]
    high = (1.0 - u) * field[i + 1, j] + u * field[i + 1, j + 1]
    return (1.0 - v) * low + v * high


@kernel
def measure_room(field, grid, centres, directions, limit, out):
    """Measure how far one can go from centres (S, 2) along directions (S, 2) and stay inside."""
    for s in range(centres.shape[0]):
        run = 0.0
        while run < limit:
            x = centres[s, 0] + run * directions[s, 0]
            y = centres[s, 1] + run * directions[s, 1]
            d = _distance_at(field, grid, x, y)
            if d <= 0.0:
                run += d
                break
            run += max(d, 0.25)
        out[s] = min(max(run, 0.0), limit)


@kernel(inline="always")
def _first_outside(target, level, stance, first):
    """The first boundary point, from `first` on, that lies over the margin outside; -1 for none."""
    points = target.points
    k = min(int(level), points.shape[0] - 2)
    t = level - k
    n = points.shape[1]
    for i in range(n):
        b = first + i
        if b >= n:
            b -= n
        u = stance.share * ((1.0 - t) * points[k, b, 0] + t * points[k + 1, b, 0])
        v = (1.0 - t) * points[k, b, 1] + t * points[k + 1, b, 1]
        px = stance.x + stance.cosine * u - stance.sine * v
        py = stance.y + stance.sine * u + stance.cosine * v
        if _distance_at(target.field, target.grid, px, py) < -target.margin:
            return b
    return -1


@kernel
def fit_level(target, x, y, azimuth, hint=-1.0, halvings=_HALVINGS, share=1.0):
    """Greatest level that fits with its centroid at (x, y), or -1; rungs tried below fit too.

    `hint` is a level to start from; each of `halvings` halves a range of four rungs; `share` is
    what is left of a footprint's length.
    """
    stance = _Stance(x, y, math.cos(azimuth), math.sin(azimuth), share)
    top = target.points.shape[0] - 1.0
    if _distance_at(target.field, target.grid, x, y) <= 0.0:
        return -1.0
    level = min(max(hint, 0.0), top)
    low, high = -1.0, top + _STRIDE
    at = 0
    while True:  # up or down from the hint until the level is bracketed
        outside = _first_outside(target, level, stance, at)
        if outside < 0:
            low = level
            if level >= top:
                return top
            if high <= top:
                break
            level = min(level + _STRIDE, top)
        else:
            at = outside
            high = level
            if low >= 0.0:
                break
            if level <= 0.0:
                return -1.0
            level = max(level - _STRIDE, 0.0)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        outside = _first_outside(target, middle, stance, at)
        if outside < 0:
            low = middle
        else:
            high, at = middle, outside
    return low


@kernel
def fit_levels(target, centres, azimuths, shares, out):
    """`fit_level` of every pose of a dense course: centres (S, 2), azimuths and shares (S,)."""
    hint = -1.0
    for s in range(centres.shape[0]):
        x, y = centres[s, 0], centres[s, 1]
        hint = fit_level(target, x, y, azimuths[s], hint, _HALVINGS, shares[s])
        out[s] = hint


@kernel
def rate(target, centres, headings, room, shifts, out_gap):
    """Fraction of the stroke's width that every direction and side step leaves bare.

    Parameters
    ----------
    target : Target
    centres : (S, 2), headings : (S,) float64
        Samples of the centre line and the direction of travel, rad.
    room : (S, 2) float64
        Distance from centre to outline on the left and on the right.
    shifts : (O,) float64
        Side steps to the left, in shares of the narrower room.
    out_gap : (S, A, O) float64
        Width left bare on both sides together, for A even directions.
    """
    n_angles = out_gap.shape[1]
    levels = np.full((n_angles, shifts.shape[0]), -1.0)
    for s in range(centres.shape[0]):
        left, right = room[s, 0], room[s, 1]
        place = _Place(centres[s, 0], centres[s, 1], headings[s], left, right)
        for o in range(shifts.shape[0]):
            shift = shifts[o] * min(left, right)
            for a in range(n_angles):
                azimuth = 2.0 * math.pi * a / n_angles
                levels[a, o], out_gap[s, a, o] = _gap(
                    target, place, shift, azimuth, levels[a, o], _ROUGH
                )


@kernel
def _gap(target, place, shift, azimuth, hint, halvings):
    """Level that fits a side step to the left of a place, and the width it leaves bare."""
    x = place.x - shift * math.sin(place.heading)
    y = place.y + shift * math.cos(place.heading)
    level = fit_level(target, x, y, azimuth, hint, halvings)
    if level < 0.0:
        return level, place.left + place.right
    turn = place.heading + 0.5 * math.pi - azimuth
    reach_left = _reach(target.support, level, turn) + shift
    reach_right = _reach(target.support, level, turn + math.pi) - shift
    return level, max(0.0, place.left - reach_left) + max(0.0, place.right - reach_right)


@kernel
def balance(target, centres, headings, room, azimuths, span, out_shift):
    """Side step (S,) near the given one that leaves the least width bare, by golden section.

    Parameters are those of `rate`; `azimuths` (S,) are fixed, `span` is how far (mm) to look to
    each side, `out_shift` (S,) is read and written, mm.
    """
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    level = -1.0
    for s in range(centres.shape[0]):
        start = out_shift[s]
        place = _Place(centres[s, 0], centres[s, 1], headings[s], room[s, 0], room[s, 1])
        low, high = start - span, start + span
        tries = np.array([high - ratio * (high - low), low + ratio * (high - low)])
        gaps = np.full(2, -1.0)
        for _ in range(_SECTIONS):
            for k in range(2):
                if gaps[k] < 0.0:
                    level, gap = _gap(target, place, tries[k], azimuths[s], level, _HALVINGS)
                    gaps[k] = gap + _STAYING * abs(tries[k] - start)
            if gaps[0] > gaps[1]:
                low = tries[0]
                tries[0], gaps[0] = tries[1], gaps[1]
                tries[1], gaps[1] = low + ratio * (high - low), -1.0
            else:
                high = tries[1]
                tries[1], gaps[1] = tries[0], gaps[0]
                tries[0], gaps[0] = high - ratio * (high - low), -1.0
        out_shift[s] = 0.5 * (low + high)


@kernel
def _reach(support, level, direction):
    n = support.shape[1]
    i = round(direction / (2.0 * math.pi) * n) % n
    k = min(int(level), support.shape[0] - 2)
    t = level - k
    return (1.0 - t) * support[k, i] + t * support[k + 1, i]


@kernel
def best_course(cost, turn_cost, shift_cost, most_turn, out_angle, out_shift):
    """Cheapest chain through the samples, by dynamic programming.

    Parameters
    ----------
    cost : (S, A, O) float64
        Cost of every state.
    turn_cost, shift_cost : float
        Cost of one step of direction or side step, times its square.
    most_turn : int
        Steps of direction allowed between neighbours.
    out_angle, out_shift : (S,) int64
        The chain.
    """
    n, n_angles, n_shifts = cost.shape
    origin = np.zeros((n, n_angles, n_shifts), np.int64)
    before = cost[0].copy()
    now = np.empty_like(before)
    for s in range(1, n):
        for a in range(n_angles):
            for o in range(n_shifts):
                best, source = np.inf, 0
                for da in range(-most_turn, most_turn + 1):
                    b = (a + da) % n_angles
                    for p in range(max(0, o - 1), min(n_shifts, o + 2)):
                        value = before[b, p] + turn_cost * da * da + shift_cost * (o - p) ** 2
                        if value < best:
                            best, source = value, b * n_shifts + p
                now[a, o] = best + cost[s, a, o]
                origin[s, a, o] = source
        before, now = now, before
    state = int(np.argmin(before))
    for s in range(n - 1, -1, -1):
        a, o = state // n_shifts, state % n_shifts
        out_angle[s], out_shift[s] = a, o
        state = origin[s, a, o]


@kernel
def cover(points, levels, centres, azimuths, shares, grid, out_mask):
    """Set the pixels under a dense course of footprints; pixel centres as grid points of a field.

    Every footprint is filled as the polygon of its boundary points, of whose length a share is
    left. A course must be dense: poses farther apart than a pixel leave scalloped edges.
    """
    n_points, n_columns = points.shape[1], out_mask.shape[1]
    x0, y0, step = grid[0], grid[1], grid[2]
    xs, ys = np.empty(n_points), np.empty(n_points)
    for s in range(levels.shape[0]):
        if levels[s] < 0.0:
            continue
        k = min(int(levels[s]), points.shape[0] - 2)
        t = levels[s] - k
        cosine, sine = math.cos(azimuths[s]), math.sin(azimuths[s])
        for b in range(n_points):
            u = shares[s] * ((1.0 - t) * points[k, b, 0] + t * points[k + 1, b, 0])
            v = (1.0 - t) * points[k, b, 1] + t * points[k + 1, b, 1]
            xs[b] = (centres[s, 0] + cosine * u - sine * v - x0) / step
            ys[b] = (centres[s, 1] + sine * u + cosine * v - y0) / step
        first = max(0, math.ceil(ys.min()))
        last = min(out_mask.shape[0] - 1, math.floor(ys.max()))
        for i in range(first, last + 1):
            low, high = np.inf, -np.inf  # footprints are convex enough for one run a row
            for b in range(n_points):
                e = (b + 1) % n_points
                if (ys[b] <= i) != (ys[e] <= i):
                    x = xs[b] + (i - ys[b]) / (ys[e] - ys[b]) * (xs[e] - xs[b])
                    low, high = min(low, x), max(high, x)
            if low <= high:
                left, right = math.ceil(max(low, 0.0)), math.floor(min(high, n_columns - 1.0))
                for j in range(left, right + 1):
                    out_mask[i, j] = True
