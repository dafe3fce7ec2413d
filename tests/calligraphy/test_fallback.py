"""Characters that kanjivg lacks, in the forms of a font of the system."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import Polygon, unary_union

from paint3d.calligraphy.fonts.fallback import with_fallback
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.errors import GlyphError
from tests.support.fonts import REFERENCE

SOURCE = open_glyphs(None)


def fonts_taken(text: str) -> set[str]:
    return set(with_fallback(SOURCE, text).characters)


def test_a_text_whose_characters_are_known_needs_no_font(system_fonts) -> None:
    system_fonts.add("Test Kai", "永和步")
    assert with_fallback(SOURCE, "永\n和") is SOURCE


def test_kai_faces_come_first_then_song_faces_then_others(system_fonts) -> None:
    for families, first in (
        (["Alpha Sans Serif", "Beta Sans"], "Alpha Sans Serif"),
        (["Source Serif"], "Source Serif"),
        (["Alpha Ming"], "Alpha Ming"),
        (["AR UKai"], "AR UKai"),
        (["标楷体"], "AR UKai"),
    ):
        for family in families:
            system_fonts.add(family, "步")
        assert fonts_taken("漫步") == {first}


def test_of_a_face_the_forms_are_those_of_the_texts_script(system_fonts) -> None:
    for region in ("HK", "JP", "SC", "TC"):
        system_fonts.add(f"Serif {region}", "飞歲步")
    assert fonts_taken("飞步") == {"Serif SC"}
    assert fonts_taken("歲步") == {"Serif HK"}


def test_one_font_has_all_characters_where_one_does(system_fonts) -> None:
    system_fonts.add("Alpha Kai", "步")
    system_fonts.add("Beta Sans", "步囍")
    assert fonts_taken("步囍") == {"Beta Sans"}
    system_fonts.add("Gamma Song", "飞")
    taken = with_fallback(SOURCE, "步囍飞永")
    assert taken.characters == {"Alpha Kai": "步", "Beta Sans": "囍", "Gamma Song": "飞"}
    assert taken.name == "kanjivg; 步 from Alpha Kai; 囍 from Beta Sans; 飞 from Gamma Song"
    assert "CC BY-SA 3.0" in taken.licence
    assert "Font: Beta Sans" in taken.licence


def measured(strokes) -> np.ndarray:
    """Left, lower, right and upper end of ink, and the mean width of its strokes."""
    ink = unary_union([Polygon(one.outline, one.holes).buffer(0.0) for one in strokes])
    return np.array([*ink.bounds, 2.0 * ink.area / ink.length])


@pytest.mark.parametrize(("scale", "growth"), [(1.25, 8.0), (0.9, -6.0)])
def test_characters_are_as_large_and_bold_as_their_neighbours(
    system_fonts, scale: float, growth: float
) -> None:
    system_fonts.add("Test Kai", REFERENCE + "步", scale, growth)
    wanted = measured(SOURCE.load("歩").strokes)
    found = measured(with_fallback(SOURCE, "步").load("步").strokes)
    np.testing.assert_allclose(found[:4], wanted[:4], atol=10.0)
    assert found[4] == pytest.approx(wanted[4], rel=0.08)


def test_a_character_that_no_font_has_is_told(system_fonts) -> None:
    system_fonts.add("Test Kai", "步")
    with pytest.raises(GlyphError, match=r"'囍' \(U\+56CD\); .* --font FONT, or install") as found:
        with_fallback(SOURCE, "漫步囍")
    assert found.value.characters == "囍"


@pytest.mark.parametrize("text", ["س", "，"])
def test_letters_that_join_and_marks_need_a_font_of_the_whole_text(system_fonts, text) -> None:
    """They would stand alone, or as in rows."""
    system_fonts.add("Test Kai", text)
    with pytest.raises(GlyphError, match="--font FONT"):
        with_fallback(SOURCE, text)
