"""Centre lines from SVG, their segments, and the outlines that a brush gives them."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon

from paint3d.calligraphy.glyph_sources import KanjiVGLines, load_glyphs, open_glyphs
from paint3d.calligraphy.kanjivg import LineStroke, find_kanjivg, parse_lines
from paint3d.calligraphy.stroke_shapes import BODY, ZONE, corners_of, cut_line, shape_strokes
from paint3d.errors import InputError

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
    with pytest.raises(InputError, match="kanjivg is not installed"):
        open_glyphs(None)
