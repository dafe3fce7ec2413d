"""Layers: wet paint mixes, dry paint is glazed over, and a mesh's own colours are a ground."""

import dataclasses

import numpy as np
import pytest

import paint3d
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.glazing import srgb_primaries
from paint3d.colour.layers import layer_reflectance, stack_reflectance
from paint3d.colour.pigments import Pigment, load_drawdown_paints, load_pigment
from paint3d.colour.spectra import decode_srgb, rgb_weights, srgb_from_reflectance
from paint3d.errors import InputError
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.colour_codes import worth_of_one_code

PLANE = paint3d.load_mesh("plane")


def surface(material="xuan", mesh=PLANE) -> PaintedSurface:
    return PaintedSurface(mesh, resolution=None, material=material)


def lay(target: PaintedSurface, name, coats, coverage=1.0, ids=(0,)):
    column = target.column_of(load_pigment(name) if isinstance(name, str) else name)
    ids = np.asarray(ids, np.int32)
    target.ink.amounts[ids, column] += coats
    target.ink.coverage[ids] = np.maximum(target.ink.coverage[ids], coverage)
    target.touch(ids)
    return target.srgb[ids[0]].astype(int)


def film(name, coats):
    pigment = load_pigment(name)
    return pigment.K, pigment.S, coats


def test_white_over_dry_black_covers_and_black_over_wet_white_greys():
    covered, mixed = surface(), surface()
    black = lay(covered, "pine soot", 1.0)
    covered.dry()
    assert np.abs(covered.srgb[0].astype(int) - black).max() <= 1
    white = lay(covered, "titanium white", 1.5)
    assert white.min() > 235
    lay(mixed, "titanium white", 1.5)
    grey = lay(mixed, "pine soot", 1.0)
    assert black.max() + 30 < grey.min() < grey.max() < white.min() - 30


def test_the_order_of_dry_layers_matters_and_that_of_wet_paint_does_not():
    shown = {}
    for dries in (True, False):
        for first, second in (("gamboge", "indigo"), ("indigo", "gamboge")):
            target = surface()
            lay(target, first, 0.5)
            if dries:
                target.dry()
            shown[dries, first] = lay(target, second, 0.5)
    assert (shown[False, "gamboge"] == shown[False, "indigo"]).all()
    apart = delta_e(*(lab_from_srgb(shown[True, a] / 255.0) for a in ("gamboge", "indigo")))
    assert apart > 3


def test_many_dry_layers_are_composed_exactly():
    target = surface("porcelain")
    layers = [("cinnabar", 0.3), ("indigo", 0.1), ("gamboge", 0.4), ("pine soot", 0.05)] * 5
    for name, coats in layers:
        lay(target, name, coats)
        target.dry()
    wanted = stack_reflectance([film(*layer) for layer in layers], target.material.reflectance)
    kept = target.dry_layers.spectra[0] / 65535.0
    np.testing.assert_allclose(kept, wanted, atol=2e-4)
    assert np.abs(target.srgb[0].astype(int) - srgb_from_reflectance(wanted)).max() <= 1


def test_the_same_paint_dried_in_two_coats_is_one_coat():
    twice, once = surface(), surface()
    lay(twice, "cinnabar", 0.2)
    twice.dry()
    two = lay(twice, "cinnabar", 0.3)
    assert np.abs(two - lay(once, "cinnabar", 0.5)).max() <= 1


def test_what_is_half_covered_shows_the_ground_between():
    target = surface()
    before = lay(target, "pine soot", 0.5, coverage=0.5).copy()
    target.dry()
    assert np.abs(target.srgb[0].astype(int) - before).max() <= 1
    assert target.coverage[0] == 0.0
    assert target.painted[0]
    assert not target.painted[1]


def test_live_colours_over_dry_layers_are_within_the_stated_difference():
    rng = np.random.default_rng(4)
    target = surface()
    names = ["pine soot", "cinnabar", "indigo", "gamboge", "malachite"]
    n = target.n_vertices
    shown, wanted = [], []
    ids = np.arange(n, dtype=np.int32)
    below = np.repeat(target.material.reflectance[None], n, axis=0)
    for _ in range(3):
        chosen = rng.choice(names, 2, replace=False)
        coats = 10 ** rng.uniform(-2, 0.5, (n, 2))
        k = s = 0.0
        for i, name in enumerate(chosen):
            pigment = load_pigment(str(name))
            lay(target, str(name), coats[:, i].astype(np.float32), ids=ids)
            k, s = k + coats[:, i, None] * pigment.K, s + coats[:, i, None] * pigment.S
        below = layer_reflectance(k, s, 1.0, below)
        shown.append(target.srgb.copy())
        wanted.append(srgb_from_reflectance(below))
        target.dry()
    codes = np.concatenate(wanted)
    shown, wanted = (lab_from_srgb(np.concatenate(colours)) for colours in (shown, wanted))
    apart = delta_e(shown, wanted)
    assert apart.mean() < 0.1
    assert (apart - worth_of_one_code(codes)).max() < 0.6  # whole codes are compared


def test_memory_is_for_painted_vertices_alone():
    target = surface()
    lay(target, "pine soot", 1.0, ids=range(10))
    target.dry()
    lay(target, "cinnabar", 1.0, ids=range(5, 12))
    target.dry()
    assert target.dry_layers.count == 12
    assert target.dry_layers.spectra.shape == (12, 31)
    assert sorted(target.dry_layers.vertex_ids) == list(range(12))


