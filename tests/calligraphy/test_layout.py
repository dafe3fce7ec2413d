"""Where characters go on objects: squares that are square, apart, and in reading order."""

import functools
import math
import re
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from scipy.spatial import cKDTree

from paint3d.calligraphy.layout import Layout, _Grid, layout_text, split_text
from paint3d.errors import InputError, MeshError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SquareLimits, frame_at, lay_square, make_chart
from paint3d.mesh.placement import place, walk
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.cases import long_but

POEM = "春眠不觉晓处处闻啼鸟夜来风雨声花落知多少"


def make_cylinder(radius=40.0, height=120.0, n=160):
    """An open tube about z, facing outwards."""
    turn = 2 * np.pi * np.arange(n) / n
    z = np.linspace(0.0, height, 49)
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    points = np.concatenate([np.column_stack([ring, np.full(n, h)]) for h in z])
    a = (np.arange(48)[:, None] * n + np.arange(n)).ravel()
    b = (np.arange(48)[:, None] * n + (np.arange(n) + 1) % n).ravel()
    faces = np.concatenate([np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)])
    return TriangleMesh(points.astype(np.float32), faces.astype(np.int32), name="cylinder")


@functools.cache
def body(name):
    return ClosestPoints(make_cylinder() if name == "cylinder" else load_mesh(name))


