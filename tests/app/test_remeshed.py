"""A score of a bowl, painted again on the same bowl meshed anew: strokes lie where they lay."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.files.load import load_mesh
from paint3d.mesh.closest_points import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score

RESOLUTION_MM = 0.5
MOST_MM = 0.5  # off where it was


@cache
def bowl() -> TriangleMesh:
    return load_mesh("bowl")


def stroke(angles, heights, meant: bool, n: int = 30) -> list:
    """A stroke around the outside of the bowl; by the place that is meant, or the root's."""
    around = np.linspace(*angles, n)
    out = [120.0 * np.cos(around), 120.0 * np.sin(around), np.linspace(*heights, n)]
    found = ClosestPoints(bowl()).find(np.column_stack(out))
    up = found.normals
    turns = np.column_stack([1.0 + up[:, 2], -up[:, 1], up[:, 0], np.zeros(n)])
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    pressure = np.full(n, 0.45)
    pressure[[0, -1]] = 0.0
    samples = Recording(
        8_000_000 * np.arange(n), found.points + 30.0 * up, turns, pressure,
        contact=found.points if meant else None,
    )  # fmt: skip
    return [{"do": "begin_stroke"}, samples, {"do": "end_stroke"}]


@cache
def score() -> Score:
    """Strokes with a mask of a region and an angle, and one with a mirror image."""
    outside = ClosestPoints(bowl()).find(np.array([[120.0, 0.0, 30.0]])).points[0].tolist()
    mask = {"do": "set_mask", "regions": [{"at": outside, "up_to": "crease", "degrees": 40}],
            "angle": {"direction": [1, 0, 0.2], "degrees": 50}}  # fmt: skip
    mirror = {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]}
    events = (
        *stroke((-0.5, 0.2), (22, 38), True), mask, *stroke((0.2, 1.2), (44, 30), False),
        {"do": "set_mask"}, mirror, *stroke((2.0, 2.5), (26, 40), True),
    )  # fmt: skip
    return Score({"object": "bowl", "resolution_mm": RESOLUTION_MM}, events)


@cache
def first() -> Document:
    return painted(score(), bowl())


def subdivided() -> TriangleMesh:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(bowl().vertices, bowl().faces, process=False).subdivide()
    return TriangleMesh(mesh.vertices, mesh.faces)


def decimated() -> TriangleMesh:
    open3d = pytest.importorskip("open3d")
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(bowl().vertices.astype(float)),
        open3d.utility.Vector3iVector(np.array(bowl().faces)),
    )
    mesh = mesh.simplify_quadric_decimation(bowl().n_faces // 3)
    return TriangleMesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles))


def inked(document: Document) -> np.ndarray:
    surface = document.surface
    return surface.paint_mesh.vertices[surface.coverage > 0.0].astype(float)


@pytest.mark.parametrize(
    ("mesh", "resolution"), [(subdivided, 0.5), (decimated, 0.4), (bowl, 0.3)],
    ids=["subdivided", "decimated", "finer paint"],
)  # fmt: skip
def test_strokes_lie_where_they_lay(mesh, resolution) -> None:
    one, other = inked(first()), inked(painted(score(), mesh(), resolution))
    off = [cKDTree(b).query(a)[0] for a, b in ((one, other), (other, one))]
    for distances in off:
        print(f"median {np.median(distances):.3f} mm, worst {distances.max():.3f} mm")
        assert np.median(distances) <= 0.5 * MOST_MM
        assert distances.max() <= MOST_MM


def test_a_mask_and_a_mirror_do_what_they_did() -> None:
    """They hold something back and paint something, or what is above would say nothing of them."""
    plain = Score(score().header, tuple(
        e for e in score().events
        if isinstance(e, Recording) or e["do"] not in ("set_mask", "set_symmetry")
    ))  # fmt: skip
    without, of_all = inked(painted(plain, bowl())), inked(first())
    far = cKDTree(of_all).query(without)[0]
    assert (far > 2.0).sum() > 100
    assert (cKDTree(without).query(of_all)[0] > 2.0).sum() > 100
