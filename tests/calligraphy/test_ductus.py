"""The strokes of letters: from KanjiVG, from letters of the same shape, or listed."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shapely import LineString, MultiPolygon, Polygon, box

from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.shapes import decompose as decomposing
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.shapes.dots import dot_among
from paint3d.calligraphy.shapes.ductus import (
    JoinedForm,
    PlacedLetter,
    body_strokes,
    form_of,
    known_strokes,
)
from paint3d.calligraphy.shapes.regions import InkStroke
from paint3d.calligraphy.shapes.transfer import KnownStrokes, order_as_known, register, tangents_of
from paint3d.core.polyline import resample
from tests.support.cases import long_but
from tests.support.examples import examples
from tests.support.found_strokes import as_listed

SOURCE = open_glyphs(None)
GREEK = "ΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩ"
CYRILLIC = "АБВГДЕЖЗИЙКЛМНОПРСТУФХЦЧШЩЪЫЬЭЮЯ"


def test_capitals_and_digits_are_known():
    latin = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
    assert [text for text in latin + GREEK + CYRILLIC if not known_strokes(SOURCE, text)] == []


def test_small_cyrillic_letters_are_known():
    assert [c for c in CYRILLIC.lower() if not known_strokes(SOURCE, c)] == []


def test_letters_of_one_shape_are_written_alike():
    for one, two in (("A", "А"), ("P", "Ρ"), ("H", "Н"), ("3", "З")):
        lines = [
            [s.median.tolist() for s in known_strokes(SOURCE, text)[0].strokes]
            for text in (one, two)
        ]
        assert lines[0] == lines[1]


def test_what_nobody_knows_has_none():
    assert known_strokes(SOURCE, "☂") == ()


@given(text=st.sampled_from("ΓΠДЖЦШЫ"), wide=st.floats(60.0, 130.0), thick=st.floats(4.0, 9.0))
@settings(deadline=None, max_examples=examples(70))
def test_a_sans_serif_letter_is_written_by_its_list(text, wide, thick):
    """As many strokes in the same order, each from its beginning, whatever the proportions."""
    (glyph,) = known_strokes(SOURCE, text)
    lines = [stroke.median * [wide, 100.0] for stroke in glyph.strokes]
    ink = shapely.union_all([LineString(line).buffer(thick, cap_style="flat") for line in lines])
    shape = MultiPolygon([part for part in shapely.get_parts(ink) if part.area > 0.0])
    strokes = decompose(shape, template=glyph)
    assert len(strokes) == len(lines)
    for stroke, line in zip(strokes, lines, strict=True):
        assert np.linalg.norm(stroke.median[0] - line[0]) < 3.0 * thick


def test_order_and_direction_are_compared_with_the_list():
    """Two strokes that are swapped, one that runs back, and a dot, which has no direction."""
    letter = known_strokes(SOURCE, "Π")[0].strokes
    wide = [GlyphStroke(one.outline, one.median * [70.0, 100.0] + 9.0) for one in letter]
    assert as_listed(wide, letter).agrees
    assert as_listed([wide[0], wide[2], wide[1]], letter).tau < 1.0
    back = GlyphStroke(wide[1].outline, wide[1].median[::-1])
    found = as_listed([wide[0], back, wide[2]], letter)
    assert not found.agrees
    assert found.direction == 2.0 / 3.0
    dot = [GlyphStroke(wide[0].outline, np.array([[0.0, y], [0.0, y + 1.0]])) for y in (0.0, 90.0)]
    assert as_listed([dot[0], GlyphStroke(dot[1].outline, dot[1].median[::-1])], dot).agrees


def drawn(lines, thick):
    ink = shapely.union_all([LineString(line).buffer(thick, cap_style="flat") for line in lines])
    return MultiPolygon([part for part in shapely.get_parts(ink) if part.area > 0.0])


def test_serifs_do_not_make_it_another_letter():
    """A Y whose three ends stand on bars: the arms from above, then the stem, as listed."""
    (letter,) = known_strokes(SOURCE, "Y")
    arms = [stroke.median * [1.0, 1.2] for stroke in letter.strokes]
    ends = [arms[0][0], arms[1][0], arms[2][-1]]
    bars = [np.add(end, [[-150.0, 0.0], [150.0, 0.0]]) for end in ends]
    ink = shapely.union_all([drawn(arms, 25.0), drawn(bars, 12.0)])
    strokes = decompose(MultiPolygon(shapely.get_parts(ink).tolist()), template=letter)
    assert as_listed(strokes, letter.strokes).agrees
    main = [s for s in strokes if np.ptp(s.median[:, 1]) > 150.0]
    assert [s.median[0, 1] > s.median[-1, 1] for s in main] == [True] * 3


def test_that_form_counts_which_is_drawn():
    """The g of one storey: around its bowl, then down the stem from above into the tail."""
    forms = known_strokes(SOURCE, "g")
    assert len(forms) == 2
    lines = [stroke.median * [60.0, 100.0] for stroke in forms[1].strokes]
    strokes = decompose(drawn(lines, 4.0), template=forms)
    assert as_listed(strokes, forms[1].strokes).agrees
    assert len(strokes) == 2
    assert np.linalg.norm(strokes[1].median[0] - lines[1][0]) < 12.0


def test_the_a_of_one_storey_is_a_bowl_then_a_stem():
    forms = known_strokes(SOURCE, "a")
    lines = [stroke.median * [60.0, 60.0] for stroke in forms[1].strokes]
    strokes = decompose(drawn(lines, 4.0), template=forms)
    assert as_listed(strokes, forms[1].strokes).agrees
    assert len(strokes) == 2
    assert strokes[0].median[:, 0].min() < 10.0


def test_the_round_e_is_one_way_from_its_top():
    forms = known_strokes(SOURCE, "E")
    (way,) = (stroke.median * [60.0, 100.0] for stroke in forms[1].strokes)
    strokes = decompose(drawn([way], 4.0), template=forms)
    assert [np.sign(np.diff(s.median[[0, -1], 1])[0]) for s in strokes] == [-1.0] * len(strokes)
    assert strokes[0].median[0, 1] > strokes[-1].median[0, 1] or len(strokes) == 1
    assert np.linalg.norm(strokes[0].median[0] - way[0]) < 12.0


@example(leads=31.0, aside=0.0, up=75.0)  # with a spur at the stem's head, next to the dot
@given(leads=st.floats(30.0, 90.0), aside=st.floats(-10.0, 40.0), up=st.floats(75.0, 110.0))
@example(leads=31.0, aside=0.0, up=75.0)
@settings(deadline=None, max_examples=examples(30))
def test_a_dot_comes_after_its_stem_wherever_it_lies(leads, aside, up):
    """An i that is led out far to the right: its box is no longer the stem's."""
    stem = [[18.0, 60.0], [4.0, 10.0], [20.0, 0.0], [20.0 + leads, 35.0]]
    dot = [[aside, up], [aside + 6.0, up + 6.0]]
    strokes = decompose(drawn([stem, dot], 5.0), template=known_strokes(SOURCE, "i"))
    assert strokes[-1].median[:, 1].min() > 65.0
    assert all(stroke.median[:, 1].max() < 65.0 for stroke in strokes[:-1])


