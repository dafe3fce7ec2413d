"""Shapes taken apart into strokes: what holds for all of them, and what is known of some."""

from __future__ import annotations

import math
import sys
from types import FrameType

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, MultiPolygon, Point, Polygon, box

from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.shapes.triangles import triangulate
from paint3d.errors import InputError
from tests.support.cases import long_but
from tests.support.examples import examples
from tests.support.found_strokes import joined, region_of, score

NOTHING = MultiPolygon()


def ink(*shapes):
    """Shapes as one."""
    whole = shapely.union_all(list(shapes))
    return MultiPolygon([part for part in shapely.get_parts(whole) if part.area > 0.0])


@st.composite
def scribbles(draw):
    """Up to four strokes of several widths, which may cross, touch and close on themselves."""
    place = st.tuples(st.integers(0, 100), st.integers(0, 100))
    shapes = []
    for _ in range(draw(st.integers(1, 4))):
        points = draw(st.lists(place, min_size=2, max_size=4, unique=True))
        shapes.append(LineString(points).buffer(draw(st.floats(2.0, 7.0)), quad_segs=6))
    return ink(*shapes)


@given(scribbles())
@settings(deadline=None, max_examples=examples(40))
def test_regions_together_are_the_ink(shape):
    regions = [region_of(stroke) for stroke in decompose(shape)]
    assert all(region.geom_type == "Polygon" for region in regions)
    assert shapely.union_all(regions).symmetric_difference(shape).area < 1e-6 * shape.area


@given(scribbles())
@settings(deadline=None, max_examples=examples(40))
def test_lines_lie_in_their_regions(shape):
    for stroke in decompose(shape):
        assert len(stroke.median) >= 2
        outside = LineString(stroke.median).difference(region_of(stroke).buffer(1e-6))
        assert outside.length < 1e-6


@given(scribbles(), st.sampled_from([2.0**-20, 0.125, 1024.0]), st.integers(-64, 64))
@settings(deadline=None, max_examples=examples(25))
def test_place_and_size_do_not_matter(shape, scale, away):
    strokes = decompose(shape)
    moved = decompose(shapely.transform(shape, lambda points: scale * (points + away)))
    assert len(moved) == len(strokes)
    for one, two in zip(strokes, moved, strict=True):
        back = shapely.transform(region_of(two), lambda points: points / scale - away)
        assert back.symmetric_difference(region_of(one)).area < 1e-3 * shape.area


@given(scribbles())
@settings(deadline=None, max_examples=examples(25))
def test_the_same_shape_gives_the_same_strokes(shape):
    for one, two in zip(decompose(shape), decompose(shape), strict=True):
        assert np.array_equal(one.outline, two.outline)
        assert np.array_equal(one.median, two.median)


def test_a_cross_is_two_strokes_that_share_the_middle():
    level, upright = box(0, 45, 100, 55), box(45, 0, 55, 100)
    strokes = decompose(ink(level, upright))
    assert len(strokes) == 2
    for stroke, bar in zip(strokes, (level, upright), strict=True):
        region = region_of(stroke)
        assert region.intersection(bar).area / region.union(bar).area > 0.95
    first, second = (s.median[-1] - s.median[0] for s in strokes)
    assert first[0] > 80.0, "the level one first, to the right"
    assert second[1] < -80.0, "then downwards"


@pytest.mark.parametrize(("turn", "goes_on"), [(0.0, True), (30.0, True), (75.0, False)])
def test_a_stroke_goes_on_through_a_junction_where_it_turns_little(turn, goes_on):
    """Of a trunk and two arms: to the arm that turns by `turn`, else the arms are one stroke."""
    trunk = LineString([(0, -70), (0, 0)])
    ways = np.radians([90.0 - turn, 170.0])
    arms = [LineString([(0, 0), (70 * np.cos(way), 70 * np.sin(way))]) for way in ways]
    strokes = decompose(ink(*(line.buffer(5.0) for line in (trunk, *arms))))
    assert len(strokes) == 2
    (lowest,) = (stroke for stroke in strokes if stroke.median[:, 1].min() < -50.0)
    assert (LineString(lowest.median).length > 120.0) is goes_on


