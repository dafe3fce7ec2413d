"""Wet paint in the live view: it shines and is darker, until it dries."""

import math

import numpy as np
import pytest
import trimesh
from scipy.ndimage import binary_erosion

from paint3d.app.model.brush_in_hand import resized
from paint3d.brush.presets import load_brush
from paint3d.colour.pigments import load_pigment
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.sheen import PLAIN_SHINE, WetWatch
from paint3d.view import live_picture, live_scene
from paint3d.view.camera import View, fit_camera
from paint3d.view.live_object import LiveObject
from paint3d.view.live_picture import LivePicture
from paint3d.view.live_scene import LiveScene
from paint3d.view.studio import Gloss
from tests.support.app.hands import line

TOWARD = np.array([-0.4, -0.8, 0.45]) / np.linalg.norm([-0.4, -0.8, 0.45])


def ball(ink, material):
    solid = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    mesh = TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces))
    surface = PaintedSurface(mesh, None, material=material)
    column = surface.column_of(load_pigment(ink))
    ids = np.flatnonzero(surface.paint_mesh.vertices @ TOWARD > 6.0).astype(np.int32)
    surface.ink.amounts[ids, column] = 2.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    return surface


@pytest.fixture
def scene():
    made = LiveScene((160, 160))
    yield made
    made.close()


def show(scene, surface):
    """The object on the scene, and a function that takes what is new and returns the picture."""
    shown = LiveObject(surface)
    gloss = Gloss(surface.material.roughness, surface.material.coat)
    scene.clear(shown.centre, shown.radius, gloss, solid=shown.is_solid)
    view = View(TOWARD, np.array([0.0, 0.0, 1.0]))

    def picture():
        scene.apply(shown.uploads(surface.refresh()))
        scene.set_camera(fit_camera(surface.paint_mesh.vertices, view, 1.0))
        scene.draw_object()
        return scene.show()[..., :3].astype(int)

    return picture


def test_wet_paint_shines_and_is_darker_until_it_dries(scene):
    surface = ball("cinnabar", "sized xuan")
    picture = show(scene, surface)
    fresh = picture()
    surface.diffuse(0.1)
    wet = picture()
    surface.dry()
    dry = picture()
    spot = (fresh[..., 0] - fresh[..., 2] > 60) & (fresh[..., 1] < 75)  # without its border
    assert spot.sum() > 3000
    assert np.median(wet[spot, 0]) < np.median(fresh[spot, 0]) - 15
    brightest, most = (np.ptp([np.median(a[spot, 2]), a[spot, 2].max()]) for a in (wet, fresh))
    assert brightest > most + 10  # a lamp in it
    assert np.abs(dry - fresh)[spot].max() <= 2


def test_what_is_wet_when_it_is_first_shown_looks_as_what_is_wetted_later(scene):
    surface = ball("cinnabar", "sized xuan")
    picture = show(scene, surface)
    picture()
    surface.diffuse(0.1)
    dampened = picture()
    np.testing.assert_array_equal(show(scene, surface)(), dampened)


def test_only_wet_patches_send_how_smooth_they_are():
    surface = ball("pine soot", "sized xuan")
    shown = LiveObject(surface, faces=200)
    assert {up.colours.shape[1] for up in shown.uploads(surface.refresh())} == {3}
    surface.diffuse(0.1)
    sent = shown.uploads(surface.refresh())
    assert {up.colours.shape[1] for up in sent} == {4}
    assert len(sent) < shown.patches.n_patches
    assert shown.uploads(surface.refresh()) == []


def test_what_dries_beside_what_is_wet_is_matt_again(monkeypatch):
    now = [(np.array([1, 2], np.int32), np.array([0.06, 0.06]))]
    monkeypatch.setattr(PaintedSurface, "seen_water", property(lambda self: now[0]))
    watch = WetWatch(ball("pine soot", "sized xuan"))
    nothing = np.zeros(0, np.int32)
    assert sorted(watch.follow(nothing)) == [1, 2]
    assert watch.shine(now[0][0]).min() > 230
    assert len(watch.follow(nothing)) == 0
    now[0] = (np.array([2], np.int32), np.array([0.06]))
    assert watch.follow(nothing).tolist() == [1]
    assert watch.shine(np.array([1, 2])).tolist() == [PLAIN_SHINE, 255]
    assert watch.damp(np.array([1, 2])).tolist() == [0.0, 1.0]
    now[0] = None
    assert watch.follow(nothing).tolist() == [2]
    assert watch.is_plain