def test_the_dot_is_the_smaller_of_two_parts():
    stem = np.array([[0.0, 0.0], [0.0, 9.0]])
    dots = [np.array([[x, 9.0], [x, 9.5]]) for x in (0.0, 2.0)]
    body, small, large = box(0, 0, 4, 90), box(40, 0, 42, 2), box(6, 0, 10, 80)
    assert dot_among([body, small], [stem, dots[0]]) == {1: 1}
    assert dot_among([small, body], [stem, dots[0]]) == {0: 1}
    assert dot_among([body, large], [stem, dots[0]]) == {}, "neither is small"
    assert dot_among([body, small], [stem, *dots]) == {}, "which of them?"
    assert dot_among([body, small, large], [stem, dots[0]]) == {}
    assert dot_among([body, small], [stem]) == {}
    assert dot_among([body, small], [stem, stem + 1.0, dots[0]]) == {}, "it may be a stroke besides"


def test_a_part_beside_a_dot_that_touches_is_not_the_dot():
    """The man of such a character was written last: it is the smaller one of two parts."""
    lines = [
        [[18, 100], [0, 66]], [[9, 82], [9, 20]],
        [[40, 60], [130, 66]], [[80, 100], [88, 40], [130, 0]], [[94, 84], [86, 63]],
    ]  # fmt: skip
    ink, strokes = np.empty((0, 2)), [np.array(line, np.float64) for line in lines]
    shape = drawn(lines, 3.0)
    assert len(shape.geoms) == 2
    known = Glyph("", tuple(GlyphStroke(ink, line) for line in strokes))
    found = decompose(shape, template=[known])
    assert as_listed(found, known.strokes).agrees
    assert len(found) == 5


SMOOTH = [[320.0, 40.0], [200.0, 40.0], [104.0, 4.0]]  # from afar to where the pen is
CORNER = [[104.0, 80.0], [104.0, 4.0]]


