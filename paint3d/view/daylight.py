"""Irradiance with soft shadows, by shadow maps of the object from many directions.

A point is lit from a direction if nothing of the object lies nearer to the light on the line
through it. Each of the studio's directions gets a depth map of samples spread evenly over the
surface; a point is looked up in it after moving it off the surface by `OFFSET` cells, so that it
does not shadow itself. Sums over many directions give soft shadows and ambient occlusion that,
unlike screen-space occlusion, do not depend on the camera.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, cross
from paint3d.view.kernels.depth_map import (
    DepthMap,
    Floor,
    Light,
    add_sunlight,
    fill_depth_map,
    shade_floor,
)
from paint3d.view.studio import Sun

__all__ = ["Ground", "Occluder", "light_ground", "light_points"]

CELLS = 224  # across a depth map: 0.9 mm on a bowl of 200 mm
SAMPLES = 400_000  # 8 per cell of the map, so that only one cell in thousands is a hole
OFFSET = 1.6  # cells off the surface, against self-shadowing
GROUND_CELLS = 420
GROUND_BLURS = 3.0, 7.0  # cells, in the deepest shadow and elsewhere: merges single lights
SHARP_BELOW = 0.3  # openness below which the shadow is blurred less
GAP = 0.004  # radii from the lowest point down to the floor: a sheet must not sink into it
GROUND_HALF = 3.0  # half-width of the shadowed ground, in radii of the object


class Occluder:
    """The object as a caster of shadows.

    Parameters
    ----------
    vertices : (V, 3) array, studio axes, mm
    faces : (F, 3) integer array
    centre : (3,) array, optional
        Middle of its maps and of the ground; by default that of the vertices' box.
    """

    def __init__(self, vertices: AnyArray, faces: AnyArray, centre: AnyArray | None = None) -> None:
        corners = vertices[faces].astype(np.float32)
        edges = corners[:, 1:] - corners[:, :1]
        areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).astype(np.float64)
        ends = np.cumsum(areas)
        rng = np.random.default_rng(20)  # a fixed seed: the same object, the same picture
        picks = (np.arange(SAMPLES) + rng.random(SAMPLES)) * (ends[-1] / SAMPLES)
        chosen = np.minimum(np.searchsorted(ends, picks), len(faces) - 1)
        u, v = rng.random((2, SAMPLES), dtype=np.float32)
        u, v = np.where(u + v > 1, (1 - u, 1 - v), (u, v))
        edges = edges[chosen]
        points = corners[chosen, 0] + u[:, None] * edges[:, 0] + v[:, None] * edges[:, 1]
        self.lowest = float(points[:, 2].min())
        if centre is None:
            centre = (vertices.min(axis=0) + vertices.max(axis=0)).astype(np.float64) / 2
        self.centre = centre
        self._points = np.ascontiguousarray((points - self.centre).T, np.float32)
        self.radius = float(np.linalg.norm(vertices - self.centre, axis=1).max())
        self.cell = 2.04 * self.radius / CELLS
        self._depth_maps: dict[bytes, DepthMap] = {}

    def turned(self, rotation: NDArray[np.float64]) -> Occluder:
        """Return the object after a rotation (3, 3) about its centre."""
        other = copy(self)
        other._points = np.ascontiguousarray(rotation.astype(np.float32) @ self._points)
        # not by the last bits: what turns about the vertical keeps its floor
        lowest = float(other._points[2].min() + self.centre[2])
        if abs(lowest - self.lowest) > 1e-3 * self.radius:
            other.lowest = lowest
        other._depth_maps = {}
        return other

    def shine(
        self, suns: list[Sun], points: AnyArray, normals: AnyArray, lift: float, ground: Ground
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the irradiance (N, 3) of `suns` and the hidden part (N,) of each point's sky.

        Points (N, 3) float32 are looked up `lift` mm off the surface along `normals` (N, 3).
        """
        lit, hidden = np.zeros((len(points), 3)), np.zeros(len(points))
        x, y, z = ground.origin.tolist()
        floor = Floor(ground.openness, x, y, z, ground.half)
        for sun in suns:
            light = Light(sun.irradiance, 4 * sun.share)
            depth_map = self._depth_map(sun.direction)
            add_sunlight(points, normals, lift, depth_map, light, floor, lit, hidden)
        return lit, hidden

    def shade(self, suns: list[Sun], ground: Ground) -> None:
        """Take the light of `suns`, all above it, off a ground where the object is in between."""
        x, y, z = ground.origin.tolist()
        floor = Floor(ground.openness, x, y, z, ground.half)
        weights = [float(sun.irradiance.mean() * sun.direction[2]) for sun in suns]
        for sun, weight in zip(suns, weights, strict=True):
            shade_floor(self._depth_map(sun.direction), weight / sum(weights), floor)

    def _depth_map(self, direction: NDArray[np.float64]) -> DepthMap:
        """Return the depth map seen from a light; cached, as floor and object both need it."""
        key = direction.tobytes()
        if key not in self._depth_maps:
            u = cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
            u /= np.linalg.norm(u)
            axes = np.stack([u, cross(direction, u), direction])
            depth = np.empty((CELLS, CELLS), dtype=np.float32)
            depth_map = DepthMap(self.centre, axes, 1 / self.cell, depth)
            fill_depth_map(self._points, depth_map)
            self._depth_maps[key] = depth_map
        return self._depth_maps[key]


