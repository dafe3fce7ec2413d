"""Text on mugs with a handle: nothing lies on anything else, and what is in the way is said."""

import itertools
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.calligraphy.fonts.font_file import open_font
from paint3d.calligraphy.fonts.shaping import Style
from paint3d.calligraphy.fonts.typesetting import set_text
from paint3d.calligraphy.layout import Layout, TextPlace, WritingArea, layout_text
from paint3d.calligraphy.page.laying import lay_page
from paint3d.cli.info import info_lines
from paint3d.cli.write import say_if_hidden
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SquareLimits
from paint3d.mesh.placement import place, turns_of
from tests.support.cases import long_but
from tests.support.mugs import make_mug, make_pot_among_balls, make_teapot

DEJAVU = Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")
TEXTS = ("Maria Löwe", "The quick brown\nfox jumps", "山高水長")
LIMITS = SquareLimits(room_mm=20.0)
TURNS, SIZES = (0.0, 63.0, 180.0, 270.0, 318.0), (9.0, 14.0, 20.0, 27.0)
CASES = [
    *itertools.product(TURNS, SIZES, ("row",), TEXTS),
    *itertools.product(TURNS, SIZES, ("columns",), TEXTS[2:]),
]
HANDLE = 0.75  # turns
KEPT = [
    (0.0, 20.0, "row", TEXTS[0]), (318.0, 14.0, "row", TEXTS[1]), (270.0, 20.0, "columns", TEXTS[2])
]  # fmt: skip


def laid(degrees, em, order, text, **place):
    """The squares of a text on a mug, with the boxes that they have on the page."""
    surface, layout = ClosestPoints(make_mug(degrees)), Layout(order, **place)
    if text[0] == TEXTS[2][0]:
        placed = layout_text(surface, text, em, layout, LIMITS)
        return [one.square for one in placed], None
    font = open_font(DEJAVU)
    page, pieces = lay_page(surface, set_text(text, font, Style(), None, order), em, layout, LIMITS)
    return [one.square for one in pieces], [piece.box for piece in page.pieces]


@pytest.mark.parametrize(("degrees", "em", "order", "text"), long_but(KEPT, CASES))
def test_boxes_lie_apart_as_they_do_on_the_page(degrees, em, order, text):
    if not DEJAVU.exists():
        pytest.skip("DejaVu is not installed")
    try:
        squares, boxes = laid(degrees, em, order, text)
    except InputError as refusal:
        if "not fit" not in str(refusal):
            raise
        return
    check_apart(squares, boxes, em)


def test_a_level_line_that_closes_to_the_left_alone_is_followed_to_the_left():
    """To the right it goes astray on the handle."""
    squares, boxes = laid(0.0, 20.0, "row", "Löwe", point=(22.0, -34.58, 30.16))
    check_apart(squares, boxes, 20.0)


def check_apart(squares, boxes, em):
    """Check that squares share no more than their boxes do on the page."""
    for one, two in itertools.permutations(range(len(squares)), 2):
        shared = 0.0
        if boxes is not None:
            (l1, b1, r1, u1), (l2, b2, r2, u2) = boxes[one], boxes[two]
            shared = max(0.0, min(r1 - l2, r2 - l1, u1 - b2, u2 - b1)) * em / 1024.0
        assert squares[one].overlap(squares[two]) < shared + 0.03 * em


@pytest.mark.parametrize(
    ("order", "text", "at"), [("row", TEXTS[0], (0.5, 0.2)), ("columns", TEXTS[2], (0.72, 0.5))]
)
def test_a_handle_in_the_way_is_said_with_what_would_do(order, text, at):
    with pytest.raises(InputError, match="another part of the object is in the way at") as fault:
        laid(0.0, 20.0, order, text, at=at)
    told = str(fault.value)
    sizes, places = (
        re.findall(pattern, told) for pattern in (r"size of ([\d.]+) mm would", r"([\d.]+,[\d.]+)$")
    )
    u, v = map(float, places[0].split(","))
    assert v == at[1]
    assert len(laid(0.0, 20.0, order, text, at=(u, v))[0]) == len(text.replace(" ", ""))
    for size in map(float, sizes):
        assert len(laid(0.0, size, order, text, at=at)[0]) == len(text.replace(" ", ""))


# -- text around --------------------------------------------------------------------------------


def turns_round(squares):
    """The U of squares' middles, and their heights."""
    origins = np.array([square.chart.frame.origin for square in squares])
    mug = make_mug(0.0)
    return turns_of(mug, origins), origins[:, 2] / mug.bounds[1, 2]


@pytest.mark.parametrize(("em", "text"), [(20.0, TEXTS[2]), (22.0, TEXTS[0])])
def test_a_text_around_leaves_the_handle_out_and_stands_opposite_of_it(em, text):
    if text == TEXTS[0] and not DEJAVU.exists():
        pytest.skip("DejaVu is not installed")
    squares, boxes = laid(0.0, em, "row", text, around=True)
    check_apart(squares, boxes, em)
    u, v = turns_round(squares)
    assert np.abs((u - HANDLE + 0.5) % 1.0 - 0.5).min() > 0.08
    middle = 0.5 * (u[0] + u[-1]) if u[-1] > u[0] else 0.5 * (u[0] + u[-1] - 1.0)
    assert middle % 1.0 == pytest.approx((HANDLE + 0.5) % 1.0, abs=0.03)
    assert v == pytest.approx(0.5, abs=0.01)


