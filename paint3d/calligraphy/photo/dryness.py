"""Dryness of the brush along a stroke: the fraction of its body that the ink left bare."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.kernels.raster import fill_polygon
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, interpolate, line_length

__all__ = ["dryness_along", "region_of", "strength_of"]

_APART = 0.6  # stroke widths from station to station
_FEWEST, _MOST = 4, 32
_FULL = 70.0  # per cent of a stroke's inked pixels that are paler: its full ink
_PALEST = 0.35  # of the sheet's full ink, that a stroke's own full ink is at the least
_EDGE = 1.5  # pixels of the body's rim that are blurred with the paper
_EVEN = 0.04  # of unevenness that wet ink has too


def _stations_along(median: AnyArray, width: float, n: int | None = None) -> NDArray[np.float64]:
    """Even stations (K, 2) along a line, the middles of pieces of equal length.

    There are as many as a stroke of that width needs, or `n`.
    """
    along = arc_lengths(median)
    n = n or min(max(math.ceil(along[-1] / max(_APART * width, 1e-9)), _FEWEST), _MOST)
    return interpolate((np.arange(n) + 0.5) / n * along[-1], along, median)


def dryness_along(
    stroke: GlyphStroke,
    cover: NDArray[np.float32],
    inked: NDArray[np.bool_],
    n: int | None = None,
) -> tuple[tuple[float, ...], float]:
    """Dryness of a stroke at even stations, and the strength of its ink.

    Parameters
    ----------
    stroke : GlyphStroke
        In pixels of the sheet, y down.
    cover : (H, W) float32
        How much of a pixel is inked, 0 to 1.
    inked : (H, W) bool
        Where ink is.
    n : int, optional
        How many stations.

    Returns
    -------
    tuple of float
        The fraction that is bare at each station, 0 to 1.
    float
        How strong its own unbroken ink is, against the sheet's.
    """
    from scipy.spatial import cKDTree

    box, region = region_of(stroke, cover.shape)
    values = cover[box]
    ink = values[region & inked[box]]
    own = max(float(np.percentile(ink, _FULL)), _PALEST) if len(ink) else 1.0
    rows, columns = np.nonzero(_core(region))
    pixels = np.column_stack([columns + box[1].start, rows + box[0].start]) + 0.5
    width = region.sum() / max(line_length(stroke.median), 1.0)
    stations = _stations_along(stroke.median, width, n)
    _, nearest = cKDTree(stations).query(pixels)
    covered = np.clip(values[rows, columns] / own / (1.0 - _EVEN), 0.0, 1.0)
    counts = np.bincount(nearest, minlength=len(stations))
    sums = np.bincount(nearest, covered, minlength=len(stations))
    bare = 1.0 - sums / np.maximum(counts, 1)
    known = np.flatnonzero(counts)
    bare = np.interp(np.arange(len(stations)), known, bare[known]) if len(known) else 0.0 * bare
    return tuple(np.round(np.clip(bare, 0.0, 1.0), 3).tolist()), own


def strength_of(
    stroke: GlyphStroke, density: NDArray[np.float32], inked: NDArray[np.bool_]
) -> float:
    """Fraction of the paper's light that the unbroken ink of a stroke takes.

    Parameters
    ----------
    stroke : GlyphStroke
        In pixels of the sheet, y down.
    density : (H, W) float32
        -log10 of the light.
    inked : (H, W) bool
        Where ink is.
    """
    box, region = region_of(stroke, density.shape)
    region = _core(region)
    ink = density[box][region & inked[box]]
    return 1.0 - 10.0 ** -float(np.percentile(ink, _FULL)) if len(ink) else 0.0


def region_of(
    stroke: GlyphStroke, size: tuple[int, ...]
) -> tuple[tuple[slice, slice], NDArray[np.bool_]]:
    """The pixels of a stroke's region: the box around it (rows, columns), and a mask of that box.

    Parameters
    ----------
    stroke : GlyphStroke
        In pixels of the sheet, y down.
    size : (int, int)
        Height and width of the sheet, pixels.
    """
    low = np.clip(np.floor(stroke.outline.min(axis=0)) - 1.0, 0.0, size[::-1]).astype(int)
    high = np.clip(np.ceil(stroke.outline.max(axis=0)) + 2.0, low, size[::-1]).astype(int)
    shape = (high[1] - low[1], high[0] - low[0])
    region, holes = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_)
    fill_polygon(np.ascontiguousarray(stroke.outline - low), region)
    for hole in stroke.holes:
        fill_polygon(np.ascontiguousarray(hole - low), holes)
    return (slice(low[1], high[1]), slice(low[0], high[0])), region & ~holes


def _core(region: AnyArray) -> NDArray[np.bool_]:
    """A region without its rim, or all of it where it is thin."""
    from scipy.ndimage import distance_transform_edt

    depth = distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]
    core: NDArray[np.bool_] = depth > _EDGE
    return core if core.sum() > 0.3 * region.sum() else region
