"""The live view: patches hold the whole object, and only what changed travels."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import paint3d
from paint3d.core.arrays import AnyArray
from paint3d.mesh.kernels.refine import activate_cell
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view import live_light, live_scene
from paint3d.view.camera import View, fit_camera
from paint3d.view.kernels.chunks import cone_of
from paint3d.view.kernels.shine import add_shine
from paint3d.view.live_coarse import CoarseObject
from paint3d.view.live_layers import Box, Enlarger, KeptPicture, joined_box
from paint3d.view.live_light import LiveLight
from paint3d.view.live_object import LiveObject
from paint3d.view.live_patches import LivePatches, turned_away
from paint3d.view.live_scene import DARK, LiveScene
from paint3d.view.studio import Gloss, light_samples
from paint3d.view.vtk_parts import DrawnMesh
from tests.support.examples import examples
from tests.support.surface_cases import sheet

NONE = np.empty(0, np.int32)


@pytest.fixture
def surface() -> PaintedSurface:
    return PaintedSurface(paint3d.load_mesh("plane"), 1.0)


def painted_scene(surface: PaintedSurface, size: tuple[int, int]) -> LiveScene:
    """A sheet with a dark half in a picture, seen a little from the side."""
    shown = LiveObject(surface)
    scene = LiveScene(size, DARK)
    scene.clear(shown.centre, shown.radius, Gloss.of("xuan"))
    column = surface.column_of(paint3d.Painter(surface).ink)
    ids = np.flatnonzero(surface.paint_mesh.vertices[:, 0] < -20.0).astype(np.int32)
    surface.ink.amounts[ids, column] = 1.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    surface.refresh()
    scene.apply(shown.uploads(NONE))
    view = View((0.1, -0.4, 1.0), (0.0, 1.0, 0.0))
    scene.set_camera(fit_camera(surface.source.vertices, view, size[0] / size[1]))
    return scene


def canonical(faces: NDArray) -> NDArray:
    """Faces as sorted rows, each beginning with its smallest corner."""
    turned = np.take_along_axis(
        faces, (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3, axis=1
    )
    return turned[np.lexsort(turned.T[::-1])]


def test_patches_hold_every_triangle_once_while_it_is_refined(surface: PaintedSurface) -> None:
    mesh = surface.paint_mesh
    patches = LivePatches(mesh, faces=500)
    drawn: dict[int, NDArray] = {}
    for cell in (None, 3, 400, 401, 7):
        if cell is not None:
            activate_cell(mesh.arrays, cell)
        for change in patches.changes(NONE):
            drawn[change.patch] = change.vertex_ids[change.faces]
        together = np.concatenate(list(drawn.values()))
        assert np.array_equal(canonical(together), canonical(mesh.leaf_faces()))


def test_a_vertex_touches_only_the_patches_that_hold_it(surface: PaintedSurface) -> None:
    surface.refine_all()
    patches = LivePatches(surface.paint_mesh, faces=500)
    everything = patches.changes(NONE)
    assert len(everything) == patches.n_patches > 20
    for vertex in (0, 57, surface.n_vertices - 1):
        found = patches.changes(np.array([vertex], np.int32))
        holding = [c.patch for c in everything if vertex in c.vertex_ids]
        assert [c.patch for c in found] == holding
        assert all(c.faces is None for c in found)
    assert patches.changes(NONE) == []


def test_refining_rebuilds_only_where_cells_split(surface: PaintedSurface) -> None:
    patches = LivePatches(surface.paint_mesh, faces=500)
    patches.changes(NONE)
    activate_cell(surface.paint_mesh.arrays, 200)
    rebuilt = patches.changes(NONE)
    assert 0 < len(rebuilt) < 0.5 * patches.n_patches
    assert patches.changes(NONE) == []


def test_walls_of_a_body_are_patches_apart() -> None:
    surface = PaintedSurface(paint3d.load_mesh("bowl"), 1.0)
    mesh = surface.paint_mesh
    for change in LivePatches(mesh, faces=500).changes(NONE):
        corners = mesh.vertices[change.vertex_ids[change.faces]].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        middle = normals.sum(axis=0)
        assert (normals @ middle > 0.0).mean() > 0.9  # a rim turns within a patch


def test_upload_is_proportional_to_what_is_dirty(surface: PaintedSurface) -> None:
    surface.refine_all()
    shown = LiveObject(surface, faces=500)
    first = sum(upload.n_bytes for upload in shown.uploads(NONE))
    order = np.argsort(surface.paint_mesh.vertices[:, 0]).astype(np.int32)
    sizes = [
        sum(upload.n_bytes for upload in shown.uploads(order[: len(order) // part]))
        for part in (40, 4, 1)
    ]
    assert sizes[0] < 0.12 * sizes[2]
    assert sizes[1] < 0.40 * sizes[2]
    assert sizes[2] < 0.15 * first  # colours alone
    assert shown.uploads(NONE) == []


def test_new_vertices_are_lit_between_their_neighbours(surface: PaintedSurface) -> None:
    shown = LiveObject(surface)
    shown.uploads(NONE)
    n = surface.n_vertices
    light = np.linspace(0.2, 0.8, n)[:, None].repeat(3, axis=1)
    shown.light.take(light)
    activate_cell(surface.paint_mesh.arrays, 10)
    ids = np.arange(n, surface.n_vertices, dtype=np.int32)
    got = shown.light.colours(ids, np.full((surface.n_vertices, 3), 255, np.uint8))
    known = shown.light.colours(np.arange(n, dtype=np.int32), np.full((n, 3), 255, np.uint8))
    parents = surface.paint_mesh.arrays.parents[n]
    low, high = np.sort(known[parents[parents < n]][:, 0])[[0, -1]]
    assert low <= got[0, 0] <= high


def test_the_picture_shows_paint_where_it_was_laid(surface: PaintedSurface) -> None:
    shown = LiveObject(surface)
    scene = LiveScene((160, 120), DARK)
    scene.clear(shown.centre, shown.radius, Gloss.of("xuan"))
    scene.apply(shown.uploads(NONE))
    scene.set_camera(fit_camera(surface.source.vertices, View((0, 0, 1), (0, 1, 0)), 160 / 120))
    before = scene.draw().copy()
    painter = paint3d.Painter(surface)
    column = surface.column_of(painter.ink)
    x = surface.paint_mesh.vertices[:, 0]
    ids = np.flatnonzero(x < -20.0).astype(np.int32)
    surface.ink.amounts[ids, column] = 1.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    scene.apply(shown.uploads(surface.refresh()))
    after = scene.draw().copy()
    darker = after[..., :3].mean(axis=2) < before[..., :3].mean(axis=2) - 60.0
    assert darker[60, 45]
    assert not darker[60, 115]
    fine = scene.draw(fine=True)
    assert fine.shape == (120, 160, 4)
    assert np.abs(fine.astype(int) - after).mean() < 4.0
    baked = shown.light.bake()
    shown.relight(baked)
    scene.set_ground(baked)
    scene.apply(shown.uploads(NONE))
    assert np.isfinite(baked.light).all()
    assert scene.draw()[60, 115, 0] > scene.draw()[5, 5, 0]  # the lit sheet before the dark
    scene.close()


def test_soft_light_is_that_of_the_object_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of another one with as many vertices it is another; refining changes nothing."""
    monkeypatch.setattr(live_light, "light_samples", lambda n: light_samples(n)[::4])

    def trough(depth: float) -> PaintedSurface:
        mesh = sheet(
            lambda x, y: np.stack([x, y, depth * (x / 30.0) ** 2], axis=1), (30.0, 30.0), 2.0
        )
        return PaintedSurface(mesh, 1.0)

    level, deep = trough(0.0), trough(60.0)
    lights = [LiveLight(surface.paint_mesh) for surface in (level, deep)]
    ids = np.arange(level.n_vertices, dtype=np.int32)
    white = np.full((len(ids), 3), 255, np.uint8)
    plain = [light.colours(ids, white).mean(axis=1) for light in lights]
    first = [light.bake() for light in lights]
    for light, baked, before, low, high in zip(
        lights, first, plain, (0.99, 0.8), (1.01, 0.95), strict=True
    ):
        light.take(baked.light)
        away = np.abs(light.mesh.vertices[:, 0])
        share = light.colours(ids, white).mean(axis=1) / before
        assert low < share[away < 8.0].mean() / share[away > 24.0].mean() < high
    assert np.ptp(first[0].light[:, 0]) < 0.01
    assert np.ptp(first[1].light[:, 0]) > 0.1
    deep.refine_all()
    again = lights[1].bake()
    np.testing.assert_array_equal(again.light, first[1].light)
    np.testing.assert_array_equal(again.ground.openness, first[1].ground.openness)
    np.testing.assert_array_equal(again.ground.origin, first[1].ground.origin)


