"""Glyphs: of medians and of KanjiVG, and of fonts where both lack a character."""

from __future__ import annotations

import json
import math
import sys
import unicodedata
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, unary_union

from paint3d.calligraphy.fonts.fallback import set_whole, with_fallback
from paint3d.calligraphy.glyph_sources import KanjiVGLines, load_glyphs, open_glyphs
from paint3d.calligraphy.glyphs import flatten_path, load_glyph
from paint3d.calligraphy.kanjivg import LineStroke, find_kanjivg, parse_lines
from paint3d.calligraphy.stroke_shapes import BODY, ZONE, corners_of, cut_line, shape_strokes
from paint3d.errors import GlyphError, InputError
from tests.support.cases import long_but
from tests.support.fonts import REFERENCE

numbers = st.integers(0, 1000)
points = st.tuples(numbers, numbers)


def area(polygon):
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def write_glyph(folder, text, strokes, medians):
    data = {"strokes": strokes, "medians": medians}
    (folder / f"{text}.json").write_text(json.dumps(data), encoding="utf-8")


def test_straight_path_gives_its_corners():
    polygon = flatten_path("M 0 0 L 10 0 10 5 L 0,5 Z")
    assert polygon.tolist() == [[0, 0], [10, 0], [10, 5], [0, 5]]


def test_closing_point_is_not_repeated():
    assert len(flatten_path("M 0 0 L 10 0 L 10 5 L 0 0 Z")) == 3


@pytest.mark.parametrize("command", ["Q", "C"])
def test_circle_of_curves_has_its_area(command):
    n, r = 8, 400.0
    turn = 2 * math.pi / n
    path = f"M {r} 0 "
    for k in range(n):
        a, b = k * turn, (k + 1) * turn
        end = r * math.cos(b), r * math.sin(b)
        if command == "Q":
            far = r / math.cos(turn / 2)
            controls = [(far * math.cos(a + turn / 2), far * math.sin(a + turn / 2))]
        else:
            h = 4 / 3 * math.tan(turn / 4) * r
            controls = [
                (r * math.cos(a) - h * math.sin(a), r * math.sin(a) + h * math.cos(a)),
                (end[0] + h * math.sin(b), end[1] - h * math.cos(b)),
            ]
        path += command + " " + " ".join(f"{x} {y}" for x, y in [*controls, end]) + " "
    assert area(flatten_path(path + "Z")) == pytest.approx(math.pi * r * r, rel=3e-3)


@given(points, points, points)
@settings(deadline=None, max_examples=40)
def test_flattened_curve_stays_near_the_curve(start, control, end):
    assume(start != end)
    corner = (2000, 2000)
    path = "M {} {} Q {} {} {} {} L {} {} Z".format(*start, *control, *end, *corner)
    polygon = flatten_path(path)
    t = np.linspace(0, 1, 400)[:, None]
    curve = (1 - t) ** 2 * start + 2 * t * (1 - t) * np.array(control) + t**2 * np.array(end)
    a, b = polygon, np.roll(polygon, -1, axis=0)
    along = np.einsum("nsk,sk->ns", curve[:, None] - a, b - a) / np.sum((b - a) ** 2, axis=1)
    foot = a + np.clip(along, 0, 1)[..., None] * (b - a)
    assert np.linalg.norm(curve[:, None] - foot, axis=2).min(axis=1).max() < 0.2


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("", "0 different points"),
        ("M 0 0 L 10 0 Z", "2 different points"),
        ("M 0 0 A 5 5 0 0 1 10 0 Z", "cannot read 'A 5 5"),
        ("L 0 0 L 10 0 L 10 10 Z", "L out of place"),
        ("M 0 0 L 10 0 L 10 10 Z M 1 1 L 2 2 L 3 1 Z", "M out of place"),
        ("M 0 0 M 10 0 L 10 10 Z", "M out of place"),
        ("M 0 0 Q 10 0 10 Z", "Q has 3 numbers"),
        ("1 2 M 0 0", "cannot read '1 2"),
        (None, "expected an SVG path"),
    ],
)
def test_bad_paths_are_refused_with_reason(path, words):
    with pytest.raises(InputError, match=words):
        flatten_path(path, "stroke")


def test_glyph_is_read(tmp_path):
    write_glyph(tmp_path, "一", ["M 0 0 L 10 0 L 10 5 Z"], [[[0, 0], [10, 4]]])
    glyph = load_glyph(tmp_path, "一")
    assert glyph.text == "一"
    assert len(glyph.strokes) == 1
    assert glyph.strokes[0].outline.shape == (3, 2)
    assert glyph.strokes[0].median.tolist() == [[0, 0], [10, 4]]


