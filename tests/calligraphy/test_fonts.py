"""Text in fonts: its direction, its lines, its glyphs, and the pieces they become."""

from __future__ import annotations

import math
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from paint3d.calligraphy.fonts import font_file
from paint3d.calligraphy.fonts.font_file import SystemFont, open_font
from paint3d.calligraphy.fonts.shaping import Shaper, Style, base_level, levels_of, visual_order
from paint3d.calligraphy.fonts.typesetting import (
    FontText,
    bodies_of,
    break_line,
    has_words,
    set_text,
)
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.optional_packages import import_optional
from paint3d.calligraphy.page import laying
from paint3d.calligraphy.page.laying import lay_page
from paint3d.calligraphy.page.page import Piece
from paint3d.calligraphy.shapes.ductus import known_strokes
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from scripts.fuzz.copied import COPIED
from tests.support.cases import long_but
from tests.support.found_strokes import as_listed

pytest.importorskip("uharfbuzz")
pytest.importorskip("fontTools")


@cache
def dejavu():
    places = [Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")]
    try:
        import matplotlib

        places.append(Path(matplotlib.get_data_path(), "fonts/ttf/DejaVuSans.ttf"))
    except ImportError:
        pass
    found = [place for place in places if place.exists()]
    if not found:
        pytest.skip("DejaVu Sans is not there")
    return open_font(found[0])


def texts(text, order="row", room=math.inf, **style):
    page = set_text(text, dejavu(), Style(**style), None, order).compose(room)
    return [piece.glyph.text for piece in page.pieces]


@pytest.mark.parametrize(
    ("text", "levels"),
    [
        ("ab", "00"),
        ("אב", "11"),
        ("אב 12", "11122"),
        ("ab אב cd", "00011000"),
        ("אב ab 3.5", "111222222"),
        ("a (b)", "00000"),
        ("سلام 12", "1111122"),
    ],
)
def test_levels_of_mixed_lines(text, levels) -> None:
    assert "".join(map(str, levels_of(text, base_level(text)))) == levels


def test_runs_are_put_in_visual_order() -> None:
    assert visual_order([0, 1, 0]) == [0, 1, 2]
    assert visual_order([1, 2, 1]) == [2, 1, 0]
    assert visual_order([0, 1, 2, 1]) == [0, 3, 2, 1]


def test_lines_are_broken_between_words_and_ideographs() -> None:
    text = "one two-three"
    assert break_line(text, [1.0] * len(text), 8) == ["one two-", "three"]
    assert break_line(text, [1.0] * len(text), 3) == ["one", "two-", "three"]
    assert break_line("永和。九年", [1.0] * 5, 2) == ["永", "和。", "九年"]
    assert break_line("永「和九」", [1.0] * 5, 2) == ["永", "「和", "九」"]


def test_letters_stand_on_their_baseline_in_reading_order() -> None:
    page = set_text("Ag", dejavu(), Style(), None, None).compose(math.inf)
    first, second = page.pieces
    assert [first.glyph.text, second.glyph.text] == ["A", "g"]
    assert first.at[0] < second.at[0]
    assert first.at[1] == pytest.approx(second.at[1]), "boxes hang on the middle of the line"
    lowest = [min(s.outline[:, 1].min() for s in p.glyph.strokes) for p in page.pieces]
    assert lowest[0] == pytest.approx(0.0, abs=1.0)
    assert lowest[1] < -150.0


def test_marks_follow_their_body() -> None:
    strokes = set_text("i", dejavu(), Style(), None, None).compose(math.inf).pieces[0].glyph.strokes
    highest = [stroke.outline[:, 1].max() for stroke in strokes]
    assert len(strokes) == 2
    assert highest[0] < highest[1], "the dot is last"


def test_arabic_is_joined_and_runs_to_the_left() -> None:
    page = set_text("سلام", dejavu(), Style(), None, None).compose(math.inf)
    assert [piece.glyph.text for piece in page.pieces] == ["سلا", "م"]
    assert page.pieces[0].at[0] > page.pieces[1].at[0]


def test_joined_letters_are_written_along_the_line() -> None:
    """The lam is taller than the qaf on its right, and comes after it all the same."""
    (word,) = set_text("قلم", dejavu(), Style(), None, None).compose(math.inf).pieces
    lines = [stroke.median for stroke in word.glyph.strokes]
    tallest = max(range(len(lines)), key=lambda k: lines[k][:, 1].max() - lines[k][:, 1].min())
    loop = max(range(len(lines) - 2), key=lambda k: lines[k][0, 0])  # the two dots come last
    assert loop < tallest
    assert all(line[:, 1].min() > 550.0 for line in lines[-2:])


def test_words_of_another_direction_run_their_own_way() -> None:
    page = set_text("ab אב", dejavu(), Style(), None, None).compose(math.inf)
    assert [piece.glyph.text for piece in page.pieces] == ["a", "b", "א", "ב"]
    x = [piece.at[0] for piece in page.pieces]
    assert x[0] < x[1] < x[3] < x[2]


def test_columns_run_down_and_lines_break_to_the_room() -> None:
    page = set_text("ab", dejavu(), Style(), None, "columns").compose(math.inf)
    assert page.pieces[0].at[1] > page.pieces[1].at[1]
    text = FontText("ab cd", dejavu())
    whole, broken = text.compose(math.inf), text.compose(1500.0)
    assert whole is not broken
    assert text.compose(1e9) is whole
    assert broken.pieces[2].at[1] < broken.pieces[0].at[1]
    assert broken.pieces[0].glyph is whole.pieces[0].glyph


def test_features_are_heeded() -> None:
    shaped = {on: len(Shaper(dejavu(), Style({"liga": on})).shape("fi")) for on in (0, 1)}
    assert shaped == {0: 2, 1: 1}


def test_pieces_lie_level_and_apart_as_on_the_page() -> None:
    surface = ClosestPoints(load_mesh("vase"))
    page, placed = lay_page(surface, FontText("HH HH", dejavu()), 12.0)
    origins = np.array([piece.square.chart.frame.origin for piece in placed])
    assert np.ptp(origins[:, 2]) < 0.2
    ways = np.linalg.norm(np.diff(origins, axis=0), axis=1)
    wanted = 12.0 / 1024.0 * np.diff([piece.at[0] for piece in page.pieces])
    np.testing.assert_allclose(ways, wanted, rtol=0.05)


def test_words_go_around_whole_and_evenly_as_often_as_there_is_room() -> None:
    surface = ClosestPoints(load_mesh("vase"))
    text, em, layout = FontText("Hi hello", dejavu()), 45.0, Layout(around=True)
    page, placed = lay_page(surface, text, em, layout)
    origins = np.array([piece.square.chart.frame.origin for piece in placed])
    turn = np.unwrap(np.arctan2(origins[:, 1], origins[:, 0]))
    radius = np.linalg.norm(origins[:, :2], axis=1).mean()
    boxes = np.array([piece.box for piece in page.pieces])
    copies, left = divmod(len(placed), len(boxes))
    assert left == 0
    length = em * (0.5 + (boxes[:, 2].max() - boxes[:, 0].min()) / 1024.0)
    assert copies == pytest.approx(2.0 * np.pi * radius / length - 0.5, abs=0.5)
    middles = radius * turn.reshape(copies, -1)
    halves = 0.5 * em / 1024.0 * (boxes[:, 2] - boxes[:, 0])
    gaps = []
    for first, last in ((0, 2), (2, len(boxes))):
        steps = em / 1024.0 * np.diff([piece.at[0] for piece in page.pieces[first:last]])
        for copy in middles:
            np.testing.assert_allclose(np.diff(copy[first:last]), steps, rtol=0.05)
    for copy, after in zip(middles, np.roll(middles, -1, axis=0), strict=True):
        gaps.append(copy[2] - halves[2] - copy[1] - halves[1])
        gaps.append((after[0] - halves[0] - copy[-1] - halves[-1]) % (2.0 * np.pi * radius))
    space = em / 1024.0 * (boxes[2, 0] - boxes[1, 2])
    np.testing.assert_allclose(np.array(gaps[::2]) - space, gaps[0] - space, atol=0.5)
    np.testing.assert_allclose(np.array(gaps[1::2]) - 0.5 * em, gaps[0] - space, atol=1.0)
    front = 0.5 * (middles[:, 0] - halves[0] + middles[:, -1] + halves[-1])
    assert np.abs(np.sin(0.5 * (front / radius + 0.5 * np.pi))).min() < 0.02


def test_a_text_too_long_to_go_around_says_how_long_it_is() -> None:
    surface = ClosestPoints(load_mesh("vase"))
    with pytest.raises(InputError, match=r"mm around; expected no less than \d+ mm"):
        lay_page(surface, FontText("H" * 30, dejavu()), 45.0, Layout(around=True))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Hi", True),
        ("A 永", False),
        ("永和九年", False),
        ("永 ab", True),
        ("سلام", True),
        ("ab\n永", True),
    ],
)
def test_words_are_of_letters_that_stand_in_no_squares(text, words) -> None:
    assert has_words(text) is words


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: FontText("a永b", dejavu()), r"no glyph for '永' \(U\+6C38\)"),
        (lambda: FontText(" ", dejavu()), "the text is empty"),
        (lambda: FontText("a", dejavu(), Style(direction="up")), "direction is 'up'"),
        (lambda: open_font("nowhere.ttf"), "no such file"),
        (lambda: open_font(__file__), "not a font"),
        (lambda: open_font(dejavu().path, 3), "no face 3"),
        (lambda: open_font(dejavu().path, 0, {"wght": 700.0}), "no axis 'wght'"),
    ],
)
def test_what_cannot_be_written_is_said(make, words) -> None:
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        ("uharfbuzz", r"need uharfbuzz, which is not installed \(pip install uharfbuzz\)"),
        ("skimage.measure", r"need skimage, which .* \(pip install 'paint3d\[hand\]'\)"),
    ],
)
def test_a_package_that_is_missing_is_said_with_how_to_get_it(monkeypatch, missing, words) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(InputError, match=words):
        import_optional(missing)


