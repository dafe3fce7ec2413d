"""Finding a sheet of paper in a photograph: its four corners.

Every threshold of a few planes (brightness, colour) has connected areas; those that are nearly
four-sided are candidates. Each is judged by its weakest side, for a sheet differs from the table
along all four, while a shadow's edge, or a stack of paper, ends somewhere. The sides of the best
one are then drawn anew: along each, where brightness or colour changes most across it, a line is
fitted to the pixels that agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.photo.ink_mask import otsu
from paint3d.colour.spectra import decode_srgb
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import cross_2d
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = [
    "blur_matrix",
    "check_corners",
    "check_exposure",
    "check_ground",
    "find_sheets",
    "homography",
    "map_points",
    "remove_light",
    "sheet_size",
    "straighten",
    "white_on_dark",
    "whole_picture",
]

# ---- Laid flat -----------------------------------------------------------------------------------
# A sheet in a photograph laid flat: the projective map of its four corners.
#
# The sheet's own proportions follow from the four corners and the picture's middle, where the
# camera's axis is taken to go through (Zhang and He, *Whiteboard scanning and image enhancement*,
# 2007, section 3): with the homography from the unit square H = (h1, h2, h3), corners counted from
# the middle, the focal length is f^2 = -(h1x h2x + h1y h2y) / (h1z h2z), and the ratio of the sides
# is |diag(1/f, 1/f, 1) h1| / |diag(1/f, 1/f, 1) h2|.


_FLAT = 0.02  # of perspective: below it the focal length says nothing
_FOCAL = (0.4, 6.0)  # longer sides of the picture: focal lengths that cameras have
_SLIMMEST = 12.0  # ratio of the sides
_CODES = np.arange(256, dtype=np.uint8)
_ROWS = 256  # that are looked up at once: bounds the memory


def _linear_light(codes: AnyArray) -> NDArray[np.float32]:
    """Linear values, 0 to 1, of sRGB codes (uint8)."""
    result: NDArray[np.float32] = decode_srgb(_CODES).astype(np.float32)[codes]
    return result


def homography(start: AnyArray, end: AnyArray) -> NDArray[np.float64]:
    """The projective map (3, 3) that carries four points (4, 2) to four others."""
    rows, right = [], []
    for (x, y), (u, v) in zip(start, end, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    solved = np.linalg.solve(np.array(rows, np.float64), np.array(right, np.float64))
    return np.append(solved, 1.0).reshape(3, 3)


def map_points(matrix: AnyArray, points: AnyArray) -> NDArray[np.float64]:
    """Points (N, 2) under a projective map."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    result: NDArray[np.float64] = mapped[:, :2] / mapped[:, 2:]
    return result


def sheet_size(corners: AnyArray, shape: tuple[int, int], longest: int) -> tuple[int, int]:
    """Height and width, pixels, that a sheet is laid flat in.

    Parameters
    ----------
    corners : (4, 2) float64
        In the picture, pixels: upper left, upper right, lower right, lower left.
    shape : (int, int)
        Height and width of the picture.
    longest : int
        Of the longer side; less where the picture shows no more.
    """
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    ratio = _side_ratio(corners, shape) or float((sides[0] + sides[2]) / (sides[1] + sides[3]))
    ratio = min(max(ratio, 1.0 / _SLIMMEST), _SLIMMEST)
    long = min(longest, round(float(sides.max())))
    width, height = (long, long / ratio) if ratio > 1.0 else (long * ratio, long)
    return max(8, round(height)), max(8, round(width))


