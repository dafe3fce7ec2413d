"""Strokes in a plain file, and drawings that become such."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, unary_union

from paint3d.calligraphy.page.bands import WIDEST
from paint3d.calligraphy.page.correcting import CorrectedPage
from paint3d.calligraphy.page.page import Page, Photograph, fill_rings
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.calligraphy.page.svg_drawing import load_svg
from paint3d.calligraphy.photo.copying import CopiedSheet, find_photographed_sheet
from paint3d.calligraphy.photo.ink_mask import InkMask
from paint3d.errors import InputError
from tests.support.examples import examples
from tests.support.stroked_drawings import Drawing, draw_strokes, lines_of, read_drawing

pytest.importorskip("svgelements")

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'


def draw(tmp_path, body, head=HEAD):
    file = tmp_path / "a.svg"
    file.write_text(f"{head}{body}</svg>", encoding="utf-8")
    return file


def ink(page):
    """The area of all strokes together, square units."""
    strokes = [stroke for piece in page.pieces for stroke in piece.glyph.strokes]
    return unary_union([Polygon(s.outline, s.holes).buffer(0.0) for s in strokes])


def test_a_stroked_path_is_the_way_itself(tmp_path) -> None:
    body = (
        '<style>.a{fill:none;stroke:#000;stroke-width:2}</style><g transform="scale(2)">'
        '<path class="a" d="M0 0L100 0"/><path class="a" d="M100 50L0 50"/></g>'
    )
    page = load_svg(draw(tmp_path, body))
    first, second = (piece.glyph.strokes[0] for piece in page.pieces)
    assert first.median[0, 0] < first.median[-1, 0]
    assert second.median[0, 0] > second.median[-1, 0]
    assert first.median[0, 1] > second.median[0, 1], "y is upwards"
    width = np.ptp(first.outline[:, 1])
    assert width == pytest.approx(2.0 / 100.0 * 1024.0)


def test_arc_flags_may_stand_without_separators(tmp_path) -> None:
    body = '<path fill="none" stroke="#000" d="M0 0a10 10 0 0110 10"/>'
    one = load_svg(draw(tmp_path, body))
    two = load_svg(draw(tmp_path, body.replace("0 0110 10", "0 0 1 10 10")))
    lines = [page.pieces[0].glyph.strokes[0].median for page in (one, two)]
    np.testing.assert_allclose(*lines)


def test_fill_rules_transforms_and_uses(tmp_path) -> None:
    square = "M0 0h40v40h-40zM10 10h20v20h-20z"
    body = (
        f'<defs><path id="p" d="{square}"/></defs><use xlink:href="#p" fill-rule="evenodd"/>'
        '<g transform="translate(60 0)"><use xlink:href="#p" id="full"/></g>'
    )
    file = draw(tmp_path, body)
    scale = (1024.0 / 100.0) ** 2
    assert ink(load_svg(file)).area == pytest.approx(scale * (1600 - 400 + 1600), rel=0.02)
    alone = load_svg(file, ["full"])
    assert ink(alone).area == pytest.approx(1024.0**2, rel=0.02)
    assert len(alone.pieces[0].glyph.strokes) > 1024.0 / WIDEST, "in bands"


def test_white_covers_what_lies_below_it(tmp_path) -> None:
    body = '<rect width="100" height="10"/><rect fill="white" x="40" width="20" height="10"/>'
    page = load_svg(draw(tmp_path, body))
    assert ink(page).area == pytest.approx(0.8 * 1024.0 * 102.4, rel=0.02)


@pytest.mark.parametrize(
    ("head", "body", "words"),
    [
        ('<!DOCTYPE svg [<!ENTITY a "b">]>' + HEAD, "<g/>", "entities are declared"),
        (HEAD, '<use xlink:href="http://a.b/c.svg#d"/>', "outside of itself"),
        (HEAD, "<style>@import url(a.css);</style>", "outside of itself"),
        (HEAD, '<g id="a"><use xlink:href="#a"/></g>', "refers to itself"),
        (HEAD, "<text>hi</text>", "nothing is filled or stroked"),
        (HEAD, "<g>", "not well-formed"),
        ("<html>", "", "not well-formed|expected svg"),
    ],
)
def test_bad_drawings_are_refused(tmp_path, head, body, words) -> None:
    with pytest.raises(InputError, match=words):
        load_svg(draw(tmp_path, body, head))


def test_uses_cannot_explode(tmp_path) -> None:
    body = '<rect id="a0" width="1" height="1"/>' + "".join(
        f'<g id="a{k}">' + f'<use xlink:href="#a{k - 1}"/>' * 10 + "</g>" for k in range(1, 9)
    )
    with pytest.raises(InputError, match="elements; expected"):
        load_svg(draw(tmp_path, body))


def test_unknown_ids_are_named(tmp_path) -> None:
    with pytest.raises(InputError, match="no id 'root'; it has leaf"):
        load_svg(draw(tmp_path, '<rect id="leaf" width="9" height="1"/>'), ["root"])


def test_bands_of_one_wide_line_vary_as_one_and_a_file_says_so(tmp_path) -> None:
    page = load_svg(
        draw(tmp_path, '<path d="M20 50H180" stroke="black" stroke-width="60" fill="none"/>')
    )
    (piece,) = page.pieces
    assert len(piece.glyph.strokes) > 1
    assert piece.glyph.joined
    save_strokes(page, tmp_path / "a.strokes.json")
    assert load_strokes(tmp_path / "a.strokes.json").pieces[0].glyph.joined


def test_a_file_gives_back_what_was_kept(tmp_path) -> None:
    body = (
        '<circle cx="5" cy="5" r="4" fill="none" stroke="#000"/><rect x="20" width="9" height="1"/>'
    )
    page = load_svg(draw(tmp_path, body))
    file = tmp_path / "a.strokes.json"
    save_strokes(page, file)
    again = load_strokes(file)
    assert (again.source, again.licence) == (page.source, page.licence)
    for one, two in zip(page.pieces, again.pieces, strict=True):
        np.testing.assert_allclose(one.box, two.box, atol=1e-3)
        for a, b in zip(one.glyph.strokes, two.glyph.strokes, strict=True):
            np.testing.assert_allclose(a.outline, b.outline, atol=1e-3)
            np.testing.assert_allclose(a.median, b.median, atol=1e-3)
            assert len(a.holes) == len(b.holes)
    assert len(again.pieces[0].glyph.strokes[0].holes) == 1
    kept = file.read_bytes()
    save_strokes(again, file)
    assert file.read_bytes() == kept


STROKE = {"order": 1, "line": [[0, 0], [9, 0]], "rings": [[[0, -1], [9, -1], [9, 1], [0, 1]]]}
PIECE = {"text": "a", "at": [0, 0], "box": [0, -1, 9, 1], "strokes": [STROKE]}
FILE = {"format": "paint3d strokes 1", "source": "s", "licence": "l", "pieces": [PIECE]}


def test_strokes_are_written_by_their_numbers(tmp_path) -> None:
    other = {**STROKE, "order": 0.5, "line": [[9, 0], [0, 0]], "dryness": [0, 1]}
    file = tmp_path / "a.strokes.json"
    file.write_text(json.dumps({**FILE, "pieces": [{**PIECE, "strokes": [STROKE, other]}]}))
    strokes = load_strokes(file).pieces[0].glyph.strokes
    assert [stroke.median[0, 0] for stroke in strokes] == [9, 0]
    assert strokes[0].dryness == (0.0, 1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "2"}, "expected an object with"),
        ({"pieces": []}, "nothing to write"),
        ({"pieces": [3]}, "piece 1: expected an object with a list named at"),
        ({"pieces": [{**PIECE, "box": [0, 0, 0, 0]}]}, "piece 1: box is"),
        ({"pieces": [{**PIECE, "strokes": [{**STROKE, "rings": []}]}]}, "stroke 1: expected rings"),
        ({"pieces": [{**PIECE, "strokes": [{**STROKE, "line": [[0, 0]]}]}]}, "line has 1 points"),
        ({"pieces": [{**PIECE, "strokes": [{**STROKE, "order": "x"}]}]}, "order is 'x'"),
        ({"pieces": [{**PIECE, "strokes": [{**STROKE, "dryness": [2]}]}]}, "from 0 to 1"),
        ({"licence": 3}, "licence is 3"),
    ],
)
def test_bad_files_are_refused(tmp_path, change, words) -> None:
    file = tmp_path / "a.strokes.json"
    file.write_text(json.dumps({**FILE, **change}), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        load_strokes(file)


def test_rings_are_filled_by_how_often_they_go_around() -> None:
    outer, inner = (np.array([[a, a], [b, a], [b, b], [a, b]], float) for a, b in ((0, 10), (2, 4)))
    assert fill_rings([outer, inner]).area == pytest.approx(100.0)
    assert fill_rings([outer, inner[::-1]]).area == pytest.approx(96.0)
    assert fill_rings([outer, inner], even_odd=True).area == pytest.approx(96.0)
    bow = np.array([[0, 0], [10, 10], [10, 0], [0, 10]], float)
    assert fill_rings([bow]).area == pytest.approx(50.0)


def test_a_file_knows_the_photograph_that_its_strokes_are_from(tmp_path) -> None:
    """By its place seen from the file, so that both can be moved."""
    page = load_svg(draw(tmp_path, '<rect width="9" height="1"/>'))
    corners = np.array([[10.0, 12.5], [400.0, 8.0], [410.0, 300.0], [5.0, 310.0]])
    origin = np.array([0.5, 300.0])
    lies = (300, 400), 0.41, origin
    photo = Photograph(tmp_path / "b" / "x.jpg", corners, *lies, invert=True, digest="5a")
    kept = tmp_path / "a" / "x.strokes.json"
    kept.parent.mkdir()
    save_strokes(replace(page, photograph=photo), kept)
    assert json.loads(kept.read_text())["photograph"]["file"] == "../b/x.jpg"
    (tmp_path / "c").mkdir()
    moved = kept.rename(tmp_path / "c" / "x.strokes.json")
    again = load_strokes(moved).photograph
    assert again.file.resolve() == photo.file.resolve()
    np.testing.assert_allclose(again.corners, corners)
    np.testing.assert_allclose(again.origin, origin)
    assert (again.size, again.per_unit, again.invert) == (photo.size, photo.per_unit, True)
    assert again.digest == "5a"
    assert CorrectedPage.of(load_strokes(moved)).reverse(0).page().photograph is not None


PHOTO = {
    "file": "a.jpg", "corners": [[0, 0], [9, 0], [9, 9], [0, 9]], "size": [9, 9], "per_unit": 1,
    "origin": [0, 9],
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"file": "/etc/passwd"}, "photograph: file is '/etc/passwd'"),
        ({"file": "\\\\host\\share\\a.jpg"}, "expected its place seen from a.strokes.json"),
        ({"file": "C:a.jpg"}, "expected its place"),
        ({"file": ""}, "expected its place"),
        ({"file": 3}, "file is 3; expected text"),
        ({"corners": [[0, 0]]}, "photograph: corners"),
        ({"size": [9, 1e9]}, "photograph: size is 1e"),
        ({"size": [8000, 8000]}, "expected 1 to 3200 pixels"),  # which took 4 GB of memory
        ({"size": [9, 2.5]}, "photograph: size is 2.5"),
        ({"per_unit": 0}, "photograph: per_unit"),
        ({"origin": [0]}, "photograph: origin"),
        ({"sha256": 5}, "photograph: sha256"),
    ],
)
def test_a_photograph_that_cannot_be_is_said(tmp_path, change, words) -> None:
    file = tmp_path / "a.strokes.json"
    file.write_text(json.dumps({**FILE, "photograph": {**PHOTO, **change}}))
    with pytest.raises(InputError, match=re.escape(words)):
        load_strokes(file)


def test_a_photograph_is_found_from_a_folder_that_is_a_link(tmp_path) -> None:
    """`..` leads from where the folder is, not from where its link is."""
    page = load_svg(draw(tmp_path, '<rect width="9" height="1"/>'))
    deep, photos = tmp_path / "deep" / "er", tmp_path / "photos"
    deep.mkdir(parents=True)
    photos.mkdir()
    (photos / "x.jpg").touch()
    (tmp_path / "link").symlink_to(deep)
    photo = Photograph(photos / "x.jpg", np.zeros((4, 2)), (9, 9), 1.0, np.zeros(2))
    save_strokes(replace(page, photograph=photo), tmp_path / "link" / "x.strokes.json")
    assert load_strokes(tmp_path / "link" / "x.strokes.json").photograph.file.is_file()
    assert load_strokes(deep / "x.strokes.json").photograph.file.is_file()


def test_names_that_are_no_utf_8_are_kept(tmp_path) -> None:
    page = load_svg(draw(tmp_path, '<rect width="9" height="1"/>'))
    name = os.fsdecode(b"\xff.jpg")
    photo = Photograph(tmp_path / name, np.zeros((4, 2)), (9, 9), 1.0, np.zeros(2))
    piece = replace(page.pieces[0], glyph=replace(page.pieces[0].glyph, text=name))
    kept = tmp_path / "x.strokes.json"
    save_strokes(Page((piece,), f"永 {name}", "l", photo), kept)
    again = load_strokes(kept)
    assert (again.source, again.pieces[0].glyph.text) == (f"永 {name}", name)
    assert again.photograph.file == tmp_path / name


def test_strokes_beside_the_sheet_are_not_laid_over_it(tmp_path) -> None:
    """As those of another photograph's, or with what cannot be: the view has nothing to show."""
    page = load_svg(draw(tmp_path, '<rect width="9" height="1"/>'))
    (left, lower, right, upper), pixels = page.bounds, np.full((200, 200, 3), 200, np.uint8)
    corners = np.array([[0, 0], [200, 0], [200, 200], [0, 200.0]])
    scale = 180.0 / max(right - left, upper - lower)
    there = scale * np.array([-left, upper])
    for off, fits in (((10.0, 10.0), True), ((-40.0, 10.0), False), ((10.0, 1e300), False)):
        photo = Photograph(tmp_path / "x.jpg", corners, (200, 200), scale, there + off)
        photographed = replace(page, photograph=photo)
        if fits:
            assert find_photographed_sheet(photographed, pixels, 1.0).picture.shape == (200, 200, 3)
            continue
        with pytest.raises(InputError, match="the strokes lie beside the sheet"):
            find_photographed_sheet(photographed, pixels, 1.0)


