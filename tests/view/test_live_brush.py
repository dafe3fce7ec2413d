"""The figure of the brush: as the model bends it, on the surface, with its ink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import paint3d
from paint3d.brush.bending import build_tuft
from paint3d.brush.bristles import build_bristles
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.device.sample import DeviceSample
from paint3d.painter.painter import Painter
from paint3d.pose.brush_pose import object_poses
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view import live_brush
from paint3d.view.brush_shape import (
    MOST_LINES,
    BrushStand,
    SingleHairs,
    grid_faces,
    handle_rings,
    tuft_rings,
)
from paint3d.view.camera import View, fit_camera
from paint3d.view.kernels.drape import drape_points
from paint3d.view.live_brush import LiveBrush, fade_along
from paint3d.view.live_scene import LiveScene
from paint3d.view.pressed_tuft import TuftFollower
from paint3d.view.studio import Gloss
from paint3d.view.vtk_parts import DrawnMesh

UPRIGHT = np.eye(3)
TUFT = build_tuft(load_brush("full"))


@pytest.fixture(scope="module")
def painter() -> Painter:
    return Painter(PaintedSurface(paint3d.load_mesh("plane"), None), "full")


def stand_at(painter: Painter, height: float, pressure: float | None) -> BrushStand:
    root = np.array([0.0, 0.0, height])
    sample = DeviceSample(
        0, root, np.eye(4)[0], pressure, 0, np.zeros(3), np.eye(4)[0], None
    )  # fmt: skip
    pressed = TuftFollower().follow(painter, object_poses([sample]))
    return BrushStand.of(painter.tuft, root, UPRIGHT, pressed)


@given(pressure=st.floats(0.05, 1.0))
@settings(max_examples=25, deadline=None)
def test_a_pressed_tuft_lies_on_the_plane_as_long_as_it_is(
    painter: Painter, pressure: float
) -> None:
    rings, arc = tuft_rings(TUFT, stand_at(painter, 20.0, pressure))
    assert rings[..., 2].min() >= 0.0
    spine = rings.mean(axis=1)
    length = np.linalg.norm(np.diff(spine, axis=0), axis=1).sum()
    assert 0.75 * TUFT.length < length < 1.1 * TUFT.length
    assert np.all(np.diff(arc) > 0.0)
    spread = np.ptp(rings[len(rings) // 2, :, 1])
    free = np.interp(arc[len(rings) // 2] * TUFT.length, [0, TUFT.length], [0, 1]) ** TUFT.taper
    assert spread > 1.02 * free * TUFT.diameters[-1]  # pressing spreads the hairs


def test_above_the_surface_the_tuft_is_straight_and_below_the_root(painter: Painter) -> None:
    stand = stand_at(painter, 50.0, None)
    assert not stand.touches
    rings, _ = tuft_rings(painter.tuft, stand)
    np.testing.assert_allclose(rings[0].mean(axis=0), [0, 0, 50.0 - painter.tuft.length], atol=1e-9)
    assert np.abs(rings.mean(axis=1)[:, :2]).max() < 0.1
    handle, colours = handle_rings(painter.tuft, stand)
    assert handle[-1, 0, 2] > handle[0, 0, 2] + 80.0
    assert 0.0 <= colours.min() <= colours.max() <= 255.0


def test_the_outline_is_the_footprint(painter: Painter) -> None:
    contact = painter.contact((0, 0, 20.0), (1, 0, 0, 0), 0.5)
    outline = stand_at(painter, 20.0, 0.5).outline()
    assert np.ptp(outline @ contact.bend) == pytest.approx(contact.length, rel=1e-6)
    across = np.cross(contact.normal, contact.bend)
    assert np.ptp(outline @ across) == pytest.approx(contact.width, rel=0.03)


def test_points_fall_onto_the_surface_or_past_it(painter: Painter) -> None:
    tree = painter.surface.contact_tree
    points = np.array([[10.0, 5.0, 40.0], [500.0, 0.0, 40.0], [0.0, 0.0, 400.0]])
    out, landed = np.zeros((3, 6)), np.zeros(3, np.uint8)
    slant = np.array([0.6, 0.0, -0.8])
    drape_points(tree, points, slant, 200.0, out, landed)
    assert landed.tolist() == [1, 0, 0]
    np.testing.assert_allclose(out[0, :3], [40.0, 5.0, 0.0], atol=0.05)
    np.testing.assert_allclose(out[0, 3:], [0, 0, 1], atol=1e-6)


def test_rings_are_joined_all_around() -> None:
    faces = grid_faces(3, 4)
    assert len(faces) == 16
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    assert sorted(set(counts)) == [1, 2]
    assert (counts == 1).sum() == 8  # open at the two ends only


def test_the_brush_is_seen_with_its_ink_and_hides(painter: Painter) -> None:
    scene = LiveScene((200, 160))
    surface = painter.surface
    scene.clear(np.zeros(3), 140.0, Gloss.of("xuan"))
    scene.set_camera(fit_camera(surface.source.vertices, View((0, -1, 0.4)), 1.25))
    empty = scene.draw().copy()
    brush = LiveBrush(scene, painter.tuft, "goat")
    assert np.array_equal(scene.draw(), empty)
    stand = stand_at(painter, 20.0, 0.6)
    brush.show(stand, surface.contact_tree, np.eye(3), (200, 20, 20), 1.0)
    seen = scene.draw()[..., :3].astype(int)
    changed = np.abs(seen - empty[..., :3]).sum(axis=2) > 20
    assert 200 < changed.sum() < 0.5 * changed.size
    assert (changed & (seen[..., 0] > seen[..., 2] + 60)).sum() > 20  # the red ink
    brush.hide()
    assert np.array_equal(scene.draw(), empty)
    brush.remove()
    scene.close()


def test_a_brush_that_is_filmed_hides_what_it_paints_and_has_no_outline(painter: Painter) -> None:
    scene = LiveScene((200, 160))
    surface = painter.surface
    scene.clear(np.zeros(3), 140.0, Gloss.of("xuan"))
    scene.set_camera(fit_camera(surface.source.vertices, View((0, -1, 0.4)), 1.25))
    stand, seen = stand_at(painter, 20.0, 0.6), {}
    empty = scene.draw()[..., :3].astype(int)
    for as_filmed in (False, True):
        brush = LiveBrush(scene, painter.tuft, "goat", as_filmed=as_filmed)
        just_painted = stand.root[None] - [0.0, 0.0, 20.0]
        brush.show(stand, surface.contact_tree, np.eye(3), (0, 0, 0), 1.0, just_painted)
        seen[as_filmed] = scene.draw()[..., :3].astype(int)
        brush.remove()
    scene.close()
    dark = {kind: (empty - pixels).sum(axis=2) for kind, pixels in seen.items()}
    assert (dark[True] > 300).sum() > 3 * (dark[False] > 300).sum()
    red = {kind: (p[..., 0] > p[..., 1] + 60).sum() for kind, p in seen.items()}
    assert red[True] == 0 < red[False]


def test_the_box_of_the_brush_follows_the_view(painter: Painter) -> None:
    scene = LiveScene((200, 150))
    brush = LiveBrush(scene, painter.tuft)
    boxes = []
    points = painter.surface.source.vertices
    for towards in ((0.0, -0.4, 1.0), (0.3, -1.0, 0.8)):
        scene.set_camera(fit_camera(points, View(towards), 4 / 3))
        if not boxes:
            assert brush.screen_box() is None
            stand = stand_at(painter, 20.0, 0.5)
            brush.show(stand, painter.surface.contact_tree, np.eye(3), None, 0.0)
        boxes.append(brush.screen_box())
        assert brush.screen_box() == boxes[-1]
    scene.set_size((400, 300))
    boxes.append(brush.screen_box())
    assert len(set(boxes)) == 3
    assert boxes[2][2] - boxes[2][0] > 1.5 * (boxes[1][2] - boxes[1][0])
    brush.hide()
    assert brush.screen_box() is None
    scene.close()


def bristles_of(n: int, **options):
    return build_bristles(load_brush("full"), BristleSpec(n, **options))


@pytest.mark.parametrize("pressure", [None, 0.3, 0.8])
def test_single_hairs_lie_within_the_tuft_from_ferrule_to_tip(painter, pressure) -> None:
    rings, _ = tuft_rings(TUFT, stand_at(painter, 50.0 if pressure is None else 20.0, pressure))
    hairs = SingleHairs(TUFT, bristles_of(300), rings.shape[1])
    lines, outward = hairs.points(rings)
    assert lines.shape == (300, 11, 3)
    assert np.linalg.norm(outward, axis=-1).max() < 1.0 + 1e-5
    low, high = rings.reshape(-1, 3).min(axis=0), rings.reshape(-1, 3).max(axis=0)
    assert (lines >= low - 1e-3).all()
    assert (lines <= high + 1e-3).all()
    root = rings[-1]
    radius = np.linalg.norm(root - root.mean(axis=0), axis=1).max()
    away = np.linalg.norm(lines[:, -1] - root.mean(axis=0), axis=1)
    assert away.max() < radius + 1e-3
    assert (away < 0.5 * radius).mean() == pytest.approx(0.25, abs=0.03)  # evenly over the section
    way = np.linalg.norm(np.diff(lines, axis=1), axis=-1).sum(axis=1)
    assert np.all(way < 1.3 * TUFT.length)
    assert way.min() > 0.7 * TUFT.length


def test_as_many_lines_are_drawn_as_there_are_hairs_up_to_a_limit() -> None:
    assert [SingleHairs(TUFT, bristles_of(n), 44).count for n in (1, 7, 400, 5000)] == [
        1, 7, MOST_LINES, MOST_LINES,
    ]  # fmt: skip
    short = SingleHairs(TUFT, bristles_of(50, unevenness=0.2), 44).arc[:, 0]
    assert short.min() < 0.01
    assert 0.15 < short.max() <= 0.2


def test_a_tuft_of_hairs_is_drawn_as_hairs(painter: Painter) -> None:
    """A few leave the sheet to be seen between them; thicker ones hide more of it."""
    scene = LiveScene((300, 240))
    surface = painter.surface
    scene.clear(np.zeros(3), 140.0, Gloss.of("xuan"))
    scene.set_camera(fit_camera(surface.source.vertices, View((0, -1, 0.4), zoom=3.0), 1.25))
    scene.draw()
    stand = stand_at(painter, 20.0, 0.6)
    seen = {}
    for name, bristles in (
        ("solid", None), ("thin", bristles_of(4, hair_mm=0.2)),
        ("thick", bristles_of(4, hair_mm=1.2)), ("many", bristles_of(3000)),
    ):  # fmt: skip
        brush = LiveBrush(scene, painter.tuft, "goat", bristles)
        brush.show(stand, surface.contact_tree, np.eye(3), (200, 20, 20), 1.0)
        pixels = scene.draw()[..., :3].astype(int)
        seen[name] = int((pixels[..., 0] > pixels[..., 2] + 60).sum())  # the red ink
        brush.remove()
    assert 0 < seen["thin"] < 0.6 * seen["thick"]
    assert seen["thick"] < 0.9 * seen["solid"]
    assert seen["many"] > 0.8 * seen["solid"]
    scene.close()


def test_a_shadow_fades_by_how_far_it_falls_also_at_the_joints_of_the_handle(
    painter: Painter,
) -> None:
    stand = stand_at(painter, 40.0, None)
    handle = handle_rings(painter.tuft, stand)[0].mean(axis=1)
    fade = fade_along(handle)
    apart = np.linalg.norm(np.diff(handle, axis=0), axis=1)
    assert apart.min() < 0.1 * apart.max()  # rings lie together at a joint
    assert fade[0] == pytest.approx(1.0)
    assert fade[-1] == pytest.approx(0.0)
    drop = -np.diff(fade)
    assert (drop >= 0.0).all()
    assert (drop <= 2.0 * apart / apart.sum() + 1e-9).all()  # nowhere steeper than at its end


def leaning_stand(painter: Painter, lean: Rotation) -> BrushStand:
    root, orientation = np.array([0.0, 0.0, 24.0]), np.roll(lean.as_quat(), 1)
    sample = DeviceSample(0, root, orientation, 0.4, 0, np.zeros(3), np.eye(4)[0], None)
    pressed = TuftFollower().follow(painter, object_poses([sample]))
    return BrushStand.of(painter.tuft, root, lean.as_matrix(), pressed)


def test_the_root_of_a_pressed_tuft_fits_a_handle_that_leans_aside(painter: Painter) -> None:
    lean = Rotation.from_euler("xy", [25.0, 35.0], degrees=True)
    stand = leaning_stand(painter, lean)
    assert stand.touches
    ring = tuft_rings(painter.tuft, stand)[0][-1]
    across = np.linalg.svd(ring - ring.mean(axis=0))[2][2]
    assert abs(across @ lean.as_matrix()[:, 2]) == pytest.approx(1.0, abs=1e-9)


def test_sections_turn_as_the_handle_does_each_by_its_share(painter: Painter) -> None:
    """The straight way from the plane of the bend to the handle, about their middles."""
    stand = leaning_stand(painter, Rotation.from_euler("xy", [15.0, -35.0], degrees=True))
    root = stand.axes.T @ [-np.cos(stand.tilt), 0.0, np.sin(stand.tilt)]
    turn = Rotation.from_euler("xyz", [25.0, -35.0, 0.0], degrees=True)
    leaning = turn.apply(root)
    way = np.cross(root, leaning)
    way *= np.arccos(root @ leaning) / np.linalg.norm(way)
    straight, turned = (
        tuft_rings(painter.tuft, replace(stand, handle=handle))[0] for handle in (root, leaning)
    )
    np.testing.assert_allclose(straight.mean(axis=1), turned.mean(axis=1), atol=0.05)
    arms, moved = (rings - rings.mean(axis=1, keepdims=True) for rings in (straight, turned))
    np.testing.assert_allclose(moved[-1], Rotation.from_rotvec(way).apply(arms[-1]), atol=1e-9)
    shares = []
    for before, after in zip(arms[-6:], moved[-6:], strict=True):
        off = [
            np.abs(Rotation.from_rotvec(share * way).apply(before) - after).max()
            for share in np.linspace(0.0, 1.0, 201)
        ]
        shares.append(np.argmin(off) / 200.0)
        assert min(off) < 0.01 * np.abs(before).max()
    assert (np.diff(shares) >= 0.0).all()
    assert shares[-1] == 1.0


def test_a_shadow_is_as_dense_as_it_fades(
    painter: Painter, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, given = LiveScene((160, 120)), list[np.ndarray]()
    brush, tree = LiveBrush(scene, painter.tuft), painter.surface.contact_tree
    stand, dense = stand_at(painter, 40.0, None), []
    monkeypatch.setattr(DrawnMesh, "set_colours", lambda mesh, colours: given.append(colours))
    for times in (1.0, 0.5, 0.0):
        monkeypatch.setattr(live_brush, "fade_along", lambda at, k=times: k * fade_along(at))
        given.clear()
        brush.show(stand, tree, np.eye(3), None, 0.0)
        black = (colours for colours in given if not colours[:, :3].any())
        shadow = max(black, key=len)
        dense.append(int(shadow[:, 3].max()))
    scene.close()
    assert dense[0] > dense[1] > dense[2] == 0


@pytest.mark.parametrize("n_hairs", [0, 300])
def test_the_brush_hides_nothing_that_was_painted_just_now(painter: Painter, n_hairs: int) -> None:
    scene, surface = LiveScene((240, 180)), painter.surface
    scene.clear(np.zeros(3), 140.0, Gloss.of("xuan"))
    scene.set_camera(fit_camera(surface.source.vertices, View((0, -1, 0.6)), 4 / 3))
    bare = scene.draw()[..., :3].astype(int)
    brush = LiveBrush(scene, painter.tuft, "goat", bristles_of(n_hairs) if n_hairs else None)
    hidden = {}
    for pressure in (None, 0.6):  # lifted just above, and pressed
        stand = stand_at(painter, 38.0 if pressure is None else 20.0, pressure)
        way = np.linspace(0.0, 1.0, 200)[:, None] * 4.5 * TUFT.length * stand.handle
        way = stand.root - TUFT.length * stand.handle + way  # seen all along the brush
        for name, painted in (("nothing", np.empty((0, 3))), ("way", way)):
            brush.show(stand, surface.contact_tree, np.eye(3), (10, 10, 10), 1.0, painted)
            seen = scene.draw()[..., :3].astype(int)
            hidden[name] = np.abs(seen - bare).sum()
        assert hidden["way"] < 0.65 * hidden["nothing"]
        far = way + 400.0 * np.array([1.0, 0.0, 0.0])
        brush.show(stand, surface.contact_tree, np.eye(3), (10, 10, 10), 1.0, far)
        assert np.abs(scene.draw()[..., :3].astype(int) - bare).sum() == hidden["nothing"]
    scene.close()
