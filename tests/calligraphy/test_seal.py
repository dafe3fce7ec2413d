"""Seals: what is cut into the stone, and what it leaves on a surface."""

import numpy as np
import pytest
from shapely import Polygon
from shapely.geometry import box

from paint3d.calligraphy.seal.impression import Pressing, find_impression
from paint3d.calligraphy.seal.stone import cut_drawing, cut_seal
from paint3d.errors import InputError, MeshError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import small_plane

UP = (0.0, 1.0, 0.0)
NEW = Pressing(wear=0.0)


def inked(seal):
    shape = Polygon()
    for ring in seal.rings:
        shape = shape.symmetric_difference(Polygon(ring))
    return shape


def pressed(surface, seal, pressing=NEW, at=(0.0, 0.0, 0.0), up=UP):
    closest = ClosestPoints(surface.source)
    frame = frame_at(closest, at, up)
    return find_impression(surface, closest, frame, seal.rings, pressing)


def cross():
    return cut_drawing("cross", box(-10, -1, 10, 1).union(box(-1, -10, 1, 10)), "zhuwen", 10.0)


def test_characters_stand_in_columns_from_the_right() -> None:
    seal = cut_seal("一川", style="zhuwen", size_mm=20.0)
    within = inked(seal).intersection(box(-8.5, -8.5, 8.5, 8.5))
    right, left = within.intersection(box(0, -9, 9, 9)), within.intersection(box(-9, -9, 0, 9))
    assert len(right.geoms if hasattr(right, "geoms") else [right]) == 1  # 一
    assert len(left.geoms) == 3  # 川


def test_white_lines_are_what_red_ones_would_be() -> None:
    shape = box(0, 0, 3, 1)
    red, white = (cut_drawing("bar", shape, style, 30.0) for style in ("zhuwen", "baiwen"))
    assert red.width_mm == pytest.approx(30.0)
    assert red.height_mm == pytest.approx(30.0 / (3 * 0.83 + 0.17), rel=1e-3)
    assert not inked(red).contains(box(-0.1, 4.85, 0.1, 5.1))
    assert inked(red).contains(box(-1, -1, 1, 1))
    assert not inked(white).intersects(box(-1, -1, 1, 1))
    rim = inked(white)
    assert rim.contains(box(-1, 0.47 * white.height_mm, 1, 0.48 * white.height_mm))


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"text": "永和九年春"}, "5 characters; expected 1 to 4"),
        ({"text": " "}, "0 characters"),
        ({}, "neither text nor drawing"),
        ({"text": "永", "drawing": "a.svg"}, "a text and a drawing"),
        ({"text": "永", "style": "round"}, "style is 'round'"),
        ({"text": "永", "size_mm": 1.0}, r"size \(mm\) is 1"),
        ({"drawing": "nowhere.svg"}, "nowhere.svg"),
    ],
)
def test_what_cannot_be_cut_is_said(asked, words: str) -> None:
    with pytest.raises(InputError, match=words):
        cut_seal(**asked)


def test_a_new_stone_prints_what_is_cut_into_it() -> None:
    surface = PaintedSurface(small_plane().surface.source, 0.1, "xuan")
    seal, shape = cross(), inked(cross())
    left = pressed(surface, seal)
    covered = surface.vertex_areas[left.vertex_ids] @ left.coverage
    # a twentieth is bare or at an edge
    assert covered == pytest.approx(shape.area, rel=0.05)
    places = surface.paint_mesh.vertices[left.vertex_ids, :2]
    import shapely

    inside = shapely.contains_xy(shape.buffer(0.1), places[:, 0], places[:, 1])
    assert inside.all()
    assert left.touched > 0.95


def test_the_same_press_is_the_same_and_another_seed_is_another() -> None:
    marks = []
    for seed in (1, 1, 2):
        surface = PaintedSurface(small_plane().surface.source, 0.2, "xuan")
        marks.append(pressed(surface, cross(), Pressing(seed=seed)))
    np.testing.assert_array_equal(marks[0].coats, marks[1].coats)
    np.testing.assert_array_equal(marks[0].vertex_ids, marks[1].vertex_ids)
    assert not np.array_equal(marks[0].vertex_ids, marks[2].vertex_ids)


def test_a_worn_stone_prints_less() -> None:
    areas = []
    for wear in (0.0, 1.0, 2.0):
        surface = PaintedSurface(small_plane().surface.source, 0.2, "xuan")
        left = pressed(surface, cross(), Pressing(wear=wear))
        areas.append(surface.vertex_areas[left.vertex_ids] @ left.coverage)
    assert areas[0] > areas[1] > areas[2] > 0.3 * areas[0]


def test_only_what_the_pad_reaches_is_printed() -> None:
    """From the top of a ball the stone's plane goes away until the pad gives way no more."""
    mesh = load_mesh("sphere")
    top = float(mesh.bounds[1][2])
    radius = 0.5 * (top - float(mesh.bounds[0][2]))
    seal = cut_drawing("disc", box(0, 0, 1, 1), "zhuwen", radius)
    surface = PaintedSurface(mesh, 0.6, "porcelain")
    left = pressed(surface, seal, Pressing(pad_mm=2.0, wear=0.0), at=(0.0, 0.0, top))
    depth = top - surface.paint_mesh.vertices[left.vertex_ids, 2]
    assert 1.5 < depth.max() < 2.01  # edges lie a little within the ball
    assert left.touched < 0.7


def test_the_far_side_of_a_thin_wall_stays_bare() -> None:
    top = [(x, y, 0.0) for x in (-20, 20) for y in (-20, 20)]
    low = [(x, y, -0.4) for x in (-20, 20) for y in (-20, 20)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6)]
    wall = TriangleMesh(np.array(top + low, np.float32), np.array(faces, np.int32), None, "wall")
    surface = PaintedSurface(wall, 0.3, "porcelain")
    left = pressed(surface, cross())
    assert (surface.paint_mesh.vertices[left.vertex_ids, 2] > -0.1).all()


def test_where_there_is_no_room_it_is_said() -> None:
    surface = PaintedSurface(small_plane().surface.source, 1.0, "xuan")
    _, high = surface.source.bounds
    with pytest.raises(MeshError, match="a seal of 11 x 11 mm has no room there"):
        pressed(surface, cross(), at=(high[0], 0, 0))


@pytest.mark.parametrize("style", ["zhuwen", "baiwen"])
def test_a_stone_of_two_characters_stands_upright_or_lies_level(style: str) -> None:
    square, upright, level = (
        cut_seal("太白", style=style, size_mm=20.0, shape=shape)
        for shape in ("square", "upright", "level")
    )
    assert (square.width_mm, square.height_mm) == pytest.approx((20.0, 20.0))
    assert upright.height_mm == pytest.approx(20.0)
    assert 0.45 < upright.width_mm / upright.height_mm < 0.6
    assert (level.width_mm, level.height_mm) == pytest.approx((upright.height_mm, upright.width_mm))
    points = np.concatenate(upright.rings)
    assert np.ptp(points[:, 1]) > 1.8 * np.ptp(points[:, 0])
    with pytest.raises(InputError, match="expected one of square, upright, level"):
        cut_seal("太白", shape="round")
