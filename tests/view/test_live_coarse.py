"""An object drawn coarsely is the same object, with fewer triangles."""

from __future__ import annotations

import numpy as np
import pytest

import paint3d
from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view.kernels.shine import add_shine
from paint3d.view.live_coarse import CoarseObject
from paint3d.view.live_object import LiveObject

NONE = np.empty(0, np.int32)


@pytest.fixture(scope="module")
def shown() -> LiveObject:
    surface = PaintedSurface(paint3d.load_mesh("bowl"), 2.0)
    surface.refine_all()
    found = LiveObject(surface, faces=1000)
    found.uploads(NONE)
    return found


def coarse(shown: LiveObject, size: float) -> CoarseObject:
    surface = shown.surface

    def seen(ids: AnyArray, srgb: AnyArray) -> AnyArray:
        return np.pad(shown.light.colours(ids, srgb), ((0, 0), (0, 1)), constant_values=PLAIN_SHINE)

    return CoarseObject(surface.paint_mesh, shown.patches, size, seen, surface.codes)


def area(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, k]].astype(np.float64) for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_finer_than_the_mesh_it_is_the_mesh(shown: LiveObject) -> None:
    mesh = shown.surface.paint_mesh
    found = coarse(shown, 0.01)
    leaves = mesh.leaf_faces()
    assert found.n_faces == len(leaves)
    lit = shown.light.colours(np.arange(mesh.n_vertices, dtype=np.int32), shown.surface.codes)
    together = np.concatenate([found.colours[piece.clusters, :3] for piece in found.pieces])
    assert together.mean() == pytest.approx(lit.mean(), abs=2.0)
    for piece in found.pieces:
        assert piece.faces.max() < len(piece.clusters)


@pytest.mark.parametrize("size", [3.0, 6.0])
def test_coarser_it_has_fewer_triangles_and_the_same_form(shown: LiveObject, size: float) -> None:
    mesh = shown.surface.paint_mesh
    leaves = mesh.leaf_faces()
    found = coarse(shown, size)
    assert found.n_faces < 0.7 * len(leaves)
    whole = area(mesh.vertices, leaves)
    drawn = sum(area(piece.points, piece.faces) for piece in found.pieces)
    assert drawn == pytest.approx(whole, rel=0.05)
    edges: dict[tuple[int, int], int] = {}
    for piece in found.pieces:
        for a, b, c in piece.clusters[piece.faces].tolist():
            for i, j in ((a, b), (b, c), (c, a)):
                edges[i, j] = edges.get((i, j), 0) + 1
    for (i, j), count in edges.items():  # what was closed has no gap
        assert edges.get((j, i), 0) == count


def test_paint_is_seen_in_it(shown: LiveObject) -> None:
    found = coarse(shown, 4.0)
    surface = shown.surface
    before = found.colours.copy()
    ids = np.flatnonzero(surface.paint_mesh.vertices[:, 0] > 40.0).astype(np.int32)
    codes = surface.codes.copy()
    codes[ids] = 0
    found.repaint(ids, codes)
    dark = found.points[:, 0] > 45.0
    assert found.colours[dark, :3].max() < 10
    assert np.array_equal(found.colours[found.points[:, 0] < 35.0], before[found.points[:, 0] < 35])


def test_it_is_made_again_only_where_it_no_longer_fits(shown: LiveObject) -> None:
    first = shown.coarse_for(0.5, 4000)
    assert first is not None
    assert shown.coarse_for(0.5, 4000) is None
    assert shown.coarse_for(0.45, 4000) is None
    near = shown.coarse_for(0.05, 10_000_000)
    assert near is not None
    assert near.n_faces > first.n_faces
    many = shown.coarse_for(0.05, 20_000)
    assert many is not None
    assert shown.coarse_for(0.05, 20_000) is None
    fewer = shown.coarse_for(0.05, 14_000)  # on a machine that was found to be slow
    assert fewer is not None
    assert fewer.n_faces < many.n_faces < near.n_faces


def test_lamps_shine_where_they_are_mirrored() -> None:
    normals = np.array([[0, 0, 1], [0, 0, -1], [0.6, 0, 0.8]], np.float32)
    lamps = np.array([[0.0, 0.0, 1.0, 1.0, 0.5, 0.0]])
    lobes = np.array([[20.0, 0.2], [100.0, 0.4], [5.0, 0.02]])
    for shine, light in ((PLAIN_SHINE, 51), (255, 102), (1, 5)):
        grey = np.full((3, 4), 100, np.uint8)
        grey[:, 3] = shine
        out = np.empty((3, 4), np.uint8)
        eye = np.array([0, 0, 9.0])
        at = np.zeros((3, 3), np.float32)
        add_shine(at, normals, grey, eye, lamps, lobes, PLAIN_SHINE, out)
        assert out[0].tolist() == [100 + light, 100 + (light + 1) // 2, 100, 255]
        assert np.array_equal(out[1], out[0])  # either side
        assert np.abs(out[2, :3].astype(int) - 100).max() <= 1
