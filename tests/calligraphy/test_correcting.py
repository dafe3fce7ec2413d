"""Corrections of a page's strokes: what each must leave as it is, for any stroke."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon, hausdorff_distance, unary_union

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.page.correcting import CorrectedPage, halves_at
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.errors import InputError
from tests.support.examples import examples


def ribbon(line, width: float, dryness=()) -> GlyphStroke:
    """A stroke of one width along a line, holes where it closes on itself."""
    shape = LineString(line).buffer(0.5 * width)
    holes = tuple(np.array(ring.coords)[:-1] for ring in shape.interiors)
    outline = np.array(shape.exterior.coords)[:-1]
    return GlyphStroke(outline, np.array(line, np.float64), holes, tuple(dryness))


def region(stroke: GlyphStroke) -> Polygon:
    return Polygon(stroke.outline, stroke.holes)


def page_of(*pieces) -> Page:
    """Pieces side by side, each of some strokes."""
    made = [
        Piece(Glyph(str(k + 1), tuple(strokes), (0.0, 0.0, 1000.0, 1000.0)), (1200.0 * k, 30.0))
        for k, strokes in enumerate(pieces)
    ]
    return Page(tuple(made), "a.svg", "mine")


@st.composite
def strokes(draw) -> GlyphStroke:
    """Lines that bend, cross themselves and come back."""
    n = draw(st.integers(2, 5))
    place = st.floats(80.0, 920.0).map(lambda x: round(x, 1))
    line = [(draw(place), draw(place))]
    while len(line) < n:
        there = (draw(place), draw(place))
        if np.hypot(*np.subtract(there, line[-1])) > 60.0:
            line.append(there)
        else:
            n -= 1
    if len(line) < 2:
        line.append((line[0][0], line[0][1] + 300.0 if line[0][1] < 500 else line[0][1] - 300.0))
    dry = draw(st.lists(st.floats(0.0, 1.0), max_size=9))
    return ribbon(line, draw(st.floats(15.0, 140.0)), dry)


@settings(max_examples=examples(40), deadline=None)
@given(strokes(), st.floats(0.05, 0.95))
def test_parts_of_a_split_stroke_are_its_ink_and_joined_it_again(stroke, share) -> None:
    page = CorrectedPage.of(page_of([stroke]))
    whole = page.strokes[0].stroke
    place = LineString(whole.median).interpolate(share, normalized=True)
    cut = page.split(0, (place.x, place.y))
    one, other = (part.stroke for part in cut.strokes)
    area = region(whole).area
    assert region(one).area + region(other).area == pytest.approx(area, rel=2e-4)
    assert (
        unary_union([region(one), region(other)]).symmetric_difference(region(whole)).area
        < 2e-4 * area
    )
    assert region(one).is_valid
    assert region(other).is_valid
    np.testing.assert_allclose(one.median[-1], other.median[0])
    again, at = cut.join(0, 1)
    assert at == 0
    back = again.strokes[0].stroke
    assert region(back).symmetric_difference(region(whole)).area < 2e-4 * area
    assert hausdorff_distance(LineString(back.median), LineString(whole.median)) < 1e-6
    np.testing.assert_allclose(back.median[[0, -1]], whole.median[[0, -1]])
    assert len(back.dryness) == max(len(whole.dryness), 2 * bool(whole.dryness))


@pytest.mark.parametrize("share", [0.125, 0.7])
def test_a_line_that_comes_back_on_itself_is_cut(share) -> None:
    page = CorrectedPage.of(page_of([ribbon([(94, 80), (80, 919), (94, 80)], 15.0)]))
    whole = page.strokes[0].stroke
    place = LineString(whole.median).interpolate(share, normalized=True)
    one, other = (part.stroke for part in page.split(0, (place.x, place.y)).strokes)
    both = unary_union([region(one), region(other)])
    assert both.symmetric_difference(region(whole)).area < 2e-4 * region(whole).area
    assert min(region(one).area, region(other).area) > 1000.0


@settings(max_examples=25, deadline=None)
@given(strokes())
def test_reversed_twice_it_is_the_same(stroke) -> None:
    page = CorrectedPage.of(page_of([stroke]))
    once = page.reverse(0)
    np.testing.assert_array_equal(
        once.strokes[0].stroke.median, page.strokes[0].stroke.median[::-1]
    )
    assert once.strokes[0].stroke.dryness == stroke.dryness[::-1]
    back = once.reverse(0).strokes[0].stroke
    np.testing.assert_array_equal(back.median, page.strokes[0].stroke.median)
    assert back.dryness == stroke.dryness
    np.testing.assert_array_equal(back.outline, page.strokes[0].stroke.outline)


MOVES = st.lists(st.tuples(st.booleans(), st.integers(0, 6), st.integers(-3, 3)), max_size=8)


@settings(max_examples=40, deadline=None)
@given(MOVES)
def test_the_order_stays_a_permutation_and_pieces_stay_together(moves) -> None:
    bars = [ribbon([(100, 90.0 * k), (900, 90.0 * k)], 30.0) for k in range(1, 8)]
    first = page = CorrectedPage.of(page_of(bars[:3], bars[3:5], bars[5:]))
    for whole, k, by in moves:
        before = page.strokes[k]
        page, at = page.move_piece(k, by) if whole else page.move(k, by)
        assert page.strokes[at] is before
    assert sorted(map(id, page.strokes)) == sorted(map(id, first.strokes))
    pieces = [one.piece for one in page.strokes]
    assert sum(a != b for a, b in pairwise(pieces)) == 2
    assert sum(len(piece.glyph.strokes) for piece in page.page().pieces) == 7


def test_a_move_stops_at_the_ends_of_its_piece() -> None:
    bars = [ribbon([(100, 90.0 * k), (900, 90.0 * k)], 30.0) for k in range(1, 5)]
    page = CorrectedPage.of(page_of(bars[:2], bars[2:]))
    assert page.move(1, 1)[1] == 1
    assert page.move(2, 5)[1] == 3
    moved, at = page.move(3, -1)
    assert at == 2
    assert moved.strokes[2] is page.strokes[3]
    assert page.number(3) == (2, 2)
    assert page.numbers == [page.number(k)[0] for k in range(4)] == [1, 2, 1, 2]
    assert page.text(3) == "2"


def test_what_is_not_touched_stays_as_it_is() -> None:
    bars = [ribbon([(100, 90.0 * k), (900, 90.0 * k)], 30.0) for k in range(1, 5)]
    page = page_of(bars[:2], bars[2:])
    begun = CorrectedPage.of(page)
    assert not begun.is_changed
    assert begun.page().pieces == page.pieces
    changed = begun.reverse(0)
    assert changed.is_changed
    made = changed.page()
    assert made.pieces[1] is page.pieces[1]
    assert made.pieces[0].at == page.pieces[0].at
    np.testing.assert_allclose(made.pieces[0].glyph.strokes[0].median, bars[0].median[::-1])
    np.testing.assert_allclose(made.pieces[0].glyph.strokes[1].outline, bars[1].outline)


def test_what_is_left_out_is_not_written_and_can_be_taken_in() -> None:
    bars = [ribbon([(100, 90.0 * k), (900, 90.0 * k)], 30.0) for k in range(1, 4)]
    begun = CorrectedPage.of(page_of(bars[:2], bars[2:]))
    page = begun.leave_out(0).leave_out_piece(2)
    assert [len(piece.glyph.strokes) for piece in page.page().pieces] == [1]
    assert [len(piece.glyph.strokes) for piece in page.leave_out(0, False).page().pieces] == [2]
    with pytest.raises(InputError, match="nothing to write"):
        page.leave_out(1).page()


def test_strokes_join_at_their_nearest_ends_in_the_first_ones_direction() -> None:
    left, right = ribbon([(100, 500), (400, 500)], 40), ribbon([(900, 500), (460, 500)], 40)
    page = CorrectedPage.of(page_of([left, right]))
    for k, way in ((0, (100.0, 900.0)), (1, (900.0, 100.0))):
        joined, at = page.join(k, 1 - k)
        assert len(joined.strokes) == 1
        assert at == 0
        x = joined.page().pieces[0].glyph.strokes[0].median[:, 0]
        assert (x[0], x[-1]) == way
        assert (np.diff(x) * np.sign(x[-1] - x[0]) > 0.0).all()
    bridge = region(joined.strokes[0].stroke).area - region(left).area - region(right).area
    assert 0.0 < bridge < 40 * 60  # narrower than they are
    with pytest.raises(InputError, match="itself"):
        page.join(0, 0)


def test_what_has_no_area_is_not_joined() -> None:
    flat = GlyphStroke(np.array([[0, 0], [9, 0], [5, 0.0]]), np.array([[0, 0], [0, 0.0]]))
    page = CorrectedPage.of(page_of([flat, flat, ribbon([(100, 500), (400, 500)], 40)]))
    for k, other in ((0, 1), (0, 2), (2, 0)):
        with pytest.raises(InputError, match="without area"):
            page.join(k, other)
    with pytest.raises(InputError, match="between its ends"):
        page.split(0, (0.0, 0.0))


def test_a_stroke_joined_to_one_of_another_piece_stays_where_it_lies() -> None:
    one, other = ribbon([(700, 500), (980, 500)], 40), ribbon([(-100, 500), (300, 500)], 40)
    page = CorrectedPage.of(page_of([one], [other]))
    joined, _ = page.join(0, 1)
    made = joined.page()
    assert len(made.pieces) == 1
    piece = made.pieces[0]
    left, _, right, _ = piece.box
    assert left == pytest.approx(-500.0)
    assert right == pytest.approx(1200.0 - 500.0 + 320.0, abs=1.0)  # its ink's end on the page
    there = piece.glyph.strokes[0].median + np.array(piece.at) - piece.glyph.middle
    assert there[:, 0].min() == pytest.approx(200.0)
    assert there[:, 0].max() == pytest.approx(1000.0)


def test_dryness_goes_with_its_half() -> None:
    stroke = ribbon([(0, 0), (800, 0)], 40, (0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0))
    one, other = halves_at(stroke, np.array([400.0, 30.0]))
    np.testing.assert_allclose(one.dryness, (0.0, 0.0, 0.2, 0.4))
    np.testing.assert_allclose(other.dryness, (0.6, 0.8, 1.0, 1.0))
    page = CorrectedPage.of(page_of([one, other]))
    np.testing.assert_allclose(page.join(0, 1)[0].strokes[0].stroke.dryness, stroke.dryness)


@pytest.mark.parametrize("place", [(-50.0, 0.0), (5.0, 8.0), (900.0, 0.0)])
def test_an_end_cannot_be_cut_off(place) -> None:
    stroke = ribbon([(0, 0), (800, 0)], 40)
    with pytest.raises(InputError, match="between its ends"):
        halves_at(stroke, np.array(place))


def test_the_stroke_under_a_point_is_that_whose_line_is_nearest() -> None:
    across = ribbon([(100, 500), (900, 500)], 60)
    down = ribbon([(500, 900), (500, 100)], 100)
    page = CorrectedPage.of(page_of([across, down]))
    for place, reach, found in (
        ((-300.0, 40.0), 5.0, 0), ((40.0, -170.0), 5.0, 1), ((25.0, 35.0), 5.0, 0),
        ((-300.0, 70.0), 5.0, None), ((-300.0, 70.0), 15.0, 0),
    ):  # fmt: skip
        assert page.stroke_at(place, reach) == found


def test_corrections_are_kept_in_a_file(tmp_path: Path) -> None:
    bars = [ribbon([(100, 90.0 * k), (900, 90.0 * k)], 30.0) for k in range(1, 4)]
    page = CorrectedPage.of(page_of(bars)).reverse(0).leave_out(1)
    page, _ = page.move(0, 2)
    page = page.split(2, (0.0, -380.0))
    file = tmp_path / "a.strokes.json"
    save_strokes(page.page(), file)
    read = load_strokes(file).pieces[0].glyph.strokes
    wanted = page.page().pieces[0].glyph.strokes
    assert len(read) == 3
    for one, other in zip(read, wanted, strict=True):
        np.testing.assert_allclose(one.median, other.median, atol=1e-3)
        assert region(one).symmetric_difference(region(other)).area < 5.0