def test_a_frame_is_written_in_three_strokes():
    """As the character for mouth: its left side, its top with the right one, its bottom."""
    frame = ink(box(0, 0, 100, 100).difference(box(10, 10, 90, 90)))
    left, fold, bottom = decompose(frame)
    assert np.ptp(left.median[:, 0]) < 10 < 80 < left.median[0, 1] - left.median[-1, 1]
    assert fold.median[-1, 0] - fold.median[0, 0] > 80 < fold.median[0, 1] - fold.median[-1, 1]
    assert np.ptp(bottom.median[:, 1]) < 10 < 80 < bottom.median[-1, 0] - bottom.median[0, 0]


def test_a_round_letter_is_one_closed_stroke_with_a_hole():
    (stroke,) = decompose(ink(Point(0, 0).buffer(50, 32).difference(Point(0, 0).buffer(40, 32))))
    assert len(stroke.holes) == 1
    assert np.array_equal(stroke.median[0], stroke.median[-1])
    assert np.hypot(*stroke.median.T) == pytest.approx(45.0, abs=0.5)
    assert stroke.median[0, 1] == pytest.approx(45.0, abs=1.0), "begun at its top"


@pytest.mark.parametrize("shape", [Point(3, 4).buffer(2.0), box(0, 0, 3, 2), box(0, 0, 2, 2)])
def test_a_dot_is_a_stroke(shape):
    (stroke,) = decompose(ink(shape))
    assert region_of(stroke).symmetric_difference(shape).area < 1e-7
    assert shape.covers(LineString(stroke.median))


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0])
def test_a_round_dot_is_drawn_level_from_rim_to_rim(angle):
    """Pressed in its middle alone, it keeps two bare crescents."""
    disc = shapely.affinity.rotate(Point(3, 4).buffer(2.0, 16), angle, use_radians=True)
    (stroke,) = decompose(ink(disc))
    way = stroke.median[-1] - stroke.median[0]
    assert abs(way[1]) < 1e-6
    assert abs(way[0]) > 3.9


def test_branches_of_no_length_are_no_strokes():
    lines = [[(10, 10), (50, 40)], [(0, 10), (70, 100), (10, 70)], [(30, 30), (10, 90)]]
    pairs = zip(lines, (7.0, 7.0, 6.0), strict=True)
    shape = ink(*(LineString(points).buffer(half, quad_segs=6) for points, half in pairs))
    strokes = decompose(shape)
    assert all(LineString(stroke.median).length > 1.0 for stroke in strokes)
    regions = shapely.union_all([region_of(stroke) for stroke in strokes])
    assert regions.symmetric_difference(shape).area < 1e-6 * shape.area


def test_specks_are_left_out():
    strokes = decompose(ink(box(0, 0, 100, 10), Point(50, 30).buffer(0.3)))
    assert len(strokes) == 1


def test_nothing_is_refused():
    with pytest.raises(InputError, match="no area"):
        decompose(NOTHING)


def known(text):
    return open_glyphs(None).load(text)


@pytest.mark.parametrize("text", long_but("永目国", "永世目和国"))
def test_known_strokes_come_back_in_their_order(text):
    glyph = known(text)
    result = score(decompose(joined(glyph.strokes), template=glyph), glyph.strokes)
    assert result.found >= 0.8
    assert result.tau == pytest.approx(1.0)
    assert result.direction == 1.0


