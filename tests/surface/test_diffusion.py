"""Ink in the surface: it spreads and stops, keeps its mass, and does not see the triangles."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import uniform_filter
from scipy.spatial import Delaunay

import paint3d
import paint3d.surface.flow as flows
import paint3d.surface.pores as pores
from paint3d.colour.materials import WET_COAT_MM, WET_INK_MM, Material, load_material
from paint3d.colour.pigments import load_pigment
from paint3d.errors import InputError, PigmentError
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.flow_graph import graph_of_triangles
from paint3d.surface.kernels.diffusion import activate_cells
from paint3d.surface.kernels.grain import fill_grain
from paint3d.surface.kernels.wet_graph import grade_paces, group_blocks
from paint3d.surface.kernels.wet_step import (
    WORKSPACE_TOO_SMALL,
    Absorption,
    WetFields,
    Workspace,
    move_water,
)
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.pores import fibre_relief
from paint3d.surface.wet_patch import WetPatch

XUAN = load_material("xuan")
SMOOTH = dataclasses.replace(XUAN, grain=0.0)
WORKSPACE = Workspace(np.full(100_000, np.nan), np.full(50_000, -7, np.int32))


def grid(size: float, spacing: float) -> TriangleMesh:
    n = round(size / spacing) + 1
    x, y = np.meshgrid(*[np.linspace(-size / 2, size / 2, n)] * 2)
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)]).astype(np.float32)
    return TriangleMesh(points, np.vstack([np.c_[a, b, c], np.c_[a, c, d]]).astype(np.int32))


def irregular(size: float, spacing: float) -> TriangleMesh:
    inner = np.random.default_rng(5).uniform(-size / 2, size / 2, (int((size / spacing) ** 2), 2))
    edge = np.linspace(-size / 2, size / 2, round(size / spacing) + 1)
    border = np.vstack([np.c_[edge, s + 0 * edge] for s in (-size / 2, size / 2)])
    flat = np.vstack([inner, border, border[:, ::-1]])
    flat = np.unique(flat, axis=0)
    points = np.column_stack([flat, np.zeros(len(flat))]).astype(np.float32)
    return TriangleMesh(points, Delaunay(flat).simplices.astype(np.int32))


def drop(surface, coats, radius=3.0, centre=(0.0, 0.0, 0.0), ink="pine soot"):
    """Lay a disc of wet ink, its border softened over half a millimetre, of a given volume."""
    column = surface.column_of(load_pigment(ink))
    away = np.linalg.norm(surface.paint_mesh.vertices - np.asarray(centre), axis=1)
    share = np.clip((radius - away) / 0.5 + 0.5, 0, 1).astype(np.float32)
    ids = np.flatnonzero(share > 0).astype(np.int32)
    scale = coats * np.pi * radius**2 / (share @ surface.vertex_areas)
    surface.ink.amounts[ids, column] += np.float32(scale) * share[ids]
    surface.ink.coverage[ids] = np.maximum(surface.ink.coverage[ids], share[ids])
    surface.touch(ids)
    return surface


def everything(surface):
    """Ink of all sorts, wet and dry, on every vertex (V,), coats."""
    amounts = surface.amounts.sum(axis=1).astype(float)
    amounts[surface.dry_layers.vertex_ids] += surface.dry_layers.amounts.sum(axis=1)
    return amounts


def spread(surface):
    """Radius of gyration of the ink, mm, and its mean amount in rings of 1 mm."""
    away = np.linalg.norm(surface.paint_mesh.vertices[:, :2], axis=1)
    areas, ink = surface.vertex_areas, everything(surface)
    mass = ink * areas
    rings = [
        mass[(away >= r) & (away < r + 1)].sum() / areas[(away >= r) & (away < r + 1)].sum()
        for r in range(5)
    ]
    return np.sqrt((away**2 @ mass) / mass.sum()), np.array(rings)


def spread_disc(mesh, seconds=10.0, step=None, material=SMOOTH, resolution=None):
    surface = PaintedSurface(mesh, resolution, material)
    surface.refine_all()
    drop(surface, 6.0).diffuse(seconds, step)
    return spread(surface)


def test_radius_and_profile_do_not_depend_on_the_triangles():
    radius, rings = spread_disc(grid(22, 0.4))
    assert radius > 1.1 * 3.0 / np.sqrt(2.0)
    for mesh in (irregular(22, 0.4), grid(22, 0.3)):
        other_radius, other_rings = spread_disc(mesh)
        assert other_radius == pytest.approx(radius, rel=0.03)
        np.testing.assert_allclose(other_rings, rings, atol=0.05 * rings[0])  # a rim is sharp
    lazy = spread_disc(grid(22, 5.5), resolution=0.5)
    assert lazy[0] == pytest.approx(radius, rel=0.03)


def test_radius_does_not_depend_on_the_step():
    mesh = grid(22, 0.5)
    radius, rings = spread_disc(mesh)
    for step in (1.0 / 30.0, 0.5, 1e3):
        other_radius, other_rings = spread_disc(mesh, step=step)
        assert other_radius == pytest.approx(radius, rel=0.01)
        np.testing.assert_allclose(other_rings, rings, atol=0.01 * rings[0])


def test_time_may_pass_in_pieces():
    whole, pieces = (drop(PaintedSurface(grid(16, 0.5), None, SMOOTH), 2.0) for _ in range(2))
    whole.diffuse(6.0)
    for _ in range(60):
        pieces.diffuse(0.1)
    assert spread(pieces)[0] == pytest.approx(spread(whole)[0], rel=0.01)


@pytest.mark.parametrize("seconds", [5.0, 1e6])  # while it runs, and until it is dry
def test_how_far_it_is_is_told(seconds: float):
    told: list[float] = []
    told_of, silent = (drop(PaintedSurface(grid(16, 0.5), None, XUAN), 2.0) for _ in range(2))
    told_of.diffuse(seconds, progress=told.append)
    silent.diffuse(seconds)
    assert len(told) > 10
    assert told == sorted(told)
    assert told[0] > 0.0
    assert told[-1] == 1.0
    np.testing.assert_array_equal(told_of.amounts, silent.amounts)


def test_ink_is_conserved_and_stops_by_itself():
    surface = drop(PaintedSurface(grid(20, 0.5), None, XUAN), 4.0)
    drop(surface, 1.0, 2.0, (4.0, 0.0, 0.0), "cinnabar")
    laid = surface.wet_ink()
    for seconds in (0.0, 0.5, 20.0, 200.0, 3600.0):
        surface.diffuse(seconds)
        assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-6)
        assert surface.amounts.min() >= 0.0
    assert surface.flow.n_wet == 0
    assert surface.flow.water == 0.0
    assert surface.wet_ink() == 0.0
    steps = surface.flow.steps
    assert steps < 1000
    surface.diffuse(1e6)
    assert surface.flow.steps == steps


def test_water_stops_where_the_fibres_hold_it():
    """Without evaporation the area is volume / (pores x advance), whatever the way there."""
    still = dataclasses.replace(SMOOTH, drying_mm_s=0.0)
    surface = drop(PaintedSurface(grid(20, 0.5), None, still), 3.0)
    volume = surface.wet_ink() * WET_INK_MM
    surface.diffuse(3000.0)
    assert surface.flow.water == pytest.approx(volume, rel=1e-9)
    ids, depth = surface.flow.depths()
    held = still.pores_mm * still.advance
    areas = surface.vertex_areas[ids]
    assert (np.minimum(depth / held, 1.0) @ areas) == pytest.approx(volume / held, rel=0.12)
    assert depth.max() < 1.35 * held


def test_a_pool_on_glaze_stays_where_it_was_laid_and_gathers_at_its_border():
    surface = drop(PaintedSurface(grid(12, 0.5), None, "porcelain"), 1.0)
    drop(surface, 1.5, ink="water")
    before, laid = everything(surface) / 2.5, surface.wet_ink()  # of soot alone
    surface.diffuse(2.5 * 2.0 * WET_COAT_MM / surface.material.drying_mm_s)
    assert surface.dry_ink() == pytest.approx(laid, rel=1e-6)
    after = everything(surface)
    assert not after[before == 0.0].any()
    away = np.linalg.norm(surface.paint_mesh.vertices[:, :2], axis=1)
    assert after[away < 1.0].mean() < 0.97 * before[away < 1.0].mean()
    assert after.max() > 1.5 * before.max()


def test_thick_paint_dries_later():
    surface = PaintedSurface(grid(12, 0.5), None, "porcelain")
    drop(surface, 0.5, 1.5, (-3.0, 0.0, 0.0))
    drop(surface, 2.0, 1.5, (3.0, 0.0, 0.0))
    surface.diffuse(0.2 * WET_INK_MM / surface.material.drying_mm_s)
    left = surface.paint_mesh.vertices[:, 0] < 0
    middle = np.abs(np.abs(surface.paint_mesh.vertices[:, 0]) - 3.0) < 0.6
    assert not surface.coverage[left & middle].any()
    assert surface.coverage[~left & middle].any()


def test_rims_dry_darker():
    surface = drop(PaintedSurface(grid(16, 0.4), None, dataclasses.replace(SMOOTH, passing=1.0)), 2)
    surface.diffuse(3600.0)
    away = np.linalg.norm(surface.paint_mesh.vertices[:, :2], axis=1)
    ink = everything(surface)
    rings = np.array([ink[(away >= r) & (away < r + 0.5)].mean() for r in np.arange(0, 6, 0.5)])
    core = rings[:3].mean()
    assert 1.3 * core < rings.max() < 4.0 * core
    assert 2.5 < 0.5 * rings.argmax() < 5.0


def test_pigment_lags_behind_the_water_where_it_is_held():
    free = spread_disc(grid(20, 0.5), material=dataclasses.replace(SMOOTH, passing=1.0))[0]
    held = spread_disc(grid(20, 0.5), material=dataclasses.replace(SMOOTH, passing=0.3))[0]
    assert held < 0.93 * free


def test_grain_makes_the_outline_rough():
    rough = {}
    for name, material in (("smooth", SMOOTH), ("grained", XUAN)):
        surface = drop(PaintedSurface(grid(20, 0.4), None, material), 3.0)
        surface.diffuse(10.0)
        ids, depth = surface.flow.depths()
        points = surface.paint_mesh.vertices[ids[depth > 0]]
        turn = np.floor((np.arctan2(points[:, 1], points[:, 0]) + np.pi) / (2 * np.pi) * 24)
        away = np.linalg.norm(points[:, :2], axis=1)
        reach = np.array([away[turn == k].max() for k in range(24)])
        rough[name] = reach.std() / reach.mean()
    assert rough["grained"] > 2.0 * rough["smooth"]


def test_wet_meets_wet_and_mixes_but_not_with_the_dry():
    surface = drop(PaintedSurface(grid(24, 0.5), None, SMOOTH), 5.0, 2.5, (-3.5, 0, 0), "indigo")
    drop(surface, 5.0, 2.5, (3.5, 0, 0), "gamboge")
    drop(surface, 2.5, 6.0, ink="water")
    surface.diffuse(15.0)
    both = (surface.amounts[:, :2] > 0.01).all(axis=1)
    assert surface.vertex_areas[both].sum() > 3.0
    surface.dry()
    laid = everything(surface).copy()
    drop(surface, 2.0, 2.0)
    surface.diffuse(5.0)
    np.testing.assert_array_equal(surface.dry_layers.amounts.sum(axis=1).min() >= 0, True)
    assert (everything(surface) >= laid - 1e-4).all()


def test_paint_that_comes_later_wets_and_what_is_taken_away_does_not():
    surface = drop(PaintedSurface(grid(16, 0.5), None, SMOOTH), 1.0)
    surface.diffuse(1.0)
    water = surface.flow.water
    ink = surface.wet_ink()
    drop(surface, 1.0)
    surface.diffuse(0.0)
    added = surface.wet_ink() - ink
    assert surface.flow.water == pytest.approx(water + WET_INK_MM * added, rel=1e-6)
    surface.refresh()
    half = surface.ink.amounts[: surface.n_vertices] * np.float32(0.5)
    surface.ink.amounts[: surface.n_vertices] = half
    surface.touch(np.arange(surface.n_vertices, dtype=np.int32))
    before = surface.flow.water
    surface.diffuse(0.0)
    assert surface.flow.water < 0.75 * before
    assert surface.wet_ink() == pytest.approx(0.5 * (ink + added), rel=1e-5)


def test_plain_water_thins_and_leaves_no_amount():
    surface = drop(PaintedSurface(grid(20, 0.5), None, SMOOTH), 0.5, 2.0)
    drop(surface, 4.0, 4.0, ink="water")
    laid = surface.wet_ink()
    surface.diffuse(5.0)
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-6)
    assert not surface.amounts[:, 1].any()
    assert spread(surface)[0] > 1.5 * 2.0 / np.sqrt(2.0)


def test_vertices_appear_ahead_of_the_water():
    surface = PaintedSurface(paint3d.load_mesh("plane"), 0.6, SMOOTH)
    column = surface.column_of(load_pigment("pine soot"))
    fields = surface.paint_mesh.arrays
    cells = np.flatnonzero((fields.cell_place[:, :2] * fields.cell_size < 4).all(axis=1))
    activate_cells(surface.paint_mesh.arrays, cells.astype(np.int32), 0)
    n = surface.n_vertices
    corner = surface.paint_mesh.vertices[0]
    ids = np.flatnonzero(np.linalg.norm(surface.paint_mesh.vertices - corner, axis=1) < 3)
    surface.ink.amounts[ids, column] = 6.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids.astype(np.int32))
    laid = surface.wet_ink()
    surface.diffuse(10.0)
    assert surface.n_vertices > n
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-6)


def test_the_mesh_may_grow_between_two_calls():
    surface = drop(PaintedSurface(paint3d.load_mesh("plane"), 4.0, SMOOTH), 2.0, 12.0)
    surface.diffuse(0.1)
    surface.make_room(3 * surface.paint_mesh.capacity)
    surface.refine_all()
    new = np.array([surface.n_vertices - 1], np.int32)
    surface.ink.amounts[new, 0] = 1.0
    surface.ink.coverage[new] = 1.0
    surface.touch(new)
    laid = surface.wet_ink() + surface.dry_ink()
    surface.diffuse(0.1)
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-6)


def test_ink_runs_around_a_crease():
    n = 21
    s = np.linspace(-5, 5, n)
    u, v = np.meshgrid(s, s)
    points = np.column_stack([u.ravel(), v.ravel(), -np.abs(u.ravel())]).astype(np.float32)
    mesh = TriangleMesh(points, grid(10, 0.5).faces)
    surface = drop(PaintedSurface(mesh, None, SMOOTH), 10.0, 2.0, (1.5, 0.0, -1.5))
    surface.diffuse(10.0)
    left = surface.paint_mesh.vertices[:, 0] < -0.75
    assert everything(surface)[left].max() > 0.1


def sheared():
    mesh = grid(10, 0.5)
    points = mesh.vertices.astype(float).copy()
    points[:, 0] += 2.5 * points[:, 1]
    return points, mesh.faces


def test_no_weight_is_negative_and_linear_functions_are_at_rest():
    points, faces = sheared()
    runs, links, weights = graph_of_triangles(points, faces)
    assert weights.min() > 0.0
    start = np.repeat(np.arange(len(points)), np.diff(runs))
    inside = (np.abs(points[:, 1]) < 3.0) & (np.abs(points[:, 0] - 2.5 * points[:, 1]) < 3.0)
    for f in (points[:, 0], points[:, 1]):
        pull = np.bincount(start, weights * (f[links] - f[start]), minlength=len(points))
        assert np.abs(pull[inside]).max() < 1e-9
    mirror = {(a, b): w for a, b, w in zip(start, links, weights, strict=True)}
    assert all(mirror[b, a] == pytest.approx(w) for (a, b), w in mirror.items())


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_links_do_not_depend_on_the_order_of_triangles_or_where_they_begin(seed):
    points, faces = sheared()
    random = np.random.default_rng(seed)
    points = points + random.normal(0.0, 0.05, points.shape)
    faces = np.concatenate([faces, faces[:1], [[3, 3, 7], [0, 1, 1]]]).astype(np.int32)
    turned = (random.integers(3, size=len(faces))[:, None] + np.arange(3)) % 3
    others = np.take_along_axis(faces, turned, axis=1)[random.permutation(len(faces))]
    for one, other in zip(
        graph_of_triangles(points, faces), graph_of_triangles(points, others), strict=True
    ):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("step", [1e-3, 0.1, 10.0, 1e4])
def test_no_new_extremes_at_any_step(step):
    points, faces = sheared()
    runs, links, weights = graph_of_triangles(points, faces)
    n = len(points)
    rng = np.random.default_rng(0)
    area = rng.uniform(0.01, 0.5, n)
    water = rng.uniform(0.0, 0.1, n) * (rng.uniform(size=n) < 0.3)
    share = rng.uniform(0.2, 0.7, n)
    pigment = (share * water)[:, None].copy()
    residual = rng.uniform(0.1, 0.4, n)
    strength = 0.06 * 10.0 * (1 - residual) / 3
    entry = np.where(water > 0, 0.0, 0.02 * strength)
    volume, mass = water @ area, pigment[:, 0] @ area
    fields = WetFields(
        runs[:-1], runs[1:], links, weights, area, np.zeros(n, np.int32), np.zeros(n, np.uint8),
        np.zeros(n, np.int32), residual, strength, np.zeros(n), np.full(n, 0.3),
        np.full(n, 0.02), entry, water,
        pigment, 0.2 * pigment, 0.3 * pigment, np.ones(1), np.ones(1),
        np.zeros(n, np.float32), np.zeros(n, bool), np.array([step], np.float32),
        np.ones(1, bool), np.zeros(1, bool), np.zeros((1, 3)),
    )  # fmt: skip
    nodes = np.arange(n, dtype=np.int32)
    given = (fields, nodes, nodes[:0], Absorption(0.06, 10.0, 1.0, 0.06, 1.0), step, np.ones(1))
    before = water.copy()
    for little in (
        Workspace(WORKSPACE.floats[:500], WORKSPACE.ints),
        Workspace(WORKSPACE.floats, WORKSPACE.ints[:200]),
    ):
        assert move_water(*given, little) == WORKSPACE_TOO_SMALL
    np.testing.assert_array_equal(water, before)
    assert move_water(*given, WORKSPACE) > 0
    assert not fields.place.any()
    assert water.min() >= 0.0
    assert water @ area == pytest.approx(volume, rel=1e-12)
    assert pigment[:, 0] @ area == pytest.approx(mass, rel=1e-12)
    wet = water > 1e-9
    concentration = pigment[wet, 0] / water[wet]
    assert concentration.min() > 0.2 - 1e-9
    assert concentration.max() < 0.7 + 1e-9


@pytest.mark.parametrize("flows_in", [True, False])
def test_no_node_gives_more_than_it_has_to_many_neighbours(flows_in):
    """As in the middle of a cylinder's cap, whose triangles all share one vertex."""
    sides = 64
    n = sides + 1
    runs = np.concatenate([[0], np.arange(sides, 2 * sides + 1)]).astype(np.int64)
    links = np.concatenate([np.arange(1, n), np.zeros(sides)]).astype(np.int32)
    area = np.full(n, 0.01)
    water = np.full(n, 0.055 if flows_in else 0.02)
    water[0] = 0.02 if flows_in else 0.1
    pigment = np.zeros((n, 1))
    pigment[0] = 1.0
    before, strength = pigment.copy(), np.full(n, 0.06 * 10.0 * 0.8 / 3)
    fields = WetFields(
        runs[:-1], runs[1:], links, np.ones(2 * sides), area, np.zeros(n, np.int32),
        np.zeros(n, np.uint8), np.zeros(n, np.int32), np.full(n, 0.2), strength, np.zeros(n),
        np.full(n, 0.3), np.full(n, 0.02), np.zeros(n), water,
        pigment, 0.5 * pigment, 0.5 * pigment, np.ones(1), np.ones(1),
        np.ones(n, np.float32), np.zeros(n, bool), np.array([0.01], np.float32),
        np.ones(1, bool), np.zeros(1, bool), np.zeros((1, 3)),
    )  # fmt: skip
    nodes = np.arange(n, dtype=np.int32)
    absorbs = Absorption(0.06, 10.0, 1.0, 0.06, 1.0)
    assert move_water(fields, nodes, nodes[:0], absorbs, 0.01, np.ones(1), WORKSPACE) > 0
    assert (pigment[1:] > 0.0).all()
    for part in (pigment, fields.fine, fields.loose):
        assert part.min() >= 0.0
    assert pigment[:, 0] @ area == pytest.approx(before[:, 0] @ area, rel=1e-12)


