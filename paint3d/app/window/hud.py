"""The plate over the picture: the brush in use, its ink and how much of it is left."""

from __future__ import annotations

from PySide6 import QtCore, QtGui

from paint3d.app.model.frame import HeldInk
from paint3d.app.window.brush.brush_panel import plain_name
from paint3d.app.window.ink.ink_panel import ink_label
from paint3d.app.window.wording import say, say_brush, say_length
from paint3d.app.window.workspace import Workspace

__all__ = ["PLATE_ALPHA", "Hud"]

PLATE_ALPHA = 242
"""Opacity of the plate, of 255: its text is readable over paper and over ink."""

_PORCELAIN = "#f3f0ea"
_MARGIN, _HEIGHT, _LEAST_WIDTH = 14, 46, 236
_BESIDE = 52  # pixels from the plate's edge to its text
_LEVELS = 56  # distinct heights of the ink in the dish: half pixels


class Hud:
    """A small plate in the lower left corner of the canvas."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._painted: tuple[object, ...] = ()
        self._plate = QtCore.QRectF()
        workspace.canvas.overlays.append(self.paint)

    def paint(self, painter: QtGui.QPainter, area: QtCore.QRect) -> None:
        """Draw the plate."""
        workspace = self._workspace
        if workspace.stage.paint_thread is None:
            return
        clip = painter.clipBoundingRect()
        if self._plate.isValid() and not (clip.isEmpty() or clip.intersects(self._plate)):
            return
        theme, held = workspace.theme, workspace.painting.held
        name, message = self._words(held)
        self._painted = _looks(name, message, held)
        wide = max(painter.fontMetrics().horizontalAdvance(text) for text in (name, message))
        width = min(max(_LEAST_WIDTH, wide + _BESIDE + 14), area.width() - 2 * _MARGIN)
        plate = QtCore.QRectF(
            area.left() + _MARGIN, area.bottom() - _MARGIN - _HEIGHT, width, _HEIGHT
        )
        self._plate = plate.adjusted(-1, -1, 1, 1)
        back = QtGui.QColor(theme.panel)
        back.setAlpha(PLATE_ALPHA)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(back)
        painter.drawRoundedRect(plate, 10, 10)
        self._paint_drop(painter, plate, held)
        painter.setPen(QtGui.QColor(theme.text))
        text = plate.adjusted(_BESIDE, 5, -8, -_HEIGHT / 2)
        left = QtCore.Qt.AlignmentFlag.AlignLeft | QtCore.Qt.AlignmentFlag.AlignVCenter
        painter.drawText(text, left, name)
        painter.setPen(QtGui.QColor(theme.faint))
        below = plate.adjusted(_BESIDE, _HEIGHT / 2 - 2, -8, -4)
        right = QtCore.Qt.TextElideMode.ElideRight
        message = painter.fontMetrics().elidedText(message, right, round(below.width()))
        painter.drawText(below, left, message)

    def _words(self, held: HeldInk) -> tuple[str, str]:
        """Return the plate's two lines."""
        brush = self._workspace.paint_thread.brush
        name = f"{say_brush(plain_name(brush))}  ·  {say_length(brush.length_mm)}"
        return name, self.describe(held)

    def follow(self) -> None:
        """Draw the plate again if brush or ink differ from those it shows."""
        if self._workspace.stage.paint_thread is None:
            return
        held = self._workspace.painting.held
        if _looks(*self._words(held), held) != self._painted:
            self.refresh()

    def refresh(self) -> None:
        """Draw the plate again, over the same picture."""
        canvas, high = self._workspace.canvas, _HEIGHT + 2 * _MARGIN
        self._plate = QtCore.QRectF()
        canvas.update(0, canvas.height() - high, canvas.width(), high)

    def describe(self, held: HeldInk) -> str:
        """Format the inks in the brush and how much is left, or that it erases."""
        if self._workspace.hand.erases:
            return say("Eraser: E puts ink on again")
        ink = say("ink {share:.0f} %", share=100 * held.fraction)
        if not held.parts:
            return ink
        if len(held.parts) == 1:
            return f"{ink}  ·  {ink_label(held.parts[0][0])}"
        inks = " + ".join(f"{ink_label(ink)} {100 * part:.0f} %" for ink, part in held.parts)
        return f"{ink}  ·  {inks}"

    def _paint_drop(self, painter: QtGui.QPainter, plate: QtCore.QRectF, held: HeldInk) -> None:
        """Draw a dish with as much ink in it as the brush has, the tip's lowest."""
        theme = self._workspace.theme
        box = QtCore.QRectF(plate.left() + 9, plate.top() + 7, 32, 32)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.faint), 1.4))
        painter.setBrush(QtGui.QColor(_PORCELAIN))
        painter.drawEllipse(box)
        if not held.bands:
            return
        clip = QtGui.QPainterPath()
        clip.addEllipse(box.adjusted(2, 2, -2, -2))
        painter.save()
        painter.setClipPath(clip)
        step = (box.height() - 4) * _level(held) / len(held.bands)
        for k, colour in enumerate(held.bands):
            top = box.bottom() - 2 - (k + 1) * step
            band = QtCore.QRectF(box.left(), top, box.width(), step + 0.5)
            painter.fillRect(band, QtGui.QColor(*colour))
        painter.restore()


def _looks(name: str, message: str, held: HeldInk) -> tuple[object, ...]:
    """Return everything that the plate's picture depends on."""
    return name, message, held.bands, _level(held)


def _level(held: HeldInk) -> float:
    """Return the height of the ink in the dish, 0 to 1."""
    return round(_LEVELS * held.fraction) / _LEVELS