@given(
    turn=st.floats(-0.12, 0.12),
    wide=st.floats(0.8, 1.25),
    slant=st.floats(-0.15, 0.15),
    text=st.sampled_from("木大王田"),
)
@settings(deadline=None, max_examples=examples(25))
def test_another_drawing_of_a_character_takes_its_strokes(turn, wide, slant, text):
    """Turned, wider, slanted, elsewhere and of another size: order and direction are the same."""
    cosine, sine = math.cos(turn), math.sin(turn)
    change = np.array([[cosine, -sine], [sine, cosine]]) @ np.array([[wide, slant], [0.0, 1.0]])
    glyph = known(text)
    strokes = [
        GlyphStroke(0.01 * s.outline @ change.T + 7.0, 0.01 * s.median @ change.T + 7.0)
        for s in glyph.strokes
    ]
    result = score(decompose(joined(strokes), template=glyph), strokes)
    assert result.count == 0
    assert result.found >= 0.75
    assert result.tau == pytest.approx(1.0)
    assert result.direction == 1.0


def test_a_shape_that_joins_strokes_keeps_its_own():
    """Where a hand runs three strokes together, they are not torn apart."""
    path = [(0, 100), (100, 100), (0, 50), (100, 50), (0, 0), (100, 0)]
    shape = ink(LineString(path).buffer(5.0))
    assert len(decompose(shape, template=known("三"))) < 3
    forward = decompose(shape, template=known("三"))[0].median
    assert forward[0, 1] > forward[-1, 1]


@pytest.mark.parametrize("shape", [Point(0, 0).buffer(50), box(0, 0, 400, 20)])
def test_a_template_that_is_a_point_is_laid_over_a_shape(shape):
    point = Glyph("?", (GlyphStroke(np.empty((0, 2)), np.full((2, 2), 7.0)),))
    (stroke,) = decompose(ink(shape), template=point)
    assert np.isfinite(stroke.median).all()


def test_a_template_without_strokes_is_none():
    shape = ink(box(0, 45, 100, 55), box(45, 0, 55, 100))
    bare = decompose(shape, template=Glyph("?", ()))
    assert [len(s.outline) for s in bare] == [len(s.outline) for s in decompose(shape)]


def test_a_polygon_that_crosses_itself_is_mended():
    bow = MultiPolygon([Polygon([(0, 0), (10, 10), (10, 0), (0, 10)])])
    assert sum(region_of(stroke).area for stroke in decompose(bow)) >= 49.9


def diamond(x: float, y: float, half: float = 1.0) -> Polygon:
    return Polygon([(x - half, y), (x, y + half), (x + half, y), (x, y - half)])


def test_dots_that_run_together_are_each_one() -> None:
    """As those of an Arabic letter do: their ink is parted at the waist, and all of it is kept."""
    two = shapely.union_all([diamond(0.0, 0.0), diamond(1.7, 0.2)])
    strokes = decompose(MultiPolygon([two]))
    assert len(strokes) == 2
    regions = [Polygon(stroke.outline) for stroke in strokes]
    assert shapely.union_all(regions).symmetric_difference(two).area < 1e-6
    assert [region.area / two.area for region in regions] == pytest.approx([0.52, 0.52], abs=0.04)
    third = shapely.union_all([two, diamond(3.4, 0.0)])
    assert len(decompose(MultiPolygon([third]))) == 3


def test_more_dots_in_a_row_than_letters_have_are_one_stroke() -> None:
    """A frill is no letter's: four may run together, with five of them the row is a line."""
    for n, strokes in ((4, 4), (5, 1)):
        row = shapely.union_all([diamond(1.7 * k, 0.0) for k in range(n)])
        assert len(decompose(MultiPolygon([row]))) == strokes


def test_dots_across_a_gap_stay_apart() -> None:
    """Four around, of which the first and the last do not touch: none reaches into the other."""
    middles = (0.0, 0.0), (0.1, 1.9), (2.0, 1.9), (2.1, 0.0)
    four = shapely.union_all([Point(middle).buffer(1.0) for middle in middles])
    strokes = decompose(MultiPolygon([four]))
    assert len(strokes) == 4
    regions = [region_of(stroke) for stroke in strokes]
    assert shapely.union_all(regions).symmetric_difference(four).area < 1e-6
    first, last = (min(regions, key=Point(middles[k]).distance) for k in (0, -1))
    assert first.intersection(last).area == 0.0


