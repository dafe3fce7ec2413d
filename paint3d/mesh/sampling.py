"""Points spread evenly over a mesh, always the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["sample_evenly"]

_STEPS = (0.7548776662466927, 0.5698402909980532)  # irrational: Roberts' R2 sequence


def sample_evenly(mesh: TriangleMesh, n: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Faces (n,) of points spread evenly by area, and the weights (n, 3) of their corners."""
    ends = np.cumsum(mesh.double_areas)
    at = (np.arange(n) + 0.5) / n * ends[-1]
    faces = np.minimum(np.searchsorted(ends, at), mesh.n_faces - 1)
    u, v = ((np.arange(n) * step) % 1.0 for step in _STEPS)
    over = u + v > 1.0  # in the other half of the parallelogram
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    return faces, np.stack([1.0 - u - v, u, v], axis=1)