@pytest.mark.parametrize(
    ("strokes", "medians", "words"),
    [
        (["M 0 0 L 9 0 L 9 9 Z"], [], "as many medians as strokes"),
        (["M 0 0 L 9 0 L 9 9 Z"], [[[0, 0]]], "1 points; expected 2"),
        (["M 0 0 L 9 0 L 9 9 Z"], [[[0, 0, 1]]], "shape"),
        ("M 0 0", [[[0, 0], [1, 1]]], "as many medians"),
    ],
)
def test_broken_glyphs_are_refused(tmp_path, strokes, medians, words):
    write_glyph(tmp_path, "一", strokes, medians)
    with pytest.raises(InputError, match=words):
        load_glyph(tmp_path, "一")


def test_missing_glyph_names_the_character(tmp_path):
    with pytest.raises(InputError, match="no glyph for '一'"):
        load_glyph(tmp_path, "一")


@pytest.mark.parametrize("text", ["", "一二"])
def test_text_must_be_one_character(tmp_path, text):
    with pytest.raises(InputError, match="single character"):
        load_glyph(tmp_path, text)


@pytest.mark.parametrize("content", ["[1, 2]", "{", '{"strokes": []}'])
def test_other_json_is_refused(tmp_path, content):
    (tmp_path / "一.json").write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match="not a glyph"):
        load_glyph(tmp_path, "一")


# -- centre lines ------------------------------------------------------------------------------


HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:kvg="http://kanjivg.tagaini.net" '
    'viewBox="0 0 109 109">'
)
LEVEL = np.array([[100.0, 400.0], [900.0, 420.0]])
FOLD = np.array([[200.0, 700.0], [700.0, 720.0], [680.0, 100.0]])


def svg(*paths):
    return HEAD + "".join(paths) + "</svg>"


def test_a_place_that_cannot_be_looked_at_is_passed_over(monkeypatch):
    known = find_kanjivg()
    monkeypatch.setattr(sys, "path", ["/" + 5000 * "a", *sys.path])
    find_kanjivg.cache_clear()
    assert find_kanjivg() == known


def test_paths_become_lines_in_glyph_units():
    (stroke,) = parse_lines(svg('<path kvg:type="㇐a/㇑" d="M0,109 l109-109"/>'))
    assert stroke.kind == "㇐a"
    assert stroke.line.tolist() == [[0.0, -124.0], [1024.0, 900.0]]
    assert parse_lines(svg('<path d="M1,1 L2,2"/>'))[0].kind == ""


def test_curves_go_on_smoothly():
    (stroke,) = parse_lines(svg('<path d="M10,50c10,-20 20,-20 30,0s20,20 30,0"/>'))
    scale = 1024.0 / 109.0
    assert stroke.line[0] == pytest.approx([10 * scale, 900 - 50 * scale])
    assert stroke.line[-1] == pytest.approx([70 * scale, 900 - 50 * scale])
    way = np.diff(stroke.line, axis=0)
    turn = np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0]))))
    assert turn.max() < 0.2
    absolute = parse_lines(svg('<path d="M10,50C20,30 30,30 40,50S60,70 70,50"/>'))[0].line
    assert absolute == pytest.approx(stroke.line)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<svg", "not XML"),
        (svg(), "no strokes"),
        (svg('<path d=""/>'), "has no length"),
        (svg('<path d="M5,5 L5,5"/>'), "has no length"),
        (svg('<path d="M5,5 Q6,6 7,7"/>'), "cannot read"),
        (svg('<path d="M5,5 C6,6 7,7"/>'), "C has 4 numbers"),
        (svg('<path d="L5,5 6,6"/>'), "out of place"),
        (svg('<path d="M5,5 L6,6 Z"/>'), "out of place"),
    ],
)
def test_broken_files_are_refused(text, words):
    with pytest.raises(InputError, match=words):
        parse_lines(text)


@given(st.floats(0.6, 2.6), st.floats(150.0, 500.0), st.floats(150.0, 500.0), st.floats(-3.0, 3.0))
@settings(deadline=None, max_examples=25)
def test_a_fold_is_cut_at_its_corner(turn, first, second, heading):
    a = first * np.array([np.cos(heading), np.sin(heading)])
    b = a + second * np.array([np.cos(heading - turn), np.sin(heading - turn)])
    segments = cut_line(np.array([[0.0, 0.0], a, b]), 1)
    assert len(segments) == 2
    step = (first + second) / 95.0
    assert segments[0].points[-1] == pytest.approx(a, abs=step)
    assert segments[0].length == pytest.approx(first, abs=2.5 * step)
    assert segments[1].length == pytest.approx(second, abs=2.5 * step)