def test_edges_are_smooth_where_nothing_moves(surface: PaintedSurface) -> None:
    shown = LiveObject(surface)
    scene = LiveScene((160, 120), DARK)
    scene.clear(shown.centre, shown.radius, Gloss.of("xuan"))
    scene.apply(shown.uploads(NONE))
    scene.set_camera(fit_camera(surface.source.vertices, View((0.4, -0.3, 1.0)), 160 / 120))
    plain = scene.draw().copy()
    if not scene.is_software:
        pytest.skip("a graphics card smooths all")
    fine = scene.draw(fine=True).copy()
    scene.close()
    assert 40 < smoothed(plain, fine) < 0.1 * 160 * 120  # along the edges, and nowhere else


def smoothed(plain: NDArray, fine: NDArray) -> int:
    """How many pixels are smoothed in the second picture; all lie between those around them."""
    before, after = plain[..., :3].astype(int), fine[..., :3].astype(int)
    around = np.lib.stride_tricks.sliding_window_view(before, (3, 3), axis=(0, 1))
    low, high = around.min(axis=(3, 4)) - 2, around.max(axis=(3, 4)) + 2
    inner = after[1:-1, 1:-1]
    assert ((inner >= low) & (inner <= high)).all()
    return int((np.abs(after - before).max(axis=2) > 20).sum())


