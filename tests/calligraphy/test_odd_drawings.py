"""Drawings with numbers that nobody can paint: refused in one line, or painted without them."""

from __future__ import annotations

import logging
import tracemalloc
import warnings
from pathlib import Path

import pytest
from shapely import LineString, MultiPolygon, Polygon, box

from paint3d.calligraphy.page.svg_drawing import load_svg
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.errors import InputError

BAR = '<rect x="5" y="70" width="60" height="12" id="bar"/>'


@pytest.fixture(autouse=True)
def without_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def drawing(folder: Path, *elements: str) -> Path:
    path = folder / "a.svg"
    inner = "".join(elements)
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{inner}</svg>', "utf-8")
    return path


@pytest.mark.parametrize(
    "element",
    [
        '<rect x="5" y="70" width="60" height="19007199254740993"/>',
        '<path d="M10 10 C 20 20, 40 1e308, 50 10 z"/>',  # its box is told without that point
        '<polyline fill="none" stroke="black" stroke-width="1e99" points="1 1 20,30 40,5"/>',
    ],
)
def test_what_reaches_too_far_is_refused(tmp_path: Path, element: str) -> None:
    with pytest.raises(InputError, match=r"^a\.svg: reaches as far as .*1e\+12 at most$"):
        load_svg(drawing(tmp_path, BAR, element))


def test_an_arc_that_cannot_be_computed_is_refused(tmp_path: Path) -> None:
    arc = f'<path id="arc" d="M10 10 h30 a{"9" * 300} 9 30 1 0 20 9 z"/>'
    with pytest.raises(InputError, match=r"^a\.svg: arc has an arc of no finite points"):
        load_svg(drawing(tmp_path, BAR, arc))


def test_a_long_line_is_cut_at_its_corner_in_little_memory() -> None:
    """All distances between its cells and its points are not there at once: here they were 408 MB,
    at 3,000 widths 14 GB.
    """
    bend = LineString([(0.0, 0.0), (0.0, 250.0), (250.0, 250.0)]).buffer(1.0, join_style="mitre")
    shape = bend.segmentize(1.0)
    decompose(MultiPolygon([box(0, 0, 9, 1)]))  # what is imported does not count
    tracemalloc.start()
    strokes = decompose(MultiPolygon([shape]))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(strokes) == 2
    assert [Polygon(one.outline).area for one in strokes] == pytest.approx([500.0] * 2, rel=0.02)
    assert most < 150e6


HAIRLINE = '<polygon points="90,90 100,60 110,4294967295" id="hair"/>'


