import json
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from paint3d.calligraphy.glyphs import flatten_path, load_glyph
from paint3d.errors import InputError

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