@pytest.mark.parametrize(
    ("line", "told", "begins"),
    [
        (SMOOTH, 0.45, -1),
        (SMOOTH, 0.8, 0),
        (CORNER, 0.45, 0),
        (CORNER, 0.1, -1),
        ([[320.0, 80.0], [320.0, 4.0]], 0.1, 0),  # far from the pen
    ],
)
def test_a_doubtful_stroke_begins_where_the_pen_is(line, told, begins):
    """The table's second stroke runs across it, and so tells its direction only so far."""
    line = np.array(line)
    first, second = resample(np.array([[0.0, 0.0], [100.0, 0.0]]), 4.0), resample(line, 4.0)
    along, aside = tangents_of(second), tangents_of(second)[:, ::-1] * [-1.0, 1.0]
    known = KnownStrokes(
        np.concatenate([first, second]),
        np.concatenate([tangents_of(first), told * along + np.sqrt(1.0 - told**2) * aside]),
        np.repeat([0, 1], [len(first), len(second)]),
        np.concatenate([np.linspace(0.0, 1.0, len(part)) for part in (first, second)]),
        2,
        20.0,
    )
    pieces = [(InkStroke(first, Polygon()), 0), (InkStroke(line, Polygon()), 1)]
    assert order_as_known(pieces, known)[1].line[0].tolist() == line[begins].tolist()
    if told > 0.3:  # of letters that are joined along a line the way is known
        along_it = order_as_known(pieces, known, by_start=True)
        assert along_it[1].line[0].tolist() == line[0].tolist()


def test_a_bow_with_a_swash_runs_the_same_way_as_without():
    """At an even pace it was nearer to the bow gone backwards."""
    bow = np.array([[0, 1], [0.6, 1], [0.9, 0.8], [0.9, 0.65], [0.6, 0.55], [0, 0.55]]) * 100.0
    swash = np.array(
        [[15, 55], [-10, 65], [-20, 80], [0, 98], [60, 100], [90, 85], [88, 70], [70, 58]]
    )
    ink = np.empty((0, 2))
    stem = GlyphStroke(ink, np.array([[0.0, 100.0], [0.0, 0.0]]))
    table = [stem, GlyphStroke(ink, bow)]
    assert as_listed([stem, GlyphStroke(ink, swash * 1.0)], table).agrees
    assert not as_listed([stem, GlyphStroke(ink, swash[::-1] * 1.0)], table).agrees


def test_a_way_there_and_back_is_no_course():
    """Forward and backward it is as far from the stroke that it was to be."""
    ink = np.empty((0, 2))
    bar = GlyphStroke(ink, np.array([[0.0, 0.0], [60.0, 0.0]]))
    stem = GlyphStroke(ink, np.array([[30.0, 100.0], [30.0, 0.0]]))
    again = GlyphStroke(ink, np.concatenate([stem.median, stem.median[::-1]]))
    assert as_listed([bar, stem], [bar, stem]).agrees
    assert not as_listed([bar, again], [bar, stem]).agrees
    half = GlyphStroke(ink, stem.median - [0.0, 50.0])  # lies elsewhere, but goes the same way
    assert as_listed([bar, half], [bar, stem]).agrees
    assert not as_listed([bar, GlyphStroke(ink, half.median[::-1])], [bar, stem]).agrees


@pytest.mark.parametrize(
    ("before", "letter", "after", "form"),
    [
        ("", "ب", "", "alone"),
        ("", "ب", "ا", "first"),
        ("ب", "ب", "ب", "middle"),
        ("ب", "ا", "ب", "last"),
        ("ا", "ب", "", "alone"),
        ("ب", "ء", "", "alone"),
        ("", "لا", "م", "alone"),
    ],
)
def test_letters_join_those_that_let_them(before, letter, after, form):
    assert form_of(before, letter, after) == form


def test_the_way_through_joined_letters_leads_to_the_left():
    """From the right of the first box to the left of the last, what is added after it."""
    boxes = [np.array([60.0, 0.0, 100.0, 50.0]), np.array([0.0, -20.0, 60.0, 30.0])]
    way = body_strokes([PlacedLetter("ط", "first", boxes[0]), PlacedLetter("ن", "last", boxes[1])])
    body, stem = (stroke.median for stroke in way.strokes)
    assert body[:, 0].max() > 90.0
    assert body[-1].tolist() == [0.0, 10.0]
    assert stem[0, 1] > stem[-1, 1]
    assert stem[:, 0].min() > 60.0
    assert body_strokes([PlacedLetter("☂", "alone", boxes[0])]) is None


