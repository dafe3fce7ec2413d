"""A small picture of an object as it would stand, drawn in a moment and without OpenGL.

Points spread evenly over the surface are laid into the picture from back to front; a shadow below
shows where the ground is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Preview"]

_AZIMUTH, _HEIGHT = np.deg2rad(-60.0), np.deg2rad(22.0)  # of the eye
_LIGHT = np.array([-0.45, 0.35, 0.82])  # in the picture: right, up, toward the eye
_SHADE = 0.42  # what is left of the light where it does not fall
_CLAY = np.array([222.0, 216.0, 204.0])
_GROUND, _SHADOW = np.array([238.0, 238.0, 236.0]), np.array([196.0, 196.0, 194.0])
_POINTS_A_PIXEL = 0.8
_FILLS = 0.86  # of the picture's side
_REACH = 5.0  # pixels around a place that tell which side it is
_DETAIL = 2  # pixels drawn along each that is shown


class Preview:
    """Pictures of one object from the side, standing in different ways.

    Parameters
    ----------
    mesh : TriangleMesh
    coloured : bool
        Whether to show its colours.
    """

    def __init__(self, mesh: TriangleMesh, size: int = 200, coloured: bool = True) -> None:
        self._size = size
        n = int(_POINTS_A_PIXEL * (size * _DETAIL) ** 2)
        ends = np.cumsum(mesh.double_areas)
        at = (np.arange(n) + 0.5) / n * ends[-1]
        face = np.minimum(np.searchsorted(ends, at), len(ends) - 1)
        # two irrational steps spread the points over each triangle (Roberts' sequence)
        u, v = ((np.arange(n) * step) % 1.0 for step in (0.7548776662466927, 0.5698402909980532))
        over = u + v > 1.0
        u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
        weights = np.stack([1.0 - u - v, u, v], axis=1)
        corners = mesh.faces[face]
        middle = mesh.bounds.mean(axis=0)
        self._points = np.einsum("nc,nci->ni", weights, mesh.vertices[corners] - middle)
        self._normals = mesh.face_normals[face]
        self._own = np.broadcast_to(_CLAY, (n, 3))
        if coloured and mesh.colours is not None:
            self._own = np.einsum("nc,nci->ni", weights, mesh.colours[corners])

    def draw(self, turn: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return the picture (size, size, 3) of the object after a rotation (3, 3); z is up."""
        size = self._size
        n = size * _DETAIL
        frame, seen, shadow, scale, middle = self._laid(turn, n)
        picture = np.tile(_GROUND, (n * n, 1))
        picture[_pixels(shadow, middle, scale, n)] = _SHADOW
        normals = self._normals @ (frame @ turn).T
        facing = normals * np.where(normals[:, 2:] < 0.0, -1.0, 1.0)  # meshes are seen inside too
        light = _SHADE + (1.0 - _SHADE) * np.clip(facing @ _LIGHT, 0.0, 1.0)
        order = np.argsort(seen[:, 2], kind="stable")
        lit = (self._own * light[:, None])[order]
        picture[_pixels(seen[order], middle, scale, n)] = np.repeat(lit, 4, axis=0)
        shown = picture.reshape(size, _DETAIL, size, _DETAIL, 3).mean(axis=(1, 3))
        return np.ascontiguousarray(np.clip(shown, 0.0, 255.0).astype(np.uint8))

    def side_at(self, turn: NDArray[np.float64], across: float, down: float) -> AnyArray | None:
        """Return the unit normal (3,) of what is seen at a place of the picture, 0 to 1 each.

        In the mesh's own axes, out of the side that is seen; None beside the object.
        """
        frame, seen, _, scale, middle = self._laid(turn, self._size)
        place = np.array([across - 0.5, 0.5 - down]) * self._size / scale + middle
        gap = np.linalg.norm(seen[:, :2] - place, axis=1) * scale
        near = np.flatnonzero(gap < _REACH)
        if not len(near):
            return None
        front = seen[near, 2] > seen[near, 2].max() - _REACH / scale
        normals = self._normals[near[front]]
        outward = normals * np.sign(normals @ (frame @ turn)[2])[:, None]
        normal = outward.sum(axis=0)
        length = float(np.linalg.norm(normal))
        return normal / length if length > 1e-6 else None

    def _laid(
        self, turn: NDArray[np.float64], n: int
    ) -> tuple[AnyArray, AnyArray, AnyArray, float, AnyArray]:
        """The eye's axes, points and their shadows in them, and how they lie on n pixels."""
        ca, sa, ch, sh = np.cos(_AZIMUTH), np.sin(_AZIMUTH), np.sin(_HEIGHT), np.cos(_HEIGHT)
        right = np.array([-sa, ca, 0.0])
        ahead = np.array([ca * sh, sa * sh, ch])  # toward the eye
        frame = np.stack([right, np.cross(ahead, right), ahead])
        points = self._points @ turn.T
        low = points[:, 2].min()
        ground = points * (1.0, 1.0, 0.0) + (0.0, 0.0, low)
        seen, shadow = points @ frame.T, ground @ frame.T
        both = np.concatenate([seen[:, :2], shadow[:, :2]])
        span = max(float(np.ptp(both, axis=0).max()), 1e-9)
        scale, middle = _FILLS * n / span, 0.5 * (both.min(axis=0) + both.max(axis=0))
        return frame, seen, shadow, scale, middle


def _pixels(points: AnyArray, middle: AnyArray, scale: float, n: int) -> NDArray[np.int64]:
    """Numbers of the pixels that points cover, 2 x 2 each (4 N,), row by row from the top."""
    place = ((points[:, :2] - middle) * (scale, -scale) + 0.5 * n).astype(np.int64)
    column, row = np.clip(place, 0, n - 2).T
    first = row * n + column
    result: NDArray[np.int64] = (first[:, None] + np.array([0, 1, n, n + 1])).ravel()
    return result
