"""Composition of a text on a sheet, as calligraphers compose: it fills the paper.

Columns run from the right, as many as let the characters be largest without much paper left bare.
They stand farther apart than the characters of one, so that the text reads down them; what is left
stays bare, above a little more than below. A signature (落款) in smaller characters stands below
the last column where that is shorter than the others, else left of it, in its lower part, within
the margin; a seal, about as wide as its ink, stands below. Without a signature it stands beside the
end of the text, which stays in the middle: the other side is left as wide. On a folding fan, whose
ribs meet, long columns and short ones take turns: the short ones end where there is no place
between the long.
"""

from __future__ import annotations

import math
import unicodedata
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.layout import split_text
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import EmSquare
from paint3d.mesh.sheet_mesh import fan_of, make_sheet, paper_bounds, sheet_of, writing_areas
from paint3d.mesh.sheets import Sheet
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "Composition",
    "Signing",
    "compose",
    "lines_of",
    "place_on",
    "seal_below",
    "sign_beside",
    "stands_in_squares",
]

_GAP, _BETWEEN = 0.2, 0.0  # ems: the least between columns, and between characters of one
_BARE = 0.09  # ems on either side of a character that its ink leaves bare: they may lie in margins
_FROM_EDGE = 0.025  # ems that a square has to stay away from the paper's edge
_MOST_GAP, _MOST_BETWEEN = 0.36, 0.3
_CLOSER = 0.5  # of the distance of columns, at most: characters of one, that it reads as a column
_LEAST_MM = 4.0  # the smallest characters that a text is composed in
_LARGEST, _SMALLER = 0.8, 0.98  # of a sheet's shorter side: a character; what is tried next
_BARE_COSTS = 0.5  # of the size, where a whole length or width stays bare
_AT_HEAD = 1.4  # margins above and below, over those at the sides, on a sheet of twice its width
_LOWER = 0.1  # of a length that stays bare: by how much the text stands below the middle
_ALONE, _PARTED = 0.6, 0.95  # of the size: one left in the last column; verses parted by columns
_SIGNATURE, _OF_WIDTH = 0.35, 1.0 / 10.0  # of the characters' size, of the paper's width at most
_SIGNED_COLUMN, _AWAY = 1.8, 0.9  # of a signature's characters: its column; from the text's ink
_SIGNED_BETWEEN, _TO_SEAL, _SEAL = 0.0, 0.4, 0.85  # of a signature's characters
_IN_MARGIN = 0.6  # of a couplet's margin: what a signature's column may take of it
_SIGNED_LENGTH = 0.85  # of the text's columns, at most
_LEAST_BELOW, _BELOW = 0.19, 0.35  # ems: a signature below the last column; from that to it
_LEAST_SIGNATURE_MM, _LEAST_FRACTION = 4.0, 0.1
_LEAST_SEAL_MM = 4.0
_ALONE_COLUMN, _ALONE_AWAY, _LEAST_ALONE = 1.4, 0.4, 0.6  # of a seal alone: its column; from the
# text's ink; how much of it stays where there is no place for it within the margin
_STEP_MM, _OFF_MM, _FARTHEST_MM, _TRIALS = 2.0, 0.01, 2000.0, 4
_HEAD_ON_FAN = 0.15  # ems from the upper margin of a fan
_WIDEST_ON_FAN = 0.8  # ems between columns, in the middle of their length
_IN_TURN_FROM, _EVEN_ON_FAN = 8, 0.8  # characters: long and short columns; of the size: even ones
_HALVINGS = 30


@dataclass(frozen=True)
class Composition:
    """A text's columns or rows on a sheet: their size, spacing and position.

    Attributes
    ----------
    lines : tuple of str
        Its columns from the right, or its rows.
    em_mm : float
        Side of a character's square, mm.
    gap, between : float
        As `Layout` has them, ems.
    point : (float, float, float) or None
        Its middle, mm; None: in the middle of the panels.
    """

    lines: tuple[str, ...]
    em_mm: float
    gap: float
    between: float
    point: tuple[float, float, float] | None