def _side_ratio(corners: AnyArray, shape: tuple[int, int]) -> float | None:
    """Width over height of a sheet, where the perspective is strong enough."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    size = max(shape)
    matrix = homography(square, (corners - 0.5 * np.array(shape[::-1])) / size)
    h1, h2 = matrix[:, 0], matrix[:, 1]
    if abs(h1[2]) < _FLAT or abs(h2[2]) < _FLAT:
        return None
    focal2 = -(h1[0] * h2[0] + h1[1] * h2[1]) / (h1[2] * h2[2])
    if not _FOCAL[0] ** 2 < focal2 < _FOCAL[1] ** 2:
        return None
    scale = np.array([focal2, focal2, 1.0])
    return math.sqrt(float((h1**2 / scale).sum() / (h2**2 / scale).sum()))


def straighten(
    pixels: NDArray[np.uint8], corners: AnyArray, size: tuple[int, int]
) -> NDArray[np.float32]:
    """Rectify a sheet, in linear light.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        sRGB codes.
    corners : (4, 2) float64
        As for `sheet_size`; pixel (i, j) of the picture lies at (j + 0.5, i + 0.5).
    size : (int, int)
        Height and width.

    Returns
    -------
    (height, width, 3) float32
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    height, width = size
    flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64)
    matrix = homography(flat, corners)
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    shrink = float(sides.max()) / max(height, width)
    out = np.empty((height, width, 3), np.float32)
    x = np.arange(width) + 0.5
    for channel in range(3):
        plane = _linear_light(pixels[..., channel])
        if shrink > 1.2:  # what the new pixels could not show
            plane = gaussian_filter(plane, 0.4 * math.sqrt(shrink**2 - 1.0), truncate=3.0)
        for first in range(0, height, _ROWS):
            rows = np.arange(first, min(first + _ROWS, height)) + 0.5
            pixels_at = np.stack(np.broadcast_arrays(x[None], rows[:, None]), axis=-1)
            at = map_points(matrix, pixels_at.reshape(-1, 2)) - 0.5
            values = map_coordinates(plane, at[:, ::-1].T, order=1, mode="nearest")
            out[first : first + len(rows), :, channel] = values.reshape(len(rows), width)
    return out


# ---- Finding the sheet ---------------------------------------------------------------------------


_SEARCHED, _DRAWN = 320, 1400  # pixels of the longer side: where it is looked for, and drawn
_THRESHOLDS = 24
_LEAST, _MOST = 0.06, 0.985  # of the picture
_FOUR_SIDED = 0.93  # of an area and its quadrilateral that they share
_STATIONS = 48  # along a side
_OUT = 0.012  # of the picture: how far inside and outside a side colours are compared
_AS_LARGE = 0.4  # of the area of the sheet that stands out most: another one
_OVERLAP = 0.1  # of the smaller one's area, that two sheets may share
_WEAKEST = 0.5  # of contrast along the weakest side over what the planes vary by themselves
_LEFT_OUT = 0.06  # of a side at either end, where corners are round
_ROUNDS = ((0.03, 6), (0.008, 6))  # of the picture to either side, and how often


@dataclass(frozen=True, eq=False)
class _Planes:
    """Planes (H, W) that are compared, each in units of how much it varies across the sheet."""

    planes: tuple[NDArray[np.float32], ...]

    @property
    def shape(self) -> tuple[int, int]:
        height, width = self.planes[0].shape
        return height, width


