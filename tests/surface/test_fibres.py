"""The fibres of a sheet: streaks in all directions, the same wherever a place is asked for."""

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

import paint3d.surface.pores as pores
from paint3d.colour.materials import load_material
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.pores import fibre_relief
from tests.surface.test_diffusion import drop, everything, grid

STEP = 0.06  # mm


def square(normal=(0.0, 0.0, 1.0), side=240):
    """Points (N, 3) of a square that faces a direction, row by row."""
    normal = np.array(normal) / np.linalg.norm(normal)
    u = np.cross(normal, [0.31, 0.7, 0.2])
    u /= np.linalg.norm(u)
    i, j = np.meshgrid(*[STEP * np.arange(side)] * 2)
    return i.reshape(-1, 1) * u + j.reshape(-1, 1) * np.cross(normal, u)


def coherence(height, side=240, window=200):
    """Mean of how far heights on a square vary in one direction only, near each place: 0 to 1."""
    gy, gx = np.gradient(height.reshape(side, side))
    xx, yy, xy = (uniform_filter(part, window) for part in (gx * gx, gy * gy, gx * gy))
    return np.mean(np.hypot(xx - yy, 2.0 * xy) / (xx + yy + 1e-12))


def test_a_place_has_the_same_fibres_whoever_asks():
    points = square(side=40)
    some = np.random.default_rng(1).permutation(len(points))[:300]
    np.testing.assert_array_equal(fibre_relief(points, 0.3)[some], fibre_relief(points[some], 0.3))


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0.4, 0.5, 0.7)])
def test_no_direction_prevails(normal):
    points = square(normal)
    relief = fibre_relief(points, 0.3)
    assert abs(relief.mean()) < 0.25
    assert relief.std() > 0.3
    assert coherence(relief) < 0.2  # over 12 mm no direction prevails


@pytest.mark.parametrize("material", ["xuan", "tinted xuan", "sized xuan", "silk"])
def test_a_sheet_has_the_same_flocs_however_far_apart_its_vertices_lie(material):
    """Fibres fade where vertices are too far apart to show them; what is left does not change."""
    points, drink = 10.0 * square(side=40), load_material(material)
    coarse = pores.find_pores(points, drink, 3.0)
    for name, there in pores.find_pores(points, drink, 1.1999)._asdict().items():
        np.testing.assert_allclose(getattr(coarse, name), there, rtol=1e-3, atol=1e-6, err_msg=name)


def outline_turns():
    """How much the outline of a drop's soot goes in and out from one 30th to the next, mm."""
    surface = drop(PaintedSurface(grid(16.0, 0.2), None, "xuan"), 1.0)
    drop(surface, 2.0, ink="water").diffuse(20.0)
    points = surface.paint_mesh.vertices
    away, angle = np.linalg.norm(points[:, :2], axis=1), np.arctan2(points[:, 1], points[:, 0])
    ink = everything(surface)
    inked = ink > 0.03 * np.median(ink[away < 1.5])
    cell = ((angle + np.pi) / (2 * np.pi) * 30).astype(int) % 30  # some .8 mm: four vertices
    rim = [away[inked & (cell == k)].max(initial=0.0) for k in range(30)]
    return np.abs(np.diff(rim, n=2)).mean()


def test_ink_feathers_in_fine_points_along_fibres(monkeypatch):
    feathered = outline_turns()
    for name in ("_FIBRES_OF_WAYS", "_FIBRES_OF_SIEVE", "_FIBRES_OF_CATCH"):
        monkeypatch.setattr(pores, name, 0.0)
    assert feathered > 1.8 * outline_turns()