def test_a_part_drawn_anew_fits_into_the_whole(surface: PaintedSurface) -> None:
    surface.refine_all()
    shown = LiveObject(surface, faces=500)
    scene = LiveScene((200, 150))
    scene.clear(shown.centre, shown.radius, Gloss.of("porcelain"))
    scene.apply(shown.uploads(NONE))
    scene.set_camera(fit_camera(surface.source.vertices, View((0.3, -1.0, 0.8)), 200 / 150))
    before = scene.draw().copy()
    again = scene.draw(only=(37, 20, 151, 118)).astype(int)
    assert np.array_equal(again, before)
    column = surface.column_of(paint3d.Painter(surface).ink)
    x, y = surface.paint_mesh.vertices[:, :2].T
    ids = np.flatnonzero((np.abs(x) < 15.0) & (np.abs(y) < 15.0)).astype(np.int32)
    surface.ink.amounts[ids, column] = 1.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    changed = scene.apply(shown.uploads(surface.refresh()))
    box = joined_box(scene.screen_box(points) for points in changed)
    assert (box[2] - box[0]) * (box[3] - box[1]) < 0.5 * 200 * 150
    part = scene.draw(only=box).copy()
    assert not np.array_equal(part, before)
    whole = scene.draw().astype(int)
    assert np.array_equal(part, whole)
    scene.close()


WHOLE, HALF = (0, 0, 200, 150), (0, 0, 90, 150)
PART, CORNER = (37, 20, 151, 118), (150, 90, 200, 150)
BOXES = st.sampled_from([WHOLE, HALF, PART, CORNER])
PLACES = st.sampled_from([None, 0.0, 0.2, 0.5])
Drawn = tuple[LiveScene, DrawnMesh, DrawnMesh]


class CopiedAtOnce(KeptPicture):
    """As `LastPicture`, but it copies whatever it is given, both ways."""

    is_lost = False

    def cover(self, box: Box, *, keep: bool = True) -> None:
        pass