def test_oil_soot_shines_dry_and_pine_soot_does_not():
    for ink, columns in (("pine soot", 3), ("oil soot", 4)):
        surface = ball(ink, "xuan")
        surface.dry()
        sent = LiveObject(surface).uploads(surface.refresh())
        assert {up.colours.shape[1] for up in sent} == {columns}


def test_ink_shines_on_every_visible_layer_and_water_on_the_one_painted_on():
    surface = ball("oil soot", "sized xuan")
    surface.diffuse(0.1)
    stack = surface.use_layers()
    shown, watch = LiveObject(surface), surface.watch_wet()
    everything = np.arange(surface.n_vertices)

    def shine():
        inked = surface.refresh()
        sent = shown.uploads(inked)
        watch.follow(inked)
        smooth = (watch.shine(everything).max() - PLAIN_SHINE) / 127.0
        look = surface.wet_look
        wanted = 0.0 if look is None else np.maximum(look.film, look.gloss).max()
        assert smooth == pytest.approx(wanted, abs=0.05)
        damp = watch.damp(everything)
        deepest = 0.0 if damp is None else damp.max()
        assert deepest == (0.0 if look is None else look.damp.max())
        return sent, smooth

    assert shine()[1] > 0.9
    for visible in (False, True):
        stack.set_properties(0, visible=visible)
        surface.touch(stack.painted_ids())
        assert (shine()[1] > 0.9) == visible
    surface.dry()
    assert 0.3 < shine()[1] < 0.45
    stack.add("2", 1)
    assert 0.3 < shine()[1] < 0.45
    stack.set_properties(0, visible=False)  # nothing is touched: what is seen is followed
    sent, smooth = shine()
    assert smooth == 0.0
    assert sent
    stack.set_properties(0, visible=True)
    assert 0.3 < shine()[1] < 0.45


def test_dry_ink_on_glaze_is_matt_and_wet_ink_shines(scene):
    surface = ball("pine soot", "porcelain")
    picture, watch = show(scene, surface), surface.watch_wet()
    inked = np.flatnonzero(surface.coverage).astype(np.int32)
    looks = {}
    for state in ("fresh", "wet", "dry"):
        if state != "fresh":
            surface.diffuse(0.1) if state == "wet" else surface.dry()
        looks[state] = picture()[..., 1]
        watch.follow(inked)
        found = watch.shine(inked)
        assert (found.min() > 250) if state == "wet" else (found.max() <= 2)
    spot = looks["dry"] < 60
    assert spot.sum() > 3000
    spot = binary_erosion(spot, iterations=2)
    wet, dry = (np.ptp(looks[state][spot]) for state in ("wet", "dry"))
    assert wet > 40  # a lamp in it
    assert dry < 0.5 * wet
    assert np.abs(looks["dry"] - looks["fresh"]).max() <= 2


def test_dry_ink_on_glaze_is_matt_while_the_view_moves(scene):
    surface = ball("pine soot", "porcelain")
    shown, found = LiveObject(surface), []
    gloss = Gloss(surface.material.roughness, surface.material.coat)
    scene.clear(shown.centre, shown.radius, gloss, solid=shown.is_solid)
    view = View(TOWARD, np.array([0.0, 0.0, 1.0]))
    scene.set_camera(fit_camera(surface.paint_mesh.vertices, view, 1.0))
    for change in (lambda: surface.diffuse(0.1), surface.dry):
        change()
        scene.apply(shown.uploads(surface.refresh()))
        if not scene.has_coarse:
            scene.set_coarse(shown.coarse_for(0.05, 100_000))
        shown.repaint_coarse()
        scene.recolour_coarse()
        for coarse in (False, True):
            scene.draw_object(coarse=coarse)
            found.append(scene.show()[..., 1].astype(int))
    spot = binary_erosion(found[2] < 60, iterations=4)
    assert spot.sum() > 3000
    wet, coarsely_wet, dry, coarsely_dry = (np.ptp(one[spot]) for one in found)
    assert coarsely_wet > 0.5 * wet > dry
    assert coarsely_dry < 1.5 * dry


def test_a_watch_knows_what_had_dried_before_it_looked():
    surface = ball("pine soot", "porcelain")
    watch = surface.watch_wet()
    inked = np.flatnonzero(surface.coverage).astype(np.int32)
    assert sorted(watch.follow(inked[:0])) == inked.tolist()
    assert watch.shine(inked).max() <= 2


