"""Strokes over the picture: looked at and corrected before they are written after or painted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.copybook.picture_view import PictureView, image_of, length_of
from paint3d.app.window.files.target_dialog import FileKind, ask_target
from paint3d.app.window.forms import buttons
from paint3d.app.window.job import run_beside
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error
from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.page.correcting import CorrectedPage
from paint3d.calligraphy.page.page import Page, bounds_of
from paint3d.calligraphy.page.strokes_file import save_strokes
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length, points_at
from paint3d.errors import Message, Paint3DError

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.copying import SheetPicture

__all__ = [
    "Behind",
    "CornerView",
    "CorrectionState",
    "CorrectionSteps",
    "LabelGrid",
    "Photographed",
    "ShownStroke",
    "StrokeView",
    "StrokesDialog",
]

# ---- Strokes over their picture ------------------------------------------------------------------
# Strokes over the picture that they were read from: coloured, numbered, with their direction.


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
    """Background of the strokes; see `FlatPage` for how units become pixels.

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
        """Return the background of a sheet laid flat."""
        image = image_of(sheet.picture)
        size = float(image.width()), float(image.height())
        return cls(size, sheet.per_unit, sheet.origin, tuple(strokes), image)

    @classmethod
    def of_page(cls, page: Page, strokes: Sequence[GlyphStroke]) -> Behind:
        """Return the background of a page without a picture, large enough for its strokes."""
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
        """Return points of the page (N, 2) as pixels."""
        there: NDArray[np.float64] = (
            self.per_unit * np.asarray(points) * np.array([1.0, -1.0]) + self.origin
        )
        return there

    def around_ink(self) -> QtCore.QRectF:
        """Return the part that the ink is in, with a margin."""
        whole = QtCore.QRectF(0.0, 0.0, *self.size)
        if not self.ink:
            return whole
        points = self.pixels(np.concatenate([stroke.outline for stroke in self.ink]))
        low, high = points.min(axis=0), points.max(axis=0)
        margin = _MARGIN * max(self.size)
        area = QtCore.QRectF(QtCore.QPointF(*low), QtCore.QPointF(*high))
        return area.adjusted(-margin, -margin, margin, margin).intersected(whole)

    def units(self, x: float, y: float) -> NDArray[np.float64]:
        """Return a pixel as a point of the page (2,)."""
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
        """Return the colour of stroke k, which is seen over ink and over paper."""
        return QtGui.QColor.fromHsvF((_FIRST + k * _TURN) % 1.0, 0.85, 0.82)

    def _path(self, stroke: GlyphStroke) -> QtGui.QPainterPath:
        path = QtGui.QPainterPath()
        path.setFillRule(QtCore.Qt.FillRule.OddEvenFill)
        for ring in (stroke.outline, *stroke.holes):
            points = self.behind.pixels(ring).tolist()
            path.addPolygon(QtGui.QPolygonF([QtCore.QPointF(x, y) for x, y in points]))
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
                style = QtCore.Qt.PenStyle
                line = style.DashLine if marked == self.other else style.SolidLine
                painter.strokePath(self._paths[marked], _pen(QtGui.QColor("#ffffff"), 5.0))
                accent = QtGui.QColor(self.theme.accent)
                painter.strokePath(self._paths[marked], _pen(accent, 2.6, line))

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

    def draw_marks(self, painter: QtGui.QPainter) -> None:
        """Draw lines with their direction, numbers where they begin, and the cut."""
        order = [k for k in range(len(self._strokes)) if k != self.chosen]
        if self.chosen is not None and self.chosen < len(self._strokes):
            order.append(self.chosen)  # above the others
        shown = [k for k in order if not self._strokes[k].is_left_out]
        lines = {k: self._line(k) for k in shown}
        for k in shown:
            self._draw_median(painter, k, lines[k])
        taken = LabelGrid()
        for k in shown[::-1]:  # the chosen one has its number where it begins
            position = _label_position(lines[k], taken)
            taken.add(position)
            self._draw_number(painter, k, position)
        if self.cut is not None and self.chosen is not None:
            self._draw_cut(painter, self.cut, self._strokes[self.chosen].stroke)

    def _line(self, k: int) -> list[QtCore.QPointF]:
        start = self.place(0.0, 0.0)
        points = self.scale * self.behind.pixels(self._strokes[k].stroke.median)
        points += start.x(), start.y()
        return [QtCore.QPointF(x, y) for x, y in points.tolist()]

    def _draw_median(self, painter: QtGui.QPainter, k: int, line: Sequence[QtCore.QPointF]) -> None:
        dark = self.colour(k).darker(150)
        wide = 2.4 if k == self.chosen else 1.6
        for pen in (_pen(QtGui.QColor(255, 255, 255, 210), wide + 2.2), _pen(dark, wide)):
            painter.setPen(pen)
            painter.drawPolyline(line)
        length = sum(length_of(b - a) for a, b in pairwise(line))
        size = min(4.5 + 1.2 * wide, 0.4 * length)
        painter.setPen(_pen(QtGui.QColor("#ffffff"), 1.0))
        painter.setBrush(dark)
        arrows = (1.0,) if length < 60.0 else (0.5, 1.0)
        for fraction in arrows:
            painter.drawPolygon(_arrow(line, fraction * length, size))

    def _draw_number(self, painter: QtGui.QPainter, k: int, middle: QtCore.QPointF) -> None:
        is_chosen = k == self.chosen
        radius = _CHOSEN_BADGE if is_chosen else _BADGE
        text = str(self._strokes[k].number)
        painter.setBrush(
            QtGui.QColor(self.theme.accent) if is_chosen else self.colour(k).darker(150)
        )
        painter.setPen(_pen(QtGui.QColor("#ffffff"), 2.0 if is_chosen else 1.2))
        wide = radius + 3.0 * (len(text) - 1)
        painter.drawRoundedRect(
            QtCore.QRectF(middle.x() - wide, middle.y() - radius, 2.0 * wide, 2.0 * radius),
            radius,
            radius,
        )
        painter.setPen(QtGui.QColor("#ffffff"))
        box = QtCore.QRectF(middle.x() - 30.0, middle.y() - 10.0, 60.0, 20.0)
        painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignCenter, text)

    def _draw_cut(
        self, painter: QtGui.QPainter, cut: NDArray[np.float64], stroke: GlyphStroke
    ) -> None:
        """Draw a bar across the stroke's line."""
        near = int(np.argmin(np.linalg.norm(stroke.median - cut, axis=1)))
        low, high = max(near - 1, 0), min(near + 1, len(stroke.median) - 1)
        direction = stroke.median[high] - stroke.median[low]
        # perpendicular to it in the widget, where y is down
        across = np.array([direction[1], direction[0]]) / max(
            float(np.linalg.norm(direction)), 1e-9
        )
        middle = self.place(*self.behind.pixels(cut[None])[0])
        reach = QtCore.QPointF(*across) * 26.0
        for colour, wide in (("#ffffff", 6.0), (self.theme.accent, 3.0)):
            painter.setPen(_pen(QtGui.QColor(colour), wide))
            painter.drawLine(middle - reach, middle + reach)


