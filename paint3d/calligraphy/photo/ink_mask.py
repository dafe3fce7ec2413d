"""Where ink is on a sheet, and the strokes' bodies: as far as the brush went, flying white too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.photo.bodies import bodies_in, without_specks
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["InkMask", "find_ink", "otsu"]

_LOW, _HIGH = 0.3, 0.45  # of Otsu's threshold: ink goes on to the one where it reaches the other
_EDGE = 0.575  # of the light that ink near by takes: there an edge lies, however it is blurred
_FAINT = 0.5  # the same of ink that is a dry stroke's, though its edge may be farther in
_LENS = 1.0  # pixels: how far a photograph spreads what is narrow
_NOISES = 5.0  # standard deviations of the paper that ink stands out by at the least
_FAINTEST = 0.06  # density of the palest ink that is one
_SPECK = 0.01  # squares of a stroke's width: smaller bits of ink are dust
_MARGIN = 0.012  # of the sheet's shorter side: its edges are no strokes
_MOST = 0.6  # of the sheet: more than that is no writing
_LEAST = 2e-4
_DITHERED = 30.0  # pixels of ink to each piece of it and hole in it: fewer is no writing
_MOST_PIECES = 2000  # the same of strokes' bodies on a sheet
_SAME = 1e-6  # of the larger: values that differ by less are the same
_COARSEST = 5.0  # pixels: narrower strokes are too coarse to be taken apart


@dataclass(frozen=True, eq=False)
class InkMask:
    """Ink on a sheet.

    Attributes
    ----------
    cover : (H, W) float32
        What share of the paper's light the ink takes, over that of unbroken ink: how much of a
        pixel is inked, 0 to 1.
    mask : (H, W) bool
        Where ink is.
    body : (H, W) bool
        What the strokes cover, with the bare streaks in them.
    width : float
        Of a usual stroke, pixels.
    full : float
        Share of the light that unbroken ink takes.
    """

    cover: NDArray[np.float32]
    mask: NDArray[np.bool_]
    body: NDArray[np.bool_]
    width: float
    full: float


def find_ink(density: NDArray[np.float32]) -> InkMask:
    """Find the ink on a sheet by its density (H, W).

    Raises
    ------
    InputError
        If there is none, or too much, if it lies in dots, in more pieces than writing has, or if
        its strokes are too few pixels wide.
    """
    from scipy.ndimage import gaussian_filter

    margin = max(1, round(_MARGIN * min(density.shape)))
    inner = np.zeros(density.shape, bool)
    inner[margin:-margin, margin:-margin] = True
    smooth = np.where(inner, gaussian_filter(density, 0.5), 0.0)
    taken = 1.0 - 10.0 ** -np.where(inner, density, 0.0)  # linear in what is inked of a pixel
    near = _inked(smooth, inner)
    share = (2.0 * taken - gaussian_filter(taken, _LENS)) / np.maximum(
        _taken_near(taken, near), 1e-6
    )
    mask, faint = near & (share > _EDGE), near & (share > _FAINT)
    if mask.mean() < _LEAST:
        raise InputError(
            "no ink was found on the sheet; expected dark strokes on paper (of a rubbing: --invert)"
        )
    if mask.sum() > _MOST * inner.sum():
        raise InputError(
            f"{mask.sum() / inner.sum():.0%} of the sheet is dark; expected writing on paper: of a "
            "rubbing --invert, of a picture that shows no sheet --corners around the paper"
        )
    width = _width(mask)
    mask, faint = (without_specks(one, _SPECK * width**2) for one in (mask, faint))
    pieces = _pieces_and_holes(mask)
    if mask.sum() < _DITHERED * pieces:
        raise InputError(
            f"the ink lies in {pieces:,} dots and gaps of a few pixels, as greys do that are "
            "dithered to black and white; expected strokes: scan in grey"
        )
    body = bodies_in(mask, faint, width)
    pieces = _pieces_and_holes(body)
    if pieces > _MOST_PIECES:
        raise InputError(
            f"the ink lies in {pieces:,} pieces and gaps in them; expected writing, of "
            f"{_MOST_PIECES:,} at the most: crop it to fewer characters, or give --corners around "
            "them"
        )
    mask &= body
    width = _width(body)
    if width < _COARSEST:
        raise InputError(
            f"strokes are {width:.1f} pixels wide on the straightened sheet; expected "
            f"{_COARSEST:g} or more: photograph it from nearer, or crop it to fewer characters"
        )
    full = max(float(np.percentile(taken[mask], 75.0)), 1e-3)
    return InkMask(np.clip(taken / full, 0.0, 1.0).astype(np.float32), mask, body, width, full)


def _pieces_and_holes(mask: NDArray[np.bool_]) -> int:
    """How many connected pieces a mask has, and holes in them."""
    from scipy.ndimage import label

    _, pieces = label(mask, np.ones((3, 3)))
    _, holes = label(~mask)
    return int(pieces + holes) - 1  # around all of them is no hole


def _inked(density: AnyArray, inner: AnyArray) -> NDArray[np.bool_]:
    """Places where the density is high, and those around them where it is not low."""
    from scipy.ndimage import label

    values = density[inner]
    middle = float(np.median(values))
    noise = 1.4826 * float(np.median(np.abs(values - middle)))
    threshold = otsu(np.clip(values, 0.0, np.percentile(values, 99.8)))
    low = max(_LOW * threshold, middle + _NOISES * noise, _FAINTEST)
    high = max(_HIGH * threshold, 1.05 * low)
    areas, n = label(density > low, np.ones((3, 3)))
    reached = np.zeros(n + 1, bool)
    reached[np.unique(areas[density > high])] = True
    reached[0] = False
    result: NDArray[np.bool_] = reached[areas]
    return result


def _taken_near(taken: AnyArray, near: AnyArray) -> NDArray[np.float64]:
    """The share of light that unbroken ink takes around each place."""
    from scipy.ndimage import gaussian_filter, maximum_filter

    reach = max(3, 2 * round(0.5 * _width(near)) + 1)
    most = maximum_filter(np.where(near, gaussian_filter(taken, 0.7), 0.0), reach)
    result: NDArray[np.float64] = gaussian_filter(most, 0.25 * reach)
    return result


def otsu(values: AnyArray) -> float:
    """The threshold that parts values into two classes of least variance (Otsu 1979).

    Of values that are all the same it is that value.
    """
    highest = float(values.max())
    if highest - float(values.min()) < _SAME * max(abs(highest), 1.0):
        return highest
    counts, edges = np.histogram(values, 256)
    middles = 0.5 * (edges[:-1] + edges[1:])
    below, sums = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    means = sums / np.maximum(below, 1), (sums[-1] - sums) / np.maximum(above, 1)
    between = below * above * (means[0] - means[1]) ** 2.0
    return float(middles[int(np.argmax(between))])


def _width(mask: AnyArray) -> float:
    """Of a usual stroke, pixels: twice the depth along the middle lines that half the ink has."""
    from scipy.ndimage import distance_transform_edt, maximum_filter

    depth = distance_transform_edt(mask)
    ridge = mask & (depth >= maximum_filter(depth, 3) - 1e-6) & (depth > 1.0)
    if not ridge.any():
        return 1.0
    depths = np.sort(depth[ridge])  # each stands for as much ink: streaks count for little
    share = np.cumsum(depths)
    return 2.0 * float(depths[np.searchsorted(share, 0.5 * share[-1])])
