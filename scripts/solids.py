"""Objects made from formulas: solids of revolution, the sphere and the plane.

The built-in objects in ``meshes/`` are written with these by ``scripts.build_meshes``. Each
comes with the exact normals of the shape it samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.mesh.triangle_mesh import TriangleMesh
from scripts.profiles import Point, sample_profile, vessel_profile

__all__ = [
    "make_bowl",
    "make_plane",
    "make_plate",
    "make_sphere",
    "make_vase",
    "revolve",
]

FEWEST_SECTORS = 6


def revolve(
    points: NDArray[np.float64], normals: NDArray[np.float64], edge: float, name: str
) -> TriangleMesh:
    """Return the surface swept by a profile that starts and ends on the z axis.

    Each profile point becomes a ring with as many vertices as keep them about `edge` apart, and
    neighbouring rings are stitched, so triangles stay near equilateral from the axis to the rim.

    Parameters
    ----------
    points, normals : (N, 2) float64
        Radius and height of the profile, mm, and its unit normals out of the material; the first
        and last radius are 0, all others positive.
    edge : float
        Wanted edge length, mm.
    name : str

    Raises
    ------
    MeshError
        If the profile does not start and end on the axis, or leaves the half plane.
    """
    if points[0, 0] != 0.0 or points[-1, 0] != 0.0 or (points[1:-1, 0] <= 0.0).any():
        raise MeshError("a profile must start and end on the axis and stay off it between")
    rings, vertices, vertex_normals, n_vertices = [], [], [], 0
    for k, ((radius, height), (out, up)) in enumerate(zip(points, normals, strict=True)):
        n = 1 if radius == 0.0 else max(FEWEST_SECTORS, round(2.0 * math.pi * radius / edge))
        turn = (np.arange(n) + 0.5 * (k % 2)) / n
        cos, sin = np.cos(2.0 * math.pi * turn), np.sin(2.0 * math.pi * turn)
        vertices.append(np.stack([radius * cos, radius * sin, np.full(n, height)], axis=1))
        tilt = 0.0 if radius == 0.0 else out
        vertex_normals.append(np.stack([tilt * cos, tilt * sin, np.full(n, up)], axis=1))
        rings.append((n_vertices, turn))
        n_vertices += n
    faces = [_stitch(a, b) for a, b in pairwise(rings)]
    return TriangleMesh(
        np.concatenate(vertices),
        np.concatenate(faces),
        name=name,
        normals=np.concatenate(vertex_normals),
    )


def _stitch(one: tuple[int, AnyArray], two: tuple[int, AnyArray]) -> NDArray[np.int32]:
    """Return the triangles between two rings, each (first vertex id, turns of its vertices)."""
    (first_a, turn_a), (first_b, turn_b) = one, two
    n_a, n_b = len(turn_a), len(turn_b)
    if n_a == 1 or n_b == 1:
        return _fan(first_a, n_a, first_b, n_b)
    faces, i, j = [], 0, 0
    while i < n_a or j < n_b:
        next_a = turn_a[(i + 1) % n_a] + (i + 1) // n_a
        next_b = turn_b[(j + 1) % n_b] + (j + 1) // n_b
        a, b = first_a + i % n_a, first_b + j % n_b
        if j == n_b or (i < n_a and next_a <= next_b):
            i += 1
            faces.append((a, b, first_a + i % n_a))
        else:
            j += 1
            faces.append((a, b, first_b + j % n_b))
    return np.array(faces, np.int32)


def _fan(first_a: int, n_a: int, first_b: int, n_b: int) -> NDArray[np.int32]:
    """Return the triangles between a pole and the ring before or after it."""
    n = max(n_a, n_b)
    k = np.arange(n)
    after = (k + 1) % n
    if n_a == 1:
        columns = (np.full(n, first_a), first_b + k, first_b + after)
    else:
        columns = (np.full(n, first_b), first_a + after, first_a + k)
    return np.stack(columns, axis=1).astype(np.int32)


def _vessel(
    wall: Sequence[tuple[Point, Point, Point, Point]],
    thickness: float,
    foot: tuple[float, float],
    edge: float,
    name: str,
) -> TriangleMesh:
    profile = vessel_profile(wall, thickness, *foot)
    points, normals = sample_profile(profile, edge * math.sqrt(3.0) / 2.0)
    points[[0, -1], 0] = 0.0
    return revolve(points, normals, edge, name)


def make_bowl() -> TriangleMesh:
    """Return a porcelain bowl: rim 150 mm, 68 mm high, 3 mm wall, flared lip, foot ring."""
    wall = [((34.0, 8.5), (63.0, 8.5), (65.0, 43.0), (73.5, 66.5))]
    return _vessel(wall, 3.0, (30.5, 7.0), 2.4, "bowl")


def make_plate() -> TriangleMesh:
    """Return a plate: rim 220 mm, 26 mm high, 3.5 mm wall, with a broad rising rim."""
    wall = [
        ((72.0, 7.75), (84.0, 7.75), (83.0, 16.0), (92.0, 19.0)),
        ((92.0, 19.0), (98.0, 21.0), (103.0, 22.6), (108.25, 24.25)),
    ]
    return _vessel(wall, 3.5, (66.0, 6.0), 2.6, "plate")


def make_vase() -> TriangleMesh:
    """Return a vase: 600 mm high, 260 mm wide, 5 mm wall, narrow neck and flared lip."""
    wall = [
        ((56.0, 14.5), (76.0, 14.5), (76.0, 40.0), (82.0, 80.0)),
        ((82.0, 80.0), (94.0, 160.0), (127.5, 230.0), (127.5, 320.0)),
        ((127.5, 320.0), (127.5, 440.0), (47.5, 410.0), (47.5, 500.0)),
        ((47.5, 500.0), (47.5, 550.0), (52.0, 580.0), (75.0, 597.5)),
    ]
    return _vessel(wall, 5.0, (49.0, 12.0), 3.25, "vase")


def make_sphere() -> TriangleMesh:
    """Return the sphere of radius 75 mm about the origin: an icosahedron halved five times."""
    points, faces = _icosahedron()
    for _ in range(5):
        points, faces = _halve_edges(points, faces)
    return TriangleMesh(75.0 * points, faces, name="sphere", normals=points)


def _icosahedron() -> tuple[AnyArray, AnyArray]:
    g = (1.0 + math.sqrt(5.0)) / 2.0
    pairs = [(s, t * g) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    points = np.array([np.roll((0.0, s, t), axis) for axis in range(3) for s, t in pairs])
    near = np.linalg.norm(points[:, None] - points[None], axis=2) < 2.1
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    outward = np.linalg.det(points[[a, b, c]]) > 0.0
                    faces.append((a, b, c) if outward else (a, c, b))
    return points / math.hypot(1.0, g), np.array(faces, np.int32)


def _halve_edges(points: AnyArray, faces: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Split every triangle in four and push the new vertices out to the unit sphere."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, back = np.unique(edges, axis=0, return_inverse=True)
    middle = points[unique].sum(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    a, b, c = faces.T
    ab, bc, ca = (len(points) + back.reshape(-1, 3)).T
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    stacked = np.stack([np.stack(q, axis=1) for q in quarters], axis=1).reshape(-1, 3)
    return np.concatenate([points, middle]), stacked.astype(np.int32)


def make_plane() -> TriangleMesh:
    """Return the square of 200 x 200 mm in z = 0, centred on the origin and facing +z."""
    n = 16
    line = np.linspace(-100.0, 100.0, n + 1)
    y, x = (axis.ravel() for axis in np.meshgrid(line, line, indexing="ij"))
    vertices = np.stack([x, y, np.zeros_like(x)], axis=1)
    row, column = (axis.ravel() for axis in np.meshgrid(range(n), range(n), indexing="ij"))
    a = row * (n + 1) + column
    b, c, d = a + 1, a + n + 2, a + n + 1
    even = ((row + column) % 2 == 0)[:, None]  # diagonals alternate: no direction is preferred
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    faces = np.stack([first, second], axis=1).reshape(-1, 3)
    normals = np.tile([0.0, 0.0, 1.0], (len(vertices), 1))
    return TriangleMesh(vertices, faces, name="plane", normals=normals)