def test_a_hairline_is_left_out_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Its line, in steps of its width, had four thousand million points."""
    along = '<rect x="0" y="0" width="4e7" height="4294967295"/>'
    with caplog.at_level(logging.WARNING):
        page = load_svg(drawing(tmp_path, along, HAIRLINE))
    assert len(page.pieces) == 1
    assert "hair: not painted: it is a hairline" in caplog.text
    with pytest.raises(InputError, match="nothing but hairlines"):
        load_svg(drawing(tmp_path, HAIRLINE))


@pytest.mark.parametrize("width", ["1e-320", "1e-18", "1e-9", "1e-4"])
def test_a_line_that_is_a_hairline_is_left_out_and_said(tmp_path, caplog, width: str) -> None:
    """The library of shapes failed at it, or all of the drawing was refused."""
    line = f'<path id="hair" d="M0 0 H100 V50" stroke="black" fill="none" stroke-width="{width}"/>'
    with caplog.at_level(logging.WARNING):
        page = load_svg(drawing(tmp_path, '<rect x="0" y="60" width="90" height="9"/>', line))
    assert len(page.pieces) == 1
    assert "hair: not painted: it is a hairline" in caplog.text
    with pytest.raises(InputError, match="filled or stroked that is more than a hairline"):
        load_svg(drawing(tmp_path, line))


def test_a_line_without_end_is_no_stroke() -> None:
    """Looking for its corners took minutes."""
    bar, endless = box(0, 0, 100, 10), box(0, 20, 30_000, 21)
    assert len(decompose(MultiPolygon([bar, endless]))) == 1
    with pytest.raises(InputError, match="a 20,000th of its length"):
        decompose(MultiPolygon([endless]))


def test_parts_that_are_hairlines_are_no_strokes() -> None:
    thick, thin = box(0, 0, 1000, 10), box(0, 20, 1000, 20 + 1e-3)
    assert len(decompose(MultiPolygon([thick, thin]))) == 1
    with pytest.raises(InputError, match="is a hairline"):
        decompose(MultiPolygon([thin]))


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e999", "NaNpx", "3,5", "abc", "3 zz"])
@pytest.mark.parametrize(
    ("element", "told"),
    [
        ('<path id="p" d="M1 1L9 9" stroke="#000" stroke-width="{}"/>', "path 'p': stroke-width"),
        ('<path d="M1 1L9 9" stroke="#000" style="stroke-width:{}"/>', "path 1: stroke-width"),
        ("<style>.a {{fill:red; stroke-width: {};}}</style>", "style 1: stroke-width"),
        ('<g transform="translate({})"><rect width="9" height="9"/></g>', "g 1: transform"),
        ('<rect width="9" x="{}" height="9"/>', "rect 2: x"),
        ('<circle cx="9" cy="8" r="{}"/>', "circle 1: r"),
        ('<g opacity="{}"/>', "g 1: opacity"),
    ],
)
def test_what_is_no_number_is_named(tmp_path: Path, element: str, told: str, value: str) -> None:
    if value == "3,5" and "transform" in element:
        return
    with pytest.raises(InputError, match=rf"^a\.svg: {told} (is|has) '[^\n]*; expected [^\n]*$"):
        load_svg(drawing(tmp_path, BAR, element.format(value)))


@pytest.mark.parametrize(
    ("element", "told"),
    [
        ('<path d="M1 1L9 nan 3 4z"/>', "path 1: d has 'nan'; expected commands"),
        ('<path d="M1 1L-1e999 3 4 5z"/>', "path 1: d has '-1e999'; expected commands"),
        ('<path d="M10 10L50 10C20 20,40"/>', "path 1: d has 'C20 20,40'; expected 6 numbers"),
        ('<path d="M10 10L50 10L"/>', "path 1: d has 'L'; expected 2 numbers"),
        ('<path d="M10 10A5 5 0 01 9"/>', "path 1: d has 'A5 5 0 01 9'; expected 7 numbers"),
        ('<path d="M1 1L9 9z 4"/>', "path 1: d has 'z 4'; expected 0 numbers"),
        ('<path d="10 10L50 10 9 9z"/>', "path 1: d has '10 10L50 10 9 9z'; expected M first"),
        ('<path d="L50 10 9 9z"/>', "path 1: d has 'L50 10 9 9z'; expected M first"),
        ('<a stroke-width="nan"><path d="M1 1L9 9"/></a>', "a 1: stroke-width is 'nan'"),
        ('<polygon points="1,2 3,4 5;6"/>', "polygon 1: points has ';6'; expected finite"),
        ('<circle r="-3"/>', "circle 1: r is '-3'; expected a length, not less than 0"),
        (
            '<svg preserveAspectRatio="xMid"/>',
            "svg 2: preserveAspectRatio is 'xMid'; expected none,",
        ),
    ],
)
def test_where_a_list_breaks_off_is_named(tmp_path: Path, element: str, told: str) -> None:
    with pytest.raises(InputError, match=rf"^a\.svg: {told}"):
        load_svg(drawing(tmp_path, BAR, element))


@pytest.mark.parametrize(
    "view",
    [
        "nan 0 9 9", "0 inf 9 9", "0 0 1e999 9", "0 0 9 -9", "0 0 0 9", "0 0 9", "0 0 9 9 9",
        "0 0 9px 9", "abc", "0;0;9;9",
    ],
)  # fmt: skip
@pytest.mark.parametrize("tag", ["svg", "symbol"])
def test_a_view_that_shows_nothing_is_named(tmp_path: Path, tag: str, view: str) -> None:
    with pytest.raises(
        InputError, match=rf"^a\.svg: {tag} 'v': viewBox is '{view}'; expected four"
    ):
        load_svg(drawing(tmp_path, BAR, f'<{tag} id="v" viewBox="{view}">{BAR}</{tag}>'))


@pytest.mark.parametrize(
    "element",
    [
        '<svg viewBox=" 0,0 , 9\n9.5e0 " preserveAspectRatio="xMinYMax slice"/>',
        '<svg viewBox="none" x="2em"/>',
        '<path d="M10-20.5.5-3e-2a1 1 0 00.5.5zM1 2H3v4"/>',
        '<g transform=" translate(1,2) rotate(-45 3.5,2)matrix(1 0 0 1-3 4), scale( 2 )"/>',
        '<rect style="stroke-width:.5px!important;fill:#fff" width="10e1mm" height="2"/>',
        '<path stroke-width="var(--a)" d="" opacity=""/>',
        "<style>.a{stroke-width:calc(1px + 2px);}/* stroke-width: abc */</style>",
        '<a:path xmlns:a="urn:other" d="nan"/>',
        '<g transform="none" opacity="50%"/><use width="auto" x="2e0"/>',
        '<g transform="translate(.5.5)matrix(1 0 0 1-3.5.5)"><path d="m1 1-.5.5z"/></g>',
        '<rect style="stroke-width:2px ! IMPORTANT" width="9" height="2"/>',
        '<path d="M1 1A5 5 0 1 0 9 9 5 5 0 015 5a5,5,0,0,1,1,1a.5.5 0 00.5.5H3 4V2z m2 2zZ"/>',
        '<path transform="rotate(45deg)translate(3px,4)" d="none"/>',
    ],
)
def test_numbers_as_others_write_them_are_taken(tmp_path: Path, element: str) -> None:
    assert load_svg(drawing(tmp_path, BAR, element)).pieces
