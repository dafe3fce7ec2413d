"""Granulation: coarse grains lie unevenly in thin washes, and only to the eye."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.colour.difference import lab_from_srgb
from paint3d.colour.pigments import load_pigment
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.granulation import COARSE_UM, granulated
from paint3d.surface.painted_surface import PaintedSurface

SPACING = 0.2


def spread(grain_um: float, coats: float) -> np.ndarray:
    """Thickness over the mean at 40,000 places of an even coat."""
    points = np.zeros((40_000, 3))
    points[:, :2] = np.random.default_rng(4).uniform(0.0, 200.0, (40_000, 2))
    amounts = np.full((40_000, 1), coats, np.float32)
    return (
        granulated(amounts, np.ones(40_000, np.float32), points, np.array([grain_um]), SPACING)
        / coats
    )


def sheet() -> PaintedSurface:
    """A sheet of 8 mm with vertices .2 mm apart."""
    side = np.arange(0.0, 8.0, SPACING)
    points = np.stack(np.meshgrid(side, side, [0.0]), axis=-1).reshape(-1, 3)
    k = np.arange(side.size**2).reshape(side.size, -1)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    mesh = TriangleMesh(points, np.vstack([np.c_[a, b, c], np.c_[a, c, d]]), name="sheet")
    return PaintedSurface(mesh, resolution=None, material="xuan")


def lay(target: PaintedSurface, name: str, coats: float) -> PaintedSurface:
    """Wet all of it evenly."""
    column, ids = target.column_of(load_pigment(name)), np.arange(target.n_vertices, dtype=np.int32)
    target.ink.amounts[ids, column] += np.float32(coats)
    target.ink.coverage[ids] = 1.0
    target.touch(ids)
    return target


def unevenness(target: PaintedSurface) -> float:
    """Standard deviation of L* over the vertices."""
    return float(lab_from_srgb(target.srgb / 255.0)[:, 0].std())


@pytest.mark.parametrize("grain_um", [10.0, 20.0, 40.0])
@pytest.mark.parametrize("coats", [0.05, 0.5, 2.0])
def test_grains_are_scattered_and_not_made(grain_um, coats):
    assert spread(grain_um, coats).mean() == pytest.approx(1.0, abs=0.06)
    assert spread(grain_um, coats).min() > 0.0


def test_large_grains_and_thin_washes_are_uneven():
    by_size = [spread(grain, 0.3).std() for grain in (5.0, 10.0, 20.0, 40.0)]
    assert (np.diff(by_size) > 0.0).all()
    assert by_size[2] == pytest.approx(8.0**0.5 * by_size[1], rel=0.1)  # 1 / sqrt(N), N as 1 / d^3
    by_coats = [spread(20.0, coats).std() for coats in (0.1, 0.4, 1.6)]
    assert by_coats[0] > 1.8 * by_coats[1] > 3.2 * by_coats[2]


def test_the_fine_is_even_to_the_bit():
    amounts = np.random.default_rng(1).random((500, 2), np.float32)
    points = np.random.default_rng(2).random((500, 3))
    seen = granulated(
        amounts, np.ones(500, np.float32), points, np.array([0.99 * COARSE_UM, 20.0]), SPACING
    )
    np.testing.assert_array_equal(seen[:, 0], amounts[:, 0])
    assert (seen[:, 1] != amounts[:, 1]).mean() > 0.99


def test_grains_lie_where_the_place_has_them_however_many_are_asked():
    amounts = np.ones((300, 1), np.float32)
    points, coverage = np.random.default_rng(3).random((300, 3)) * 50.0, np.ones(300, np.float32)
    all_at_once = granulated(amounts, coverage, points, np.array([40.0]), SPACING)
    for some in (np.array([17]), np.arange(299, 100, -7)):
        few = granulated(amounts[some], coverage[some], points[some], np.array([40.0]), SPACING)
        np.testing.assert_array_equal(few, all_at_once[some])


def test_a_wash_of_stone_is_granular_and_one_of_indigo_is_not():
    assert unevenness(lay(sheet(), "indigo", 0.2)) < 0.5
    washes = [unevenness(lay(sheet(), name, 0.2)) for name in ("azurite 1", "azurite", "azurite 4")]
    assert washes[0] > washes[1] > 2.0
    assert washes[2] < 1.0
    assert unevenness(lay(sheet(), "malachite", 0.2)) > 2.0
    assert unevenness(lay(sheet(), "azurite", 3.0)) < 0.5  # a coat that hides is even


def test_amounts_stay_and_drying_changes_no_colour():
    target = lay(sheet(), "azurite 1", 0.25)
    wet, before = target.srgb.astype(int), target.wet_ink()
    assert target.ink.amounts[: target.n_vertices, 0].tolist() == [0.25] * target.n_vertices
    target.dry()
    assert np.abs(target.srgb.astype(int) - wet).max() <= 1
    assert target.dry_ink() == pytest.approx(before, rel=1e-6)


def test_stone_is_granular_over_dried_paint_and_on_a_layer_too():
    over = lay(sheet(), "ochre", 0.3)
    over.dry()
    plain = over.srgb.astype(int)
    lay(over, "azurite 1", 0.2)
    assert plain.std(axis=0).max() < 0.5
    assert unevenness(over) > 2.0
    layered = sheet()
    layered.use_layers().add("above", 1)
    lay(layered, "azurite 1", 0.2)
    np.testing.assert_allclose(
        layered.srgb.astype(int), lay(sheet(), "azurite 1", 0.2).srgb.astype(int), atol=1
    )