def test_memory_to_work_in_grows_as_it_must_and_is_given_back(monkeypatch):
    found = []
    for least, most in ((1 << 18, 1 << 24), (1 << 8, 1 << 12)):
        monkeypatch.setattr(flows, "_WORKSPACE", least)
        monkeypatch.setattr(flows, "_MOST_WORKSPACE", most)
        monkeypatch.setattr(flows, "work_memory", flows.WorkMemory())
        surface = drop(PaintedSurface(grid(12, 0.5), None, SMOOTH), 2.0)
        surface.diffuse(1.0)
        assert len(flows.work_memory.workspace.floats) == least
        found.append(surface.amounts)
    np.testing.assert_array_equal(*found)


def test_work_grows_with_the_root_of_the_time():
    """Nothing has to converge: a hundred times the time takes ten times the stages."""
    points, faces = sheared()
    runs, links, weights = graph_of_triangles(points, faces)
    n = len(points)
    nodes, residual = np.arange(n, dtype=np.int32), np.full(n, 0.15)
    stages = []
    for step in (0.1, 10.0):
        water = np.full(n, 0.05)
        water[: n // 2] = 0.055
        fields = WetFields(
            runs[:-1], runs[1:], links, weights, np.full(n, 0.25), np.zeros(n, np.int32),
            np.zeros(n, np.uint8), np.zeros(n, np.int32), residual, np.full(n, 0.17),
            np.full(n, 0.02), np.full(n, 0.3), np.full(n, 0.02), np.zeros(n), water,
            water[:, None].copy(),
            water[:, None].copy(), np.zeros((n, 1)), np.ones(1), np.ones(1),
            np.ones(n, np.float32),
            np.zeros(n, bool),
            np.array([step], np.float32), np.ones(1, bool), np.zeros(1, bool), np.zeros((1, 3)),
        )  # fmt: skip
        given = (
            fields,
            nodes,
            nodes[:0],
            Absorption(0.06, 10.0, 0.8, 0.06, 1.0),
            step,
            np.zeros(1),
            WORKSPACE,
        )
        stages.append(move_water(*given))
        assert 0.05 - 1e-12 <= water.min() <= water.max() <= 0.055 + 1e-12
    assert stages[1] == pytest.approx(10 * stages[0], rel=0.25)


def test_grain_depends_on_the_place_alone():
    points = np.random.default_rng(1).uniform(-50, 50, (2000, 3))
    height, again = np.empty(2000), np.empty(2000)
    fill_grain(points, 0.8, height)
    fill_grain(np.ascontiguousarray(points[::-1]), 0.8, again)
    assert (height == again[::-1]).all()
    assert 0.0 <= height.min() < 0.2
    assert 0.8 < height.max() <= 1.0
    assert height.mean() == pytest.approx(0.5, abs=0.02)
    near = np.empty(2000)
    fill_grain(points + 0.01, 0.8, near)
    assert np.abs(near - height).max() < 0.1
    for axis in range(3):  # it varies along each of them
        fill_grain(points + 5.0 * np.eye(3)[axis], 0.8, near)
        assert abs(np.corrcoef(near, height)[0, 1]) < 0.2


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf"), "soon"])
def test_bad_times_are_named(seconds):
    with pytest.raises(InputError, match="seconds is"):
        PaintedSurface(grid(4, 1.0), None).diffuse(seconds)


def test_bad_ways_to_drink_are_named():
    with pytest.raises(InputError, match="step"):
        PaintedSurface(grid(4, 1.0), None).diffuse(1.0, step=0.0)
    with pytest.raises(PigmentError, match="residual of x is 1"):
        Material("x", np.ones(31), 0, 0, 0, 0, residual=1.0)
    with pytest.raises(PigmentError, match="spread_mm2_s of x"):
        Material("x", np.ones(31), 0, 0, 0, 0, spread_mm2_s=float("nan"))


def laid(radius=2.5, coats=6.0):
    """A sheet of paper, refined where ink comes, with a wet disc on it."""
    surface = PaintedSurface(paint3d.load_mesh("plane"), 0.6, SMOOTH)
    fields = surface.paint_mesh.arrays
    middle = fields.origin + (fields.cell_place + 0.5) * fields.cell_size
    cells = np.flatnonzero(np.linalg.norm(middle[:, :2], axis=1) < radius + 3.0).astype(np.int32)
    activate_cells(fields, cells, 0)
    return drop(surface, coats, radius)


def outcome(surface):
    """Area that is inked, mm2; radius of gyration of the ink, mm; and its sum."""
    ink, areas = everything(surface), surface.vertex_areas
    return np.array([areas[ink > 0.02].sum(), spread(surface)[0], ink @ areas])


@functools.cache
def spread_at_once(seconds):
    surface = laid()
    surface.diffuse(seconds)
    return outcome(surface)


@settings(max_examples=25, deadline=None)
@given(
    cuts=st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=12),
    seconds=st.sampled_from([0.3, 3.0, 20.0]),
    beside=st.booleans(),
    most_nodes=st.sampled_from([500, 3000, 10**6]),
)
def test_spreading_ends_and_does_not_depend_on_how_time_is_cut(cuts, seconds, beside, most_nodes):
    surface = laid()
    before = surface.wet_ink()
    for part in np.array(cuts) / np.sum(cuts):
        if not beside:
            surface.diffuse(seconds * part)
            continue
        n = max(1, round(seconds * part / 0.05))
        for _ in range(n):  # as beside a hand, with as much work as it takes
            keeps_up = surface.follow_flow(seconds * part / n, most_nodes)
            while not keeps_up:
                keeps_up = surface.follow_flow(0.0, most_nodes)
    surface.diffuse(1e-9)  # brings all to now
    area, radius, ink = outcome(surface)
    expected = spread_at_once(seconds)
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(before, rel=1e-6)
    assert ink == pytest.approx(expected[2], rel=1e-6)
    hurried = beside and most_nodes < 1000  # a fifth of it: steps get longer
    assert radius == pytest.approx(expected[1], rel=0.05 if hurried else 0.01)
    # what a long step exchanges is bounded, so soot's thin border depends on them a little
    assert area == pytest.approx(expected[0], rel=0.1 if hurried else 0.05 if beside else 0.03)
    assert surface.flow.steps < 100 * seconds + 400


