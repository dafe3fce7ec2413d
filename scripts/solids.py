"""Objects made from formulas: solids of revolution, the sphere and the plane.

The built-in objects in ``meshes/`` are written with these by ``scripts.build_meshes``. Each
comes with the exact normals of the shape it samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "make_bowl",
    "make_plane",
    "make_plate",
    "make_sphere",
    "make_vase",
    "revolve",
    "sample_profile",
    "vessel_profile",
]

# ---- Profiles ------------------------------------------------------------------------------------
# Smooth curves in the (radius, height) half plane, with normals. A profile is a chain of pieces
# that meet with one tangent. Seen along the direction of travel the material lies on the right, so
# the left normal points out of the clay.

Point = tuple[float, float]


class Piece(Protocol):
    """A smooth curve with a parameter from 0 to 1."""

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents, (N, 2) each, at the parameters `t` (N,)."""
        ...


@dataclass(frozen=True)
class Line:
    """The straight piece from `start` to `end`, mm."""

    start: Point
    end: Point

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        start, end = np.array(self.start), np.array(self.end)
        tangent = (end - start) / np.linalg.norm(end - start)
        return start + t[:, None] * (end - start), np.tile(tangent, (len(t), 1))


@dataclass(frozen=True)
class Arc:
    """The circular piece about `centre` from angle `start` to `end`, rad; either sense."""

    centre: Point
    radius: float
    start: float
    end: float

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        angle = self.start + t * (self.end - self.start)
        ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        turn = math.copysign(1.0, self.end - self.start)
        tangent = turn * np.stack([-ray[:, 1], ray[:, 0]], axis=1)
        return np.array(self.centre) + self.radius * ray, tangent


@dataclass(frozen=True)
class Offset:
    """A cubic Bezier curve moved by `distance` mm to its left; `backwards` from its end.

    Both faces of a wall are offsets of its middle line, so the wall has one thickness and its
    normals are exactly those of the middle line.
    """

    controls: tuple[Point, Point, Point, Point]
    distance: float
    backwards: bool = False

    def at(self, t: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return points and unit tangents at `t`."""
        s = (1.0 - t if self.backwards else t)[:, None]
        p = np.array(self.controls)
        point = (1 - s) ** 3 * p[0] + 3 * (1 - s) ** 2 * s * p[1]
        point = point + 3 * (1 - s) * s**2 * p[2] + s**3 * p[3]
        d = np.diff(p, axis=0)
        velocity = (1 - s) ** 2 * d[0] + 2 * (1 - s) * s * d[1] + s**2 * d[2]
        tangent = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
        left = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        return point + self.distance * left, -tangent if self.backwards else tangent


def vessel_profile(
    wall: Sequence[tuple[Point, Point, Point, Point]],
    thickness: float,
    foot_radius: float,
    foot_height: float,
) -> list[Piece]:
    """Return the closed profile of a vessel that stands on a foot ring at height 0.

    Parameters
    ----------
    wall : sequence of four (radius, height) points, mm
        Cubic Beziers of the wall's middle line from the flat floor to the lip; the first starts
        level, at height foot_height + thickness / 2.
    thickness : float
        Of wall, floor and foot ring, mm.
    foot_radius, foot_height : float
        Middle radius of the foot ring and height of the floor's underside, mm.

    Returns
    -------
    list of Piece
        From the axis along the inside, round the lip, down the outside, round the foot ring and
        back to the axis.
    """
    half = thickness / 2.0
    floor_radius = wall[0][0][0]
    lip = np.array(wall[-1][3])
    rise = lip - np.array(wall[-1][2])
    across = math.atan2(rise[1], rise[0]) + math.pi / 2.0
    top = foot_height + thickness
    inside: list[Piece] = [Line((0.0, top), (floor_radius, top)), *(Offset(c, half) for c in wall)]
    turns = (across, math.pi / 2.0, 0.0, across - math.pi)  # stops at the highest and widest point
    centre = (float(lip[0]), float(lip[1]))
    round_lip = [Arc(centre, half, a, b) for a, b in pairwise(turns)]
    outside = [Offset(c, -half, backwards=True) for c in reversed(wall)]
    foot = _foot_ring(floor_radius, foot_radius, foot_height, half)
    return [*inside, *round_lip, *outside, *foot]


def _foot_ring(floor: float, ring: float, height: float, half: float) -> list[Piece]:
    """Return the underside, travelled inwards: a round-bottomed ring with fillets of `half`."""
    outer, inner, up = ring + half, ring - half, height - half
    quarter = math.pi / 2.0
    return [
        Line((floor, height), (outer + half, height)),
        Arc((outer + half, up), half, quarter, 2 * quarter),
        Line((outer, up), (outer, half)),
        Arc((ring, half), half, 0.0, -quarter),
        Arc((ring, half), half, -quarter, -2 * quarter),
        Line((inner, half), (inner, up)),
        Arc((inner - half, up), half, 0.0, quarter),
        Line((inner - half, height), (0.0, height)),
    ]


def sample_profile(
    pieces: Sequence[Piece], spacing: float, max_turn: float = math.radians(36.0)
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points and outward normals along a profile, (N, 2) each, evenly spaced by piece.

    Parameters
    ----------
    pieces : sequence of Piece
    spacing : float
        Wanted distance of neighbours, mm.
    max_turn : float
        Largest turn of the tangent between neighbours, rad: tight curves get more points.
    """
    points, normals = [], []
    for k, piece in enumerate(pieces):
        fine, tangent = piece.at(np.linspace(0.0, 1.0, 2001))
        length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))]
        cosine = np.clip(np.einsum("ij,ij->i", tangent[1:], tangent[:-1]), -1.0, 1.0)
        turn = float(np.arccos(cosine).sum())
        n = max(1, round(length[-1] / spacing), math.ceil(turn / max_turn - 1e-9))
        at = np.interp(np.linspace(0.0, length[-1], n + 1), length, np.linspace(0.0, 1.0, 2001))
        point, tangent = piece.at(at if k == 0 else at[1:])
        points.append(point)
        normals.append(np.stack([-tangent[:, 1], tangent[:, 0]], axis=1))
    return np.concatenate(points), np.concatenate(normals)


# ---- Solids --------------------------------------------------------------------------------------

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
