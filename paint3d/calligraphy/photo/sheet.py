"""Finding a sheet of paper in a photograph: its four corners.

Every threshold of a few planes (brightness, colour) has connected areas; those that are nearly
four-sided are candidates. Each is judged by its weakest side, for a sheet differs from the table
along all four, while a shadow's edge, or a stack of paper, ends somewhere. The sides of the best
one are then drawn anew: along each, where brightness or colour changes most across it, a line is
fitted to the places that agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.photo.straighten import linear_light
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["checked_corners", "find_sheet", "whole_picture"]

_SEARCHED, _DRAWN = 320, 1400  # pixels of the longer side: where it is looked for, and drawn
_THRESHOLDS = 24
_LEAST, _MOST = 0.06, 0.985  # of the picture
_FOUR_SIDED = 0.93  # of an area and its quadrilateral that they share
_STATIONS = 48  # along a side
_OUT = 0.012  # of the picture: how far inside and outside a side colours are compared
_WEAKEST = 0.5  # of contrast along the weakest side over what the planes vary by themselves
_LEFT_OUT = 0.06  # of a side at either end, where corners are round
_ROUNDS = ((0.03, 6), (0.008, 6))  # of the picture to either side, and how often


@dataclass(frozen=True, eq=False)
class _Planes:
    """What is compared: (H, W) planes, each in units of how much it varies from place to place."""

    planes: tuple[NDArray[np.float32], ...]

    @property
    def shape(self) -> tuple[int, int]:
        height, width = self.planes[0].shape
        return height, width


def whole_picture(pixels: AnyArray) -> NDArray[np.float64]:
    """The corners (4, 2) of the picture itself, as of a scan."""
    height, width = pixels.shape[:2]
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def checked_corners(corners: AnyArray, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Corners (4, 2) that were given, in pixels of a picture of height and width `shape`.

    Raises
    ------
    InputError
        If they lie outside of it, or do not go around a sheet.
    """
    corners = np.asarray(corners, np.float64)
    height, width = shape
    room = 0.02 * max(shape)
    if ((corners < -room) | (corners > (width + room, height + room))).any():
        raise InputError(
            f"corners are {corners.round().tolist()} in a picture of {width} x {height} pixels; "
            "expected places in it"
        )
    sides = np.roll(corners, -1, axis=0) - corners
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    if not ((turns > 0.0).all() or (turns < 0.0).all()) or np.abs(turns).min() < 100.0:
        raise InputError(
            f"corners are {corners.round().tolist()}; expected four, one after another around the "
            "sheet, from its upper left"
        )
    return corners if (turns > 0.0).all() else corners[[0, 3, 2, 1]]


def find_sheet(pixels: NDArray[np.uint8]) -> NDArray[np.float64]:
    """The corners of the sheet in a photograph.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        sRGB codes.

    Returns
    -------
    (4, 2) float64
        Pixels, x to the right and y down: upper left, upper right, lower right, lower left.

    Raises
    ------
    InputError
        If no four-sided sheet stands out.
    """
    step = max(1, round(max(pixels.shape[:2]) / _SEARCHED))
    small = _planes(pixels, step)
    best, weakest = None, 0.0
    for corners in _candidates(small):
        contrast = _weakest_side(small, corners)
        if contrast > weakest:
            best, weakest = corners, contrast
    if best is None or weakest < _WEAKEST:
        raise InputError(
            "no sheet with four sides stands out; expected paper that lies whole in the picture on "
            "another colour: give its corners, --corners x,y x,y x,y x,y, or --whole for all of it"
        )
    finer = max(1, round(max(pixels.shape[:2]) / _DRAWN))
    fine = _planes(pixels, finer)
    drawn = _drawn(fine, best * (step / finer))
    return _in_order(drawn * finer)