def whole_picture(pixels: AnyArray) -> NDArray[np.float64]:
    """The corners (4, 2) of the picture itself, as of a scan."""
    height, width = pixels.shape[:2]
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def check_corners(corners: AnyArray, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Check given corners (4, 2), in pixels of a picture of height and width `shape`.

    Raises
    ------
    InputError
        If they lie outside of it, or do not go around a sheet.
    """
    corners = np.asarray(corners, np.float64)
    height, width = shape
    margin = 0.02 * max(shape)
    if ((corners < -margin) | (corners > (width + margin, height + margin))).any():
        raise InputError(
            "corners are {corners} in a picture of {width} x {height} pixels; expected places in "
            "it",
            corners=corners.round().tolist(),
            width=width,
            height=height,
        )
    sides = np.roll(corners, -1, axis=0) - corners
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    if not ((turns > 0.0).all() or (turns < 0.0).all()) or np.abs(turns).min() < 100.0:
        raise InputError(
            "corners are {corners}; expected four, one after another around the sheet, from its "
            "upper left",
            corners=corners.round().tolist(),
        )
    return corners if (turns > 0.0).all() else corners[[0, 3, 2, 1]]


def find_sheets(pixels: NDArray[np.uint8]) -> list[NDArray[np.float64]]:
    """The corners of the sheets in a photograph, that which stands out most first.

    Others are sheets where they stand out, too, are not much smaller, and lie beside it.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        sRGB codes.

    Returns
    -------
    list of (4, 2) float64
        Pixels, x to the right and y down: upper left, upper right, lower right, lower left.

    Raises
    ------
    InputError
        If no four-sided sheet stands out.
    """
    import shapely

    step = max(1, round(max(pixels.shape[:2]) / _SEARCHED))
    small = _compute_planes(pixels, step)
    candidates = [one for one in _find_candidates(small) if shapely.Polygon(one).is_valid]
    ranked = [(_weakest_side(small, corners), corners) for corners in candidates]
    ranked.sort(key=lambda one: -one[0])
    chosen: list[tuple[NDArray[np.float64], Polygon]] = []
    for contrast, corners in ranked:
        area = shapely.Polygon(corners)
        if contrast < _WEAKEST:
            break
        is_large = not chosen or area.area > _AS_LARGE * chosen[0][1].area
        if is_large and not any(
            area.intersection(one).area > _OVERLAP * min(area.area, one.area) for _, one in chosen
        ):
            chosen.append((corners, area))
    if not chosen:
        raise InputError(
            "no sheet with four sides stands out; expected paper that lies whole in the picture on "
            "another colour: give its corners",
            hint="--corners x,y x,y x,y x,y, or --whole for all of the picture",
        )
    finer = max(1, round(max(pixels.shape[:2]) / _DRAWN))
    fine = _compute_planes(pixels, finer)
    return [
        _order_corners(_refine_corners(fine, corners * (step / finer)) * finer)
        for corners, _ in chosen
    ]


def _compute_planes(pixels: NDArray[np.uint8], step: int) -> _Planes:
    """Logarithms of brightness and of red over blue, by what each varies."""
    from scipy.ndimage import gaussian_filter

    height, width = (n // step * step for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // step, step, width // step, step, 3)
    # block by block of rows: never a picture's worth of floats
    rows = [_linear_light(row).mean(axis=(0, 2)) for row in blocks]
    light = np.log(np.stack(rows) + 0.01)
    measures = (light.mean(axis=2), light[..., 0] - light[..., 2])
    planes = []
    for plane, least in zip(measures, (0.25, 0.15), strict=True):
        smooth = gaussian_filter(plane, 0.8)
        spread = float(np.subtract(*np.percentile(smooth, (90.0, 10.0))))
        planes.append((smooth / max(spread, least)).astype(np.float32))
    return _Planes(tuple(planes))


# -- candidates ---------------------------------------------------------------------------------


def _find_candidates(small: _Planes) -> list[NDArray[np.float64]]:
    """Quadrilaterals (4, 2) around areas above or below thresholds."""
    from scipy.ndimage import binary_fill_holes, binary_opening, find_objects, label

    quadrilaterals: list[NDArray[np.float64]] = []
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
                        quadrilaterals.append(corners)
    return quadrilaterals


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
            meet = _intersect(a, b, d, c)
            if meet is None:
                continue
            grown = 0.5 * abs(float(cross_2d(c - b, meet - b)))
            if grown < least:
                best, least = (k, meet), grown
        if best is None:
            return None
        k, meet = best
        ring[k] = meet
        ring = np.delete(ring, (k + 1) % n, axis=0)
    return ring if len(ring) == 4 else None


def _intersect(a: AnyArray, b: AnyArray, d: AnyArray, c: AnyArray) -> AnyArray | None:
    """Intersection of the lines from a through b and from d through c, beyond b and c."""
    along, other = b - a, c - d
    turn = cross_2d(along, other)
    if abs(turn) < 1e-9:
        return None
    t = cross_2d(d - a, other) / turn
    s = cross_2d(d - a, along) / turn
    return a + t * along if t >= 1.0 - 1e-9 and s >= 1.0 - 1e-9 else None


# -- judging and drawing the sides --------------------------------------------------------------


def _side_normal(start: AnyArray, end: AnyArray) -> AnyArray:
    """Unit vector (2,) across a side, outwards."""
    side = end - start
    normal: AnyArray = np.array([side[1], -side[0]]) / max(float(np.linalg.norm(side)), 1e-9)
    return normal


def _sample_across(planes: _Planes, start: AnyArray, end: AnyArray, offsets: AnyArray) -> AnyArray:
    """Values of planes at offsets (K,) across a side: (planes, stations, K)."""
    from scipy.ndimage import map_coordinates

    fraction = np.linspace(_LEFT_OUT, 1.0 - _LEFT_OUT, _STATIONS)
    side, normal = end - start, _side_normal(start, end)
    points = (start + fraction[:, None] * side)[:, None] + offsets[None, :, None] * normal
    at = points[..., ::-1].reshape(-1, 2).T - 0.5
    values = [map_coordinates(plane, at, order=1, mode="nearest") for plane in planes.planes]
    return np.array(values).reshape(len(values), _STATIONS, len(offsets))


def _weakest_side(planes: _Planes, corners: AnyArray) -> float:
    """Contrast of the weakest side of a quadrilateral, by the plane that shows all sides best."""
    reach = max(2.0, _OUT * max(planes.shape))
    offsets = np.array([-2.0, -1.0, 1.0, 2.0]) * 0.5 * reach
    sides = []
    for k in range(4):
        values = _sample_across(planes, corners[k], corners[(k + 1) % 4], offsets)
        change = values[..., 2:].mean(axis=2) - values[..., :2].mean(axis=2)
        inside = _sides_inside(planes.shape, corners[k], corners[(k + 1) % 4])
        sides.append(np.quantile(change, 0.3, axis=1) * inside)
        sides.append(np.quantile(-change, 0.3, axis=1) * inside)
    out, into = np.array(sides[::2]), np.array(sides[1::2])  # (4, planes): all change one way
    sign = max(out.min(axis=0).max(), into.min(axis=0).max())
    mixed = np.maximum(out, into).max(axis=1).min()  # or any way, which is worth less
    return float(max(sign, 0.6 * mixed))


def _sides_inside(shape: tuple[int, int], start: AnyArray, end: AnyArray) -> float:
    """1 for a side within the picture, 0 for one along or beyond its border."""
    height, width = shape
    middles = np.array([start, 0.5 * (start + end), end])
    reach = 1.5
    away = np.minimum(middles, np.array([width, height]) - middles).min(axis=1)
    return float(np.median(away) > reach)


def _refine_corners(planes: _Planes, corners: AnyArray) -> NDArray[np.float64]:
    """Corners where the lines meet that are fitted to the sides."""
    corners = np.array(corners, np.float64)
    for reach, rounds in _ROUNDS:
        width = max(4.0, reach * max(planes.shape))
        for _ in range(rounds):
            lines = [_fit_side(planes, corners[k], corners[(k + 1) % 4], width) for k in range(4)]
            met = [_cross_lines(lines[k - 1], lines[k]) for k in range(4)]
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


def _fit_side(planes: _Planes, start: AnyArray, end: AnyArray, reach: float) -> AnyArray:
    """Two points (2, 2) of the line along which the planes change most across a side."""
    offsets = np.arange(-reach, reach + 0.5, 0.5)
    values = _sample_across(planes, start, end, offsets)
    gap = 3
    change = values[..., 2 * gap :] - values[..., : -2 * gap]  # over 3 pixels
    total = change.mean(axis=1)
    sign = np.sign(total[np.arange(len(total)), np.abs(total).argmax(axis=1)])
    strong = np.clip(change * sign[:, None, None], 0.0, None).sum(axis=0)
    middles = offsets[gap : len(offsets) - gap]
    at = strong.argmax(axis=1)
    best = middles[at] + _peak_offset(strong, at)
    weight = strong.max(axis=1)
    weight = np.minimum(weight, np.median(weight))  # a seal is stronger, but only in some pixels
    fraction = np.linspace(_LEFT_OUT, 1.0 - _LEFT_OUT, _STATIONS)
    slope, height = _line_through(fraction, best, weight, 0.25 * reach)
    normal = _side_normal(start, end)
    return np.array([start + height * normal, end + (height + slope) * normal])


def _peak_offset(strong: AnyArray, at: AnyArray) -> AnyArray:
    """Offset of the greatest value from a sample, by a parabola through three."""
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


def _cross_lines(one: AnyArray, other: AnyArray) -> AnyArray | None:
    a, b = one
    c, d = other
    turn = cross_2d(b - a, d - c)
    if abs(turn) < 1e-9:
        return None
    met: AnyArray = a + cross_2d(c - a, d - c) / turn * (b - a)
    return met


def _order_corners(corners: AnyArray) -> NDArray[np.float64]:
    """Corners clockwise as seen, from the one that is upper left."""
    middle = corners.mean(axis=0)
    around = np.arctan2(*(corners - middle).T[::-1])
    corners = corners[np.argsort(around)]
    start = int(np.argmin(corners.sum(axis=1)))
    result: NDArray[np.float64] = np.roll(corners, -start, axis=0)
    return result


# ---- Light ---------------------------------------------------------------------------------------
# The light on a sheet taken out: what is left is how much of it the ink lets back.
#
# The paper's own brightness is known wherever there is no ink. It is spread over the rest from near
# by where paper is near, and from farther off where it is not, so that the edge of a shadow is
# followed and the inside of a thick stroke is bridged.


_SMALL = 360  # pixels of the longer side: light has no finer detail
_SEEN_AS_PAPER = 80.0  # per cent of a window's pixels that are darker, at first
_WINDOW = 0.12  # of the longer side
_NEAR = (0.008, 0.02, 0.06, 0.25)  # of the longer side: from where paper is taken, nearest first
_ENOUGH = 0.25  # of paper within that distance
_BLACK = 0.3  # of the light of bright paper around: darker than a shadow
_NO_SHADOW = 0.08  # of the sheet's own light: darker than a shadow,
_BROADEST = 0.2  # unless it is broader than that part of the longer side
_RED = 1.35  # times the paper's own red over green and blue: a seal
_NARROW = 0.05  # of the longer side: narrower dark pixels are ink, broader ones shadow
_DARKER = 0.9  # of the paper's light
_DARKEST = 1e-3


def remove_light(sheet: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Reflectance of every pixel of a sheet, as a fraction of the paper's.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.

    Returns
    -------
    (H, W, 3) float32
        1 on bare paper, 0 on the blackest ink.
    (h, w, 3) float32
        The paper's light, at a smaller size.
    """
    step = max(1, round(max(sheet.shape[:2]) / _SMALL))
    small = _block_means(sheet, step)
    paper = _spread_light(small, _is_paper(small), max(small.shape[:2]))
    whole = np.stack([_resize(paper[..., k], sheet.shape[:2]) for k in range(3)], axis=-1)
    return np.clip(sheet / np.maximum(whole, _DARKEST), 1e-3, 1.25), paper


def _block_means(sheet: AnyArray, step: int) -> NDArray[np.float32]:
    """Means over blocks of so many pixels a side; the last ones may be cut."""
    height, width = (max(1, n // step) * step for n in sheet.shape[:2])
    blocks = sheet[:height, :width].reshape(height // step, step, width // step, step, 3)
    result: NDArray[np.float32] = blocks.mean(axis=(1, 3), dtype=np.float32)
    return result


def _resize(plane: AnyArray, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """A plane at another size, linear between its pixels' middles."""
    from scipy.ndimage import map_coordinates

    rows = (np.arange(shape[0]) + 0.5) * plane.shape[0] / shape[0] - 0.5
    columns = (np.arange(shape[1]) + 0.5) * plane.shape[1] / shape[1] - 0.5
    at = np.stack(np.meshgrid(rows, columns, indexing="ij"))
    result: NDArray[np.float32] = map_coordinates(
        plane.astype(np.float32), at, order=1, mode="nearest", output=np.float32
    )
    return result


def _is_paper(small: AnyArray) -> NDArray[np.bool_]:
    """Pixels without ink: ink is very dark, coloured, or narrow; a shadow is neither."""
    from scipy.ndimage import (
        binary_dilation,
        grey_closing,
        maximum_filter,
        median_filter,
        minimum_filter,
        percentile_filter,
    )

    longest = max(small.shape[:2])
    grey = small.mean(axis=2)
    window = max(3, round(_WINDOW * longest / 3))
    top = percentile_filter(median_filter(grey[::3, ::3], 3), _SEEN_AS_PAPER, size=window)
    bright = np.maximum(_resize(top, grey.shape), _DARKEST)
    warmth = small[..., 0] / np.maximum(np.minimum(small[..., 1], small[..., 2]), _DARKEST)
    lit = grey > 0.7 * bright
    usual = float(np.median(warmth[lit])) if lit.any() else 1.0
    black = grey < _NO_SHADOW * np.percentile(grey, _SEEN_AS_PAPER)
    broadest = 2 * max(1, round(0.5 * _BROADEST * longest)) + 1  # a square, whose sides go apart
    narrowed = minimum_filter(black, broadest, mode="constant")
    black &= ~maximum_filter(narrowed, broadest, mode="constant")
    black |= grey < _BLACK * bright
    inked = binary_dilation(black | (warmth > _RED * usual), np.ones((3, 3)))
    bridged = _spread_light(grey[..., None], ~inked, longest)[..., 0]
    filled = np.where(inked, bridged, grey)
    size = max(3, round(_NARROW * longest))
    closed = grey_closing(filled, size=(size, size), mode="nearest")
    result: NDArray[np.bool_] = ~binary_dilation(grey < _DARKER * closed) & ~inked
    return result


def _spread_light(small: AnyArray, is_paper: AnyArray, longest: int) -> NDArray[np.float32]:
    """The light of pixels that are paper, spread over all: normalized blurs, nearest first."""
    weight = is_paper.astype(np.float32)
    if not weight.any():
        weight[:] = 1.0
    total = np.zeros(small.shape, np.float32)
    left = np.ones(small.shape[:2], np.float32)
    for k, fraction in enumerate(_NEAR):
        sigma = max(0.7, fraction * longest)
        down, across = (blur_matrix(n, sigma) for n in small.shape[:2])
        there = (down @ weight @ across.T).astype(np.float32)
        trust = left if k == len(_NEAR) - 1 else left * np.clip(there / _ENOUGH, 0.0, 1.0)
        for channel in range(small.shape[2]):
            seen = (down @ (small[..., channel] * weight) @ across.T).astype(np.float32)
            total[..., channel] += trust * seen / np.maximum(there, 1e-6)
        left = left - trust
    return total


@lru_cache(maxsize=16)  # a sheet is looked at twice, at four widths
def blur_matrix(n: int, sigma: float) -> NDArray[np.float64]:
    """Weights of n pixels in a row in each other when they are blurred by a Gaussian.

    The row is mirrored at its ends. The widest blur here reaches over all pixels there are: picture
    by picture, tap by tap, it would cost 2.7 times as much.

    Parameters
    ----------
    n : int
    sigma : float
        Pixels.

    Returns
    -------
    (n, n) float64
        Each row sums to 1.
    """
    from scipy.ndimage import gaussian_filter1d

    result: NDArray[np.float64] = gaussian_filter1d(np.eye(n), sigma, axis=0)
    return result


# ---- What is hidden ------------------------------------------------------------------------------
# What a photograph hides of its sheet: highlights and black shadows.


_CLIPPED = 0.985  # linear light of all three colours: above it nothing is distinguished
_BRIGHTER = 1.25  # than the sheet's own paper: a highlight, not paper that is exposed so
_GLARE, _BLACK_SHADOW = 0.02, 0.05  # of the sheet, that may be hidden
_LIT = 0.4  # of the sheet: what is lighter than the rest, and less than that, is no paper
_CONTRAST = 1.4  # of natural logarithms: more than that of a shadow
_DARK = 0.012  # linear light of the paper: the camera's noise is as strong


def check_exposure(sheet: NDArray[np.float32], paper: NDArray[np.float32]) -> None:
    """Refuse a sheet of which too much cannot be seen.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.
    paper : (h, w, 3) float32
        The light of its paper alone, of any size.

    Raises
    ------
    InputError
        How much of it a highlight or a shadow hides.
    """
    usual = float(np.median(paper.min(axis=2)))
    clipped = float((sheet.min(axis=2) > _CLIPPED).mean())
    if _BRIGHTER * usual < _CLIPPED and clipped > _GLARE:
        raise InputError(
            "a highlight hides {clipped:.0%} of the sheet; expected light from the side: "
            "photograph it without a flash, away from a window's reflection",
            clipped=clipped,
        )
    hidden = float((paper.max(axis=2) < _DARK).mean())
    if hidden > _BLACK_SHADOW:
        raise InputError(
            "{hidden:.0%} of the sheet lies in black shadow; expected light all over: give the "
            "corners around what can be seen, or photograph it brighter",
            hint="--corners",
            hidden=hidden,
        )


def check_ground(sheet: NDArray[np.float32]) -> None:
    """Refuse white strokes on a dark ground unless they are asked for.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.

    Raises
    ------
    InputError
        If most of the sheet is dark, and the rest much lighter.
    """
    fraction, contrast = white_on_dark(sheet)
    if fraction < _LIT and contrast > _CONTRAST:
        raise InputError(
            "{share:.0%} of the sheet is white on a dark ground; expected dark strokes on paper",
            hint="of a rubbing: --invert",
            share=fraction,
        )


def white_on_dark(sheet: NDArray[np.float32]) -> tuple[float, float]:
    """Fraction of a sheet (H, W, 3) that is the lighter, and by how much: a natural logarithm."""
    grey = np.log(sheet[::3, ::3].mean(axis=2) + 0.004)
    lighter = grey > otsu(grey)
    contrast = float(grey[lighter].mean() - grey[~lighter].mean()) if lighter.any() else 0.0
    return float(lighter.mean()), contrast