def test_a_long_step_into_new_ground_ends():
    """Ink that runs far in one step: the patch grows until it holds it, once and for all."""
    surface = laid(coats=12.0)
    before = surface.wet_ink()
    surface.diffuse(0.0)
    kept = surface.keep_flow()
    kept["pace"][:] = 20.0  # as after a long rest
    surface.restore_flow(kept)
    n = surface.n_vertices
    surface.diffuse(20.0)
    assert surface.flow.steps < 40
    assert surface.n_vertices > 2 * n
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(before, rel=1e-6)
    assert outcome(surface)[1] == pytest.approx(outcome(spread_slowly())[1], rel=0.05)


def spread_slowly():
    surface = laid(coats=12.0)
    surface.diffuse(20.0)
    return surface


def test_a_slice_of_work_is_bounded_and_the_rest_is_done_later():
    surface = laid(radius=8.0, coats=2.0)
    other = laid(radius=8.0, coats=2.0)
    other.diffuse(0.0)
    while surface.follow_flow(0.0, 200) and len(surface.flow.waiting):
        pass  # until all its ways are known
    assert surface.follow_flow(1.0 / 30.0, 200)
    moved = np.flatnonzero(surface.flow.depths()[1] != other.flow.depths()[1])
    assert 0 < len(moved) < 0.5 * np.count_nonzero(other.flow.depths()[1])
    calls = 1
    while surface.flow.patience == 0.0:
        assert surface.follow_flow(0.0, 200)
        calls += 1
    assert 4 < calls < 200
    assert not surface.follow_flow(0.3, 200)  # now it is behind


