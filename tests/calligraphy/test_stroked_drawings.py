"""Strokes of a drawing are its paths: as many, in the same order, each the same way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon

from paint3d.calligraphy.page.svg_drawing import load_svg
from tests.support.examples import examples
from tests.support.stroked_drawings import Drawing, draw_strokes, lines_of, read_drawing

pytest.importorskip("svgelements")

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" fill="none" stroke="#000" stroke-width="2">'


def drawn(body, *lines):
    return Drawing(f"{HEAD}{body}</svg>", [np.array(line, np.float64) for line in lines])


def assert_exact(read):
    assert (read.too_many, read.out_of_order, read.turned) == (0, 0, 0)
    assert read.off < 0.005


@given(seed=st.integers(0, 2**31))
@settings(deadline=None, max_examples=examples(45))
def test_count_order_and_direction_are_those_of_the_paths(seed):
    assert_exact(read_drawing(draw_strokes(seed, 6)))


def test_what_lies_between_two_that_overlap_keeps_its_place():
    """The third crosses the first; the second lies aside, and was written last."""
    lines = [[(0, 0), (100, 0)], [(300, 300), (320, 300)], [(50, -20), (50, 30)]]
    body = "".join(f'<path d="M{a[0]} {a[1]}L{b[0]} {b[1]}"/>' for a, b in lines)
    assert_exact(read_drawing(drawn(body, *lines)))


def test_pieces_of_what_overlaps_are_laid_by_one_box(tmp_path):
    """So they lie on a bent object as they do on the page, though one is written between them."""
    file = tmp_path / "a.svg"
    body = '<path d="M0 0h100"/><path d="M300 300h20"/><path d="M50-20v50"/>'
    file.write_text(f"{HEAD}{body}</svg>", encoding="utf-8")
    first, between, last = load_svg(file).pieces
    assert first.box == last.box
    assert between.box[0] > first.box[2]


@pytest.mark.parametrize(
    "element",
    [
        '<rect x="30" y="10" width="40" height="20"',
        '<polygon points="30,10 70,10 70,30 30,30"',
        '<path d="M30 10h40v20h-40z"',
    ],
)
def test_a_basic_shape_is_turned_about_the_same_point_as_a_path(element):
    """A rectangle that was turned lay elsewhere, by as much as it was turned."""
    ring = np.array([(30, 10), (70, 10), (70, 30), (30, 30), (30, 10)], np.float64)
    turned = np.stack([-ring[:, 1], ring[:, 0]], axis=1)
    frame = [(-200, 0), (200, 0)]
    body = f'<path d="M-200 0H200"/>{element} transform="rotate(90)"/>'
    assert_exact(read_drawing(drawn(body, frame, turned)))


def test_an_arc_is_sheared():
    angles = np.linspace(0.0, np.pi, 200)
    arc = np.stack([-np.cos(angles), -np.sin(angles)], axis=1) * 50.0
    sheared = arc @ np.array([[1.0, 0.0], [1.0, 1.0]])
    body = '<path d="M-200 9H200"/><path d="M-50 0A50 50 0 0 1 50 0" transform="skewX(45)"/>'
    assert_exact(read_drawing(drawn(body, [(-200, 9), (200, 9)], sheared)))


def test_a_smooth_curve_mirrors_only_its_own_kind(tmp_path):
    """A T after a C is a straight line (SVG 1.1, 8.3.7)."""
    file = tmp_path / "a.svg"
    file.write_text(f'{HEAD}<path d="M0 0C0 40 40 40 40 0T90 0"/></svg>', encoding="utf-8")
    (line,) = lines_of(load_svg(file))
    assert (
        np.abs(line[line[:, 0] > line[0, 0] + 0.5 * np.ptp(line[:, 0]), 1] - line[0, 1]).max() < 1
    )


@pytest.mark.parametrize("way", ["h0", "z", "L5 5"])
@pytest.mark.parametrize(("cap", "count"), [("round", 2), ("square", 2), ("butt", 1)])
def test_a_path_without_length_is_a_dot_where_it_has_caps(tmp_path, way, cap, count):
    file = tmp_path / "a.svg"
    body = f'<path d="M0 0h40"/><path stroke-linecap="{cap}" d="M5 5{way}"/>'
    file.write_text(f"{HEAD}{body}</svg>", encoding="utf-8")
    assert len(lines_of(load_svg(file))) == count


def test_a_stroke_is_as_wide_as_its_transform_makes_it(tmp_path):
    file = tmp_path / "a.svg"
    body = '<g transform="rotate(30) scale(3)"><path d="M0 0H100"/></g>'
    file.write_text(f"{HEAD}{body}</svg>", encoding="utf-8")
    (piece,) = load_svg(file).pieces
    (stroke,) = piece.glyph.strokes
    length = np.linalg.norm(stroke.median[-1] - stroke.median[0])
    assert Polygon(stroke.outline).area == pytest.approx(0.02 * length**2)


def test_the_measure_tells_faults():
    """Strokes that are swapped, turned round, elsewhere and missing are counted."""
    drawing = draw_strokes(3)
    assert_exact(read_drawing(drawing))
    straight = [k for k, line in enumerate(drawing.lines) if len(line) == 2]
    turned = Drawing(drawing.text, list(drawing.lines))
    turned.lines[straight[0]] = turned.lines[straight[0]][::-1]
    assert read_drawing(turned).turned == 1
    swapped = Drawing(drawing.text, [drawing.lines[1], drawing.lines[0], *drawing.lines[2:]])
    assert read_drawing(swapped).out_of_order == 2
    more = Drawing(drawing.text, [*drawing.lines, drawing.lines[0] + 1.0])
    assert read_drawing(more).too_many == -1
    moved = Drawing(drawing.text, list(drawing.lines))
    moved.lines[straight[0]] = moved.lines[straight[0]] + [12.0, -9.0]
    assert read_drawing(moved).out_of_order > 0