def test_a_large_photograph_is_kept_by_its_own_pixels(tmp_path) -> None:
    """It is looked at half as large, and may be read in another size next time."""
    page = load_svg(draw(tmp_path, '<rect width="9" height="1"/>'))
    down, across = np.mgrid[:100, :120]
    small = np.stack([2 * across, 2 * down, across + down], axis=-1).astype(np.uint8)
    corners = np.array([[10.0, 10.0], [110.0, 12.0], [108.0, 90.0], [9.0, 88.0]])
    size, unit, origin = (80, 100), 0.02, np.array([9.0, 60.0])
    looked = find_photographed_sheet(
        replace(page, photograph=Photograph(tmp_path, corners, size, unit, origin)), small, 1.0
    )
    none = np.zeros(size, np.float32)
    found = CopiedSheet(
        page, size, unit, origin, picture=looked.picture, corners=corners,
        ink=InkMask(none, none > 0.0, none > 0.0, 1.0, 1.0), red=none,
    )  # fmt: skip
    kept = found.taken_from(tmp_path / "x.jpg", 2.0).page
    np.testing.assert_allclose(kept.photograph.corners, 2.0 * corners)
    np.testing.assert_array_equal(find_photographed_sheet(kept, small, 2.0).picture, looked.picture)
    whole = find_photographed_sheet(kept, small.repeat(2, axis=0).repeat(2, axis=1), 1.0).picture
    assert np.abs(whole.astype(float) - looked.picture).max() < 4.0