def test_no_more_than_a_few_blocks_are_opened_in_one_call(monkeypatch):
    """Where much is wet at once, as after opening a painting, the hand need not wait for it."""
    most = 2
    monkeypatch.setattr(flows, "_OPENED", most)
    surface, whole = laid(radius=12.0, coats=1.0), laid(radius=12.0, coats=1.0)
    whole.diffuse(0.0)
    before = surface.wet_ink()
    opened, calls = 0, 0
    while surface.follow_flow(0.0) and len(surface.flow.waiting):
        now = np.count_nonzero(surface.flow_graph.block_open)
        assert opened < now <= opened + most
        opened, calls = now, calls + 1
        assert surface.flow_patience == 0.0
    assert calls > 3
    assert surface.flow.water == whole.flow.water
    assert surface.wet_ink() == pytest.approx(before, rel=1e-6)


def test_ink_that_waits_to_be_taken_up_is_kept(monkeypatch):
    monkeypatch.setattr(flows, "_OPENED", 2)
    surface = laid(radius=12.0, coats=1.0)
    surface.follow_flow(0.02)
    kept = surface.keep_flow()
    before = surface.flow.water
    surface.restore_flow(kept)
    keeps_up = [surface.follow_flow(0.05) for _ in range(5)]
    assert keeps_up[0]
    assert not all(keeps_up)  # time has to stand still for it
    while len(surface.flow.waiting):
        surface.follow_flow(0.0)
    assert surface.flow.water > 1.5 * before
    volume = WET_INK_MM * surface.wet_ink()
    assert surface.flow.water == pytest.approx(volume, rel=0.01)  # a little has dried