def test_a_table_without_a_name_is_no_fault(tmp_path) -> None:
    """A damaged directory may name a table by letters that are none."""
    data = dejavu().path.read_bytes()
    head = 12 + 16 * int.from_bytes(data[4:6], "big")
    last = data[head - 16 : head - 12]
    assert max(data[k : k + 4] for k in range(12, head, 16)) == last
    renamed = data[:head].replace(last, b"\xff" + last[1:]) + data[head:]
    (tmp_path / "a.ttf").write_bytes(renamed)
    opened = open_font(tmp_path / "a.ttf")
    assert opened.outline(opened.font.get_nominal_glyph(ord("a"))).area > 0.0
    for table, words in ((b"glyf", "is without outlines"), (b"maxp", "damaged: face 0 has no gl")):
        without = renamed[:head].replace(table, table[:3] + b"~") + data[head:]
        (tmp_path / "b.ttf").write_bytes(without)
        with pytest.raises(InputError, match=words):
            open_font(tmp_path / "b.ttf")


def test_an_axis_without_a_name_is_said(tmp_path) -> None:
    ((_, data),) = [one for one in COPIED["font"].seeds() if b"fvar" in one[1]]
    assert data.count(b"wght") == 1
    (tmp_path / "a.ttf").write_bytes(data)
    assert open_font(tmp_path / "a.ttf", 0, {"wght": 650.0}).face.axis_infos
    (tmp_path / "a.ttf").write_bytes(data.replace(b"wght", b"w\xffht"))
    with pytest.raises(InputError, match="damaged: an axis has no name"):
        open_font(tmp_path / "a.ttf", 0, {"wght": 650.0})