def test_what_is_no_dot_at_a_waist_is_not_parted() -> None:
    long = shapely.union_all([diamond(0.0, 0.0), shapely.box(0.8, -0.12, 6.0, 0.12)])
    assert len(decompose(MultiPolygon([long]))) == 1
    ring = shapely.Point(0.0, 0.0).buffer(2.0).difference(shapely.Point(0.0, 0.0).buffer(1.6))
    assert len(decompose(MultiPolygon([ring]))) == 1


@pytest.mark.parametrize("turn", [0.0, 20.0, 45.0, 70.0])
def test_a_square_dot_is_written_from_corner_to_corner(turn) -> None:
    square = shapely.affinity.rotate(shapely.box(0.0, 0.0, 2.0, 2.0), turn)
    (stroke,) = decompose(MultiPolygon([square]))
    ends = stroke.median[[0, -1]]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.9 * math.sqrt(8.0), rel=0.01)
    corners = np.array(square.exterior.coords)
    for end in ends:
        assert np.linalg.norm(corners - end, axis=1).min() < 0.2
    assert ends[0, 0] <= ends[1, 0]


@pytest.mark.parametrize(
    ("thick", "thin", "from_thick"),
    [
        ((0.0, 0.0), (20.0, 30.0), True),  # it rises: ti
        ((30.0, 25.0), (0.0, 0.0), True),  # it falls to the left: pie
        ((30.0, -30.0), (0.0, 0.0), False),  # it falls to the right, with its foot last: na
        ((0.0, -40.0), (0.0, 0.0), False),  # a stem that swells
    ],
)
def test_a_stroke_runs_out_to_its_point(thick, thin, from_thick) -> None:
    """Unless that were upwards against the brush."""
    ends = np.array([thick, thin])
    way = ends[1] - ends[0]
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    outline = np.array([
        ends[0] + 3.0 * across, ends[1] + 0.8 * across, ends[1] - 0.8 * across,
        ends[0] - 3.0 * across,
    ])  # fmt: skip
    (stroke,) = decompose(MultiPolygon([Polygon(outline)]))
    forwards = float((stroke.median[-1] - stroke.median[0]) @ way) > 0.0
    assert forwards is from_thick


def net(n: int) -> MultiPolygon:
    """Bars between the places of a square grid, a quarter of them left out: one connected shape."""
    rng = np.random.default_rng(4)
    bars = [
        LineString([(10 * x + rng.normal(0.0, 0.3), 10 * y), (10 * (x + dx), 10 * (y + dy))])
        for x in range(n)
        for y in range(n)
        for dx, dy in ((1, 0), (0, 1))
        if rng.random() > 0.25
    ]
    whole = shapely.union_all([bar.buffer(1.0) for bar in bars])
    return MultiPolygon([max(shapely.get_parts(whole), key=shapely.area)])


def steps_of_taking_apart(shape: MultiPolygon) -> tuple[int, int]:
    """How many functions are called, and how many strokes are found."""
    calls = 0

    def count(_frame: FrameType, event: str, _arg: object) -> None:
        nonlocal calls
        calls += event == "call"

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        strokes = decompose(shape)
    finally:
        sys.setprofile(before)
    return calls, len(strokes)


def test_a_net_takes_as_long_as_its_strokes() -> None:
    """Each of many strokes took as long as there were others: nets of a thousand minutes."""
    steps_of_taking_apart(net(3))  # what is imported does not count
    few, some = steps_of_taking_apart(net(4))
    many, more = steps_of_taking_apart(net(9))
    assert more > 3 * some >= 30
    assert many / more < 1.4 * few / some


def test_distances_to_the_edge_are_those_to_all_of_it() -> None:
    shape = Point(0, 0).buffer(10.0).difference(box(-3, -2, 4, 5))
    triangles = triangulate(shape)
    points = np.random.default_rng(2).uniform(-12.0, 12.0, (300, 2))
    edge = shapely.distance(shapely.points(points), shape.boundary)
    assert triangles.to_edge(points) == pytest.approx(edge, rel=1e-12)
    assert triangles.to_edge(np.zeros((1, 2))) == pytest.approx([2.0])