def test_ink_that_waits_is_not_lost_to_ink_that_runs_there(monkeypatch):
    monkeypatch.setattr(flows, "_OPENED", 1)
    surface = laid(radius=12.0, coats=3.0)
    before = surface.wet_ink()
    waited = 0
    for _ in range(40):
        surface.follow_flow(0.05)
        waited += len(surface.flow.waiting) > 0
        assert surface.wet_ink() + surface.dry_ink() == pytest.approx(before, rel=1e-6)
    assert waited > 1


def test_ink_that_comes_onto_what_is_about_to_dry_stays_wet():
    """A touch dries while the stroke that follows it is taken up: dark dots were left of these."""
    surface = PaintedSurface(grid(12.0, 0.5), None, XUAN)
    drop(surface, 1e-5)
    surface.follow_flow(0.01)
    touch = surface.wet_ink() + surface.dry_ink()
    drop(surface, 0.5)
    drop(surface, 0.5, ink="water")
    laid = surface.wet_ink()
    surface.follow_flow(0.01)
    assert 0.0 < surface.dry_ink() <= 1.001 * touch
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-6)
    assert surface.flow.water == pytest.approx(
        0.5 * (WET_INK_MM + WET_COAT_MM) * np.pi * 9.0, rel=1e-3
    )  # half a coat of each
    assert surface.ink.coverage.max() == 1.0
    surface.diffuse(5.0)
    assert surface.dry_ink() < 1e-3 * laid