@pytest.fixture(scope="module")
def two_scenes() -> Iterator[list[Drawn]]:
    """The same twice: an object, something that may stick in it, something that may be in front.

    The second scene copies at once.
    """
    surface = PaintedSurface(paint3d.load_mesh("vase"), None)
    shown, made = LiveObject(surface), []
    uploads = shown.uploads(NONE)
    with pytest.MonkeyPatch.context() as patch:
        for _ in range(2):
            scene, stuck, brush = LiveScene((200, 150)), DrawnMesh(), DrawnMesh()
            scene.clear(shown.centre, shown.radius, Gloss.of("porcelain"), solid=shown.is_solid)
            scene.apply(uploads)
            scene.set_camera(fit_camera(surface.source.vertices, View((0.3, -1.0, 0.8)), 200 / 150))
            scene.add(stuck)
            scene.add(brush, front=True)
            for one in (stuck, brush):
                stand(one, scene, None)
            scene.draw()
            made.append((scene, stuck, brush))
            patch.setattr(live_scene, "LastPicture", CopiedAtOnce)
    yield made
    for scene, _, _ in made:
        scene.close()


def stand(thing: DrawnMesh, scene: LiveScene, share: float | None) -> None:
    """Put a triangle somewhere from the object's middle (0) toward the eye, or nowhere."""
    thing.show(share is not None)
    if share is not None:
        camera = scene.camera
        away = camera.position - camera.focus
        right = np.cross(camera.up, away)
        places = np.array([[-0.1, -0.05], [0.12, -0.08], [0.02, 0.13]])  # to the right and up
        across = places @ np.stack([right, np.linalg.norm(away) * camera.up])
        nearer = np.array([[share - 0.1], [share + 0.1], [share]])
        corners = camera.focus + nearer * away + (1.0 - share) * across
        faces = np.array([[0, 1, 2], [0, 2, 1]], np.int32)
        thing.set_shape(corners.astype(np.float32), faces)


def test_edges_of_the_brush_are_smooth_too(two_scenes: list[Drawn]) -> None:
    scene, stuck, brush = two_scenes[0]
    if not scene.is_software:
        pytest.skip("a graphics card smooths all")
    stand(stuck, scene, None)
    stand(brush, scene, 0.5)
    scene.draw_object()
    plain = scene.show().copy()
    assert smoothed(plain, scene.show().copy()) == 0
    fine = scene.show(fine=True).copy()
    assert 5 < smoothed(plain, fine) < 400  # the object's edges stay as they were drawn


STEPS = st.tuples(PLACES, st.lists(BOXES, max_size=2), PLACES, BOXES, st.booleans(), st.booleans())


def test_what_vtk_holds_stays_alive_without_us() -> None:
    """Memory that is let go of is given to the next one that asks for as much."""
    mesh, size = DrawnMesh(), 24
    points = np.arange(3.0 * size).reshape(size, 3)
    mesh.set_shape(points, np.arange(size, dtype=np.int64).reshape(-1, 3), points)
    shown = mesh.actor.GetMapper().GetInput()
    place, cells, normals = shown.GetPoints(), shown.GetPolys(), shown.GetPointData().GetNormals()
    mesh.set_shape(points[:3], np.array([[0, 1, 2]], np.int32), points[:3])
    del mesh, shown
    others = [np.full((size, 3), -7.0, kind) for kind in (np.float32, np.int32) for _ in range(50)]
    assert place.GetPoint(size - 1) == normals.GetTuple3(size - 1) == tuple(points[-1])
    assert cells.GetConnectivityArray().GetValue(size - 1) == size - 1
    assert len(others) == 100


@given(steps=st.lists(STEPS, min_size=3))
@settings(max_examples=examples(25), deadline=None)
def test_what_is_copied_late_is_the_same_picture(two_scenes: list[Drawn], steps: list) -> None:
    """Drawn anew where it is asked for only, with the brush in front of it."""
    for scene, stuck, brush in two_scenes:
        for one in (stuck, brush):
            stand(one, scene, None)
        scene.draw()
    for stuck_at, boxes, brush_at, seen, fine, keep in steps:
        is_lost = any(scene.is_lost for scene, _, _ in two_scenes)
        pictures = []
        for scene, stuck, brush in two_scenes:
            stand(stuck, scene, stuck_at)
            for box in [WHOLE, *boxes] if is_lost else boxes:
                scene.draw_object(box)
            stand(brush, scene, brush_at)
            pictures.append(scene.show(seen, fine=fine, keep=keep))
        assert np.array_equal(*pictures)