def test_what_little_matt_ink_mirrors_is_spread_widely(scene, monkeypatch):
    monkeypatch.setitem(vars(live_scene)["_LOBES"], "MATT_SHARE", 0.24)  # so that it can be seen
    seen = show(scene, ball("pine soot", "porcelain"))()[..., 1]
    lit = binary_erosion(seen < 110, iterations=2)
    assert lit.sum() > 3000

    assert np.percentile(seen[lit], 90) > seen[lit].min() + 15


def test_what_is_drawn_coarsely_shines_as_what_is_drawn_finely():
    surface = ball("pine soot", "porcelain")
    shown = LiveObject(surface)
    shown.uploads(surface.refresh())
    coarse = shown.coarse_for(0.2, 100_000)
    front = coarse.points @ TOWARD > 7.0
    assert coarse.colours[front, 3].max() <= 2
    assert (coarse.colours[coarse.points @ TOWARD < 5.0, 3] == PLAIN_SHINE).all()
    surface.diffuse(0.1)
    shown.uploads(surface.refresh())
    shown.repaint_coarse()
    assert coarse.colours[front, 3].min() > 250


BIG_MM = 200.0  # the longest tuft there is


def drawn_anew(surface, scene):
    """The picture of a scene that has seen nothing before."""
    shown, other = LiveObject(surface, faces=500), LiveScene(scene.size)
    other.clear(shown.centre, shown.radius, Gloss.of(surface.material))
    other.apply(shown.uploads(np.arange(surface.n_vertices, dtype=np.int32)))
    other.set_camera(scene.camera)
    picture = other.draw()[..., :3].astype(int)
    other.close()
    return picture


@pytest.mark.parametrize(("material", "most"), [("sized xuan", math.inf), ("porcelain", 1_000.0)])
def test_a_broad_wet_stroke_refreshed_in_parts_is_the_picture_drawn_anew(
    scene, monkeypatch, material, most
):
    """Of one black wherever it was drawn last, also after what was drawn coarsely meanwhile."""
    monkeypatch.setattr(live_picture, "_LEVELS", ((most, 1.0),))
    monkeypatch.setattr(live_picture, "_MANY", most)
    monkeypatch.setattr(live_picture, "_BEST", live_picture._PLAIN)
    monkeypatch.setattr(live_picture, "_CELL", 40)
    monkeypatch.setattr(live_picture, "_SETTLED_S", 0.0)
    surface = PaintedSurface(load_mesh("plane"), 2.0, material)
    shown, coarse = LiveObject(surface, faces=500), []
    painter = Painter(surface, resized(load_brush("full"), BIG_MM))

    def prepare(n_triangles):
        coarse.append(shown.coarse_for(scene.nearest_mm(), n_triangles))
        if coarse[-1] is not None:
            scene.set_coarse(coarse[-1])
        return scene.has_coarse

    def refresh():
        boxes = [scene.screen_box(one) for one in scene.apply(shown.uploads(surface.refresh()))]
        for box in boxes:
            picture.touch_object(box)
        if shown.repaint_coarse() is not None:
            scene.recolour_coarse()
        pixels = picture.draw()
        while not picture.is_done():
            pixels = picture.draw()
        return boxes, pixels

    scene.clear(shown.centre, shown.radius, Gloss.of(surface.material))
    scene.apply(shown.uploads(np.arange(surface.n_vertices, dtype=np.int32)))
    scene.set_camera(fit_camera(surface.source.vertices, View((0.1, -0.4, 1.0)), 1.0))
    picture = LivePicture(scene, prepare)
    parts, way = 0, line((-60.0, -10.0), (60.0, 15.0), n=60, pressure=0.9, height=BIG_MM)
    for k in range(0, 60, 10):
        painter.advance(way[k : k + 10])
        surface.diffuse(0.05)
        if k == 20:
            picture.touch()  # the view has moved
        boxes, pixels = refresh()
        parts += any(box is not None and box != scene.whole for box in boxes)
        assert np.abs(pixels[..., :3] - drawn_anew(surface, scene)).max() <= 1
    assert (surface.srgb.max(axis=1) < 60).sum() > 1000
    assert parts == 6
    assert bool(coarse) == (most == 1_000.0)
    for pause_s in (5.0, 500.0):  # it runs, and dries
        surface.diffuse(pause_s)
        assert np.abs(refresh()[1][..., :3] - drawn_anew(surface, scene)).max() <= 1