def test_a_slanted_letter_is_found_by_its_slant():
    """The K of KanjiVG, leaned by 31 degrees: laid by its box, its strokes end in each other's."""
    lines = [resample(stroke.median, 20.0, 6) for stroke in known_strokes(SOURCE, "K")[0].strokes]
    leaned = [line @ np.array([[0.6, 0.0], [0.6, 1.0]]) for line in lines]
    tangents = np.concatenate([tangents_of(line) for line in leaned])
    found = register(lines, np.concatenate(leaned), tangents, start="slanted")
    for line, wanted in zip(found, leaned, strict=True):
        assert np.linalg.norm(line[[0, -1]] - wanted[[0, -1]], axis=1).max() < 25.0


def test_strokes_along_one_way_follow_each_other_by_their_starts():
    way = resample(np.array([[1000.0, 0.0], [0.0, 0.0]]), 5.0)
    known = KnownStrokes(
        way, tangents_of(way), np.zeros(len(way), int), np.linspace(0.0, 1.0, len(way)), 1, 50.0
    )
    long, short = (
        InkStroke(np.array([[first, 0.0], [last, 0.0]]), Polygon()) for first, last in
        ((1000.0, 100.0), (800.0, 650.0))
    )  # fmt: skip
    pairs = [(short, None), (long, None)]
    for by_start, wanted in ((True, [1000.0, 800.0]), (False, [800.0, 1000.0])):
        ordered = order_as_known(pairs, known, by_start=by_start)
        assert [float(piece.line[0, 0]) for piece in ordered] == wanted


def joined_ink(form, slant: float = 0.0, thick: float = 1.8) -> MultiPolygon:
    """The ink of a form's lines, slanted."""
    lines = [one.median @ np.array([[70.0, 0.0], [slant, 100.0]]) for one in form.strokes]
    ink = shapely.union_all([LineString(line).buffer(thick) for line in lines])
    return MultiPolygon([part for part in shapely.get_parts(ink) if part.area > 0.0])


@pytest.mark.parametrize(
    ("slant", "text"),
    long_but([(20.0, "f"), (0.0, "k")], product((0.0, 20.0), "bfkr")),
)
def test_a_letter_of_a_joined_hand_is_one_way_to_the_right(text, slant) -> None:
    """Its loops are not torn into a stem and a bow, and its end is not written backwards."""
    forms = known_strokes(SOURCE, text)
    (joined,) = (form for form in forms if isinstance(form, JoinedForm))
    strokes = decompose(joined_ink(joined, slant), template=forms)
    begin, end = joined.strokes[0].median[[0, -1]] @ np.array([[70.0, 0.0], [slant, 100.0]])
    assert np.linalg.norm(strokes[0].median[0] - begin) < 30.0
    assert np.linalg.norm(strokes[-1].median[-1] - end) < 8.0


@pytest.mark.parametrize("text", long_but("frv", "bfkrvw"))
def test_forms_of_joined_hands_leave_other_letters_alone(text) -> None:
    forms = known_strokes(SOURCE, text)
    apart = [form for form in forms if not isinstance(form, JoinedForm)]
    assert 0 < len(apart) < len(forms)
    lines = [one.median * [0.1, 0.1] for one in apart[0].strokes]
    ink = shapely.union_all([LineString(line).buffer(4.0) for line in lines])
    shape = MultiPolygon([part for part in shapely.get_parts(ink) if part.area > 0.0])
    one, two = decompose(shape, template=forms), decompose(shape, template=apart)
    assert [s.median.tolist() for s in one] == [s.median.tolist() for s in two]


@pytest.mark.parametrize(
    ("apart", "joined", "is_joined"),
    [
        (0.30, 0.22, True),
        (0.30, 0.23, False),  # nearer, but not far nearer
        (0.16, 0.10, True),
        (0.14, 0.01, False),  # what is set apart is near enough: nothing else is looked at
    ],
)
def test_a_joined_form_counts_where_it_lies_far_nearer(
    monkeypatch, apart, joined, is_joined
) -> None:
    """By how far both lie from the ink's lines, in widths; a way so loose comes near to much."""
    forms = known_strokes(SOURCE, "b")
    own = {id(stroke.median): form for form in forms for stroke in form.strokes}
    asked = []

    def laid(_, lines) -> SimpleNamespace:
        form = own[id(lines[0])]
        asked.append(form)
        return SimpleNamespace(
            fit=0, away=joined if isinstance(form, JoinedForm) else apart, known=form
        )

    monkeypatch.setattr(decomposing, "_lay_forms", laid)
    best = vars(decomposing)["_best_form"]([], forms)
    assert isinstance(best.known, JoinedForm) == is_joined
    assert any(isinstance(form, JoinedForm) for form in asked) == (apart > 0.15)