# -- drawings whose paths are strokes ----------------------------------------------------------


STROKED = '<svg xmlns="http://www.w3.org/2000/svg" fill="none" stroke="#000" stroke-width="2">'


def drawn(body, *lines):
    return Drawing(f"{STROKED}{body}</svg>", [np.array(line, np.float64) for line in lines])


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
    file.write_text(f"{STROKED}{body}</svg>", encoding="utf-8")
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
    file.write_text(f'{STROKED}<path d="M0 0C0 40 40 40 40 0T90 0"/></svg>', encoding="utf-8")
    (line,) = lines_of(load_svg(file))
    assert (
        np.abs(line[line[:, 0] > line[0, 0] + 0.5 * np.ptp(line[:, 0]), 1] - line[0, 1]).max() < 1
    )


@pytest.mark.parametrize("way", ["h0", "z", "L5 5"])
@pytest.mark.parametrize(("cap", "count"), [("round", 2), ("square", 2), ("butt", 1)])
def test_a_path_without_length_is_a_dot_where_it_has_caps(tmp_path, way, cap, count):
    file = tmp_path / "a.svg"
    body = f'<path d="M0 0h40"/><path stroke-linecap="{cap}" d="M5 5{way}"/>'
    file.write_text(f"{STROKED}{body}</svg>", encoding="utf-8")
    assert len(lines_of(load_svg(file))) == count


def test_a_stroke_is_as_wide_as_its_transform_makes_it(tmp_path):
    file = tmp_path / "a.svg"
    body = '<g transform="rotate(30) scale(3)"><path d="M0 0H100"/></g>'
    file.write_text(f"{STROKED}{body}</svg>", encoding="utf-8")
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
