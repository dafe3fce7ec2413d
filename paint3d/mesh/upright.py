"""Guess which axis of an object points up, and rotate meshes accordingly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import cross_2d
from paint3d.errors import UnknownNameError
from paint3d.mesh.sampling import sample_evenly
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["UP_AXES", "Upright", "guess_up", "stand_on", "turn_mesh", "turn_rows", "turn_up"]

UP_AXES = ("z", "y", "x", "-z", "-y", "-x")
"""Axes that may point up, the most usual first."""

_NEAR = 0.01  # of the object's size: up to this height a point touches the ground
_MOST_FACES = 6000
_CELLS = 40  # along the object, of the height map that is filled with water
_MIRRORED = 0.02  # of the size: distance of a mirror image that counts as the same
_HABIT = {"z": 0.06, "y": 0.06}  # bonus of the axes that programs use for up
_SURE = 0.14  # lead over the second that a sure guess needs
_LEAST = 0.4  # and its own least score


class Upright(NamedTuple):
    """A guess: the axis of the mesh that points up, whether it is sure, the score of each axis."""

    up: str
    sure: bool
    scores: dict[str, float]


def turn_up(up: str) -> NDArray[np.float64]:
    """Return the rotation (3, 3), of quarter turns, that brings an axis of `UP_AXES` to z.

    Raises
    ------
    UnknownNameError
        If there is no such axis.
    """
    rows = {
        "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
        "x": ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
        "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    }
    if up not in rows:
        raise UnknownNameError("up axis", str(up), UP_AXES)
    return np.array(rows[up], np.float64)


def stand_on(side: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the shortest rotation (3, 3) that brings a side's unit normal (3,) to -z.

    Where the normal is within a degree of an axis, it is made of quarter turns.
    """
    side = np.asarray(side, np.float64)
    axis = int(np.abs(side).argmax())
    if abs(side[axis]) > np.cos(np.deg2rad(1.0)):
        up = "xyz"[axis] if side[axis] < 0.0 else "-" + "xyz"[axis]
        return turn_up(up)
    cross = np.array([-side[1], side[0], 0.0])  # side x -z
    cosine = -side[2]
    k = np.array(
        [[0.0, -cross[2], cross[1]], [cross[2], 0.0, -cross[0]], [-cross[1], cross[0], 0.0]]
    )
    result: NDArray[np.float64] = np.eye(3) + k + k @ k / (1.0 + cosine)
    return result


def turn_rows(rows: AnyArray, turn: NDArray[np.float64]) -> AnyArray:
    """Return vectors (N, 3) after a rotation (3, 3); quarter turns are exact to the last bit."""
    if (np.count_nonzero(turn, axis=1) == 1).all():
        axes = np.abs(turn).argmax(axis=1)
        return np.stack([rows[:, axis] * turn[k, axis] for k, axis in enumerate(axes)], axis=1)
    return rows @ turn.T


def turn_mesh(mesh: TriangleMesh, turn: NDArray[np.float64], scale: float = 1.0) -> TriangleMesh:
    """Return a mesh after a rotation (3, 3) and in another size."""
    if scale == 1.0 and np.array_equal(turn, np.eye(3)):
        return mesh
    vertices = scale * turn_rows(mesh.vertices.astype(np.float64), turn)
    normals = mesh.normals
    if normals is not None:
        normals = turn_rows(normals.astype(np.float64), turn)
    return TriangleMesh(vertices, mesh.faces, mesh.colours, mesh.name, normals)


