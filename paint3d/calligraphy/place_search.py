"""Places on an object that a text may be tried at, and the frames of what is written there."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceFrame, frame_at
from paint3d.mesh.placement import SIDES, is_flat, place, upwards

__all__ = ["frames_to_try", "upright_frame", "walking_step"]

_TURNS = (0.5, 0.375, 0.625, 0.25, 0.75, 0.125, 0.875, 0.0)  # from the front to the back
_HEIGHTS = (0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9)
_ACROSS = (0.5, 0.35, 0.65, 0.2, 0.8)
_SCATTERED = 60
_GOLDEN = (0.7548776662466927, 0.5698402909980532)  # even in the plane: Roberts' R2 sequence
_STEPS_PER_EM, _LEAST_STEP_MM = 8.0, 0.1


def walking_step(em_mm: float) -> float:
    """How long a step (mm) of the lines is that a text of an em runs along."""
    return max(em_mm / _STEPS_PER_EM, _LEAST_STEP_MM)


def upright_frame(surface: ClosestPoints, point: AnyArray, up: AnyArray) -> SurfaceFrame:
    """The frame at a point (3,) of a surface with an upwards.

    Raises
    ------
    MeshError
        If the surface lies level there.
    """
    try:
        return frame_at(surface, point, up)
    except InputError:
        raise MeshError(
            f"{surface.mesh.name}: the surface lies level at {point.round(1).tolist()}; "
            "expected a place with an upwards"
        ) from None


def frames_to_try(surface: ClosestPoints, side: str | None) -> Iterator[SurfaceFrame]:
    """Frames all over an object, those nearest to the middle of its front first.

    Parameters
    ----------
    surface : ClosestPoints
    side : {"outside", "inside", "top", "bottom"}, optional
        From where one looks; by default the object's usual side first, then the others, and at
        last places spread evenly over its area, which no side may show.
    """
    usual = "top" if is_flat(surface) else "outside"
    sides = [side] if side is not None else [usual, *(s for s in SIDES if s != usual)]
    for looked_from in sides:
        level = looked_from in ("top", "bottom")
        grid = product(_ACROSS, _ACROSS) if level else product(_TURNS, _HEIGHTS)
        for at in sorted(grid, key=lambda at: abs(at[0] - 0.5) + 0.5 * abs(at[1] - 0.5)):
            try:
                yield place(surface, at, side=looked_from)
            except MeshError:
                continue
    if side is None:
        yield from _scattered(surface)


def _scattered(surface: ClosestPoints) -> Iterator[SurfaceFrame]:
    """Frames spread over the surface by area, from triangle to triangle in the mesh's order."""
    mesh = surface.mesh
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    sides = corners[:, 1:] - corners[:, :1]
    passed = np.cumsum(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))
    share = (np.arange(_SCATTERED) + 0.5) / _SCATTERED
    faces = np.searchsorted(passed, share * passed[-1])
    first, second = np.modf(np.outer(np.arange(1, _SCATTERED + 1), _GOLDEN))[0].T
    folded = first + second > 1.0  # the other half of the parallelogram
    weights = np.stack([first, second], axis=1)
    weights[folded] = 1.0 - weights[folded]
    points = corners[faces, 0] + np.einsum("nk,nkd->nd", weights, sides[faces])
    for point, normal in zip(points, mesh.face_normals[faces], strict=True):
        yield frame_at(surface, point, upwards(normal))
