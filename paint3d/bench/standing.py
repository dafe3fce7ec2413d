"""Stamps that stand alone: gather, plane, projection and deposit without contact or stroke."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.bench.kernels.standing import deposit_standing, place_standing
from paint3d.brush_engine.footprint import Stamp, make_stamp
from paint3d.brush_engine.scratch import make_scratch
from paint3d.painter.painter import Painter

__all__ = ["StandingStamps"]


class StandingStamps:
    """Stamps placed once on a surface; calling it leaves all of them there, one by one.

    Each time the patch of surface inside the enclosing sphere is found, its mean normal taken, the
    vertices under the outline gathered, projected along their own normals, weighed, and inked.

    Parameters
    ----------
    painter : Painter
        Its surface must need no refinement.
    poses : (D, 9) float64
        Position, quaternion wxyz, pressure, 0.
    """

    def __init__(self, painter: Painter, poses: NDArray[np.float64]) -> None:
        surface = painter.surface
        n = len(poses)
        self._painter = painter
        self._scratch = make_scratch(surface.paint_mesh, len(surface.pigments))
        self._before, self._after = make_stamp(), make_stamp()
        rows = [np.zeros((n, *array.shape), array.dtype) for array in make_stamp()]
        self._stamps = Stamp(*rows)
        self.counters = self._scratch.counters
        field = surface.paint_mesh.arrays
        place_standing(
            poses,
            painter.tuft,
            surface.contact_tree,
            field,
            self._scratch,
            self._after,
            self._stamps,
        )

    def __call__(self) -> None:
        """Leave every stamp once."""
        surface = self._painter.surface
        deposit_standing(
            self._stamps, self._painter.tuft, surface.paint_mesh.arrays, surface.ink, self._scratch,
            self._before, self._after,
        )  # fmt: skip