def painted(surface: PaintedSurface, ids: NDArray) -> NDArray:
    """Black paint on some vertices; which of them changed."""
    column = surface.column_of(paint3d.Painter(surface).ink)
    surface.ink.amounts[ids, column] = 1.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    return surface.refresh()


def test_where_refining_and_painting_shows_is_all_that_must_be_drawn() -> None:
    surface = PaintedSurface(paint3d.load_mesh("bowl"), 2.0)
    shown = LiveObject(surface)
    scene = LiveScene((400, 300))
    scene.clear(shown.centre, shown.radius, Gloss.of("porcelain"), solid=shown.is_solid)
    scene.apply(shown.uploads(NONE))
    scene.set_camera(fit_camera(surface.source.vertices, View((0.3, -1.0, 0.8)), 4 / 3))
    scene.draw()
    sizes = []
    for angle in np.linspace(-2.5, -0.6, 6):
        way = np.array([np.cos(angle), np.sin(angle)])
        places = surface.paint_mesh.vertices
        near = np.linalg.norm(places[:, :2] - 60.0 * way, axis=1) < 12.0
        field = surface.paint_mesh.arrays
        for cell in np.unique(field.sheet_cell[field.vertex_sheet[np.flatnonzero(near)]]):
            activate_cell(field, cell)
        places = surface.paint_mesh.vertices
        near = np.linalg.norm(places[:, :2] - 60.0 * way, axis=1) < 9.0
        changed = scene.apply(
            shown.uploads(painted(surface, np.flatnonzero(near).astype(np.int32)))
        )
        box = joined_box(scene.screen_box(points) for points in changed)
        part = scene.draw(only=box).copy()
        assert np.array_equal(part, scene.draw())
        sizes.append((box[2] - box[0]) * (box[3] - box[1]))
    assert max(sizes) < 0.15 * 400 * 300
    scene.close()


@pytest.mark.parametrize("view", [(0.3, -1.0, 0.8), (0.1, 0.0, -1.0), (1.0, 0.2, 0.0)])
@pytest.mark.parametrize("name", ["bowl", pytest.param("vase", marks=pytest.mark.long)])
def test_what_is_seen_from_behind_need_not_be_drawn(name: str, view: tuple) -> None:
    surface = PaintedSurface(paint3d.load_mesh(name), 4.0)
    shown = LiveObject(surface, faces=500)
    assert shown.is_solid
    pictures, drawn = [], []
    for solid in (False, True):
        scene = LiveScene((400, 300))
        scene.clear(shown.centre, shown.radius, Gloss.of("porcelain"), solid=solid)
        scene.apply(LiveObject(surface, faces=500).uploads(NONE))
        scene.set_camera(fit_camera(surface.source.vertices, View(view), 4 / 3))
        pictures.append(scene.draw().astype(int))
        drawn.append(scene.seen()[0])
        scene.close()
    differ = (np.abs(pictures[0] - pictures[1]) > 2).any(axis=2)
    assert differ.mean() < 2e-4  # where a rim's silhouette runs through a pixel's middle
    assert drawn[1] < 0.95 * drawn[0]