def test_ink_is_conserved_by_drying():
    target = surface()
    lay(target, "pine soot", 0.7, ids=range(100))
    wet = target.wet_ink()
    target.settle(np.arange(40, dtype=np.int32))
    assert 0.0 < target.dry_ink() < wet
    assert target.wet_ink() + target.dry_ink() == pytest.approx(wet, rel=1e-6)
    lay(target, "cinnabar", 0.2, ids=range(20))
    lay(target, "water", 5.0, ids=range(20))
    both = target.wet_ink() + target.dry_ink()
    target.dry()
    assert target.wet_ink() == 0.0
    assert target.dry_ink() == pytest.approx(both, rel=1e-6)


def test_drying_nothing_changes_nothing():
    target = surface()
    before = target.srgb.copy()
    target.dry()
    lay(target, "pine soot", 0.0, coverage=0.0)
    target.dry()
    assert (target.srgb == before).all()
    assert target.dry_layers.count == 0


def test_glossy_paint_dries_to_what_was_measured():
    paint = load_drawdown_paints()["Vermillion"]
    target = surface("porcelain")
    wet = lay(target, paint, 0.3).copy()
    target.dry()
    assert np.abs(target.srgb[0].astype(int) - wet).max() <= 1
    lay(target, paint, 0.7)
    target.dry()
    once = stack_reflectance([(paint.K, paint.S, 1.0)], target.material.reflectance, glossy=True)
    assert np.abs(target.srgb[0].astype(int) - srgb_from_reflectance(once)).max() <= 1


def test_any_srgb_colour_is_a_reflectance():
    primaries = srgb_primaries()
    assert primaries.min() >= 0.0
    np.testing.assert_allclose(primaries.sum(axis=1), 1.0, atol=1e-10)
    np.testing.assert_allclose(primaries.T @ rgb_weights(), np.eye(3), atol=1e-9)
    codes = np.random.default_rng(1).integers(0, 256, (500, 3)).astype(np.uint8)
    spectra = decode_srgb(codes) @ srgb_primaries().T
    assert spectra.min() >= 0.0
    assert spectra.max() <= 1.0 + 1e-9
    assert (srgb_from_reflectance(spectra) == codes).all()


def coloured() -> PaintedSurface:
    codes = np.random.default_rng(2).integers(0, 256, (PLANE.n_vertices, 3)).astype(np.uint8)
    return surface(mesh=dataclasses.replace(PLANE, colours=codes))


def test_a_meshs_own_colours_are_the_ground():
    target = coloured()
    order = target.paint_mesh.source_vertices
    assert (target.srgb == target.source.colours[order]).all()
    before = target.srgb.copy()
    ids = np.arange(target.n_vertices, dtype=np.int32)
    lay(target, "pine soot", 0.0, coverage=1e-9, ids=ids)  # coloured by the kernel, not kept
    assert (target.srgb == before).all()
    lay(target, "gamboge", 0.1, ids=[7])
    gamboge = load_pigment("gamboge")
    below = decode_srgb(before[7]) @ srgb_primaries().T
    wanted = srgb_from_reflectance(layer_reflectance(gamboge.K, gamboge.S, 0.1, below))
    assert np.abs(target.srgb[7].astype(int) - wanted).max() <= 1
    target.dry()
    assert np.abs(target.srgb[7].astype(int) - wanted).max() <= 1


def test_refined_vertices_lie_between_the_colours_and_export_takes_them_back():
    codes = np.zeros((PLANE.n_vertices, 3), np.uint8)
    codes[:, 0] = np.linspace(0, 250, PLANE.n_vertices)
    mesh = dataclasses.replace(PLANE, colours=codes)
    target = PaintedSurface(mesh, resolution=2.0)
    target.refine_all()
    parents = target.paint_mesh.arrays.parents[: target.n_vertices]
    added = np.flatnonzero(parents[:, 0] >= 0)
    mean = target.srgb[parents[added]].astype(float).mean(axis=1)
    assert len(added) > 1000
    assert np.abs(target.srgb[added] - mean).max() <= 1.01
    vertices, _, _, srgb = target.export_arrays()
    assert len(vertices) == mesh.n_vertices
    assert (srgb == codes).all()


def test_an_ink_of_the_same_name_must_be_the_same():
    target = surface()
    target.column_of(load_pigment("cinnabar"))
    other = Pigment("cinnabar", "", np.ones(31), np.ones(31))
    with pytest.raises(InputError, match="another ink named 'cinnabar'"):
        target.column_of(other)
    for otherwise in ({"gloss": 0.5}, {"fine": 0.9}, {"grain_um": 9.0}, {"saunderson": True}):
        alike = dataclasses.replace(load_pigment("cinnabar"), **otherwise)
        with pytest.raises(InputError, match="another ink named 'cinnabar'"):
            target.column_of(alike)


def test_a_painting_keeps_the_inks_that_it_was_begun_with(tmp_path):
    """An ink that ships cannot be named otherwise; a later version may have measured it anew."""
    begun = surface()
    old = Pigment("cinnabar", "朱砂", np.full(31, 2.0), np.ones(31))
    begun.column_of(old)
    save_session(Session(begun), tmp_path / "old.p3d")
    again = load_session(tmp_path / "old.p3d").surface
    Painter(again, ink="cinnabar")
    assert [pigment.name for pigment in again.pigments] == ["cinnabar"]
    np.testing.assert_array_equal(again.pigments[0].K, old.K)
