"""A square or a box laid on a surface: its chart, how much it is bent, whether two overlap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.mesh.chart import SurfaceChart, SurfaceFrame, make_chart
from paint3d.mesh.closest_points import ClosestPoints

__all__ = ["EmSquare", "SquareLimits", "lay_square"]

_NODES = 12  # of the chart along an em
_PROBES = 20  # points along an em that are looked at
_FEWEST = 6  # points along a side, however short it is
_FINEST_MM = 0.25
_FREE = 0.7  # of the height: nearer than that, something is in the way, or a hollow too tight


@dataclass(frozen=True)
class SquareLimits:
    """What a square may be like and still be written in.

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
        Share of the em around the square that must lie on the surface as well, for the handle.
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
        p = self.points
        edges = (p[:, 0], p[-1], p[:, -1], p[0])
        return np.array([np.linalg.norm(np.diff(e, axis=0), axis=1).sum() for e in edges])

    def corner_angles(self) -> NDArray[np.float64]:
        """Angles (4,) between the sides that meet in each corner, rad."""
        p = self.points
        angles = []
        for i, di in ((0, 1), (-1, -1)):
            for j, dj in ((0, 1), (-1, -1)):
                one, two = p[i + di, j] - p[i, j], p[i, j + dj] - p[i, j]
                normal = self.normals[i, j]
                one, two = one - normal * (one @ normal), two - normal * (two @ normal)
                cosine = one @ two / (np.linalg.norm(one) * np.linalg.norm(two))
                angles.append(math.acos(min(1.0, max(-1.0, cosine))))
        return np.array(angles)

    def fault(self, limits: SquareLimits) -> str | None:
        """Why one cannot write here, or None."""
        n = self.normals
        neighbours = [(n[1:] * n[:-1]).sum(-1).min(), (n[:, 1:] * n[:, :-1]).sum(-1).min()]
        if min(neighbours) < math.cos(limits.crease):
            return "the surface has an edge or a tight bend there"
        if (n @ self.chart.frame.normal).min() < math.cos(limits.turn):
            return "the surface turns away there"
        wanted = np.array([self.width_mm, self.height_mm, self.width_mm, self.height_mm])
        stretch = np.abs(self.sides() / wanted - 1.0).max()
        shear = np.abs(self.corner_angles() - 0.5 * math.pi).max()
        if stretch > limits.stretch or shear > limits.shear:
            return (
                f"the surface is so curved there that the square would be stretched by "
                f"{100.0 * stretch:.0f} % and sheared by {math.degrees(shear):.0f} degrees"
            )
        return None

    def overlap(self, other: EmSquare) -> float:
        """How far (mm) the other square reaches into this one; 0 where they are apart."""
        edge = other.points
        rim = np.concatenate([edge[:, 0], edge[-1], edge[::-1, -1], edge[0, ::-1]])
        flat = self.points.reshape(-1, 3)
        apart = np.linalg.norm(rim[:, None] - flat, axis=2)
        nearest = apart.argmin(axis=1)
        size = np.array([self.width_mm, self.height_mm])
        spacings = size / (np.array(self.points.shape[:2]) - 1)
        spacing = float(spacings.max())
        close = apart[np.arange(len(rim)), nearest] < 1.5 * spacing
        i, j = np.divmod(nearest[close], self.points.shape[1])
        at = np.stack([i, j], axis=1) * spacings - 0.5 * size
        axes = self.chart.tangents(at)
        local = np.einsum("nk,nkd->nd", rim[close] - flat[nearest[close]], axes)
        thin = np.abs(local[:, 2]) < 0.5 * spacing  # not the other side of a thin wall
        inside = (0.5 * size - np.abs(at + local[:, :2])).min(axis=1)
        return float(np.max(inside[thin], initial=0.0))


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
    limits = limits or SquareLimits()
    width, height = size or (em_mm, em_mm)
    spacing = em_mm / _NODES
    halves = [(0.5 + limits.margin * (em_mm / side)) * side for side in (width, height)]
    try:
        chart = make_chart(surface, frame, halves[0], halves[1], spacing, max(spacing, _FINEST_MM))
    except MeshError:
        raise _no_place(surface, frame, em_mm, "the surface ends within it") from None
    lines = [
        np.linspace(-0.5 * side, 0.5 * side, _probes(side / em_mm) + 1) for side in (width, height)
    ]
    xy = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    shape = (len(lines[0]), len(lines[1]), 3)
    points, normals = chart.points(xy).reshape(shape), chart.normals(xy).reshape(shape)
    square = EmSquare(chart, em_mm, width, height, points, normals)
    fault = square.fault(limits)
    if fault is None and not _is_free(surface, square, limits.room_mm):
        fault = "there is no room for the brush above it"
    if fault is not None:
        raise _no_place(surface, frame, em_mm, fault)
    return square


def _probes(ems: float) -> int:
    """How many steps a side of so many ems is looked at in."""
    return max(_FEWEST, round(_PROBES * ems))


def _is_free(surface: ClosestPoints, square: EmSquare, height: float) -> bool:
    """Whether from so high above the square (mm) nothing is nearer than the square itself."""
    if height <= 0.0:
        return True
    some = tuple(slice(None, None, min(_PROBES // 4, n // 2)) for n in square.points.shape[:2])
    foot = square.points[some].reshape(-1, 3)
    above = foot + height * square.normals[some].reshape(-1, 3)
    nearest = np.linalg.norm(surface.find(above).points - above, axis=1)
    return bool((nearest > _FREE * height).all())


def _no_place(surface: ClosestPoints, frame: SurfaceFrame, em_mm: float, why: str) -> MeshError:
    x, y, z = frame.origin
    return MeshError(
        f"{surface.mesh.name}: no place for an em of {em_mm:g} mm around "
        f"({x:.1f}, {y:.1f}, {z:.1f}): {why}"
    )
