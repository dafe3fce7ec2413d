"""Profiles of thrown vessels: smooth curves in the (radius, height) half plane, with normals.

A profile is a chain of pieces that meet with one tangent. Seen along the direction of travel the
material lies on the right, so the left normal points out of the clay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["Arc", "Line", "Offset", "Piece", "sample_profile", "vessel_profile"]

Point = tuple[float, float]


class Piece(Protocol):
    """A smooth curve with a parameter from 0 to 1."""

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents, (N, 2) each, at the parameters `t` (N,)."""
        ...


@dataclass(frozen=True)
class Line:
    """The straight piece from `start` to `end`, mm."""

    start: Point
    end: Point

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        start, end = np.array(self.start), np.array(self.end)
        tangent = (end - start) / np.linalg.norm(end - start)
        return start + t[:, None] * (end - start), np.tile(tangent, (len(t), 1))


@dataclass(frozen=True)
class Arc:
    """The circular piece about `centre` from angle `start` to `end`, rad; either sense."""

    centre: Point
    radius: float
    start: float
    end: float

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        angle = self.start + t * (self.end - self.start)
        ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        turn = math.copysign(1.0, self.end - self.start)
        tangent = turn * np.stack([-ray[:, 1], ray[:, 0]], axis=1)
        return np.array(self.centre) + self.radius * ray, tangent


@dataclass(frozen=True)
class Offset:
    """A cubic Bezier curve moved by `distance` mm to its left; `backwards` from its end.

    Both faces of a wall are offsets of its middle line, so the wall has one thickness and its
    normals are exactly those of the middle line.
    """

    controls: tuple[Point, Point, Point, Point]
    distance: float
    backwards: bool = False

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        s = (1.0 - t if self.backwards else t)[:, None]
        p = np.array(self.controls)
        point = (1 - s) ** 3 * p[0] + 3 * (1 - s) ** 2 * s * p[1]
        point = point + 3 * (1 - s) * s**2 * p[2] + s**3 * p[3]
        d = np.diff(p, axis=0)
        velocity = (1 - s) ** 2 * d[0] + 2 * (1 - s) * s * d[1] + s**2 * d[2]
        tangent = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
        left = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        return point + self.distance * left, -tangent if self.backwards else tangent


def vessel_profile(
    wall: Sequence[tuple[Point, Point, Point, Point]],
    thickness: float,
    foot_radius: float,
    foot_height: float,
) -> list[Piece]:
    """Return the closed profile of a vessel that stands on a foot ring at height 0.

    Parameters
    ----------
    wall : sequence of four (radius, height) points, mm
        Cubic Beziers of the wall's middle line from the flat floor to the lip; the first starts
        level, at height foot_height + thickness / 2.
    thickness : float
        Of wall, floor and foot ring, mm.
    foot_radius, foot_height : float
        Middle radius of the foot ring and height of the floor's underside, mm.

    Returns
    -------
    list of Piece
        From the axis along the inside, round the lip, down the outside, round the foot ring and
        back to the axis.
    """
    half = thickness / 2.0
    floor_radius = wall[0][0][0]
    lip = np.array(wall[-1][3])
    rise = lip - np.array(wall[-1][2])
    across = math.atan2(rise[1], rise[0]) + math.pi / 2.0
    top = foot_height + thickness
    inside: list[Piece] = [Line((0.0, top), (floor_radius, top)), *(Offset(c, half) for c in wall)]
    turns = (across, math.pi / 2.0, 0.0, across - math.pi)  # stops at the highest and widest point
    centre = (float(lip[0]), float(lip[1]))
    round_lip = [Arc(centre, half, a, b) for a, b in pairwise(turns)]
    outside = [Offset(c, -half, backwards=True) for c in reversed(wall)]
    foot = _foot_ring(floor_radius, foot_radius, foot_height, half)
    return [*inside, *round_lip, *outside, *foot]


def _foot_ring(floor: float, ring: float, height: float, half: float) -> list[Piece]:
    """Return the underside, travelled inwards: a round-bottomed ring with fillets of `half`."""
    outer, inner, up = ring + half, ring - half, height - half
    quarter = math.pi / 2.0
    return [
        Line((floor, height), (outer + half, height)),
        Arc((outer + half, up), half, quarter, 2 * quarter),
        Line((outer, up), (outer, half)),
        Arc((ring, half), half, 0.0, -quarter),
        Arc((ring, half), half, -quarter, -2 * quarter),
        Line((inner, half), (inner, up)),
        Arc((inner - half, up), half, 0.0, quarter),
        Line((inner - half, height), (0.0, height)),
    ]


def sample_profile(
    pieces: Sequence[Piece], spacing: float, max_turn: float = math.radians(36.0)
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points and outward normals along a profile, (N, 2) each, evenly spaced by piece.

    Parameters
    ----------
    pieces : sequence of Piece
    spacing : float
        Wanted distance of neighbours, mm.
    max_turn : float
        Largest turn of the tangent between neighbours, rad: tight curves get more points.
    """
    points, normals = [], []
    for k, piece in enumerate(pieces):
        fine, tangent = piece.at(np.linspace(0.0, 1.0, 2001))
        length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))]
        cosine = np.clip(np.einsum("ij,ij->i", tangent[1:], tangent[:-1]), -1.0, 1.0)
        turn = float(np.arccos(cosine).sum())
        n = max(1, round(length[-1] / spacing), math.ceil(turn / max_turn - 1e-9))
        at = np.interp(np.linspace(0.0, length[-1], n + 1), length, np.linspace(0.0, 1.0, 2001))
        point, tangent = piece.at(at if k == 0 else at[1:])
        points.append(point)
        normals.append(np.stack([-tangent[:, 1], tangent[:, 0]], axis=1))
    return np.concatenate(points), np.concatenate(normals)
