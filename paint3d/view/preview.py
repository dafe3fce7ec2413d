"""Small previews of an object in different orientations, fast and without OpenGL.

Points spread evenly over the surface are splatted back to front; a shadow shows the ground.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.sampling import sample_evenly
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Preview"]

_AZIMUTH, _HEIGHT = np.deg2rad(-60.0), np.deg2rad(22.0)  # of the eye
_LIGHT = np.array([-0.45, 0.35, 0.82], np.float32)  # in the picture: right, up, toward the eye
_SHADE = 0.42  # ambient fraction of the light
_F = np.float32  # precise enough for pixels
_CLAY = np.array([222.0, 216.0, 204.0], _F)
_GROUND, _SHADOW = np.array([238.0, 238.0, 236.0], _F), np.array([196.0, 196.0, 194.0], _F)
_LEVELS = 65535.0  # depth levels
_POINTS_A_PIXEL = 0.8
_FILLS = 0.86  # fraction of the picture's side that the object fills
_REACH = 5.0  # radius, pixels, within which `side_at` averages normals
_DETAIL = 2  # supersampling along each axis


class Preview:
    """Pictures of one object from the side, in different orientations.

    Parameters
    ----------
    mesh : TriangleMesh
    size : int
        Pixels along a side.
    """

    def __init__(self, mesh: TriangleMesh, size: int = 200) -> None:
        self.size = size
        n = _points_for(size)
        face, shares = sample_evenly(mesh, n)
        weights = shares.astype(_F)
        corners = mesh.faces[face]
        middle = mesh.bounds.mean(axis=0)
        centred = (mesh.vertices[corners] - middle).astype(_F)
        self._points = np.einsum("nc,nci->ni", weights, centred)
        self._normals = mesh.face_normals[face].astype(_F)
        self._own = np.broadcast_to(_CLAY, (n, 3))
        if mesh.colours is not None:
            self._own = np.einsum("nc,nci->ni", weights, mesh.colours[corners].astype(_F))

    def smaller(self, size: int) -> Preview:
        """Return a copy of at most the present size in pixels, with fewer points."""
        every = max(1, len(self._points) // _points_for(size))
        other = copy(self)
        other.size, other._points = size, self._points[::every]
        other._normals, other._own = self._normals[::every], self._own[::every]
        return other

    def plain(self) -> Preview:
        """Return a copy without the object's colours."""
        other = copy(self)
        other._own = np.broadcast_to(_CLAY, self._own.shape)
        return other

    def draw(self, turn: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return the picture (size, size, 3) of the object after a rotation (3, 3); z is up."""
        size = self.size
        n = size * _DETAIL
        axes, seen, shadow, scale, middle = self._projected(turn, n)
        picture = np.empty((n * n, 3), _F)
        picture[:] = _GROUND
        shaded = np.zeros(n * n, np.bool_)
        shaded[_pixels(shadow, middle, scale, n)] = True
        picture[shaded] = _SHADOW
        deep = seen[:, 2]
        levels = (deep - deep.min()) * (_LEVELS / max(float(np.ptp(deep)), 1e-9))
        order = np.argsort(levels.astype(np.uint16), kind="stable")  # uint16: a fast radix sort
        owner = np.full(n * n, -1, np.int32)
        owner[_pixels(seen[order], middle, scale, n)] = np.repeat(order.astype(np.int32), 4)
        covered = np.flatnonzero(owner >= 0)
        shown = owner[covered]
        normals = self._normals[shown] @ axes.T
        facing = np.where(
            normals[:, 2] < 0.0, -1.0, 1.0
        )  # two-sided: open meshes show their inside
        light = _SHADE + (1.0 - _SHADE) * np.clip(facing * (normals @ _LIGHT), 0.0, 1.0)
        picture[covered] = self._own[shown] * light[:, None]
        rows = picture.reshape(size, _DETAIL, size, _DETAIL, 3)
        mean = sum(rows[:, j, :, k] for j in range(_DETAIL) for k in range(_DETAIL)) / _DETAIL**2
        return np.ascontiguousarray(np.clip(mean, 0.0, 255.0).astype(np.uint8))

    def side_at(self, turn: NDArray[np.float64], across: float, down: float) -> AnyArray | None:
        """Return the unit normal (3,) visible at a position of the picture, 0 to 1 each.

        In the mesh's own axes, toward the viewer; None beside the object.
        """
        axes, seen, _, scale, middle = self._projected(turn, self.size)
        place = np.array([across - 0.5, 0.5 - down]) * self.size / scale + middle
        gap = np.linalg.norm(seen[:, :2] - place, axis=1) * scale
        near = np.flatnonzero(gap < _REACH)
        if not len(near):
            return None
        front = seen[near, 2] > seen[near, 2].max() - _REACH / scale
        normals = self._normals[near[front]]
        outward = normals * np.sign(normals @ axes[2])[:, None]
        normal = outward.sum(axis=0, dtype=np.float64)
        length = float(np.linalg.norm(normal))
        return normal / length if length > 1e-6 else None

    def _projected(
        self, turn: NDArray[np.float64], n: int
    ) -> tuple[AnyArray, AnyArray, AnyArray, float, AnyArray]:
        """Project the points onto n x n pixels.

        Returns
        -------
        axes : (3, 3)
            Rows right, up and toward the eye, in the mesh's own axes.
        seen : (N, 3)
            Points in these axes.
        shadow : (N, 2)
            Their shadows on the ground, likewise.
        scale : float
            Pixels per mm.
        middle : (2,)
            Position in the middle of the picture.
        """
        ca, sa, ch, sh = np.cos(_AZIMUTH), np.sin(_AZIMUTH), np.sin(_HEIGHT), np.cos(_HEIGHT)
        right = np.array([-sa, ca, 0.0])
        ahead = np.array([ca * sh, sa * sh, ch])  # toward the eye
        frame = np.stack([right, np.cross(ahead, right), ahead])
        axes, upward = (frame @ turn).astype(_F), turn[2].astype(_F)
        seen = self._points @ axes.T
        above = self._points @ upward
        above -= above.min()
        shadow = seen[:, :2] - above[:, None] * frame[:2, 2].astype(_F)
        both = [(places.min(), places.max()) for flat in (seen, shadow) for places in flat[:, :2].T]
        low = np.minimum([both[0][0], both[1][0]], [both[2][0], both[3][0]]).astype(np.float64)
        high = np.maximum([both[0][1], both[1][1]], [both[2][1], both[3][1]]).astype(np.float64)
        span = max(float((high - low).max()), 1e-9)
        return axes, seen, shadow, _FILLS * n / span, 0.5 * (low + high)


def _points_for(size: int) -> int:
    """Return the number of points that fill a picture."""
    return int(_POINTS_A_PIXEL * (size * _DETAIL) ** 2)


def _pixels(points: AnyArray, middle: AnyArray, scale: float, n: int) -> NDArray[np.int64]:
    """Return the indices (4 N,) of the 2 x 2 pixels that each point covers, rows from the top."""
    column, row = (
        np.clip((points[:, k] - _F(middle[k])) * _F(sign * scale) + _F(0.5 * n), 0, n - 2)
        for k, sign in enumerate((1.0, -1.0))
    )
    first = row.astype(np.int64) * n + column.astype(np.int64)
    result: NDArray[np.int64] = (first[:, None] + np.array([0, 1, n, n + 1])).ravel()
    return result