@pytest.mark.parametrize("text", ["i", "j"])
def test_a_dotted_letter_is_its_body_and_its_dot(text) -> None:
    """The lines of a known letter are laid over body and mark together, not over each alone."""
    page = set_text(text, dejavu(), Style(), open_glyphs(None), "row").compose(math.inf)
    body, dot = page.pieces[0].glyph.strokes
    assert np.ptp(body.outline[:, 1]) > 4.0 * np.ptp(dot.outline[:, 1])
    assert body.median[0, 1] > body.median[-1, 1]
    assert dot.outline[:, 1].min() > body.outline[:, 1].max()


def strokes_of(text):
    """The strokes of a text's first piece, where they stand on the line."""
    source = open_glyphs(None)
    piece = set_text(text, dejavu(), Style(), source, None).compose(math.inf).pieces[0]
    return piece.glyph.strokes


def turn_of(line):
    """Twice the area that a line goes around, negative with the clock."""
    x, y = line.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_a_nine_begins_with_its_ring() -> None:
    """Straight on through its junction the tail would lead up into the ring."""
    forms = known_strokes(open_glyphs(None), "9")
    strokes = strokes_of("9")
    assert as_listed(strokes, *(form.strokes for form in forms)).agrees
    assert turn_of(strokes[0].median) > 0.0
    ends = strokes[-1].median
    assert ends[-1, 1] < ends[0, 1]
    assert ends[-1, 0] < ends[0, 0]