def test_stations_rise_and_reach_both_ends():
    (segment,) = cut_line(LEVEL, 0)
    at = segment.stations(20.0, 10.0, 15.0)
    assert len(at) == 2 * ZONE + BODY
    assert (np.diff(at) > 0.0).all()
    assert (at[0], at[-1]) == pytest.approx((-10.0, segment.length + 15.0))
    points, lefts = segment.at(at)
    assert points[0][0] < 100.0 < 900.0 < points[-1][0]
    assert np.linalg.norm(lefts, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("kind", "line"), [("㇐", LEVEL), ("㇕", FOLD), ("", LEVEL), ("㇑", LEVEL)]
)
def test_an_outline_holds_its_line(kind, line):
    (stroke,) = shape_strokes([LineStroke(kind, line)])
    shape = Polygon(stroke.outline)
    assert shape.is_valid
    inner = LineString(stroke.median[2:-2])
    assert inner.intersection(shape).length > 0.95 * inner.length
    assert 20.0 < shape.area / LineString(line).length < 140.0


def test_crowded_characters_have_finer_strokes():
    areas = [
        Polygon(shape_strokes([LineStroke("㇐", LEVEL)] * n)[0].outline).area for n in (1, 8, 20)
    ]
    assert areas[0] > areas[1] > areas[2]


def test_a_foot_is_heavier_than_its_beginning():
    """㇏ swells towards its foot; ㇒ thins out."""
    falling = np.array([[300.0, 700.0], [850.0, 100.0]])
    mirrored = falling * [-1, 1] + [1024, 0]
    for kind, line, heavy, fine in (("㇏", falling, 0.75, 0.2), ("㇒", mirrored, 0.2, 0.75)):
        (stroke,) = shape_strokes([LineStroke(kind, line)])
        shape = Polygon(stroke.outline)
        way = LineString(line)
        widths = {
            t: Point(way.interpolate(t, normalized=True)).distance(shape.exterior)
            for t in (0.2, 0.75)
        }
        assert widths[heavy] > 1.15 * widths[fine]


def test_hooked_types_get_a_hook():
    assert (corners_of("㇚"), corners_of("㇐a"), corners_of("㇆v")) == (1, 0, 2)
    line = np.array([[500.0, 800.0], [500.0, 100.0], [470.0, 60.0], [440.0, 90.0]])
    (stroke,) = shape_strokes([LineStroke("㇚", line)])
    assert stroke.outline[:, 0].min() < 430.0
    assert stroke.median[-1][0] < 450.0


def test_the_installed_package_is_found():
    source = open_glyphs(None)
    assert isinstance(source, KanjiVGLines)
    assert find_kanjivg() is not None
    glyph = load_glyphs(source, "永永")["永"]
    assert len(glyph.strokes) == 5
    assert "CC BY-SA 3.0" in source.licence
    words = r"kanjivg has no glyph for '飞' \(U\+98DE\); expected characters that it has"
    with pytest.raises(InputError, match=words):
        load_glyphs(source, "永飞")


def test_a_package_that_is_not_there_is_said(monkeypatch):
    monkeypatch.setattr("paint3d.calligraphy.glyph_sources.find_kanjivg", lambda: None)
    with pytest.raises(InputError, match="pip install kanjivg"):
        open_glyphs(None)


# -- characters that kanjivg lacks -------------------------------------------------------------


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


@pytest.mark.parametrize(("scale", "growth"), long_but([(0.9, -6.0)], [(1.25, 8.0), (0.9, -6.0)]))
def test_characters_are_as_large_and_bold_as_their_neighbours(
    system_fonts, scale: float, growth: float
) -> None:
    system_fonts.add("Test Kai", REFERENCE + "步", scale, growth)
    wanted = measured(SOURCE.load("歩").strokes)
    found = measured(with_fallback(SOURCE, "步").load("步").strokes)
    np.testing.assert_allclose(found[:4], wanted[:4], atol=12.0)
    assert found[4] == pytest.approx(wanted[4], rel=0.1)


def test_a_character_that_no_font_has_is_told(system_fonts) -> None:
    system_fonts.add("Test Kai", "步")
    with pytest.raises(GlyphError, match=r"'囍' \(U\+56CD\).*--font FONT") as found:
        with_fallback(SOURCE, "漫步囍")
    assert found.value.message.fields["characters"] == "囍"


@pytest.mark.parametrize("text", ["س", "，"])
def test_letters_that_join_and_marks_need_a_font_of_the_whole_text(system_fonts, text) -> None:
    """They would stand alone, or as in rows."""
    system_fonts.add("Test Kai", text)
    with pytest.raises(GlyphError, match="--font FONT"):
        with_fallback(SOURCE, text)