def _pen(
    colour: QtGui.QColor,
    width: float,
    style: QtCore.Qt.PenStyle = QtCore.Qt.PenStyle.SolidLine,
) -> QtGui.QPen:
    """Return a pen whose width is in pixels of the widget, whatever the zoom."""
    pen = QtGui.QPen(colour, width, style)
    pen.setCosmetic(True)
    pen.setJoinStyle(QtCore.Qt.PenJoinStyle.RoundJoin)
    return pen


class LabelGrid:
    """Positions of numbers, in cells as wide as one number, so that only near ones are compared."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, int], list[QtCore.QPointF]] = {}

    def add(self, position: QtCore.QPointF) -> None:
        """Add a number."""
        self._cells.setdefault(self._cell(position), []).append(position)

    def is_free(self, position: QtCore.QPointF) -> bool:
        """Return whether no other number would be covered by one there."""
        x, y = self._cell(position)
        near = ((x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1))
        return all(
            length_of(position - other) > 2.0 * _BADGE
            for cell in near
            for other in self._cells.get(cell, ())
        )

    def _cell(self, position: QtCore.QPointF) -> tuple[int, int]:
        return int(position.x() // (2.0 * _BADGE)), int(position.y() // (2.0 * _BADGE))


def _label_position(line: Sequence[QtCore.QPointF], grid: LabelGrid) -> QtCore.QPointF:
    """Return a number's position: a line's start, or a free point farther along it."""
    length = sum(length_of(b - a) for a, b in pairwise(line))
    for fraction in (0.0, 0.12, 0.24, 0.36, 0.5):
        position = _point_along(line, fraction * length)
        if grid.is_free(position):
            return position
    return line[0]


def _point_along(line: Sequence[QtCore.QPointF], distance: float) -> QtCore.QPointF:
    """Return the point at a distance along a line."""
    for a, b in pairwise(line):
        step = length_of(b - a)
        if step > 0.0 and (distance <= step or b is line[-1]):
            break
        distance -= step
    step = max(length_of(b - a), 1e-9)
    return a + (b - a) / step * min(distance, step)


def _arrow(line: Sequence[QtCore.QPointF], distance: float, size: float) -> QtGui.QPolygonF:
    """Return a triangle with its tip at a distance along a line, turned along the line."""
    tip = _point_along(line, distance)
    there = tip - _point_along(line, max(distance - 2.0 * size, 0.0))
    there /= max(length_of(there), 1e-9)
    side = QtCore.QPointF(-there.y(), there.x())
    foot = tip - there * (2.0 * size)
    return QtGui.QPolygonF([tip, foot + side * size, foot - side * size])


# ---- Corners of the sheet ------------------------------------------------------------------------
# The corners of a sheet over its photograph, to be dragged.


_GRIP, _NEAR = 8.0, 26.0
_CORNER_STEPS = {
    QtCore.Qt.Key.Key_Left: (-1, 0), QtCore.Qt.Key.Key_Right: (1, 0),
    QtCore.Qt.Key.Key_Up: (0, -1), QtCore.Qt.Key.Key_Down: (0, 1),
}  # fmt: skip
_FAR = 10  # pixels that Shift goes at once


class CornerView(PictureView):
    """Four corners, dragged by pen, mouse or finger; arrows move the chosen one, 1 to 4 choose.

    Parameters
    ----------
    theme : Theme
    pixels : (H, W, 3) uint8
        The photograph.
    """

    def __init__(self, theme: Theme, pixels: NDArray[np.uint8]) -> None:
        super().__init__(theme)
        self._image = image_of(pixels)
        self.corners = np.zeros((4, 2))
        self._chosen = 0
        self.show_area(QtCore.QRectF(self._image.rect()))

    def show_corners(self, corners: NDArray[np.float64]) -> None:
        """Show other corners (4, 2), pixels."""
        self.corners = np.array(corners, np.float64)
        self.update()

    def take_hold(self, place: QtCore.QPointF) -> bool:
        """Choose the corner there; return whether there is one."""
        distances = [length_of(self.place(*corner) - place) for corner in self.corners]
        nearest = int(np.argmin(distances))
        if distances[nearest] > _NEAR:
            return False
        self._chosen = nearest
        self.update()
        return True

    def drag_to(self, place: QtCore.QPointF) -> None:
        """Move the chosen corner there, but not off the picture."""
        self._put(np.array(self.pixel(place)))

    def _put(self, pixel: NDArray[np.float64]) -> None:
        most = self._image.width(), self._image.height()
        self.corners[self._chosen] = np.clip(pixel, 0.0, most)
        self.update()

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Choose a corner by its number, or move the chosen one by a pixel, with Shift by ten."""
        key = QtCore.Qt.Key(event.key())
        if key in _CORNER_STEPS:
            far = bool(event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier)
            self._put(
                self.corners[self._chosen] + np.array(_CORNER_STEPS[key]) * (_FAR if far else 1)
            )
        elif event.text() in ("1", "2", "3", "4"):
            self._chosen = int(event.text()) - 1
            self.update()
        else:
            super().keyPressEvent(event)

    def draw(self, painter: QtGui.QPainter) -> None:
        """Draw the photograph."""
        painter.drawImage(0, 0, self._image)

    def draw_marks(self, painter: QtGui.QPainter) -> None:
        """Draw the sheet's sides and corners."""
        points = [self.place(*corner) for corner in self.corners]
        line = QtGui.QPolygonF(points)
        for colour, width in (("#ffffff", 4.0), (self.theme.accent, 2.0)):
            painter.setPen(QtGui.QPen(QtGui.QColor(colour), width))
            painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
            painter.drawPolygon(line)
        for k, place in enumerate(points):
            is_chosen = k == self._chosen
            painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 2.0))
            painter.setBrush(QtGui.QColor(self.theme.accent if is_chosen else "#ffffff"))
            painter.drawEllipse(place, _GRIP + 3.0 * is_chosen, _GRIP + 3.0 * is_chosen)
            painter.setPen(QtGui.QColor("#ffffff" if is_chosen else "#2a2825"))
            box = QtCore.QRectF(place.x() - 10.0, place.y() - 10.0, 20.0, 20.0)
            painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignCenter, str(k + 1))


