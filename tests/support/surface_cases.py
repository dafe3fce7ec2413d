#!/usr/bin/env python
"""Press one footprint on shapes that are hard to paint, and print what became of it.

Each case says how large the footprint is in its plane, how much surface it painted, how much of
that it must not have painted (far side, other shell, back), and how much of the released ink ran
off. `tests/mesh/test_surface_cases.py` holds these figures to their limits.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import revolve

UPRIGHT = 0.5 * np.pi
WALL = 2.0  # mm, of the bowl
GAP = 1.0  # mm, between shells and between the layers of the fold
RADII = (10.0, 15.0, 20.0, 30.0, 50.0, 75.0, 150.0, 300.0, 1000.0)


# -- shapes ---------------------------------------------------------------------------------------


def sheet(
    place: Callable[[NDArray, NDArray], NDArray], half: tuple[float, float], edge: float = 1.0
) -> TriangleMesh:
    """A square grid of points (x, y), carried into space by `place`; it faces up where z does."""
    nx, ny = (max(2, round(2.0 * h / edge)) for h in half)
    x, y = np.meshgrid(
        np.linspace(-half[0], half[0], nx + 1), np.linspace(-half[1], half[1], ny + 1)
    )
    a = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return TriangleMesh(place(x.ravel(), y.ravel()), faces)


def flat(x: NDArray, y: NDArray) -> NDArray:
    """The plane z = 0."""
    return np.stack([x, y, np.zeros_like(x)], axis=1)


def on_sphere(radius: float) -> Callable[[NDArray, NDArray], NDArray]:
    """Lay the plane on a sphere that touches it at the origin, true along rays from there."""

    def place(x: NDArray, y: NDArray) -> NDArray:
        reach = np.hypot(x, y)
        share = np.sinc(reach / radius / np.pi)
        return np.stack([x * share, y * share, radius * (np.cos(reach / radius) - 1.0)], axis=1)

    return place


def on_cylinder(radius: float) -> Callable[[NDArray, NDArray], NDArray]:
    """Roll the plane round a cylinder along y that touches it at the origin."""

    def place(x: NDArray, y: NDArray) -> NDArray:
        turn = x / radius
        return np.stack([radius * np.sin(turn), y, radius * (np.cos(turn) - 1.0)], axis=1)

    return place


def folded(gap: float) -> Callable[[NDArray, NDArray], NDArray]:
    """Fold the strip -90 < x < 90 as a Z: three layers of 60 mm with `gap` between them.

    The top layer (x > 30) lies in z = 0 and faces up, as does the lowest in z = -2 gap.
    """
    bend = 0.5 * gap
    arc = np.pi * bend

    def place(x: NDArray, y: NDArray) -> NDArray:
        s = x + 90.0
        run = 60.0 - arc  # straight part of every layer
        u, z = np.empty_like(s), np.empty_like(s)
        low = s <= run
        u[low], z[low] = s[low], -2.0 * gap
        first = (s > run) & (s <= run + arc)
        turn = (s[first] - run) / bend
        u[first] = run + bend * np.sin(turn)
        z[first] = -1.5 * gap - bend * np.cos(turn)
        middle = (s > run + arc) & (s <= 2.0 * run + arc)
        u[middle], z[middle] = 2.0 * run + arc - s[middle], -gap
        second = (s > 2.0 * run + arc) & (s <= 2.0 * (run + arc))
        turn = (s[second] - 2.0 * run - arc) / bend
        u[second] = -bend * np.sin(turn)
        z[second] = -0.5 * gap - bend * np.cos(turn)
        top = s > 2.0 * (run + arc)
        u[top], z[top] = s[top] - 2.0 * (run + arc), 0.0
        return np.stack([u, y, z], axis=1)

    return place


def bowl(inner: float = 40.0, wall: float = WALL) -> TriangleMesh:
    """A hemisphere, open upwards, with a wall of `wall` mm and a flat rim at z = 0."""
    angle = np.linspace(-UPRIGHT, 0.0, 60)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ray[0, 0] = 0.0
    across = np.linspace(inner, inner + wall, 4)[1:-1]
    rim = np.stack([across, np.zeros(2)], axis=1)
    points = np.concatenate([inner * ray, rim, (inner + wall) * ray[::-1]])
    normals = np.concatenate([-ray, np.tile([0.0, 1.0], (2, 1)), ray[::-1]])
    return revolve(points, normals, 1.5, "bowl")


def ball(radius: float, edge: float = 1.5) -> TriangleMesh:
    """A whole sphere about the origin."""
    angle = np.linspace(UPRIGHT, -UPRIGHT, max(24, round(np.pi * radius / edge)))
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ray[[0, -1], 0] = 0.0
    return revolve(radius * ray, ray, edge, "ball")


def box(side: float = 40.0) -> TriangleMesh:
    """A cube whose upper face lies in z = 0, of twelve triangles."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-1.0, 0.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return TriangleMesh(side * corners, faces, name="box")


