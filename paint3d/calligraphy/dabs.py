"""Dabs: what the strokes of a filled shape leave bare within it is painted by the tip of the brush.

A path keeps the largest footprint that fits about its line, which reaches no square end and no
cusp. Of what is left, each patch that would be seen gets a path of its own, as narrow as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt, find_objects, label

from paint3d.calligraphy.centre_line import CentreLine, OutlineField, centre_line
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.calligraphy.kernels.raster import fill_polygon
from paint3d.calligraphy.path_fit import PathFitter, PlanSettings, StrokePath
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["Shape", "dabs_in", "loads_of"]

Shape = tuple[AnyArray, Sequence[AnyArray]]
"""The outline (N, 2) of a stroke and its holes, mm."""

_PER_EM = 1024  # pixels
_RIM = 4  # pixels around all
_THICK = 2.0  # pixels: half of what a patch measures across at the least, to be seen
_OVERLAP = 10  # pixels that a dab goes on over what is painted
_ROUNDS = 3  # what is left of a patch by a dab along it is a patch again
_WORTH = 0.2  # fraction of a patch that a dab has to cover
_MOST = 400  # dabs
_STATIONS = 9
_LOAD = 0.12  # of the em square: the area that a load fills evenly


def dabs_in(
    shapes: Sequence[Shape],
    paths: Sequence[StrokePath],
    em_mm: float,
    footprints: FootprintTable,
    settings: PlanSettings,
) -> list[StrokePath]:
    """Paths through what others leave bare, each next to the one before.

    Parameters
    ----------
    shapes : sequence of Shape
    paths : sequence of StrokePath
        Through all of them, at least one.
    em_mm : float
        Side of the em square, mm: patches narrower than a 256th of it are not seen.
    footprints : FootprintTable
    settings : PlanSettings
    """
    step = em_mm / _PER_EM
    low = np.min([outline.min(axis=0) for outline, _ in shapes], axis=0) - _RIM * step
    high = np.max([outline.max(axis=0) for outline, _ in shapes], axis=0) + _RIM * step
    columns, rows = np.ceil((high - low) / step).astype(int) + 1
    grid = np.array([*low, step])
    wanted = _ink_mask(shapes, grid, (rows, columns))
    painted = np.zeros_like(wanted)
    for path in paths:
        _covered_mask(path, footprints, grid, painted)
    all_dabs: list[StrokePath] = []
    tried = np.zeros_like(wanted)
    for _ in range(_ROUNDS):
        dabs = []
        for patch, field in _patches(wanted, painted | tried, grid):
            dab = _dab(patch, field, em_mm, footprints, settings)
            if dab is None:
                tried |= patch
                continue
            before = int((patch & painted).sum())
            _covered_mask(dab, footprints, grid, painted)
            if (patch & painted).sum() - before < _WORTH * patch.sum():
                tried |= patch
            dabs.append(dab)
        all_dabs += dabs
        if not dabs or len(all_dabs) > _MOST:
            break
    return _order_by_nearness(all_dabs[:_MOST], paths[-1].centre[-1])


def loads_of(
    paths: Sequence[StrokePath], em_mm: float, footprints: FootprintTable
) -> list[list[StrokePath]]:
    """Paths of a filled shape in the parts that the brush is dipped before, so that it is even.

    A path is never broken off; one that fills more than a load begins with a full brush.
    """
    loads: list[list[StrokePath]] = []
    filled = math.inf
    for path in paths:
        lengths = np.linalg.norm(np.diff(path.centre, axis=0), axis=1)
        width = footprints.width_at(0.5 * (path.level[1:] + path.level[:-1]))
        own = float(lengths @ width) / em_mm**2
        if filled + own > _LOAD:
            loads.append([])
            filled = 0.0
        loads[-1].append(path)
        filled += own
    return loads


def _ink_mask(
    shapes: Sequence[Shape], grid: NDArray[np.float64], size: tuple[int, int]
) -> NDArray[np.bool_]:
    """Mask (H, W) of all shapes, sampled at the grid's points."""

    def filled(ring: AnyArray) -> NDArray[np.bool_]:
        mask = np.zeros(size, np.bool_)
        fill_polygon(np.ascontiguousarray((ring - grid[:2]) / grid[2] + 0.5), mask)
        return mask

    inked = np.zeros(size, np.bool_)
    for outline, holes in shapes:
        own = filled(outline)
        for hole in holes:
            own &= ~filled(hole)
        inked |= own
    return inked


def _covered_mask(
    path: StrokePath, footprints: FootprintTable, grid: AnyArray, painted: NDArray[np.bool_]
) -> None:
    kernels.cover(
        footprints.points, path.level, path.centre, path.azimuth, path.share, grid, painted
    )


def _patches(
    wanted: NDArray[np.bool_], painted: NDArray[np.bool_], grid: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.bool_], OutlineField]]:
    """Yield the bare patches (H, W), each with the distance field of the area open to a dab."""
    bare = wanted & ~painted
    core = distance_transform_edt(bare) >= _THICK
    thick = bare & (distance_transform_edt(~core) < _THICK)
    labels, _ = label(thick, np.ones((3, 3)))
    for number, (down, across) in enumerate(find_objects(labels), start=1):
        rim = _OVERLAP + _RIM
        box = (
            slice(max(down.start - rim, 0), down.stop + rim),
            slice(max(across.start - rim, 0), across.stop + rim),
        )
        patch = np.zeros_like(wanted)
        patch[box] = labels[box] == number
        free = wanted[box] & binary_dilation(patch[box], iterations=_OVERLAP)
        distance = distance_transform_edt(free) - distance_transform_edt(~free)
        corner = grid[:2] + grid[2] * np.array([box[1].start, box[0].start])
        yield patch, OutlineField(grid[2] * distance, np.array([*corner, grid[2]]))


def _dab(
    patch: NDArray[np.bool_],
    field: OutlineField,
    em_mm: float,
    footprints: FootprintTable,
    settings: PlanSettings,
) -> StrokePath | None:
    """The path along a patch; None where no footprint fits."""
    try:
        line = _line_of(field, settings.sample_step * em_mm)
    except InputError:
        return None
    return PathFitter(field, footprints, settings, em_mm, None).follow(line).path


def _line_of(field: OutlineField, step: float) -> CentreLine:
    """The line through the middles of a patch's sections across its principal axis."""
    rows, columns = np.nonzero(field.inside)
    points = field.grid[:2] + field.grid[2] * np.stack([columns, rows], axis=1)
    middle = points.mean(axis=0)
    direction = np.linalg.eigh(np.cov((points - middle).T))[1][:, -1]
    along = (points - middle) @ direction
    ends = np.linspace(along.min(), along.max(), _STATIONS + 1)
    station = np.clip(np.searchsorted(ends, along, "right") - 1, 0, _STATIONS - 1)
    middles = [points[station == k].mean(axis=0) for k in range(_STATIONS) if (station == k).any()]
    return centre_line(np.array(middles), field, step)


def _order_by_nearness(paths: list[StrokePath], at: AnyArray) -> list[StrokePath]:
    """Order paths greedily: each begins nearest to where the one before ends."""
    left, order = list(paths), []
    while left:
        apart = [float(np.linalg.norm(path.centre[0] - at)) for path in left]
        order.append(left.pop(int(np.argmin(apart))))
        at = order[-1].centre[-1]
    return order
