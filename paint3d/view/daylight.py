"""Light that reaches each point, with soft shadows: depth maps of the object from many sides.

A point is lit from a direction if nothing of the object lies nearer to the light on the line
through it. Each of the studio's directions gets a depth map of samples spread evenly over the
surface; a point looks itself up, moved off the surface along its normal by `OFFSET` cells so that
it does not shade itself. Sums over many directions give soft shadows and ambient occlusion that,
unlike screen-space occlusion, do not depend on where the camera stands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from paint3d.view.studio import Sun

__all__ = ["Ground", "Occluder", "light_ground", "light_points"]

CELLS = 224  # across a depth map: 0.9 mm on a bowl of 200 mm
SAMPLES = 400_000  # 8 a cell of the map, so that a hole is met once in thousands of cells
OFFSET = 1.6  # cells
GROUND_CELLS = 420
GROUND_BLUR = 2.0  # cells; joins the shadows of neighbouring lights
GROUND_HALF = 3.0  # half-width of the shaded ground, in radii of the object


class Occluder:
    """The object as something that casts shadows.

    Parameters
    ----------
    vertices : (V, 3) array, studio axes, mm
    faces : (F, 3) integer array
    """

    def __init__(self, vertices: NDArray, faces: NDArray) -> None:
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
        self.points = corners[chosen, 0] + u[:, None] * edges[:, 0] + v[:, None] * edges[:, 1]
        self.centre = (vertices.min(axis=0) + vertices.max(axis=0)).astype(np.float64) / 2
        self.radius = float(np.linalg.norm(vertices - self.centre, axis=1).max())
        self.cell = 2.04 * self.radius / CELLS

    def is_open(self, points: NDArray, direction: NDArray) -> NDArray[np.bool_]:
        """Return which of `points` (N, 3) see out of the object along the unit `direction`."""
        axes = self._axes(direction)
        cells, depth = self._project(self.points, axes)
        nearest = np.full(CELLS * CELLS + 1, -np.inf, dtype=np.float32)
        np.maximum.at(nearest, cells, depth)
        nearest[-1] = -np.inf  # outside of the map nothing shades
        cells, depth = self._project(points, axes)
        return depth >= nearest[cells]

    def _axes(self, direction: NDArray) -> NDArray[np.float32]:
        aside = np.eye(3)[np.argmin(np.abs(direction))]
        u = np.cross(direction, aside)
        u /= np.linalg.norm(u)
        return np.stack([u, np.cross(direction, u), direction]).astype(np.float32)

    def _project(self, points: NDArray, axes: NDArray) -> tuple[NDArray, NDArray]:
        centre = (axes @ self.centre).astype(np.float32)
        scale = np.float32(1 / self.cell)
        u = (points @ axes[0] - centre[0]) * scale + np.float32(CELLS / 2)
        v = (points @ axes[1] - centre[1]) * scale + np.float32(CELLS / 2)
        inside = (u >= 0) & (u < CELLS) & (v >= 0) & (v < CELLS)
        cells = np.where(inside, u.astype(np.int32) + CELLS * v.astype(np.int32), CELLS * CELLS)
        return cells, points @ axes[2]


@dataclass(frozen=True)
class Ground:
    """The floor under the object: `openness` (N, N) is its light over that of the free floor.

    Cell [i, j] lies at (-half + (j + 1/2) step, -half + (i + 1/2) step) from `origin`, studio axes.
    """

    origin: NDArray[np.float64]
    half: float
    openness: NDArray[np.float64]

    def openness_at(self, xy: NDArray) -> NDArray[np.float64]:
        """Return the openness at (N, 2) places, 1 outside the ground's square."""
        n = len(self.openness)
        at = ((xy - self.origin[:2]) / self.half + 1) * (n / 2)
        inside = ((at >= 0) & (at < n)).all(axis=1)
        j, i = np.where(inside[:, None], at, 0).astype(np.int64).T
        return np.where(inside, self.openness[i, j], 1.0)


def light_ground(occluder: Occluder, suns: list[Sun]) -> Ground:
    """Return the floor that touches the object's lowest point, with the object's soft shadow."""
    floor = float(occluder.points[:, 2].min())
    half = GROUND_HALF * occluder.radius
    ticks = ((np.arange(GROUND_CELLS) + 0.5) / GROUND_CELLS * 2 - 1) * half
    origin = np.array([occluder.centre[0], occluder.centre[1], floor])
    x, y = np.meshgrid(ticks + origin[0], ticks + origin[1])
    points = np.stack([x, y, np.full_like(x, floor)], axis=-1).reshape(-1, 3).astype(np.float32)
    lit, free = np.zeros(len(points)), 0.0
    for sun in suns:
        strength = sun.irradiance.mean() * sun.direction[2]
        if strength > 0:
            lit += strength * occluder.is_open(points, sun.direction)
            free += strength
    openness = (lit / free).reshape(GROUND_CELLS, GROUND_CELLS)
    return Ground(origin, half, gaussian_filter(openness, GROUND_BLUR, mode="nearest"))


def light_points(
    occluder: Occluder,
    ground: Ground | None,
    suns: list[Sun],
    points: NDArray,
    normals: NDArray,
    albedo: float,
) -> NDArray[np.float64]:
    """Return the (N, 3) irradiance over pi at points of the surface.

    What the object hides from a point sends light as well: it is taken to shine with the mean
    light of all points times `albedo`, one bounce, so that a white bowl glows inside.

    Parameters
    ----------
    occluder : Occluder
    ground : Ground or None
        The floor whose shade darkens the light from below; None where there is no floor.
    suns : list of Sun
    points, normals : (N, 3) float32 arrays, studio axes
    albedo : float
        Reflectance of the bare object, 0 to 1.
    """
    lifted = points + np.float32(OFFSET * occluder.cell) * normals
    lit = np.zeros((len(points), 3))
    hidden = np.zeros(len(points))
    for sun in suns:
        cosines = normals @ sun.direction.astype(np.float32)
        facing = np.flatnonzero(cosines > 0)
        weights = cosines[facing] * occluder.is_open(lifted[facing], sun.direction)
        hidden[facing] += 4 * sun.share * (cosines[facing] - weights)
        if ground is not None and sun.direction[2] < 0:
            reach = (points[facing, 2] - ground.origin[2]) / -sun.direction[2]
            foot = points[facing, :2] + reach[:, None] * sun.direction[:2]
            weights = weights * ground.openness_at(foot)
        lit[facing] += weights[:, None] * sun.irradiance
    lit /= np.pi
    return lit + albedo * hidden[:, None] * lit.mean(axis=0)
