"""Gather, project and deposit as one would write it with SciPy and NumPy: the competitor.

It follows Guo 2017, section 4.2.1, word for word: vertices inside a ball, their mean normal, each
carried to the plane along its own normal, painted where it falls inside the outline. One stamp a
dab and no sweep, no check of connectedness, no contact search: it does less.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from paint3d.brush.footprint import Footprint
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["PlainSurface"]

_LEAST_FACING = 0.25


class PlainSurface:
    """The vertices of a surface in a k-d tree, and ink on them.

    Parameters
    ----------
    surface : PaintedSurface
        Only read; its vertices as they are now.
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self.points = surface.paint_mesh.vertices
        self.normals = surface.paint_mesh.normals
        self.areas = surface.vertex_areas.astype(np.float32)
        self.edge = np.float32(np.sqrt(self.areas.mean()))
        self.tree = cKDTree(self.points)
        self.amounts = np.zeros(len(self.points), np.float32)
        self.coverage = np.zeros(len(self.points), np.float32)
        self.dirty = np.zeros(len(self.points), bool)

    def stamp(
        self,
        foot: NDArray[np.float64],
        along: NDArray[np.float64],
        footprint: Footprint,
        ball: tuple[AnyArray, float],
        released: float,
    ) -> int:
        """Leave ink under a footprint; return how many vertices lay in the ball.

        Parameters
        ----------
        foot, along : (3,) float64
            P'_m and the direction of the bend.
        footprint : Footprint
        ball : (centre (3,), radius)
            Where to look for vertices, mm.
        released : float
            Ink, coats x mm2.
        """
        ids = np.asarray(self.tree.query_ball_point(*ball), dtype=np.intp)
        offsets, normals = self.points[ids] - foot.astype(np.float32), self.normals[ids]
        up = normals.mean(axis=0)
        up /= np.linalg.norm(up)
        cosines = normals @ up
        steps = -(offsets @ up) / np.maximum(cosines, _LEAST_FACING)
        carried = offsets + steps[:, None] * normals
        bend = along - (along @ up) * up
        bend = (bend / np.linalg.norm(bend)).astype(np.float32)
        x, y = carried @ bend, carried @ np.cross(up, bend)
        reach, half_width = footprint.reach[::-1], footprint.half_width[::-1]
        width = np.interp(x, reach, half_width, left=-np.inf, right=-np.inf)
        cover = np.clip(0.5 + (width - np.abs(y)) / self.edge, 0.0, 1.0)
        cover[cosines < _LEAST_FACING] = 0.0
        inside = np.flatnonzero(cover)
        ids, cover = ids[inside], cover[inside].astype(np.float32)
        share = cover / cosines[inside] ** 2
        weighed = float(share @ self.areas[ids])
        self.amounts[ids] += share * (released / weighed)
        self.coverage[ids] = np.maximum(self.coverage[ids], cover)
        self.dirty[ids] = True
        return len(offsets)