def true_sides(square, surface):
    """Lengths of the square's sides by closest points on the surface, walked finely."""
    half = 0.5 * square.em_mm
    t = np.linspace(-half, half, 101)
    fixed = np.full_like(t, half)
    edges = [(t, -fixed), (fixed, t), (t, fixed), (-fixed, t)]
    sides = []
    for x, y in edges:
        line = surface.find(square.chart.points(np.column_stack([x, y]))).points
        sides.append(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    return np.array(sides)


def deepest(one, two):
    """How far (mm) points of one square lie inside another, by fine grids."""
    line = np.linspace(-0.5, 0.5, 61) * one.em_mm
    xy = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    a, b = one.chart.points(xy), two.chart.points(xy)
    depth = 0.5 * one.em_mm - np.abs(xy).max(axis=1)
    distance, nearest = cKDTree(b).query(a)
    shared = distance < 0.6 * one.em_mm / 60
    return float(np.max(np.minimum(depth, depth[nearest])[shared], initial=0.0))


CASES = [
    ("bowl", 12.0, Layout()),
    ("bowl", 40.0, Layout(around=True)),
    ("bowl", 18.0, Layout(side="inside")),
    ("bowl", 16.0, Layout(side="top")),
    ("vase", 40.0, Layout()),
    ("vase", 45.0, Layout("row", around=True)),
    ("sphere", 20.0, Layout()),
    ("plate", 24.0, Layout()),
    ("cylinder", 20.0, Layout()),
    ("plane", 30.0, Layout("row")),
]


@functools.cache
def placed(case):
    name, em, layout = CASES[case]
    n = {40.0: 7, 18.0: 8, 16.0: 6, 45.0: 12, 30.0: 6}.get(em, 20)
    return layout_text(body(name), POEM[:n], em, layout)


@pytest.mark.parametrize("case", long_but(range(5), range(len(CASES))))
def test_squares_are_square(case):
    surface = body(CASES[case][0])
    for character in placed(case):
        square = character.square
        assert true_sides(square, surface) == pytest.approx(square.em_mm, rel=0.035)
        assert np.degrees(square.corner_angles()) == pytest.approx(90.0, abs=3.5)


@pytest.mark.parametrize("case", long_but(range(5), range(len(CASES))))
def test_no_two_squares_overlap(case):
    squares = [character.square for character in placed(case)]
    em = squares[0].em_mm
    for k, one in enumerate(squares):
        for two in squares[k + 1 :]:
            apart = np.linalg.norm(one.chart.frame.origin - two.chart.frame.origin)
            if apart < 2.2 * em:
                assert deepest(one, two) < 0.02 * em


def test_columns_run_down_and_from_right_to_left():
    squares = [c.square.chart.frame for c in placed(0)]
    heights = np.array([frame.origin[2] for frame in squares])
    tall = int(np.argmax(np.diff(heights) > 0.0)) + 1
    assert tall >= 2
    assert (np.diff(heights[:tall]) < 0.0).all()
    step = squares[tall].origin - squares[0].origin
    assert step @ squares[0].x_axis < 0.0
    assert abs(heights[tall] - heights[0]) < 0.2
    assert [c.text for c in placed(0)] == list(POEM)


def test_rows_run_to_the_right():
    squares = [c.square.chart.frame for c in placed(9)]
    xs = [frame.origin[0] for frame in squares]
    assert np.diff(xs) == pytest.approx(30.0, abs=0.2)
    assert np.mean(xs) == pytest.approx(0.0, abs=0.1)


def test_around_goes_evenly_all_around():
    origins = np.array([c.square.chart.frame.origin for c in placed(1)])
    turn = np.unwrap(np.arctan2(origins[:, 1], origins[:, 0]))
    assert np.diff(turn) == pytest.approx(-2 * np.pi / len(origins), abs=0.02)
    assert np.ptp(origins[:, 2]) < 0.2


def test_writing_inside_faces_inwards():
    for character in placed(2):
        frame = character.square.chart.frame
        assert frame.normal[:2] @ frame.origin[:2] < 0.0


def test_line_breaks_make_columns():
    frames = [c.square.chart.frame.origin for c in layout_text(body("plane"), "永和\n九", 20.0)]
    assert frames[1] - frames[0] == pytest.approx([0, -20, 0], abs=0.2)
    assert frames[2] - frames[0] == pytest.approx([-22, 0, 0], abs=0.2)
    assert split_text(" 永 和\n\n九\t") == ["永和", "九"]


def test_a_place_that_was_asked_for_is_kept():
    (one,) = layout_text(body("plane"), "永", 20.0, Layout(at=(0.25, 0.75)))
    assert one.square.chart.frame.origin == pytest.approx([-50, 50, 0], abs=1e-3)


def test_a_text_that_does_not_fit_says_how_much_would():
    with pytest.raises(InputError, match=r"9 characters does not fit on plane .* 4 of them would"):
        layout_text(body("plane"), POEM[:9], 66.0)


def test_a_text_that_does_not_fit_says_at_which_size_it_would():
    with pytest.raises(InputError, match=r"expected a size of [\d.]+ mm") as fault:
        layout_text(body("plane"), POEM[:9], 66.0)
    proposed = float(re.search(r"expected a size of ([\d.]+) mm", str(fault.value))[1])
    assert 40.0 < proposed < 60.0
    assert len(layout_text(body("plane"), POEM[:9], proposed)) == 9


@pytest.mark.parametrize(
    ("name", "em", "layout", "words"),
    [
        ("plane", 300.0, Layout(), "the surface ends"),
        ("sphere", 140.0, Layout(), "stretched by"),
        ("sphere", 20.0, Layout(side="inside"), "faces away"),
        ("plane", 20.0, Layout(side="outside"), "no surface at"),
        ("plane", 20.0, Layout(around=True), "does not go around it"),
        ("plate", 20.0, Layout(around=True, at=(0.5, 0.4)), "does not go around it"),
        ("bowl", 20.0, Layout(at=(0.5, 0.99)), "edge or a tight bend"),
    ],
)
def test_no_place_is_said_and_why(name, em, layout, words):
    with pytest.raises(MeshError, match=words):
        layout_text(body(name), "永", em, layout)


def test_a_text_around_a_plate_goes_round_its_rim_not_beneath_it():
    placed = layout_text(body("plate"), "山高水長", 20.0, Layout("row", around=True))
    frames = [one.square.chart.frame for one in placed]
    assert all(frame.normal[2] > 0.5 for frame in frames)
    assert [frame.origin[2] for frame in frames] == pytest.approx(
        [frames[0].origin[2]] * 4, abs=0.1
    )


def sheets(*offsets):
    """Squares of 60 mm in x and z, one behind the other in y, that look to the front (-y)."""
    corners = np.array([[x, 0, z] for z in (0, 60) for x in (0, 60)], float)
    points = np.concatenate([corners + offset for offset in offsets])
    faces = np.concatenate(
        [4 * k + np.array([[0, 1, 3], [0, 3, 2]]) for k in range(len(offsets))]
    ).astype(np.int32)
    return ClosestPoints(TriangleMesh(points.astype(np.float32), faces, name="sheets"))


def test_a_place_is_looked_for_where_the_middle_has_none():
    apart = sheets((0, 0, 0), (90, 0, 0), (0, 0, 80), (90, 0, 80))  # the middle is a gap
    (one,) = layout_text(apart, "\u6c38", 40.0)
    x, y, z = one.square.points.reshape(-1, 3).T
    assert y == pytest.approx(0.0, abs=1e-3)
    assert (x < 60).all() or (x > 90).all()
    assert (z < 60).all() or (z > 80).all()
    with pytest.raises(MeshError, match=r"no surface at .* other places were no better"):
        layout_text(apart, "\u6c38", 70.0)
    with pytest.raises(MeshError, match=r"no surface at \[0.5, 0.5\] seen from the outside"):
        layout_text(apart, "\u6c38", 40.0, Layout(at=(0.5, 0.5)))


def test_a_text_of_thousands_is_refused_before_it_is_laid(monkeypatch: pytest.MonkeyPatch):
    """Squares are laid for what may fit; how long the rest is is all that is asked."""
    laid = []
    cells = _Grid._cells
    monkeypatch.setattr(_Grid, "_cells", lambda *asked: laid.append(cells(*asked)) or laid[-1])
    with pytest.raises(InputError, match=r"10000 characters does not fit on plane .* 4 of them"):
        layout_text(body("plane"), "\u6c38" * 10_000, 90.0)
    assert sum(map(len, laid)) < 100


def test_a_text_that_fits_nowhere_says_how_much_would_at_the_best_place():
    apart = sheets((0, 0, 0), (90, 0, 0), (0, 0, 80), (90, 0, 80))
    with pytest.raises(
        InputError, match=r"9 characters does not fit on sheets .* [1-4] of them would"
    ):
        layout_text(apart, POEM[:9], 25.0)


def test_the_brush_needs_room_above_the_square():
    behind = sheets((0, 0, 0), (0, -20, 0))  # one looks at the other's back, 20 mm away
    near = place(behind, (0, -1, 0))
    far = frame_at(behind, (30, 0, 30), (0, 0, 1))
    for room, free in ((10.0, True), (30.0, False)):
        limits = SquareLimits(room_mm=room)
        lay_square(behind, near, 20.0, limits)
        if free:
            lay_square(behind, far, 20.0, limits)
        else:
            with pytest.raises(MeshError, match="no room for the brush"):
                lay_square(behind, far, 20.0, limits)


@pytest.mark.parametrize("text", ["", " \n\t"])
def test_an_empty_text_is_refused(text):
    with pytest.raises(InputError, match="the text is empty"):
        layout_text(body("plane"), text, 20.0)


def test_a_box_is_written_on_up_to_its_edges():
    corners = np.array([[x, y, z] for x in (0, 30) for y in (0, 30) for z in (0, 90)], float)
    sides = [(0, 4, 5, 1), (4, 6, 7, 5), (6, 2, 3, 7), (2, 0, 1, 3), (1, 5, 7, 3), (0, 2, 6, 4)]
    faces = [f for a, b, c, d in sides for f in ((a, b, c), (a, c, d))]
    mesh = TriangleMesh(corners.astype(np.float32), np.array(faces, np.int32), name="box")
    box = ClosestPoints(mesh)
    placed = layout_text(box, "永和九", 27.0)
    assert [c.square.chart.frame.normal.round(6).tolist() for c in placed] == [[0, -1, 0]] * 3
    assert placed[0].square.sides() == pytest.approx(27.0, abs=1e-3)
    with pytest.raises(MeshError, match="the surface ends within it"):
        layout_text(box, "永", 29.0)


def test_an_unknown_order_is_refused():
    with pytest.raises(InputError, match="expected one of columns, row"):
        layout_text(body("plane"), "永", 20.0, Layout("spiral"))


def test_a_row_longer_than_the_ring_is_refused():
    """It would end in its own beginning: the ring is 251 mm."""
    assert len(layout_text(body("cylinder"), POEM[:12], 20.0, Layout("row"))) == 12
    with pytest.raises(
        InputError, match=r"text of 13 characters does not fit .*: 12 of them would"
    ):
        layout_text(body("cylinder"), POEM[:13], 20.0, Layout("row"))


def test_level_lines_close_and_keep_their_height():
    start = place(body("bowl"), (0.5, 0.5))
    line = walk(body("bowl"), start, (0, 0, 1), (1.0, 0.0))
    assert line.closed
    assert line.points[:, 2] == pytest.approx(start.origin[2], abs=0.1)
    radius = np.hypot(*start.origin[:2])
    assert line.length == pytest.approx(2 * np.pi * radius, rel=2e-3)
    assert line.at(line.length + 5.0) == pytest.approx(line.at(5.0))


def test_lines_are_walked_no_farther_than_asked(monkeypatch: pytest.MonkeyPatch):
    surface, asked = body("bowl"), []
    start = place(surface, (0.5, 0.5))
    whole = walk(surface, start, (0, 0, 1), (1.0, 0.0))
    places = [0.0, 3.0, 21.7, whole.length - 0.1, whole.length, whole.length + 4.0, -2.0]
    expected = [whole.at(distance).tolist() for distance in places if whole.closed]
    find = ClosestPoints.find_checked
    monkeypatch.setattr(
        ClosestPoints, "find_checked", lambda self, points: asked.append(1) or find(self, points)
    )
    line = walk(surface, start, (0, 0, 1), (1.0, 0.0))
    assert line.reaches(20.0)
    assert 0 < len(asked) <= 2 * 25, "two a step of a millimetre"
    assert [line.at(distance).tolist() for distance in places] == expected
    assert not line.reaches(whole.length + 0.01)
    assert line.points.tolist() == whole.points.tolist()


def test_a_line_whose_walk_was_interrupted_is_as_long_as_before(monkeypatch: pytest.MonkeyPatch):
    surface, asked = body("bowl"), []
    start = place(surface, (0.5, 0.5))
    length, find = walk(surface, start, (0, 0, 1), (1.0, 0.0)).length, ClosestPoints.find_checked

    def interrupted(self, points):
        asked.append(1)
        if len(asked) == 9:
            raise KeyboardInterrupt
        return find(self, points)

    monkeypatch.setattr(ClosestPoints, "find_checked", interrupted)
    line = walk(surface, start, (0, 0, 1), (1.0, 0.0))
    with pytest.raises(KeyboardInterrupt):
        line.reaches(20.0)
    assert line.length == length


def test_threads_may_ask_the_same_line(monkeypatch: pytest.MonkeyPatch):
    surface, find, both = body("bowl"), ClosestPoints.find_checked, Barrier(2)
    start = place(surface, (0.5, 0.5))
    lengths = {walk(surface, start, (0, 0, 1), (1.0, 0.0)).length}
    line = walk(surface, start, (0, 0, 1), (1.0, 0.0))

    def slow(self, points):
        time.sleep(1e-5)  # lets the other thread come between
        return find(self, points)

    def length(_) -> float:
        both.wait()
        return line.length

    monkeypatch.setattr(ClosestPoints, "find_checked", slow)
    with ThreadPoolExecutor(2) as threads:
        assert set(threads.map(length, range(2))) == lengths


@pytest.mark.parametrize("distance", [math.nan, math.inf, -math.inf])
def test_no_place_on_a_ring_is_endlessly_far(distance):
    line = walk(body("bowl"), place(body("bowl"), (0.5, 0.5)), (0, 0, 1), (1.0, 0.0))
    with pytest.raises(InputError, match=f"mm long; expected {distance:.1f} mm"):
        line.at(distance)


def test_one_character_walks_no_farther_than_its_square(monkeypatch: pytest.MonkeyPatch):
    surface, asked = ClosestPoints(body("bowl").mesh), []
    find = ClosestPoints.find
    monkeypatch.setattr(
        ClosestPoints, "find", lambda self, points: asked.append(1) or find(self, points)
    )
    layout_text(surface, "永", 20.0)
    assert len(asked) < 400, "all around the bowl and up and down it are 2,000"


def test_climbing_lines_end_where_the_surface_does():
    start = place(body("cylinder"), (0.5, 0.5))
    up = walk(body("cylinder"), start, (0, 0, 1), (0.0, 1.0))
    assert not up.closed
    assert up.length == pytest.approx(60.0, abs=0.2)
    assert walk(body("sphere"), place(body("sphere"), (0.5, 0.5)), (0, 0, 1), (0, 1)).length < 119.0
    with pytest.raises(InputError, match="mm long"):
        up.at(61.0)


def test_overlap_is_the_depth_that_two_squares_share():
    surface = body("plane")
    squares = [
        lay_square(surface, frame_at(surface, (x, y, 0), (0, 1, 0)), 20.0)
        for x, y in ((0, 0), (18, 0), (20.5, 0), (17, 17))
    ]
    assert squares[0].overlap(squares[1]) == pytest.approx(2.0, abs=0.05)
    assert squares[0].overlap(squares[2]) == 0.0
    assert squares[0].overlap(squares[3]) == pytest.approx(3.0, abs=0.05)


def test_a_chart_s_steps_may_be_larger():
    surface = body("sphere")
    frame = place(surface, (0.5, 0.5))
    fine, coarse = (make_chart(surface, frame, 15, 15, 2.5, step) for step in (0.5, 2.0))
    xy = np.random.default_rng(1).uniform(-15, 15, (100, 2))
    assert np.linalg.norm(fine.points(xy) - coarse.points(xy), axis=1).max() < 0.05