def together(*meshes: TriangleMesh) -> TriangleMesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(m.n_vertices for m in meshes)])
    return TriangleMesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + start for m, start in zip(meshes, starts[:-1], strict=True)]),
    )


def moved(mesh: TriangleMesh, by: tuple[float, float, float]) -> TriangleMesh:
    """The mesh elsewhere."""
    return TriangleMesh(mesh.vertices + np.float32(by), mesh.faces)


def turned_over(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh with every face looking the other way."""
    return TriangleMesh(mesh.vertices, mesh.faces[:, ::-1])


# -- pressing -------------------------------------------------------------------------------------


def poses(
    points: NDArray,
    normals: NDArray,
    along: NDArray,
    pressures: NDArray,
    brush: str = "full",
    tilt: float = UPRIGHT,
    rate: float = 250.0,
) -> Recording:
    """A brush over surface points (N, 3) with normals and bend directions `along` (N, 3)."""
    spec = load_brush(brush)
    n = len(points)
    z = np.broadcast_to(np.asarray(normals, float), (n, 3))
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    x = np.broadcast_to(np.asarray(along, float), (n, 3))
    x = x - np.sum(x * z, axis=1, keepdims=True) * z
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    height = spec.length_mm * np.sin(tilt) - np.asarray(pressures) * spec.full_press_mm
    lean = Rotation.from_rotvec((tilt - UPRIGHT) * y)
    frames = np.stack([lean.apply(x), y, lean.apply(z)], axis=2)
    return Recording(
        (np.arange(n) * (1e9 / rate)).round().astype(np.int64),
        points + height[:, None] * z,
        quaternions_from_matrices(frames),
        np.asarray(pressures, float),
    )


def press(
    mesh: TriangleMesh,
    point: tuple[float, float, float] = (0.0, 0.0, 0.0),
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    along: tuple[float, float, float] = (0.0, 1.0, 0.0),
    pressure: float = 0.4,
    brush: str = "full",
    tilt: float = UPRIGHT,
    resolution: float = 0.4,
) -> Painter:
    """Set the brush on one point and move it by a twentieth of a millimetre, so that it inks."""
    painter = Painter(PaintedSurface(mesh, resolution), brush)
    start = np.asarray(point, float)
    points = np.stack([start, start + 0.05 * np.asarray(along, float)])
    painter.replay(poses(points, normal, along, np.full(2, pressure), brush, tilt))
    return painter


def footprint_area(brush: str, pressure: float, tilt: float = UPRIGHT) -> float:
    """Area (mm2) of the footprint in the plane."""
    spec = load_brush(brush)
    return make_footprint(build_tuft(spec), pressure * spec.full_press_mm, tilt).rounded().area


def painted_area(painter: Painter, where: NDArray | None = None) -> float:
    """Painted surface (mm2), or that of the vertices `where` (V,) bool."""
    surface = painter.surface
    covered = surface.vertex_areas * surface.coverage
    return float(covered.sum() if where is None else covered[where].sum())


# -- cases ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """Result of a press: areas in mm2, `astray` of it where none may be; fraction of ink lost."""

    name: str
    footprint: float
    painted: float
    astray: float
    off: float

    @property
    def ratio(self) -> float:
        """Painted area over the footprint's."""
        return self.painted / self.footprint


def measure(
    name: str,
    mesh: TriangleMesh,
    astray: Callable[[NDArray, NDArray], NDArray] | None = None,
    **pressing: object,
) -> Case:
    """Press on a mesh; `astray` tells from vertices and normals (V, 3) what must stay bare."""
    painter = press(mesh, **pressing)
    paint_mesh = painter.surface.paint_mesh
    wrong = 0.0
    if astray is not None:
        wrong = painted_area(painter, astray(paint_mesh.vertices, paint_mesh.normals))
    ledger = painter.ledger()
    released = ledger["loaded"] - ledger["in_brush"]
    options = {k: pressing[k] for k in ("brush", "pressure", "tilt") if k in pressing}
    footprint = footprint_area(**{"brush": "full", "pressure": 0.4, **options})
    off = ledger["off_surface"] / released if released > 0.0 else 0.0
    return Case(name, footprint, painted_area(painter), wrong, off)


def sphere(radius: float, **pressing: object) -> Case:
    """The outside of a sphere, pressed at its top."""
    half = min(30.0, 2.0 * radius)
    mesh = sheet(on_sphere(radius), (half, half), min(1.0, radius / 25.0))
    return measure(f"sphere, radius {radius:g} mm", mesh, **pressing)


def dish(radius: float, **pressing: object) -> Case:
    """The inside of a sphere, pressed at its bottom."""
    half = min(30.0, 1.2 * radius)
    mesh = sheet(on_sphere(-radius), (half, half), min(1.0, radius / 25.0))
    return measure(f"dish, radius {radius:g} mm", mesh, **pressing)


def bowl_inside(**pressing: object) -> Case:
    """Half-way up the inner wall."""
    level = np.sqrt(0.5)
    return measure(
        "bowl, inside",
        bowl(),
        lambda v, n: (v * n).sum(axis=1) > 0.0,
        point=(0.0, 40.0 * level, -40.0 * level),
        normal=(0.0, -level, level),
        along=(0.0, level, level),
        **pressing,
    )


def bowl_outside(**pressing: object) -> Case:
    """The same place from outside."""
    level = np.sqrt(0.5)
    return measure(
        "bowl, outside",
        bowl(),
        lambda v, n: (v * n).sum(axis=1) < 0.0,
        point=(0.0, 42.0 * level, -42.0 * level),
        normal=(0.0, level, -level),
        along=(0.0, level, level),
        **pressing,
    )


def bowl_rim(**pressing: object) -> Case:
    """The rim from above, and of the inner wall what faces the leaning plane: not the outside."""
    return measure(
        "bowl, rim",
        bowl(),
        lambda v, n: ((v * n).sum(axis=1) > 10.0) & (n[:, 2] < 0.2),
        point=(0.0, 41.0, 0.0),
        along=(1.0, 0.0, 0.0),
        **pressing,
    )


def box_edge(distance: float = 2.0, **pressing: object) -> Case:
    """The upper face of a cube, 2 mm from its edge, which the footprint overhangs."""
    return measure(
        f"cube, {distance:g} mm from an edge",
        box(),
        lambda v, n: n[:, 2] < 0.5,
        point=(20.0 - distance, 0.0, 0.0),
        **pressing,
    )


def cylinder(radius: float, along: tuple[float, float, float], **pressing: object) -> Case:
    """A cylinder from outside."""
    mesh = sheet(on_cylinder(radius), (min(30.0, 3.0 * radius), 30.0), min(1.0, radius / 25.0))
    way = "along" if along[1] else "across"
    return measure(f"cylinder, radius {radius:g} mm, {way}", mesh, along=along, **pressing)


def shells(**pressing: object) -> Case:
    """Two spheres about one centre, 1 mm apart, both facing outwards."""
    return measure(
        "spheres 1 mm apart",
        together(ball(40.0), ball(40.0 - GAP)),
        lambda v, n: np.linalg.norm(v, axis=1) < 40.0 - 0.5 * GAP,
        point=(0.0, 0.0, 40.0),
        **pressing,
    )


def plates(**pressing: object) -> Case:
    """Two plates, 1 mm apart, both facing up."""
    top = sheet(flat, (30.0, 30.0))
    return measure(
        "plates 1 mm apart",
        together(top, moved(top, (0.0, 0.0, -GAP))),
        lambda v, n: v[:, 2] < -0.5 * GAP,
        **pressing,
    )


def fold(**pressing: object) -> Case:
    """The top layer of a Z fold, 6 mm from the bend; the lowest layer, 2 mm below, faces up too."""
    return measure(
        "Z fold, layers 1 mm apart",
        sheet(folded(GAP), (90.0, 25.0), 0.5),
        lambda v, n: v[:, 2] < -0.5 * GAP,
        point=(6.0, 0.0, 0.0),
        **pressing,
    )


def from_behind(**pressing: object) -> Case:
    """A plane whose faces look away from the brush."""
    return measure("plane from behind", turned_over(sheet(flat, (30.0, 30.0))), **pressing)


def two_sided(**pressing: object) -> Case:
    """Two planes back to back, with no thickness between them."""
    front = sheet(flat, (30.0, 30.0))
    return measure(
        "two-sided plane",
        together(front, turned_over(front)),
        lambda v, n: n[:, 2] < 0.0,
        **pressing,
    )


def cases() -> list[Case]:
    """Every case, in the order of the table."""
    return [
        measure("plane", sheet(flat, (30.0, 30.0))),
        bowl_inside(),
        bowl_outside(),
        bowl_rim(),
        cylinder(20.0, (0.0, 1.0, 0.0)),
        cylinder(20.0, (1.0, 0.0, 0.0)),
        cylinder(50.0, (0.0, 1.0, 0.0)),
        cylinder(50.0, (1.0, 0.0, 0.0)),
        *(sphere(radius) for radius in RADII),
        *(dish(radius) for radius in RADII[2:]),
        box_edge(),
        shells(),
        plates(),
        fold(),
        from_behind(),
        two_sided(),
    ]


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print(f"{'case':34}{'footprint':>10}{'painted':>9}{'ratio':>7}{'astray':>8}{'off':>7}")
    print(f"{'':34}{'mm2':>10}{'mm2':>9}{'':>7}{'mm2':>8}{'%':>7}")
    for case in cases():
        print(
            f"{case.name:34}{case.footprint:10.1f}{case.painted:9.1f}{case.ratio:7.3f}"
            f"{case.astray:8.2f}{100.0 * case.off:7.1f}"
        )


if __name__ == "__main__":
    main()