def test_a_text_of_letters_that_no_squares_hold_is_set_whole_in_one_font(
    system_fonts, caplog
) -> None:
    system_fonts.add("Alpha Kai", "Mariöowe永")
    system_fonts.add("Beta Serif", "MariöoweL")
    system_fonts.add("Gamma Sans", "MariöoweLш")
    set_text = set_whole(SOURCE, "Maria Löwe", None)
    assert set_text is not None
    assert (set_text.text, set_text.font.name) == ("Maria Löwe", "Beta Serif")
    assert [one.getMessage() for one in caplog.records] == [
        "Maria Löwe is written in the font Beta Serif"
    ]
    for text in ("永和", "步", "Mariaα", "2026"):
        assert set_whole(SOURCE, text, None) is None
    with pytest.raises(GlyphError, match=r"which fonts have.* such as Beta Serif"):
        with_fallback(SOURCE, "Maria Löwe")


def test_letters_stand_in_words_of_a_font_by_hand_where_there_is_one(system_fonts) -> None:
    """Also those that kanjivg has, but not where columns are asked for."""
    assert set_whole(SOURCE, "Lena", None) is None
    system_fonts.add("Alpha Serif", "LenaИван")
    for text in ("Lena", "Иван"):
        assert set_whole(SOURCE, text, "row").font.name == "Alpha Serif"
    system_fonts.add("Beta Script", "Lena")
    assert set_whole(SOURCE, "Lena", None).font.name == "Beta Script"
    assert set_whole(SOURCE, "Иван", None).font.name == "Alpha Serif"
    assert set_whole(SOURCE, "Lena", "columns") is None


def test_a_word_is_one_piece_beside_characters_in_squares(system_fonts, caplog) -> None:
    system_fonts.add("Beta Script", "Lena")
    mixed = set_whole(SOURCE, "生日 Lena\n永", None)
    assert [one.getMessage() for one in caplog.records] == [
        "Lena is written in the font Beta Script"
    ]
    pieces = mixed.compose(math.inf).pieces
    assert [piece.glyph.text for piece in pieces] == [*"生日Lena永"]
    assert [piece.word for piece in pieces] == [(0, 0), (0, 1), *[(0, 2)] * 4, (1, 0)]
    for piece in pieces[:2]:
        assert piece.glyph is SOURCE.load(piece.glyph.text)
    left, lower, right, _ = np.array([piece.box for piece in pieces[:6]]).T
    assert (left[1:] > left[:-1]).all()
    assert right[0] == left[1]
    assert left[2] > right[1] + 200.0, "a space"
    assert lower[2:].min() > lower[0], "letters stand on the line of the squares"
    assert pieces[6].at[1] < pieces[0].at[1] - 1024.0
    assert len({piece.at[1] for piece in mixed.compose(3000.0).pieces}) > 2, (
        "it breaks at the space"
    )


def test_words_beside_squares_stand_as_they_are_read_and_leave_punctuation_to_its_fonts(
    system_fonts, caplog
) -> None:
    system_fonts.add("Beta Script", "LenaéبتL")
    system_fonts.add("Gamma Song", "Lenaé，")
    mixed = set_whole(SOURCE, "生日，Lena", None)
    assert [one.getMessage() for one in caplog.records] == [
        "Lena is written in the font Beta Script",
        "kanjivg lacks characters: ， is taken from Gamma Song",
    ]
    assert [piece.glyph.text for piece in mixed.compose(math.inf).pieces] == [*"生日，Lena"]
    decomposed = unicodedata.normalize("NFD", "山 é")
    assert set_whole(SOURCE, decomposed, None).font.name == "Beta Script"
    for text, seen in (("永 ب ت", "永تب"), ("ب ت 永和", "永和تب")):
        pieces = set_whole(SOURCE, text, None).compose(math.inf).pieces
        assert [piece.glyph.text for piece in pieces] == [*text.replace(" ", "")]
        boxes = sorted((piece.box, piece.glyph.text) for piece in pieces)
        assert "".join(one for _, one in boxes) == seen
        assert all(one[2] <= two[0] for (one, _), (two, _) in pairwise(boxes))


def test_katakana_of_half_width_stand_in_squares_in_their_middle(system_fonts) -> None:
    system_fonts.add("Test Kai", "ｱ", scale=0.5)
    assert set_whole(SOURCE, "ｱｱ", None) is None
    strokes = with_fallback(SOURCE, "ｱ").load("ｱ").strokes
    x = np.concatenate([stroke.outline[:, 0] for stroke in strokes])
    assert x.min() == pytest.approx(256.0, abs=20.0), "in the font it begins where the em does"


def test_words_that_go_around_are_set_in_a_font_and_squares_are_not(system_fonts) -> None:
    assert set_whole(SOURCE, "Maria", None, around=True) is None
    system_fonts.add("Beta Serif", "Maria永和")
    assert set_whole(SOURCE, "Maria", None, around=True) is not None
    assert set_whole(SOURCE, "永和", None, around=True) is None