# ---- The dialog ----------------------------------------------------------------------------------


_REACH = 14.0  # pixels of the widget that a click may miss a stroke by
_STEPS = 24  # along a stroke, that the keys move a cut by
_KEY = QtCore.Qt.Key
_REDO = QtCore.QKeyCombination(QtCore.Qt.KeyboardModifier.ControlModifier, _KEY.Key_Y)
_SUFFIX = ".strokes.json"


class Photographed(NamedTuple):
    """A photograph that strokes are from.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
    sheet : SheetPicture
        The sheet read from it.
    find : callable
        Reads the strokes again from a sheet of other corners (4, 2).
    """

    pixels: NDArray[np.uint8]
    sheet: SheetPicture
    find: Callable[[NDArray[np.float64]], SheetPicture]


class CorrectionState(NamedTuple):
    """A state to undo to: the strokes, and the sheet that they lie on."""

    strokes: CorrectedPage
    sheet: SheetPicture | None


class CorrectionSteps:
    """Corrections one after another, of which the last ones can be undone and done again.

    Parameters
    ----------
    first : CorrectionState
    """

    def __init__(self, first: CorrectionState) -> None:
        self._states, self._at = [first], 0

    @property
    def now(self) -> CorrectionState:
        """The current state."""
        return self._states[self._at]

    @property
    def first(self) -> CorrectionState:
        """The first state."""
        return self._states[0]

    @property
    def can_undo(self) -> bool:
        """True if there is a state before."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """True if something was undone."""
        return self._at + 1 < len(self._states)

    def take(self, state: CorrectionState) -> None:
        """Go on to another state; what was undone is forgotten."""
        self._states[self._at + 1 :] = [state]
        self._at += 1

    def undo(self) -> None:
        """Go back by one, where there is one."""
        self._at -= self.can_undo

    def redo(self) -> None:
        """Go forth by one, where there is one."""
        self._at += self.can_redo


class StrokesDialog(QtWidgets.QDialog):
    """Correct the strokes of a page.

    Parameters
    ----------
    parent : QWidget
    theme : Theme
    page : Page
    photographed : Photographed, optional
        Where the page is a photograph's.
    beside : Path
        The file that was opened: what is saved is proposed beside it.
    steps : CorrectionSteps, optional
        Corrections of before, to go on with.

    Attributes
    ----------
    view : StrokeView
    corners : CornerView or None
    steps : CorrectionSteps
        What was corrected, to be undone.
    buttons : dict of str to QAbstractButton
        By their names in `_BUTTONS`.
    message_label : QLabel
        What is chosen, and what is expected next.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        theme: Theme,
        page: Page,
        photographed: Photographed | None = None,
        beside: Path | None = None,
        steps: CorrectionSteps | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Strokes over the picture…").rstrip("…"))
        self._theme, self._photo = theme, photographed
        self._beside = beside or Path.cwd() / "strokes"
        sheet = photographed.sheet if photographed is not None else None
        self.steps = steps or CorrectionSteps(CorrectionState(CorrectedPage.of(page), sheet))
        self._saved = self.steps.first
        self._chosen: int | None = 0 if self._now.strokes else None
        self._mode = "choose"
        self._cut_at = 0.5
        self.view = StrokeView(theme, self._behind())
        self.view.setAccessibleName(self.windowTitle())
        self.view.clicked.connect(self._click)
        self.corners: CornerView | None = None
        self._views = QtWidgets.QStackedWidget()
        self._views.addWidget(self.view)
        if photographed is not None:
            self.corners = CornerView(theme, photographed.pixels)
            self._views.addWidget(self.corners)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setWordWrap(True)
        self.buttons: dict[str, QtWidgets.QAbstractButton] = {}
        self._lay_out()
        window = parent.window().size()
        self.resize(max(window.width() - 60, 760), max(window.height() - 60, 480))
        self.view.setFocus()
        self._show()

    # -- result -----------------------------------------------------------------------------

    @property
    def page(self) -> Page:
        """The page as it was corrected.

        Raises
        ------
        InputError
            If every stroke is left out.
        """
        return self._now.page()

    @property
    def is_changed(self) -> bool:
        """True if strokes or sheet were changed."""
        is_other = self._photo is not None and self.steps.now.sheet is not self._photo.sheet
        return is_other or self._now.is_changed

    @property
    def photographed(self) -> Photographed | None:
        """The photograph with the current sheet."""
        sheet = self.steps.now.sheet
        if self._photo is None or sheet is None:
            return None
        return self._photo._replace(sheet=sheet)

    @property
    def chosen(self) -> int | None:
        """Which stroke is chosen."""
        return self._chosen

    @property
    def _now(self) -> CorrectedPage:
        return self.steps.now.strokes

    def _behind(self) -> Behind:
        corrected, sheet = self.steps.now
        strokes = [one.stroke for one in corrected.strokes]
        if sheet is None:
            return Behind.of_page(corrected.base, strokes)
        return Behind.of_sheet(sheet, strokes)

    # -- layout -----------------------------------------------------------------------------

    def _lay_out(self) -> None:
        grid = QtWidgets.QGridLayout()
        grid.setSpacing(6)
        rows = (
            ("reverse", "leave out"), ("earlier", "later"), ("join", "split"), ("undo", "redo"),
        )  # fmt: skip
        for row, names in enumerate(rows):
            for column, name in enumerate(names):
                grid.addWidget(self._button(name), row, column)
        self.whole = QtWidgets.QCheckBox(f"{say('The whole piece')}  (W)")
        self.whole.setToolTip(say("Earlier, later and leave out take all strokes of its piece"))
        self.whole.setFocusPolicy(QtCore.Qt.FocusPolicy.TabFocus)
        self.whole.toggled.connect(lambda _: self._show())
        grid.addWidget(self.whole, len(rows), 0, 1, 2)
        side = QtWidgets.QVBoxLayout()
        side.addLayout(grid)
        if self.corners is not None:
            side.addWidget(self._button("corners"))
        side.addSpacing(6)
        side.addWidget(self.message_label)
        side.addStretch(1)
        side.addWidget(self._button("save"))
        box = buttons(self, say("Use"))
        self.use = box.button(QtWidgets.QDialogButtonBox.StandardButton.Ok)
        self.use.setToolTip(say("As ghosts on the object"))
        side.addWidget(box)
        panel = QtWidgets.QWidget()
        panel.setLayout(side)
        panel.setFixedWidth(276)
        side.setContentsMargins(0, 0, 0, 0)
        layout = QtWidgets.QHBoxLayout(self)
        layout.addWidget(self._views, 1)
        layout.addWidget(panel)

    def _button(self, name: str) -> QtWidgets.QPushButton:
        """Return a button that leaves the focus with the picture when it is clicked."""
        text, key, what, checkable = _BUTTONS[name]
        button = QtWidgets.QPushButton(f"{say(text)}  ({key})" if key else say(text))
        button.setToolTip(say(what))
        button.setAutoDefault(False)
        button.setCheckable(checkable)
        button.setFocusPolicy(QtCore.Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda _=False: self.do(name))
        self.buttons[name] = button
        return button

    # -- commands ---------------------------------------------------------------------------

    def do(self, name: str) -> None:
        """Do a button's command, by its name: see `_BUTTONS`."""
        if not self.buttons[name].isEnabled():
            return
        if name in ("join", "split", "corners"):
            self._enter("choose" if self._mode == name else name)
            return
        acts: dict[str, Callable[[], None]] = {
            "reverse": self._reverse, "leave out": self._leave_out, "undo": self._undo,
            "redo": self._redo, "save": self.save, "earlier": lambda: self._move(-1),
            "later": lambda: self._move(1),
        }  # fmt: skip
        acts[name]()

    def _take(self, strokes: CorrectedPage, chosen: int | None = None) -> None:
        """Take corrected strokes as the new state, and leave any other mode."""
        self.steps.take(self.steps.now._replace(strokes=strokes))
        if chosen is not None:
            self._chosen = chosen
        self._enter("choose")

    def _reverse(self) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        self._take(self._now.reverse(self._chosen))

    def _leave_out(self) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        on = not self._now.strokes[self._chosen].is_left_out
        do = self._now.leave_out_piece if self.whole.isChecked() else self._now.leave_out
        self._take(do(self._chosen, on))

    def _move(self, by: int) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        do = self._now.move_piece if self.whole.isChecked() else self._now.move
        moved, at = do(self._chosen, by)
        if moved.strokes != self._now.strokes:
            self._take(moved, at)

    def _undo(self) -> None:
        self._step(self.steps.undo)

    def _redo(self) -> None:
        self._step(self.steps.redo)

    def _step(self, do: Callable[[], None]) -> None:
        sheet = self.steps.now.sheet
        do()
        if self.steps.now.sheet is not sheet:
            self.view.show_behind(self._behind())
        n = len(self._now.strokes)
        self._chosen = min(self._chosen or 0, n - 1) if n else None
        self._enter("choose")

    # -- joining, splitting, corners --------------------------------------------------------

    def _enter(self, mode: str) -> None:
        """Enter a mode, which says what the next click does.

        Leaving corners that were dragged reads the strokes again; if that fails, the mode stays.
        """
        if self._mode == "corners" and mode != "corners" and not self._read_again():
            self._show()
            return
        self._mode = mode
        self._cut_at = 0.5
        self.view.other = None
        if mode == "join" and self._chosen is not None:
            self.view.other = (self._chosen + 1) % len(self._now.strokes)
        if mode == "corners" and self.corners is not None and self.steps.now.sheet is not None:
            self.corners.show_corners(self.steps.now.sheet.corners)
        shown = self.corners if mode == "corners" and self.corners is not None else self.view
        self._views.setCurrentWidget(shown)
        shown.setFocus()
        self._show()

    def _read_again(self) -> bool:
        """Read the strokes of the sheet with the dragged corners; return whether that succeeded."""
        sheet = self.steps.now.sheet
        if self.corners is None or self._photo is None or sheet is None:
            return True
        corners, find = self.corners.corners.copy(), self._photo.find
        if np.abs(corners - sheet.corners).max() < 0.01:
            return True
        done = run_beside(self, say("Finding the strokes…"), lambda _: find(corners))
        error = done.exception()
        if error is None:
            sheet_read: SheetPicture = done.result()
            self.steps.take(CorrectionState(CorrectedPage.of(sheet_read.page), sheet_read))
            self._chosen = 0 if self._now.strokes else None
            self.view.show_behind(self._behind())
        elif isinstance(error, Paint3DError):
            QtWidgets.QMessageBox.warning(self, "paint3d", say_error(error))
        elif not isinstance(error, CancelledError):
            raise error
        return error is None

    def _click(self, x: float, y: float) -> None:
        """Choose the stroke there, join it, or cut there."""
        point = self.view.behind.units(x, y)
        reach = _REACH / self.view.scale / self.view.behind.per_unit
        k = self._now.stroke_at(point, reach)
        if self._mode == "split":
            self._split(point)
        elif k is not None and self._mode == "join":
            self._join(k)
        elif k is not None:
            self._chosen = k
            self._show()

    def _confirm(self) -> None:
        """Join or cut what is shown."""
        if self._mode == "join" and self.view.other is not None:
            self._join(self.view.other)
        elif self._mode == "split" and self.view.cut is not None:
            self._split(self.view.cut)
        elif self._mode == "corners":
            self._enter("choose")

    def _join(self, other: int) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        try:
            joined, at = self._now.join(self._chosen, other)
        except Paint3DError as error:
            self.message_label.setText(say_error(error))
        else:
            self._take(joined, at)

    def _split(self, point: NDArray[np.float64]) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        try:
            parts = self._now.split(self._chosen, point)
        except Paint3DError as error:
            self.message_label.setText(say_error(error))
        else:
            self._take(parts)

    def _step_along(self, by: int) -> None:
        """Choose another stroke, or move the cut along."""
        n = len(self._now.strokes)
        if self._mode == "split":
            self._cut_at = min(max(self._cut_at + by / _STEPS, 1 / _STEPS), 1.0 - 1 / _STEPS)
        elif self._mode == "join" and self.view.other is not None:
            other = (self.view.other + by) % n
            self.view.other = (other + by) % n if other == self._chosen else other
        elif n:
            self._chosen = ((-1 if self._chosen is None else self._chosen) + by) % n
        self._show()

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Press a button by its key; arrows choose, Return confirms, Escape leaves a mode."""
        key, standard = _KEY(event.key()), QtGui.QKeySequence.StandardKey
        if event.matches(standard.Undo):
            self.do("undo")
        elif event.matches(standard.Redo) or event.keyCombination() == _REDO:
            self.do("redo")
        elif event.matches(standard.Save):
            self.do("save")
        elif self._mode != "choose" and key in (_KEY.Key_Return, _KEY.Key_Enter):
            self._confirm()
        elif self._mode != "choose" and key == _KEY.Key_Escape:
            self._leave()
        elif key in (_KEY.Key_Left, _KEY.Key_Right):
            self._step_along(1 if key == _KEY.Key_Right else -1)
        elif key == _KEY.Key_W:
            self.whole.click()
        elif key in _KEYS and _KEYS[key] in self.buttons and not _has_modifier(event):
            self.do(_KEYS[key])
        else:
            super().keyPressEvent(event)

    def _leave(self) -> None:
        """Leave the mode; corners stay as they were."""
        if self._mode == "corners" and self.corners is not None and self.steps.now.sheet:
            self.corners.show_corners(self.steps.now.sheet.corners)
        self._enter("choose")

    def save(self) -> None:
        """Ask where, and write the strokes as a file."""
        name = self._beside.name
        stem = name.removesuffix(_SUFFIX) if name.endswith(_SUFFIX) else self._beside.stem
        start = self._beside.with_name(f"{stem}{_SUFFIX}")
        path = ask_target(self, say("Save the strokes"), start, [FileKind(say("Strokes"), _SUFFIX)])
        if path is None:
            return
        try:
            save_strokes(self.page, path)
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self, "paint3d", say_error(error))
        else:
            self._beside, self._saved = path, self.steps.now
            self.message_label.setText(say("Exported {name}", name=path.name))

    def reject(self) -> None:
        """Close it; ask first if corrections are not in a file."""
        if self.steps.now is not self._saved:
            message = say("The corrections are not used and not saved")
            if (
                ask(self, message, destroy=say("Drop them"), warns=True)
                is not Answer.DestructiveRole
            ):
                return
        super().reject()

    # -- showing ----------------------------------------------------------------------------

    def _show(self) -> None:
        """Show the strokes, and which buttons can do something."""
        now, k = self._now, self._chosen
        self.view.show_strokes(
            [
                ShownStroke(one.stroke, number, one.is_left_out)
                for one, number in zip(now.strokes, now.numbers, strict=True)
            ]
        )
        self.view.chosen = k
        self.view.cut = None
        if self._mode == "split" and k is not None:
            line = now.strokes[k].stroke.median
            self.view.cut = points_at(line, self._cut_at * line_length(line))
        can = dict.fromkeys(self.buttons, self._mode != "corners" and k is not None)
        is_still = self._mode != "corners"
        can |= {
            "undo": self.steps.can_undo and is_still, "redo": self.steps.can_redo and is_still,
            "corners": True,
        }  # fmt: skip
        can["join"] &= len(now.strokes) > 1
        is_any = any(not one.is_left_out for one in now.strokes)
        can["save"] = is_any and is_still
        for name, button in self.buttons.items():
            button.setEnabled(can[name])
            if button.isCheckable():
                button.setChecked(self._mode == name)
        self.use.setEnabled(can["save"])
        self.whole.setEnabled(can["reverse"])
        is_out = k is not None and now.strokes[k].is_left_out
        key = _BUTTONS["leave out"][1]
        self.buttons["leave out"].setText(
            f"{say('Take in') if is_out else say('Leave out')}  ({key})"
        )
        self.message_label.setText(self._hint())
        self.view.update()

    def _hint(self) -> str:
        """Return what is chosen, and what to do next, as text."""
        k = self._chosen
        if k is None:
            return say("There are no strokes")
        if self._mode == "corners":
            return say(_HINTS[self._mode])
        number, count = self._now.number(k)
        message = say("{piece}: stroke {k} of {n}", piece=self._now.text(k), k=number, n=count)
        return f"{message}\n\n{say(_HINTS[self._mode])}"


_BUTTONS = {
    "reverse": (Message("Reverse"), "R", Message("Write the stroke the other way"), False),
    "leave out": (
        Message("Leave out"),
        "X",
        Message("It is no stroke, or is to be written again"),
        False,
    ),
    "earlier": (Message("Earlier"), "PgUp", Message("Write it before the one before"), False),
    "later": (Message("Later"), "PgDn", Message("Write it after the next one"), False),
    "join": (Message("Join"), "J", Message("Make one stroke of this and another"), True),
    "split": (Message("Split"), "S", Message("Make two strokes of this, at a place"), True),
    "undo": (Message("Undo"), "Ctrl+Z", Message("Take the last correction back"), False),
    "redo": (Message("Redo"), "Ctrl+Y", Message("Correct it again"), False),
    "corners": (
        Message("Corners of the sheet"),
        "C",
        Message("Drag them, and find the strokes anew"),
        True,
    ),
    "save": (
        Message("Save the strokes…"),
        "Ctrl+S",
        Message("As a file that can be written and corrected"),
        False,
    ),
}
"""Words, key, what it does, and whether it stays pressed."""

_KEYS = {
    _KEY.Key_R: "reverse", _KEY.Key_X: "leave out", _KEY.Key_PageUp: "earlier",
    _KEY.Key_PageDown: "later", _KEY.Key_J: "join", _KEY.Key_S: "split", _KEY.Key_C: "corners",
}  # fmt: skip

_HINTS = {
    "choose": Message("Click a stroke, or go through them by ← and →. Each begins at its number."),
    "join": Message("Click the stroke to join it to, or choose by ← and → and press Return."),
    "split": Message("Click where to split it, or move the cut by ← and → and press Return."),
    "corners": Message(
        "Drag the corners of the sheet, or move one by the arrows (1 to 4 choose it). "
        "Return finds the strokes anew, Esc leaves them."
    ),
}


def _has_modifier(event: QtGui.QKeyEvent) -> bool:
    """Return whether Ctrl, Alt or Meta is down."""
    modifier = QtCore.Qt.KeyboardModifier
    return bool(
        event.modifiers()
        & (modifier.ControlModifier | modifier.AltModifier | modifier.MetaModifier)
    )
