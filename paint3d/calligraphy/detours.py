"""Bare corners of a stroke, and how its line goes there: by a bend, or out into the tip and back.

A bend suits what lies beside a line that goes on. Where it ends, or is folded, the tuft is led from
where a disc reaches nearest to the corner straight into its tip, as narrow as it gets, and back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.centre_line import CentreLine, OutlineField, measured, resampled
from paint3d.calligraphy.kernels.patches import fill_depths, label_patches

__all__ = ["Corner", "corners_in", "detours_to", "visiting"]

_LEAST_AREA = 1.8  # of the square of the disc that must fit into a patch
_OTHER_TIP = 0.25  # widths: two tips of a corner that are nearer to each other are one
_NEAR_END = 0.5  # widths: a bend nearer to an end than that would only move the end
_BEND = 0.3  # widths to either side that a bend takes
_BEND_REACH = 1.2  # widths: beyond, the line stays


@dataclass(frozen=True, eq=False)
class Corner:
    """A bare patch that is worth a detour.

    Attributes
    ----------
    middle : (2,) float64
        Its innermost point, mm.
    points : (N, 2) float64
        The grid points in it, mm.
    at : ((N,) int64, (N,) int64)
        Their rows and columns.
    """

    middle: NDArray[np.float64]
    points: NDArray[np.float64]
    at: tuple[NDArray[np.int64], NDArray[np.int64]]


def corners_in(
    bare: NDArray[np.bool_], line: CentreLine, field: OutlineField, finest: float
) -> list[Corner]:
    """The bare patches (H, W) that are worth a detour, the largest first.

    A patch counts where a disc of the share `finest` of the stroke's width would fit in.
    """
    step = float(field.grid[2])
    disc = finest * line.width / step
    depth, labels = np.empty(bare.shape), np.empty(bare.shape, np.int32)
    fill_depths(bare, depth)
    n = label_patches(bare, labels)
    deepest = np.zeros(n + 1)
    np.maximum.at(deepest, labels[bare], depth[bare])
    areas = np.bincount(labels.ravel(), minlength=n + 1) * (deepest > 0.5 * disc)
    large = [k for k in np.argsort(-areas, kind="stable") if areas[k] >= _LEAST_AREA * disc**2]
    corners = []
    for k in large:
        rows, columns = np.nonzero(labels == k)
        points = field.grid[:2] + step * np.stack([columns, rows], axis=1)
        middle = points[int(np.argmax(depth[rows, columns]))]
        corners.append(Corner(middle, points, (rows, columns)))
    return corners


def detours_to(
    corner: Corner, line: CentreLine, field: OutlineField, held: bool
) -> Iterator[CentreLine]:
    """The line with its detours to a corner: visits, and a bend where it goes on beyond.

    A second visit goes to what lies farthest towards the corner's middle, where that is not the
    farthest of it: a rim runs on from there that is too thin to be worth a way.

    Where the bend of the tuft is `held` against the motion nothing turns back: a bend only.
    """
    if not held:
        yield visiting(line, corner, field)
        k, tip = _leaving(line, corner, field)
        ahead = (corner.points - line.points[k]) @ (corner.middle - line.points[k])
        other = corner.points[int(np.argmax(ahead))]
        if np.linalg.norm(other - tip) > _OTHER_TIP * line.width:
            yield _to(other, k, line, field)
    nearest = int(np.argmin(np.linalg.norm(line.points - corner.middle, axis=1)))
    if held or min(nearest, len(line.points) - 1 - nearest) * line.step > _NEAR_END * line.width:
        yield _bent(line, corner, nearest, field)


def _bent(line: CentreLine, corner: Corner, nearest: int, field: OutlineField) -> CentreLine:
    """Bend a line out to a corner beside it and back, within about a width."""
    apart = np.linalg.norm(line.points - corner.middle, axis=1)
    along = (np.arange(len(apart)) - nearest) * line.step / line.width
    near = np.flatnonzero(np.abs(along) < _BEND_REACH)
    bump = np.exp(-0.5 * (along[near] / _BEND) ** 2)[:, None]
    bent = line.points[near] + bump * (corner.middle - line.points[nearest])
    before, after = line.points[: near[0]], line.points[near[-1] + 1 :]
    points = np.concatenate([before, resampled(bent, line.step), after])
    return measured(points, line.width, line.step, field)


def visiting(line: CentreLine, corner: Corner, field: OutlineField) -> CentreLine:
    """Leave a line, where a disc on it reaches nearest to a corner, for its tip and come back."""
    k, tip = _leaving(line, corner, field)
    return _to(tip, k, line, field)


def _leaving(
    line: CentreLine, corner: Corner, field: OutlineField
) -> tuple[int, NDArray[np.float64]]:
    """The sample from which a corner is visited, and its point that is farthest from there."""
    apart = np.linalg.norm(line.points - corner.middle, axis=1)
    k = int(np.argmin(apart / np.maximum(field.depths(line.points), 0.5 * field.grid[2])))
    far = np.linalg.norm(corner.points - line.points[k], axis=1)
    return k, corner.points[int(np.argmax(far))]


def _to(tip: NDArray[np.float64], k: int, line: CentreLine, field: OutlineField) -> CentreLine:
    """A line that goes from its k-th sample straight to a point, and back."""
    start = line.points[k]
    n = max(2, math.ceil(float(np.linalg.norm(tip - start)) / line.step))
    out = start + np.linspace(0.0, 1.0, n + 1)[:, None] * (tip - start)
    points = np.concatenate([line.points[:k], out, out[-2::-1], line.points[k + 1 :]])
    return measured(points, line.width, line.step, field)
