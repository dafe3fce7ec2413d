"""The strokes of letters: from KanjiVG, from letters of the same shape, or listed."""

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, MultiPolygon

from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.shapes.ductus import known_strokes
from tests.support.found_strokes import as_listed

SOURCE = open_glyphs(None)
GREEK = "ΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩ"
CYRILLIC = "АБВГДЕЖЗИЙКЛМНОПРСТУФХЦЧШЩЪЫЬЭЮЯ"


def test_capitals_and_digits_are_known():
    latin = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
    assert [text for text in latin + GREEK + CYRILLIC if known_strokes(SOURCE, text) is None] == []


def test_small_cyrillic_letters_are_known():
    assert [c for c in CYRILLIC.lower() if known_strokes(SOURCE, c) is None] == []


def test_letters_of_one_shape_are_written_alike():
    for one, two in (("A", "А"), ("P", "Ρ"), ("H", "Н"), ("3", "З")):
        lines = [
            [s.median.tolist() for s in known_strokes(SOURCE, text).strokes] for text in (one, two)
        ]
        assert lines[0] == lines[1]


def test_what_nobody_knows_has_none():
    assert known_strokes(SOURCE, "☂") is None


@given(text=st.sampled_from("ΓΠДЖЦШЫ"), wide=st.floats(60.0, 130.0), thick=st.floats(4.0, 9.0))
@settings(deadline=None, max_examples=70)
def test_a_sans_serif_letter_is_written_by_its_list(text, wide, thick):
    """As many strokes in the same order, each from its beginning, whatever the proportions."""
    glyph = known_strokes(SOURCE, text)
    lines = [stroke.median * [wide, 100.0] for stroke in glyph.strokes]
    ink = shapely.union_all([LineString(line).buffer(thick, cap_style="flat") for line in lines])
    shape = MultiPolygon([part for part in shapely.get_parts(ink) if part.area > 0.0])
    strokes = decompose(shape, template=glyph)
    assert len(strokes) == len(lines)
    for stroke, line in zip(strokes, lines, strict=True):
        assert np.linalg.norm(stroke.median[0] - line[0]) < 3.0 * thick


def test_order_and_direction_are_compared_with_the_list():
    """Two strokes that are swapped, one that runs back, and a dot, which has no direction."""
    letter = known_strokes(SOURCE, "Π").strokes
    wide = [GlyphStroke(one.outline, one.median * [70.0, 100.0] + 9.0) for one in letter]
    assert as_listed(wide, letter).agrees
    assert as_listed([wide[0], wide[2], wide[1]], letter).tau < 1.0
    back = GlyphStroke(wide[1].outline, wide[1].median[::-1])
    found = as_listed([wide[0], back, wide[2]], letter)
    assert not found.agrees
    assert found.direction == 2.0 / 3.0
    dot = [GlyphStroke(wide[0].outline, np.array([[0.0, y], [0.0, y + 1.0]])) for y in (0.0, 90.0)]
    assert as_listed([dot[0], GlyphStroke(dot[1].outline, dot[1].median[::-1])], dot).agrees