@dataclass(frozen=True)
class Ground:
    """The floor under the object: `openness` (N, N) is its light over that of an empty floor.

    Cell [i, j] lies at (-half + (j + 1/2) step, -half + (i + 1/2) step) from `origin`, studio axes.
    """

    origin: NDArray[np.float64]
    half: float
    openness: NDArray[np.float64]


def light_ground(occluder: Occluder, suns: list[Sun]) -> Ground:
    """Return the floor just under the object's lowest point, with the object's soft shadow."""
    half = GROUND_HALF * occluder.radius
    floor = occluder.lowest - GAP * occluder.radius
    origin = np.array([occluder.centre[0], occluder.centre[1], floor], dtype=np.float64)
    openness = np.ones((GROUND_CELLS, GROUND_CELLS))
    above = [sun for sun in suns if sun.direction[2] > 0]
    occluder.shade(above, Ground(origin, half, openness))
    # Blur least where the shadow is darkest: under the object, where contact is visible.
    sharp, soft = (blur @ openness @ blur.T for blur in map(_blur, GROUND_BLURS))
    dark = np.clip((SHARP_BELOW - soft) / SHARP_BELOW * 2, 0, 1)
    return Ground(origin, half, soft + dark * (sharp - soft))


@cache
def _blur(cells: float) -> NDArray[np.float64]:
    """Return the matrix (N, N) that blurs columns of the ground by a Gaussian; its edge goes on.

    SciPy has the same, and takes longer to be loaded than a picture to be lit.
    """
    reach = round(4.0 * cells)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / cells) ** 2)
    blur = np.zeros((GROUND_CELLS, GROUND_CELLS))
    for step, weight in zip(range(-reach, reach + 1), weights / weights.sum(), strict=True):
        rows = np.arange(GROUND_CELLS)
        blur[rows, np.clip(rows + step, 0, GROUND_CELLS - 1)] += weight
    return blur


def light_points(
    occluder: Occluder,
    ground: Ground,
    suns: list[Sun],
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    albedo: float,
) -> NDArray[np.float64]:
    """Return the (N, 3) irradiance over pi at points of the surface.

    The parts of the object that block a point's sky reflect light themselves: they are taken to
    shine with the mean light of all points times `albedo`, one bounce, so that a white bowl glows
    inside.

    Parameters
    ----------
    occluder : Occluder
    ground : Ground
        The floor, whose shadow darkens the light from below.
    suns : list of Sun
    points, normals : (N, 3) float32 arrays, studio axes
    albedo : float
        Reflectance of the bare object, 0 to 1.
    """
    lit, hidden = occluder.shine(suns, points, normals, OFFSET * occluder.cell, ground)
    lit /= np.pi
    result: NDArray[np.float64] = lit + albedo * hidden[:, None] * lit.mean(axis=0)
    return result
