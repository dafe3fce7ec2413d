"""Strokes over the picture that they were found in: coloured, numbered, with their direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui

from paint3d.app.window.dialogs.picture_view import PictureView, image_of, length_of
from paint3d.app.window.theme import Theme
from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.page.page import Page, bounds_of
from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.copying import SheetPicture

__all__ = ["Behind", "ShownStroke", "StrokeView", "Taken"]

_FIRST = 0.56  # hue of the stroke that is chosen at first: far from the theme's, of rims
_TURN = 0.381966  # of the circle of hues, from one stroke to the next: no two near ones are alike
_PAPER, _INK = "#f6f3ec", "#b9b3a8"
_MARGIN = 0.06  # of a page without a picture
_PIXELS = 1000.0  # of such a page's longer side
_BADGE = 9.0
_CHOSEN_BADGE = 11.0


@dataclass(frozen=True)
class ShownStroke:
    """A stroke of a page, its number in its piece, and whether it is left out."""

    stroke: GlyphStroke
    number: int
    is_left_out: bool


@dataclass(frozen=True, eq=False)
class Behind:
    """What lies behind the strokes; see `FlatPage` for how units become pixels.

    Attributes
    ----------
    size : (float, float)
        Pixels.
    per_unit : float
    origin : (2,) float64
    ink : tuple of GlyphStroke
        On the page as it was, glyph units.
    image : QImage, optional
        The sheet; a page that is no photograph shows its ink instead.
    """

    size: tuple[float, float]
    per_unit: float
    origin: NDArray[np.float64]
    ink: tuple[GlyphStroke, ...]
    image: QtGui.QImage | None = None

    @classmethod
    def of_sheet(cls, sheet: SheetPicture, strokes: Sequence[GlyphStroke]) -> Behind:
        """A sheet laid flat."""
        image = image_of(sheet.picture)
        size = float(image.width()), float(image.height())
        return cls(size, sheet.per_unit, sheet.origin, tuple(strokes), image)

    @classmethod
    def of_page(cls, page: Page, strokes: Sequence[GlyphStroke]) -> Behind:
        """A page without a picture, and what of its strokes stands out of it."""
        low = [tuple(stroke.outline.min(axis=0)) for stroke in strokes]
        high = [tuple(stroke.outline.max(axis=0)) for stroke in strokes]
        around = [(*a, *b) for a, b in zip(low, high, strict=True)]
        left, lower, right, upper = bounds_of([page.bounds, *around])
        width, height = max(right - left, 1.0), max(upper - lower, 1.0)
        per_unit = _PIXELS / max(width, height)
        margin = _MARGIN * _PIXELS
        origin = np.array([margin - per_unit * left, margin + per_unit * upper])
        size = per_unit * width + 2.0 * margin, per_unit * height + 2.0 * margin
        return cls(size, per_unit, origin, tuple(strokes))

    def pixels(self, points: AnyArray) -> NDArray[np.float64]:
        """Places of the page (N, 2) as pixels."""
        there: NDArray[np.float64] = (
            self.per_unit * np.asarray(points) * np.array([1.0, -1.0]) + self.origin
        )
        return there

    def around_ink(self) -> QtCore.QRectF:
        """The part that the ink is in, with some room."""
        whole = QtCore.QRectF(0.0, 0.0, *self.size)
        if not self.ink:
            return whole
        points = self.pixels(np.concatenate([stroke.outline for stroke in self.ink]))
        low, high = points.min(axis=0), points.max(axis=0)
        room = _MARGIN * max(self.size)
        area = QtCore.QRectF(QtCore.QPointF(*low), QtCore.QPointF(*high))
        return area.adjusted(-room, -room, room, room).intersected(whole)

    def units(self, x: float, y: float) -> NDArray[np.float64]:
        """A pixel as a place of the page (2,)."""
        there: NDArray[np.float64] = (np.array([x, -y]) - self.origin * (1.0, -1.0)) / self.per_unit
        return there


class StrokeView(PictureView):
    """Draws strokes over what lies behind them.

    Attributes
    ----------
    behind : Behind
    chosen : int or None
        Which stroke is chosen.
    other : int or None
        Which one it is to be joined to.
    cut : (2,) float64 or None
        Where it is to be split, glyph units of the page.
    """

    def __init__(self, theme: Theme, behind: Behind) -> None:
        super().__init__(theme)
        self.behind = behind
        self.chosen: int | None = None
        self.other: int | None = None
        self.cut: NDArray[np.float64] | None = None
        self._strokes: tuple[ShownStroke, ...] = ()
        self._paths: list[QtGui.QPainterPath] = []
        self._ink: list[QtGui.QPainterPath] = []
        self.show_behind(behind)

    def show_behind(self, behind: Behind) -> None:
        """Lay other strokes over another picture; they are shown next."""
        self.behind = behind
        self._ink = [self._path(stroke) for stroke in behind.ink]
        self._strokes, self._paths = (), []
        self.show_area(behind.around_ink())

    def show_strokes(self, strokes: Sequence[ShownStroke]) -> None:
        """Show other strokes."""
        self._strokes = tuple(strokes)
        self._paths = [self._path(one.stroke) for one in strokes]
        self.update()

    def colour(self, k: int) -> QtGui.QColor:
        """Of stroke k, over ink as over paper."""
        return QtGui.QColor.fromHsvF((_FIRST + k * _TURN) % 1.0, 0.85, 0.82)

    def _path(self, stroke: GlyphStroke) -> QtGui.QPainterPath:
        path = QtGui.QPainterPath()
        path.setFillRule(QtCore.Qt.FillRule.OddEvenFill)
        for ring in (stroke.outline, *stroke.holes):
            path.addPolygon(_polygon(self.behind.pixels(ring)))
            path.closeSubpath()
        return path

    # -- drawing ----------------------------------------------------------------------------

    def draw(self, painter: QtGui.QPainter) -> None:
        """Draw the picture and the strokes' regions."""
        whole = QtCore.QRectF(0.0, 0.0, *self.behind.size)
        if self.behind.image is None:
            painter.fillRect(whole, QtGui.QColor(_PAPER))
            for path in self._ink:
                painter.fillPath(path, QtGui.QColor(_INK))
        else:
            painter.drawImage(whole, self.behind.image)
        for k, path in enumerate(self._paths):
            self._draw_region(painter, k, path)
        for marked in (self.other, self.chosen):
            if marked is not None and marked < len(self._paths):
                self._draw_rim(painter, self._paths[marked], is_other=marked == self.other)

    def _draw_region(self, painter: QtGui.QPainter, k: int, path: QtGui.QPainterPath) -> None:
        colour = self.colour(k)
        if self._strokes[k].is_left_out:
            faint = QtGui.QColor("#808080")
            painter.fillPath(path, QtGui.QBrush(faint, QtCore.Qt.BrushStyle.BDiagPattern))
            painter.strokePath(path, _pen(faint, 1.2, QtCore.Qt.PenStyle.DashLine))
            return
        fill = QtGui.QColor(colour)
        fill.setAlphaF(0.62 if k == self.chosen else 0.42)
        painter.fillPath(path, fill)
        painter.strokePath(path, _pen(colour, 1.4))

    def _draw_rim(
        self, painter: QtGui.QPainter, path: QtGui.QPainterPath, *, is_other: bool
    ) -> None:
        style = QtCore.Qt.PenStyle.DashLine if is_other else QtCore.Qt.PenStyle.SolidLine
        painter.strokePath(path, _pen(QtGui.QColor("#ffffff"), 5.0))
        painter.strokePath(path, _pen(QtGui.QColor(self.theme.accent), 2.6, style))

    def draw_marks(self, painter: QtGui.QPainter) -> None:
        """Draw lines with their direction, numbers where they begin, and the cut."""
        order = [k for k in range(len(self._strokes)) if k != self.chosen]
        if self.chosen is not None and self.chosen < len(self._strokes):
            order.append(self.chosen)  # above the others
        shown = [k for k in order if not self._strokes[k].is_left_out]
        lines = {k: self._line(k) for k in shown}
        for k in shown:
            self._draw_way(painter, k, lines[k])
        taken = Taken()
        for k in shown[::-1]:  # the chosen one has its number where it begins
            place = _free(lines[k], taken)
            taken.add(place)
            self._draw_number(painter, k, place)
        if self.cut is not None and self.chosen is not None:
            self._draw_cut(painter, self.cut, self._strokes[self.chosen].stroke)

    def _line(self, k: int) -> list[QtCore.QPointF]:
        start = self.place(0.0, 0.0)
        points = self.scale * self.behind.pixels(self._strokes[k].stroke.median)
        points += start.x(), start.y()
        return [QtCore.QPointF(x, y) for x, y in points.tolist()]

    def _draw_way(self, painter: QtGui.QPainter, k: int, line: Sequence[QtCore.QPointF]) -> None:
        dark = self.colour(k).darker(150)
        wide = 2.4 if k == self.chosen else 1.6
        for pen in (_pen(QtGui.QColor(255, 255, 255, 210), wide + 2.2), _pen(dark, wide)):
            painter.setPen(pen)
            painter.drawPolyline(line)
        length = sum(length_of(b - a) for a, b in pairwise(line))
        size = min(4.5 + 1.2 * wide, 0.4 * length)
        painter.setPen(_pen(QtGui.QColor("#ffffff"), 1.0))
        painter.setBrush(dark)
        places = (1.0,) if length < 60.0 else (0.5, 1.0)
        for share in places:
            painter.drawPolygon(_arrow(line, share * length, size))

    def _draw_number(self, painter: QtGui.QPainter, k: int, start: QtCore.QPointF) -> None:
        is_chosen = k == self.chosen
        radius = _CHOSEN_BADGE if is_chosen else _BADGE
        text = str(self._strokes[k].number)
        painter.setBrush(
            QtGui.QColor(self.theme.accent) if is_chosen else self.colour(k).darker(150)
        )
        painter.setPen(_pen(QtGui.QColor("#ffffff"), 2.0 if is_chosen else 1.2))
        wide = radius + 3.0 * (len(text) - 1)
        painter.drawRoundedRect(
            QtCore.QRectF(start.x() - wide, start.y() - radius, 2.0 * wide, 2.0 * radius),
            radius,
            radius,
        )
        painter.setPen(QtGui.QColor("#ffffff"))
        box = QtCore.QRectF(start.x() - 30.0, start.y() - 10.0, 60.0, 20.0)
        painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignCenter, text)

    def _draw_cut(
        self, painter: QtGui.QPainter, cut: NDArray[np.float64], stroke: GlyphStroke
    ) -> None:
        """A bar across the stroke's line."""
        near = int(np.argmin(np.linalg.norm(stroke.median - cut, axis=1)))
        low, high = max(near - 1, 0), min(near + 1, len(stroke.median) - 1)
        way = stroke.median[high] - stroke.median[low]
        across = np.array([way[1], way[0]]) / max(float(np.linalg.norm(way)), 1e-9)  # y turned
        middle = self.place(*self.behind.pixels(cut[None])[0])
        reach = QtCore.QPointF(*across) * 26.0
        for colour, wide in (("#ffffff", 6.0), (self.theme.accent, 3.0)):
            painter.setPen(_pen(QtGui.QColor(colour), wide))
            painter.drawLine(middle - reach, middle + reach)