def test_ink_that_comes_onto_what_dries_covers_as_much_as_it_did():
    """Also where it is taken up later: ink without coverage would not be seen until then."""
    surface = drop(PaintedSurface(grid(12.0, 0.5), None, XUAN), 1e-5)
    patch = WetPatch(surface)
    patch.read_surface(patch.find_changed(np.flatnonzero(surface.coverage).astype(np.int32)))
    patch.write_surface()
    drop(surface, 0.5)
    laid = surface.coverage.copy()
    patch.dry(np.arange(patch.graph.n_nodes))
    wet = surface.amounts.any(axis=1)
    assert wet.any()
    np.testing.assert_array_equal(surface.coverage[wet], laid[wet])
    assert not surface.coverage[~wet].any()
    assert surface.wet_ink() == pytest.approx(0.5 * np.pi * 9.0, rel=1e-3)


def test_the_outcome_does_not_depend_on_the_threads(monkeypatch):
    """Drops apart from one another, each moved by whoever has time, or by one thread."""
    monkeypatch.setattr(flows, "_BUNDLE", 100)
    found = []
    for each in (flows.each, lambda work, items: [work(item) for item in items]):
        numbers = []

        def counted(work, items, each=each, numbers=numbers):
            numbers.append(len(items))
            return each(work, items)

        monkeypatch.setattr(flows, "each", counted)
        surface = PaintedSurface(grid(60, 15.0), 0.6, XUAN)
        surface.refine_all()
        for x in (-25.0, 0.0, 25.0):
            for y in (-25.0, 0.0, 25.0):
                drop(surface, 2.0 + 0.02 * x, 2.0, (x, y, 0.0))
        for _ in range(20):
            surface.follow_flow(0.05)
        surface.diffuse(5.0)
        assert max(numbers) > 4
        found.append((surface.amounts.copy(), surface.flow.depths()[1], surface.srgb.copy()))
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