def _planes(pixels: NDArray[np.uint8], step: int) -> _Planes:
    """Logarithms of brightness and of red over blue, by what each varies."""
    from scipy.ndimage import gaussian_filter

    height, width = (n // step * step for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // step, step, width // step, step, 3)
    # block by block of rows: never a picture's worth of floats
    rows = [linear_light(row).mean(axis=(0, 2)) for row in blocks]
    light = np.log(np.stack(rows) + 0.01)
    told = (light.mean(axis=2), light[..., 0] - light[..., 2])
    planes = []
    for plane, least in zip(told, (0.25, 0.15), strict=True):
        smooth = gaussian_filter(plane, 0.8)
        spread = float(np.subtract(*np.percentile(smooth, (90.0, 10.0))))
        planes.append((smooth / max(spread, least)).astype(np.float32))
    return _Planes(tuple(planes))


# -- candidates ---------------------------------------------------------------------------------


def _candidates(small: _Planes) -> list[NDArray[np.float64]]:
    """Quadrilaterals (4, 2) around areas above or below thresholds."""
    from scipy.ndimage import binary_fill_holes, binary_opening, find_objects, label

    found: list[NDArray[np.float64]] = []
    for plane in small.planes:
        levels = np.quantile(plane, np.linspace(0.03, 0.97, _THRESHOLDS))
        for level in levels:
            for side in (plane > level, plane <= level):
                opened = binary_opening(side, np.ones((3, 3)))
                areas, n = label(opened)
                sizes = np.bincount(areas.ravel())[1:]
                for k in np.flatnonzero(sizes > 0.4 * _LEAST * plane.size):
                    box = find_objects(areas, n)[k]
                    part = binary_fill_holes(areas[box] == k + 1)
                    if not _LEAST < part.sum() / plane.size < _MOST:
                        continue
                    corners = _four_sided(part, np.array([box[1].start, box[0].start]))
                    if corners is not None:
                        found.append(corners)
    return found


def _four_sided(part: AnyArray, start: AnyArray) -> NDArray[np.float64] | None:
    """The quadrilateral around an area, where it is nearly one."""
    import shapely

    rows = np.flatnonzero(part.any(axis=1))
    first = part[rows].argmax(axis=1)
    last = part.shape[1] - part[rows, ::-1].argmax(axis=1)
    edges = [np.column_stack([x, rows + dy]) for x in (first, last) for dy in (0, 1)]
    hull = shapely.MultiPoint(np.concatenate(edges)).convex_hull
    if hull.geom_type != "Polygon":
        return None
    corners = _four_corners(np.array(hull.simplify(0.6).exterior.coords)[:-1])
    if corners is None:
        return None
    area = shapely.Polygon(corners).area
    if not part.sum() > _FOUR_SIDED * area or not hull.area > _FOUR_SIDED * area:
        return None
    return corners + start


def _four_corners(ring: AnyArray) -> NDArray[np.float64] | None:
    """A convex polygon (N, 2) with sides left out, where its neighbours meet nearest, until 4."""
    ring = np.array(ring)
    while len(ring) > 4:
        best, least = None, np.inf
        n = len(ring)
        for k in range(n):
            a, b, c, d = ring[k - 1], ring[k], ring[(k + 1) % n], ring[(k + 2) % n]
            meet = _meeting(a, b, d, c)
            if meet is None:
                continue
            grown = 0.5 * abs(_cross(c - b, meet - b))
            if grown < least:
                best, least = (k, meet), grown
        if best is None:
            return None
        k, meet = best
        ring[k] = meet
        ring = np.delete(ring, (k + 1) % n, axis=0)
    return ring if len(ring) == 4 else None


def _cross(a: AnyArray, b: AnyArray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _meeting(a: AnyArray, b: AnyArray, d: AnyArray, c: AnyArray) -> AnyArray | None:
    """Where the lines from a through b and from d through c meet beyond b and c."""
    along, other = b - a, c - d
    turn = _cross(along, other)
    if abs(turn) < 1e-9:
        return None
    t = _cross(d - a, other) / turn
    s = _cross(d - a, along) / turn
    return a + t * along if t >= 1.0 - 1e-9 and s >= 1.0 - 1e-9 else None


# -- judging and drawing the sides --------------------------------------------------------------


def _across(planes: _Planes, start: AnyArray, end: AnyArray, offsets: AnyArray) -> AnyArray:
    """What planes show at offsets (K,) across a side: (planes, stations, K)."""
    from scipy.ndimage import map_coordinates

    share = np.linspace(_LEFT_OUT, 1.0 - _LEFT_OUT, _STATIONS)
    way = end - start
    normal = np.array([way[1], -way[0]]) / max(float(np.linalg.norm(way)), 1e-9)
    places = (start + share[:, None] * way)[:, None] + offsets[None, :, None] * normal
    at = places[..., ::-1].reshape(-1, 2).T - 0.5
    values = [map_coordinates(plane, at, order=1, mode="nearest") for plane in planes.planes]
    return np.array(values).reshape(len(values), _STATIONS, len(offsets))


def _weakest_side(planes: _Planes, corners: AnyArray) -> float:
    """Contrast of the weakest side of a quadrilateral, by the plane that shows all sides best."""
    reach = max(2.0, _OUT * max(planes.shape))
    offsets = np.array([-2.0, -1.0, 1.0, 2.0]) * 0.5 * reach
    sides = []
    for k in range(4):
        values = _across(planes, corners[k], corners[(k + 1) % 4], offsets)
        change = values[..., 2:].mean(axis=2) - values[..., :2].mean(axis=2)
        inside = _inside(planes.shape, corners[k], corners[(k + 1) % 4])
        sides.append(np.quantile(change, 0.3, axis=1) * inside)
        sides.append(np.quantile(-change, 0.3, axis=1) * inside)
    out, into = np.array(sides[::2]), np.array(sides[1::2])  # (4, planes): all change one way
    sign = max(out.min(axis=0).max(), into.min(axis=0).max())
    mixed = np.maximum(out, into).max(axis=1).min()  # or any way, which is worth less
    return float(max(sign, 0.6 * mixed))


def _inside(shape: tuple[int, int], start: AnyArray, end: AnyArray) -> float:
    """1 for a side within the picture, 0 for one along or beyond its border."""
    height, width = shape
    middles = np.array([start, 0.5 * (start + end), end])
    reach = 1.5
    away = np.minimum(middles, np.array([width, height]) - middles).min(axis=1)
    return float(np.median(away) > reach)


def _drawn(planes: _Planes, corners: AnyArray) -> NDArray[np.float64]:
    """Corners where the lines meet that are fitted to the sides."""
    corners = np.array(corners, np.float64)
    for reach, rounds in _ROUNDS:
        width = max(4.0, reach * max(planes.shape))
        for _ in range(rounds):
            lines = [_fitted(planes, corners[k], corners[(k + 1) % 4], width) for k in range(4)]
            met = [_crossing(lines[k - 1], lines[k]) for k in range(4)]
            if any(point is None for point in met):
                break
            moved = np.array(met)
            if np.linalg.norm(moved - corners, axis=1).max() > 0.15 * max(planes.shape):
                break
            done = np.abs(moved - corners).max() < 0.05
            corners = moved
            if done:
                break
    return corners


def _fitted(planes: _Planes, start: AnyArray, end: AnyArray, reach: float) -> AnyArray:
    """Two points (2, 2) of the line along which the planes change most across a side."""
    offsets = np.arange(-reach, reach + 0.5, 0.5)
    values = _across(planes, start, end, offsets)
    gap = 3
    change = values[..., 2 * gap :] - values[..., : -2 * gap]  # over 3 pixels
    total = change.mean(axis=1)
    sign = np.sign(total[np.arange(len(total)), np.abs(total).argmax(axis=1)])
    strong = np.clip(change * sign[:, None, None], 0.0, None).sum(axis=0)
    middles = offsets[gap : len(offsets) - gap]
    at = strong.argmax(axis=1)
    best = middles[at] + _between(strong, at)
    weight = strong.max(axis=1)
    weight = np.minimum(weight, np.median(weight))  # a seal is stronger, but only in some places
    share = np.linspace(_LEFT_OUT, 1.0 - _LEFT_OUT, _STATIONS)
    slope, height = _line_through(share, best, weight, 0.25 * reach)
    way = end - start
    normal = np.array([way[1], -way[0]]) / max(float(np.linalg.norm(way)), 1e-9)
    return np.array([start + height * normal, end + (height + slope) * normal])


def _between(strong: AnyArray, at: AnyArray) -> AnyArray:
    """How far from a sample the greatest value lies, by a parabola through three, in offsets."""
    n = strong.shape[1]
    k = np.clip(at, 1, n - 2)
    rows = np.arange(len(strong))
    a, b, c = strong[rows, k - 1], strong[rows, k], strong[rows, k + 1]
    bend = a - 2.0 * b + c
    shift = np.where(bend < -1e-9, 0.5 * (a - c) / np.where(bend < -1e-9, bend, 1.0), 0.0)
    return np.where(k == at, 0.5 * np.clip(shift, -1.0, 1.0), 0.0)


def _line_through(x: AnyArray, y: AnyArray, weight: AnyArray, near: float) -> tuple[float, float]:
    """Slope and height at 0 of the line that most weight lies near, then fitted to what does."""
    best, most = (0.0, float(np.median(y))), -1.0
    for i in range(0, len(x) - 4, 2):
        for j in range(i + 8, len(x), 4):
            slope = (y[j] - y[i]) / (x[j] - x[i])
            height = y[i] - slope * x[i]
            agree = float(weight[np.abs(y - height - slope * x) < 0.5 * near].sum())
            if agree > most:
                best, most = (float(slope), float(height)), agree
    slope, height = best
    for scale in (near, 0.5 * near, 0.25 * near):
        off = (y - height - slope * x) / max(scale, 0.7)
        trust = weight * np.clip(1.0 - off**2, 0.0, None) ** 2
        if trust.sum() <= 0.0:
            break
        middle_x, middle_y = np.average(x, weights=trust), np.average(y, weights=trust)
        spread = float((trust * (x - middle_x) ** 2).sum())
        if spread < 1e-9:
            break
        slope = float((trust * (x - middle_x) * (y - middle_y)).sum() / spread)
        height = float(middle_y - slope * middle_x)
    return slope, height


def _crossing(one: AnyArray, other: AnyArray) -> AnyArray | None:
    a, b = one
    c, d = other
    turn = _cross(b - a, d - c)
    if abs(turn) < 1e-9:
        return None
    met: AnyArray = a + _cross(c - a, d - c) / turn * (b - a)
    return met


def _in_order(corners: AnyArray) -> NDArray[np.float64]:
    """Corners clockwise as seen, from the one that is upper left."""
    middle = corners.mean(axis=0)
    around = np.arctan2(*(corners - middle).T[::-1])
    corners = corners[np.argsort(around)]
    start = int(np.argmin(corners.sum(axis=1)))
    result: NDArray[np.float64] = np.roll(corners, -start, axis=0)
    return result