@pytest.mark.long
def test_where_a_text_around_has_its_middle_can_be_said():
    squares, _ = laid(0.0, 16.0, "row", TEXTS[2], around=True, at=(0.4, 0.3))
    u, v = turns_round(squares)
    assert 0.5 * (u[0] + u[-1]) == pytest.approx(0.4, abs=0.01)
    assert v == pytest.approx(0.3, abs=0.02)
    vase = ClosestPoints(load_mesh("vase"))
    two = layout_text(vase, "山高", 30.0, Layout("row", around=True, at=(0.4, 0.5)))
    turns = turns_of(vase.mesh, np.array([one.square.chart.frame.origin for one in two]))
    assert turns == pytest.approx([0.15, 0.65], abs=0.01)


def test_what_keeps_a_text_around_from_fitting_is_named_with_what_would_do():
    with pytest.raises(InputError, match=r"a part of the object \(at 0.75,0.50\) is in") as fault:
        laid(0.0, 30.0, "row", "山高水長" * 2, around=True)
    size = float(re.search(r"expected a size of ([\d.]+) mm", str(fault.value))[1])
    assert len(laid(0.0, size, "row", "山高水長" * 2, around=True)[0]) == 8
    with pytest.raises(InputError, match=r"this size would fit at 0.25,0.5$"):
        laid(0.0, 20.0, "row", "山高水長山", around=True, at=(0.55, 0.5))


@pytest.mark.long
def test_between_handle_and_spout_a_text_has_one_side_of_a_teapot():
    pot = make_teapot()
    surface = ClosestPoints(pot)
    placed = layout_text(surface, "山高水長", 20.0, Layout("row", around=True), LIMITS)
    turns = turns_of(pot, np.array([one.square.chart.frame.origin for one in placed]))
    assert ((turns > 0.28) & (turns < 0.72)).all()
    assert turns.mean() == pytest.approx(0.5, abs=0.02)
    with pytest.raises(InputError, match=r"a part of the object \(at 0\.[27]\d,0\.50\)"):
        layout_text(surface, "山高水長" * 2, 24.0, Layout("row", around=True), LIMITS)


@pytest.mark.skipif(not DEJAVU.exists(), reason="DejaVu is not installed")
def test_lines_around_take_the_one_arc_that_is_free_beside_all_of_them():
    """The upper line alone has the back of the pot, the lower one its front."""
    pot = make_pot_among_balls((0.25, 0.0), (0.75, 0.0), (0.5, 25.0), (0.0, -25.0))
    text = set_text("Hill\nMain", open_font(DEJAVU), Style(), None, "row")
    _, pieces = lay_page(ClosestPoints(pot), text, 12.0, Layout("row", around=True), LIMITS)
    origins = np.array([piece.square.chart.frame.origin for piece in pieces])
    assert origins[:, 2] == pytest.approx(np.repeat([7.0, -7.0], 4), abs=0.1)
    assert 0.1 < np.ptp(turns_of(pot, origins)) + 0.05 < 0.25


@pytest.mark.skipif(not DEJAVU.exists(), reason="DejaVu is not installed")
def test_nothing_stands_where_things_are_in_the_way_all_round_or_it_is_level():
    pot = ClosestPoints(make_pot_among_balls(*((k / 12.0, 0.0) for k in range(12))))
    text = set_text("Hill", open_font(DEJAVU), Style(), None, "row")
    with pytest.raises(InputError, match="a part of it is in the way all round there"):
        lay_page(pot, text, 12.0, Layout("row", around=True, at=(1 / 24, 0.5)), LIMITS)
    mug = ClosestPoints(make_mug(0.0))
    at_front = TextPlace(WritingArea(mug), 10.0, Layout(), LIMITS, place(mug, (0.5, 0.5)))
    assert at_front.is_free(at_front.middle.origin, (0.0, 15.0))
    assert not at_front.is_free(np.array([0.0, 0.0, 4.0]), (0.0,)), "the floor"


def test_where_a_handle_is_in_the_way_is_said_of_the_object():
    (told,) = [line for line in info_lines(ClosestPoints(make_mug(0.0))) if "in the way" in line]
    first, last = map(float, re.findall(r"0\.\d\d", told)[:2])
    assert 0.64 < first < 0.71
    assert 0.79 < last < 0.86
    assert (
        len([one for one in info_lines(ClosestPoints(make_teapot())) if "in the way" in one]) == 2
    )
    vase = ClosestPoints(load_mesh("vase"))
    assert not [line for line in info_lines(vase) if "in the way" in line]


def test_a_row_that_goes_out_of_sight_is_said(caplog):
    surface = SimpleNamespace(source=make_mug(0.0))
    for text, notes in (("山高水長", 1), ("山高", 0)):
        squares, _ = laid(90.0, 24.0, "row", text)
        written = SimpleNamespace(placed=[SimpleNamespace(square=one) for one in squares])
        caplog.clear()
        say_if_hidden(written, surface)
        assert len(caplog.records) == notes
        if notes:
            assert re.search(r"9\d of 2[56]\d mm round: .* about 8\d", caplog.text)