def test_still_water_waits_for_its_step():
    surface = laid()
    surface.diffuse(60.0)
    surface.refresh()
    surface.diffuse(0.0)
    assert surface.flow_patience > 0.1
    steps = surface.flow.steps
    assert surface.follow_flow(0.5 * surface.flow_patience)
    assert surface.flow.steps == steps
    assert not PaintedSurface(grid(4, 1.0), None, SMOOTH).flow_patience < np.inf


# -- blocks that are moved together ------------------------------------------------------------


SIDE = 6


def lattice():
    """Blocks of a square: the run of each one's neighbours, and these."""
    n = SIDE * SIDE
    row, column = np.divmod(np.arange(n), SIDE)
    near = (np.abs(row[:, None] - row) <= 1) & (np.abs(column[:, None] - column) <= 1)
    np.fill_diagonal(near, False)
    last = np.cumsum(near.sum(axis=1))
    return near, last - near.sum(axis=1), last, np.nonzero(near)[1].astype(np.int32)


def some_blocks():
    return st.sets(st.integers(0, SIDE * SIDE - 1), min_size=1).map(
        lambda blocks: np.array(sorted(blocks), np.int64)
    )


@settings(max_examples=60, deadline=None)
@given(some_blocks())
def test_no_block_lies_next_to_two_groups(blocks):
    near, first, last, beside = lattice()
    head, group = np.full(SIDE * SIDE, -1, np.int32), np.empty(len(blocks), np.int32)
    count = group_blocks(blocks, first, last, beside, head, group)
    assert (head == -1).all()
    reach = near | np.eye(SIDE * SIDE, dtype=bool)
    meets = (reach[blocks].astype(int) @ reach[:, blocks].astype(int)) > 0
    for _ in range(SIDE * SIDE):  # whoever meets through others meets
        meets = (meets.astype(int) @ meets.astype(int)) > 0
    np.testing.assert_array_equal(group[:, None] == group, meets)
    assert sorted(set(group.tolist())) == list(range(count))
    assert group[0] == 0