def guess_up(mesh: TriangleMesh) -> Upright:
    """Guess which of its axes points up on an object as people stand it.

    In favour of a side as the bottom: it is flat and broad against the object's outline; the
    middle of the surface is low and well inside it; hollow objects open to the top; and an
    animal's two halves are left and right.
    """
    step = max(1, mesh.n_faces // _MOST_FACES)
    faces = np.arange(0, mesh.n_faces, step)
    corners = mesh.vertices[mesh.faces[faces]].astype(np.float64)
    area = mesh.double_areas[faces]
    points = np.concatenate([corners.mean(axis=1), corners.reshape(-1, 3)])
    size = max(float(np.ptp(points, axis=0).max()), 1e-30)
    middle = np.average(corners.mean(axis=1), axis=0, weights=area + 1e-30)
    mirrored = _find_mirrors(points, size)
    open_to = area @ mesh.face_normals[faces] / max(float(area.sum()), 1e-30)  # 0 where closed
    even = _sample_evenly(mesh)
    scores = {}
    for up in UP_AXES:
        turn = turn_up(up)
        low = float((mesh.vertices @ turn[2].astype(np.float32)).min())
        foot = mesh.vertices[mesh.vertices @ turn[2].astype(np.float32) < low + _NEAR * size]
        normals = mesh.face_normals[faces] @ turn.T
        stability = _stability(corners @ turn.T, area, normals, foot @ turn.T, size)
        stability += 0.4 * open_to @ turn[2]
        axis = "xyz".index(up[-1])
        across = mirrored[axis] and mirrored.count(True) == 1
        height = max(float((points @ turn[2]).max()) - low, 1e-30)
        lowness = 1.0 - (float(middle @ turn[2]) - low) / height
        score = _HABIT.get(up, 0.0) + stability + 0.6 * (lowness - 0.5) - 0.5 * across
        scores[up] = float(score + 1.2 * _water_depth(even @ turn.T, size))
    order = sorted(scores, key=lambda up: -scores[up])
    best, next_best = (scores[up] for up in order[:2])
    sure = best - next_best > _SURE and best > _LEAST
    return Upright(order[0], sure, scores)


def _stability(
    corners: NDArray[np.float64], area: AnyArray, normals: AnyArray, foot: AnyArray, size: float
) -> float:
    """Score, 0 to about 1.5, how stably an object (F, 3, 3) stands on its foot (N, 3)."""
    low = foot[:, 2].min()
    outline = _hull_area(corners[..., :2].reshape(-1, 2))
    if outline <= 1e-6 * size * size:
        return 0.0
    touching = corners[..., 2] < low + _NEAR * size
    foot = foot[:, :2].astype(np.float64)
    lies = touching.all(axis=1) & (normals[:, 2] < -0.95)
    flat = min(0.5 * float(area[lies].sum()) / outline, 1.0)
    broad = _hull_area(foot) / outline
    middle = np.average(corners.mean(axis=1)[:, :2], axis=0, weights=area + 1e-30)
    held = _depth_inside(foot, middle) / np.sqrt(outline)
    result: float = 0.4 * np.sqrt(flat) + 0.4 * np.sqrt(broad) + 0.8 * min(held, 0.4)
    return result


def _hull_area(points: AnyArray) -> float:
    hull = _hull(points)
    x, y = hull.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _hull(points: AnyArray) -> AnyArray:
    """Corners (H, 2) of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    points = np.unique(points, axis=0)
    if len(points) > 400:  # nearly all corners are outermost in one of these directions
        angles = np.linspace(0.0, 2.0 * np.pi, 181)[:-1]
        far = points @ np.stack([np.cos(angles), np.sin(angles)])
        points = points[np.unique(far.argmax(axis=0))]
    if len(points) < 3:
        return points
    chains = []
    for run in (points, points[::-1]):
        chain: list[AnyArray] = []
        for p in run:
            while len(chain) > 1 and cross_2d(chain[-1] - chain[-2], p - chain[-2]) <= 0.0:
                chain.pop()
            chain.append(p)
        chains += chain[:-1]
    return np.array(chains)


def _depth_inside(points: AnyArray, point: AnyArray) -> float:
    """Distance of a point (2,) inside the convex hull of points (N, 2) to its border; 0 outside."""
    hull = _hull(points)
    if len(hull) < 3:
        return 0.0
    along = np.roll(hull, -1, axis=0) - hull
    length = np.linalg.norm(along, axis=1)
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(length, 1e-30)[:, None]
    return max(0.0, float(np.einsum("ij,ij->i", inward, point - hull).min()))


def _find_mirrors(points: AnyArray, size: float) -> list[bool]:
    """Return for each axis whether points (N, 3) are nearly their own mirror image along it."""
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    some = points[:: max(1, len(points) // 1500)]
    found = []
    for axis in range(3):
        image = some.copy()
        middle = 0.5 * (points[:, axis].min() + points[:, axis].max())
        image[:, axis] = 2.0 * middle - image[:, axis]
        distance, _ = tree.query(image)
        found.append(float(np.quantile(distance, 0.9)) < _MIRRORED * size)
    return found


def _sample_evenly(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Return points (N, 3) spread evenly over the surface."""
    face, weights = sample_evenly(mesh, 16 * _CELLS**2)
    result: NDArray[np.float64] = np.einsum(
        "nc,nci->ni", weights, mesh.vertices[mesh.faces[face]].astype(np.float64)
    )
    return result


def _water_depth(points: NDArray[np.float64], size: float) -> float:
    """Mean depth of the water that an object (N, 3) holds, in units of its height."""
    low = points.min(axis=0)
    height = float(np.ptp(points[:, 2]))
    if height < 1e-3 * size:
        return 0.0
    cell = ((points[:, :2] - low[:2]) / size * (_CELLS - 1)).astype(np.int64) + 1
    ground = np.full((_CELLS + 2, _CELLS + 2), -1.0)
    np.maximum.at(ground, (cell[:, 0], cell[:, 1]), (points[:, 2] - low[2]) / height)
    there = ground >= 0.0
    # start with a flood and lower every cell to its lowest neighbour, but not below the ground
    water = np.where(there, 2.0, -1.0)
    for _ in range(_CELLS * 4):
        lowest = np.full_like(water, -1.0)
        lowest[1:-1, 1:-1] = np.minimum.reduce(
            [water[:-2, 1:-1], water[2:, 1:-1], water[1:-1, :-2], water[1:-1, 2:]]
        )
        level = np.maximum(ground, np.minimum(water, lowest))
        if np.array_equal(level, water):
            break
        water = level
    return float((water - ground)[there].mean())
