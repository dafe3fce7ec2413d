"""Drawings lie where what refers to them says; symbols, masks and markers are no part of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from paint3d.calligraphy.page.svg_drawing import svg_shape

SQUARE = '<rect x="2" y="2" width="6" height="6"/>'
SYMBOL = f'<symbol id="s" viewBox="0 0 10 10">{SQUARE}</symbol>'


def inked(folder: Path, *elements: str, view: str = "0 0 100 100") -> list[list[float]]:
    """The boxes of what a drawing inks, from the left: left, upper, right, lower side."""
    path = folder / "a.svg"
    inner = "".join(elements)
    size = 'width="100" height="100"'
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}" {size}>{inner}</svg>', "utf-8"
    )
    boxes = [(a, -d, c, -b) for a, b, c, d in (g.bounds for g in svg_shape(path).geoms)]
    return np.round(sorted(boxes), 6).tolist()


@pytest.mark.parametrize("tag", ["symbol", "mask", "marker", "defs", "clipPath"])
def test_what_is_there_to_be_referred_to_is_not_painted(tmp_path: Path, tag: str) -> None:
    hidden = f'<{tag} id="k"><rect x="50" y="50" width="9" height="9"/></{tag}>'
    assert inked(tmp_path, SQUARE, hidden) == [[2, 2, 8, 8]]


def test_a_symbol_is_as_large_as_each_use_of_it(tmp_path: Path) -> None:
    """Six tenths of each use, at its own place; the second is as high as wide, in its middle."""
    uses = (
        '<use href="#s" x="10" y="20" width="10" height="10"/>'
        '<use href="#s" x="40" width="20" height="40"/>'
        '<use href="#s" transform="translate(70 0) scale(2)" x="1" y="5" width="5" height="5"/>'
    )
    assert inked(tmp_path, SYMBOL, uses) == [
        [12, 22, 18, 28],
        [44, 14, 56, 26],
        [74, 12, 80, 18],
    ]


def test_a_use_that_says_no_size_is_the_symbols_or_the_drawings_own(tmp_path: Path) -> None:
    assert inked(tmp_path, SYMBOL, '<use href="#s"/>') == [[20, 20, 80, 80]]
    sized = SYMBOL.replace("viewBox", 'width="20" height="20" viewBox')
    assert inked(tmp_path, sized, '<use href="#s"/>') == [[4, 4, 16, 16]]
    assert inked(tmp_path, sized, '<use href="#s" width="50" height="50"/>') == [[10, 10, 40, 40]]


def test_a_symbol_may_use_another(tmp_path: Path) -> None:
    outer = (
        '<symbol id="t" viewBox="0 0 20 10"><use href="#s" width="10" height="10"/>'
        '<use href="#s" x="10" width="10" height="10"/></symbol>'
    )
    uses = '<g id="g"><use href="#t" width="40" height="20"/></g><use href="#g" x="50" y="50"/>'
    assert inked(tmp_path, outer, uses, SYMBOL) == [
        [4, 4, 16, 16],
        [24, 4, 36, 16],
        [54, 54, 66, 66],
        [74, 54, 86, 66],
    ]


def test_a_drawing_within_a_drawing_lies_where_it_says(tmp_path: Path) -> None:
    for view in ("", 'viewBox="0 0 20 20"'):
        inner = f'<svg x="40" y="30" width="20" height="20" {view}>{SQUARE}</svg>'
        assert inked(tmp_path, inner) == [[42, 32, 48, 38]]


def test_a_use_may_lie_at_a_share_of_the_view(tmp_path: Path) -> None:
    use = '<use href="#s" x="10%" y="20%" width="10%" height="10"/>'
    assert inked(tmp_path, SYMBOL, use) == [[12, 22, 18, 28]]


def test_a_style_reaches_what_is_used(tmp_path: Path) -> None:
    style = "<style>.line { fill: none; stroke: black; stroke-width: 2 }</style>"
    symbol = '<symbol id="s" viewBox="0 0 10 10" class="line"><path d="M1 5 H9"/></symbol>'
    use = '<use href="#s" width="50" height="50"/>'
    assert inked(tmp_path, style, symbol, use) == [[5, 20, 45, 30]]


def test_a_view_of_other_proportions_stretches_only_where_it_may(tmp_path: Path) -> None:
    assert inked(tmp_path, SQUARE, view="0 0 10 20") == [[35, 10, 65, 40]]
    filled = '0 0 10 20" preserveAspectRatio="none'
    assert inked(tmp_path, SQUARE, view=filled) == [[20, 10, 80, 40]]
