"""Taking an ink shape apart into strokes, each with its region and its centre line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.shapes.continuation import Chain, chains_of
from paint3d.calligraphy.shapes.corners import cut_at_corners
from paint3d.calligraphy.shapes.dots import as_dot, dot_among, find_dots
from paint3d.calligraphy.shapes.ductus import JoinedForm, in_writing_order
from paint3d.calligraphy.shapes.regions import (
    Ink,
    InkStroke,
    complete_regions,
    has_length,
    pieces_of,
)
from paint3d.calligraphy.shapes.skeleton import skeleton_of
from paint3d.calligraphy.shapes.transfer import (
    Fit,
    KnownStrokes,
    Labelled,
    fit_of,
    label_chains,
    lay_over,
    order_as_known,
)
from paint3d.calligraphy.shapes.triangles import triangulate
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["decompose", "thinnest_within"]

_SPECK = 0.01  # squares of the mean width: smaller parts are no strokes
_HAIRLINE = 1e-5  # of the size of a shape: thinner parts are no strokes
_LONGEST = 20_000.0  # of its width that a part is long: longer ones are no strokes of a brush
_GRAIN = 2.0**-40  # of the farthest coordinate: thinner parts are what rounding left
_NOT_NEAR = 0.15  # widths away: forms of joined hands are looked at beyond it
_NEARER = 0.75  # of the distance of other forms, below which they count
_GRID = 2.0**32  # points to the size of a shape


def decompose(
    outline: MultiPolygon,
    *,
    template: Glyph | Sequence[Glyph] | None = None,
    runs_on: bool = False,
) -> list[GlyphStroke]:
    """The strokes that an ink shape is made of, in order and direction of writing.

    Parameters
    ----------
    outline : shapely.MultiPolygon
        Any unit, y upwards.
    template : Glyph or sequence of Glyph, optional
        The strokes of the character where it is known, in any frame, or several forms of it, of
        which the one that fits best counts: their order and direction
        are carried onto the shape. Where the shape joins its strokes, as running hands do, or
        is another character, its own strokes stay, in the order and direction of those that they
        lie upon.
    runs_on : bool
        Whether it is letters joined along a line: they keep their own strokes, in the order in
        which these begin; see `in_writing_order` for letters that are not known.

    Returns
    -------
    list of GlyphStroke
        In the frame of the outline. Their regions together are the shape, but for specks of less
        than a hundredth of the square of a stroke's mean width, and parts thinner than a 100,000th
        of its size or a 20,000th of its length.

    Raises
    ------
    InputError
        If the outline has no area, or nothing but such parts.
    """
    parts = _connected_parts(outline)
    low = np.array(outline.bounds[:2])
    size = 2.0 ** math.ceil(math.log2(max(np.ptp(np.reshape(outline.bounds, (2, 2)), axis=0))))
    even = [_snap_to_grid(part, low, size) for part in parts]
    forms = [template] if isinstance(template, Glyph) else template or ()
    forms = [form for form in forms if form.strokes]
    return [_to_outline_frame(piece, low, size) for piece in _pieces_of(even, forms, runs_on)]


def _snap_to_grid(part: Polygon, low: NDArray[np.float64], size: float) -> Polygon:
    """A polygon normalized to 0 to 1 on a fine grid: the result does not depend on position."""
    import shapely

    return shapely.transform(part, lambda p: np.round((p - low) / size * _GRID) / _GRID)


def _pieces_of(parts: list[Polygon], forms: Sequence[Glyph], runs_on: bool) -> list[InkStroke]:
    """The strokes of connected shapes, in order and direction of writing."""
    if not forms:
        pieces = [piece for part in parts for piece in _decompose_by_shape(_ink_of(part))]
        return in_writing_order(pieces, runs_on=runs_on)
    if runs_on:
        return _decompose_joined(parts, _lines_of(forms[0]))
    best = _best_form(parts, forms)
    dots = dot_among(parts, best.lines)
    taken, own = set(dots.values()), list[tuple[InkStroke, int | None]]()
    for k, part in enumerate(parts):
        if best.fit is Fit.WHOLE:
            mine = _decompose_by_template(best.inks[k], best.labelled[k].chains)
        elif best.fit is Fit.JOINED:
            mine = [(piece, None) for piece in _decompose_by_lines(_ink_of(part), best.known)]
        else:
            mine = [(piece, None) for piece in _decompose_by_shape(_ink_of(part))]
        for piece, stroke in mine:  # what lies beside a dot is no part of it
            own.append((piece, dots.get(k, None if stroke in taken else stroke)))
    return order_as_known(own, best.known, dots=taken)


def _decompose_by_lines(ink: Ink, known: KnownStrokes) -> list[InkStroke]:
    """The strokes of a shape that joins known ones: only corners are cut where these change."""
    labelled = label_chains(ink, known, tear=False)
    return [piece for piece, _ in _decompose_by_template(ink, labelled.chains)]


def _decompose_joined(parts: list[Polygon], lines: Sequence[AnyArray]) -> list[InkStroke]:
    """The strokes of joined letters, whose path is known."""
    inks = [_ink_of(part) for part in parts]
    known = lay_over(lines, inks, _mean_width(parts))
    pieces = [(piece, None) for ink in inks for piece in _decompose_by_lines(ink, known)]
    return order_as_known(pieces, known, by_start=True)


class _Laid(NamedTuple):
    """A form of a known character, laid over the shape."""

    fit: Fit
    away: float
    lines: Sequence[AnyArray]
    known: KnownStrokes
    inks: list[Ink]
    labelled: list[Labelled]


def _lines_of(form: Glyph) -> list[NDArray[np.float64]]:
    return [stroke.median for stroke in form.strokes]


def _best_form(parts: list[Polygon], forms: Sequence[Glyph]) -> _Laid:
    """The form that fits best; one of a joined hand only where it lies nearer than others."""
    apart = [form for form in forms if not isinstance(form, JoinedForm)] or forms
    laid = [_lay_forms(parts, _lines_of(form)) for form in apart]
    away = min(one.away for one in laid)
    if away > _NOT_NEAR:
        joined = [form for form in forms if isinstance(form, JoinedForm)]
        nearer = [_lay_forms(parts, _lines_of(form)) for form in joined]
        laid = [one for one in nearer if one.away < _NEARER * away] or laid
    return min(laid, key=lambda one: (one.fit, one.away))


def _lay_forms(parts: list[Polygon], lines: Sequence[AnyArray]) -> _Laid:
    inks = [_ink_of(part) for part in parts]
    known = lay_over(lines, inks, _mean_width(parts))
    labelled = [label_chains(ink, known) for ink in inks]
    return _Laid(*fit_of(inks, known, labelled), lines, known, inks, labelled)


def _mean_width(parts: list[Polygon]) -> float:
    """Mean width of the strokes of all parts."""
    import shapely

    areas, lengths = (sum(map(size, parts)) for size in (shapely.area, shapely.length))
    return float(2.0 * areas / lengths)


def _ink_of(part: Polygon) -> Ink:
    triangles = triangulate(part)
    return Ink(triangles, skeleton_of(triangles))


def thinnest_within(points: AnyArray) -> float:
    """Least width of a part that reaches so far, points (N, 2), that is no hairline."""
    return float(max(_HAIRLINE * np.ptp(points, axis=0).max(), _GRAIN * np.abs(points).max()))


def _connected_parts(outline: MultiPolygon) -> list[Polygon]:
    """The connected polygons of a shape without specks, from the left, then from the top."""
    import shapely

    valid = outline if shapely.is_valid(outline) else shapely.make_valid(outline)
    parts = shapely.get_parts(shapely.get_parts(valid))
    thinnest = thinnest_within(np.reshape(outline.bounds, (2, 2)))
    parts = [part for part in parts if part.geom_type == "Polygon" and part.area > 0.0]
    parts = [part for part in parts if _mean_width([part]) >= thinnest]
    parts = [part for part in parts if part.length <= 2.0 * _LONGEST * _mean_width([part])]
    if not parts:
        raise InputError(
            "the outline has no area, or is a hairline; expected a shape to fill, wider than a "
            "{hairline:,.0f}th of its size and a {most:,.0f}th of its length",
            hairline=1.0 / _HAIRLINE,
            most=_LONGEST,
        )
    least = _SPECK * _mean_width(parts) ** 2
    large_parts = [part for part in parts if part.area >= least]
    return sorted(large_parts, key=lambda part: (part.bounds[0], -part.bounds[3], part.area))


def _decompose_by_shape(ink: Ink) -> list[InkStroke]:
    """The strokes of one connected shape, by what it looks like alone."""
    dots = find_dots(ink)
    if dots:
        return dots
    cut_at_corners(ink.skeleton, ink.triangles, ink.half_widths)
    chains = [one for one in chains_of(ink.skeleton, ink.half_widths) if has_length(one, ink)]
    if not chains:
        return [as_dot(ink.shape)]
    return complete_regions(pieces_of(chains, ink), ink)


def _decompose_by_template(
    ink: Ink, labelled: list[tuple[Chain, int]]
) -> list[tuple[InkStroke, int | None]]:
    """The strokes of one connected shape as those of a known character."""
    labelled = [(chain, stroke) for chain, stroke in labelled if has_length(chain, ink)]
    dots = find_dots(ink)
    if dots or not labelled:
        return [(dot, None) for dot in dots or [as_dot(ink.shape)]]
    pieces = complete_regions(pieces_of((chain for chain, _ in labelled), ink), ink)
    return [(piece, stroke) for piece, (_, stroke) in zip(pieces, labelled, strict=True)]


def _to_outline_frame(piece: InkStroke, low: NDArray[np.float64], size: float) -> GlyphStroke:
    """A piece as a stroke of the outline's frame."""
    stroke = GlyphStroke.filling(piece.region, piece.line)
    return stroke.mapped(lambda points: low + size * points)