@settings(max_examples=60, deadline=None)
@given(some_blocks(), st.sampled_from([1.01, 1.15, 2.0]), st.integers(0, 2**31))
def test_steps_differ_little_from_block_to_block(wet, most, seed):
    near, first, last, beside = lattice()
    pace = np.full(SIDE * SIDE, np.inf, np.float32)
    pace[wet] = np.exp(np.random.default_rng(seed).uniform(-3, 3, len(wet)))
    before = pace.copy()
    grade_paces(wet, first, last, beside, most, pace)
    assert (pace <= before).all()
    assert pace.min() == before.min()
    both = near[np.ix_(wet, wet)]
    quotient = pace[wet][:, None] / pace[wet]
    assert quotient[both].max(initial=0.0) <= most * (1 + 1e-6)


# -- fibres ------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("height", [0.0, 0.7])
def test_grain_lies_along_no_side_of_a_sheet(height):
    """Or fronts have square corners: how far gradients lie along the axes, 0 to 1."""
    side = 0.2 * np.arange(600)
    x, y = np.meshgrid(side, side)
    grain = np.empty(x.size)
    fill_grain(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)]), 2.4, grain)
    gy, gx = np.gradient(grain.reshape(x.shape))
    fourfold = (gx + 1j * gy) ** 4 / np.maximum(gx * gx + gy * gy, 1e-12)
    assert abs(fourfold.sum()) / (gx * gx + gy * gy).sum() < 0.12  # .18 to .20 where it does


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
    assert feathered > 1.3 * outline_turns()