def compose(
    sheet: Sheet,
    text: str,
    order: str = "columns",
    *,
    signature: int | None = None,
    gap: float | None = None,
    between: float | None = None,
) -> Composition | None:
    """Find the size, columns and distances at which a text fills a sheet.

    Parameters
    ----------
    sheet : Sheet
    text : str
        Line breaks are ends of verses: a column holds one, several, or none wholly, whatever lets
        the characters be largest.
    order : {"columns", "row"}
    signature : int, optional
        Characters of the signature that is to stand beside it, with a seal; 0 for a seal alone.
    gap, between : float, optional
        Distances that are given, ems, as `Layout` has them.

    Returns
    -------
    Composition or None
        None of a text with letters that do not stand in squares.

    Raises
    ------
    InputError
        If the text is empty, or so long that its characters would be too small to write.
    """
    if not stands_in_squares(text):
        return None
    verses = _verses_of(text)
    asked = _Asked(
        sheet,
        order == "columns",
        0.0 if signature is None else _signed_length(signature),
        signature == 0,
        (_GAP, _MOST_GAP) if gap is None else (gap, gap),
        (_BETWEEN, _MOST_BETWEEN) if between is None else (between, between),
    )
    composed = _on_panels if sheet.usual.panels > 1 else _best
    composition = composed(asked, verses)
    if composition.em_mm < _LEAST_MM:
        n = len("".join(verses))
        fits = bisect_left(
            range(1, n), True, key=lambda k: composed(asked, ["一" * k]).em_mm < _LEAST_MM
        )
        raise InputError(
            "{n} characters would fill {sheet} at {em:.1f} mm each, which is less than {least:g} "
            "mm; expected at most {fits} characters, or a larger sheet",
            n=n,
            sheet=sheet.name,
            em=composition.em_mm,
            least=_LEAST_MM,
            fits=fits,
        )
    return composition


def place_on(sheet: Sheet, point: Sequence[float]) -> tuple[float, float]:
    """A point of a sheet as fractions of its panels' width and height; see `place`."""
    low, high = paper_bounds(make_sheet(sheet))[:, :2]
    u, v = ((np.array(point[:2]) - low) / (high - low)).tolist()
    return u, v


def stands_in_squares(text: str) -> bool:
    """Return whether all letters of a text, punctuation apart, are written in squares.

    Raises
    ------
    InputError
        If the text is empty.
    """
    letters = "".join(_verses_of(text))
    return all(unicodedata.east_asian_width(letter) in "WF" for letter in letters)


def _verses_of(text: str) -> list[str]:
    # punctuation, which calligraphers do not write, ends a verse
    marks = {one for one in text if unicodedata.category(one)[0] == "P"}
    return split_text("".join("\n" if one in marks else one for one in text))


@dataclass(frozen=True)
class _Asked:
    """A sheet, and what is asked of a composition on it."""

    sheet: Sheet
    columns: bool
    signature: float  # its length with the seal, in its characters; 0 without one
    seal_alone: bool
    gap: tuple[float, float]  # from the least to the most, ems
    between: tuple[float, float]

    @property
    def aside(self) -> float:
        """Width of the signature's column, in sizes of its characters."""
        return _ALONE_COLUMN * _SEAL if self.seal_alone else _SIGNED_COLUMN


def _best(asked: _Asked, verses: Sequence[str]) -> Composition:
    broken = list(_ways_to_break(verses))
    if asked.columns and asked.sheet.usual.shape == "sector":
        broken = [(lines, preference * _on_ribs(lines)) for lines, preference in broken]
        broken += _alternating_columns("".join(verses), asked.sheet)
    rated = [(preference, *_fit_lines(asked, lines)) for lines, preference in broken]
    return max(rated, key=lambda one: one[0] * one[1])[2]


def _on_ribs(lines: Sequence[str]) -> float:
    """The preference for columns of one length on a folding fan, 0 to 1."""
    few = sum(map(len, lines)) < _IN_TURN_FROM
    return 1.0 if few or max(map(len, lines)) == 1 else _EVEN_ON_FAN