def test_a_cone_holds_every_normal_and_none_seen_is_called_turned_away() -> None:
    rng = np.random.default_rng(3)
    away = 0
    for _ in range(300):
        points = rng.normal(size=(12, 3)).astype(np.float32)
        points[:, 2] *= rng.choice([0.02, 0.3, 1.0])
        faces = rng.integers(0, 12, (6, 3)).astype(np.int32)
        a, b, c = (points[faces[:, k]].astype(np.float64) for k in range(3))
        normals = np.cross(b - a, c - a)
        faces = np.where((normals[:, 2] < 0.0)[:, None], faces[:, ::-1], faces)
        a, b, c = (points[faces[:, k]].astype(np.float64) for k in range(3))
        normals = np.cross(b - a, c - a)
        cone = np.empty(4)
        cone_of(points, faces, cone)
        length = np.linalg.norm(normals, axis=1)
        real = length > 0.0
        if real.any():
            assert (normals[real] @ cone[:3] / length[real] >= cone[3] - 1e-6).all()
        eye = rng.normal(size=3) * rng.choice([0.3, 3.0, 30.0])
        bounds = np.concatenate([points.min(axis=0), points.max(axis=0)])[None]
        if turned_away(bounds, cone[None], eye)[0]:
            away += 1
            assert (np.einsum("ij,ij->i", normals, eye - a) <= 1e-6).all()
    assert away > 20


def test_grain_is_seen_from_near_and_makes_nothing_darker_on_the_whole(
    surface: PaintedSurface,
) -> None:
    shown = LiveObject(surface)
    scene = LiveScene((240, 180), DARK)
    pictures = {}
    for grain in (0.0, 0.3, 0.6):
        scene.clear(shown.centre, shown.radius, Gloss(0.9, 0.0, grain, 1.2))
        scene.apply(LiveObject(surface).uploads(NONE))
        for distance in (30.0, 4000.0):
            camera = fit_camera(surface.source.vertices, View((0, 0, 1), (0, 1, 0)), 4 / 3)
            place = camera.focus + np.array([0.0, 0.0, distance])
            scene.set_camera(dataclasses.replace(camera, position=place))
            pictures[grain, distance] = scene.draw()[60:120, 80:160, 1].astype(float)
    scene.close()
    near = {grain: pictures[grain, 30.0] for grain in (0.0, 0.3, 0.6)}
    assert near[0.0].std() < 1.0
    assert near[0.6].std() > 1.7 * near[0.3].std() > 3.0
    assert near[0.6].mean() == pytest.approx(near[0.0].mean(), rel=0.01)
    assert np.abs(pictures[0.6, 4000.0] - pictures[0.0, 4000.0]).max() <= 1.0


@pytest.mark.parametrize("share", [2 / 3, 0.5])
def test_fewer_pixels_show_the_same_in_the_same_place(
    surface: PaintedSurface, share: float
) -> None:
    scene = painted_scene(surface, (241, 161))
    whole = scene.draw().copy()
    scene.draw_object(share=share)
    assert scene.is_lost
    fewer = scene.show().copy()
    assert fewer.shape == whole.shape
    apart = np.abs(fewer.astype(int) - whole)
    assert 0.0 < apart.mean() < 2.0
    for aside, along in ((0, 1), (0, -1), (1, 1), (-1, 1)):
        shifted = np.abs(np.roll(fewer.astype(int), along, axis=aside) - whole)
        assert shifted.mean() > apart.mean()
    scene.draw_object()
    assert not scene.is_lost
    assert np.array_equal(scene.show(), whole)  # at rest it is what it was, to the bit


def test_fewer_pixels_lie_on_the_colours_around_that_there_are_now(surface: PaintedSurface) -> None:
    scene = painted_scene(surface, (120, 80))
    colours = []
    for mood in (DARK, live_scene.LIGHT):
        scene.set_mood(mood)
        whole = scene.draw()[-3, 3].astype(int)
        colours.append(whole)
        scene.draw_object(share=0.5)
        assert np.abs(scene.show()[-3, 3] - whole).max() <= 3
    assert np.abs(colours[1] - colours[0]).max() > 30


