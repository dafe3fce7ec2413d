"""Drawings whose lengths are relative, and that clip paths cut; paints that brushes have not."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from paint3d.calligraphy.page.svg_drawing import load_svg, svg_shape

SIZED = 'width="200" height="100"'
CLIP = '<clipPath id="c"><rect width="50" height="50"/></clipPath>'
ALL = '<rect width="100" height="100" clip-path="url(#c)"/>'


def drawing(folder: Path, inner: str, outer: str = SIZED) -> Path:
    path = folder / "a.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {outer}>{inner}</svg>', "utf-8")
    return path


def box(folder: Path, inner: str, outer: str = SIZED) -> list[float]:
    """Left, upper, right and lower side of what is inked, y downwards."""
    left, lower, right, upper = svg_shape(drawing(folder, inner, outer)).bounds
    return np.round([left, -upper, right, -lower], 3).tolist()


RECT = '<rect x="{0}" y="{1}" width="{2}" height="{3}"/>'
SHARES = RECT.format("50%", "50%", "50%", "50%")


@pytest.mark.parametrize(
    ("inner", "outer", "wanted"),
    [
        (SHARES, SIZED, [100, 50, 200, 100]),
        (SHARES, f'{SIZED} viewBox="0 0 100 50"', [100, 50, 200, 100]),
        (SHARES, f'{SIZED} viewBox="0 0 50 50" preserveAspectRatio="none"', [100, 50, 200, 100]),
        (f'<svg x="100" width="100" height="50">{SHARES}</svg>', SIZED, [150, 25, 200, 50]),
        (f'<svg x="50%" width="50%" height="50%">{SHARES}</svg>', SIZED, [150, 25, 200, 50]),
        ('<circle cx="50%" cy="50%" r="10%"/>', SIZED, [84.189, 34.189, 115.811, 65.811]),
        ('<ellipse cx="50%" cy="50%" rx="10%" ry="10%"/>', SIZED, [80, 40, 120, 60]),
        ('<path d="M0 50H200" stroke="#000" stroke-width="10%"/>', SIZED, [0, 42.094, 200, 57.906]),
        ('<line x2="100%" y1="50%" y2="50%" stroke="#000"/>', SIZED, [0, 49.5, 200, 50.5]),
        (
            f'<g font-size="10">{RECT.format("1em", "1ex", "2em", "2em")}</g>',
            SIZED,
            [10, 5, 30, 25],
        ),
        (
            f'<g style="font-size:20px">{RECT.format(0, 0, "1em", "1rem")}</g>',
            SIZED,
            [0, 0, 20, 16],
        ),
        (
            f'<g font-size="20"><g font-size="150%">{RECT.format(0, 0, "1em", 9)}</g></g>',
            SIZED,
            [0, 0, 30, 9],
        ),
        (
            '<path d="M0 50H9" font-size="10" style="stroke:#000;stroke-width:1em"/>',
            SIZED,
            [0, 45, 9, 55],
        ),
        (RECT.format(0, 0, "10vw", "10vh"), SIZED, [0, 0, 20, 10]),
        (RECT.format("1in", 0, "1cm", "10mm"), SIZED, [96, 0, 133.795, 37.795]),
    ],
)
def test_lengths_are_shares_of_their_own_sides_and_fonts(tmp_path, inner, outer, wanted) -> None:
    assert box(tmp_path, inner, outer) == pytest.approx(wanted, abs=2e-3)


@pytest.mark.parametrize(
    ("inner", "wanted"),
    [
        (CLIP + ALL, [0, 0, 50, 50]),
        (f'<defs>{CLIP}</defs><g clip-path="url(#c)">{RECT.format(9, 9, 90, 90)}</g>',
         [9, 9, 50, 50]),
        (CLIP + ALL.replace("/>", ' transform="translate(30 0)"/>'), [30, 0, 80, 50]),
        (f'{CLIP}<g transform="translate(30 0) scale(2)">{ALL}</g>', [30, 0, 130, 100]),
        (
            CLIP + '<clipPath id="d"><rect x="20" width="90" height="90"/></clipPath>'
            f'<g style="clip-path: url(#d)">{ALL}</g>',
            [20, 0, 50, 50],
        ),
        (
            '<clipPath id="d"><rect x="20" width="90" height="90"/></clipPath>'
            + CLIP.replace("<clipPath", '<clipPath clip-path="url(#d)"') + ALL,
            [20, 0, 50, 50],
        ),
        (CLIP.replace("<clipPath", '<clipPath transform="translate(9 0)"') + ALL, [9, 0, 59, 50]),
        (
            '<defs><rect id="r" width="9" height="9"/><clipPath id="c">'
            f'<use href="#r" x="5"/></clipPath></defs>{ALL}',
            [5, 0, 14, 9],
        ),
        (f'<defs>{CLIP}<g id="g">{ALL}</g></defs><use href="#g" x="10"/>', [10, 0, 60, 50]),
        (CLIP.replace("<rect ", '<rect fill="none" style="fill:none" ') + ALL, [0, 0, 50, 50]),
        (CLIP.replace('"50" h', '"25%" h') + ALL, [0, 0, 50, 50]),
        ('<clipPath id="c" clip-path="url(#c)"><rect width="9" height="9"/></clipPath>' + ALL,
         [0, 0, 9, 9]),
        (ALL, [0, 0, 100, 100]),  # of what is not there
    ],
)  # fmt: skip
def test_clip_paths_cut(tmp_path: Path, inner: str, wanted: list[float]) -> None:
    assert box(tmp_path, inner) == pytest.approx(wanted, abs=1e-3)


def test_what_is_clipped_away_is_not_there(tmp_path: Path) -> None:
    assert box(tmp_path, f'<clipPath id="c"/>{ALL}{RECT.format(9, 9, 5, 5)}') == [9, 9, 14, 14]


def test_a_rule_of_a_clip_path_leaves_its_hole(tmp_path: Path) -> None:
    ring = '<path clip-rule="evenodd" d="M0 0h20v20h-20zM5 5h10v10h-10z"/>'
    shape = svg_shape(drawing(tmp_path, f'<clipPath id="c">{ring}</clipPath>{ALL}'))
    assert shape.area == pytest.approx(300.0)


def test_a_line_that_is_clipped_is_painted_no_further(tmp_path: Path) -> None:
    line = '<path clip-path="url(#c)" d="M0 20H100" stroke="#000" stroke-width="4"/>'
    (piece,) = load_svg(drawing(tmp_path, CLIP + line)).pieces
    (stroke,) = piece.glyph.strokes
    assert np.ptp(stroke.median[:, 0]) < np.ptp(stroke.outline[:, 0]) + 1.0
    assert np.ptp(stroke.outline[:, 0]) / np.ptp(stroke.outline[:, 1]) == pytest.approx(50 / 4)


@given(
    st.tuples(*[st.integers(-40, 80)] * 2), st.tuples(*[st.integers(5, 90)] * 2),
    st.sampled_from(["", "rotate(90)", "translate(7 3)", "scale(2 .5)"]),
)  # fmt: skip
def test_a_clipped_square_is_what_both_have(tmp_path_factory, at, size, transform) -> None:
    from shapely import affinity
    from shapely import box as rectangle

    path = RECT.format(*at, *size)
    folder = tmp_path_factory.mktemp("svg")
    far = RECT.format(500, 500, 5, 5)
    shape = svg_shape(
        drawing(
            folder,
            f'<clipPath id="c">{path}</clipPath><g transform="{transform}">{ALL}</g>{far}',
        )
    )
    both = rectangle(0, 0, 100, 100).intersection(rectangle(*at, at[0] + size[0], at[1] + size[1]))
    matrices = {
        "": (1, 0, 0, 1, 0, 0), "rotate(90)": (0, -1, 1, 0, 0, 0),
        "translate(7 3)": (1, 0, 0, 1, 7, 3), "scale(2 .5)": (2, 0, 0, 0.5, 0, 0),
    }  # fmt: skip
    wanted = affinity.affine_transform(both, matrices[transform])
    wanted = affinity.scale(wanted, 1, -1, origin=(0, 0)).union(rectangle(500, -505, 505, -500))
    assert shape.symmetric_difference(wanted).area == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("inner", "words"),
    [
        ('<linearGradient id="g"/><rect width="9" height="9" fill="url(#g)"/>', "linearGradient"),
        ('<pattern id="g"/><rect width="9" height="9" style="fill:url(#g)"/>', "pattern"),
        (
            '<clipPath id="c" clipPathUnits="objectBoundingBox"><rect width="1" height="1"/>'
            f"</clipPath>{ALL}",
            "painted whole, without clip-path: url(#c)",
        ),
        ('<rect width="9" height="9" clip-path="inset(1px)"/>', "clip-path: inset(1px)"),
    ],
)
def test_what_is_painted_otherwise_is_told(tmp_path, caplog, inner: str, words: str) -> None:
    caplog.set_level(logging.WARNING)
    svg_shape(drawing(tmp_path, inner))
    assert words in caplog.text


def test_a_gradient_that_nothing_has_is_not_told(tmp_path: Path, caplog) -> None:
    svg_shape(drawing(tmp_path, '<linearGradient id="g"/><rect width="9" height="9"/>'))
    assert caplog.text == ""


@pytest.mark.parametrize("paint", ["url(#lost)", "url(#lost) none"])
def test_a_paint_that_is_not_there_is_what_it_names_instead(tmp_path: Path, paint: str) -> None:
    lost = f'<rect width="90" height="90" fill="{paint}"/>'
    assert box(tmp_path, lost + RECT.format(0, 0, 9, 9)) == [0, 0, 9, 9]
    assert box(tmp_path, lost.replace(paint, "url(#lost) #000")) == [0, 0, 90, 90]