def _alternating_columns(text: str, sheet: Sheet) -> Iterator[tuple[list[str], float]]:
    """Yield a text in long and short columns by turns, with the preference for it."""
    fan = fan_of(sheet)
    most = int(2.0 * fan.half_opening * fan.outer / _LEAST_MM)  # columns
    longest = min(len(text) // 2 - 1, int(sheet.height_mm / _LEAST_MM))
    for long in range(2, longest + 1 if len(text) >= _IN_TURN_FROM else 0):
        for short in range(1, long // 2 + 1):
            if 2 * len(text) > most * (long + short):
                continue
            lines: list[str] = []
            at = 0
            while at < len(text):
                rows = (long, short)[len(lines) % 2]
                lines.append(text[at : at + rows])
                at += rows
            whole = at == len(text)
            if len(lines) > 2 and (whole or len(lines[-1]) > len(lines[-2])):
                yield lines, 1.0 if whole else _PARTED


def _on_panels(asked: _Asked, verses: list[str]) -> Composition:
    """A couplet: a half on each panel, in as many columns of one size."""
    n = asked.sheet.usual.panels
    if len(verses) == 1:
        half = -(-len(verses[0]) // n)
        verses = [verses[0][k : k + half] for k in range(0, len(verses[0]), half)]
    halves = ["".join(part) for part in np.array_split(np.array(verses, dtype=object), n)]
    longest = max(halves, key=len)
    best = _best(asked, [longest])
    rows = len(best.lines[0])
    columns = [half[k : k + rows] for half in halves for k in range(0, len(longest), rows)]
    return Composition(tuple(filter(None, columns)), best.em_mm, best.gap, best.between, None)


def _ways_to_break(verses: Sequence[str]) -> Iterator[tuple[list[str], float]]:
    """Yield the verses broken into columns, with the preference for each way."""
    for n in range(1, len(verses) + 1):
        yield ["".join(verses[k : k + n]) for k in range(0, len(verses), n)], 1.0
    whole = "".join(verses)
    for rows in sorted({math.ceil(len(whole) / n) for n in range(1, len(whole) + 1)}):
        yield [whole[k : k + rows] for k in range(0, len(whole), rows)], _PARTED


def _fit_lines(asked: _Asked, lines: list[str]) -> tuple[float, Composition]:
    """Fit lines to a sheet; their score and composition."""
    n, longest = len(lines), max(map(len, lines))
    shape = asked.sheet.usual.shape
    fit = {"sector": _on_fan, "disc": _on_disc}.get(shape, _on_rectangle)
    worth, em, gap, between, x, y = fit(asked, lines)
    if n > 1 and len(set(map(len, lines[:-1]))) == 1 and len(lines[-1]) == 1 and longest > 1:
        worth *= _ALONE
    point = None if asked.sheet.usual.panels > 1 else (x, y, 0.0)
    return worth, Composition(tuple(lines), em, gap, between, point)


class _Fit(NamedTuple):
    """Lines at the size that suits a sheet best, and how good that is; x, y: their middle, mm."""

    worth: float
    em: float
    gap: float
    between: float
    x: float
    y: float


def _signature_mm(em: float, whole: float, length: float) -> float:
    """The size of a signature, `whole` of its characters long, beside a text of a length, mm."""
    return min(_SIGNATURE * em, max(_SIGNED_LENGTH * length / whole, _LEAST_FRACTION * em))


def _below_mm(em: float, whole: float, blank: float) -> float | None:
    """The size of a signature below a column that is shorter by a length, mm; None: no room."""
    size = min(_SIGNATURE * em, (blank - (_BELOW + _BARE) * em) / whole)
    return size if size >= _LEAST_BELOW * em else None


def _signed_length(n: int) -> float:
    """Length of a signature of n characters with its seal, in sizes of its characters."""
    return n * (1.0 + _SIGNED_BETWEEN) + _TO_SEAL + _SEAL


def _spread(free: float, em: float, n: int, least: float, most: float) -> float:
    """The distance, ems, that lets n characters fill a length, mm."""
    return least if n == 1 else min(max((free / em - n) / (n - 1), least), most)


def _on_rectangle(asked: _Asked, lines: list[str]) -> _Fit:
    """Lines on a rectangle: as large as they can be with little of it bare."""
    sheet, columns = asked.sheet, asked.columns
    width, height = sheet.size
    at_side = sheet.margin_mm
    at_head = at_side * (_AT_HEAD if height >= 2.0 * width else 1.0)
    across, along = width - 2.0 * at_side, height - 2.0 * at_head
    margins = at_side, at_head
    if not columns:
        across, along, margins = along, across, margins[::-1]
    n, rows = len(lines), max(map(len, lines))
    in_halves = sheet.usual.panels > 1  # which are laid within margins, in the middle
    least = asked.between[0]
    best: _Fit | None = None
    em = min(
        _LARGEST * min(sheet.size),
        across / (n + (n - 1) * asked.gap[0] - 2.0 * _BARE),
        along / (rows + (rows - 1) * least - 2.0 * _BARE),
    )
    while best is None or em > best.worth:
        bare = [-0.5 * _BARE * em if in_halves else min(_BARE * em, edge) for edge in margins]
        long = along + 2.0 * bare[1]
        spaced = partial(_space_lines, asked, lines, em, (across + 2.0 * bare[0], long))
        wide, gap, between = spaced(0.0)
        signature = 0.0
        blank = (rows - len(lines[-1])) * em * (1.0 + between)
        if asked.signature and (n == 1 or _below_mm(em, asked.signature, blank) is None):
            size = _signature_mm(em, asked.signature, em * (rows + (rows - 1) * least))
            signature = asked.aside * min(size, _OF_WIDTH * min(sheet.size))
            if in_halves:  # from the ink on it may lie in the margin; the other side is as wide
                aside = signature - _BARE * em + bare[0] - _IN_MARGIN * margins[0]
                signature = 2.0 * max(0.0, aside)
            elif asked.seal_alone:  # likewise
                signature *= 2.0
            wide, gap, between = spaced(signature)
        free = wide - em * (n + (n - 1) * gap), long - em * (rows + (rows - 1) * between)
        shift = 0.0 if asked.seal_alone else 0.5 * signature
        edge = margins[0] + 0.5 * (across - wide + free[0]) - shift  # the paper's, from the squares
        if min(free) >= -1e-6 * em and (shift == 0.0 or edge >= _FROM_EDGE * em):
            worth = em * math.prod(1.0 - _BARE_COSTS * np.array(free) / (wide, long))
            if best is None or worth > best.worth:
                x, y = (shift, -_LOWER * free[1]) if columns else (0.0, shift)
                best = _Fit(worth, em, gap, between, x, y)
        em *= _SMALLER
    return best


def _space_lines(
    asked: _Asked, lines: list[str], em: float, space: tuple[float, float], signature: float
) -> tuple[float, float, float]:
    """The width left beside a signature's column, mm, and the gaps between columns and in one."""
    least, most = asked.between
    n, rows = len(lines), max(map(len, lines))
    wide = space[0] - signature
    gap = _spread(wide, em, n, *asked.gap)
    closest = most if least == most or n == 1 else max(least, min(most, _CLOSER * gap))
    return wide, gap, _spread(space[1], em, rows, least, closest)


def _on_disc(asked: _Asked, lines: list[str]) -> _Fit:
    sheet, columns = asked.sheet, asked.columns
    radius = 0.5 * sheet.width_mm - sheet.margin_mm
    n, rows = len(lines), max(map(len, lines))
    wide = n + (n - 1) * asked.gap[0] - 2.0 * _BARE
    long = rows + (rows - 1) * asked.between[0] - 2.0 * _BARE
    signed = asked.aside * _SIGNATURE * 0.75 if asked.signature and columns else 0.0
    shift = 0.0 if asked.seal_alone else 0.5 * signed
    em = 2.0 * radius / math.hypot(wide + (2.0 * signed if asked.seal_alone else signed), long)
    corner = math.hypot(wide + 2.0 * _BARE, long + 2.0 * _BARE)
    em = min(em, 0.97 * sheet.width_mm / corner, 0.6 * sheet.width_mm)
    return _Fit(em, em, asked.gap[0], asked.between[0], shift * em, 0.0)


def _on_fan(asked: _Asked, lines: list[str]) -> _Fit:
    sheet, columns = asked.sheet, asked.columns
    fan = fan_of(sheet)
    margin = sheet.margin_mm
    outer, inner = fan.outer - margin, fan.inner + margin
    opening = 2.0 * (fan.half_opening - margin / (0.5 * (outer + inner)))
    n, rows = (len(lines), max(map(len, lines))) if columns else (max(map(len, lines)), len(lines))
    aside, along = (asked.gap, asked.between) if columns else (asked.between, asked.gap)
    long = rows + (rows - 1) * along[0]
    signed = asked.aside * _SIGNATURE if asked.signature and columns else 0.0
    if asked.seal_alone:
        signed *= 2.0
    lengths = list(map(len, lines)) if columns else [rows] * n
    # columns touch where they are nearest to the apex: neighbours, and those beside a shorter one
    beside = max(map(min, pairwise(lengths)), default=0)
    beyond = max(map(min, zip(lengths, lengths[2:], strict=False)), default=0)

    def pitch_of(em: float) -> float:
        """The least angle between two columns."""
        head = _HEAD_ON_FAN - along[0]
        near, far = (outer - em * (k * (1.0 + along[0]) + head) for k in (beside, beyond))
        return em * (1.0 + aside[0]) * max(1.0 / min(near, middle_of(em)), 0.5 / far)

    def middle_of(em: float) -> float:
        return outer - em * (0.5 * long + _HEAD_ON_FAN)

    def fits(em: float) -> bool:
        lower = outer - em * (long + _HEAD_ON_FAN)
        return (n - 1) * pitch_of(em) + (1.0 + signed) * em / lower <= opening

    em, most = 0.0, (outer - inner) / (long + 2.0 * _HEAD_ON_FAN)
    if fits(most):
        em = most
    else:
        for k in range(1, _HALVINGS):
            em += 0.5**k * most if fits(em + 0.5**k * most) else 0.0
    lower, middle = outer - em * (long + _HEAD_ON_FAN), middle_of(em)
    signature = signed * em / lower  # an angle, as that of a pitch
    pitch = (opening - signature - em / lower) / (n - 1) if n > 1 else 0.0
    widest = aside[1] if aside[0] == aside[1] else _WIDEST_ON_FAN  # equal where it is given
    apart = min(max(pitch * middle / em - 1.0, aside[0]), widest)
    turn = 0.0 if asked.seal_alone else 0.5 * signature
    x, y = middle * math.sin(turn), middle * math.cos(turn) + fan.apex
    return _Fit(em, em, *((apart, along[0]) if columns else (along[0], apart)), x, y)


# ---- Signatures ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Signing:
    """A signature beside a text, and the seal below it: their sizes and positions.

    Attributes
    ----------
    em_mm : float
        Side of its characters' squares, mm.
    between : float
        Between them, ems.
    point : (3,) float64
        Where its middle is, mm, in the tangent plane of the text's last column.
    seal_mm : float
        Side of the seal, mm.
    seal_point : (3,) float64
        Where the seal's middle is, mm, likewise.
    up : (3,) float64
        Upwards there.
    """

    em_mm: float
    between: float
    point: NDArray[np.float64]
    seal_mm: float
    seal_point: NDArray[np.float64]
    up: NDArray[np.float64]


def lines_of(squares: Sequence[EmSquare], order: str = "columns") -> list[list[EmSquare]]:
    """The squares of a text, in writing order, as its columns or rows."""
    lines = [[squares[0]]]
    for before, square in pairwise(squares):
        frame = before.chart.frame
        step = square.chart.frame.origin - frame.origin
        onward = -frame.y_axis if order == "columns" else frame.x_axis
        if step @ onward < 0.5 * np.linalg.norm(step):
            lines.append([])
        lines[-1].append(square)
    return lines


class _Paper:
    """A sheet's paper, for measuring how far it extends."""

    def __init__(self, mesh: TriangleMesh) -> None:
        areas = () if sheet_of(mesh) is None else writing_areas(mesh, False)
        self._apex = areas[0].apex if areas else None
        self._panels = [ClosestPoints(area.mesh) for area in areas]

    def beside(
        self, point: AnyArray, away: float, aside: AnyArray, onward: AnyArray
    ) -> tuple[AnyArray, AnyArray]:
        """The point so far (mm) aside of one (3,), and the direction onward there.

        On a folding fan that is to where its ribs meet.
        """
        if self._apex is None:
            return point + away * aside, onward
        rib = point - self._apex
        turn = away / float(np.linalg.norm(rib))
        turned = math.cos(turn) * rib + math.sin(turn) * float(np.linalg.norm(rib)) * aside
        return self._apex + turned, -turned / float(np.linalg.norm(turned))

    def splay(self, point: AnyArray, onward_mm: float) -> float:
        """The factor by which a folding fan's ribs are closer so far (mm) onward of a point."""
        if self._apex is None:
            return 1.0
        rib = float(np.linalg.norm(point - self._apex))
        return rib / max(rib - onward_mm, 0.25 * rib)

    def free_length(self, start: AnyArray, direction: AnyArray) -> float:
        """The length (mm) of paper from a point (3,) in a direction; endless on other objects."""
        if not self._panels:
            return math.inf
        steps = np.arange(0.0, _FARTHEST_MM, _STEP_MM)
        points = start + np.outer(steps, direction)
        off = np.min(
            [np.linalg.norm(panel.find(points).points - points, axis=1) for panel in self._panels],
            axis=0,
        )
        return float(steps[int(np.argmax(off > _OFF_MM))] if off.max() > _OFF_MM else steps[-1])


def sign_beside(
    mesh: TriangleMesh, squares: Sequence[EmSquare], n: int, order: str = "columns"
) -> Signing:
    """Place a signature beside a text.

    Parameters
    ----------
    mesh : TriangleMesh
    squares : sequence of EmSquare
        Of the text, in writing order.
    n : int
        Characters of the signature; 0 for a seal alone, which stands beside the text's end.
    order : {"columns", "row"}
        Of the text; the signature is laid out likewise.
    """
    lines = lines_of(squares, order)
    last, em = lines[-1], lines[-1][0].em_mm
    rows = max(map(len, lines))
    first = last[0].chart.frame
    if order == "columns":
        onward, aside = -first.y_axis, -first.x_axis
    else:
        onward, aside = first.x_axis, -first.y_axis
    most = max(lines, key=len)
    pitch = em * (1.0 + _BETWEEN)
    if rows > 1:
        ends = most[-1].chart.frame.origin - most[0].chart.frame.origin
        pitch = float(np.linalg.norm(ends)) / (rows - 1)
    length = em + (rows - 1) * pitch
    whole = _signed_length(n) if n else _SEAL
    size = _signature_mm(em, whole, length)
    sheet = sheet_of(mesh)
    if sheet is not None:
        size = min(size, _OF_WIDTH * min(sheet.size))
    below = _below_mm(em, whole, (rows - len(last)) * pitch) if len(lines) > 1 else None
    foot = 0.5 if n and length > 4.0 * em else _BARE  # a seal alone stands beside the text's end
    end = length - (0.5 + foot) * em  # from the first's middle
    away = 0.0
    paper = _Paper(mesh)
    if below is not None:
        size = min(size, below)
        start = (len(last) - 1) * pitch + (0.5 + _BELOW) * em
        lowest = length - (0.5 + _BARE) * em
        end = min(lowest, max(start + whole * size, 0.7 * end))
    else:
        inked = (0.5 - _BARE) * em
        free = paper.free_length(first.origin + inked * aside, aside)
        within = free - (0.0 if sheet is None else sheet.margin_mm) + (_BARE * size if n else 0.0)
        size = min(size, free / 1.5)
        if n == 0:
            size *= min(1.0, max(within / (_ALONE_COLUMN * _SEAL * size), _LEAST_ALONE))
        for _ in range(_TRIALS):
            wide, apart = (size, _AWAY * size) if n else (_SEAL * size, _ALONE_AWAY * _SEAL * size)
            beside = max(min(apart, within - wide), 0.3 * (free - wide), 0.1 * size)
            away = inked + 0.5 * wide + min(apart, beside)
            away *= paper.splay(first.origin, end)
            at, down = paper.beside(first.origin, away, aside, onward)
            above, under = (
                paper.free_length(at, direction) - 0.4 * size for direction in (-down, down)
            )
            if whole * size <= above + under:
                break
            size = 0.98 * (above + under) / whole
        end = max(min(end, under), whole * size - above)
    size = max(size, _LEAST_SIGNATURE_MM)
    seal = max(_SEAL * size, _LEAST_SEAL_MM)
    written = n * (1.0 + _SIGNED_BETWEEN) * size
    at_seal = end - 0.5 * seal
    at_text = end - seal - _TO_SEAL * size - 0.5 * written

    at, down = paper.beside(first.origin, away, aside, onward)
    up = -down if order == "columns" else first.y_axis
    point, seal_point = at + at_text * down, at + at_seal * down
    return Signing(size, _SIGNED_BETWEEN, point, seal, seal_point, up)


def seal_below(signature: Sequence[EmSquare]) -> Signing:
    """Place a signature's seal below it."""
    last = signature[-1]
    frame, size = last.chart.frame, last.em_mm
    seal = max(_SEAL * size, _LEAST_SEAL_MM)
    below = (0.5 + _TO_SEAL) * size + 0.5 * seal
    middle = np.mean([square.chart.frame.origin for square in signature], axis=0)
    point = frame.origin - below * frame.y_axis
    return Signing(size, _SIGNED_BETWEEN, middle, seal, point, frame.y_axis)