def test_what_is_in_front_has_all_its_pixels_over_an_object_that_has_fewer(
    surface: PaintedSurface,
) -> None:
    scene = painted_scene(surface, (240, 160))
    tip = DrawnMesh()
    corners = np.array([[-20.0, -10, 5], [20, -10, 5], [0, 22, 5], [0, 0, -30], [9, 0, -30]])
    tip.set_shape(corners.astype(np.float32), np.array([[0, 1, 2], [2, 3, 4]], np.int32))
    tip.set_colours(np.tile(np.array([200, 20, 20], np.uint8), (5, 1)))
    tip.actor.GetProperty().LightingOff()
    scene.add(tip, front=True)
    camera = scene.camera
    below = View((0.1, 0.4, -1.0), (0.0, 1.0, 0.0))
    scene.set_camera(fit_camera(surface.source.vertices, below, 240 / 160))
    scene.draw()  # of what is seen from there nothing is left
    scene.set_camera(camera)
    scene.draw_object(share=0.5)
    fewer = scene.show().copy()
    whole = scene.draw().copy()
    red = (whole[..., 0] > 150) & (whole[..., 1] < 60)
    assert 200 < red.sum() < 0.2 * red.size
    assert np.array_equal((fewer[..., 0] > 150) & (fewer[..., 1] < 60), red)
    assert np.array_equal(fewer[red], whole[red])


def test_lines_are_as_wide_where_fewer_pixels_are_drawn(surface: PaintedSurface) -> None:
    scene = painted_scene(surface, (240, 160))
    line = DrawnMesh()
    line.set_lines([np.array([[-30.0, -20, 0.5], [30, 20, 0.5]])])
    line.set_colours(np.tile(np.array([20, 20, 220], np.uint8), (2, 1)))
    line.actor.GetProperty().LightingOff()
    line.actor.GetProperty().SetLineWidth(4.0)
    scene.add(line)

    def blue(share: float) -> float:
        scene.draw_object(share=share)
        seen = scene.show().astype(int)
        return float((seen[..., 2] - seen[..., 0]).clip(6, 240).sum() - 6 * seen[..., 0].size)

    assert blue(0.5) == pytest.approx(blue(1.0), rel=0.2)


@given(
    st.tuples(st.integers(1, 24), st.integers(1, 24)),
    st.tuples(st.integers(0, 24), st.integers(0, 24)),
    st.integers(0, 2**32 - 1),
)
def test_a_picture_is_spread_as_its_neighbours_say(
    small: tuple[int, int], more: tuple[int, int], seed: int
) -> None:
    large = small[0] + more[0], small[1] + more[1]
    pixels = np.random.default_rng(seed).integers(0, 256, (*small[::-1], 4)).astype(np.uint8)
    out = np.empty((*large[::-1], 4), np.uint8)
    Enlarger(small, large).enlarge(pixels, out)
    wanted = pixels.astype(np.float64)
    for axis in (0, 1):
        n, many = wanted.shape[axis], large[1 - axis]
        place = np.clip((np.arange(many) + 0.5) * n / many - 0.5, 0, n - 1)
        low = np.floor(place).astype(int)
        share = (place - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        ahead = np.take(wanted, np.minimum(low + 1, n - 1), axis=axis)
        wanted = (1 - share) * np.take(wanted, low, axis=axis) + share * ahead
    assert np.abs(out[::-1] - wanted).max() <= 2.0


# -- objects drawn coarsely --------------------------------------------------------------------


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


def test_silk_and_paper_stay_apart_in_it() -> None:
    """Where a mount's silk touches the paper, vertices of both stand in one place."""
    surface = PaintedSurface(paint3d.load_mesh("scroll:100x200:mounted"), 2.0, "xuan")
    shown = LiveObject(surface)
    shown.uploads(NONE)
    found = shown.coarse_for(1.0, 100_000)
    assert found is not None
    ids = np.flatnonzero(surface.paint_mesh.normals[:, 2] > 0.999).astype(np.int32)
    fine = {tuple(row) for row in shown.light.colours(ids, surface.codes).tolist()}
    flat = found.colours[found.normals[:, 2] > 0.999, :3]
    assert len(flat) > 50
    assert {tuple(row) for row in flat.tolist()} <= fine


def test_it_waits_until_what_was_added_is_followed() -> None:
    """Painting goes on between two looks; the sheen of new vertices is not known before."""
    shown = LiveObject(PaintedSurface(paint3d.load_mesh("bowl"), 2.0))
    shown.uploads(NONE)
    shown.surface.refine_all()
    assert shown.coarse_for(0.5, 4000) is None
    shown.uploads(shown.surface.refresh())
    assert shown.coarse_for(0.5, 4000) is not None


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