@pytest.mark.parametrize("letter", ["و", "ف", "ق"])
def test_heads_of_arabic_letters_go_with_the_clock(letter) -> None:
    """Around the head, then into the tail, which ends on the left; the dots come after it."""
    body, *dots = strokes_of(letter)
    head = body.median[body.median[:, 1] > np.median(body.outline[:, 1])]
    assert turn_of(head) < 0.0
    assert body.median[-1, 0] < body.median[0, 0]
    assert all(dot.median[:, 1].min() > body.median[0, 1] for dot in dots)


def test_a_joined_alef_goes_up_and_a_stem_is_added_last() -> None:
    alef = max(strokes_of("با"), key=lambda stroke: float(np.ptp(stroke.median[:, 1])))
    assert alef.median[-1, 1] > alef.median[0, 1]
    body, stem = strokes_of("ط")
    assert np.ptp(stem.median[:, 0]) < 0.1 * np.ptp(stem.median[:, 1])
    assert stem.median[0, 1] > stem.median[-1, 1]
    assert turn_of(body.median) < 0.0


def crowded(text, by):
    """The bodies of two letters that lie nearer than the font has them, glyph units."""
    glyphs = Shaper(dejavu(), Style()).shape(text)
    second = max(one.cluster for one in glyphs)
    moved = [one._replace(x=one.x + by * (one.cluster == second)) for one in glyphs]
    return bodies_of(moved, dejavu())


@pytest.mark.parametrize(("text", "n_marks"), [("ري", 2), ("رب", 1), ("وج", 1), ("زپ", 3)])
@pytest.mark.parametrize("by", range(0, 400, 40))
def test_dots_stay_their_own_letters_whatever_they_touch(text, n_marks, by) -> None:
    """The tail of a letter may run through the dots below the next one."""
    bodies = crowded(text, by)
    own = crowded(text, 0)[-1].parts[1:]
    last = bodies[-1]
    assert len(last.parts) - 1 >= n_marks
    found = sorted(round(part.area, 3) for part in last.parts[1:])
    for part in own:
        assert round(part.area, 3) in found
    if len(bodies) == 2:  # not so near that the letters themselves touch
        assert len(last.parts) - 1 == n_marks
        assert text[1] in "".join(text[one.cluster] for one in last.glyphs)


@pytest.mark.parametrize(
    ("letter", "rows"),
    [
        ("ت", [2]),
        ("ي", [2]),
        ("ق", [2]),
        ("ث", [2, 1]),
        ("ش", [2, 1]),
        ("پ", [2, 1]),
        ("چ", [2, 1]),
    ],
)
def test_dots_come_from_the_right_and_the_nearest_to_the_letter_first(letter, rows) -> None:
    strokes = strokes_of(letter)
    dots = [stroke.median.mean(axis=0) for stroke in strokes[-sum(rows) :]]
    body = np.concatenate([stroke.median for stroke in strokes[: -sum(rows)]]).mean(axis=0)
    away = [abs(dot[1] - body[1]) for dot in dots]
    assert dots[0][0] > dots[1][0] + 50.0
    assert away[0] == pytest.approx(away[1], abs=1.0)
    assert all(distance > away[0] + 50.0 for distance in away[2:])


def test_the_dots_of_a_latin_letter_come_from_the_left() -> None:
    dots = [stroke.median.mean(axis=0) for stroke in strokes_of("ü")[-2:]]
    assert dots[0][0] < dots[1][0]


@pytest.mark.parametrize("packing", ["woff", "woff2"])
def test_web_fonts_are_read(tmp_path, packing) -> None:
    from fontTools.subset import Subsetter
    from fontTools.ttLib import TTFont

    if packing == "woff2":
        pytest.importorskip("brotli")
    font, few = TTFont(dejavu().path), Subsetter()  # all of it takes seconds to pack
    few.populate(text="an")
    few.subset(font)
    font.cfg["fontTools.ttLib.tables.otBase:USE_HARFBUZZ_REPACKER"] = False  # old ones warn
    font.flavor = packing
    font.save(tmp_path / f"a.{packing}")
    page = set_text("an", open_font(tmp_path / f"a.{packing}"), Style(), None, "row")
    assert [piece.glyph.text for piece in page.compose(math.inf).pieces] == ["a", "n"]


