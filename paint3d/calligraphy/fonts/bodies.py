"""Glyphs of a line as pieces of ink: what hangs together is one body, with the marks it carries.

A letter, a word of a joined script and a syllable are bodies; a dot, an accent or a vowel sign that
touches none is written after the body it belongs to. Characters of Chinese, Japanese and Korean
stay whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.shaping import ShapedGlyph
from paint3d.calligraphy.page.ink import as_multipolygon, polygons_of

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["WHOLE", "Body", "bodies_of", "text_of"]

WHOLE = frozenset({"Hani", "Hira", "Kana", "Hang", "Bopo", "Yiii", "Tang", "Nshu"})
"""Scripts whose characters are squares of their own."""


@dataclass(frozen=True, eq=False)
class Body:
    """Ink that is written in one go.

    Attributes
    ----------
    glyphs : tuple of ShapedGlyph
        That it is made of, as they are read.
    parts : tuple of MultiPolygon
        The body, then its marks; glyph units of the line.
    """

    glyphs: tuple[ShapedGlyph, ...]
    parts: tuple[MultiPolygon, ...]


class _Part(NamedTuple):
    shape: Polygon
    glyph: int  # place in the line
    is_main: bool  # the largest of a glyph that is no mark


def bodies_of(glyphs: Sequence[ShapedGlyph], font: FontFile) -> list[Body]:
    """The bodies of a line in writing order.

    Parameters
    ----------
    glyphs : sequence of ShapedGlyph
        As they are read.
    font : FontFile
    """
    bodies: list[tuple[int, Body]] = []
    parts: list[_Part] = []
    shapes = [_placed(one, font) for one in glyphs]
    bases = _bases(glyphs, [shape.area for shape in shapes])
    for k, (one, shape) in enumerate(zip(glyphs, shapes, strict=True)):
        if shape.is_empty:
            continue
        if one.script in WHOLE:
            bodies.append((k, Body((one,), (shape,))))
            continue
        pieces = polygons_of(shape)
        largest = max(pieces, key=lambda piece: piece.area)
        is_base = bases[k] == k and not font.is_mark(one.glyph)
        parts += [_Part(piece, k, piece is largest and is_base) for piece in pieces]
    bodies += _joined(parts, glyphs, bases)
    return [body for _, body in sorted(bodies, key=lambda one: one[0])]


def text_of(some: Sequence[ShapedGlyph], glyphs: Sequence[ShapedGlyph], line: str) -> str:
    """The characters of a line that some of its glyphs stand for, from the first to the last."""
    starts = sorted({one.cluster for one in glyphs})
    first, last = min(one.cluster for one in some), max(one.cluster for one in some)
    end = next((start for start in starts if start > last), len(line))
    return line[first:end]


def _bases(glyphs: Sequence[ShapedGlyph], areas: Sequence[float]) -> list[int]:
    """For every glyph the largest one of those that stand for the same characters."""
    largest: dict[int, int] = {}
    for k, one in enumerate(glyphs):
        if areas[k] > areas[largest.setdefault(one.cluster, k)]:
            largest[one.cluster] = k
    return [largest[one.cluster] for one in glyphs]


def _placed(one: ShapedGlyph, font: FontFile) -> MultiPolygon:
    from shapely import transform

    at = np.array([one.x, one.y])
    return transform(font.outline(one.glyph), lambda points: points + at)


def _joined(
    parts: Sequence[_Part], glyphs: Sequence[ShapedGlyph], bases: Sequence[int]
) -> list[tuple[int, Body]]:
    """Parts that touch as bodies, with the others as their marks; each with its first glyph."""
    groups = _touching(parts)
    homes = {part.glyph: group for group in groups for part in group if part.is_main}
    marks: dict[int, list[list[_Part]]] = {}
    bodies = []
    for group in groups:
        home = None if any(part.is_main for part in group) else _home(group, homes, bases)
        if home is None:
            bodies.append(group)
        else:
            marks.setdefault(id(home), []).append(group)
    result = []
    for group in bodies:
        carried = sorted(marks.get(id(group), []), key=lambda one: min(p.glyph for p in one))
        members = sorted({part.glyph for one in (group, *carried) for part in one})
        shapes = tuple(_union(one) for one in (group, *carried))
        first = min(part.glyph for part in group)
        result.append((first, Body(tuple(glyphs[k] for k in members), shapes)))
    return result


def _home(
    group: Sequence[_Part], homes: dict[int, list[_Part]], bases: Sequence[int]
) -> list[_Part] | None:
    """The body that a mark belongs to: that of its glyph, or of the letter before it."""
    here = bases[min(part.glyph for part in group)]
    return next((homes[k] for k in range(here, -1, -1) if k in homes), None)


def _touching(parts: Sequence[_Part]) -> list[list[_Part]]:
    """Groups of parts whose ink touches."""
    from shapely import STRtree

    if not parts:
        return []
    shapes = [part.shape for part in parts]
    group = list(range(len(parts)))
    for a, b in STRtree(shapes).query(shapes, predicate="intersects").T:
        one, two = group[a], group[b]
        if one != two:
            group = [min(one, two) if k in (one, two) else k for k in group]
    return [
        [part for part, k in zip(parts, group, strict=True) if k == key]
        for key in dict.fromkeys(group)
    ]


def _union(parts: Sequence[_Part]) -> MultiPolygon:
    from shapely import unary_union

    return as_multipolygon(unary_union([part.shape for part in parts]))