def _polygon(points: AnyArray) -> QtGui.QPolygonF:
    return QtGui.QPolygonF([QtCore.QPointF(x, y) for x, y in points.tolist()])


def _pen(
    colour: QtGui.QColor,
    width: float,
    style: QtCore.Qt.PenStyle = QtCore.Qt.PenStyle.SolidLine,
) -> QtGui.QPen:
    """Of so many pixels of the widget, whatever the zoom."""
    pen = QtGui.QPen(colour, width, style)
    pen.setCosmetic(True)
    pen.setJoinStyle(QtCore.Qt.PenJoinStyle.RoundJoin)
    return pen


class Taken:
    """Places of numbers, by cells as wide as one: of many strokes only near ones are looked at."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, int], list[QtCore.QPointF]] = {}

    def add(self, place: QtCore.QPointF) -> None:
        """Have a number there."""
        self._cells.setdefault(self._cell(place), []).append(place)

    def is_free(self, place: QtCore.QPointF) -> bool:
        """Whether no other number would be covered by one there."""
        x, y = self._cell(place)
        near = ((x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1))
        return all(
            length_of(place - other) > 2.0 * _BADGE
            for cell in near
            for other in self._cells.get(cell, ())
        )

    def _cell(self, place: QtCore.QPointF) -> tuple[int, int]:
        return int(place.x() // (2.0 * _BADGE)), int(place.y() // (2.0 * _BADGE))


def _free(line: Sequence[QtCore.QPointF], taken: Taken) -> QtCore.QPointF:
    """Where a number goes: at a line's start, or farther along it where no other one is."""
    length = sum(length_of(b - a) for a, b in pairwise(line))
    for share in (0.0, 0.12, 0.24, 0.36, 0.5):
        place = _along(line, share * length)
        if taken.is_free(place):
            return place
    return line[0]


def _along(line: Sequence[QtCore.QPointF], way: float) -> QtCore.QPointF:
    """The place so far along a line."""
    for a, b in pairwise(line):
        step = length_of(b - a)
        if step > 0.0 and (way <= step or b is line[-1]):
            break
        way -= step
    step = max(length_of(b - a), 1e-9)
    return a + (b - a) / step * min(way, step)


def _arrow(line: Sequence[QtCore.QPointF], way: float, size: float) -> QtGui.QPolygonF:
    """A triangle whose tip lies so far along a line, and points as this leads over its length."""
    tip = _along(line, way)
    there = tip - _along(line, max(way - 2.0 * size, 0.0))
    there /= max(length_of(there), 1e-9)
    side = QtCore.QPointF(-there.y(), there.x())
    foot = tip - there * (2.0 * size)
    return QtGui.QPolygonF([tip, foot + side * size, foot - side * size])