@pytest.mark.parametrize("order", long_but(["columns"], ["row", "columns"]))
def test_what_is_far_too_long_is_refused_before_it_is_set(monkeypatch, order) -> None:
    """Ten thousand letters are told by their advances: no glyph is placed or taken apart."""

    def nothing(*_):
        raise AssertionError("it is set")

    monkeypatch.setattr(FontText, "_set_lines", nothing)
    text = "".join(f"{word:b} ".replace("0", "o").replace("1", "l") for word in range(1, 1200))
    assert len(text) > 10_000
    plane = ClosestPoints(load_mesh("plane"))
    with pytest.raises(
        InputError, match=r"the text is \d+,\d+ mm long at this size, which does not"
    ):
        lay_page(plane, set_text(text, dejavu(), Style(), None, order), 40.0)


def test_few_boxes_are_laid_of_a_page_that_does_not_fit(monkeypatch) -> None:
    """A page is broken and moved until it fits; where it does not, its edges show that."""
    laid, measured = [], []
    lay_squares, box = laying.lay_squares, Piece.box.fget

    def counted(surface, frames, *given):
        laid.extend(frames)
        return lay_squares(surface, frames, *given)

    def seen(piece):
        measured.append(piece)
        return box(piece)

    monkeypatch.setattr(laying, "lay_squares", counted)
    monkeypatch.setattr(Piece, "box", property(seen))
    lengths = np.random.default_rng(4).integers(1, 7, 18)
    text = set_text(" ".join("on" * k for k in lengths), dejavu(), Style(), None, "row")
    page, placed = lay_page(ClosestPoints(load_mesh("sphere")), text, 16.0)
    assert len(placed) == len(page.pieces) > 80
    assert len(laid) < 1.5 * len(placed)
    assert len(measured) < 20 * len(placed)


@pytest.mark.parametrize("order", ["row", "columns"])
@pytest.mark.parametrize("text", ["an", "a few words that are broken", "one\ntwo\nthree"])
def test_a_page_is_no_smaller_than_its_advances_say(text, order) -> None:
    made = set_text(text, dejavu(), Style(), None, order)
    for room in (math.inf, 4096.0, 2048.0):
        left, lower, right, upper = made.compose(room).bounds
        across = right - left if order == "columns" else upper - lower
        assert made.least_size(room)[1] <= across + 1.0


def test_a_letter_whose_glyph_is_empty_is_missing(tmp_path, monkeypatch) -> None:
    """Brush fonts list thousands of characters that they never drew."""
    from fontTools.fontBuilder import FontBuilder
    from fontTools.pens.ttGlyphPen import TTGlyphPen

    square, nothing = TTGlyphPen(None), TTGlyphPen(None)
    square.moveTo((100, 0))
    for point in ((600, 0), (600, 500), (100, 500)):
        square.lineTo(point)
    square.closePath()
    build = FontBuilder(1000)
    names = [".notdef", "A", "B", "space", "filler"]
    build.setupGlyphOrder(names)
    build.setupCharacterMap(
        {0x41: "A", 0x42: "B", 0x20: "space", 0x3164: "filler", 0x2800: "filler"}
    )
    build.setupGlyf({name: (square if name == "A" else nothing).glyph() for name in names})
    build.setupHorizontalMetrics(dict.fromkeys(names, (700, 0)))
    build.setupHorizontalHeader(ascent=800, descent=-200)
    build.setupNameTable({"familyName": "Half", "styleName": "Regular"})
    build.setupOS2()
    build.setupPost()
    build.save(tmp_path / "half.ttf")
    font = open_font(tmp_path / "half.ttf")
    font.check_has("A \u3164\u2800A")  # a sign may be empty: Braille's blank
    with pytest.raises(InputError, match=r"no glyph for 'B' \(U\+0042\);"):
        font.check_has("AB")
    mine = SystemFont("Half", "Regular", 0, tmp_path / "half.ttf")
    gone = SystemFont("Gone", "Regular", 0, tmp_path / "gone.ttf")
    monkeypatch.setattr(font_file, "fonts_with", lambda _: [mine, gone])
    with pytest.raises(InputError, match="; try another font"):  # they list it, too
        font.check_has("AB")
    monkeypatch.setattr(font_file, "list_fonts", lambda _: [mine, gone])
    assert font_file.fonts_that_draw("A \u200d\tA") == [mine], "these ask for no ink"
    assert font_file.fonts_that_draw("AB") == []
    assert font_file.fonts_that_draw("") == [mine, gone]
